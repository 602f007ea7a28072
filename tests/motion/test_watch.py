"""Events that are watched, apexes, peaks, sections and strobes, against SciPy and closed forms."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import painleve_sym as ps
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from tests.cli.cli_helpers import rejected, run_json
from tests.motion.test_at_events import NO_MOTION_OF_TABLE, TABLE
from tests.motion.test_continuation import MOTIONS, assert_joined

ENGINES = ("taylor", "compiled", "erk")
TABLE_FILE = Path(__file__).parents[2] / "examples/mechanisms/oscillating-table.toml"
WATCHED = ("apex", "peak", "section", "strobe")
OSCILLATOR = """
name = "driven-oscillator"
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
m = { default = 2.0, unit = "kg", positive = true }
k = { default = 30.0, unit = "N/m" }
c = { default = 0.4, unit = "N s/m" }
F = { default = 3.0, unit = "N" }
omega = { default = 7.0, unit = "rad/s" }
mu = { default = 0.1, unit = "1" }
[[bodies]]
mass = "m"
centre = ["y", "x"]
[[springs]]
extension = "x"
stiffness = "k"
damping = "c"
[forces]
x = "F*sin(omega*t)"
[[contacts]]
name = "floor"
point = ["y", "x + 10"]
friction = "mu"
"""


def events_of(run, *kinds):
    return [e for e in run.events if e.kind in kinds]


@pytest.mark.parametrize("engine", ENGINES)
def test_the_apexes_of_a_bouncing_ball_are_e_to_the_2n_times_its_height(engine):
    height, e = 0.5, 0.7
    run = ps.simulate(
        TABLE,
        "rigid",
        {"y": height},
        t_end=2.0,
        parameters={**NO_MOTION_OF_TABLE, "e_energetic": e},
        watch="apex",
        engine=engine,
    )
    apexes = run.events_of("apex")[:12]
    heights = height * e ** (2 * np.arange(1, 13))
    assert [a.state["y"] for a in apexes] == pytest.approx(heights, rel=1e-9)
    assert [a.contact for a in apexes] == ["table"] * 12
    first = np.sqrt(2 * height / 9.8)
    flights = np.cumsum(2 * first * e ** np.arange(1, 13))
    assert [a.time for a in apexes] == pytest.approx(
        first + flights - first * e ** np.arange(1, 13), rel=1e-9
    )
    # Each impact turns the velocity: a maximum of energy at an instant.
    settled = run.events_of("settle")[0].time
    assert settled == pytest.approx(first * (1 + 2 * e / (1 - e)), rel=1e-8)


def test_apexes_of_bounces_that_die_out_do_not_end_them():
    e = np.linspace(0.2, 0.8, 61)
    batch = ps.simulate_batch(
        TABLE,
        "rigid",
        {"y": 0.5},
        t_end=4.0,
        parameters={**NO_MOTION_OF_TABLE, "e_energetic": e},
        watch="apex",
    )
    assert set(batch["stop_reason"]) == {"t_end"} and batch["count_of_settle"].tolist() == [1] * 61
    first = np.sqrt(2 * 0.5 / 9.8)
    assert batch["time_of_settle"] == pytest.approx(first * (1 + 2 * e / (1 - e)), rel=1e-8)


@pytest.fixture(scope="module")
def oscillator():
    return mechanism_from_text(OSCILLATOR, "oscillator.toml", "oscillator")


@pytest.mark.parametrize("engine", ENGINES)
def test_they_are_where_scipy_locates_them(oscillator, engine):
    m, k, c, F, omega, end = 2.0, 30.0, 0.4, 3.0, 7.0, 6.0

    def rates(t, y):
        return [y[1], (F * np.sin(omega * t) - c * y[1] - k * y[0]) / m]

    def peak(t, y):
        return y[1]

    def section(t, y):
        return y[0] - 0.03 * t

    def fastest(t, y):
        return y[1] * rates(t, y)[1]

    for event in (peak, section, fastest):
        event.direction = -1
    known = solve_ivp(
        rates,
        (0, end),
        [0.2, 0.0],
        "DOP853",
        rtol=1e-12,
        atol=1e-14,
        events=[peak, section, fastest],
        dense_output=True,
    )
    watch = ("apex(x)", "peak(kinetic_energy)", "section(x - 0.03*t)", "strobe(2*pi/omega, 0.1)")
    run = ps.simulate(oscillator, "rigid", {"x": 0.2}, t_end=end, watch=watch, engine=engine)
    for kind, times in zip(("apex", "section", "peak"), known.t_events, strict=True):
        # The start is at rest at a maximum, with which no list begins.
        expected = times[times > 1e-9]
        assert len(expected) >= 3
        assert [e.time for e in run.events_of(kind)] == pytest.approx(expected, abs=1e-8)
    strobes = run.events_of("strobe")
    times = np.arange(0.1, end, 2 * np.pi / omega)
    assert [s.time for s in strobes] == pytest.approx(times, rel=1e-12)
    states = np.array([[s.state["x"], s.state["x_dot"]] for s in strobes])
    assert states == pytest.approx(known.sol(times).T, abs=1e-8)
    assert run.final["x"] == pytest.approx(known.y[0, -1], abs=1e-9)


@pytest.mark.parametrize("name", MOTIONS)
def test_what_is_watched_changes_nothing(name):
    mechanism, law, state, t_end, engine = MOTIONS[name]
    whole = ps.simulate(mechanism, law, state, t_end=t_end, engine=engine)
    watch = ("apex", "apex(theta)", "peak(x_A_dot)", "strobe(0.013)")
    seen = ps.simulate(mechanism, law, state, t_end=t_end, engine=engine, watch=watch)
    n = len(whole.state_names)
    assert seen.state_names[:n] == whole.state_names
    size = np.maximum(np.abs(whole.final_state), 1e-3)
    assert np.max(np.abs(seen.final_state[:n] - whole.final_state) / size) < 1e-8
    own = [e for e in seen.events if e.kind not in WATCHED]
    ends = [e.time for e in whole.events if e.kind == "settle"]
    last = ends[0] * (1 - 1e-6) if ends else np.inf
    own, known = ([e for e in events if e.time < last] for events in (own, whole.events))
    assert [(e.kind, e.contact) for e in own] == [(e.kind, e.contact) for e in known]
    assert [e.time for e in own] == pytest.approx([e.time for e in known], rel=1e-8)
    strobes = [e.time for e in seen.events_of("strobe")]
    assert strobes == pytest.approx(np.arange(1, len(strobes) + 1) * 0.013, rel=1e-12)
    assert len(strobes) == int(t_end / 0.013) and seen.energy_closes


@settings(max_examples=4)
@given(part=st.floats(0.05, 0.95))
@pytest.mark.parametrize("name", ["damped", "rigid", "rigid feet"])
def test_a_watched_motion_cut_anywhere_and_continued_is_the_whole_one(name, part):
    mechanism, law, state, t_end, engine = MOTIONS[name]
    t_end = min(t_end, 0.3)

    def run(t_end):
        watch = ("apex", "peak(x_A_dot)", "strobe(0.07, 0.01)")
        return ps.simulate(mechanism, law, state, t_end=t_end, engine=engine, watch=watch)

    whole, first = run(t_end), run(part * t_end)
    assert_joined(first, first.continued(t_end), whole)


def test_they_end_a_motion_that_continues():
    start = {"y_A": 0.1, "theta": 0.9}
    whole = ps.simulate("rod", "rigid", start, t_end=0.4, watch="apex")
    apex = whole.events_of("apex")[0]
    for until in ("apex", "before_apex"):
        top = ps.simulate("rod", "rigid", start, t_end=0.4, watch="apex", until=until)
        assert top.stop_reason is ps.StopReason.UNTIL
        assert top.final_time == pytest.approx(apex.time, rel=1e-10)
        assert top.final["y_A_dot"] == pytest.approx(0, abs=1e-10) and top.final["y_A"] > 0
        assert_joined(top, top.continued(0.4), whole)
    with pytest.raises(ps.InputError, match="unknown event 'apex'"):
        ps.simulate("rod", "rigid", start, t_end=0.4, until="apex")


def test_a_maximum_at_a_corner_is_one():
    """A bilinear contact has its greatest force where compression ends, with a corner there."""
    run = ps.simulate(
        "rod",
        "bilinear-hertz",
        {"y_A": 0.1, "theta": 0.9},
        t_end=0.3,
        watch="peak(normal_force), peak(kinetic_energy)",
    )
    (force,) = [e for e in run.events_of("peak") if e.quantity == "normal_force"]
    (greatest,) = run.events_of("max_compression")
    assert force.time == greatest.time
    assert force.normal_force == pytest.approx(greatest.normal_force, rel=1e-14)
    energy = [e.time for e in run.events_of("peak") if e.quantity == "kinetic_energy"]
    # A compliant contact takes a moment until its force exceeds the weight.
    assert run.events_of("touchdown")[0].time < energy[0] < greatest.time
    stiff = ps.simulate(
        "rod", "rigid", {"y_A": 0.1, "theta": 0.9}, t_end=0.2, watch="peak(kinetic_energy)"
    )
    assert stiff.events_of("peak")[0].time == stiff.events_of("touchdown")[0].time


def test_a_peak_of_force_is_that_of_a_batch():
    start = {"y_A": 0.1, "theta": 0.9}
    batch = ps.simulate_batch(
        "rod",
        "hunt-crossley",
        start,
        t_end=0.3,
        maxima=("normal_force",),
        watch="peak(normal_force)",
        at_events=("normal_force_before_peak",),
    )
    assert batch["normal_force_before_peak"][0] == pytest.approx(
        batch["max_normal_force"], rel=1e-12
    )
    assert batch["time_of_peak"] == pytest.approx(batch["max_normal_force_time"], rel=1e-7)
    assert batch["count_of_peak"] == 1


def test_the_derivatives_of_an_apex_are_those_of_its_closed_form():
    """Height e² h at the time √(2 h/g) (1 + e)."""
    simulator = ps.Simulator(TABLE, "rigid", watch="apex")
    h, e, g = 0.5, 0.7, 9.8
    given_ = {**NO_MOTION_OF_TABLE, "e_energetic": e}
    result = simulator.sensitivities(
        {"y": h}, ["y", "e_energetic"], parameters=given_, t_end=2.0, until="apex"
    )
    place = result.trajectory.state_names.index("y")
    assert result.final_jacobian[place] == pytest.approx([e**2, 2 * e * h], rel=1e-8)
    fall = np.sqrt(2 * h / g)
    assert result.final_time_gradient == pytest.approx([fall / h / 2 * (1 + e), fall], rel=1e-8)


def test_a_fit_takes_heights_of_rebounds(capsys, tmp_path):
    """Heights alone give e: e² is the slope of heights after over heights before, by hand."""
    rng = np.random.default_rng(1)
    dropped = np.linspace(0.2, 1.0, 12)
    rebounds = 0.78 * dropped * np.exp(0.02 * rng.standard_normal(12))
    file = tmp_path / "rebounds.csv"
    rows = zip(dropped.tolist(), rebounds.tolist(), strict=True)
    file.write_text("start y [m],end y [m]\n" + "".join(f"{a!r},{b!r}\n" for a, b in rows))
    result = ps.fit(
        TABLE,
        "rigid",
        file,
        ["e_energetic"],
        parameters=NO_MOTION_OF_TABLE,
        state={},
        watch="apex",
        until="apex",
    )
    share = (rebounds @ dropped) / (dropped @ dropped)
    assert result.estimate[0] == pytest.approx(np.sqrt(share), rel=1e-6)
    case = ("--estimate", "e_energetic", "--law", "rigid", "--set", "a=0,b=0", "--state", "x_dot=0")
    data = run_json(capsys, "fit", file, TABLE_FILE, *case, "--watch", "apex", "--until", "apex")
    (estimate,) = data["estimates"]
    assert estimate["estimate"] == pytest.approx(np.sqrt(share), rel=1e-6)


def test_strobes_of_a_sweep_show_the_period(tmp_path, monkeypatch):
    """A ball that bounces once a period is at the same place at each strobe."""
    monkeypatch.chdir(Path(__file__).parents[2])
    file = tmp_path / "ball.toml"
    file.write_text(SWEEP)
    ps.sweep(file, tmp_path / "ball.npz")
    with np.load(tmp_path / "ball.npz") as data:
        last = data["y_after_strobe"][:, -20:]
        assert data["count_of_strobe"].tolist() == [190, 190]
    assert np.ptp(last[0]) < 1e-4 and np.ptp(last[1]) > 1e-3
    assert np.ptp(last[1, ::2]) < 1e-4 and np.ptp(last[1, 1::2]) < 1e-4


SWEEP = """model = "examples/mechanisms/oscillating-table.toml"
t_end = 29.9
rtol = 1e-9
state = { y = 0.036, y_dot = 0.0 }
parameters = { b = 0.0, mu = 0.0, omega = 40.0, phase = -2.42 }
watch = ["strobe(2*pi/omega)"]
keep = ["y_after_strobe"]
events = 189
[law]
name = "rigid"
parameters = { e_energetic = 0.5 }
[axes]
a = [0.0085, 0.0097]
"""

CASE = """model = "rod"
law = "rigid"
t_end = 0.4
watch = ["apex", "strobe(0.1)"]
state = { y_A = 0.1, theta = 0.9 }
"""


def test_a_file_and_the_command_line_say_it(capsys, tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(CASE)
    data = run_json(capsys, "simulate", file)
    kinds = [e["kind"] for e in data["events"]]
    assert kinds.count("strobe") == 4 and kinds.count("apex") == 1
    case = ("simulate", "rod", "--law", "rigid", "--t-end", "0.4", "--state", "y_A=0.1,theta=0.9")
    again = run_json(capsys, *case, "--watch", "apex, strobe(0.1, 0)")
    assert [e["time"] for e in again["events"]] == [e["time"] for e in data["events"]]
    strobe = next(e for e in again["events"] if e["kind"] == "strobe")
    assert strobe["quantity"] == "0.1, 0"
    assert "unknown event 'apx'. Did you mean 'apex'" in rejected(capsys, *case, "--watch", "apx")


def test_they_are_kept_in_files_and_tables(tmp_path):
    run = ps.simulate(
        "rod", "rigid", {"y_A": 0.1, "theta": 0.9}, t_end=0.4, watch="apex(theta), apex"
    )
    run.save(tmp_path / "run.npz")
    loaded = ps.Trajectory.load(tmp_path / "run.npz")
    assert loaded.events == run.events and loaded.inputs["watch"] == ["apex(theta)", "apex"]
    assert pickle.loads(pickle.dumps(run)) == run
    frame = run.events_to_dataframe()
    apexes = frame[frame["kind"] == "apex"]
    assert apexes["quantity"].tolist()[-1] == "" and apexes["contact"].tolist()[-1] == "A"
    simulator = ps.Simulator("rod", "rigid", watch="apex")
    assert pickle.loads(pickle.dumps(simulator)).watch == ("apex",)
    with pytest.raises(ps.InputError, match="the motion before watches 'apex"):
        ps.simulate("rod", "rigid", start=loaded, t_end=0.5)
    again = ps.simulate("rod", "rigid", start=loaded, t_end=0.5, watch=loaded.inputs["watch"])
    assert again == run.continued(0.5)


def test_strobes_keep_their_phase_where_laws_change():
    start = {"y_A": 0.1, "theta": 0.9}
    first = ps.simulate("rod", "rigid", start, t_end=0.12, watch="strobe(0.001, 0.0005)")
    rest = ps.simulate("rod", "hertz", start=first, t_end=0.2, watch="strobe(0.001, 0.0005)")
    times = [e.time for run in (first, rest) for e in run.events_of("strobe")]
    assert times == pytest.approx((np.arange(200) + 0.5) / 1000, rel=1e-12)


@pytest.mark.parametrize(
    ("watch", "message"),
    [
        ("apx", "unknown event 'apx'. Did you mean 'apex'"),
        ("peak", r"got 'peak', need peak\(normal_force\)"),
        ("peak(normal_forc)", "unknown quantity 'normal_forc'. Did you mean 'normal_force'"),
        ("apex(y_A", "Fix: close the bracket"),
        ("apex, apex", "got 'apex:A' twice"),
        ("strobe()", r"need strobe\(0.1\) with a period"),
        ("strobe(1, 2, 3)", r"need strobe\(0.1\) with a period"),
        ("strobe(-1)", "got no period > 0"),
        ("strobe(theta)", "unknown"),
        ("section(theta +)", "section"),
        ("section(__import__('os'))", "section"),
        (7, "need names, such as 'apex'"),
    ],
)
def test_what_cannot_be_watched_is_one_sentence(watch, message):
    with pytest.raises(ps.InputError, match=message):
        ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 0.9}, t_end=0.1, watch=watch)


def test_forces_that_solve_a_system_have_no_peak():
    with pytest.raises(ps.InputError, match="its rate is not known"):
        ps.simulate(
            "block-two-feet", "rigid", {"y_A": 0.01}, t_end=0.1, watch="peak(normal_force_A)"
        )


def test_exported_c_records_them(tmp_path):
    export = ps.export_c(
        "rod",
        "rigid",
        {"y_A": 0.1, "theta": 0.9},
        folder=tmp_path / "rod",
        t_end=0.4,
        watch="apex, strobe(0.1)",
        until="before_apex",
    )
    kinds = [str(e.kind) for e in export.trajectory.events]
    assert kinds.count("strobe") == 2
    expected = (tmp_path / "rod" / "expected.txt").read_text()
    assert expected.count(" strobe: flight to flight") == 2 and "apex" not in expected
    assert "options.until[rod_event_apex] = 2;" in (tmp_path / "rod" / "main.c").read_text()


def test_a_motion_in_phases_watches_all_of_it():
    phases = [{"time": 0.12, "law_parameters": {"e_energetic": 0.3}}]
    start, watch = {"y_A": 0.1, "theta": 0.9}, "apex, strobe(0.05)"
    run = ps.simulate("rod", "rigid", start, t_end=0.31, phases=phases, watch=watch)
    assert [e.time for e in run.events_of("strobe")] == pytest.approx(0.05 * np.arange(1, 7))
    first = ps.simulate("rod", "rigid", start, t_end=0.12, watch=watch)
    rest = first.continued(0.31, law_parameters={"e_energetic": 0.3})
    apexes = [e.time for piece in (first, rest) for e in piece.events_of("apex")]
    assert [e.time for e in run.events_of("apex")] == apexes and apexes
    assert run.inputs["watch"] == ["apex", "strobe(0.05)"]
