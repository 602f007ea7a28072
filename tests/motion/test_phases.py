"""Motions with phases and inputs, against pieces by hand, SciPy and formulas."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import painleve_sym as ps
from painleve_sym.cli import main
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.study.scenario import Scenario
from tests.scenes import SLED

SLIDING = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
FALLING = {"y_A": 0.1, "theta": 0.9}
TWO_FEET = {"y_A": 0.01, "theta": 0.02, "x_A_dot": 1.0}
MOTIONS = {
    "compliant": ("rod", "bilinear-hertz", SLIDING, 0.01, "auto"),
    "rigid": ("rod", "rigid", FALLING, 0.3, "auto"),
    "Runge-Kutta": ("rod", "hunt-crossley", FALLING, 0.2, "compiled"),
    "erk": ("rod", "bilinear-hertz", SLIDING, 0.005, "erk"),
    "both kinds": ("block-two-feet", {"A": "rigid", "B": "hertz"}, TWO_FEET, 0.1, "auto"),
}
CUBIC = 'meaning = "place of the table", interpolation = "cubic"'
BLOCK = SLED.replace(CUBIC.replace("cubic", "linear"), CUBIC)


@pytest.fixture(scope="module")
def block():
    """Return a block on a table that moves, with a force on it: two inputs."""
    return ps.Simulator(mechanism_from_text(BLOCK), "rigid")


@settings(max_examples=3)
@given(
    parts=st.lists(st.floats(0.05, 0.95), min_size=1, max_size=3, unique=True),
    values=st.lists(st.floats(0.1, 0.9), min_size=3, max_size=3),
)
@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_with_phases_is_that_of_its_pieces(name, parts, values):
    mechanism, law, state, t_end, engine = MOTIONS[name]
    simulator = ps.Simulator(mechanism, law, engine)
    friction = simulator.mechanism.outline.contacts[0].friction
    times = [part * t_end for part in sorted(parts)]
    pieces = [simulator.run(state, t_end=times[0])]
    for time, mu in zip([*times[1:], t_end], values, strict=False):
        pieces.append(pieces[-1].continued(time, parameters={friction: mu}))
    phases = [
        {"time": time, "parameters": {friction: mu}}
        for time, mu in zip(times, values, strict=False)
    ]
    whole = simulator.run(state, t_end=t_end, phases=phases[::-1])
    assert whole.events == tuple(e for piece in pieces for e in piece.events)
    assert whole.t.tolist() == [*(t for p in pieces for t in p.t[:-1]), t_end]
    assert (whole.final_state == pieces[-1].final_state).all()
    assert whole.energy_residual == max(piece.energy_residual for piece in pieces)
    assert whole.counters["events"] == sum(p.counters["events"] for p in pieces)
    for piece in pieces:
        at = piece.sample(20)[:-1]
        assert (whole(at) == piece(at)).all()
        for output, known in piece.outputs(at).items():
            assert (whole.values(output, at) == known).all(), output


def test_values_that_are_held_are_phases(block):
    times, values = [0.0, 0.1, 0.25, 0.4], [0.3, 0.1, 0.5, 0.2]
    start = {"x_dot": 5.0}
    held = block.run(start, t_end=0.5, inputs={"mu": {"times": times, "values": values}})
    phases = [{"time": t, "parameters": {"mu": mu}} for t, mu in zip(times, values, strict=True)]
    both = block.run(start, t_end=0.5, phases=phases)
    assert held.events == both.events and (held.final_state == both.final_state).all()
    loss = sum(9.8 * mu * dt for mu, dt in zip(values, [0.1, 0.15, 0.15, 0.1], strict=True))
    assert held.final["x_dot"] == pytest.approx(5 - loss, rel=1e-12)


def test_a_force_by_lines_has_its_impulse(block):
    times, values = [0.0, 0.125, 0.5, 1.0], [0.0, 40.0, -8.0, 12.0]
    force = {"times": times, "values": values, "interpolation": "linear"}
    run = block.run({"x_dot": 5.0}, t_end=1.0, inputs={"F": force})
    impulse = np.trapezoid(values, times)
    assert run.final["x_dot"] == pytest.approx(5 - 0.3 * 9.8 + impulse / 2, rel=1e-13)
    assert set(times) <= set(run.t)
    assert run.energy_closes


def test_times_of_inputs_are_those_of_the_motion_whatever_t_is_in_formulas(block):
    force = {"times": [0, 0.5, 1], "values": [0, 7, 2], "interpolation": "linear"}
    early, late = (
        block.run({"x_dot": 5.0, "t": t}, t_end=1.0, inputs={"F": force}) for t in (0.0, 3.0)
    )
    assert late.final["t"] == pytest.approx(4.0)
    assert late.final["x_dot"] == pytest.approx(early.final["x_dot"], rel=1e-13)


def table_by_scipy(curve, t_end, knots, v):
    """Return the velocity of a block that slides on a table, with μ g = 0.3 · 9.8."""
    place, t = np.array([0.0, v]), 0.0

    def rate(t, z):
        return [z[1], -0.3 * 9.8 * np.sign(z[1] - curve(t, 1))]

    for knot in [*[k for k in knots if 0 < k < t_end], t_end]:
        end = solve_ivp(rate, (t, knot), place, "DOP853", rtol=1e-12, atol=1e-14)
        place, t = end.y[:, -1], knot
    return place


def test_a_table_that_moves_by_a_spline_is_that_of_scipy(block):
    knots, values = np.linspace(0, 1, 6), np.array([0.0, 0.01, -0.02, 0.03, 0.0, 0.02])
    curve = CubicSpline(knots, values)
    table = {"times": knots, "values": values, "interpolation": "cubic"}
    start = {"x_dot": 6.0}
    run = block.run(start, t_end=0.9, inputs={"u": table})
    known = table_by_scipy(curve, 0.9, knots, 6.0)
    assert [run.final["x"], run.final["x_dot"]] == pytest.approx(known, rel=1e-11)
    assert run["slip_velocity"] == pytest.approx(run["x_dot"] - curve(run.t, 1), abs=1e-11)
    stuck = block.run({}, t_end=0.9, parameters={"mu": 5.0}, inputs={"u": table})
    # Without friction to spare it begins to slide and is caught: it follows the table.
    assert stuck.final["x_dot"] == pytest.approx(float(curve(0.9, 1)), abs=1e-10)


def test_a_motion_with_phases_is_kept_in_a_file(tmp_path):
    phases = [{"time": 2e-3, "law": "hertz"}, {"time": "3 ms", "parameters": {"mu": 0.2}}]
    run = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=5e-3, phases=phases)
    run.save(tmp_path / "run.npz")
    kept = ps.Trajectory.load(tmp_path / "run.npz")
    assert kept == run and kept.energy_residual == pytest.approx(run.energy_residual, abs=1e-14)
    at = run.sample(30)
    assert kept.values("normal_force", at) == pytest.approx(run.values("normal_force", at))
    again = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=5e-3, phases=kept.inputs["phases"])
    assert again == run and kept.inputs == run.inputs
    rest = ps.simulate("rod", "hertz", start=kept, t_end=6e-3)
    assert rest.t[0] == 5e-3 and rest.events == run.continued(6e-3).events[len(run.events) :]


def test_what_is_ahead_is_kept_where_a_motion_is_continued(block):
    force = {"times": [0, 0.3, 1], "values": [1, 9, -4], "interpolation": "linear"}
    given = {"inputs": {"F": force}, "phases": [{"time": 0.7, "parameters": {"mu": 0.1}}]}
    whole = block.run({"x_dot": 3.0}, t_end=1.0, **given)
    rest = block.run({"x_dot": 3.0}, t_end=0.4, **given).continued(1.0)
    assert rest.t[0] == 0.4 and rest.inputs["inputs"] == whole.inputs["inputs"]
    assert rest.final_state == pytest.approx(whole.final_state, rel=1e-12)


def test_a_contact_that_is_taken_away_lets_go():
    """The block lies on two feet; without B it falls onto that side about A."""
    start = {"y_A": 0.0, "theta": 0.0}
    laws = {"A": "rigid", "B": "rigid"}
    run = ps.simulate(
        "block-two-feet", laws, start, t_end=0.2, phases=[{"time": 0.1, "contacts": ["A"]}]
    )
    assert run["theta"][run.t <= 0.1] == pytest.approx(0, abs=1e-12)
    alone = ps.model("block-two-feet").only("A")
    known = ps.simulate(alone, "rigid", start, t_end=0.1)
    assert run.final["theta"] == pytest.approx(known.final["theta"], rel=1e-9)
    assert run.final["theta"] != 0 and run.final_forces["normal_force_B"] == 0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"phases": {"time": 1}}, "need a list"),
        ({"phases": [{"parameters": {"mu": 1}}]}, "phases[0]: got"),
        ({"phases": [{"time": -1}]}, "phases[0]: time: got -1, need"),
        ({"phases": [{"time": 1, "parametres": {}}]}, "Did you mean 'parameters'?"),
        ({"phases": [{"time": 1e-3, "parameters": {"nu": 1}}]}, "unknown parameter 'nu'"),
        ({"phases": [{"time": 1e-3, "contacts": ["floor"]}]}, "unknown contact 'floor'"),
        ({"phases": [{"time": 1e-3, "contacts": []}]}, "got none, need one at least"),
        ({"inputs": {"F": [1, 2]}}, "need a mapping such as"),
        ({"inputs": {"Q": {"times": [0], "values": [1]}}}, "unknown input or parameter 'Q'"),
        ({"inputs": {"F": {"times": [0, 0], "values": [1, 1]}}}, "later than the one before"),
        ({"inputs": {"F": {"times": [0, 1], "values": [1]}}}, "got 2 times and 1 values"),
        ({"inputs": {"F": {"times": [0], "values": ["x"]}}}, "values"),
        ({"inputs": {"F": {"times": [0], "values": [float("nan")]}}}, "finite numbers"),
        ({"inputs": {"m": {"times": [0], "values": [-1]}}}, "parameter m"),
        ({"inputs": {"F": {"times": [1, 2], "values": [1, 1]}}}, "need them from 0 s to 1 s"),
        (
            {"inputs": {"m": {"times": [0, 1], "values": [1, 2], "interpolation": "linear"}}},
            "declare it as an input",
        ),
        (
            {"inputs": {"F": {"times": [0, 1], "values": [1, 2], "interpolation": "cubic"}}},
            "declare it as an input",
        ),
    ],
)
def test_what_cannot_change_is_one_sentence(block, given, message):
    with pytest.raises(ps.InputError) as error:
        block.run({"x_dot": 1.0}, t_end=1.0, **given)
    assert message in str(error.value) and "\n" not in str(error.value)


RECORD = "t [ms], F [kN]\n0, 0\n100, 0.02\n400, -0.01\n1000, 0\n"
BY_LINES = {"times": [0, 0.1, 0.4, 1.0], "values": [0, 20, -10, 0], "interpolation": "linear"}


@pytest.fixture
def files(tmp_path):
    """Return the folder of a mechanism, a record and a scenario."""
    (tmp_path / "block.toml").write_text(BLOCK)
    (tmp_path / "record.csv").write_text(RECORD)
    (tmp_path / "case.toml").write_text(
        f"""
model = "{tmp_path}/block.toml"
law = "rigid"
t_end = 0.9
state = {{ x_dot = 5 }}
[[phases]]
time = "500 ms"
parameters = {{ mu = 0.1 }}
[inputs.F]
file = "{tmp_path}/record.csv"
interpolation = "linear"
"""
    )
    return tmp_path


def of_python(block, **given):
    phases = [{"time": 0.5, "parameters": {"mu": 0.1}}]
    return block.run({"x_dot": 5.0}, t_end=0.9, phases=phases, inputs={"F": BY_LINES}, **given)


def test_a_scenario_a_command_and_a_file_of_data_give_the_same_motion(block, files, capsys):
    known = of_python(block)
    of_file = Scenario.read(files / "case.toml").simulate()
    assert of_file.final == known.final and of_file.inputs["inputs"] == known.inputs["inputs"]
    words = ["simulate", str(files / "block.toml"), "--law", "rigid", "--state", "x_dot=5"]
    words += ["--t-end", "0.9", "--phases", "500 ms:mu=0.1", "--json"]
    assert main([*words, "--inputs", f"F={files}/record.csv:linear"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["final"]["state"] == known.final
    assert data["phases"] == [{"time": 0.5, "parameters": {"mu": 0.1}}]
    assert data["inputs"]["F"]["values"] == pytest.approx([0, 20, -10, 0])
    assert main(["simulate", str(files / "case.toml")]) == 0
    out = capsys.readouterr().out
    assert "phases 0.5:mu=0.1" in out and "record.csv:linear" in out and "F_t0" not in out


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "got no rows"),
        ("t [s],F [N]\n", "got 0 times"),
        ("t [s],F [m]\n0,1\n1,1\n", "need [N]"),
        ("t [s],G [N]\n0,1\n1,1\n", "unknown column 'F'"),
        ("t [s],F [N]\n0,1\n1\n", "line 3: got 1 cells, need 2"),
        ("t [s],F [N]\n0,1\n1,\n", "line 3, column F"),
        ("t [s],F [N]\n0,1\n1,inf\n", "line 3, column F"),
        ("t [s],F [N]\n1,1\n0,1\n", "later than the one before"),
        ("t [s],F [N],F [kN]\n0,1,1\n1,2,1\n", "there twice"),
        ("t [s],F [N]\n" + "".join(f"{k},1\n" for k in range(50_002)), "need 2 to 50000"),
    ],
)
def test_a_file_that_has_no_input_is_one_sentence(block, tmp_path, text, message):
    (tmp_path / "record.csv").write_text(text)
    given = {"F": {"file": str(tmp_path / "record.csv"), "interpolation": "linear"}}
    with pytest.raises(ps.InputError) as error:
        block.run({"x_dot": 1.0}, t_end=0.5, inputs=given)
    assert message in str(error.value) and "\n" not in str(error.value)


def test_a_file_may_have_its_columns_by_place(block, tmp_path):
    text = "a line to skip\n0;0,0;1\n100;20,0;2\n400;-10,0;3\n1000;0,0;4\n"
    (tmp_path / "record.csv").write_text(text)
    form = {"skip": 1, "separator": ";", "decimal": ","}
    table = {"file": str(tmp_path / "record.csv"), "time": "c1", "column": "c2", "csv": form}
    known = {"times": [0, 100, 400, 1000], "values": [0, 20, -10, 0]}
    runs = [block.run({"x_dot": 9.0}, t_end=0.9, inputs={"F": v}) for v in (table, known)]
    assert runs[0].final == runs[1].final


def test_rows_of_a_batch_are_single_motions(block):
    given = {"phases": [{"time": 0.5, "parameters": {"mu": 0.1}}], "inputs": {"F": BY_LINES}}
    start = {"x_dot": [4.0, 5.0, 6.0]}
    batch = run_batch(block, start, {"m": 2.0}, t_end=0.9, **given)
    assert batch["x"][1] == of_python(block).final["x"]
    assert batch.trajectory(1) == of_python(block)
    assert (
        batch["count_of_touchdown"].tolist() == [0, 0, 0] and max(batch["energy_residual"]) < 1e-9
    )
    for fault, message in (
        ({"phases": [{"time": 0.5, "law": "hertz"}]}, "got another law or contacts"),
        ({**given, "maxima": ("normal_force",)}, "extremes and integrals need"),
        ({"inputs": {"Q": BY_LINES}}, "unknown input or parameter 'Q'"),
    ):
        with pytest.raises(ps.InputError, match=message):
            run_batch(block, start, t_end=0.9, **fault)


def test_a_sweep_has_phases_and_inputs(block, files):
    text = (files / "case.toml").read_text() + "\n[axes]\nm = [2.0, 3.0]\n"
    (files / "sweep.toml").write_text(text)
    out = files / "sweep.npz"
    assert main(["sweep", str(files / "sweep.toml"), "--out", str(out)]) == 0
    known = [of_python(block, parameters={"m": m}).final["x_dot"] for m in (2.0, 3.0)]
    assert np.load(out)["x_dot"].tolist() == known


def test_a_fit_of_motions_with_inputs_gives_back_what_made_them(block, files):
    run = of_python(block, parameters={"m": 2.5, "mu": 0.27})
    times = np.linspace(0.05, 0.9, 18)
    data = {"t": times, "x": run.values("x", times)}
    phases = [{"time": 0.5, "parameters": {"mu": 0.1}}]
    given = {"phases": phases, "inputs": {"F": BY_LINES}, "state": {"x_dot": 5.0}}
    result = ps.fit(files / "block.toml", "rigid", data, ["m", "mu"], **given)
    assert result.estimate == pytest.approx([2.5, 0.27], rel=1e-7)


def test_a_fit_of_rows_has_inputs_too(block, files):
    times, values = [0, 0.2], [1.0, -2.0]
    given = {"inputs": {"F": {"times": times, "values": values}}, "until": "slip_stop"}
    speeds = [1.0, 2.0, 3.0, 1.5]
    runs = [block.run({"x_dot": v}, t_end=5.0, parameters={"mu": 0.25}, **given) for v in speeds]
    data = {"start x_dot": speeds, "end x": [run.final["x"] for run in runs]}
    result = ps.fit(files / "block.toml", "rigid", data, ["mu"], t_end=5.0, **given)
    assert result.estimate == pytest.approx([0.25], rel=1e-6)


def test_parameters_of_a_continued_motion_replace_those_of_past_phases(block):
    phases = [{"time": 0.2, "parameters": {"mu": 0.1}}, {"time": 0.6, "parameters": {"mu": 0.2}}]
    first = block.run({"x_dot": 5.0}, t_end=0.4, phases=phases)
    rest = first.continued(0.8, parameters={"mu": 0.5})
    loss = 9.8 * (0.2 * 0.3 + 0.2 * 0.1 + 0.2 * 0.5 + 0.2 * 0.2)
    assert rest.final["x_dot"] == pytest.approx(5 - loss, rel=1e-12)
    # A motion that ends where a phase begins leaves the phase to the next one.
    at_phase = block.run({"x_dot": 5.0}, t_end=0.2, phases=phases)
    assert at_phase.continued(0.4).final_state == pytest.approx(first.final_state, rel=1e-12)
    without = first.continued(0.8, phases=[])
    assert without.final["x_dot"] == pytest.approx(5 - 9.8 * (0.2 * 0.3 + 0.6 * 0.1), rel=1e-12)


def test_a_law_of_a_past_phase_remains_where_a_motion_is_continued():
    phases = [{"time": 2e-3, "law": "hertz"}]
    whole = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=5e-3, phases=phases)
    first = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=3e-3, phases=phases)
    rest = first.continued(5e-3)
    assert rest.law == "hertz" and rest.final == pytest.approx(whole.final, rel=1e-9)
    other = ps.simulate("rod", "hunt-crossley", start=first, t_end=5e-3)
    assert other.law == "hunt-crossley"


def test_limits_are_those_of_the_whole_motion(block):
    phases = [{"time": t, "parameters": {"mu": 0.1}} for t in (0.1, 0.2, 0.3)]
    whole = block.run({"x_dot": 5.0}, t_end=0.5, phases=phases)
    steps = whole.counters["accepted_steps"]
    assert steps == 4 and whole.stop_reason == "t_end"
    short = block.run({"x_dot": 5.0}, t_end=0.5, phases=phases, max_steps=2)
    assert short.stop_reason == "step_limit" and short.final_time == 0.2
    until = block.run({"x_dot": 0.5}, t_end=0.5, phases=phases, until="slip_stop")
    assert until.stop_reason == "until" and 0.2 < until.final_time < 0.5
    dense = [{"time": 1e-5 * k, "parameters": {"mu": 0.1}} for k in range(1, 50_002)]
    with pytest.raises(ps.InputError, match="need fewer than 50,000"):
        block.run({"x_dot": 0.5}, t_end=1.0, phases=dense)


def test_what_is_watched_is_watched_in_every_piece():
    phases = [{"time": 0.5, "parameters": {"g": 5.0}}]
    run = ps.simulate(
        "rod", "rigid", {"y_A": 6.0, "theta": 1.0}, t_end=0.9, watch="strobe(0.2)", phases=phases
    )
    assert [e.time for e in run.events_of("strobe")] == pytest.approx([0.2, 0.4, 0.6, 0.8])


def test_a_phase_before_the_start_of_a_motion_is_an_error():
    run = ps.simulate("rod", "hertz", {"theta": 1.0, "x_A_dot": -1.0}, t_end=1e-3)
    with pytest.raises(ps.InputError, match=r"got the time 0.0005 s, need times from 0.001 s on"):
        run.continued(2e-3, phases=[{"time": 5e-4, "parameters": {"mu": 0.5}}])
    at_once = run.continued(2e-3, phases=[{"time": 1e-3, "parameters": {"mu": 0.5}}])
    given = run.continued(2e-3, parameters={"mu": 0.5})
    assert at_once.final["theta_dot"] == pytest.approx(given.final["theta_dot"], rel=1e-12)
