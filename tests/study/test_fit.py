"""Parameters from synthetic data whose answer is known."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.laws.catalogue import law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.fitting.data import FitData, read_fit_data
from painleve_sym.study.fitting.problem import FitProblem, fit

FOLDER = Path(__file__).parents[2] / "examples" / "studies" / "fit"
TRUTH = {"e_energetic": 0.75, "mu": 1.4, "E": 20.9e10}
GUESS = {"e_energetic": 0.5, "mu": 1.35, "E": 5e10}
FALL = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0, "y_A_dot": -0.02}
TIMES = np.arange(0, 101) * 4e-5


@functools.cache
def simulator():
    return Simulator(model("rod"), law("bilinear-hertz"))


@functools.cache
def clean_force():
    run = simulator().run(FALL, parameters=TRUTH, t_end=1.001 * TIMES[-1])
    return run.values("normal_force", TIMES)


def history(force):
    return FitData("made up", TIMES, {}, {"normal_force": force})


def problem(data, estimate=tuple(TRUTH), state=FALL, parameters=GUESS, **more):
    return FitProblem(simulator(), data, tuple(estimate), state, parameters, **more)


def test_clean_data_give_the_parameters_back():
    fit = problem(history(clean_force()), sigma={"normal_force": 1.0}).solve()
    np.testing.assert_allclose(fit.estimate, list(TRUTH.values()), rtol=1e-7)


@pytest.mark.parametrize(("name", "state"), [("impacts.csv", {}), ("force.csv", FALL)])
def test_intervals_of_the_committed_data_hold_the_truth(name, state):
    data = read_fit_data(FOLDER / name, simulator().mechanism)
    fit = problem(data, state=state).solve()
    for i, parameter in enumerate(fit.names):
        low, high = fit.interval[i]
        assert low < TRUTH[parameter] < high
    assert fit.freedom == data.count - 3
    noise = {"y_A_dot": 2e-3, "theta_dot": 4e-3, "normal_force": 5.0}
    for column, value in fit.noise.items():
        assert value == pytest.approx(noise[column], rel=0.25)


def test_derivatives_of_the_model_are_its_differences():
    p = problem(history(clean_force()))
    at = np.array(list(GUESS.values()))
    slopes = p.predict(at)[1]["normal_force"]
    for k in range(3):
        h = np.zeros(3)
        h[k] = 1e-5 * at[k]
        moved = [p.predict(at + s * h)[0]["normal_force"] for s in (1, -1)]
        difference = (moved[0] - moved[1]) / (2 * h[k])
        scale = float(np.max(np.abs(difference)))
        np.testing.assert_allclose(slopes[:, k], difference, atol=2e-6 * scale)


@pytest.mark.parametrize(
    ("name", "state"),
    [
        ("pr-robot", {"theta": 0.927295, "x_dot": -1.0, "theta_dot": 1.0}),
        ("strut", {"theta": 0.927295, "theta_dot": 0.5}),
    ],
)
@pytest.mark.parametrize("quantity", ["normal_force", "gap", "slip_velocity", "theta_dot"])
@pytest.mark.slow
def test_a_history_is_fitted_where_the_gap_is_not_a_coordinate(name, state, quantity):
    simulator, times = Simulator(model(name), law("hertz")), np.linspace(0, 1.5e-4, 16)
    run = simulator.run(state, parameters={"mu": 0.9}, t_end=2e-4, rtol=1e-10)
    data = FitData("history", times, {}, {quantity: run.values(quantity, times)})
    fit = FitProblem(simulator, data, ("mu",), state, {"mu": 0.6}).solve()
    assert fit.estimate[0] == pytest.approx(0.9, abs=1e-6)


@pytest.mark.slow
def test_ninety_percent_intervals_hold_the_truth_nine_times_of_ten():
    rng, held = np.random.default_rng(5), np.zeros(3)
    runs = 60
    for _ in range(runs):
        force = clean_force() + 5.0 * rng.standard_normal(len(TIMES))
        fit = problem(history(force), parameters=TRUTH, level=0.9).solve()
        truth = np.array(list(TRUTH.values()))
        held += (fit.interval[:, 0] < truth) & (truth < fit.interval[:, 1])
    # Four standard deviations of a binomial count.
    assert np.all(np.abs(held - 0.9 * runs) < 4 * np.sqrt(0.09 * runs))


class Line(FitProblem):
    """A straight line through five points in place of a motion."""

    AT = np.linspace(0.0, 1.0, 5)

    def predict(self, values):
        slopes = np.stack([np.ones(5), self.AT], axis=1)
        return {"gap": slopes @ values}, {"gap": slopes}


@pytest.mark.parametrize("sigma", [None, {"gap": 0.1}])
def test_intervals_of_a_line_hold_the_truth_as_often_as_they_say(sigma):
    rng, truth, runs, level = np.random.default_rng(1), np.array([1.0, 2.0]), 500, 0.9
    held, variance = np.zeros(2), 0.0
    for _ in range(runs):
        data = FitData("line", Line.AT, {}, {"gap": 1 + 2 * Line.AT + 0.1 * rng.normal(size=5)})
        start = {"x_A": 0.5, "y_A": 0.5}
        fit = Line(simulator(), data, tuple(start), start, {}, sigma=sigma, level=level).solve()
        held += (fit.interval[:, 0] < truth) & (truth < fit.interval[:, 1])
        variance += fit.noise["gap"] ** 2 / runs
    # Four standard deviations of a binomial count, and of the mean of squares with 3 freedoms.
    assert np.all(np.abs(held - level * runs) < 4 * np.sqrt(level * (1 - level) * runs))
    assert variance == pytest.approx(0.01, rel=4 * np.sqrt(2 / 3 / runs))
    # Intercept and slope of a line over [0, 1] in five even points, by hand.
    expected = -0.5 / np.sqrt(0.5**2 + 0.125)
    assert fit.correlation == pytest.approx(np.array([[1, expected], [expected, 1]]), rel=1e-9)


def test_values_that_the_model_meets_have_no_noise_and_the_correlation_of_their_times():
    class Still(Line):
        def predict(self, values):
            slopes = super().predict(values)[1]
            return {"gap": np.zeros(5)}, slopes

    data = FitData("line", Line.AT, {}, {"gap": np.zeros(5)})
    fit = Still(simulator(), data, ("x_A", "y_A"), {"x_A": 0.5, "y_A": 0.5}, {}).solve()
    assert fit.noise == {"gap": 0.0} and fit.standard_error == pytest.approx(0.0, abs=0)
    assert pytest.approx(np.array([fit.estimate] * 2), abs=0) == fit.interval.T
    assert fit.correlation[0, 1] == pytest.approx(-0.5 / np.sqrt(0.5**2 + 0.125), rel=1e-9)


@pytest.mark.slow
def test_a_combination_that_the_data_leave_open_is_named():
    with pytest.raises(InputError, match="combination of E, R"):
        problem(history(clean_force()), ("E", "R"), parameters={}).solve()


def test_a_parameter_without_influence_is_named():
    flight = FitData("flight", TIMES, {}, {"theta": 1.0 + TIMES})
    with pytest.raises(InputError, match="do not depend on e_energetic"):
        problem(flight, state={"theta": 1.0, "y_A": 1.0}).solve()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"estimate": ("mue",)}, "Did you mean 'mu'"),
        ({"estimate": ()}, "nothing to estimate"),
        ({"estimate": ("mu", "mu")}, "twice"),
        ({"level": 1.0}, "level"),
        ({"sigma": {"theta": 1.0}}, "unknown column"),
        ({"sigma": {"normal_force": 0.0}}, "need a finite number > 0"),
    ],
)
def test_what_is_asked_is_checked(change, said):
    with pytest.raises(InputError, match=said):
        problem(history(np.ones(101)), **change)


def test_too_few_rows_are_refused():
    data = FitData("short", TIMES[:3], {}, {"normal_force": np.ones(3)})
    with pytest.raises(InputError, match="too few rows: got 3"):
        problem(data)


def test_a_motion_that_stops_before_the_data_is_refused():
    late = FitData("late", np.array([0.0, 1.0, 5.0, 9.0]), {}, {"theta": np.ones(4)})
    with pytest.raises(InputError, match=r"stops at t = .*left_domain"):
        problem(late).solve()


def test_a_row_without_its_event_is_named():
    data = FitData("rows", None, {"theta": np.ones(4)}, {"theta_dot": np.ones(4)})
    with pytest.raises(InputError, match="row 1: the motion ends by"):
        problem(data, state={"y_A": 10.0}, t_end=0.01).solve()


GOOD = "t [s],normal_force [N]\n0,1\n1e-3,2\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no rows"),
        ("normal_force [N]\n1\n", "t .s. is missing"),
        ("t [s]\n1\n", "no measured column"),
        ("t [mm],normal_force [N]\n1,2\n", r"got the unit \[mm\], need \[s\]"),
        ("t [s],theta [kg]\n1,2\n", r"got the unit \[kg\], need \[rad\]"),
        ("t [s],normal_force\n1,2\n", r"need NAME \[unit\]"),
        ("t [s],normal_forse [N]\n1,2\n", "Did you mean 'normal_force'"),
        ("t [s],t [s]\n1,2\n", "there twice"),
        ("t [s],normal_force [N]\n1\n", "line 2: got 1 cells, need 2"),
        ("t [s],normal_force [N]\n1,x\n", "line 2, column normal_force .N.: got 'x'"),
        ("t [s],normal_force [N]\n1,nan\n", "need a finite number"),
        ("t [s],normal_force [N]\n1,1e200\n", r"need a finite number of at most 1e\+100"),
        ("t [s],normal_force [N]\n,2\n", "column t: got an empty cell"),
        ("t [s],normal_force [N]\n2,2\n1,2\n", "do not decrease"),
        ("t [s],normal_force [N]\n1,\n", "no measured values"),
        ("t [s],end theta [rad]\n1,2\n", "with and without start or end"),
        ("start theta [rad]\n1\n", "no measured column"),
        ('t [s],theta [rad]\n0,"1\n",2\n', "line 2: not a row of a CSV file .quotes"),
        ('t [s],theta [rad]\n0,"1"2\n', "line 2: not a row of a CSV file"),
    ],
)
def test_data_files_are_checked(tmp_path, text, said):
    path = tmp_path / "data.csv"
    path.write_text(text, "utf-8")
    with pytest.raises(InputError, match=said):
        read_fit_data(path, simulator().mechanism)


def test_comments_empty_cells_and_spaces_are_read(tmp_path):
    path = tmp_path / "data.csv"
    path.write_text("# a comment\n\n t [s] , theta [rad], normal_force [N]\n0, 1.5,\n1,,3\n")
    data = read_fit_data(path, simulator().mechanism)
    assert data.count == 2
    np.testing.assert_array_equal(data.times, [0, 1])
    np.testing.assert_array_equal(data.measured["theta"], [1.5, np.nan])


def test_files_that_cannot_be_read_are_named(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        read_fit_data(tmp_path / "none.csv", simulator().mechanism)
    path = tmp_path / "binary.csv"
    path.write_bytes(b"\xff\xfe\x00t")
    with pytest.raises(InputError, match="not UTF-8 text"):
        read_fit_data(path, simulator().mechanism)


def test_the_least_squares_end_at_the_limit_of_evaluations():
    whole = problem(history(clean_force())).solve()
    assert whole.message.startswith("converged")
    limited = problem(history(clean_force()), max_evaluations=3).solve()
    assert limited.evaluations == 3 < whole.evaluations
    assert limited.message == "not converged: the limit of evaluations was reached"
    with pytest.raises(InputError, match="max_evaluations: got 0"):
        problem(history(clean_force()), max_evaluations=0)


def test_a_motion_that_takes_too_many_steps_is_named():
    with pytest.raises(InputError, match="step_limit"):
        problem(history(clean_force()), max_steps=3).solve()


# ---- rigid contacts ----

BALL = """
name = "dropped-ball"
gravity = "g"
[coordinates]
y = { unit = "m", meaning = "height" }
[parameters]
m = { default = 0.05, unit = "kg", meaning = "mass", positive = true }
g = { default = 9.81, unit = "m/s^2", meaning = "gravity", lower = 0 }
mu = { default = 0.0, unit = "1", meaning = "friction coefficient" }
[[bodies]]
mass = "m"
centre = ["0", "y"]
[[contacts]]
name = "floor"
gap = "y"
slip_velocity = "0"
friction = "mu"
"""
TWO = BALL.replace('"floor"\ngap = "y"', '"ceiling"\ngap = "1 - y"') + BALL[BALL.index("[[con") :]
REBOUNDS = (3.12, 3.10, 3.08, 3.16, 3.13)


EACH = {name: RigidLaw("newton", impact_friction="final_slip") for name in ("floor", "ceiling")}


@pytest.mark.parametrize(
    ("text", "event", "law", "name"),
    [
        (BALL, "impact_end", "rigid", "e_energetic"),
        (TWO, "impact", "rigid", "e_energetic"),
        (TWO, "impact", EACH, "e_newton_floor"),
    ],
)
def test_rigid_impacts_are_fitted_without_naming_their_event(tmp_path, text, event, law, name):
    """e is the mean rebound over sqrt(2 g h); its error is that of the mean of Gaussian numbers."""
    rows = "\n".join(f"0.65,{v}" for v in REBOUNDS)
    (tmp_path / "drops.csv").write_text(f"start y [m],end y_dot [m/s]\n{rows}\n")
    speed = np.sqrt(2 * 9.81 * 0.65)
    arguments = (mechanism_from_text(text), law, tmp_path / "drops.csv", name)
    fitted = fit(*arguments)
    assert fitted.estimate[0] == pytest.approx(np.mean(REBOUNDS) / speed, rel=1e-8)
    error = np.std(REBOUNDS, ddof=1) / np.sqrt(len(REBOUNDS)) / speed
    assert fitted.standard_error[0] == pytest.approx(error, rel=1e-6)
    assert fit(*arguments, until=event).estimate == pytest.approx(fitted.estimate, rel=1e-12)


def test_rows_of_a_contact_that_never_opens_need_an_event():
    contact = Simulator(model("painleve-klein"), "rigid")
    data = FitData("data", None, {}, {"x_dot": np.ones(3)})
    with pytest.raises(InputError, match=r"until: no contact.*Fix: name one of the events .*slip"):
        FitProblem(contact, data, ("mu",), {}, {}).solve()
