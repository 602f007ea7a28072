"""Write tables and figure of ``docs/peers.md`` from the results in ``examples/studies/peers``."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from painleve_sym.present.style import PAGE as WIDTH
from painleve_sym.present.style import PALETTE, legend_below, legend_entries, styled, write_figure
from painleve_sym.quantities import axis_label, number_latex
from painleve_sym.tables import markdown_table as table
from tools.tables import written

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "examples" / "studies" / "peers" / "results.json"
PAGE = ROOT / "docs" / "peers.md"
MARKS = {
    "one force (Table 1)": "one-force",
    "lift-off (Table 2)": "lift-off",
    "no solution (Table 3)": "no-solution",
    "two solutions (Table 4)": "two-solutions",
}
"""State → name of its table."""
STEPS = (1e-3, 1e-4, 1e-5)


def _cells(rows: Sequence[dict[str, Any]], name: str, form: str) -> list[str]:
    by_step = {row["step"]: row for row in rows}
    return [format(by_step[h][name], form) if h in by_step else "—" for h in STEPS]


def state_table(results: Sequence[dict[str, Any]], state: str) -> str:
    """Return what every program computes at a state."""
    head = ["program, setting"]
    head += [
        f"{symbol}, h = {h:.0e}".replace("e-0", "e-") for symbol in ("F_n", "P_n") for h in STEPS
    ]
    head += ["ẋ_A", "ẏ_A", "not converged"]
    lines = []
    for result in results:
        if "missing" in result:
            lines.append([result["program"], "not installed", *(["—"] * (len(head) - 2))])
            continue
        for setting, states in result["settings"].items():
            rows = states[state]
            slip, normal, _ = rows[-1]["end"]
            failed = sum(row["failed"] for row in rows)
            lines.append(
                [
                    f"{result['program']}: {setting}",
                    *_cells(rows, "force", ".4g"),
                    *_cells(rows, "impulse", ".4f"),
                    f"{slip + 0.0:.4f}".replace("-0.0000", "0.0000"),
                    f"{normal + 0.0:.4f}".replace("-0.0000", "0.0000"),
                    str(failed),
                ]
            )
    return table(head, lines)


def version_table(results: Sequence[dict[str, Any]]) -> str:
    """Return the programs with their versions."""
    rows = [(r["program"], r.get("version", r.get("missing", ""))) for r in results]
    return table(("program", "version"), rows)


def tables(results: Sequence[dict[str, Any]]) -> dict[str, str]:
    """Return every table of the page."""
    made_of_states = {mark: state_table(results, state) for state, mark in MARKS.items()}
    return {"versions": version_table(results)} | made_of_states


@styled
def figure(results: Sequence[dict[str, Any]]) -> Figure:
    """Return the normal impulse of every program and setting, a panel for each state."""
    rows = [
        (f"{result['program']}: {setting}", states)
        for result in results
        for setting, states in result.get("settings", {}).items()
    ]
    drawn = Figure(figsize=(WIDTH, 0.4 + 0.17 * len(rows)), layout="constrained")
    panels = drawn.subplots(1, len(MARKS), sharex=True, sharey=True)
    for letter, axes, state in zip("abcd", panels, MARKS, strict=True):
        for h, symbol, colour in zip(STEPS, "so^", PALETTE, strict=False):
            for i, (_, states) in enumerate(rows):
                kept = [row["impulse"] for row in states[state] if row["step"] == h]
                look = {"color": colour, "markerfacecolor": "none", "markersize": 3.6}
                label = f"$h = {number_latex(h)}$ s" if i == 0 else "_"
                axes.plot(kept, [i] * len(kept), symbol, label=label, **look)
        axes.set(xlabel=axis_label("P_n", "N s"), title=f"({letter}) {state.split(' (')[0]}")
        axes.tick_params(left=False, right=False)
        axes.margins(x=0.08)
        axes.grid(axis="y", color="0.92", linewidth=0.5)
    power = re.compile(r"\d+e\+\d+")
    names = [power.sub(lambda n: f"${number_latex(float(n[0]))}$", name) for name, _ in rows]
    panels[0].set_yticks(range(len(rows)), names, fontsize=6.5)
    panels[0].invert_yaxis()
    legend_below(drawn, legend_entries(panels))
    return drawn


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--figures", type=Path, default=PAGE.parent / "figures", help="folder")
    options = parser.parse_args()
    results = json.loads(RESULTS.read_text("utf-8"))
    PAGE.write_text(written(PAGE.read_text("utf-8"), tables(results)), "utf-8")
    write_figure(figure(results), options.figures / "peers.png")


if __name__ == "__main__":
    main()
