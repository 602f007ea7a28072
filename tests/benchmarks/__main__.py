"""All measurements of the package's speed in one run, as text and as JSON: ``make bench``.

Every ratio is of processor times taken in turn in this process, after the answers were checked.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib import metadata
from pathlib import Path
from typing import Any

from painleve_sym.codegen.compile import FLAGS, find_compiler
from painleve_sym.motion.batch.machine import processor_count
from tests.benchmarks import (
    accuracy,
    bench_call,
    bench_corrected_jump,
    bench_explorer,
    bench_impact_in_space,
    bench_many,
    bench_modes,
    bench_numerics,
    bench_sensitivity,
    bench_start,
)
from tests.benchmarks import bench_table3 as single
from tests.benchmarks.cases import CASES

PACKAGES = ("painleve-sym", "casadi", "heyoka", "numpy", "scikit-sundae", "scipy", "sympy")
SINGLE = {"heyoka": 1.3, "SciPy": 150.0, "scikit-sundae": 100.0, "generated C": 5.0}
"""Wanted ratios of a single impact, by a part of the peer's name."""


def machine() -> dict[str, Any]:
    """Return versions, compiler, flags, processor and how busy it is."""
    compiler = find_compiler()
    return {
        "versions": {p: _version(p) for p in PACKAGES} | {"python": platform.python_version()},
        "compiler": compiler.version,
        "flags": list(FLAGS),
        "processor": _processor(),
        "processors": processor_count(),
        "load": os.getloadavg()[0],
    }


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((x.split(":")[1].strip() for x in lines if x.startswith("model name")), "")


def impacts(repeats: int) -> dict[str, Any]:
    """Return the lines of `bench_table3` and its wanted ratios."""
    lines, wanted = [], {}
    for case in CASES:
        contenders, skipped = single.contestants(case)
        print(*skipped, sep="\n")
        measured = single.measure(contenders, repeats=repeats)
        print(single.table(measured), flush=True)
        lines += measured
    for line in lines:
        for part, least in SINGLE.items():
            if part in line.peer and line.ratio is not None:
                name = f"{line.case}, {line.target:g}: {line.peer}"
                wanted[name] = {"measured": line.ratio, "at_least": least}
    return {"lines": [asdict(line) for line in lines], "wanted": wanted}


def batches(per_axis: int) -> dict[str, Any]:
    """Return what `bench_many` measures, with its wanted ratios."""
    times = bench_many.measure(per_axis, 2000)
    times["lanes"] = bench_many.lanes(per_axis**4)
    count = processor_count()
    times["threads"] = bench_many.threads(per_axis, range(1, count + 1))
    times["wanted"] = {
        "heyoka's batch mode": {"measured": times["heyoka"]["ratio"], "at_least": 2.5}
    }
    if count > 1:
        one, two = (times["threads"][n]["wall"] for n in (1, 2))
        times["wanted"]["two threads, by the clock"] = {"measured": one / two, "at_least": 1.9}
    return times


def starts() -> dict[str, Any]:
    """Return seconds of `bench_start`, with their limits."""
    times = {f"{m}, {law}": bench_start.measure(m, law) for m, law in bench_start.CASES}
    rod = times["rod, bilinear-hertz"]
    wanted = {
        f"{case} from nothing, s": {
            "measured": stages["from nothing"]["total"],
            "at_most": 2.0 if case.startswith("rod") else 15.0,
        }
        for case, stages in times.items()
    }
    cached = {"measured": rod["from the cache"]["total"], "at_most": 0.02}
    wanted["rod from the cache, s"] = cached
    warm = bench_start.commands()
    for name in bench_start.COMMANDS:
        title = f"command {name}, in imports of NumPy"
        wanted[title] = {"measured": warm[name]["ratio"], "at_most": bench_start.COMMAND_RATIO}
    return {"cases": times, "commands": warm, "wanted": wanted}


def calls() -> dict[str, Any]:
    """Return the times of engines and of whole calls, s."""
    times = bench_call.measure()
    for title, line in times.items():
        engine, whole = (1e6 * line[name] for name in ("engine", "call"))
        print(f"{title:30} engine {engine:7.1f} us, call {whole:7.1f} us", flush=True)
    impact = {"measured": times["rod, compliant"]["call"], "at_most": bench_call.LIMIT}
    wanted = {"call for an impact of the rod, s": impact}
    named = bench_call.named()
    for name, line in named.items():
        print(f"{name:30} {1e6 * line['call']:7.1f} us, {line['ratio']:.1f} engines", flush=True)
        wanted[f"{name} by name, s"] = {
            "measured": line["call"],
            "at_most": bench_call.NAMED_LIMITS[name],
        }
    return {"cases": times, "named": named, "wanted": wanted}


def derivatives() -> dict[str, Any]:
    """Return the cost of an 8 × 8 Jacobian of Table 3 in plain runs."""
    times = bench_sensitivity.measure(1e-11)
    print(f"8 x 8 Jacobian in plain runs: {times}")
    limit = {"measured": times["loop"], "at_most": bench_sensitivity.LIMIT}
    return times | {"wanted": {"8 x 8 Jacobian, plain runs": limit}}


def jumps() -> dict[str, Any]:
    """Return the cost of one jump at finite stiffness, s."""
    times = bench_corrected_jump.measure()
    limit = {"measured": times["from rest"], "at_most": bench_corrected_jump.LIMIT}
    return {"seconds": times, "wanted": {"corrected jump from rest, s": limit}}


def impacts_in_space() -> dict[str, Any]:
    """Return the cost of an impact of one contact in space, s."""
    times = bench_impact_in_space.measure()
    print(f"impact in space: {times}")
    wanted = {
        f"impact in space, {title}, s": {
            "measured": line["compiled"],
            "at_most": bench_impact_in_space.LIMIT,
        }
        for title, line in times.items()
    }
    return {"seconds": times, "wanted": wanted}


def modes() -> dict[str, Any]:
    """Return the cost of natural modes in both integrators, and that of ten in rigid rods."""
    cases = bench_modes.measure()
    ten = f"rod-bending:10,0 {bench_modes.MODULI[0]:.2e}"
    wanted = {
        f"ten bending modes, {integrator}, in rigid rods": {
            "measured": cases[f"{integrator} {ten}"]["ratio"],
            "at_most": bench_modes.LIMIT,
        }
        for integrator in bench_modes.ENGINES.values()
    }
    return {"cases": cases, "wanted": wanted}


def numerics(repeats: int) -> dict[str, Any]:
    """Return error against cost, and the orders of accuracy."""
    return {"curves": bench_numerics.measure(repeats), "accuracy": accuracy.measure()}


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, and rewrite the file after every part."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, metavar="FILE")
    parser.add_argument("--repeats", type=int, default=101, help="of single impacts")
    parser.add_argument("--per-axis", type=int, default=18, help="batches have this to the fourth")
    o = parser.parse_args(arguments)
    parts: dict[str, Callable[[], dict[str, Any]]] = {
        "start": starts,
        "impacts": lambda: impacts(o.repeats),
        "batches": lambda: batches(o.per_axis),
        "calls": calls,
        "derivatives": derivatives,
        "corrected_jump": jumps,
        "impacts_in_space": impacts_in_space,
        "modes": modes,
        "explorer": bench_explorer.measure,
        "numerics": lambda: numerics(max(o.repeats // 10, 1)),
    }
    result: dict[str, Any] = {"machine": machine()}
    print(json.dumps(result["machine"], indent=2), flush=True)
    o.out.parent.mkdir(parents=True, exist_ok=True)
    for name, measure in parts.items():
        try:
            result[name] = measure()
        except ImportError as error:
            result[name] = {"skipped": str(error)}
            print(f"{name}: skipped ({error})")
        beside = o.out.with_name(f".{o.out.name}.new")
        beside.write_text(json.dumps(result, indent=2) + "\n", "utf-8")
        beside.replace(o.out)
    print(f"{'':62} {'measured':>10} {'wanted':>12}")
    for part in parts:
        for name, w in result[part].get("wanted", {}).items():
            sign, limit = (">=", w["at_least"]) if "at_least" in w else ("<=", w["at_most"])
            met = w["measured"] >= limit if sign == ">=" else w["measured"] <= limit
            mark = "" if met else "  missed"
            print(f"{name:62} {w['measured']:10.4g} {sign:>4} {limit:7.4g}{mark}")
    print(f"{o.out}: everything measured, as JSON")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
