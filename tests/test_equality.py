"""Results compare by their content: two alike are equal, one changed is not, and none raises."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import math
import pickle
import re

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.equality import Compared, same
from painleve_sym.mechanics.deferred import Deferred
from painleve_sym.problem import LCP
from painleve_sym.study import FitData

STATE = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
GAP = {"theta": 0.8, "y_A": 1e-4, "y_A_dot": -0.1, "x_A_dot": -1.0}


def rod(mu=1.5):
    return ps.models.rod(mu=mu)


def motion(mu=1.5):
    return ps.simulate(rod(mu), "hertz", STATE, t_end=2e-3)


def corrected(mu=1.5):
    return ps.evaluate_corrected_jump(rod(mu), "bilinear-hertz", STATE)


def several(mu=0.5):
    W = np.diag([2.0, 1.0, 3.0, 1.0])
    return ps.ContactProblem(W, [-1.0, 0.2, -1.0, 0.0], [mu, mu], slip_velocity=[1.0, 0.0])


def flat(mu=0.5):
    return ps.contact([[2.0, 0.5], [0.5, 3.0]], [-1.0, 0.5], mu)


def in_space(mu=0.5):
    return ps.contact(np.eye(3) + 0.2, [-1.0, 0.5, 0.1], mu)


MADE = {
    "BatchResult": lambda mu=1.5: ps.simulate_batch(
        rod(mu), "hertz", {**STATE, "theta": [0.9, 1.0]}, t_end=1e-3
    ),
    "Classification": lambda mu=1.5: ps.classify(rod(mu), STATE),
    "ContactProblem": several,
    "ContactSolution": lambda mu=0.5: several(mu).solutions()[0],
    "CorrectedJump": corrected,
    "FitData": lambda mu=1.5: FitData("here", None, {"theta": np.array([mu, math.nan])}, {}),
    "Impact": lambda mu=0.5: ps.solve_impact([[2, 0.5], [0.5, 3]], mu, (-1, 1), "poisson", 0.5),
    "JumpResult": lambda mu=0.2: ps.evaluate_jump(rod(mu), "poisson", {**GAP, "y_A": 0.0}),
    "LCP": lambda mu=0.5: LCP([[2.0, mu], [0.0, 1.0]], [-1.0, 1.0]),
    "RegionMap": lambda mu=1.5: ps.region_map(
        "rod", "theta,theta_dot", points=5, parameters={"mu": mu}
    ),
    "SensitiveTrajectory": lambda mu=1.5: ps.Simulator(rod(mu), "hertz").sensitivities(
        STATE, wrt="mu", t_end=1e-3
    ),
    "Trajectory": motion,
}
BY_IDENTITY = {
    "Robot": "what a file holds, read once",
    "RobotContact": "a place of a robot, asked for numbers",
}
"""Public types that are compared by identity, each with the reason."""
_OPEN = re.compile(r"\b(Array|\w*Array|NDArray|Mapping|dict|list)\b")


def public_dataclasses():
    public = {name: getattr(ps, name) for name in ps.__all__}
    return {n: c for n, c in public.items() if inspect.isclass(c) and dataclasses.is_dataclass(c)}


@pytest.mark.parametrize("name", sorted(public_dataclasses()))
def test_public_type_is_compared_by_its_content(name):
    kind = public_dataclasses()[name]
    texts = [str(f.type) for f in dataclasses.fields(kind) if f.compare]
    if name in BY_IDENTITY:
        assert kind.__eq__ is object.__eq__
    elif not issubclass(kind, Deferred) and any(map(_OPEN.search, texts)):
        assert issubclass(kind, Compared) and kind.__eq__ is Compared.__eq__
    assert kind.__hash__ is not None


@functools.cache
def result_of(name):
    return MADE[name]()


@pytest.mark.parametrize("name", sorted(MADE))
def test_equal_results_are_equal(name):
    one, other = result_of(name), MADE[name]()
    assert type(one).__name__ == name and one is not other
    assert (one == other) is True and (one != other) is False and hash(one) == hash(other)
    copy = pickle.loads(pickle.dumps(one))
    assert (copy == one) is True and (one == copy) is True and hash(copy) == hash(one)
    changed = MADE[name](1.3)
    assert (one == changed) is False and (one != changed) is True
    assert (one == 1.0) is False and (one != "text") is True


def test_a_run_read_from_its_file_is_the_run(tmp_path):
    run = result_of("Trajectory")
    run.save(tmp_path / "run.npz")
    read = ps.Trajectory.load(tmp_path / "run.npz")
    assert read == run and hash(read) == hash(run)
    state = read.final_state.copy()
    state[0] = np.nextafter(state[0], 2)
    assert dataclasses.replace(read, final_state=state) != run


def test_each_field_of_a_result_decides():
    data = FitData("here", np.array([0.0, math.nan]), {"theta": np.ones(2)}, {"t": np.ones(2)})
    other = {
        "where": "there",
        "times": np.array([0.0, 1.0]),
        "starts": {"theta": np.ones(3)},
        "measured": {},
    }
    assert set(other) == {f.name for f in dataclasses.fields(data)}
    for name, value in other.items():
        assert dataclasses.replace(data, **{name: value}) != data
    assert dataclasses.replace(data, times=np.array([0.0, math.nan])) == data


@pytest.mark.parametrize(
    ("one", "other", "equal"),
    [
        (math.nan, float("nan"), True),
        (np.float64("nan"), float("nan"), True),
        ({"a": (math.nan,)}, {"a": (float("nan"),)}, True),
        (np.array([1.0, math.nan]), np.array([1.0, math.nan]), True),
        (np.array([1.0, math.nan]), np.array([1.0, 2.0]), False),
        (np.ones((2, 1)), np.ones((1, 2)), False),
        (np.ones(1), None, False),
        (np.ones((0,)), np.ones((0, 3)), False),
        (np.array(["a"]), np.array(["a"]), True),
        (np.array(["a"]), np.array(["b"]), False),
        ((1.0, 2.0), (1.0,), False),
        ({"a": 1}, {"b": 1}, False),
        (1.0, "1.0", False),
        (None, 0.0, False),
    ],
)
def test_content(one, other, equal):
    assert same(one, other) is equal and same(other, one) is equal


def mechanisms():
    from painleve_sym.mechanics.models import NAMED

    return [*(ps.model(name) for name in NAMED), ps.models.rod(mu=1.5)]


def test_mechanisms_hash_as_they_compare():
    first, second = mechanisms(), mechanisms()
    copies = pickle.loads(pickle.dumps(first[:3]))
    for i, one in enumerate(first):
        assert hash(one) == hash(second[i])
        assert [one == other for other in first] == [i == k for k in range(len(first))]
    assert first[0] == second[0] and first[0] != first[-1]
    assert copies == first[:3] and list(map(hash, copies)) == list(map(hash, first[:3]))
    assert len({*first, *copies}) == len(first)
    assert hash(first[0].system) == hash(copies[0].system)
    assert hash(first[0].contact) == hash(copies[0].contact)


def test_laws_hash_as_they_compare():
    one, other = (ps.laws.bilinear_hertz(E=1e9) for _ in range(2))
    assert one == other and hash(one) == hash(other) and one != ps.laws.bilinear_hertz(E=2e9)
    assert {one: 1}[pickle.loads(pickle.dumps(other))] == 1
    assert hash(ps.laws.rigid(e=0.5)) == hash(ps.laws.rigid(e=0.5))
