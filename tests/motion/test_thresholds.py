"""Thresholds of friction and the work of drives, where a hand calculation says both exactly."""

from __future__ import annotations

import functools
import math

import pytest
import sympy as sp

from painleve_sym.laws.catalogue import law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.bodies import Body, Load
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import LagrangianSystem
from painleve_sym.motion.simulator import Simulator
from tests.mechanics.made_up import skew_block

NEAR = [0.995, 1.005]
"""Parts of a threshold on either side of it, nearer than a hundredth."""


def points(count: int, guided: bool = False) -> Mechanism:
    """Return points of 1 kg, each on (or in) a belt of its own, pushed along it and against it."""
    coordinates, bodies, loads, parameters = [], [], [], []
    push, press = Parameter("push", 0.0, "N", "along"), Parameter("press", 0.0, "N", "against")
    for i in range(1, count + 1):
        x, y = Coordinate(f"x_{i}", "place", "m"), Coordinate(f"y_{i}", "height", "m")
        place = (x.symbol, y.symbol)
        coordinates += [x, y]
        bodies.append(Body(sp.Integer(1), place))
        loads.append(Load.force(place, (push.symbol, -press.symbol)))
        parameters += [
            Parameter(f"mu_{i}", 0.5, "1", "friction coefficient", 0.0),
            Parameter(f"u_{i}", 0.0, "m/s", "speed of the belt"),
        ]
    system = LagrangianSystem.of_bodies(
        "points", coordinates, (push, press, *parameters), bodies, loads=loads
    )
    contacts = [
        Contact.of_point(
            str(i + 1),
            system,
            tuple(c.symbol for c in coordinates[2 * i : 2 * i + 2]),
            parameters[2 * i].symbol,
            surface_speed=parameters[2 * i + 1].symbol,
            bilateral=guided,
        )
        for i in range(count)
    ]
    return Mechanism("points", "points on belts", "a test", system, tuple(contacts))


@functools.cache
def simulator(count: int, name: str):
    own = law(name) if name == "linear" else RigidLaw()
    return Simulator(points(count, name == "guide"), own, "compiled")


@functools.cache
def skew(restitution: str):
    return Simulator(skew_block(), RigidLaw(restitution), "compiled")


# ---- the friction cone ----


@pytest.mark.parametrize("c", [0.8, -0.8])
@pytest.mark.parametrize("part", NEAR)
def test_impact_at_rest_sticks_up_to_the_edge_of_the_cone(part, c):
    """The impulse that sticking needs is |W_nt|/W_tt = |c|/(c² + d) of the normal one."""
    mu = part * abs(c) / (c**2 + 0.5)
    run = skew("energetic").run({"y_dot": -1.0}, t_end=1e-9, parameters={"c": c, "mu": mu, "g": 0})
    rays = [e.mode_after for e in run.events if e.mode_after.startswith("impact/")]
    slip = "slip_neg" if c > 0 else "slip_pos"
    assert rays[0] == f"impact/{slip if part < 1 else 'stick'}/compression"
    assert (run.final["x_dot"] == 0) is (part > 1)


@pytest.mark.parametrize("push", [1.0, -1.0])
@pytest.mark.parametrize("part", NEAR)
@pytest.mark.parametrize("name", ["rigid", "guide", "linear"])
@pytest.mark.parametrize("count", [1, 2])
def test_slip_that_stops_reverses_only_where_friction_cannot_hold_it(count, name, part, push):
    """Under the normal force N and the push P a point that has stopped sticks for P ≤ μ N."""
    press, speed, k = 2.0, 0.3, 1e4
    mu = part * abs(push) / press
    given = {"push": push, "press": press} | {f"mu_{i}": mu for i in range(1, count + 1)}
    depth = press / k if name == "linear" else 0.0
    if depth:
        given["k"] = k
    # A second point is faster, and slips on.
    state = {f"x_{i}_dot": -math.copysign(speed * i, push) for i in range(1, count + 1)}
    state |= {f"y_{i}": -depth for i in range(1, count + 1)}
    stop = speed / (abs(push) + mu * press)
    run = simulator(count, name).run(state, t_end=1.5 * stop, parameters=given)
    assert [e.time for e in run.events_of("slip_stop")] == pytest.approx([stop], rel=1e-9)
    assert not run.events_of("slip_start")
    rate = push - math.copysign(mu * press, push) if part < 1 else 0.0
    assert run.final["x_1_dot"] == pytest.approx(rate * 0.5 * stop, rel=1e-9, abs=1e-14)
    assert run.energy_residual < 1e-9


@pytest.mark.parametrize("push", [1.0, -1.0])
@pytest.mark.parametrize("part", NEAR)
@pytest.mark.parametrize("name", ["rigid", "guide", "linear"])
@pytest.mark.parametrize("count", [1, 2])
def test_point_at_rest_begins_to_slip_at_the_edge_of_the_cone(count, name, part, push):
    press, k = 2.0, 1e4
    mu = part * abs(push) / press
    given = {"push": push, "press": press} | {f"mu_{i}": mu for i in range(1, count + 1)}
    depth = press / k if name == "linear" else 0.0
    if depth:
        given["k"] = k
    run = simulator(count, name).run(
        {f"y_{i}": -depth for i in range(1, count + 1)}, t_end=0.1, parameters=given
    )
    assert run.final_time == 0.1
    assert part < 1 or not run.events_of("slip_start")
    rate = push - math.copysign(mu * press, push) if part < 1 else 0.0
    for i in range(1, count + 1):
        assert run.final[f"x_{i}_dot"] == pytest.approx(rate * 0.1, rel=1e-9, abs=1e-14)


# ---- belts ----


@pytest.mark.parametrize("count", [1, 2])
def test_impact_on_a_belt_takes_the_work_of_its_drive(count):
    """P_n = (1 + e) m |v_n| and P_t = −μ s P_n: the drive of a belt at u does the work u P_t."""
    e, mu, fall = 0.5, 0.2, 1.0
    given = {"e_energetic": e} | {f"mu_{i}": mu for i in (1, 2)[:count]}
    given |= {f"u_{i}": u for i, u in zip((1, 2)[:count], (2.0, -3.0), strict=False)}
    state = {f"y_{i}_dot": -fall for i in (1, 2)[:count]}
    run = simulator(count, "rigid").run(state, t_end=1e-9, parameters=given)
    P_t = mu * (1 + e) * fall
    assert run.final["x_1_dot"] == pytest.approx(P_t, rel=1e-12)
    work = P_t * (2.0 + 3.0 * (count == 2))
    assert run.final["force_dissipation"] == pytest.approx(-work, rel=1e-12)
    lost = run.final["friction_dissipation"] + run.final["contact_dissipation"]
    kinetic = count * (P_t**2 + (e * fall) ** 2 - fall**2) / 2
    assert kinetic + lost == pytest.approx(work, rel=1e-12)


# ---- what a law keeps when it lets go ----


@pytest.mark.parametrize("count", [1, 2])
def test_energy_left_in_a_released_dashpot_is_lost(count):
    """A spring with a dashpot lets go at k δ + c δ̇ = 0, still compressed: k δ²/2 is lost then."""
    k, c = 1e4, 60.0
    state = {f"y_{i}_dot": -1.0 for i in range(1, count + 1)}
    run = simulator(count, "linear").run(state, t_end=0.05, parameters={"k": k, "c": c})
    assert len(run.events_of("separation")) == count
    end = run.final["y_1_dot"]
    # δ̈ + c δ̇ + k δ = 0 by hand: the force vanishes before half a cycle is over.
    damp = c / 2
    omega = math.sqrt(k - damp**2)
    t = (math.pi - math.atan2(2 * damp * omega, omega**2 - damp**2)) / omega
    speed = -math.exp(-damp * t) * (math.cos(omega * t) - damp / omega * math.sin(omega * t))
    assert end == pytest.approx(speed, rel=1e-9)
    assert run.final["contact_dissipation"] == pytest.approx(count * (1 - end**2) / 2, rel=1e-9)
