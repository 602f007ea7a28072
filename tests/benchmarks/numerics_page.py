"""Measure, draw and write the tables of ``docs/numerics.md``: ``make numerics``.

The numbers are kept in ``docs/numerics.json``; without ``--measure`` figures and tables are made
from that file, and a test compares the page with it.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from painleve_sym.present.style import DASHES, PAGE, PALETTE, REFERENCE, STYLE, write_figure
from painleve_sym.tables import markdown_table as table
from tests.benchmarks import accuracy, bench_numerics
from tests.benchmarks.__main__ import machine
from tools.tables import written

DOCS = Path(__file__).parents[2] / "docs"
NUMBERS = DOCS / "numerics.json"
PAGE_FILE = DOCS / "numerics.md"
FIGURES = DOCS / "figures"

BLACK, BLUE, RED, GREEN, PINK = PALETTE
LOOKS: Mapping[str, tuple[str, Any, str]] = {
    "painleve-sym, Taylor": (BLACK, DASHES[0], "o"),
    "painleve-sym, Taylor, row of a batch": (BLACK, DASHES[3], "o"),
    "painleve-sym, Runge-Kutta": (BLUE, DASHES[0], "s"),
    "painleve-sym, erk without compiler": (BLUE, DASHES[3], "s"),
    "heyoka Taylor": (RED, DASHES[0], "^"),
    bench_numerics.ALONE: (RED, DASHES[3], "^"),
    "SUNDIALS CVODE Adams, C": (GREEN, DASHES[0], "D"),
    "SUNDIALS CVODE BDF, C": (GREEN, DASHES[1], "v"),
    "SUNDIALS ARKODE ERK 8(7), C": (GREEN, DASHES[3], "<"),
    "CasADi erk, generated C": (PINK, DASHES[0], "P"),
    "CasADi erk, virtual machine": (PINK, DASHES[3], "P"),
    "scikit-sundae CVODE": (REFERENCE, DASHES[1], "x"),
    "SciPy DOP853": (REFERENCE, DASHES[0], "x"),
}
"""Colour, dashes and marker of each contestant, in the order of the legend."""


# ---- figures ----


def _panels(titles: Sequence[str], height: float) -> tuple[Figure, list[Any]]:
    figure = Figure(figsize=(PAGE, height), layout="constrained")
    axes = list(figure.subplots(1, len(titles), sharey=True))
    for letter, axis, title in zip("abc", axes, titles, strict=False):
        axis.set_title(f"({letter}) {title}")
        axis.set_xscale("log")
        axis.set_yscale("log")
    return figure, axes


def _legend(figure: Figure, axis: Any, columns: int) -> None:
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns)


def _curve(axis: Any, name: str, x: Iterable[float], y: Iterable[float]) -> None:
    colour, dashes, marker = LOOKS[name]
    look = {"color": colour, "linestyle": dashes, "marker": marker, "markersize": 3.2}
    axis.plot(list(x), list(y), label=name, markerfacecolor="white", markeredgewidth=0.7, **look)


def error_against_cost(numbers: Mapping[str, Any]) -> Figure:
    """Draw the curves of all motions."""
    curves = numbers["curves"]
    figure, axes = _panels(list(curves), 4.3)
    for axis, measured in zip(axes, curves.values(), strict=True):
        for name in LOOKS:
            points = measured["peers"].get(name, [])
            if points:
                _curve(axis, name, (p["seconds"] for p in points), (p["error"] for p in points))
        axis.set_xlabel("processor time of one motion (s)")
        axis.set_ylim(1e-15, 3e-2)
    axes[0].set_ylabel("relative error at the end")
    _legend(figure, axes[0], 3)
    return figure


def event_times(numbers: Mapping[str, Any]) -> Figure:
    """Draw the largest error of the times of events over the tolerance."""
    cases = numbers["accuracy"]["event_times"]
    figure, axes = _panels(list(cases), 3.4)
    for axis, measured in zip(axes, cases.values(), strict=True):
        tolerances = measured["tolerances"]
        axis.plot(tolerances, tolerances, color=REFERENCE, linewidth=0.7, label="slope 1")
        for name in LOOKS:
            line = measured["engines"].get(name)
            if line:
                kept = [
                    (t, max(e, 1e-17))
                    for t, e in zip(tolerances, line["largest"], strict=True)
                    if e is not None
                ]
                _curve(axis, name, *zip(*kept, strict=True))
        axis.set_xlabel("relative tolerance")
        axis.set_ylim(1e-17, 1e-1)
    axes[0].set_ylabel("largest relative error of an event's time")
    _legend(figure, axes[0], 3)
    return figure


def starts(numbers: Mapping[str, Any]) -> Figure:
    """Draw errors of steps of one length, and of chosen steps, from the three starts."""
    fixed, chosen = (numbers["accuracy"][n] for n in ("fixed_steps", "adaptive_starts"))
    figure = Figure(figsize=(PAGE, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    lines = list(zip(fixed["starts"], PALETTE, "so^", strict=False))
    for start, colour, marker in lines:
        look = {"color": colour, "marker": marker, "markersize": 3.6, "markerfacecolor": "white"}
        part = [1 / count for count in fixed["steps"]]
        left.plot(
            part, [max(e, 1e-16) for e in fixed["starts"][start]["errors"]], label=start, **look
        )
        for name, dashes in (
            ("painleve-sym, Taylor", "solid"),
            ("painleve-sym, Runge-Kutta", DASHES[1]),
        ):
            errors = [max(e, 1e-16) for e in chosen["starts"][start][name]["errors"]]
            label = f"{start}, {name.split(', ')[1]}"
            right.plot(chosen["tolerances"], errors, linestyle=dashes, label=label, **look)
    left.set(title="(a) Runge–Kutta, steps of one length", xlabel="step, in parts of the motion")
    right.set(title="(b) chosen steps", xlabel="relative tolerance")
    left.set_ylabel("relative error of the normal velocity")
    for axis in (left, right):
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.legend(loc="upper left", fontsize=7)
        axis.set_ylim(3e-17, 1.0)
    return figure


DRAWN: Mapping[str, Callable[[Mapping[str, Any]], Figure]] = {
    "error-against-cost": error_against_cost,
    "event-times": event_times,
    "start-of-contact": starts,
}


# ---- tables ----


def _size(value: float | None, digits: int = 1) -> str:
    if value is None or not math.isfinite(value):
        return "—"
    return f"{value:.{digits - 1}e}".replace("e-0", "e-").replace("e+0", "e+")


def _short(value: float | None, form: str = ".3g") -> str:
    return "—" if value is None or not math.isfinite(value) else format(value, form)


def setup_table(numbers: Mapping[str, Any]) -> str:
    """Return machine, compiler and versions."""
    given = numbers["machine"]
    versions = ", ".join(f"{n} {v}" for n, v in given["versions"].items() if v)
    rows = [
        ("processor", f"{given['processor']}, {given['processors']} cores"),
        ("load when measured", f"{given['load']:.1f}"),
        ("C compiler", given["compiler"]),
        ("flags", f"`{' '.join(given['flags'])}`"),
        ("versions", versions),
    ]
    return table(("item", "value"), rows)


def ratio_table(numbers: Mapping[str, Any]) -> str:
    """Return times at equal error in those of the Taylor engine."""
    curves = numbers["curves"]
    errors = list(next(iter(next(iter(curves.values()))["ratios"].values())))
    head = ["program", *(f"{case}, {e.replace('e-0', 'e-')}" for case in curves for e in errors)]
    rows = []
    for name in LOOKS:
        cells = [
            _short(measured["ratios"].get(name, {}).get(e), ".2g")
            for measured in curves.values()
            for e in errors
        ]
        rows.append([name, *(_plain(c) for c in cells)])
    return table(head, rows)


def _plain(cell: str) -> str:
    return cell if cell == "—" else f"{float(cell):g}"


def time_table(numbers: Mapping[str, Any]) -> str:
    """Return the Taylor engine's own times at these errors, µs."""
    rows = []
    for case, measured in numbers["curves"].items():
        points = measured["peers"]["painleve-sym, Taylor"]
        times = (bench_numerics.seconds_at(points, e) for e in (1e-6, 1e-9, 1e-11))
        rows.append([case, *(_short(1e6 * t, ".0f") if t else "—" for t in times)])
    return table(("Taylor engine, µs", "1e-6", "1e-9", "1e-11"), rows)


def failure_table(numbers: Mapping[str, Any]) -> str:
    """Return where a motion was not completed with the right events."""
    rows = [
        (case, name, ", ".join(_size(t) for t in tolerances))
        for case, measured in numbers["curves"].items()
        for name, tolerances in measured["failed"].items()
    ]
    return table(("motion", "contestant", "tolerances without an answer"), rows)


def slope_table(numbers: Mapping[str, Any]) -> str:
    """Return the exponents of the events' errors in the tolerance."""
    cases = numbers["accuracy"]["event_times"]
    rod = next(iter(cases))
    head = [
        "program",
        *(f"rod: {event}" for event in accuracy.EVENTS),
        *(f"{c}: largest" for c in cases),
    ]
    rows = []
    for name in LOOKS:
        if name not in cases[rod]["engines"]:
            continue
        cells = cases[rod]["engines"][name]["slopes"]
        cells = [*cells, *(measured["engines"][name]["slope"] for measured in cases.values())]
        rows.append([name, *(_short(c, ".2f") for c in cells)])
    return table(head, rows)


def event_table(numbers: Mapping[str, Any]) -> str:
    """Return the largest error of an event's time at some tolerances."""
    cases = numbers["accuracy"]["event_times"]
    chosen = (1e-6, 1e-9, 1e-12)
    head = ["program", *(f"{case}, {_size(t)}" for case in cases for t in chosen)]
    rows = []
    for name in LOOKS:
        if name not in next(iter(cases.values()))["engines"]:
            continue
        cells = []
        for measured in cases.values():
            line = dict(
                zip(measured["tolerances"], measured["engines"][name]["largest"], strict=True)
            )
            cells += [
                next(e for t, e in line.items() if math.isclose(t, wanted)) for wanted in chosen
            ]
        rows.append([name, *(_size(c) for c in cells)])
    return table(head, rows)


def grazing_table(numbers: Mapping[str, Any]) -> str:
    """Return the error of a touchdown's time over its speed."""
    measured = numbers["accuracy"]["grazing"]
    head = ["speed (m/s)", "depth (m)", "Taylor (s)", "Runge–Kutta (s)", "`erk` (s)"]
    rows = []
    for r in measured["rows"]:
        errors = (r[engine] for engine in accuracy.ENGINES)
        cells = ["not seen" if e is None else _size(e, 2) for e in errors]
        rows.append([_size(r["speed"]), _size(r["speed"] ** 2 / 2), *cells])
    return table(head, rows)


def touch_table(numbers: Mapping[str, Any]) -> str:
    """Return the errors of an elastic impact over its speed."""
    measured = numbers["accuracy"]["soft_touch"]
    shown = ("time", "rebound")
    head = ["speed (m/s)"]
    head += [f"{name}: {q}" for name in ("Taylor", "Runge–Kutta", "`erk`") for q in shown]
    rows = [
        [_size(r["speed"]), *(_size(r[e][q], 2) for e in accuracy.ENGINES for q in shown)]
        for r in measured["rows"]
    ]
    return table(head, rows)


def fixed_table(numbers: Mapping[str, Any]) -> str:
    """Return errors and orders of Runge–Kutta steps of one length."""
    measured = numbers["accuracy"]["fixed_steps"]
    head = ["steps"]
    for start in measured["starts"]:
        head += [start, "order"]
    rows = []
    for i, count in enumerate(measured["steps"]):
        row = [str(count)]
        for line in measured["starts"].values():
            row += [_size(line["errors"][i], 2), _short(line["orders"][i], ".2f")]
        rows.append(row)
    return table(head, rows)


def taylor_table(numbers: Mapping[str, Any]) -> str:
    """Return errors and orders of Taylor steps of one length and order."""
    measured = numbers["accuracy"]["taylor_orders"]
    head = ["steps"]
    for order in measured["orders"]:
        head += [f"order {order}", "measured"]
    rows = []
    for i, count in enumerate(measured["steps"]):
        row = [str(count)]
        for line in measured["orders"].values():
            row += [_size(line["errors"][i], 2), _short(line["orders"][i], ".2f")]
        rows.append(row)
    return table(head, rows)


def chosen_table(numbers: Mapping[str, Any]) -> str:
    """Return errors and steps of chosen steps from the three starts."""
    measured = numbers["accuracy"]["adaptive_starts"]
    wanted = [
        i for i, t in enumerate(measured["tolerances"]) if round(-math.log10(t)) in (5, 8, 11)
    ]
    head = ["start", "engine"]
    for i in wanted:
        head += [f"error at {_size(measured['tolerances'][i])}", "steps"]
    head.append("exponent")
    rows = []
    for start, engines in measured["starts"].items():
        for name, line in engines.items():
            row = [start, name.split(", ")[1]]
            for i in wanted:
                row += [_size(line["errors"][i], 2), str(line["steps"][i])]
            rows.append([*row, _short(line["slope"], ".2f")])
    return table(head, rows)


def stepping_table(numbers: Mapping[str, Any]) -> str:
    """Return errors and orders of time stepping."""
    measured = numbers["accuracy"]["time_stepping"]
    head = ["scheme", "start", *(f"h = {_size(h, 3)}" for h in measured["steps"]), "order"]
    rows = []
    for scheme, states in measured["schemes"].items():
        for name, line in states.items():
            fit = accuracy.slope(measured["steps"], line["errors"])
            rows.append([scheme, name, *(_size(e, 2) for e in line["errors"]), _short(fit, ".2f")])
    return table(head, rows)


def jump_table(numbers: Mapping[str, Any]) -> str:
    """Return errors of the jump rules over the modulus with their local orders."""
    measured = numbers["accuracy"]["jump_rules"]
    head = ["E (Pa)", "compliant ẏ_A"]
    for rule in ("classical", "frozen", "carried"):
        head += [rule, "order"]
    rows = []
    for r in measured["rows"]:
        row = [_size(r["E"], 3), f"{r['compliant']:.7f}"]
        for rule in ("classical", "frozen", "carried"):
            row += [_size(r[rule], 2), _short(r[f"order_{rule}"], ".3f")]
        rows.append(row)
    return table(head, rows)


TABLES: Mapping[str, Callable[[Mapping[str, Any]], str]] = {
    "setup": setup_table,
    "times": time_table,
    "ratios": ratio_table,
    "failures": failure_table,
    "event-errors": event_table,
    "event-slopes": slope_table,
    "grazing": grazing_table,
    "soft-touch": touch_table,
    "fixed-steps": fixed_table,
    "taylor-orders": taylor_table,
    "chosen-steps": chosen_table,
    "time-stepping": stepping_table,
    "jump-rules": jump_table,
}


def tables(numbers: Mapping[str, Any]) -> dict[str, str]:
    """Return every table of the page."""
    return {name: make(numbers) for name, make in TABLES.items()}


def _rounded(value: Any) -> Any:
    """Return the numbers with five digits, with which they are kept."""
    if isinstance(value, dict):
        return {k: _rounded(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_rounded(v) for v in value]
    if isinstance(value, float):
        return float(f"{value:.5g}") if math.isfinite(value) else None
    return value


def measure(repeats: int) -> dict[str, Any]:
    """Return everything that the page shows."""
    before = machine()
    return {
        "machine": before,
        "accuracy": accuracy.measure(),
        "curves": bench_numerics.measure(repeats),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure where asked; draw the figures and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--measure", action="store_true", help="measure; else the kept numbers")
    parser.add_argument("--repeats", type=int, default=21, help="rounds of timed runs")
    parser.add_argument("--figures", type=Path, default=FIGURES, help="folder of the figures")
    o = parser.parse_args(arguments)
    if o.measure:
        NUMBERS.write_text(json.dumps(_rounded(measure(o.repeats)), indent=1) + "\n", "utf-8")
    numbers = json.loads(NUMBERS.read_text("utf-8"))
    for name, draw in DRAWN.items():
        with mpl.rc_context(STYLE):
            write_figure(draw(numbers), o.figures / f"{name}.png")
    page = written(PAGE_FILE.read_text("utf-8"), tables(numbers))
    PAGE_FILE.write_text(page, "utf-8")


if __name__ == "__main__":
    main()
