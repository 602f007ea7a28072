"""Rigid motion with two contacts, against one contact, the literature and the second engine."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from painleve_sym.at.cases import classify
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, StopReason
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.simulator import Simulator

FLAT = {"beta": 0.0}


@pytest.fixture(scope="module")
def feet() -> Simulator:
    return Simulator(model("block-two-feet"), RigidLaw())


def test_both_feet_slide_to_rest(feet):
    """F = m g (1 ∓ μ h/a)/2 with equal friction, and the deceleration μ g."""
    run = feet.run({"x_A_dot": 1.0}, t_end=1.0, parameters=FLAT | {"mu_A": 0.3, "mu_B": 0.3})
    g, mu, h, a = 9.8, 0.3, 0.2, 0.1
    assert [e.kind for e in run.events] == ["contact", "slip_stop", "contact"]
    assert run.events[1].time == pytest.approx(1 / (mu * g), rel=1e-11)
    outputs = run.outputs(0.1)
    for name, sign in (("A", -1), ("B", 1)):
        assert outputs[f"normal_force_{name}"][0] == pytest.approx(g / 2 * (1 + sign * mu * h / a))
    assert run.events[2].mode_after == "stick + stick"
    assert run.final["x_A"] == pytest.approx(1 / (2 * mu * g), rel=1e-11)
    assert run.energy_residual < 1e-12


def test_too_much_friction_tips_the_block(feet):
    """Beyond μ h = a the rear foot would have to pull: it lifts off, the other slides on."""
    start = {"x_A_dot": 1.0}
    for mu, mode in ((0.49, "slip_pos + slip_pos"), (0.51, "flight + slip_pos")):
        run = feet.run(start, t_end=1e-3, parameters=FLAT | {"mu_A": mu, "mu_B": mu})
        assert run.segments[0].mode == mode


@pytest.mark.slow
def test_one_foot_moves_as_the_mechanism_with_that_contact_alone(feet):
    """While A is in the air the motion is that of B alone, also through its impacts."""
    start, p = {"y_A": 0.1, "theta": -0.4, "x_A_dot": 1.0}, FLAT | {"mu_B": 0.7}
    alone = Simulator(feet.mechanism.only("B"), RigidLaw())
    both = feet.run(start, t_end=0.3, parameters=p)
    one = alone.run(start, t_end=0.3, parameters=p)
    first = next((e.time for e in both.events if e.contact == "A"), both.final_time)
    assert one.events_of("touchdown")[0].time < first
    for t in np.linspace(0, first * 0.999, 7):
        for name in ("x_A", "y_A", "theta", "x_A_dot", "y_A_dot", "theta_dot"):
            assert both.state(t)[name] == pytest.approx(one.state(t)[name], abs=1e-10)


@pytest.mark.parametrize("h", [0.3, 0.5])
def test_rocking_loses_what_housner_says(feet, h):
    """θ̇⁺/θ̇⁻ = 1 − 2 m a²/(J + m (a² + h²)) at each change of foot (Housner 1963)."""
    p = FLAT | {"h": h, "mu_A": 1.5, "mu_B": 1.5, "e_energetic": 0.0}
    run = feet.run({"theta": 0.1}, t_end=1.5, parameters=p)
    ratio = 1 - 2 * 0.1**2 / (0.02 + 0.1**2 + h**2)
    touched = [i for i, e in enumerate(run.events) if e.kind == "touchdown"]
    assert len(touched) >= 2
    for i in touched:
        before, after = run.events[i].state, run.events[i + 2].state
        assert after["theta_dot"] / before["theta_dot"] == pytest.approx(ratio, rel=1e-9)
    assert run.energy_residual < 1e-9


@pytest.mark.parametrize(
    "law", ["energetic", *(pytest.param(n, marks=pytest.mark.slow) for n in ("poisson", "newton"))]
)
def test_a_falling_block_comes_to_rest(law):
    """Bounces and rocking accumulate and end; the energy closes through hundreds of impacts."""
    simulator = Simulator(model("block-two-feet"), RigidLaw(law))
    p = FLAT | {"h": 0.1, "mu_A": 0.8, "mu_B": 0.8, simulator.own_parameters[0].name: 0.3}
    run = simulator.run({"y_A": 0.05, "theta": 0.3}, t_end=3.0, parameters=p)
    assert run.stop_reason is StopReason.T_END
    assert run.mode_names[run.final_mode] == "stick + stick"
    assert abs(run.final["theta"]) < 1e-8
    forces = run.final_forces
    assert forces["normal_force_A"] + forces["normal_force_B"] == pytest.approx(9.8)
    assert run.energy_residual < 1e-8


def test_landing_flat_is_one_impact_of_both_feet(feet):
    run = feet.run({"y_A": 0.1}, t_end=0.2, parameters=FLAT | {"e_energetic": 0.5})
    impact = run.events_of("impact")[0]
    speed = math.sqrt(2 * 9.8 * 0.1)
    assert impact.impulses == pytest.approx((0.75 * speed, 0, 0.75 * speed, 0), abs=1e-9)
    assert impact.state["y_A_dot"] == pytest.approx(0.5 * speed)


@pytest.mark.slow
def test_the_inconsistent_foot_has_its_impact_without_collision(feet):
    """A tall block on one sliding foot, A < 0 and B < 0: the slip stops in an instant."""
    p = FLAT | {"h": 0.2, "J": 0.01, "mu_B": 3.0, "mu_A": 3.0}
    start = {"theta": -0.8, "y_A": 2 * 0.1 * math.sin(0.8), "x_A_dot": -1.0}
    alone = feet.mechanism.only("B")
    rigid = Simulator(alone, RigidLaw()).run(start, t_end=1e-4, parameters=p)
    run = feet.run(start, t_end=1e-4, parameters=p)
    assert rigid.events_of("impact_slip_stop"), "the state is not the one meant"
    assert run.events_of("impact")[0].time == 0
    for name in ("x_A_dot", "y_A_dot", "theta_dot"):
        assert run.final[name] == pytest.approx(rigid.final[name], rel=1e-9)


def test_what_cannot_be_is_refused(feet):
    with pytest.raises(InputError, match="contact 'B' starts inside the ground"):
        feet.run({"theta": -0.1}, t_end=0.1)
    with pytest.raises(InputError, match="unknown event 'impct'"):
        feet.run({}, t_end=0.1, until="impct")
    with pytest.raises(InputError, match=r"unknown contact 'C'.*Known: A, B"):
        feet.mechanism.only("C")
    with pytest.raises(InputError, match="choose one of 'A', 'B'"):
        _ = feet.mechanism.contact


def test_a_run_ends_where_it_is_asked_to(feet):
    run = feet.run({"y_A": 0.1, "theta": 0.1}, t_end=1.0, parameters=FLAT, until="impact")
    assert run.stop_reason is StopReason.UNTIL
    assert run.final_time == run.events_of("impact")[0].time
    limited = feet.run({"y_A": 0.1, "theta": 0.1}, t_end=1.0, parameters=FLAT, max_events=3)
    assert limited.stop_reason is StopReason.EVENT_LIMIT


# ---- the contact problem at a state ----


def test_classification_of_the_sliding_block():
    classification = classify(model("block-two-feet"), {"x_A_dot": -1.0}, parameters=FLAT)
    assert (classification.case.value, classification.contacts, classification.open) == (
        "unique",
        ("A", "B"),
        (),
    )
    (solution,) = classification.solutions
    assert solution.normal_forces.sum() == pytest.approx(9.8)
    assert classification.to_dict()["solutions"][0]["contacts"]["A"]["mode"] == "slip_neg"


def test_the_block_at_rest_is_hyperstatic():
    classification = classify(model("block-two-feet"), {}, parameters=FLAT)
    assert classification.case.value == "hyperstatic"
    assert not any(s.isolated for s in classification.solutions)


def test_an_open_contact_is_left_out():
    classification = classify(model("block-two-feet"), {"theta": 0.3, "x_A_dot": 1.0})
    assert (classification.contacts, classification.open) == (("A",), ("B",))
    with pytest.raises(InputError, match="no contact is closed"):
        classify(model("block-two-feet"), {"y_A": 0.1})
    with pytest.raises(InputError, match="contact 'A' approaches with 1 m/s"):
        classify(model("block-two-feet"), {"y_A_dot": -1.0})


def test_rigid_contacts_of_one_mechanism_follow_one_law():
    own = RigidLaw("newton", impact_friction="final_slip")
    for other in (RigidLaw("newton"), RigidLaw("poisson", "slip"), own):
        with pytest.raises(InputError, match="all rigid contacts the same choices"):
            Simulator(model("block-two-feet"), {"A": RigidLaw("poisson"), "B": other})


def test_law_whose_parameter_the_mechanism_has_is_refused():
    legs = Path(__file__).parents[2] / "examples/mechanisms/three-legged-table.toml"
    text = legs.read_text("utf-8").replace("mu_left", "e_energetic")
    with pytest.raises(InputError, match="has the name 'e_energetic' too"):
        Simulator(mechanism_from_text(text, name="legs"), RigidLaw())


ROCKING = FLAT | {"h": 0.3, "mu_A": 1.5, "mu_B": 1.5, "e_energetic": 0.2}


@pytest.mark.parametrize("spin", [1e-7, -1e-5, 1e-3])
def test_rocking_that_starts_all_but_at_rest_comes_to_rest_as_from_rest(spin):
    """A run that hardly moves at its start has a scale that says nothing of its bounces."""
    simulator = Simulator(model("block-two-feet"), RigidLaw())
    runs = [
        simulator.run({"theta": 0.1, "theta_dot": s}, t_end=1.75, parameters=ROCKING)
        for s in (0.0, spin)
    ]
    for run in runs:
        assert run.stop_reason is StopReason.T_END
        assert run.mode_names[run.final_mode] == "stick + stick"
        assert run.notices == ()
    rest, moved = (run.events_of("settle")[-1].time for run in runs)
    assert moved == pytest.approx(rest, abs=abs(spin) + 1e-6)


def kinetic_energy(state):
    """Of the block of ROCKING: m = 1 kg, J = 0.02 kg m², a = 0.1 m, h = 0.3 m."""
    theta, spin = state["theta"], state["theta_dot"]
    x = state["x_A_dot"] - spin * (0.1 * math.sin(theta) + 0.3 * math.cos(theta))
    y = state["y_A_dot"] + spin * (0.1 * math.cos(theta) - 0.3 * math.sin(theta))
    return (x**2 + y**2 + 0.02 * spin**2) / 2


@pytest.mark.parametrize(
    ("law", "e"),
    [
        *(("newton", 0.2), ("energetic", 0.5)),
        pytest.param("newton", 0.5, marks=pytest.mark.slow),
        pytest.param("energetic", 0.2, marks=pytest.mark.slow),
        *(pytest.param("poisson", e, marks=pytest.mark.slow) for e in (0.2, 0.5)),
    ],
)
def test_closing_short_bounces_adds_no_energy(law, e):
    """Bounces too short for the time to tell are closed; feet that stick are not set in motion.

    From θ̇ = 10⁻⁷ rad/s and under Newton's law with e = 0.2 the slip that closing started had its
    own impacts, until the limit of events; with e = 0.5 from rest the rocking grew again.
    """
    simulator = Simulator(model("block-two-feet"), RigidLaw(law))
    p = FLAT | {"h": 0.3, "mu_A": 1.5, "mu_B": 1.5, simulator.own_parameters[0].name: e}
    ends = []
    for spin in (0.0, 1e-7):
        start = {"theta": 0.1, "theta_dot": spin}
        run = simulator.run(start, t_end=1.75, parameters=p, max_events=10_000)
        assert run.stop_reason is StopReason.T_END
        assert run.mode_names[run.final_mode] == "stick + stick"
        assert run.energy_residual < 1e-9
        settled = [i for i, e in enumerate(run.events) if e.kind == "settle"]
        for before, after in ((run.events[i - 1], run.events[i]) for i in settled):
            assert kinetic_energy(after.state) <= kinetic_energy(before.state) * (1 + 1e-12)
        ends.append(run.events[settled[-1]].time)
    assert ends[1] == pytest.approx(ends[0], abs=2e-7)


def test_engines_agree_on_when_bounces_of_a_slow_start_have_died_out():
    start = {"theta": 0.1, "theta_dot": 1e-5}
    ends = []
    for engine in ("taylor", "compiled"):
        simulator = Simulator(model("block-two-feet"), RigidLaw(), engine)
        run = simulator.run(start, t_end=0.194, parameters=ROCKING)
        settled = run.events_of("settle")[0]
        ends.append((settled.time, run.final["theta_dot"]))
        assert run.stop_reason is StopReason.T_END
    np.testing.assert_allclose(ends, [ends[0]] * 2, rtol=1e-9)
