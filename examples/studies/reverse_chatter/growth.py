"""When do bounces of a contact at rest grow instead of dying out?

A cart with a pendulum (phi = 2.9 rad) is pushed by a force of -10 N. Its contact can stick, yet a
bounce of 1e-8 m/s grows to a visible one. Ratio of successive bounces: with W and b of the rest,
and of rigid runs.

Run: python examples/studies/reverse_chatter/growth.py [--points N] [--out FOLDER]
Writes growth.png, growth.svg (figure) and growth.json (the numbers).
"""

from __future__ import annotations

import argparse
import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

import painleve_sym as ps
from painleve_sym.present.style import COLUMN, DASHES, PAGE, PALETTE, REFERENCE, STYLE, save
from painleve_sym.problem.impact.chatter import chatter

LAWS = ("poisson", "energetic", "newton")
NAMES = {"poisson": "Poisson", "energetic": "energetic", "newton": "Newton"}
STATE, PUSH = {"phi": 2.9}, {"F": -10.0}
CART = ps.model("cart-pendulum")


@cache
def frozen(law: str, e: float) -> Any:
    """Return the bounces with W and b of the cart at rest."""
    cart = ps.classify(CART, STATE, parameters=PUSH)
    return chatter(cart.problem, law, e)


@cache
def simulator(law: str) -> ps.Simulator:
    """Return the rigid cart with a restitution law, made once."""
    return ps.Simulator(CART, ps.law("rigid", restitution=law))


def speeds(law: str, e: float, t_end: float) -> tuple[Any, Any, Any]:
    """Return times and approach speeds of the bounces of a rigid run, and the run."""
    parameters = PUSH | {f"e_{law}": e}
    run = simulator(law).run(STATE | {"y_dot": 1e-8}, t_end=t_end, parameters=parameters)
    landings = run.events_of("touchdown")
    return [x.time for x in landings], [-x.state["y_dot"] for x in landings], run


def study(points: int) -> dict[str, Any]:
    """Return all numbers of the study."""
    computed = {"version": ps.__version__, "law": f"rigid, with restitution {', '.join(LAWS)}"}
    numbers: dict[str, Any] = {
        "computed": computed, "mechanism": CART.name, "state": STATE, "push": PUSH, "laws": {}
    }  # fmt: skip
    for law in LAWS:
        rows = []
        for e in np.linspace(0.2, 1.0, points):
            _, v, _ = speeds(law, float(e), 5e-8)
            rows.append(
                {"e": float(e), "measured": v[2] / v[1], "expected": frozen(law, float(e)).ratio}
            )
        threshold = frozen(law, 0.75).threshold or 1.0
        numbers["laws"][law] = {"threshold": threshold, "ratios": rows}
    times, v, run = speeds("energetic", 0.75, 0.2)
    (chatter,) = run.reverse_chatter
    numbers["run"] = {
        "times": times,
        "speeds": v,
        "ratio": chatter.ratio,
        "bounces": chatter.bounces,
    }
    return numbers


def figure(data: dict[str, Any]) -> Figure:
    """Return the figure: one run, and the ratio over the restitution for three laws."""
    with rc_context(STYLE):
        drawn = Figure(figsize=(PAGE, COLUMN * 0.8), layout="constrained")
        left, right = drawn.subplots(1, 2)
        run = data["run"]
        left.plot(run["times"], run["speeds"], "o", color=PALETTE[2], markersize=2.5)
        left.set(xscale="log", yscale="log", title="(a) energetic restitution, $e = 0.75$")
        left.set(xlabel="time of touchdown (s)", ylabel="approach speed (m/s)")
        for law, color, dash in zip(LAWS, PALETTE, DASHES, strict=False):
            rows = data["laws"][law]["ratios"]
            e = np.linspace(0.2, 1.0, 41)
            expected = [frozen(law, float(x)).ratio for x in e]
            right.plot(e, expected, color=color, linestyle=dash, label=NAMES[law])
            measured = [r["measured"] for r in rows]
            right.plot([r["e"] for r in rows], measured, "o", color=color, markersize=3)
        right.axhline(1, color=REFERENCE, linewidth=0.6)
        right.set(xlabel="coefficient of restitution", ylabel="ratio of bounces")
        right.set_title("(b) lines: $W$ and $b$ of the rest, dots: rigid runs")
        right.legend(loc="upper left")
    return drawn


def main() -> None:
    """Compute, write the files, print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=9, help="coefficients of restitution")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder")
    parser.add_argument("--draw", action="store_true", help="draw the kept numbers again")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    kept = Path(__file__).with_name("growth.json")
    data = json.loads(kept.read_text("utf-8")) if options.draw else study(options.points)
    (options.out / "growth.json").write_text(json.dumps(data, indent=1) + "\n", "utf-8")
    save(figure(data), options.out / "growth")
    print("law        threshold  largest relative difference of measured and expected ratio")
    for law, entry in data["laws"].items():
        worst = max(abs(r["measured"] / r["expected"] - 1) for r in entry["ratios"])
        print(f"{law:10s} {entry['threshold']:9.6f}  {worst:.1e}")
    run = data["run"]
    print(f"energetic, e = 0.75: {run['bounces']} bounces from 1e-8 to {run['speeds'][-1]:.3g} m/s")


if __name__ == "__main__":
    main()
