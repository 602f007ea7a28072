"""The registry of quantities: units of derived names, LaTeX of symbols, agreement with engines."""

from __future__ import annotations

import pytest

from painleve_sym.laws.catalogue import one_law
from painleve_sym.motion.simulator import Simulator
from painleve_sym.quantities import (
    QUANTITIES,
    axis_label,
    derivative_latex,
    quantity,
    roundest,
    symbol_latex,
    unit_of,
)
from tests.mechanics.catalogue import derived


@pytest.mark.parametrize("name", ["rod", "block-two-feet"])
def test_every_state_and_output_of_an_automaton_has_a_unit(name):
    mechanism = derived(name)
    automaton = Simulator(mechanism, one_law("hertz")).automaton
    outputs = next(iter(automaton.modes)).outputs
    names = [*(s.name for s in automaton.states), *outputs]
    assert len(names) > len(mechanism.state_names)
    for n in names:
        assert n in mechanism.units or quantity(n) is not None, n


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("theta_dot", "rad/s"),
        ("mu", "1"),
        ("max_normal_force", "N"),
        ("max_normal_force_time", "s"),
        ("integral_normal_force", "N s"),
        ("integral_theta", "rad s"),
        ("times_of_liftoff", "s"),
        ("gap_A", "m"),
        ("gap_A_dot", "m/s"),
        ("normal_force_B", "N"),
        ("stop_reason", "1"),
    ],
)
def test_unit_of_a_name(name, unit):
    assert unit_of(name, derived("rod").units) == unit


def test_units_of_products_agree():
    assert QUANTITIES["A_stick"].unit == QUANTITIES["W_nn"].unit == "1/kg"
    assert QUANTITIES["gap_dot"] == QUANTITIES["gap_rate"]


@pytest.mark.parametrize(
    ("name", "latex"),
    [
        ("theta", r"\theta"),
        ("theta_dot", r"\dot{\theta}"),
        ("x_A_dot", r"\dot{x}_{A}"),
        ("mu_floor", r"\mu_{floor}"),
        ("mass", r"\mathrm{mass}"),
        ("q1_dot", r"\dot{q}_{1}"),
    ],
)
def test_latex_of_a_symbol(name, latex):
    assert symbol_latex(name) == latex


def test_derivatives_keep_the_index_outside():
    assert derivative_latex("x_A") == r"\dot{x}_A"
    assert derivative_latex(r"\theta", 2) == r"\ddot{\theta}"
    assert derived("rod").latex_names["x_A_dot"] == r"\dot{x}_A"


def test_axis_labels_name_the_unit_unless_it_is_one():
    assert axis_label("F_n", "N") == "$F_n$ (N)"
    assert axis_label(r"\mu", "1") == r"$\mu$"


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(1.21e-3, 1.87e-3, 0.0015), (0.9, 1.1, 1.0), (3.0, 7.0, 5.0), (17.0, 17.0, 17.0), (0, 1, 0)],
)
def test_roundest_number_of_a_range(low, high, expected):
    assert roundest(low, high) == expected
