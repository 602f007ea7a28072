"""Tables and figure of ``docs/contact-solvers.md`` and of its manuscript, from kept first steps."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from derivations.generated import contact_coefficients as coefficients
from painleve_sym.present.style import PAGE as WIDTH
from painleve_sym.present.style import PALETTE, legend_below, legend_entries, styled, write_figure
from painleve_sym.quantities import axis_label
from painleve_sym.tables import markdown_table as table
from tools.tables import written

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "examples" / "studies" / "peers" / "cone-dual.json"
PAGES = (ROOT / "docs" / "contact-solvers.md", ROOT / "paper" / "contact-solvers.md")
FIGURE = ROOT / "docs" / "figures" / "contact-solvers.png"
Matrix = NDArray[np.float64]
SLIP, G = -1.0, 9.8
"""Of the rod at the start: m/s along the ground, with θ̇ = 1 rad/s; and gravity, m/s²."""


def mobility(theta: float) -> Matrix:
    """Return W of the rod, normal direction first."""
    w_nt = coefficients.W_nt(theta=theta, m=1.0)
    return np.array(
        [
            [coefficients.W_nn(theta=theta, m=1.0), w_nt],
            [w_nt, coefficients.W_tt(theta=theta, m=1.0)],
        ]
    )


def sliding_coefficient(W: Matrix, mu: float) -> float:
    """Return A of a contact that slides to the left."""
    return float(W[0, 0] + mu * W[0, 1])


def cone_dual_step(W: Matrix, mu: float, velocity: Matrix) -> tuple[Matrix, Matrix]:
    """Return impulse and velocity of a convex step of a contact that slides to the left."""
    edge = np.array([1.0, mu])
    impulse = edge * (-(edge @ velocity) / (edge @ W @ edge))
    after = velocity + W @ impulse
    if after[0] < 0:
        impulse, after = np.linalg.solve(W, -velocity), np.zeros(2)
    return impulse, after


REGULARIZATIONS: dict[str, Callable[[Matrix], Matrix]] = {
    # (1 - d)/d of the body's mean inverse mass, 2/3 with two slides; the impedance d is 0.9999.
    "MuJoCo": lambda W: (1 - 0.9999) / 0.9999 * 2 / 3 * np.eye(2),
    # The near-rigid contact of Castro, Permenter & Han (2021).
    "Drake, SAP": lambda W: np.linalg.norm(W) / 3 * np.diag([1 / (4 * math.pi**2), 1e-3]),
}
"""Program → what it adds to W, as its documentation has it."""


def predicted(program: str, theta: float, mu: float, step: float) -> tuple[float, float]:
    """Return impulse and normal velocity of a first step with the program's regularization."""
    W = mobility(theta)
    free = step * np.array([-G + math.sin(theta), math.cos(theta)])
    velocity = np.array([0.0, SLIP]) + free
    impulse, _ = cone_dual_step(W + REGULARIZATIONS[program](W), mu, velocity)
    return float(impulse[0]), float((velocity + W @ impulse)[0])


def limit(theta: float, mu: float) -> tuple[float, float]:
    """Return impulse and normal velocity of a step whose length and compliance tend to zero."""
    impulse, after = cone_dual_step(mobility(theta), mu, np.array([0.0, SLIP]))
    return float(impulse[0]), float(after[0])


def first_steps(data: dict[str, Any], mu: float) -> str:
    """Return the table of impulses and velocities at one friction."""
    programs = list(data["versions"])
    head = ["θ", "A", "P, closed form", *(f"P, {name}" for name in programs)]
    head += ["ẏ_A, closed form", *(f"ẏ_A, {name}" for name in programs)]
    rows = {(r["program"], r["theta"], r["mu"]): r for r in data["rows"]}
    lines = []
    for theta in sorted({r["theta"] for r in data["rows"]}):
        of = [rows[name, theta, mu] for name in programs]
        impulse, normal = limit(theta, mu)
        values = [sliding_coefficient(mobility(theta), mu), impulse, *(r["impulse"] for r in of)]
        values += [normal, *(r["normal"] for r in of)]
        lines.append([f"{theta}", *(f"{v + 0.0:.4f}".replace("-0.0000", "0.0000") for v in values)])
    return table(head, lines)


def agreement(data: dict[str, Any]) -> str:
    """Return the table of largest differences over all states."""
    lines = []
    for program, version in data["versions"].items():
        rows = [r for r in data["rows"] if r["program"] == program]

        def largest(values: Iterable[float]) -> float:
            return max(map(abs, values))

        plain = largest(r["impulse"] / limit(r["theta"], r["mu"])[0] - 1 for r in rows)
        own = largest(
            r["impulse"] / predicted(program, r["theta"], r["mu"], data["step"])[0] - 1
            for r in rows
        )
        speed = largest(
            r["normal"] - predicted(program, r["theta"], r["mu"], data["step"])[1] for r in rows
        )
        lines.append(
            [program, version, str(len(rows)), f"{plain:.1e}", f"{own:.1e}", f"{speed:.1e} m/s"]
        )
    head = ("program", "version", "states", "of P from the closed form")
    return table((*head, "of P with R and the step", "of ẏ_A with R and the step"), lines)


def tables(data: dict[str, Any]) -> dict[str, str]:
    """Return every table of the page."""
    return {"first-steps": first_steps(data, 1.4), "agreement": agreement(data)}


@styled
def figure(data: dict[str, Any]) -> Figure:
    """Return impulse and normal velocity over the angle: the closed form, and both programs."""
    drawn = Figure(figsize=(WIDTH, 2.7), layout="constrained")
    left, right = drawn.subplots(1, 2)
    angles = np.linspace(0.25, 1.45, 241)
    frictions = sorted({r["mu"] for r in data["rows"]})
    marks = dict(zip(data["versions"], "o+", strict=True))
    for colour, mu in zip(PALETTE, frictions, strict=False):
        curves = np.array([limit(theta, mu) for theta in angles])
        for axes, column, name in ((left, 0, "impulse"), (right, 1, "normal")):
            axes.plot(angles, curves[:, column], color=colour, label=f"$\\mu = {mu:g}$")
            for program, mark in marks.items():
                rows = [r for r in data["rows"] if (r["program"], r["mu"]) == (program, mu)]
                look = {"color": colour, "markerfacecolor": "none", "markersize": 4}
                axes.plot([r["theta"] for r in rows], [r[name] for r in rows], mark, **look)
    left.set(ylabel=axis_label("P", "N s"), title="(a) impulse")
    right.set(ylabel=axis_label(r"\dot y_A", "m/s"), title="(b) normal velocity")
    for axes in (left, right):
        axes.set_xlabel(axis_label(r"\theta", "rad"))
    look = {"color": "black", "linestyle": "none", "fillstyle": "none"}
    programs = {name: Line2D([], [], marker=mark, **look) for name, mark in marks.items()}
    legend_below(drawn, legend_entries([left]) | programs)
    return drawn


def main() -> None:
    """Write page, manuscript and figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--figures", type=Path, default=FIGURE.parent, help="folder")
    options = parser.parse_args()
    data = json.loads(RESULTS.read_text("utf-8"))
    for page in PAGES:
        page.write_text(written(page.read_text("utf-8"), tables(data)), "utf-8")
    write_figure(figure(data), options.figures / FIGURE.name)


if __name__ == "__main__":
    main()
