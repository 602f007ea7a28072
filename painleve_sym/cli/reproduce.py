"""The command reproduce: the tables, figures and formulas of a paper, each with its verdict."""

from __future__ import annotations

import argparse
import sys
from contextlib import suppress

from painleve_sym.cli.options import output_folder, read_look, read_names
from painleve_sym.cli.output import print_json, show_table
from painleve_sym.papers import registry


def reproduce(arguments: argparse.Namespace) -> int:
    """Compute the items asked for; 0 only when every verdict is the expected one."""
    out = output_folder("--out", arguments.out) if arguments.out is not None else None
    look = read_look(arguments)
    only = None if arguments.only is None else read_names("--only", ",".join(arguments.only))
    chosen = registry.selected(only, arguments.paper)
    if arguments.list:
        keys = ("id", "group", "title", "paper_name")
        claims = [(paper.name, name, paper.claims.items[name]) for paper, name in chosen]
        rows = [(name, claim.group, claim.title, paper) for paper, name, claim in claims]
        if arguments.json:
            print_json({"items": [dict(zip(keys, row, strict=True)) for row in rows]})
        else:
            show_table((*keys[:3], "paper"), rows, left=(0, 1, 2, 3), indent=0)
        return 0
    if out is not None or not arguments.json:
        # Imported before computing, so that a missing dependency fails first.
        from painleve_sym.present.report import terminal_table, write_report
    reproduction = registry.reproduce(only, paper=arguments.paper)
    if out is not None:
        from painleve_sym.present.style import Look

        write_report(reproduction, out, Look(**look))
        with suppress(OSError):
            print(f"report written to {out}", file=sys.stderr, flush=True)
    if arguments.json:
        print_json(reproduction.to_dict())
    else:
        print(terminal_table(reproduction).rstrip("\n"))
    return 0 if reproduction.ok else 1
