"""What becomes of a slip near A = B = 0: does the rod lift off, or does its contact jam?

A grid of slips of the slender rod (its end A sliding left at 30 m/s), each with A > 0 and a force
F = -B/A, followed by the rigid simulator until the contact opens or the slip runs into the singular
point. Below the friction 8/(3 sqrt 3) all of them lift off; above it those with F > F* jam.

Run: python examples/studies/singular_point/fates.py [--points N] [--out FOLDER]
Writes fates.png, fates.svg (figure) and fates.json (the numbers).
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import painleve_sym as ps
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.mechanics.paradox.singular_point import SingularPoint
from painleve_sym.present.style import COLUMN, DASHES, PAGE, PALETTE, REFERENCE, STYLE, save

SLIP = -30.0  # m/s: fast enough that the slip does not stop first
A_RANGE, F_RANGE = (1e-3, 0.3), (0.3, 3e3)  # of the starts: A m, and F in N
FRICTIONS = (1.45, 5 / 3)  # below and above 8/(3 sqrt 3) = 1.5396
FATES = {"until": "lifts off", "dynamic_jam": "jams"}
# A slip that lifts off within rounding of A = 0 ends there.
CLOSE = {"liftoff": "lifts off", "bounded": "stays bounded", "stop": "stops"}

ROD = ps.model("rod")
SIMULATOR = ps.Simulator(ROD, ps.law("rigid"))
POINT = SingularPoint(ROD.coefficients, slip=-1)
PARAMETERS = {p.name: p.default for p in ROD.system.parameters}


def value(expr: Any, state: dict[str, float], mu: float) -> float:
    """Return an expression of the rod at a state."""
    full = dict.fromkeys(ROD.state_names, 0.0) | state
    return float(numbers([expr], full | PARAMETERS | {"mu": mu})[0])


def root(f: Any, low: float, high: float) -> float:
    """Return the zero of f between low and high by bisection."""
    rising = f(high) > 0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if (f(middle) > 0) == rising else (middle, high)
    return (low + high) / 2


def singular_point(mu: float) -> dict[str, float]:
    """Return angle and angular velocity with A = B = 0, theta rising, and what happens there."""
    c = ROD.coefficients
    theta = root(lambda x: value(c.A(-1), {"theta": x}, mu), 0.05, math.atan(2.0))
    spin = root(lambda w: value(c.B, {"theta": theta, "theta_dot": w}, mu), 0.0, 50.0)
    at = {"theta": theta, "theta_dot": spin}
    forms = {
        "eigenvalue_A": POINT.eigenvalues[0],
        "eigenvalue_B": POINT.eigenvalues[1],
        "eigenvalue_ratio": POINT.eigenvalue_ratio,
        "force_exponent": POINT.force_exponent,
        "bounded_force": POINT.bounded_force,
    }
    return at | {name: value(form, at, mu) for name, form in forms.items()}


def start(mu: float, theta_end: float, A: float, force: float) -> dict[str, float]:
    """Return a slip short of the singular point with that A (in 1/m) and force."""
    c = ROD.coefficients
    theta = root(lambda x: value(c.A(-1), {"theta": x}, mu) - A, 0.05, theta_end)
    balance = lambda w: value(c.B, {"theta": theta, "theta_dot": w}, mu) + A * force  # noqa: E731
    return {"theta": theta, "theta_dot": root(balance, 0.0, 50.0), "x_A_dot": SLIP}


def fates(mu: float, points: int) -> list[dict[str, Any]]:
    """Return the fate of every slip of the grid."""
    slips, end = [], singular_point(mu)["theta"]
    for A in np.geomspace(*A_RANGE, points):
        for force in np.geomspace(*F_RANGE, points):
            # B = -A F needs theta_dot^2 > 0.
            if A * force >= 0.99 * PARAMETERS["g"]:
                continue
            state = start(mu, end, float(A), float(force))
            run = SIMULATOR.run(state, t_end=2.0, parameters={"mu": mu}, until="liftoff")
            limit, reason = run.limit, run.stop_reason.label
            close = CLOSE.get(limit.kind.value) if limit else None
            slips.append(
                {
                    "A": float(A),
                    "force": float(force),
                    "fate": close or FATES.get(reason, reason),
                    "time": limit.time if limit else run.final_time,
                    "measured_exponent": limit.measured_exponent if limit else None,
                }
            )
    return slips


def path(mu: float, A: float, force: float) -> tuple[Any, Any]:
    """Return A and F along a slip."""
    state = start(mu, singular_point(mu)["theta"], A, force)
    run = SIMULATOR.run(state, t_end=2.0, parameters={"mu": mu}, until="liftoff")
    times = run.fine_times(6)
    mobility = [value(ROD.coefficients.A(-1), {"theta": float(x)}, mu) for x in run(times)[:, 2]]
    return np.array(mobility), run.values("normal_force", times)


def draw_fates(axes: Axes, mu: float, slips: list[dict[str, Any]], point: dict[str, float]) -> None:
    """Draw starts by fate, some slips, and the bounded force, over A and F."""
    for force in np.geomspace(0.3, 25, 9):
        mobility, forces = path(mu, A_RANGE[1], float(force))
        keep = (mobility > 0) & (forces > 0)
        name = "paths of slips" if force < 0.31 else "_"
        axes.plot(mobility[keep], forces[keep], color=REFERENCE, linewidth=0.6, label=name)
    looks = {"lifts off": (PALETTE[1], "o", "none"), "jams": (PALETTE[2], "s", PALETTE[2])}
    for fate, (color, symbol, face) in looks.items():
        dots = [f for f in slips if f["fate"] == fate]
        x, y = [d["A"] for d in dots], [d["force"] for d in dots]
        style = {"color": color, "markerfacecolor": face, "markersize": 2.6, "markeredgewidth": 0.6}
        if dots:
            axes.plot(x, y, symbol, linestyle="none", label=f"{fate}: {len(dots)}", **style)
    if point["bounded_force"] > 0:
        text = f"$F^* = {point['bounded_force']:.3g}$ N"
        axes.axhline(point["bounded_force"], color="black", linestyle=DASHES[1], label=text)
    axes.set(xscale="log", yscale="log", xlim=(7e-4, 0.5), ylim=(0.1, 1e5), xlabel="$A$ (1/kg)")
    axes.legend(loc="upper right")


def exponents(points: int) -> list[dict[str, float]]:
    """Return exponents measured in jams over friction, with the closed form."""
    jams = []
    for mu in np.linspace(1.56, 3.0, points):
        point = singular_point(float(mu))
        state = start(float(mu), point["theta"], 0.02, 4 * point["bounded_force"])
        run = SIMULATOR.run(state, t_end=2.0, parameters={"mu": float(mu)}, until="liftoff")
        if run.limit is not None and run.limit.measured_exponent is not None:
            measured = run.limit.measured_exponent
            jams.append({"mu": float(mu), "exponent": measured} | point)
    return jams


def figure(data: dict[str, Any]) -> Figure:
    """Return the figure: fates below and above the threshold, exponent over friction."""
    with rc_context(STYLE):
        drawn = Figure(figsize=(PAGE, COLUMN * 0.85), layout="constrained")
        left, middle, right = drawn.subplots(1, 3)
        for axes, case in zip((left, middle), data["cases"], strict=True):
            draw_fates(axes, case["mu"], case["slips"], case["point"])
            letter, ratio = "ab"[axes is middle], case["point"]["eigenvalue_ratio"]
            axes.set_title(rf"({letter}) fates, $\mu = {case['mu']:.4g}$, $r = {ratio:.3g}$")
        left.set_ylabel("$F = -B/A$ (N)")
        mu = np.linspace(4 / 3 + 1e-4, 3.0, 120)
        closed = [singular_point(float(x))["force_exponent"] for x in mu]
        right.plot(mu, closed, color="black", label=r"$\gamma = 1 - r$, $r = -\beta_1/\alpha$")
        x = [e["mu"] for e in data["exponents"]]
        y = [e["exponent"] for e in data["exponents"]]
        right.plot(x, y, "o", color=PALETTE[2], markersize=3, label="measured in jams")
        right.axvline(data["threshold"], color=REFERENCE, linestyle=DASHES[1])
        right.axhline(0, color=REFERENCE, linewidth=0.5)
        right.text(data["threshold"] + 0.04, -0.85, r"$\mu_C = 8/(3\sqrt{3})$")
        right.set(
            xlabel=r"$\mu$", ylabel=r"exponent $\gamma$", ylim=(-1, 1),
            title=r"(c) $F - F^* \sim (t^*-t)^{-\gamma}$",
        )  # fmt: skip
        right.legend(loc="lower right", bbox_to_anchor=(1, 0.16))
    return drawn


def study(points: int) -> dict[str, Any]:
    """Return all numbers of the study."""
    (threshold,) = POINT.thresholds("theta")
    cases = [
        {"mu": mu, "point": singular_point(mu), "slips": fates(mu, points)} for mu in FRICTIONS
    ]
    return {
        "computed": {"version": ps.__version__, "law": "rigid"},
        "mechanism": ROD.name,
        "parameters": PARAMETERS,
        "threshold": float(threshold.friction),
        "threshold_closed_form": str(threshold.friction),
        "cases": cases,
        "exponents": exponents(points),
    }


def main() -> None:
    """Compute, write the files, print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=14, help="starts along each axis")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder")
    parser.add_argument("--draw", action="store_true", help="draw the kept numbers again")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    kept = Path(__file__).with_name("fates.json")
    data = json.loads(kept.read_text("utf-8")) if options.draw else study(options.points)
    (options.out / "fates.json").write_text(json.dumps(data, indent=1) + "\n", "utf-8")
    save(figure(data), options.out / "fates")
    print(f"threshold {data['threshold_closed_form']} = {data['threshold']:.6f}")
    print("  mu      theta_1  eigenvalues        r      gamma   F* [N]   slips  lift off  jam")
    for case in data["cases"]:
        p, slips = case["point"], case["slips"]
        counts = [sum(s["fate"] == fate for s in slips) for fate in FATES.values()]
        print(
            f"  {case['mu']:.4f}  {math.degrees(p['theta']):6.3f}  "
            f"{p['eigenvalue_A']:7.3f} {p['eigenvalue_B']:7.3f}  {p['eigenvalue_ratio']:6.4f} "
            f"{p['force_exponent']:7.4f} {p['bounded_force']:8.3f}   {len(slips):4d} "
            f"{counts[0]:8d} {counts[1]:5d}"
        )
    worst = max(abs(e["exponent"] - e["force_exponent"]) for e in data["exponents"])
    print(f"exponents measured in {len(data['exponents'])} jams agree to {worst:.1e}")


if __name__ == "__main__":
    main()
