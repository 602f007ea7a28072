"""Trajectories can be evaluated, cut into segments, saved and loaded."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson

from painleve_sym.errors import InputError, StopReason
from painleve_sym.files import write_beside
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.motion.runs import simulate
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory
from tests.support.paper_law import paper_law

START = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}


@pytest.fixture(scope="module")
def simulator():
    return Simulator(rod(), paper_law())


@pytest.fixture(scope="module")
def impact(simulator):
    return simulator.run(START, t_end=1e-3, parameters={"E": 20.9e14})


def test_states_are_continuous_at_every_step(impact):
    for i in range(1, len(impact.step_time)):
        before = impact._states(impact.step_time[i : i + 1], np.array([i - 1]))[0]
        after = impact.step_rows[i, 0]
        # A reset may set the slip velocity to exactly zero; it was zero to round-off.
        np.testing.assert_allclose(before, after, rtol=1e-9, atol=1e-15)


def test_velocities_are_the_derivatives_of_coordinates(impact):
    t = impact.sample(20001)
    for name in ("x_A", "y_A", "theta"):
        rate = impact.values(f"{name}_dot", t)
        moved = cumulative_simpson(rate, x=t, initial=0)
        position = impact.values(name, t)
        scale = np.max(np.abs(position - position[0]))
        assert np.max(np.abs(position - position[0] - moved)) < 1e-7 * scale


def test_evaluation_at_an_event_is_the_state_after_it(impact):
    for e in impact.events:
        assert impact.state(e.time)["x_A_dot"] == e.state["x_A_dot"]


def test_end_is_where_the_polynomial_ends(impact):
    np.testing.assert_allclose(impact(impact.final_time)[0], impact.final_state, rtol=1e-12)
    assert impact.final_time == 1e-3


def test_sampling_is_even_and_complete(impact):
    t = impact.sample(11)
    assert t[0] == 0
    assert t[-1] == impact.final_time
    np.testing.assert_allclose(np.diff(t), impact.final_time / 10)
    assert len(impact.fine_times(4)) == 4 * len(impact.step_time) + 1


def test_segments_cover_the_run_in_order(impact):
    segments = impact.segments
    assert segments[0].t_start == 0
    assert segments[-1].t_end == pytest.approx(impact.final_time, rel=1e-14)
    for a, b in pairwise(segments):
        assert a.t_end == pytest.approx(b.t_start, rel=1e-12)
    modes = [s.mode for s in segments]
    assert modes[:3] == ["slip_neg/compression", "stick/compression", "stick/restitution"]
    assert [e.mode_after for e in impact.events] == modes[1:]


@pytest.mark.parametrize("t", [-1e-9, 1.1e-3, float("nan")])
def test_times_outside_are_refused(impact, t):
    with pytest.raises(InputError, match="time"):
        impact(t)


def test_unknown_quantity_suggests_the_nearest(impact):
    with pytest.raises(InputError, match="Did you mean 'normal_force'"):
        impact.values("normal_forc", 0.0)


def test_run_without_dense_record_says_why_it_cannot_be_evaluated(simulator):
    run = simulator.run(START, t_end=1e-3, record="events")
    assert run.energy_residual < 1e-10
    assert np.isnan(simulator.run(START, t_end=1e-3, record="end").energy_residual)
    with pytest.raises(InputError, match="record='dense'"):
        run(0.0)


def test_end_of_a_run_without_dense_record_can_be_evaluated(simulator):
    run = simulator.run(START, t_end=1e-3, record="events")
    assert run.state(1e-3) == run.final
    assert run.outputs(1e-3)["normal_force"][0] == run.final_outputs["normal_force"]


def test_run_that_ended_at_its_start_can_be_evaluated_there():
    run = simulate(
        "strut", "rigid", {"theta": 0.9272952180016122}, t_end=1e-2, parameters={"mu": 2.0}
    )
    assert run.stop_reason is StopReason.JAM and run.ended_at_start
    assert run.state(0.0) == run.final
    assert run.sample(3) == pytest.approx([0, 0, 0])
    with pytest.raises(InputError, match=r"need 0.0: the run ended at its start \(jam\)"):
        run(1e-3)


def test_evaluation_at_an_event_that_ends_the_run_is_the_state_after_it():
    start = {"theta": 0.9, "theta_dot": 4.0}
    run = simulate("strut", "rigid", start, t_end=1e-2, parameters={"mu": 2.0})
    assert run.stop_reason is StopReason.JAM and len(run.step_time)
    assert run.state(run.final_time) == run.final == run.events[-1].state
    before = run.state(float(np.nextafter(run.final_time, 0)))
    assert abs(before["theta_dot"] - run.final["theta_dot"]) > 2


def test_saved_trajectory_is_the_same_when_loaded(impact, tmp_path):
    path = tmp_path / "run.npz"
    impact.save(path)
    again = Trajectory.load(path)
    t = impact.sample(101)
    np.testing.assert_array_equal(again(t), impact(t))
    forces = (run.values("normal_force", t) for run in (again, impact))
    np.testing.assert_array_almost_equal_nulp(*forces, nulp=4)
    assert again.events == impact.events
    assert again.stop_reason is StopReason.T_END
    assert again.to_dict() == impact.to_dict()
    assert [p.name for p in tmp_path.iterdir()] == ["run.npz"]


def test_foreign_files_are_refused(tmp_path):
    text = tmp_path / "text.npz"
    text.write_text("not an archive")
    pickled = tmp_path / "pickled.npz"
    np.savez(pickled, text=np.array([{"a": 1}], dtype=object))
    other = tmp_path / "other.npz"
    np.savez(other, a=np.zeros(3))
    for path in (text, pickled, other, tmp_path / "missing.npz"):
        with pytest.raises(InputError, match="not readable"):
            Trajectory.load(path)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("step_length", lambda a: a[:-1]),
        ("step_mode", lambda a: a + 1000),
        ("step_rows", lambda a: a[..., :-1]),
        ("final_state", lambda a: a.astype(str)),
        ("final_memory", lambda a: np.zeros(30)),
        ("text", lambda a: np.array(str(a).replace('"names": [', '"names": [[], '))),
        ("text", lambda a: np.array(str(a).replace('"slip_stop"', '"slip_stops"'))),
        ("text", lambda a: np.array(str(a).replace('"operations": [[', '"operations": [[[], '))),
    ],
)
def test_file_whose_parts_do_not_fit_is_refused(impact, tmp_path, name, change):
    path = tmp_path / "run.npz"
    impact.save(path)
    with np.load(path) as data:
        arrays = dict(data)
    changed = change(arrays[name])
    assert changed.shape != arrays[name].shape or (changed != arrays[name]).any()
    np.savez(path, **(arrays | {name: changed}))
    with pytest.raises(InputError, match=r"step_mode|got shape|not readable"):
        Trajectory.load(path)


def test_save_into_a_missing_folder_leaves_nothing(impact, tmp_path):
    with pytest.raises(InputError, match="writable"):
        impact.save(tmp_path / "none" / "run.npz")
    assert list(tmp_path.iterdir()) == []


def test_a_failed_write_keeps_the_old_file(tmp_path):
    path = tmp_path / "file"
    path.write_text("old")

    def fail(_):
        raise RuntimeError("disk")

    with pytest.raises(RuntimeError):
        write_beside(path, fail)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_energies_are_named_and_sum_up(impact):
    terms = impact.energies(impact.sample(50))
    total = sum(v for k, v in terms.items() if k != "total")
    np.testing.assert_allclose(terms["total"], total, rtol=1e-15)
    assert impact.energy_residual < 1e-9
    assert terms["friction_dissipation"][-1] > 0


def test_the_function_is_the_simulator_run_once(impact):
    again = simulate("rod", paper_law(), START, t_end=1e-3, law_parameters={"E": 20.9e14})
    np.testing.assert_array_equal(again.final_state, impact.final_state)
