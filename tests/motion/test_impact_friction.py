"""Impacts by the final slip, and a coefficient of restitution for each contact, in motions."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import painleve_sym as ps
from painleve_sym.at.delassus import Delassus
from painleve_sym.cli import main
from painleve_sym.engines.impacts import solve_simultaneous_impact
from painleve_sym.errors import InputError
from painleve_sym.study.sweeps.sweep import Sweep
from tests.motion.test_one_contact_as_several import agree
from tests.scenes import FEET
from tests.support import moreau, woodpecker

FINAL = {"restitution": "newton", "impact_friction": "final_slip"}
E = np.array([0.5, 0.0, 0.0])


def bird(by):
    names = ("beak", "low", "up")
    laws = {
        name: ps.RigidLaw("newton", e=e, impact_friction=by)
        for name, e in zip(names, E, strict=True)
    }
    return ps.Simulator("woodpecker", laws)


def beak_hits(run):
    return [e for e in run.events_of("impact") if e.impulses[0] > 0]


# ---- the woodpecker ----


def test_the_beak_hits_with_the_numbers_of_both_readings():
    """The sleeve leaves with 27.806 rad/s along the path, with 22.882 by the final slip."""
    rows = woodpecker.J[:2]
    inverse = np.linalg.inv(woodpecker.M)
    # Before the first hit of the motion below: the beak slides down the pole.
    u = np.array([-0.1346941152538514, -2.1834857654505386, 16.931435786142963])
    W, v = rows @ inverse @ rows.T, rows @ u
    turns = {}
    for by in ("path", "final_slip"):
        impact = solve_simultaneous_impact(W, [0.3], v, "newton", 0.5, impact_friction=by)
        turns[by] = (u + inverse @ rows.T @ impact.impulses)[1]
        assert impact.velocities[0] == pytest.approx(-0.5 * v[0])
    P = moreau.impulses(W, v * [1.5, 1], [0.3])
    assert turns["final_slip"] == pytest.approx((u + inverse @ rows.T @ P)[1])
    # The slip stops and turns round: along the path friction brakes first, then pushes.
    W_nt, W_tt = W[1]
    down, up = np.array([1, 0.3]), np.array([1, -0.3])
    stop = -v[1] / (W_nt + 0.3 * W_tt)
    rest = (-0.5 * v[0] - v[0] - W[0] @ down * stop) / (W[0] @ up)
    by_hand = (u + inverse @ rows.T @ (stop * down + rest * up))[1]
    assert v[1] < 0 < W_nt - 0.3 * W_tt and turns["path"] == pytest.approx(by_hand)
    assert turns == pytest.approx({"path": 27.806, "final_slip": 22.882}, abs=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("by", "turn"), [("path", 27.806), ("final_slip", 22.882)])
def test_the_sleeve_turns_as_the_reading_says(by, turn):
    run = bird(by).run(t_end=0.1)
    hit = next(e for e in beak_hits(run) if e.time > 0.05)
    assert hit.state["a_dot"] == pytest.approx(turn, abs=1e-3)
    assert run.choices["impact_friction"] == by
    # Newton's law of the beak, with its own coefficient; the sleeve clamps without rebound.
    before = next(e for e in run.events if e.time == hit.time)
    rates = before.state["gap_beak_dot"], hit.state["gap_beak_dot"]
    assert rates[1] == pytest.approx(-0.5 * rates[0], rel=1e-12)
    for event in run.events_of("impact"):
        low = event.impulses[2] > 0
        assert not low or abs(event.state["gap_low_dot"]) < 1e-12


@pytest.mark.slow
def test_the_limit_cycle_is_that_of_time_stepping_and_of_the_literature():
    run = bird("final_slip").run(t_end=2.0)
    hits = beak_hits(run)[-6:]
    period = np.diff([e.time for e in hits]).mean()
    fall = -np.diff([e.state["y"] for e in hits]).mean()
    assert period == pytest.approx(0.1460, abs=1e-4) and fall == pytest.approx(0.0195, abs=1e-4)
    # Leine, Glocker & van Campen (2001) start on their cycle, with four digits.
    times = np.linspace(1.8, 2.0, 20_001)
    turn, rate = run.values("b", times), run.values("b_dot", times)
    crossing = np.flatnonzero((turn[:-1] > -0.2788) & (turn[1:] <= -0.2788))
    assert rate[crossing] == pytest.approx(-7.4583, rel=2e-3)
    assert run.values("y_dot", times[crossing]) == pytest.approx(-0.3411, rel=1e-2)
    # Time stepping is of first order.
    step = 2e-5
    states = moreau.stepped(
        woodpecker.M,
        woodpecker.force,
        woodpecker.gaps,
        woodpecker.J,
        woodpecker.MU,
        E,
        *woodpecker.START,
        step,
        45_000,
    )
    rate = states[:, 1, 2]
    hits = np.flatnonzero((rate[:-1] > 1) & (rate[1:] < 0))[-4:]
    assert np.diff(hits).mean() * step == pytest.approx(period, abs=2e-4)
    assert -np.diff(states[hits, 0, 0]).mean() == pytest.approx(fall, abs=1e-4)


# ---- one contact ----


@pytest.mark.parametrize("e", [0.0, 0.6])
@settings(max_examples=10, deadline=None)
@given(
    theta=st.floats(0.3, 1.4),
    slip=st.floats(-1.0, 1.0),
    fall=st.floats(-1.0, 0.0),
    mu=st.floats(0.0, 2.5),
)
def test_one_contact_moves_as_asked_as_several(e, theta, slip, fall, mu):
    state = {"theta": theta, "x_A_dot": slip, "y_A_dot": fall, "theta_dot": 0.3}
    agree("rod", "newton by the final slip", state, {"mu": mu, "e_newton": e}, 1e-3)


def test_a_run_by_the_final_slip_has_the_impact_of_the_jump():
    rod, state = ps.model("rod"), {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -0.2, "y_A_dot": -1.0}
    for by in ("path", "final_slip"):
        jump = ps.evaluate_jump(rod, "newton", state, e=0.5, impact_friction=by)
        run = ps.simulate(rod, ps.RigidLaw("newton", e=0.5, impact_friction=by), state, t_end=1e-9)
        (end,) = run.events_of("impact_end")
        for name, value in jump.velocity.items():
            assert end.state[name] == pytest.approx(value, abs=1e-12)
        assert run.energy_residual < 1e-12


def test_engines_and_pieces_have_one_motion_by_the_final_slip():
    law = ps.RigidLaw("newton", e=0.5, impact_friction="final_slip")
    state = {"theta": 1.0, "y_A": 0.05, "x_A_dot": -0.3}
    run = ps.simulate("rod", law, state, t_end=0.3)
    others = [ps.Simulator("rod", law, name).run(state, t_end=0.3) for name in ("erk", "compiled")]
    others.append(ps.simulate("rod", law, state, t_end=0.12).continued(t_end=0.3))
    assert len(run.events_of("impact_end")) > 2
    for other in others:
        assert other.final == pytest.approx(run.final, abs=1e-12)


def test_a_final_slip_under_two_coefficients_is_left_open():
    """Slip by the friction of slip and stick by that of rest can both follow: the run stops."""
    law = ps.RigidLaw("newton", impact_friction="final_slip", friction="static")
    run = ps.simulate("rod", law, {"theta": 1.0, "y_A": 0.01}, t_end=0.2)
    assert run.stop_reason is ps.StopReason.VARYING_FRICTION


# ---- several contacts ----


def test_feet_rebound_each_with_its_own_coefficient():
    """A level block without friction: P_n of each foot follows from its own e by hand."""
    block = ps.model(FEET)
    laws = {"A": ps.RigidLaw("newton", e=0.8), "B": ps.RigidLaw("newton", e=0.2)}
    level = {"mu_A": 0, "mu_B": 0, "beta": 0, "a": 0.1}
    run = ps.simulate(block, laws, {"y_A": 0.01}, t_end=0.05, parameters=level)
    (hit, *_), v = run.events_of("impact"), np.sqrt(2 * run.parameters["g"] * 0.01)
    left, right = hit.state["y_A_dot"], hit.state["y_A_dot"] + 2 * 0.1 * hit.state["theta_dot"]
    assert (left, right) == pytest.approx((0.8 * v, 0.2 * v), rel=1e-9)
    assert {"e_newton_A": 0.8, "e_newton_B": 0.2}.items() <= run.parameters.items()


def test_final_slip_takes_newtons_law_alone():
    for law in ("energetic", "poisson"):
        with pytest.raises(InputError, match="need 'newton'"):
            ps.RigidLaw(law, impact_friction="final_slip")
        with pytest.raises(InputError, match="need 'newton'"):
            ps.solve_impact([[2, 0], [0, 1]], 0.5, (-1, 1), law, impact_friction="final_slip")
        with pytest.raises(InputError, match="need 'newton'"):
            ps.evaluate_jump("rod", law, {"theta": 1, "y_A_dot": -1}, impact_friction="final_slip")
    with pytest.raises(InputError, match="Did you mean 'final_slip'"):
        ps.RigidLaw("newton", impact_friction="finalslip")


def test_a_batch_has_the_rows_of_its_runs():
    block, laws = ps.model(FEET), {n: ps.RigidLaw(**FINAL) for n in "AB"}
    tilt, e = np.linspace(-0.1, 0.1, 5), np.linspace(0.1, 0.9, 5)
    start = {"y_A": 0.1, "x_A_dot": 0.2}
    batch = ps.simulate_batch(
        block, laws, start | {"theta": tilt}, t_end=0.3, law_parameters={"e_newton_B": e}
    )
    for i, (theta, own) in enumerate(zip(tilt, e, strict=True)):
        run = ps.simulate(
            block,
            laws,
            start | {"theta": float(theta)},
            t_end=0.3,
            law_parameters={"e_newton_B": float(own)},
        )
        assert batch.rows.state[i].tobytes() == run.final_state.tobytes()
        assert len(run.events_of("impact")) > 0


def test_a_saved_run_keeps_the_reading_and_begins_again(tmp_path):
    law = ps.RigidLaw("newton", e=0.5, impact_friction="final_slip")
    run = ps.simulate("rod", law, {"theta": 1.0, "y_A": 0.1, "x_A_dot": -0.1}, t_end=0.3)
    run.save(tmp_path / "run.npz")
    kept = ps.Trajectory.load(tmp_path / "run.npz")
    assert kept.choices == run.choices == law.choices
    again = ps.law(kept.inputs["law"], **kept.choices)
    assert again.choices == law.choices
    other = ps.simulate(
        "rod", again, kept.inputs["state"], t_end=0.3, law_parameters={"e_newton": 0.5}
    )
    assert other.final == run.final


def test_an_impact_with_several_final_slips_says_so():
    """A high block that slides on a foot with much friction as the other foot lands."""
    block, own = ps.model(FEET), {"mu_A": 1.12, "mu_B": 0.11, "h": 0.45, "a": 0.11, "beta": 0.0}
    state = {"x_A_dot": -1.7, "theta_dot": -2.0}
    laws = {n: ps.RigidLaw("newton", e=0.0, impact_friction="final_slip") for n in "AB"}
    run = ps.simulate(block, laws, state, t_end=1e-6, parameters=own)
    (first, *_) = run.events_of("impact")
    assert len(first.alternatives) == 3
    (notice,) = (text for text in run.notices if "has several final slips (" in text)
    assert first.alternatives[1] in notice
    at = Delassus.of(block).at({**run.parameters, **dict.fromkeys(block.state_names, 0.0), **state})
    given = at.W, at.mu, at.v, "newton", 0.0
    impact = solve_simultaneous_impact(*given, impact_friction="final_slip")
    assert not impact.is_unique
    assert first.impulses == pytest.approx(tuple(impact.impulses), abs=1e-14)
    # Both are final slips by the law itself, and the other one has more normal impulse.
    least = moreau.impulses(at.W, at.v, at.mu)
    assert impact.impulses == pytest.approx(least, abs=1e-12)


# ---- files and commands ----

SWEEP = """
model = "block-two-feet"
t_end = 0.15
state = { y_A = 0.01 }
parameters = { beta = 0.0, mu_A = 0.0, mu_B = 0.0 }
until = ["impact"]
keep = ["y_A_dot"]

[law]
name = "A=rigid,B=rigid"
restitution = "newton"
impact_friction = "final_slip"
parameters = { e_newton_B = 0.25 }

[axes]
e_newton_A = [0.0, 0.5, 1.0]
"""


def test_a_sweep_takes_the_coefficient_of_one_contact(tmp_path):
    (tmp_path / "feet.toml").write_text(SWEEP, "utf-8")
    data = Sweep.read(tmp_path / "feet.toml").compute(0, 3)
    speed = np.sqrt(2 * 9.8 * 0.01)
    assert data["y_A_dot"] == pytest.approx(np.array([0.0, 0.5, 1.0]) * speed, abs=1e-9)


def test_commands_say_which_slip_friction_opposes(capsys, tmp_path):
    state = ["--state", "theta=0.5,x_A_dot=0.3,y_A_dot=-1", "--set", "mu=0.3"]
    rules, seen = ["--rule", "newton", "--restitution", "0.5"], {}
    for by in ("path", "final_slip"):
        asked = [] if by == "path" else ["--impact-friction", by]
        assert main(["jump", "rod", *state, *rules, *asked, "--json"]) == 0
        seen[by] = json.loads(capsys.readouterr().out)
        assert seen[by]["impact_friction"] == by
        assert main(["jump", "rod", *state, *rules, *asked]) == 0
        assert f"(impact_friction {by})" in capsys.readouterr().out
    assert seen["path"]["case"] == "c_reversed" and seen["final_slip"]["case"] == "reversed"
    assert seen["path"]["final"]["velocity"] != seen["final_slip"]["final"]["velocity"]
    law = [
        "--law",
        "rigid",
        "--law-set",
        "restitution=newton,impact_friction=final_slip,e_newton=0.5",
    ]
    report = tmp_path / "run.html"
    words = ["simulate", "rod", *state, *law, "--t-end", "1e-4", "--report", str(report)]
    assert main(words) == 0
    assert "(impact_friction final_slip)" in " ".join(capsys.readouterr().out.split())
    text = report.read_text("utf-8")
    assert "final_slip" in text and "Moreau (1988)" in text and "Routh (1905)" not in text
    assert main([*words[:-2], "--json"]) == 0
    run = json.loads(capsys.readouterr().out)
    assert run["choices"]["impact_friction"] == "final_slip"
    (end,) = (e for e in run["events"] if e["kind"] == "impact_end")
    jump = seen["final_slip"]["final"]["velocity"]
    assert {n: end["state"][n] for n in jump} == pytest.approx(jump, abs=1e-12)
    assert main(["jump", "rod", *state, "--impact-friction", "final_slip"]) == 2
    assert "need 'newton'" in capsys.readouterr().err


def test_e_is_one_keyword_of_jumps_and_given_once():
    state = {"theta": 1.0, "y_A_dot": -1.0}
    jump = ps.evaluate_jump("rod", "newton", state, e=0.25)
    named = ps.evaluate_jump("rod", "newton", state, parameters={"e_newton": 0.25})
    assert jump == named and jump.velocity["y_A_dot"] == pytest.approx(0.25)
    with pytest.raises(InputError, match="give it once, as e"):
        ps.evaluate_jump("rod", "newton", state, e=0.25, parameters={"e_newton": 0.5})
    for e in (-0.1, 1.5):
        with pytest.raises(InputError, match="e_newton"):
            ps.evaluate_jump("rod", "newton", state, e=e)
    W, v = np.diag([1.0, 2.0, 1.0, 2.0]), [-1, 0, -1, 0]
    several = solve_simultaneous_impact(W, [0, 0], v, "poisson", [0.5, 0.25])
    assert several.velocities.tolist() == [0.5, 0, 0.25, 0]
    for e in ([0.5], [0.5, 0.5, 0.5], [0.5, -0.1]):
        with pytest.raises(InputError, match="e"):
            solve_simultaneous_impact(W, [0, 0], v, "poisson", e)
