"""Starts of runs: the same from every engine, alone and in a batch, for any kind of contact."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import NO_FORCE, Simulator
from painleve_sym.motion.trajectory import StoredRecord

IMPACT = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
CASES = [("rod", "bilinear-hertz"), ("rod", "rigid"), ("painleve-klein", "rigid")]
CASES += [("block-two-feet", "rigid"), ("strut", "linear")]


def random_starts(simulator, n=40):
    """Return parameters, given states of very different sizes, many exactly 0, and forces."""
    rng = np.random.default_rng(11)
    given = len(simulator.mechanism.state_names)
    motion = rng.normal(size=(n, given)) * 10.0 ** rng.integers(-14, 3, size=(n, given))
    motion[rng.random((n, given)) < 0.5] = 0.0
    values = simulator.parameters()
    p = np.array([values[n] for n in simulator.outline.parameter_names])
    forces = np.where(rng.random(n) < 0.5, NO_FORCE, rng.exponential(10.0, n))
    # The mechanism's own start is admitted; a guide admits few others.
    own = simulator.mechanism.start
    motion[0], forces[0] = [own.get(s, 0.0) for s in simulator.mechanism.state_names], NO_FORCE
    p = np.vstack([p, p * rng.uniform(0.5, 1.5, (n - 1, 1))])
    return p, motion, forces


@pytest.mark.parametrize(("name", "kind"), CASES)
def test_every_engine_prepares_the_same_bits_row_by_row(name, kind):
    second = "compiled" if name == "block-two-feet" else "erk"
    compiled, erk = (Simulator(model(name), law(kind), e).integrator for e in ("auto", second))
    p, motion, forces = random_starts(Simulator(model(name), law(kind), second))
    whole, other = (engine.prepare(p, motion, forces) for engine in (compiled, erk))
    for a, b in zip(whole, other, strict=True):
        np.testing.assert_array_equal(a, b)
    for i in range(len(p)):
        alone = compiled.prepare(p[i : i + 1], motion[i : i + 1], forces[i : i + 1])
        assert [a.tobytes() for a in alone] == [a[i].tobytes() for a in whole]
        np.testing.assert_array_equal(compiled.scales(p[i], whole.states[i]), whole.scales[i])


@pytest.mark.parametrize(("name", "kind"), CASES)
def test_every_start_that_is_admitted_has_positive_scales(name, kind):
    simulator = Simulator(model(name), law(kind))
    _, admits, scales = simulator.integrator.prepare(*random_starts(simulator))
    assert set(np.unique(admits)) <= {0.0, 1.0}
    admitted = (admits == 1).all(axis=1)
    assert admitted.any()
    assert (scales[admitted] > 0).all()
    assert np.isfinite(scales[admitted]).all()


def test_an_initial_force_is_carried_at_the_start():
    simulator = Simulator(model("rod"), law("bilinear-hertz"))
    start = simulator.start(simulator.at(IMPACT, {"E": 20.9e14}), 25.0)
    run = simulator.run(IMPACT, parameters={"E": 20.9e14}, initial_force=25.0, t_end=1e-9)
    assert run.values("normal_force", 0.0) == pytest.approx(25.0, rel=1e-12)
    depth = simulator.compression_of_force(25.0, start.place.parameters)
    assert -start.state[simulator.outline.state_names.index(simulator.contact.rows[0].gap)] == depth


@pytest.mark.parametrize(
    ("state", "message"),
    [({"x_A_dott": 1.0}, "unknown state"), ({"theta": np.nan}, "got nan"), ({"theta": 4.0}, "> 0")],
)
def test_a_refused_start_says_why(state, message):
    simulator = Simulator(model("rod"), law("rigid"), "erk")
    with pytest.raises(InputError, match=message):
        simulator.start(simulator.at(state))


def test_whole_numbers_and_numpy_numbers_are_taken_as_floats():
    simulator = Simulator(model("rod"), law("rigid"), "erk")
    place = simulator.at({"theta": 1, "x_A_dot": np.float64(-1.0)}, {"mu": np.int64(1)})
    start = simulator.start(place)
    plain = simulator.start(simulator.at({"theta": 1.0, "x_A_dot": -1.0}, {"mu": 1.0}))
    assert start.state.tobytes() == plain.state.tobytes()
    assert {type(v) for v in start.place.parameters.values()} == {float}


def test_steps_and_events_are_read_once_and_survive_pickling():
    run = Simulator(model("rod"), law("rigid")).run({**IMPACT, "y_A": 0.001}, t_end=0.05)
    assert run.events is run.events and len(run.events) > 2
    assert run.step_rows is run.step_rows
    again = pickle.loads(pickle.dumps(run.record))
    assert isinstance(again, StoredRecord)
    assert again.events == run.events and again.mode_names == run.mode_names
    np.testing.assert_array_equal(again.steps.polynomial, run.step_rows)
    np.testing.assert_array_equal(again.constants, run.constants)
