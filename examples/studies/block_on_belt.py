"""A block sticks to a belt and slips back: which cycle has each friction curve?

A spring holds the block. It moves with the belt until friction at rest no longer bears the spring,
then slips back and sticks again: a limit cycle, which motions from inside and outside reach within
one turn. Three curves have the same friction at rest and in fast slip; the period of each is
compared with an independent integration by SciPy, that of the two constants with its closed form.

`... block_on_belt.py STEM` draws the phase plane to STEM.png and STEM.svg. SI units.
"""

import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

import painleve_sym as ps
from painleve_sym.mechanics.friction import SLIP_VELOCITY
from painleve_sym.present.style import DASHES, PAGE, PALETTE, REFERENCE, STYLE, save

BELT = ps.model("block-on-belt")
U, D, LEAST = 0.2, 3.0, 0.4
Curve = Callable[[float], float]


def with_friction(name: str, slip: object) -> ps.Mechanism:
    """Return the block on the belt with another friction in slip, and mu_s at rest."""
    c = BELT.contact
    mu_s = next(p.symbol for p in BELT.system.parameters if p.name == "mu_s")
    own = (c.name, c.system, c.gap, c.slip_velocity, slip)
    contact = ps.Contact(*own, geometry=c.geometry, static_friction=mu_s)
    return ps.Mechanism(name, BELT.title, BELT.source, c.system, (contact,), shapes=BELT.shapes)


def curves() -> dict[str, tuple[ps.Mechanism, Curve]]:
    """Return mechanisms with their friction in slip as a function of the speed."""
    import sympy as sp

    v = abs(SLIP_VELOCITY)
    return {
        "falls to zero": (BELT, lambda w: 1 / (1 + D * w)),
        "falls to 0.4": (
            with_friction("exponential", LEAST + (1 - LEAST) * sp.exp(-v / sp.Rational(1, 10))),
            lambda w: LEAST + (1 - LEAST) * math.exp(-w / 0.1),
        ),
        "0.4 in slip": (with_friction("constants", sp.Float(LEAST)), lambda w: LEAST),
    }


def cycle(run: ps.Trajectory) -> tuple[float, float]:
    """Return period and time of slip of the last whole cycle; s."""
    starts, stops = (run.events_of(kind) for kind in ("slip_start", "slip_stop"))
    begin, end = starts[-2].time, starts[-1].time
    (stop,) = (e.time for e in stops if begin < e.time < end)
    return end - begin, stop - begin


def by_scipy(mu: Curve) -> tuple[float, float]:
    """Return the same of the equation of slip, x'' = mu(u - x') - x, up to x' = u."""

    def stops(_: float, z: np.ndarray) -> float:
        return float(z[1] - U)

    stops.terminal, stops.direction = True, 1  # type: ignore[attr-defined]
    way = solve_ivp(
        lambda _, z: [z[1], mu(U - z[1]) - z[0]],
        (0, 30),
        [1.0, U],
        method="DOP853",
        rtol=1e-13,
        atol=1e-15,
        max_step=0.05,
        events=stops,
    )
    slip, (x, _) = way.t_events[0][-1], way.y_events[0][-1]
    return float(slip), float(slip + (1.0 - x) / U)


def figure(mechanisms: dict[str, ps.Mechanism]) -> Figure:
    """Return the phase plane: the limit cycle of each curve, two motions that reach the first."""
    with rc_context(STYLE):
        drawn = Figure(figsize=(PAGE, 0.6 * PAGE), layout="constrained")
        axes = drawn.subplots()
        first = next(iter(mechanisms.values()))
        for label, (x, x_dot) in {"two motions": (0.5, -0.1), "_": (-1.4, 0.0)}.items():
            run = ps.simulate(first, "rigid", {"x": x, "x_dot": x_dot}, t_end=9.0)
            t = np.linspace(0, run.final_time, 2000)
            grey = {"color": REFERENCE, "linewidth": 0.8, "label": label}
            axes.plot(run.values("x", t), run.values("x_dot", t), **grey)
        for i, (name, mechanism) in enumerate(mechanisms.items()):
            run = ps.simulate(mechanism, "rigid", {"x_dot": U}, t_end=30.0)
            begin, end = (event.time for event in run.events_of("slip_start")[-2:])
            t = np.linspace(begin, end, 2000)
            style = {"color": PALETTE[i + 1], "linestyle": DASHES[i]}
            axes.plot(run.values("x", t), run.values("x_dot", t), label=name, **style)
        axes.set(xlabel="$x$ (m)", ylabel=r"$\dot x$ (m/s)")
        axes.legend(title="friction in slip")
        axes.set_title("limit cycles; on the level part the block sticks to the belt")
    return drawn


OWN = curves()
print("friction in slip   period [s]       slip [s]         SciPy            SciPy")
for name, (mechanism, mu) in OWN.items():
    period, slip = cycle(ps.simulate(mechanism, "rigid", {"x_dot": U}, t_end=40.0, rtol=1e-12))
    other_slip, other = by_scipy(mu)
    print(f"{name:17s}  {period:.12f}  {slip:.12f}  {other:.12f}  {other_slip:.12f}")
fall = 1 - LEAST
closed = 2 * fall / U + 2 * (math.pi - math.atan(fall / U))
print(f"0.4 in slip, closed form: {closed:.12f} s")
if len(sys.argv) > 1:
    save(figure({name: mechanism for name, (mechanism, _) in OWN.items()}), Path(sys.argv[1]))
