"""For which directions of slip, and up to which azimuthal velocity, does the rod lose its answer?

Maps of `rod-3d` over elevation and direction of slip, whose borders A = 0 are compared with
cos β = μ_P(θ)/μ, and over elevation and azimuthal velocity, whose borders B = 0 are compared with
l sinθ (θ̇² + ψ̇² cos²θ) = g. Counts of the solutions of random contacts at rest.

Run: python examples/studies/paradox_in_space/paradox_in_space.py [--quick] [--out FOLDER] [--draw]
Writes paradox-in-space.json (the numbers), paradox-in-space.png and paradox-in-space.svg.
"""

from __future__ import annotations

import argparse
import json
import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

import painleve_sym as ps
from painleve_sym.present.style import COLUMN, DASHES, PAGE, PALETTE, REFERENCE, STYLE, save

ROD = ps.models.rod_3d(J_3=1e-9)
FRICTIONS = (1.34, 1.4, 1.6, 2.0, 3.0)
ELEVATION = (math.radians(20), math.radians(85))
RATE = 2.0  # of the elevation in the second map; rad/s


def sectors(points: int) -> list[dict[str, Any]]:
    """Return the border A = 0 over θ and the slip direction for each friction, and its error."""
    rows = []
    ranges = {"theta": ELEVATION, "slip_direction": (math.pi / 2, 3 * math.pi / 2)}
    for mu in FRICTIONS:
        regions = ps.region_map(
            ROD, ("theta", "slip_direction"), ranges=ranges, points=points, parameters={"mu": mu}
        )
        pieces = regions.curves["A"]
        theta, angle = pieces.reshape(-1, 2).T
        critical = (4 + np.tan(theta) ** 2) / (3 * np.tan(theta))
        error = float(np.abs(np.cos(angle - math.pi) - critical / mu).max())
        rows.append({"mu": mu, "pieces": np.round(pieces, 9).tolist(), "error": error})
    return rows


def turning(points: int) -> dict[str, Any]:
    """Return the map over θ and ψ̇ with slip at β = 0, its borders, and the error of B = 0."""
    regions = ps.region_map(
        ROD,
        ("theta", "psi_dot"),
        ranges={"theta": ELEVATION, "psi_dot": (0.0, 12.0)},
        points=points,
        state={"theta_dot": RATE, "x_A_dot": -1.0},
        parameters={"mu": 1.6},
    )
    theta, rate = regions.curves["B"].reshape(-1, 2).T
    error = np.sin(theta) * (RATE**2 + (rate * np.cos(theta)) ** 2) - 9.8
    return {
        "counts": regions.counts,
        "curves": {name: np.round(c, 9).tolist() for name, c in regions.curves.items()},
        "crossings": regions.crossings.tolist(),
        "error": float(np.abs(error).max()),
    }


def at_rest(count: int) -> dict[str, int]:
    """Return how many random contacts at rest have how many solutions."""
    rng, numbers = np.random.default_rng(0), Counter[int]()
    for _ in range(count):
        root = rng.normal(size=(3, 3)) * 10 ** rng.uniform(-1, 1, size=(3, 1))
        b, mu = rng.normal(size=3) * 10 ** rng.uniform(-1, 1, size=3), 10 ** rng.uniform(-2, 1.5)
        numbers[len(ps.contact(root @ root.T, b, mu).solutions())] += 1
    return {str(n): numbers[n] for n in sorted(numbers)}


def study(quick: bool) -> dict[str, Any]:
    """Return all numbers of the study."""
    points = 40 if quick else 120
    return {
        "computed": {"version": ps.__version__, "points": points},
        "sectors": sectors(points),
        "turning": turning(points),
        "at_rest": at_rest(200 if quick else 20_000),
        # The least azimuthal velocity beyond which A = B = 0 is nowhere, at sinθ = 1/√3.
        "psi_dot_m": math.sqrt(1.5 * math.sqrt(3) * 9.8),
    }


def joined(pieces: list[Any]) -> Any:
    """Return pieces of a curve as its two coordinates, with gaps where pieces do not meet."""
    left, chain = [np.array(piece) for piece in pieces], list[Any]()
    while left:
        piece = left.pop(0)
        line = [piece[0], piece[1]]
        while left:  # the next piece that begins or ends where the line ends
            ends = np.array(left)
            away = np.abs(ends - line[-1]).max(axis=2)
            k, side = np.unravel_index(np.argmin(away), away.shape)
            if away[k, side] > 1e-8:
                break
            line.append(left.pop(int(k))[1 - side])
        chain += [*line, np.full(2, np.nan)]
    return np.array(chain).T


def figure(data: dict[str, Any]) -> Figure:
    """Return the figure: sectors of the paradox, and the map over the azimuthal velocity."""
    with rc_context(STYLE):
        drawn = Figure(figsize=(PAGE, COLUMN * 0.85), layout="constrained")
        left, right = drawn.subplots(1, 2)
        for k, row in enumerate(data["sectors"]):
            color, dash = PALETTE[k % len(PALETTE)], DASHES[k % len(DASHES)]
            theta, angle = np.degrees(joined(row["pieces"]))
            label = rf"$\mu = {row['mu']:g}$"
            left.plot(theta, angle - 180, color=color, linestyle=dash, label=label)
        left.axhline(0, color=REFERENCE, linewidth=0.6)
        left.set(xlabel=r"elevation $\theta$ (°)", ylabel=r"direction of slip $\beta$ (°)")
        left.set(xlim=np.degrees(ELEVATION), ylim=(-125, 90), title=r"(a) $A < 0$ inside")
        left.legend(loc="lower center", ncols=3)
        names = {"A": r"$A = 0$", "B": r"$B = 0$"}
        for k, name in enumerate(names):
            theta, rate = joined(data["turning"]["curves"][name])
            right.plot(np.degrees(theta), rate, color=PALETTE[k], label=names[name])
        crossings = np.array(data["turning"]["crossings"]).reshape(-1, 2)
        right.plot(np.degrees(crossings[:, 0]), crossings[:, 1], "o", color=REFERENCE, markersize=3)
        for x, y, text in ((61, 2, "no solution"), (61, 9, "two solutions"), (30, 2, "slip")):
            right.annotate(text, (x, y), ha="center")
        right.annotate("lift-off", (30, 9), ha="center")
        right.set(xlabel=r"elevation $\theta$ (°)", ylabel=r"azimuthal velocity $\dot\psi$ (rad/s)")
        right.set(xlim=np.degrees(ELEVATION), ylim=(0, 12))
        right.set_title(rf"(b) $\mu = 1.6$, $\beta = 0$, $\dot\theta = {RATE:g}$ rad/s")
        right.legend(loc="upper left")
    return drawn


def main() -> None:
    """Compute, write the files, print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="coarse maps, few contacts")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder")
    parser.add_argument("--draw", action="store_true", help="draw the kept numbers again")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    kept = Path(__file__).with_name("paradox-in-space.json")
    data = json.loads(kept.read_text("utf-8")) if options.draw else study(options.quick)
    (options.out / "paradox-in-space.json").write_text(json.dumps(data) + "\n", "utf-8")
    save(figure(data), options.out / "paradox-in-space")
    print("mu    widest sector   largest error of cos(beta) = mu_P/mu")
    for row in data["sectors"]:
        widest = np.abs(np.array(row["pieces"])[..., 1] - math.pi).max()
        print(f"{row['mu']:4.2f}  ±{math.degrees(widest):6.2f} deg     {row['error']:.1e}")
    crossings = ", ".join(f"({a:.6f}, {b:.6f})" for a, b in data["turning"]["crossings"])
    print(f"A = B = 0 at (theta, psi_dot) = {crossings}")
    print(f"largest error of B = 0: {data['turning']['error']:.1e} m/s^2")
    counts = ", ".join(f"{n}: {count}" for n, count in data["at_rest"].items())
    print(f"solutions of random contacts at rest: {counts}")


if __name__ == "__main__":
    main()
