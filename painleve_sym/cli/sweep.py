"""The command sweep: one motion for every point of a grid or a sampled set."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from painleve_sym.cli.options import output_file, output_store, read_count
from painleve_sym.cli.output import number, print_json, quantity, show, show_table
from painleve_sym.errors import InputError, StopReason
from painleve_sym.study.sweeps.runner import Parts, Reporter, parts_folder, run_sweep
from painleve_sym.study.sweeps.sweep import Sweep
from painleve_sym.study.sweeps.writers import SUFFIXES, check_format, result_name, write_result


def sweep(arguments: argparse.Namespace) -> int:
    """Run or resume the sweep, write its result and print what it holds."""
    source = Path(arguments.file)
    threads = read_count("--threads", arguments.threads) if arguments.threads else None
    if threads and arguments.cluster is not None:
        raise InputError(
            "--threads: the workers of a cluster have one thread each. Fix: leave out --threads "
            "or --cluster."
        )
    out = _result(arguments.out) if arguments.out else None
    found = Sweep.read(source)
    out = out or _result(f"{source.stem}.{found.format}")
    begun = time.monotonic()
    try:
        parts = run_sweep(
            found, out, threads=threads, cluster=arguments.cluster, progress=Reporter(sys.stderr)
        )
        summary = _summary(parts) | {"seconds": time.monotonic() - begun, "file": str(out)}
        write_result(parts, out)
    except KeyboardInterrupt:
        folder = parts_folder(out)
        if folder.exists():
            sys.stderr.write(
                f"\npainleve: note: finished chunks stay in {folder}; the same command goes on "
                "from there.\n"
            )
        raise
    parts.remove()
    if arguments.json:
        print_json(summary)
    else:
        _show(found, summary)
    return 0


def _result(text: str) -> Path:
    """Return where the result goes, checked before anything runs."""
    store = Path(text).suffix.lower() == ".zarr"
    out = output_store("--out", text) if store else output_file("--out", text, SUFFIXES)
    check_format(out)
    return out


def _summary(parts: Parts) -> dict[str, Any]:
    """Return counts of the stop reasons and the range of every quantity, chunk by chunk."""
    sweep = parts.sweep
    reasons = {v: k for k, v in (sweep.codes("stop_reason") or {}).items()}
    counts: dict[str, int] = {}
    ranges: dict[str, dict[str, Any]] = {}
    for start in sweep.starts:
        codes, numbers = np.unique(parts.read(start, "stop_reason"), return_counts=True)
        for code, n in zip(codes.tolist(), numbers.tolist(), strict=True):
            counts[reasons[code]] = counts.get(reasons[code], 0) + n
        for name in sweep.kept:
            if sweep.codes(name) is None:
                _widen(ranges, result_name(sweep, name), parts.read(start, name), sweep.unit(name))
    axes = {n: sweep.unit(n) for n in sweep.space.names}
    return {
        "title": sweep.scenario.title,
        "mechanism": sweep.mechanism.name,
        "law": sweep.simulator.label,
        "points": sweep.space.points,
        "axes": axes,
        "stop_reasons": counts,
        "quantities": ranges,
    }


def _widen(ranges: dict[str, dict[str, Any]], name: str, values: Any, unit: str) -> None:
    each = values.reshape(len(values), -1)
    there = np.isfinite(each) if each.dtype.kind == "f" else np.ones(each.shape, bool)
    some = each[there]
    old = ranges.setdefault(name, {"unit": unit, "from": None, "to": None, "missing": 0})
    old["missing"] += int((~there.any(axis=1)).sum())
    if len(some):
        ends = [v for v in (old["from"], old["to"]) if v is not None]
        old["from"] = min([float(some.min()), *ends])
        old["to"] = max([float(some.max()), *ends])


def _show(found: Sweep, summary: dict[str, Any]) -> None:
    show(summary["title"] or f"{summary['mechanism']} with law {summary['law']}")
    axes = ", ".join(f"{n} [{u}]" for n, u in summary["axes"].items())
    show(f"{summary['points']:,} points over {axes}")
    reasons = (f"{n:,} {name}" for name, n in summary["stop_reasons"].items())
    show(f"ended by {', '.join(reasons)}")
    for name in summary["stop_reasons"]:
        reason = StopReason.from_label(name)
        if reason not in (StopReason.T_END, StopReason.UNTIL):
            show(f"  {name}: {reason.advice}")
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
    show(f"written: {summary['file']}")
