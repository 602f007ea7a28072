"""Bilateral contacts: solutions, tangential impacts and motion, by hand and by SciPy."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from painleve_sym.at.cases import classify
from painleve_sym.at.classification import solution_name
from painleve_sym.at.tangential import tangential_impact
from painleve_sym.automata.guide import TANGENTIAL_IMPACT
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, StopReason
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.toml.mechanism_file import load_mechanism
from painleve_sym.motion.simulator import Simulator
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.solution import ContactCase
from tests.oracles.bead_scipy import accelerations, motion, slip_forces, yielding

BEAD = Path(__file__).parents[2] / "examples" / "mechanisms" / "bead-in-groove.toml"
KLEIN = {"phi": 1.2, "x_dot": 1.0}
JAMMED = {"phi": 0.4, "x_dot": 1.0, "phi_dot": 9.0}
MOVES = ("x", "phi", "x_dot", "phi_dot")


@cache
def klein():
    return model("painleve-klein")


@cache
def bead():
    return load_mechanism(BEAD)


@cache
def simulator(policy="liftoff", of=bead):
    return Simulator(of(), RigidLaw(policy=policy))


def by_hand(phi, s, m_1, m_2, mu, P_1, P_2, g=9.8):
    """Klein's blocks: forces of the rough guide with s = sign(v), rod force S along the rod.

    (m_1 + m_2) a = P_1 + P_2 + F_t;  m_2 a = P_2 + S cos phi;  N = m_1 g + S sin phi.
    """
    events = []
    for side in (1, -1):
        t = math.tan(phi)
        # N = m_1 g + t (m_2 a - P_2) and a = (P_1 + P_2 - mu s side N)/(m_1 + m_2).
        share = m_2 / (m_1 + m_2)
        normal = (m_1 * g + t * (share * (P_1 + P_2) - P_2)) / (1 + t * share * mu * s * side)
        if normal * side > 0:
            events.append(normal)
    return sorted(events)


# ---- states ----


@pytest.mark.parametrize("mu", [0.3, 0.77, 0.79, 2.0])
@pytest.mark.parametrize("s", [-1, 1])
@pytest.mark.parametrize("P_2", [-5.0, 7.0, 8.0, 40.0])
def test_klein_has_the_forces_of_the_hand_calculation(mu, s, P_2):
    parameters = {"mu": mu, "P_2": P_2, "P_1": 0.7, "m_1": 1.3}
    classification = classify(klein(), KLEIN | {"x_dot": 0.4 * s}, parameters=parameters)
    expected = by_hand(1.2, s, 1.3, 1.0, mu, 0.7, P_2)
    assert [x.normal_force for x in classification.solutions] == pytest.approx(expected, rel=1e-12)
    assert len(expected) == 1 or mu * math.tan(1.2) > 2.3


@pytest.mark.parametrize("m_1, m_2, phi", [(1.0, 1.0, 1.2), (2.0, 0.5, 0.9), (0.3, 4.0, 0.2)])
def test_klein_paradox_begins_at_the_ratio_of_the_masses(m_1, m_2, phi):
    """Klein's condition: μ tanφ > (m_1 + m_2)/m_2, that is 2 for equal masses."""
    limit = (m_1 + m_2) / m_2 / math.tan(phi)
    masses = {"m_1": m_1, "m_2": m_2, "phi_0": phi}
    for factor, paradox in ((1 - 1e-9, False), (1 + 1e-9, True)):
        state = {"phi": phi, "x_dot": 1.0}
        classification = classify(klein(), state, parameters=masses | {"mu": factor * limit})
        assert (classification.coefficients[0].excess > 0) is paradox
        other = classify(
            klein(), state | {"x_dot": -1.0}, parameters=masses | {"mu": factor * limit}
        )
        counts = sorted((len(classification.solutions), len(other.solutions)))
        assert counts == ([0, 2] if paradox else [1, 1])


def test_klein_cases_are_named():
    cases = [
        ({}, KLEIN, ContactCase.INDETERMINATE),
        ({}, KLEIN | {"x_dot": -1.0}, ContactCase.INCONSISTENT),
        ({"mu": 0.5}, KLEIN, ContactCase.SLIP),
        ({}, KLEIN | {"x_dot": 0.0}, ContactCase.STICK),
        ({"P_1": -100.0, "P_2": -90.0}, KLEIN | {"x_dot": 0.0}, ContactCase.INDETERMINATE),
    ]
    for parameters, state, case in cases:
        classification = classify(klein(), state, parameters=parameters)
        assert classification.case is case, (parameters, state)
        assert all(s.residual < 1e-12 for s in classification.solutions)


def test_classification_as_plain_data():
    data = classify(klein(), KLEIN).to_dict()
    (name, own), *_ = data["contacts"].items()
    assert (data["case"], own["kind"]) == ("indeterminate", "bilateral")
    names = [s["contacts"][name]["name"] for s in data["solutions"]]
    assert names == ["slip_pos/pull_unstable", "slip_pos/push"]
    assert own["A"] + own["A_pull"] == pytest.approx(2 * data["W"][0][0])


@pytest.mark.parametrize("change", [{"phi": 1.1}, {"phi_dot": 0.5}])
def test_a_state_off_the_guide_is_refused_in_one_sentence(change):
    calls = (
        lambda: classify(klein(), KLEIN | change),
        lambda: tangential_impact(klein(), KLEIN | change),
        lambda: simulator(of=klein).run(KLEIN | change, t_end=0.1),
    )
    for call in calls:
        with pytest.raises(InputError, match=r"holds its point.*Fix: start on the guide"):
            call()


def test_kinds_of_contact_are_told_apart():
    with pytest.raises(InputError, match=r"its contact can open. Fix: use evaluate_jump"):
        tangential_impact(model("rod"), {"theta": 1.0})


# ---- tangential impacts ----

states = st.fixed_dictionaries(
    {
        "phi": st.floats(-3, 3),
        "phi_dot": st.floats(-10, 10),
        "x_dot": st.floats(0.1, 3) | st.floats(-3, -0.1),
    }
)
parameters = st.fixed_dictionaries({"mu": st.floats(0, 4), "M": st.floats(0.02, 2)})


@given(states, parameters)
@example(JAMMED, {"mu": 1.5, "M": 0.05})  # an impact, which few of the drawn states have
@settings(max_examples=20)
def test_tangential_impact_exists_where_a_slip_may_have_no_solution(state, values):
    classification = classify(bead(), state, parameters=values)
    if classification.coefficients[0].excess < 0:
        with pytest.raises(InputError, match="tangential impact"):
            tangential_impact(bead(), state, parameters=values)
        return
    jump = tangential_impact(bead(), state, parameters=values)
    p = classification.problem
    change = np.array([[p.W_nn, p.W_nt], [p.W_nt, p.W_tt]]) @ [
        jump.normal_impulse,
        *jump.tangential_impulse,
    ]
    assert change == pytest.approx([0, -state["x_dot"]], abs=1e-9)
    assert abs(jump.tangential_impulse[0]) <= p.mu * abs(jump.normal_impulse) * (1 + 1e-9)
    assert abs(jump.velocity["x_dot"]) < 1e-12 and abs(jump.velocity["y_dot"]) < 1e-9
    # The groove is at rest: kinetic energy falls by the work of friction, by hand.
    M, m, L = values["M"], 1.0, 0.5
    energies = []
    for v in (jump.velocity_before, jump.velocity):
        v_x = v["x_dot"] + L * math.cos(state["phi"]) * v["phi_dot"]
        v_y = L * math.sin(state["phi"]) * v["phi_dot"]
        energies.append(M * v["x_dot"] ** 2 / 2 + m * (v_x**2 + v_y**2) / 2)
    scale = max(energies)
    assert energies[1] - energies[0] == pytest.approx(jump.energy_change, abs=1e-9 * scale)


def test_tangential_impact_is_the_limit_of_a_stiff_damped_groove():
    """A groove that yields, by SciPy: the distance falls like the root of the compliance."""
    assert slip_forces(1, 0.4, 9.0, 1.5, 0.05) == []
    jump = tangential_impact(bead(), JAMMED, parameters={"mu": 1.5})
    limit = [jump.velocity[n] for n in ("x_dot", "y_dot", "phi_dot")]
    assert limit[2] == pytest.approx(10.84212198800577, rel=1e-12)
    errors = [
        np.max(np.abs(yielding((0, 0.4, 1.0, 9.0), K, 1.5, 0.05) - limit)) for K in (1e8, 1e10)
    ]
    assert errors[1] < 6e-3
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.1)


def test_tangential_impact_needs_a_slip():
    with pytest.raises(InputError, match="v_t = 0"):
        tangential_impact(klein(), KLEIN | {"x_dot": 0.0})


# ---- motion ----


@pytest.mark.parametrize("mu, w", [(0.3, 9.0), (0.6, 12.0), (0.5, -10.0)])
def test_motion_and_events_agree_with_scipy(mu, w):
    run = simulator().run(
        {"phi": 1.0, "x_dot": 1.0, "phi_dot": w}, t_end=2.0, parameters={"mu": mu}
    )
    final, events = motion((0, 1.0, 1.0, w), 2.0, mu, 0.05)
    assert [run.final[n] for n in MOVES] == pytest.approx(list(final), rel=1e-8, abs=1e-8)
    own_events = [e for e in run.events if e.kind != "contact"]
    assert [e.kind for e in own_events] == [kind for _, kind in events]
    assert [e.time for e in own_events] == pytest.approx([t for t, _ in events], abs=1e-9)
    assert run.energy_residual < 1e-9
    assert run.final["y"] == run.final["y_dot"] == 0


def test_second_engine_agrees():
    start, options = {"phi": 1.0, "x_dot": 1.0, "phi_dot": 12.0}, {"parameters": {"mu": 0.6}}
    run = simulator().run(start, t_end=0.3, **options)
    other = Simulator(bead(), RigidLaw(), "erk").run(start, t_end=0.3, **options)
    assert [e.kind for e in other.events] == [e.kind for e in run.events]
    times = [e.time for e in other.events]
    assert [e.time for e in run.events] == pytest.approx(times, abs=1e-9)


def test_round_off_off_the_guide_is_no_fault():
    run = simulator().run({"phi": 0.5, "x_dot": 1.0, "y": -1e-13}, t_end=1e-3)
    assert run.stop_reason is StopReason.T_END


def test_klein_slides_by_constant_force_and_then_sticks():
    run = simulator(of=klein).run(KLEIN, t_end=1.0)
    (force,) = [n for n in by_hand(1.2, 1, 1, 1, 0.9, 0, 1.0) if n > 0]
    assert run.outputs([0.3])["normal_force"][0] == pytest.approx(force, rel=1e-12)
    rate = (1.0 - 0.9 * force) / 2
    (stop,) = run.events_of("slip_stop")
    assert stop.time == pytest.approx(-1 / rate, rel=1e-12)
    assert run.events[0].alternatives == ("slip_pos/pull_unstable", "slip_pos/push")
    # At rest the smooth guide carries P_2 as far as the rod pulls: F_t = −P_2 on the lower block.
    assert run.final_outputs["tangential_force"] == pytest.approx(-1.0, rel=1e-12)
    assert run.energy_residual < 1e-12


@pytest.mark.parametrize("policy, mode", [("slip", "slip_pos/pull_unstable"), ("impact", None)])
def test_policies_take_the_other_answers(policy, mode):
    run = simulator(policy, klein).run(KLEIN, t_end=0.01)
    first = run.events[0]
    assert first.mode_after == (mode or TANGENTIAL_IMPACT)
    assert first.alternatives == ("slip_pos/pull_unstable", "slip_pos/push")
    assert run.choices == {"policy": policy}
    if mode:
        force = run.outputs([0.001])["normal_force"][0]
        assert force == pytest.approx(by_hand(1.2, 1, 1, 1, 0.9, 0, 1.0)[0], rel=1e-12)
    else:
        assert run.final["x_dot"] == 0 and run.energy_residual < 1e-12


def test_inconsistent_state_stops_the_slip_at_once():
    run = simulator().run(JAMMED, t_end=0.05, parameters={"mu": 1.5})
    assert [e.kind for e in run.events[:3]] == ["contact", "tangential_impact", "contact"]
    jump = tangential_impact(bead(), JAMMED, parameters={"mu": 1.5})
    after = run.events[1].state
    assert after["phi_dot"] == pytest.approx(jump.velocity["phi_dot"], rel=1e-12)
    assert after["friction_dissipation"] == pytest.approx(-jump.energy_change, rel=1e-12)
    assert run.segments[0].mode == "stick/push"


def test_force_that_falls_to_zero_without_a_successor_ends_in_an_impact():
    """With two solutions both forces vanish together, and beyond there is none."""
    start = {"phi": 2.75, "x_dot": 3.0, "phi_dot": 5.0}
    values = {"mu": 1.5, "b": 0.0}
    run = simulator().run(start, t_end=0.02, parameters=values)
    first, turn, impact, *_ = run.events
    assert (turn.kind, turn.mode_after) == ("force_reversal", TANGENTIAL_IMPACT)
    assert (impact.kind, impact.time) == ("tangential_impact", turn.time)
    assert first.alternatives == ("slip_pos/pull_unstable", "slip_pos/push")
    for time, count in ((turn.time - 1e-6, 2), (turn.time, None)):
        z = run.state(time) if count else turn.state
        # A little beyond the turn, as if the slip continued.
        ahead = 0.0 if count else 1e-6
        phi, w = z["phi"] + ahead * z["phi_dot"], z["phi_dot"] + ahead * _turning(z, values)
        assert len(slip_forces(1, phi, w, 1.5, 0.0)) == (count or 0)
    assert abs(turn.normal_force) < 1e-9
    assert run.final["x_dot"] == 0 and run.energy_residual < 1e-9


def _turning(z, values):
    """Return p'' with no force of the groove but N = 0, by hand."""
    return accelerations(z["phi"], z["phi_dot"], 0.0, 0.0, values["b"])[1]


def test_singular_slip_keeps_what_was_computed_and_says_why():
    run = simulator().run(JAMMED, t_end=1.0, parameters={"mu": 1.5})
    assert run.stop_reason is StopReason.SINGULAR
    assert "force of the guide grows without bound" in run.stop_detail
    assert run.final_time == pytest.approx(0.2246091, abs=1e-6)
    assert run.energy_residual < 1e-9
    assert len(run.events_of("force_reversal")) == 1


loads = st.floats(-80, 80)


@given(
    st.floats(-1.4, 1.4),
    st.floats(0, 4),
    loads,
    loads,
    st.sampled_from([-1.0, 1.0]),
    st.sampled_from(["liftoff", "slip", "impact"]),
)
@settings(max_examples=60)
def test_motion_begins_with_a_solution_of_the_contact_problem(phi, mu, P_1, P_2, v, policy):
    values = {"mu": mu, "P_1": P_1, "P_2": P_2, "phi_0": phi}
    state = {"phi": phi, "x_dot": v}
    classification = classify(klein(), state, parameters=values)
    (own,) = classification.coefficients
    if min(abs(own.A), abs(own.A_pull)) < 1e-6 * classification.problem.W_nn:
        return  # the force may grow past every bound
    run = simulator(policy, klein).run(state, t_end=1e-9, parameters=values)
    names = [solution_name(s, classification.problem) for s in classification.solutions]
    first = run.events[0].mode_after
    if not names:
        assert first == TANGENTIAL_IMPACT
    elif len(names) == 1:
        assert [first] == names
    else:
        stable = [n for n in names if not n.endswith("unstable")]
        unstable = [n for n in names if n.endswith("unstable")]
        expected = {"liftoff": stable, "slip": unstable, "impact": [TANGENTIAL_IMPACT]}
        assert [first] == expected[policy]
        assert set(run.events[0].alternatives) == set(names)
    assert run.energy_residual < 1e-9


@given(
    st.floats(-1.4, 1.4),
    st.floats(0.1, 3),
    loads,
    loads,
)
@settings(max_examples=25)
def test_rest_begins_with_sticking_or_with_a_slip_that_speeds_up(phi, mu, P_1, P_2):
    values = {"mu": mu, "P_1": P_1, "P_2": P_2, "phi_0": phi}
    state = {"phi": phi}
    classification = classify(klein(), state, parameters=values)
    names = [solution_name(s, classification.problem) for s in classification.solutions]
    run = simulator(of=klein).run(state, t_end=1e-6, parameters=values)
    first = run.events[0].mode_after
    assert first in names or len(names) == 0
    if any(n.startswith("stick") for n in names):
        assert first.startswith("stick")
    else:
        s = 1 if first.startswith("slip_pos") else -1
        assert s * run.final["x_dot"] > 0


@given(
    st.floats(0.1, 5),
    st.floats(-3, 3),
    st.floats(-20, 20),
    st.floats(0, 4),
    st.sampled_from([-1, 1]),
)
@settings(max_examples=200)
def test_number_of_solutions_by_excess_and_selector(W_nn, W_nt, b_n, mu, s):
    """The closed condition that `derive` prints, against the enumeration."""
    excess, selector = mu * abs(W_nt) - W_nn, s * W_nt * b_n
    if abs(excess) < 1e-9 or abs(b_n) < 1e-6 or abs(W_nt) < 1e-6:
        return
    W_tt = 1 + 2 * W_nt**2 / W_nn
    count = len(
        ContactProblem.single(W_nn, W_nt, W_tt, b_n, 0.3, mu, s, bilateral=True).solutions()
    )
    assert count == (1 if excess < 0 else 2 if selector > 0 else 0)
