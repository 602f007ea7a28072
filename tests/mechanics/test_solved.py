"""Accelerations solved for step by step, against NumPy and Lagrange's equations at numbers."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.mechanics.bodies import Body, Spring
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.solved import (
    MOST_VELOCITIES,
    SolvedMotion,
    bias_force,
    is_solved,
    solved_motion,
)
from painleve_sym.mechanics.system import TIME, LagrangianSystem


def chain(links: int, driven: bool = False) -> Mechanism:
    """Return a chain whose tip may touch a wall; its pivot may move as prescribed."""
    q = [Coordinate(f"q{i}", "angle", "rad") for i in range(links)]
    names = {"m": "kg", "l": "m", "J": "kg m^2", "g": "m/s^2", "k": "N/m", "mu": "1"}
    p = {n: Parameter(n, 1.0, unit, n, 0.0, lower_closed=False) for n, unit in names.items()}
    m, length, J, g, k, mu = (p[n].symbol for n in names)
    place, bodies = sp.Matrix([sp.sin(3 * TIME) / 5 if driven else 0, 0]), []
    for c in q:
        along = length * sp.Matrix([sp.sin(c.symbol), -sp.cos(c.symbol)])
        bodies.append(Body(m, tuple(place + along / 2), J, c.symbol))
        place += along
    spring = Spring(q[0].symbol - q[-1].symbol, k, damping=k / 3)
    system = LagrangianSystem.of_bodies(
        "chain", q, [*p.values()], bodies, gravity=g, springs=[spring]
    )
    contact = Contact.of_point("tip", system, tuple(place), friction=mu)
    return Mechanism("chain", "hanging chain", "made for this test", system, (contact,))


def numbers(system: LagrangianSystem) -> dict[sp.Symbol, sp.Expr]:
    symbols = sorted({*system.symbols, *system.clock}, key=str)
    drawn = np.random.default_rng(4).uniform(0.3, 1.2, len(symbols))
    return {s: sp.Float(v, 30) for s, v in zip(symbols, drawn.tolist(), strict=True)}


def lagrange(system: LagrangianSystem, point) -> np.ndarray:
    """Return h at a point by Lagrange's equations, as they come."""
    T, V, q, u = system.kinetic_energy, system.potential_energy, system.q, system.q_dot
    momenta = [sp.diff(T, v) for v in u]
    rows = []
    for i, p in enumerate(momenta):
        moved = sum((sp.diff(p, s) * rate for s, rate in system.rates.items()), sp.Integer(0))
        force = system.generalized_forces.get(q[i].name, 0)
        rows.append(float((sp.diff(T - V, q[i]) - moved + force).xreplace(point)))
    return np.array(rows)


def values(motion: SolvedMotion, point) -> dict[str, float]:
    known = dict(point)
    for symbol, step in motion.steps.items():
        known[symbol] = step.xreplace(known)
    return {s.name: float(v) for s, v in known.items()}


@pytest.mark.parametrize("driven", [False, True])
def test_steps_are_those_of_the_linear_system(driven):
    mechanism = chain(4, driven)
    system, (contact,) = mechanism.system, mechanism.contacts
    point, motion = numbers(system), solved_motion(mechanism)
    assert motion is not None
    own = values(motion, point)
    momenta = sp.Matrix([sp.diff(system.kinetic_energy, v) for v in system.q_dot])
    M, J = (
        np.array(e.xreplace(point)).astype(float)
        for e in (momenta.jacobian(system.q_dot), contact.J)
    )
    a, D = np.linalg.solve(M, lagrange(system, point)), np.linalg.solve(M, J.T)
    biases = np.array(contact.biases.xreplace(point)).astype(float).ravel()
    near = {"rtol": 1e-12, "atol": 1e-13}
    np.testing.assert_allclose([own[f"a_{i + 1}_1"] for i in range(4)], a, **near)
    for r in range(2):
        np.testing.assert_allclose([own[f"D_{i + 1}_{r + 1}"] for i in range(4)], D[:, r], **near)
    W = [own[n] for n in ("W_1_1", "W_1_2", "W_2_2")]
    np.testing.assert_allclose(W, (J @ D)[[0, 0, 1], [0, 1, 1]], **near)
    np.testing.assert_allclose([own["b_1_1"], own["b_2_1"]], J @ a + biases, **near)


def test_the_bias_force_of_bodies_is_that_of_lagranges_equations():
    for driven in (False, True):
        system = chain(3, driven).system
        point = numbers(system)
        by_bodies = np.array(bias_force(system).xreplace(point)).astype(float).ravel()
        np.testing.assert_allclose(by_bodies, lagrange(system, point), rtol=1e-12, atol=1e-13)


def test_what_is_short_in_closed_form_is_not_solved_for():
    assert not is_solved(chain(MOST_VELOCITIES))
    assert is_solved(chain(MOST_VELOCITIES + 1))


def test_modes_of_a_bar_do_not_meet_in_the_elimination():
    """Eliminated first, each has entries with the frame alone; the other order takes 105 steps."""
    assert len(solved_motion(model("rod-bending:4,3")).steps) <= 99
