"""Impacts of mechanisms: Kane's double pendulum, stiff contacts, the page's examples."""

from __future__ import annotations

import itertools
import math
import re
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from painleve_sym.at.jump import evaluate_jump
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.mechanics.system import LagrangianSystem
from painleve_sym.motion.simulator import Simulator
from painleve_sym.problem.impact.one_contact import ImpactEnd
from tests.mechanics.made_up import positive
from tests.support.paper_law import paper_law

LAWS = sorted(RESTITUTIONS)
PAGE = Path(__file__).resolve().parents[2] / "docs" / "impacts.md"

# ---- Kane's double pendulum ----


def double_pendulum() -> Mechanism:
    """Return two equal uniform rods, hanging and hinged, whose lower tip hits rough ground."""
    a, b = (Coordinate(n, f"angle of rod {n} from the vertical", "rad") for n in ("a", "b"))
    m, l = positive("m", 1.0, "kg", "mass of a rod"), positive("l", 1.0, "m", "length of a rod")
    h = positive("h", 1.8057, "m", "height of the pivot")
    g, mu = (
        Parameter("g", 9.81, "m/s^2", "gravity", 0.0),
        Parameter("mu", 0.7, "1", "friction", 0.0),
    )

    def along(q):
        return sp.Matrix([sp.sin(q), -sp.cos(q)]) * l.symbol

    elbow = along(a.symbol)
    centres = (elbow / 2, elbow + along(b.symbol) / 2)
    tip = elbow + along(b.symbol)
    q, v = (a.symbol, b.symbol), sp.Matrix([a.rate, b.rate])
    speeds = [c.jacobian(q) * v for c in centres]
    kinetic = sum(m.symbol * s.dot(s) / 2 for s in speeds)
    kinetic += m.symbol * l.symbol**2 / 12 * (a.rate**2 + b.rate**2) / 2
    potential = sum(m.symbol * g.symbol * c[1] for c in centres)
    system = LagrangianSystem(
        "double pendulum", (a, b), (m, l, h, g, mu), sp.expand(kinetic), potential
    )
    contact = Contact.of_point("tip", system, (tip[0], h.symbol + tip[1]), mu.symbol)
    source = "Kane & Levinson (1985)"
    return Mechanism("double pendulum", "two hinged rods over ground", source, system, (contact,))


KANE = {"a": math.radians(20), "b": math.radians(30), "a_dot": -1.0, "b_dot": -2.0}


@pytest.mark.slow
def test_double_pendulum_gains_energy_by_newtons_law_only():
    pendulum, e, gain = double_pendulum(), 0.5, {}
    before = _kinetic(pendulum, KANE)
    for rule in LAWS:
        jump = evaluate_jump(pendulum, rule, KANE, parameters={f"e_{rule}": e})
        assert jump.case is ImpactClass.R_STICKING
        after = _kinetic(pendulum, KANE | dict(jump.velocity))
        assert jump.energy_change == pytest.approx(after - before, rel=1e-12)
        # Two coordinates: the end's velocities (0, v_n) are all there is to know.
        rebound = jump.phases[-1].normal_velocity
        assert after == pytest.approx(rebound**2 / (2 * _sticking_rate()), rel=1e-12)
        gain[rule] = jump.energy_change / before
    # As the page says.
    assert {r: round(100 * g) for r, g in gain.items()} == {
        "newton": 59,
        "poisson": -48,
        "energetic": -47,
    }


def _sticking_rate():
    """Return A′ = det W/W_tt of the pendulum, from its mass matrix and Jacobian in numbers."""
    a, b = KANE["a"], KANE["b"]
    coupling = math.cos(a - b) / 2
    mass = np.array([[4 / 3, coupling], [coupling, 1 / 3]])
    jacobian = np.array([[math.cos(a), math.cos(b)], [math.sin(a), math.sin(b)]])
    mobility = jacobian @ np.linalg.inv(mass) @ jacobian.T
    return np.linalg.det(mobility) / mobility[0, 0]


def _kinetic(mechanism, state):
    system = mechanism.system
    values = {p.symbol: p.default for p in system.parameters}
    values |= {s: state[s.name] for s in (*system.q, *system.q_dot)}
    return float(system.kinetic_energy.subs(values))


# ---- the compliant contact as the limit of growing stiffness ----

SOFTENED = {
    "slides": ({"theta": 0.2, "x_A_dot": -1.0, "y_A_dot": -1.0}, 0.2, ImpactClass.SLIDING),
    "sticks late": ({"theta": 0.9, "x_A_dot": -1.1, "y_A_dot": -1.0}, 0.8, ImpactClass.R_STICKING),
    "turns": ({"theta": 0.5, "x_A_dot": 0.3, "y_A_dot": -1.0}, 0.3, ImpactClass.C_REVERSED),
    "turns late": ({"theta": 0.5, "x_A_dot": 0.75, "y_A_dot": -1.0}, 0.3, ImpactClass.R_REVERSED),
    "starts at rest": ({"theta": 1.0, "y_A_dot": -1.0}, 1.4, ImpactClass.C_STICKING),
    "sticks": ({"theta": 1.0, "x_A_dot": -1.0, "y_A_dot": -1.0}, 1.4, ImpactClass.C_STICKING),
}


@pytest.fixture(scope="module")
def softened():
    return Simulator(rod(), paper_law(), "compiled")


@pytest.mark.parametrize("name", sorted(SOFTENED))
def test_impact_is_the_limit_of_stiff_softened_contacts(softened, name):
    state, mu, case = SOFTENED[name]
    state = {"theta_dot": 0.5, **state}
    rule = evaluate_jump(rod(), "energetic", state, parameters={"mu": mu})
    assert rule.case is case
    errors = []
    for E in (20.9e10, 20.9e16):
        run = softened.run(
            state, t_end=1.0, parameters={"mu": mu, "E": E}, until="separation", record="events"
        )
        last = run.events_of("separation")[0].state
        errors.append(max(abs(last[n] - v) for n, v in rule.velocity.items()))
    # With a collision the dropped impulses last as long as the contact, ∝ E^(−1/(n+1)) = 1/148.
    assert errors[1] < 3e-5
    assert errors[1] < errors[0] / 50


# ---- the page ----


def test_page_examples_run_and_print_what_they_say(capsys):
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert blocks
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
        expected = re.findall(r"# -> (.*)", block)
        printed = capsys.readouterr().out.splitlines()
        assert printed == expected


def test_page_names_every_class_and_end():
    text = PAGE.read_text(encoding="utf-8")
    for member in itertools.chain(ImpactClass, ImpactEnd):
        assert f"`{member.name}`" in text
