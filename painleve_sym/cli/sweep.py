"""The command sweep: one motion for every point of a grid or a sampled set."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from painleve_sym.cli.options import output_file, output_store
from painleve_sym.cli.output import number, print_json, quantity, show, show_table
from painleve_sym.cli.run import EXIT_DOUBTFUL
from painleve_sym.errors import InputError, StopReason
from painleve_sym.study.sweeps.runner import run_sweep
from painleve_sym.study.sweeps.store import SUFFIXES, SweepSummary, check_format, parts_folder
from painleve_sym.study.sweeps.sweep import Sweep


def sweep(arguments: argparse.Namespace) -> int:
    """Run or resume the sweep, write its result and print what it holds."""
    source = Path(arguments.file)
    threads = arguments.threads
    if threads and arguments.cluster is not None:
        raise InputError(
            "--threads: the workers of a cluster have one thread each. Fix: leave out --threads "
            "or --cluster."
        )
    out = _result(arguments.out) if arguments.out is not None else None
    given = Sweep.read(source)
    out = out or _result(f"{source.stem}.{given.format}")
    begun = time.monotonic()
    try:
        summary = run_sweep(given, out, threads=threads, cluster=arguments.cluster)
    except KeyboardInterrupt:
        folder = parts_folder(out)
        if folder.exists():
            sys.stderr.write(
                f"\npainleve: note: finished chunks stay in {folder}; the same command resumes "
                "there.\n"
            )
        raise
    written = {"seconds": time.monotonic() - begun, "file": str(out)}
    if arguments.json:
        print_json({**summary, **written})
    else:
        _show(summary)
        show(f"written: {out}")
    return EXIT_DOUBTFUL if summary["open_balances"] else 0


def _result(text: str) -> Path:
    """Return where the result goes, checked before anything runs."""
    store = Path(text).suffix.lower() == ".zarr"
    out = output_store("--out", text) if store else output_file("--out", text, SUFFIXES)
    check_format(out)
    return out


def _show(summary: SweepSummary) -> None:
    show(summary["title"] or f"{summary['mechanism']} with law {summary['law']}")
    axes = ", ".join(f"{n} [{u}]" for n, u in summary["axes"].items())
    show(f"{summary['points']:,} points over {axes}")
    reasons = (f"{n:,} {name}" for name, n in summary["stop_reasons"].items())
    show(f"ended by {', '.join(reasons)}")
    for name in summary["stop_reasons"]:
        reason = StopReason.from_label(name)
        if reason not in (StopReason.T_END, StopReason.UNTIL):
            show(f"  {name}: {reason.sentence}")
    show()
    rows = [
        (
            name,
            "-" if q["from"] is None else number(q["from"]),
            "-" if q["to"] is None else quantity(q["to"], q["unit"]),
            f"{q['missing']:,}" if q["missing"] else "",
        )
        for name, q in summary["quantities"].items()
    ]
    show_table(("quantity", "from", "to", "without"), rows)
    for notice in summary["notices"]:
        show(notice)
