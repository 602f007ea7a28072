"""The command reproduce: the tables, figures and formulas of the paper, each with its verdict."""

from __future__ import annotations

import argparse
import sys
from contextlib import suppress

from painleve_sym.cli.options import output_folder
from painleve_sym.cli.output import print_json, show_table
from painleve_sym.papers import registry as study


def reproduce(arguments: argparse.Namespace) -> int:
    """Redo the items asked for; 0 only when every verdict is the expected one."""
    out = output_folder("--out", arguments.out) if arguments.out is not None else None
    if arguments.list:
        return _list(arguments.json)
    only = _only(arguments.only)
    if out is not None or not arguments.json:
        # Before computing: a library that is missing shall be missed at once.
        from painleve_sym.present.report import terminal_table, write_report
    found = study.reproduce(only=only, progress=_progress)
    if out is not None:
        write_report(found, out)
        _tell(f"report written to {out}")
    if arguments.json:
        print_json(found.to_dict())
    else:
        print(terminal_table(found).rstrip("\n"))
    return 0 if found.ok else 1


def _list(as_json: bool) -> int:
    if as_json:
        items = [{"id": e.id, "group": e.group, "title": e.title} for e in study.ENTRIES]
        print_json({"items": items})
        return 0
    show_table(
        ("id", "group", "title"),
        [(e.id, e.group, e.title) for e in study.ENTRIES],
        left=(0, 1, 2),
        indent=0,
    )
    return 0


def _only(texts: list[str] | None) -> list[str] | None:
    if texts is None:
        return None
    names = [name.strip() for name in ",".join(texts).split(",")]
    study.selected(names)
    return names


def _progress(number: int, total: int, title: str) -> None:
    _tell(f"[{number:{len(str(total))}}/{total}] {title}")


def _tell(text: str) -> None:
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)
