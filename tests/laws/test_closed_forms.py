"""Closed forms of a mechanism as formulas: their values, and the Python module made of them."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import painleve_sym as ps
from painleve_sym.at.cases import contact_problem
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.laws.python_module import python_module
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import LagrangianSystem
from tests.mechanics.catalogue import derived

_STATE = {"x_A": 0.0, "y_A": 0.0, "y_A_dot": 0.0, "theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}


def _formulas(mechanism):
    return {f.name: f for section in ps.closed_forms(mechanism) for f in section.formulas}


def test_python_module_of_the_rod_agrees_with_the_contact_problem():
    rod = derived("rod")
    scope: dict = {}
    exec(python_module(rod), scope)
    values = {p.name: p.default for p in rod.system.parameters}
    problem = contact_problem(rod, _STATE, values)

    def evaluated(name):
        function = scope[name]
        known = {**_STATE, **values}
        names = function.__code__.co_varnames[: function.__code__.co_argcount]
        return function(**{n: known[n] for n in names})

    assert evaluated("A_neg") == pytest.approx(problem.A, rel=1e-13)
    assert evaluated("B") == pytest.approx(problem.B, rel=1e-13)


def _unit_body_in_a_corner():
    """Return a body of unit mass and inertia with two points over a floor and one at a wall."""
    x, y, theta = (Coordinate(n, "place", u) for n, u in (("x", "m"), ("y", "m"), ("phi", "rad")))
    mu = Parameter("mu", 0.3, "1", "friction of every contact", 0.0)
    rates = [c.rate for c in (x, y, theta)]
    energy = sp.Add(*(v**2 for v in rates)) / 2
    system = LagrangianSystem("corner", (x, y, theta), (mu,), energy, 10 * y.symbol)
    points = {
        "A": (y.symbol - theta.symbol, rates[0] + rates[2]),
        "B": (y.symbol + 2 * theta.symbol, rates[0] + rates[2]),
        "C": (x.symbol + theta.symbol / 2, rates[1] + rates[2]),
    }
    contacts = tuple(Contact(n, system, gap, slip, mu.symbol) for n, (gap, slip) in points.items())
    return Mechanism("corner", "body in a corner", "made for this test", system, contacts)


@pytest.mark.parametrize(
    "mechanism",
    [
        pytest.param(derived("block-two-feet"), marks=pytest.mark.slow),
        _unit_body_in_a_corner(),
    ],
)
def test_forms_of_sliding_contacts_make_every_normal_acceleration_zero(mechanism):
    forms, n = _formulas(mechanism), len(mechanism.contacts)
    values = {s: 0.3 for s in mechanism.system.symbols}
    values |= {p.symbol: p.default for p in mechanism.system.parameters}
    slips = [(-1, "neg"), (1, "pos"), (1, "pos")][:n]
    end = "_".join(name for _, name in slips)
    F = numbers([forms[f"F_n_{c.name}_{end}"].value for c in mechanism.contacts], values)
    W, b = (numbers(list(forms[name].value), values) for name in ("W", "b"))
    mu = [float(sp.sympify(c.friction).subs(values)) for c in mechanism.contacts]
    tangential = [-s * m * f for (s, _), m, f in zip(slips, mu, F, strict=True)]
    accelerations = W.reshape(2 * n, 2 * n) @ np.column_stack([F, tangential]).ravel() + b
    assert np.max(np.abs(b)) > 1
    assert accelerations[::2] == pytest.approx(np.zeros(n), abs=1e-12 * np.max(np.abs(b)))


def test_the_jump_of_a_contact_that_nothing_slides_is_a_normal_impact():
    x, y = (Coordinate(n, "place", "m") for n in "xy")
    mu = Parameter("mu", 0.3, "1", "friction", 0.0)
    energy = sp.Integer(2) * (x.rate**2 + y.rate**2) / 2
    system = LagrangianSystem("press", (x, y), (mu,), energy, sp.Integer(0))
    contact = Contact("A", system, y.symbol, sp.Integer(0), mu.symbol)
    press = Mechanism("press", "press", "made for this test", system, (contact,))
    jumps = [s for s in ps.closed_forms(press) if s.title.startswith("jump")]
    assert not jumps[0].phases
    assert "no motion slides the contact" in jumps[0].note
    compression, restitution = (section.phases[0].values for section in jumps[1:])
    v_n, v_n_plus = sp.Symbol("v_n", real=True), sp.Symbol("v_n_plus", nonnegative=True)
    assert compression["normal_impulse"] == -2 * v_n
    assert restitution["normal_impulse"] == 2 * v_n_plus
    for values in (compression, restitution):
        assert (values["tangential_impulse"], values["slip_velocity"]) == (0, 0)
        assert values["x_dot"] == x.rate
