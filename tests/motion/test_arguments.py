"""Keyword arguments of runs: named once, known to editors and `help`, rejected by name."""

from __future__ import annotations

import inspect
import re
from dataclasses import fields

import pytest

import painleve_sym as ps
from painleve_sym.engines.protocol import RunSettings
from painleve_sym.motion.arguments import BatchArguments, RunArguments
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.study.scenario import Scenario

START = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
SETTINGS = {f.name for f in fields(RunSettings)}
BEGINS = {"parameters", "law_parameters", "material", "initial_force", "close"}
LIMITS = {"t_end": 1e-2, "until": ("slip_stop",), "rtol": 1e-9, "max_steps": 500, "max_events": 3}


def rod():
    return ps.Simulator("rod", "hertz")


CALLS = {
    "simulate": lambda **given: ps.simulate("rod", "hertz", START, **given),
    "run": lambda **given: rod().run(START, **given),
    "sensitivities": lambda **given: rod().sensitivities(START, ["mu"], **given),
    "simulate_batch": lambda **given: ps.simulate_batch("rod", "hertz", START, **given),
    "run_batch": lambda **given: run_batch(rod(), START, **given),
}


def test_every_setting_is_an_argument_of_a_run():
    assert set(RunArguments.__annotations__) == SETTINGS | BEGINS | {"start", "phases", "inputs"}


def test_every_argument_of_a_run_begins_it_or_is_a_setting():
    takes = set(inspect.signature(ps.Simulator.begin).parameters)
    takes |= set(inspect.signature(ps.Simulator.at).parameters)
    assert takes - {"self", "state"} == BEGINS


def test_batch_has_the_settings_of_a_run_but_two():
    shared = SETTINGS & set(BatchArguments.__annotations__)
    assert SETTINGS - shared == {"atol", "record"}
    assert set(RunSettings(1.0).shared()) == shared


@pytest.mark.parametrize(
    ("function", "kind"),
    [
        (ps.simulate, RunArguments),
        (ps.Simulator.run, RunArguments),
        (ps.Simulator.sensitivities, RunArguments),
        (ps.simulate_batch, BatchArguments),
    ],
)
def test_signature_names_every_argument_with_its_default(function, kind):
    parameters = inspect.signature(function).parameters
    assert set(kind.__annotations__) < set(parameters)
    assert all(p.kind is not p.VAR_KEYWORD for p in parameters.values())
    assert parameters["t_end"].default is inspect.Parameter.empty
    assert parameters["t_end"].annotation == "Value"
    for name in SETTINGS & set(parameters) - {"t_end"}:
        assert parameters[name].default is getattr(RunSettings(1.0), name)


@pytest.mark.parametrize("name", CALLS)
def test_unknown_argument_is_rejected_with_the_nearest(name):
    with pytest.raises(ps.InputError, match=r"unknown argument 'rtoll'\. Did you mean 'rtol'\?"):
        CALLS[name](t_end=1e-3, rtoll=1e-9)


@pytest.mark.parametrize("name", CALLS)
def test_missing_end_is_rejected(name):
    with pytest.raises(ps.InputError, match="t_end: got none, need the end of the motion"):
        CALLS[name]()


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize(("bad", "value"), [("t_end", -1.0), ("rtol", 2.0), ("max_steps", 0)])
def test_setting_out_of_range_is_rejected_by_name(name, bad, value):
    with pytest.raises(ps.InputError, match=f"'rod' with law 'hertz': {bad}: got"):
        CALLS[name](**{"t_end": 1e-3, bad: value})


def test_scenario_and_call_run_with_the_same_settings():
    of_file = Scenario("rod", state=START, law="hertz", **LIMITS)
    run, again = of_file.simulate(), ps.simulate("rod", "hertz", START, **LIMITS)
    assert run.final == again.final
    assert run.inputs == again.inputs
    assert [e.kind for e in run.events] == ["slip_stop"]


@pytest.mark.slow
def test_sensitivities_take_all_that_a_run_takes():
    given = {"material": "steel", "t_end": 1e-3, "record": "events", "max_events": 7}
    run = ps.simulate("rod-bending", "hertz", START, **given)
    with_slopes = ps.Simulator("rod-bending", "hertz").sensitivities(START, ["mu"], **given)
    assert with_slopes.trajectory.body_periods == run.body_periods
    assert with_slopes.trajectory.parameters == run.parameters


def parameters_of_solve_ivp():
    """Return the arguments of SciPy's integrators that a motion has not."""
    from scipy.integrate import odeint, solve_ivp

    own = {"rtol", "atol", "t_end", "max_step", "first_step"}
    ours = inspect.signature(solve_ivp).parameters.keys() - own
    return sorted(ours - {"options", "vectorized"}) + sorted(
        {"tol"} | (inspect.signature(odeint).parameters.keys() & {"args"}) - ours
    )


@pytest.mark.parametrize("name", parameters_of_solve_ivp())
def test_an_argument_of_scipy_is_answered_by_ours(name):
    from painleve_sym.motion.arguments import OF_SCIPY

    with pytest.raises(ps.InputError, match=rf"argument '{name}' is one of SciPy\. Fix: ") as error:
        ps.simulate("rod", "hertz", {"theta": 1.0}, t_end=1e-4, **{name: 1})
    named = re.findall(r"(\w+)=", str(error.value))
    assert set(named) <= inspect.signature(ps.simulate).parameters.keys()
    assert "Did you mean" not in str(error.value) and name in OF_SCIPY
