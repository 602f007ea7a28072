"""Equations of modes and quantities of mechanisms as functions for other programs."""

from __future__ import annotations

import math
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
import sympy as sp

import painleve_sym as ps
from painleve_sym.at.delassus import Delassus
from painleve_sym.laws.compliance import ramp

QUADRUPED = Path(__file__).parents[2] / "examples" / "robots" / "quadruped.urdf"


def states_of(simulator, count):
    """Return states near the start, memory and parameters of a simulator."""
    rng, start = np.random.default_rng(7), simulator.begin(None)
    size = len(simulator.outline.memory_names)
    for _ in range(count):
        x = start.state + rng.uniform(-0.1, 0.1, len(start.state))
        x[1] = -1e-6 * rng.random()
        yield x, 1e-6 * rng.random(size), start.parameters


@pytest.mark.parametrize("law", ["bilinear-hertz", "hertz", "rigid"])
def test_functions_of_every_mode_are_those_of_the_engine(law):
    simulator = ps.Simulator("rod", law)
    for i, mode in enumerate(simulator.automaton.modes):
        own, plain = simulator.casadi(mode.name), simulator.lambdify(mode.name, "math")
        for x, z, p in states_of(simulator, 2):
            c = simulator.integrator.constants(p)
            expected = simulator.integrator.field(i, x, z, c)
            assert np.array(own.field(x, z, p)).ravel() == pytest.approx(expected, rel=1e-12)
            assert plain.field(x, z, p) == pytest.approx(expected, rel=1e-11, abs=1e-9)
            outputs = np.array(own.outputs(x, z, p)).ravel()
            assert plain.outputs(x, z, p) == pytest.approx(outputs, rel=1e-11, nan_ok=True)
            guards = np.array(own.guards(x, z, p)).ravel()
            assert plain.guards(x, z, p) == pytest.approx(guards, rel=1e-11, abs=1e-9)
            for label in own.targets:
                after = [np.array(v).ravel() for v in own.resets[label](x, z, p)]
                for one, other in zip(plain.resets[label](x, z, p), after, strict=True):
                    assert one == pytest.approx(other, rel=1e-11, abs=1e-12)
                holds = np.array(own.choices[label](x, z, p)).ravel()
                assert [bool(v) for v in plain.choices[label](x, z, p)] == holds.astype(
                    bool
                ).tolist()


def test_names_are_those_of_the_automaton():
    simulator = ps.Simulator("rod", "rigid")
    own = simulator.casadi("stick")
    assert own.states == simulator.outline.state_names
    assert own.memory == simulator.outline.memory_names
    assert own.parameters == simulator.outline.parameter_names
    assert own.output_names == simulator.outline.output_names
    for function in (own.field, own.guards, own.outputs, *own.resets.values()):
        assert function.name_in() == ["x", "z", "p"]
    assert own.resets["liftoff"].name_out() == ["x_plus", "z_plus"]
    assert own.targets["slip_neg"] == ("slip_neg", "flight")
    assert "stick" in repr(own) and len(repr(own)) < 300


def test_several_contacts_have_casadi_functions_alone():
    simulator = ps.Simulator("block-two-feet", "rigid")
    own, start = simulator.casadi("motion"), simulator.begin(None)
    z = np.zeros(len(own.memory))
    # Both feet open: a free flight.
    rates = np.array(own.field(start.state, z, start.parameters)).ravel()
    assert rates[own.states.index("y_A_dot")] < 0
    with pytest.raises(
        ps.InputError, match=r"linear systems of several contacts .* Fix: use casadi"
    ):
        simulator.lambdify("motion")


@pytest.mark.parametrize("method", ["casadi", "lambdify"])
def test_an_unknown_mode_names_those_that_there_are(method):
    simulator = ps.Simulator("rod", "rigid")
    with pytest.raises(ps.InputError, match=r"unknown mode 'slip'.*slip_neg"):
        getattr(simulator, method)("slip")
    with pytest.raises(ps.InputError, match="unknown mode"):
        getattr(simulator.automaton, method)("slip")


def test_an_unknown_library_names_those_that_there_are():
    with pytest.raises(ps.InputError, match=r"jax.*math.*mpmath.*numpy|numpy.*math"):
        ps.Simulator("rod", "rigid").lambdify("flight", "fortran")


def test_jax_differentiates_a_field():
    jax = pytest.importorskip("jax", reason="needs JAX")
    jax.config.update("jax_enable_x64", True)
    simulator = ps.Simulator("rod", "bilinear-hertz")
    mode = "slip_neg/compression"
    fast, own = simulator.lambdify(mode, "jax"), simulator.casadi(mode)
    ((x, z, p),) = states_of(simulator, 1)
    slope = jax.jacfwd(lambda x: jax.numpy.array(fast.field(x, z, p)))(x)
    X = ca.MX.sym("x", len(x))
    J = ca.jacobian(own.field(X, z, p), X)
    expected = np.array(ca.Function("J", [X], [J])(x))
    np.testing.assert_allclose(slope, expected, rtol=1e-10, atol=1e-9)


# ---- quantities of mechanisms ----


@pytest.mark.parametrize("name", ["rod", "block-two-feet", "rod-3d", "two-link-arm-3d"])
def test_quantities_are_those_of_the_contact_problem(name):
    mechanism = ps.model(name)
    place = mechanism.at({**mechanism.start, mechanism.state_names[-1]: 0.3})
    numbers = Delassus.of(mechanism).at(place.values)
    arguments = [*place.state.values()], [*place.parameters.values()]
    for quantity in ("W", "b", "gap", "gap_rate", "slip_velocity", "A_stick", "B_stick"):
        value = np.array(mechanism.casadi(quantity)(*arguments))
        expected = getattr(numbers, quantity)
        assert value.ravel() == pytest.approx(expected.ravel(), rel=1e-12, abs=1e-14)
    size = len(numbers.b) // len(numbers.mu)
    for i, mu in enumerate(numbers.mu):
        own = slice(size * i, size * (i + 1))
        answer = ps.contact(
            numbers.W[own, own],
            numbers.b[own],
            mu,
            numbers.v[own][1:] if size > 2 else numbers.v[own][1],
        )
        A, B = (float(mechanism.casadi(q)(*arguments)[i]) for q in ("A", "B"))
        assert pytest.approx((answer.A, answer.B), rel=1e-12) == (A, B)


def test_mass_matrix_and_forces_are_those_of_the_system():
    rod = ps.models.rod()
    place = rod.at({"theta": 1.0, "theta_dot": 2.0})
    arguments = [*place.state.values()], [*place.parameters.values()]
    M, h = (np.array(rod.casadi(name)(*arguments)) for name in ("M", "h"))
    s, c = math.sin(1.0), math.cos(1.0)
    # m = l = 1, J = 1/3 about the centre: M and h by hand.
    np.testing.assert_allclose(M, [[1, 0, -s], [0, 1, c], [-s, c, 4 / 3]], rtol=1e-15)
    np.testing.assert_allclose(h.ravel(), [4 * c, -9.8 + 4 * s, -9.8 * c], rtol=1e-14)


@pytest.mark.parametrize("frames", [("LF_foot", "free"), ("LF_foot,RF_foot", "stuck")])
def test_quantities_of_a_robot_are_those_of_its_contact(frames):
    foot = ps.robot(QUADRUPED).contact(frames[0], pose="standing", others=frames[1])
    place = foot.mechanism.at(None, {"mu": 0.8})
    arguments = [*place.state.values()], [*place.parameters.values()]
    numbers = Delassus.of(foot.mechanism).at(place.values)
    for quantity in ("W", "b", "A_stick", "B_stick"):
        value = np.array(foot.mechanism.casadi(quantity)(*arguments)).ravel()
        expected = getattr(numbers, quantity).ravel()
        assert value == pytest.approx(expected, rel=1e-10, abs=1e-12)
    mu_P = float(foot.mechanism.casadi("mu_P")(*arguments))
    assert mu_P == pytest.approx(foot.risk().mu_P, rel=1e-12)
    with pytest.raises(ps.InputError, match="unknown quantity 'M'"):
        foot.mechanism.casadi("M")


# ---- SymPy ----


@pytest.mark.parametrize(
    ("printer", "text"),
    [
        (sp.pycode, "max(0, y)**1.5"),
        (sp.ccode, "pow(fmax(0, y), 1.5)"),
        (sp.cxxcode, "std::pow(std::max(0, y), 1.5)"),
        (sp.jscode, "Math.pow(Math.max(0, y), 1.5)"),
        (sp.octave_code, "max(0, y).^1.5"),
        (sp.rust_code, "max(0, y).powf(1.5)"),
        (sp.mathematica_code, "Max[0, y]^1.5"),
    ],
)
def test_a_ramp_prints_in_every_language(printer, text):
    assert printer(ramp(sp.Symbol("y", real=True)) ** 1.5) == text


def test_a_ramp_is_the_greater_of_a_number_and_zero():
    y = sp.Symbol("y", real=True)
    assert ramp(y).rewrite(sp.Max) == sp.Max(0, y)
    assert sp.lambdify(y, ramp(y) ** 1.5)(np.array([-1.0, 4.0])).tolist() == [0.0, 8.0]


def test_descriptions_of_systems_and_automata_take_one_line():
    simulator = ps.Simulator("rod", "bilinear-hertz")
    automaton, rod = simulator.automaton, ps.models.rod()
    parts = [automaton, automaton.modes[2], automaton.modes[2].transitions[0], simulator.outline]
    for part in (*parts, rod.system, rod.outline):
        assert "\n" not in repr(part) and len(repr(part)) < 260
