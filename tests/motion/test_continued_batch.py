"""Batches and derivatives of motions that continue another one."""

from __future__ import annotations

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.errors import InputError

SLIDING = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
TWO_FEET = {"y_A": 0.01, "theta": 0.02, "x_A_dot": 1.0}
MOTIONS = {
    "compliant": ("rod", "bilinear-hertz", SLIDING, 1.9e-3, 6e-3, "mu", "auto"),
    "rigid": ("rod", "rigid", {"y_A": 0.1, "theta": 0.9}, 0.15, 0.4, "mu", "auto"),
    "feet": ("block-two-feet", "rigid", TWO_FEET, 0.1, 0.3, "g", "auto"),
    "erk": ("rod", "bilinear-hertz", SLIDING, 1.9e-3, 3e-3, "mu", "erk"),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_rows_that_continue_a_motion_are_those_of_single_runs(name):
    mechanism, law, state, cut, t_end, varied, engine = MOTIONS[name]
    simulator = ps.Simulator(mechanism, law, engine)
    first = simulator.run(state, t_end=cut)
    values = first.parameters[varied] * np.array([1.0, 0.9, 1.1])
    rows = ps.simulate_batch(
        mechanism,
        law,
        start=first,
        t_end=t_end,
        parameters={varied: values},
        engine=engine,
        events=3,
    )
    assert rows.shape == (3,) and len(set(rows["theta"].tolist())) == 3
    for i, value in enumerate(values.tolist()):
        run = simulator.run(start=first, t_end=t_end, parameters={varied: value})
        for state_name in run.state_names:
            assert rows[state_name][i] == run.final[state_name], state_name
        assert rows["time"][i] == t_end == run.final_time
        assert rows["mode"][i] == run.mode_names[run.final_mode]
        for kind in rows.kinds:
            times = [e.time for e in run.events_of(kind)]
            assert rows[f"count_of_{kind}"][i] == len(times)
            assert rows[f"times_of_{kind}"][i][: len(times[:3])].tolist() == times[:3]
        assert rows.trajectory(i).final == run.final
    assert (rows["energy_residual"] < 1e-7).all()


def test_a_batch_goes_on_as_the_whole_motion():
    whole = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=6e-3)
    first = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=1.9e-3)
    row = ps.simulate_batch(
        "rod", "bilinear-hertz", start=first, t_end=6e-3, maxima=["normal_force"]
    )
    fresh = ps.simulate_batch(
        "rod", "bilinear-hertz", {n: first.final[n] for n in SLIDING}, t_end=4.1e-3
    )
    assert float(row["theta_dot"]) == pytest.approx(whole.final["theta_dot"], rel=1e-9)
    assert float(fresh["theta_dot"]) != pytest.approx(whole.final["theta_dot"], rel=1e-3)
    at = float(row["max_normal_force_time"])
    assert whole.values("normal_force", at)[0] == pytest.approx(
        float(row["max_normal_force"]), rel=1e-6
    )


def test_other_laws_begin_at_the_cut_in_a_mode_of_their_own():
    first = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 0.9}, t_end=0.1)
    row = ps.simulate_batch("rod", "hertz", start=first, t_end=0.2, parameters={"mu": [0.3, 0.5]})
    run = ps.simulate("rod", "hertz", start=first, t_end=0.2, parameters={"mu": 0.5})
    assert row["theta_dot"][1] == run.final["theta_dot"]
    assert row["time_of_touchdown"][1] == run.events_of("touchdown")[0].time > 0.1


def test_derivatives_of_the_rest_are_those_of_the_whole_by_the_chain_rule():
    simulator = ps.Simulator("rod", "bilinear-hertz")
    names = ("x_A", "y_A", "theta", "x_A_dot", "y_A_dot", "theta_dot")
    cut, t_end = 1.0e-3, 4e-3  # slides in compression at the cut, which has no memory to differ
    first = simulator.sensitivities(SLIDING, names, t_end=cut)
    rest = simulator.sensitivities(None, names, start=first.trajectory, t_end=t_end)
    whole = simulator.sensitivities(SLIDING, names, t_end=t_end)
    product = rest.final_jacobian[:6] @ first.final_jacobian[:6]
    np.testing.assert_allclose(product, whole.final_jacobian[:6], rtol=1e-6, atol=1e-6)
    assert [e.event.time for e in rest.events] == pytest.approx(
        [e.event.time for e in whole.events], rel=1e-10
    )
    assert rest.trajectory.final_time == t_end


def test_derivatives_by_a_parameter_of_the_rest_are_differences_of_runs():
    simulator = ps.Simulator("rod", "bilinear-hertz")
    first = simulator.run(SLIDING, t_end=1.8e-3)  # in restitution: it has a memory
    own = simulator.sensitivities(
        None, ["e_energetic", "theta_dot"], start=first, t_end=6e-3, rtol=1e-12
    )
    e, h = first.parameters["e_energetic"], 1e-5
    ends = [
        simulator.run(
            start=first, t_end=6e-3, parameters={"e_energetic": e + s * h}, rtol=1e-12
        ).final_state
        for s in (1, -1)
    ]
    difference = (ends[0] - ends[1]) / (2 * h)
    scale = np.abs(difference).max()
    np.testing.assert_allclose(own.final_jacobian[:, 0], difference, atol=1e-6 * scale)


def test_a_start_is_one_of_a_motion_or_of_states():
    first = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=1e-3)
    for wrong, said in (
        ({"states": SLIDING, "start": first, "t_end": 2e-3}, "start: got state, too"),
        ({"start": first, "t_end": 1e-3}, "need a time after 0.001 s"),
        ({"start": first, "t_end": 2e-3, "close": "y_A"}, "start: got close, too"),
        ({"start": SLIDING, "t_end": 2e-3}, "need a Trajectory"),
    ):
        with pytest.raises(InputError, match=said):
            ps.simulate_batch("rod", "bilinear-hertz", **wrong)
    with pytest.raises(InputError, match="start: got state, too"):
        ps.Simulator("rod", "hertz").sensitivities(SLIDING, ["mu"], start=first, t_end=2e-3)
    change = {"time": 5e-3, "parameters": {"mu": 0.2}}
    start = {"y_A": 0.1, "theta": 1.0}
    changed = ps.simulate("rod", "hertz", start, t_end=0.01, phases=[change])
    with pytest.raises(InputError, match="phases, inputs or pulses, which"):
        ps.simulate_batch("rod", "hertz", start=changed, t_end=0.02)


def test_rows_whose_closed_contact_has_another_speed_are_one_sentence():
    belt = ps.load_mechanism("examples/mechanisms/belt-oscillator.toml")
    first = ps.simulate(belt, "rigid", {"x_dot": 0.2}, t_end=0.01)  # it sticks to the belt
    with pytest.raises(ps.InputError, match=r"has another speed.*Fix: continue it row by row"):
        ps.simulate_batch(belt, "rigid", start=first, t_end=0.02, parameters={"u": [0.2, 0.4]})
