"""When does a real bar jam? Four thresholds of friction of Painlevé's rod as an elastic bar.

Below cot θ nothing grows. From mode coupling on small oscillations grow. From the landing on, a bar
that touches the ground while it slides stops in an impact without collision. From divergence on
sliding grows without oscillation. The landing is a motion of the linear bar with all its modes that
matter, at a frozen angle, on Hertz's contact; the others come from receptances and eigenvalues
(examples/studies/rigid_rod).

Run: python examples/studies/elastic_bar/elastic_bar.py [--draw] [--out FOLDER]
Writes elastic-bar.json (all numbers) and elastic-bar.png; --draw draws the kept numbers.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import painleve_sym as ps
from painleve_sym.present.style import (
    COLUMN,
    DASHES,
    PALETTE,
    legend_below,
    legend_entries,
    styled,
    write_figure,
)
from painleve_sym.quantities import axis_label

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "rigid_rod"))
from rigid_rod import Bar as FewModes  # noqa: E402
from rigid_rod import contact, euler_bernoulli, growth, modal, rigid, threshold  # noqa: E402

G = 9.8
ANGLES = (1.0, 1.1, 1.2, 1.3, 1.4)
SPEEDS = (1.0, 3.0, 10.0, 30.0, 100.0)
COUNTS = ((8, 2), (24, 12), (48, 24), (80, 40))
CONVERGED, COUPLED = (80, 40), (24, 12)
"""Bending and axial modes of landings and of mode coupling."""
DAMPING = 0.01
"""ζ of every mode in mode coupling; a landing has none."""
WINDOW, STEP = 6e-3, 1e-6
"""Time in which a landing must end, and the step of its integration, s."""
TIP = 0.00645
"""Radius of the tip, m."""
HERTZ = {"n": 1.5}


class Bar(FewModes):
    """The bar with any number of modes; from the 21st on a root is (i + 1/2)π to round-off."""

    def frequencies(self, bending: int, axial: int) -> tuple[Any, Any]:
        """Return the natural circular frequencies of both kinds; rad/s."""
        across, along = super().frequencies(min(bending, 20), min(axial, 1))
        roots = (np.arange(21, bending + 1) + 0.5) * math.pi
        more = roots**2 * math.sqrt(self.stiffness / (self.mass * self.length**3))
        return np.concatenate([across, more]), along[:1] * np.arange(1, axial + 1)


@dataclass(frozen=True)
class Modes:
    """The bar at a frozen angle as oscillators of mass m that the force of its end drives.

    Rigid motion has frequency 0: translation and rotation across the bar (end values 1 and √3,
    whose squares add to the 4 of W m), and translation along it. Bending modes have the end value
    2, axial ones √2.

    Attributes
    ----------
    rates, ends : array
        Circular frequencies in rad/s, and displacements of the end per coordinate.
    across : array of bool
        Whether a mode moves the end across the bar.
    weight : array of bool
        Whether gravity acts on a mode.
    """

    rates: Any
    ends: Any
    across: Any
    weight: Any

    @staticmethod
    def of(bar: Bar, bending: int, axial: int) -> Modes:
        """Return the modes of a bar."""
        b, a = bar.frequencies(bending, axial)
        return Modes(
            rates=np.concatenate([[0.0, 0.0], b, [0.0], a]),
            ends=np.concatenate(
                [[1.0, math.sqrt(3)], np.full(len(b), 2.0), [1.0], np.full(len(a), math.sqrt(2))]
            ),
            across=np.arange(3 + len(b) + len(a)) < 2 + len(b),
            weight=np.isin(np.arange(3 + len(b) + len(a)), (0, 2 + len(b))),
        )

    def along(self, across: Any, along: Any) -> Any:
        """Return a vector in the plane, by its parts across and along the bar, at every mode."""
        return np.where(self.across, across, along) * self.ends


def landings(
    bar: Bar,
    modes: Modes,
    constant: float,
    theta: Any,
    mu: Any,
    speed: float,
    approach: float = 0.0,
) -> Any:
    """Return whether the slip stops before the first separation, for arrays of angle and friction.

    The end touches the ground without load, slides to the left with `speed` and approaches with
    `approach` (m/s); the contact has F = K δ^1.5 with K = `constant`. Integrated by the classical
    Runge–Kutta method at a frozen angle, all runs at a time.
    """
    theta, mu = (np.asarray(x, float)[:, None] for x in (theta, mu))
    sin, cos = np.sin(theta), np.cos(theta)
    normal = modes.along(cos, sin)
    tangent = modes.along(-sin, cos)
    push = (normal + mu * tangent) / bar.mass
    load = -G * modes.weight * np.where(modes.across, cos, sin)
    stiff = modes.rates**2
    place = np.zeros_like(normal)
    # Translation alone has the velocity of the whole bar at the start.
    rate = modes.weight * np.where(
        modes.across, speed * sin - approach * cos, -speed * cos - approach * sin
    )
    stopped, touched = np.zeros(len(theta), bool), np.zeros(len(theta), bool)
    runs = np.arange(len(theta))

    def field(q: Any) -> Any:
        depth = np.maximum(-(normal * q).sum(axis=1, keepdims=True), 0.0)
        return push * (constant * depth * np.sqrt(depth)) - stiff * q + load

    for _ in range(round(WINDOW / STEP)):
        k1 = field(place)
        half = place + STEP / 2 * rate
        k2 = field(half)
        k3 = field(half + STEP**2 / 4 * k1)
        k4 = field(place + STEP * rate + STEP**2 / 2 * k2)
        place = place + STEP * rate + STEP**2 / 6 * (k1 + k2 + k3)
        rate = rate + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        pressed = (normal * place).sum(axis=1) < 0
        stops = pressed & ((tangent * rate).sum(axis=1) >= 0)
        stopped[runs[stops]] = True
        on = ~stops & (pressed | ~touched[runs])
        touched[runs[pressed]] = True
        if not on.all():
            runs = runs[on]
            normal, tangent, push, load = normal[on], tangent[on], push[on], load[on]
            place, rate = place[on], rate[on]
        if not len(runs):
            break
    return stopped


def landing(
    bar: Bar,
    counts: tuple[int, int],
    constant: float,
    angles: Sequence[float],
    speed: float,
    approach: float = 0.0,
    top: float = 2.5,
) -> list[float]:
    """Return the least friction of a landing at each angle, to 1e-4; infinite above `top`."""
    modes = Modes.of(bar, *counts)
    # Nothing grows below cot θ, but plain friction may stop a slow slip.
    low, high = np.full(len(angles), 0.02), np.full(len(angles), top)
    reaches = landings(bar, modes, constant, angles, high, speed, approach)
    points = 9
    while (high - low).max() > 1e-4:
        shares = np.linspace(0, 1, points + 2)[1:-1]
        grid = low[:, None] + (high - low)[:, None] * shares
        stops = landings(
            bar, modes, constant, np.repeat(angles, points), grid.ravel(), speed, approach
        ).reshape(grid.shape)
        first = np.where(stops.any(axis=1), stops.argmax(axis=1), points)
        edges = np.concatenate([low[:, None], grid, high[:, None]], axis=1)
        rows = np.arange(len(angles))
        low, high = edges[rows, first], edges[rows, first + 1]
    return [float(x) if reached else math.inf for x, reached in zip(high, reaches, strict=True)]


def coupling(bar: Bar, theta: float, stiffness: float) -> float:
    """Return the least friction from which deviations grow faster than 1/s, to 1e-5."""
    low, high = 0.9 / math.tan(theta), threshold(euler_bernoulli(bar), theta, stiffness)[0]
    while high - low > 1e-5:
        middle = (low + high) / 2
        root = growth(bar, COUPLED, theta, middle, stiffness, DAMPING)
        low, high = (low, middle) if root.real > 1 else (middle, high)
    return high


def study() -> dict[str, Any]:
    """Return every number."""
    bar = Bar()
    constant, stiffness = contact(G, bar.modulus, TIP, bar.poisson, **HERTZ)
    all_modes = euler_bernoulli(bar)
    landed = landing(bar, CONVERGED, constant, ANGLES, 1.0)
    rigid_landed = landing(bar, (0, 0), constant, ANGLES, 1.0)
    rows = [
        {
            "theta": theta,
            "cot": 1 / math.tan(theta),
            "coupling": coupling(bar, theta, stiffness),
            "landing": landed[i],
            "divergence": threshold(all_modes, theta, stiffness)[0],
            "rigid_contact": threshold(all_modes, theta)[0],
            "rigid_landing": rigid_landed[i],
            "rigid_rod": threshold(rigid(bar), theta)[0],
        }
        for i, theta in enumerate(ANGLES)
    ]
    speeds = [
        {"speed": v, "landing": landing(bar, COUPLED, constant, ANGLES, v)}
        | {"rigid": landing(bar, (0, 0), constant, ANGLES[:1], v)[0]}
        for v in SPEEDS
    ]
    modes = [
        {"bending": b, "axial": a, "landing": landing(bar, (b, a), constant, ANGLES, 1.0)}
        for b, a in COUNTS
    ]
    # An aluminium rod of 1 m and 6 mm with a hard tip, over a belt: docs/experiments.md.
    area = math.pi * 0.003**2
    bench = Bar(mass=2700 * area, length=1.0, density=2700, modulus=70e9, poisson=0.33)
    hard, _ = contact(1.0, bench.modulus, 0.003, bench.poisson, **HERTZ)
    belt = [
        {
            "theta": theta,
            "landing": landing(bench, CONVERGED, hard, [theta], 1.0, 0.1)[0],
            "rigid_landing": landing(bench, (0, 0), hard, [theta], 1.0, 0.1)[0],
        }
        for theta in (0.6, 1.2)
    ]
    return {
        "version": ps.__version__,
        "constant": constant,
        "stiffness": stiffness,
        "limit": [threshold(modal(bar, *COUPLED), theta)[0] for theta in ANGLES],
        "thresholds": rows,
        "speeds": speeds,
        "modes": modes,
        "belt": belt,
    }


@styled
def figure(data: dict[str, Any]) -> Figure:
    """Return the thresholds over the angle."""
    drawn = Figure(figsize=(COLUMN, 2.7), layout="constrained")
    axes = drawn.subplots()
    angles = [row["theta"] for row in data["thresholds"]]
    lines = {
        "cot": "$\\cot\\theta$",
        "coupling": "mode coupling",
        "landing": "landing, 1 m/s",
        "rigid_contact": "divergence, rigid contact",
        "rigid_landing": "rigid rod, landing",
        "rigid_rod": "rigid rod, divergence",
    }
    looks = zip([*PALETTE[:5], "0.55"], [*DASHES[:5], DASHES[0]], strict=True)
    for (name, label), (colour, dash) in zip(lines.items(), looks, strict=True):
        values = [row[name] for row in data["thresholds"]]
        axes.plot(angles, values, color=colour, linestyle=dash, label=label)
    axes.set(xlabel=axis_label(r"\theta", "rad"), ylabel=axis_label(r"\mu", "1"), ylim=(0, 2.3))
    legend_below(drawn, legend_entries([axes]))
    return drawn


def main() -> None:
    """Compute or read the numbers, and draw them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draw", action="store_true", help="draw the kept numbers")
    parser.add_argument("--out", type=Path, default=HERE, help="folder")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    if options.draw:
        data = json.loads((HERE / "elastic-bar.json").read_text("utf-8"))
    else:
        data = study()
        text = json.dumps(data, indent=1) + "\n"
        (options.out / "elastic-bar.json").write_text(text, "utf-8")
    write_figure(figure(data), options.out / "elastic-bar.png")


if __name__ == "__main__":
    main()
