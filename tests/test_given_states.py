"""Forms in which a state is given: names, symbols, a Series, an array in the order of the names."""

from __future__ import annotations

import functools

import numpy as np
import pytest
import sympy as sp
from sympy.physics.mechanics import dynamicsymbols

import painleve_sym as ps
from painleve_sym.checks import named_state
from painleve_sym.errors import InputError

pandas = pytest.importorskip("pandas")
NAMED = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
ORDERED = [0.0, 0.0, 1.0, -1.0, 0.0, 1.0]


@functools.cache
def rod():
    return ps.models.rod()


def forms():
    """Return one state in every form."""
    theta = dynamicsymbols("theta")
    return {
        "list": ORDERED,
        "array": np.array(ORDERED),
        "Series": pandas.Series(NAMED),
        "symbols": {rod().symbols[name]: value for name, value in NAMED.items()},
        "plain symbols": {sp.Symbol(name): value for name, value in NAMED.items()},
        "functions of time": {theta: 1.0, theta.diff(): 1.0, "x_A_dot": -1.0},
        "row of a frame": pandas.DataFrame([NAMED, NAMED]).iloc[1],
    }


QUESTIONS = {
    "classify": lambda state: ps.classify(rod(), state).problem.b.tolist(),
    "jump": lambda state: ps.evaluate_jump(rod(), "energetic", state).velocity,
    "simulate": lambda state: ps.simulate(rod(), "hertz", state, t_end=1e-4).final,
    "sensitivities": lambda state: (
        ps.Simulator(rod(), "hertz").sensitivities(state, ["mu"], t_end=1e-4).trajectory.final
    ),
    "batch": lambda state: ps.simulate_batch(rod(), "hertz", state, t_end=1e-4)["theta"].tolist(),
    "corrected jump": lambda state: ps.evaluate_corrected_jump(rod(), "hertz", state).velocity,
    "compare": lambda state: ps.compare(rod(), state, steps=(1e-3,), stiffness=(20.9e14,)).state,
    "explore": lambda state: ps.explore(rod(), state=state).html,
}


@pytest.mark.parametrize("question", QUESTIONS)
def test_every_form_of_a_state_has_one_answer(question):
    ask = QUESTIONS[question]
    expected = ask(NAMED)
    for form, state in forms().items():
        assert ask(state) == expected, form


def test_rows_of_a_batch_are_those_of_an_array_and_of_a_frame():
    table = np.array([ORDERED, [0.0, 0.0, 0.9, -1.0, 0.0, 1.0]])
    by_name = {"theta": table[:, 2], "theta_dot": 1.0, "x_A_dot": -1.0}
    expected = ps.simulate_batch(rod(), "hertz", by_name, t_end=1e-4)["theta_dot"]
    assert expected[0] != expected[1]
    for states in (table, table.tolist(), pandas.DataFrame(table, columns=rod().state_names)):
        motions = ps.simulate_batch(rod(), "hertz", states, t_end=1e-4)
        np.testing.assert_array_equal(motions["theta_dot"], expected)
    whole = ps.simulate_batch(rod(), "hertz", np.stack([table, table]), t_end=1e-4)
    np.testing.assert_array_equal(whole["theta_dot"], [expected, expected])


def test_parameters_may_have_symbols_for_names():
    given = {rod().symbols["mu"]: 0.5}
    assert rod().at(NAMED, given) == rod().at(NAMED, {"mu": 0.5})
    run = ps.simulate(rod(), "hertz", NAMED, t_end=1e-5, parameters=pandas.Series({"mu": 0.5}))
    assert run.parameters["mu"] == 0.5


def test_a_formula_takes_the_symbols_of_its_mechanism():
    energy = rod().system.kinetic_energy
    place = rod().at(NAMED)
    value = energy.subs({rod().symbols[name]: value for name, value in place.values.items()})
    assert not value.free_symbols
    assert energy.subs({"theta": 1.0}) == energy  # SymPy reads another symbol


@pytest.mark.parametrize(
    "wrong",
    [
        [1.0],
        np.zeros(8),
        np.zeros((6, 2)),
        {dynamicsymbols("theta").diff().diff(): 1.0},
        {"theta": 1.0, sp.Symbol("theta"): 2.0},
        {1: 2.0},
        5.0,
        "theta",
        pandas.Series([1.0, 2.0]),
    ],
)
def test_another_form_is_refused_with_the_order_of_the_names(wrong):
    with pytest.raises(InputError, match="in the order x_A, y_A, theta, x_A_dot") as error:
        ps.classify(rod(), wrong)
    assert "\n" not in str(error.value)
    with pytest.raises(InputError, match="in the order x_A, y_A, theta, x_A_dot"):
        ps.simulate_batch(rod(), "hertz", wrong, t_end=1e-4)


def test_names_stand_in_the_order_that_is_said():
    assert named_state(np.arange(6.0), rod().state_names, "x") == dict(
        zip(rod().state_names, range(6), strict=True)
    )
