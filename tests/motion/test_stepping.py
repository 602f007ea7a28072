"""Time stepping: order one in smooth motion, impulses, symmetry, energy, several solutions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.at.cases import classify
from painleve_sym.at.jump import evaluate_jump
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, StopReason
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.time_stepping.stepping import SCHEMES, TimeStepper

SLIDING = {"theta": 0.5, "theta_dot": 1.0, "x_A_dot": -1.0}
INCONSISTENT = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
INDETERMINATE = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
VELOCITIES = ("x_A_dot", "y_A_dot", "theta_dot")


@pytest.fixture(scope="module")
def stepper():
    return TimeStepper(rod())


@pytest.fixture(scope="module")
def rigid():
    return Simulator(rod(), RigidLaw("newton"), "compiled")


def _orders(stepper, reference, state, steps, t_end, **options):
    errors = []
    for h in steps:
        run = stepper.run(state, step=h, t_end=t_end, **options)
        assert run.stop_reason is StopReason.T_END
        errors.append(max(abs(run.final[n] - reference[n]) for n in VELOCITIES))
    return np.diff(np.log(errors)) / np.diff(np.log(steps))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_order_is_one_in_slip(rigid, scheme):
    """The start of Table 1 slides on with one solution at every time."""
    reference = rigid.run(SLIDING, t_end=0.02).final
    steps = (2e-3, 1e-3, 5e-4)
    orders = _orders(TimeStepper(rod(), scheme), reference, SLIDING, steps, 0.02)
    assert orders == pytest.approx([1, 1], abs=0.05)


def test_order_is_at_least_one_in_free_fall(stepper, rigid):
    state = {"theta": 0.7, "theta_dot": 2.0, "x_A_dot": 0.3, "y_A": 1.0}
    reference = rigid.run(state, t_end=0.1).final
    orders = _orders(stepper, reference, state, (1e-2, 5e-3, 2.5e-3), 0.1)
    assert np.all(orders > 0.95)
    assert stepper.run(state, step=1e-2, t_end=0.1).normal_impulse == 0


def test_order_is_one_through_the_impact_without_collision(stepper, rigid):
    reference = rigid.run(INCONSISTENT, t_end=4e-3).final
    orders = _orders(stepper, reference, INCONSISTENT, (1e-3, 5e-4, 2.5e-4), 4e-3)
    assert orders == pytest.approx([1, 1], abs=0.05)


@pytest.mark.parametrize("solver", ["first", "least-impulse", "largest-impulse", "lemke", "mpcc"])
def test_inconsistent_state_jumps_to_rest_in_one_step(stepper, solver):
    """No solver notices a paradox: the e = 0 jump, up to the impulse of finite forces in h."""
    h = 1e-6
    run = stepper.run(INCONSISTENT, step=h, t_end=h, solver=solver)
    jump = evaluate_jump(rod(), "energetic", INCONSISTENT, parameters={"e_energetic": 0.0})
    assert run.solutions_found.tolist() == [1]
    assert run.contact_velocities[-1] == pytest.approx([0, 0], abs=1e-12)
    assert run.final["theta_dot"] == pytest.approx(jump.velocity["theta_dot"], abs=20 * h)
    impulse = sum(p.normal_impulse for p in jump.phases)
    assert run.normal_impulse == pytest.approx(impulse, abs=20 * h)


def test_newtons_restitution_changes_nothing_at_the_inconsistent_state(stepper):
    runs = [stepper.run(INCONSISTENT, step=1e-3, t_end=2e-3, e=e) for e in (0, 0.75)]
    assert runs[0].states == pytest.approx(runs[1].states, abs=1e-15)


def test_indeterminate_state_has_three_steps_and_the_solver_chooses(stepper):
    ends = {}
    for solver in ("least-impulse", "largest-impulse", "lemke"):
        run = stepper.run(INDETERMINATE, step=1e-5, t_end=1e-5, solver=solver)
        ends[solver] = run.contact_velocities[-1, 1]
        assert run.solutions_found[0] == (1 if solver == "lemke" else 3)
    assert ends["least-impulse"] < -0.9
    assert ends["largest-impulse"] == pytest.approx(0, abs=1e-12)
    problem = stepper.first_problem(INDETERMINATE, 1e-5)
    modes = [s.mode.value for s in problem.solutions()]
    assert modes == ["liftoff", "slip_neg", "stick"]


def test_resting_contact_carries_weight_times_time():
    """A block that sticks on level ground under its weight."""
    state = {"theta": math.pi / 2}
    run = TimeStepper(rod()).run(state, step=1e-3, t_end=0.05)
    assert run.states == pytest.approx(np.tile(run.states[0], (51, 1)), abs=1e-12)
    assert run.normal_impulse == pytest.approx(1 * 9.8 * 0.05, rel=1e-12)
    assert np.sum(run.impulses[:, 1]) == pytest.approx(0, abs=1e-12)


@settings(max_examples=15)
@given(
    st.floats(0.2, 1.4),
    st.floats(-4, 4),
    st.floats(-2, 2),
    st.sampled_from(["least-impulse", "largest-impulse"]),
)
def test_mirrored_starts_give_mirrored_motions(theta, theta_dot, slip, solver):
    stepper = TimeStepper(rod())
    options = {"step": 1e-3, "t_end": 4e-3, "solver": solver}
    state = {"theta": theta, "theta_dot": theta_dot, "x_A_dot": slip}
    run = stepper.run(state, **options)
    state = {"theta": math.pi - theta, "theta_dot": -theta_dot, "x_A_dot": -slip}
    other = stepper.run(state, **options)
    for name, sign in (("x_A_dot", -1), ("y_A_dot", 1), ("theta_dot", -1)):
        assert other.final[name] == pytest.approx(sign * run.final[name], abs=1e-9)


@settings(max_examples=25)
@given(st.floats(0.2, 2.9), st.floats(-6, 6), st.floats(-2, 2), st.floats(-1, 0), st.booleans())
def test_plastic_impulses_never_gain_energy(theta, theta_dot, slip, approach, largest):
    solver = "largest-impulse" if largest else "least-impulse"
    state = {"theta": theta, "theta_dot": theta_dot, "x_A_dot": slip, "y_A_dot": approach}
    run = TimeStepper(rod()).run(state, step=1e-3, t_end=5e-3, solver=solver)
    size = 1 + float(np.max(run.states[:, 3:] ** 2))
    assert np.all(run.contact_work <= 1e-12 * size)


def test_energy_falls_in_slip_by_the_contact_work(stepper):
    """T + V changes by the work of the impulses, up to the scheme's own error of order h."""

    def energy(states):
        _, y, theta, u, v, w = states.T
        x_dot, y_dot = u - np.sin(theta) * w, v + np.cos(theta) * w
        return (x_dot**2 + y_dot**2) / 2 + w**2 / 6 + 9.8 * (y + np.sin(theta))

    gaps = []
    for h in (1e-3, 1e-4):
        run = stepper.run(SLIDING, step=h, t_end=0.02)
        total = energy(run.states)
        assert np.all(np.diff(total) < 0)
        gaps.append(abs(total[-1] - total[0] - np.sum(run.contact_work)))
    assert gaps[1] < 0.15 * gaps[0] < 1e-4


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_plain_bounce_has_newtons_restitution(stepper, e):
    """An upright rod: the normal of the contact passes through the centre."""
    state = {"theta": math.pi / 2, "y_A_dot": -1.0}
    run = stepper.run(state, step=1e-3, t_end=1e-3, e=e)
    # J is taken at half the step; the approach is that before the step.
    assert run.final["y_A_dot"] == pytest.approx(e, abs=1e-12)


@pytest.mark.parametrize(
    "name",
    [
        "eccentric-disc",
        pytest.param("block", marks=pytest.mark.slow),
        pytest.param("cart-pendulum", marks=pytest.mark.slow),
        pytest.param("two-link-arm", marks=pytest.mark.slow),
        pytest.param("pr-robot", marks=pytest.mark.slow),
    ],
)
def test_other_mechanisms_converge_to_their_rigid_motion(name):
    mechanism = model(name)
    names = [f"{c.name}_dot" for c in mechanism.system.coordinates]
    reference = Simulator(mechanism, RigidLaw("newton")).run(mechanism.start, t_end=0.01).final
    errors = []
    for h in (1e-3, 1e-4):
        run = TimeStepper(mechanism).run(mechanism.start, step=h, t_end=0.01)
        errors.append(max(abs(run.final[n] - reference[n]) for n in names))
    assert errors[1] < 0.15 * errors[0] + 1e-12
    assert errors[1] < 1e-3


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("solver", ["least-impulse", "lemke"])
def test_jam_of_the_strut_is_told_at_its_first_step(scheme, solver):
    """Rank one and μ > 1/tanθ: the tip on the belt has no velocity that both rows allow."""
    mechanism = model("strut")
    stepper = TimeStepper(mechanism, scheme)
    options = {"step": 1e-3, "t_end": 5e-3, "solver": solver}
    run = stepper.run(mechanism.start, **options, parameters={"mu": 2.0})
    assert run.stop_reason is StopReason.NO_MODE
    assert len(run.impulses) == 0 and len(run.states) == 1


def test_strut_below_its_critical_friction_rests_under_the_belt():
    """Pressed by spring and weight at rest: F_n = −B/A in every step, and the strut stays."""
    mechanism = model("strut")
    run = TimeStepper(mechanism).run(mechanism.start, step=1e-3, t_end=5e-3)
    classification = classify(mechanism, mechanism.start)
    assert run.stop_reason is StopReason.T_END
    assert run.states == pytest.approx(np.tile(run.states[0], (6, 1)), abs=1e-12)
    assert run.impulses[:, 0] == pytest.approx(
        -classification.B / classification.A * 1e-3, rel=1e-9
    )


def test_stewart_trinkle_has_order_one_through_a_plastic_impact(rigid):
    """The largest error of several heights, since the impact may fall anywhere in its step."""
    stepper, given = TimeStepper(rod(), "stewart-trinkle"), {"mu": 0.3}
    steps = (1e-3, 2.5e-4)
    worst = dict.fromkeys(steps, 0.0)
    for height in np.linspace(4e-3, 5e-3, 6):
        state = {"theta": 0.9, "y_A": height, "y_A_dot": -0.445, "x_A_dot": -2.0, "theta_dot": 0.3}
        reference = rigid.run(state, t_end=0.02, parameters={**given, "e_newton": 0.0})
        assert [e.kind for e in reference.events][1] == "impact"
        for h in steps:
            run = stepper.run(state, step=h, t_end=0.02, parameters=given)
            error = max(abs(run.final[n] - reference.final[n]) for n in VELOCITIES)
            worst[h] = max(worst[h], error)
    order = math.log(worst[steps[0]] / worst[steps[1]]) / math.log(steps[0] / steps[1])
    assert order == pytest.approx(1, abs=0.2)


def test_several_and_bilateral_contacts_are_refused():
    with pytest.raises(InputError, match="got 2 contacts"):
        TimeStepper(model("block-two-feet"))
    with pytest.raises(InputError, match="bilateral"):
        TimeStepper(model("painleve-klein"))


def test_last_step_is_shortened(stepper):
    run = stepper.run(SLIDING, step=4e-4, t_end=1e-3)
    assert run.times == pytest.approx([0, 4e-4, 8e-4, 1e-3])


def test_run_ends_at_the_border_of_the_domain(stepper):
    state = {"theta": 0.05, "theta_dot": -20.0, "y_A": 1.0}
    run = stepper.run(state, step=1e-3, t_end=0.1)
    assert run.stop_reason is StopReason.LEFT_DOMAIN
    assert len(run.times) == len(run.states) == len(run.impulses) + 1


def test_run_ends_when_the_solves_are_used_up(stepper):
    run = stepper.run(SLIDING, step=1e-3, t_end=1e-2, max_solves=3)
    assert run.stop_reason is StopReason.STEP_LIMIT
    assert len(run.impulses) == 3


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"step": 0.0}, "step: got 0.0"),
        ({"step": float("nan")}, "step: got nan"),
        ({"step": 1.0}, "step: got 1.0"),
        ({"step": 1e-12}, "at most 1000000"),
        ({"t_end": float("inf")}, "t_end: got inf"),
        ({"solver": "lemk"}, "Did you mean 'lemke'?"),
        ({"e": 1.5}, "0 <= e <= 1"),
        ({"e": float("nan")}, "0 <= e <= 1"),
        ({"parameters": {"mass": 1.0}}, "unknown parameter 'mass'"),
    ],
)
def test_bad_options_are_refused(stepper, options, words):
    with pytest.raises(InputError) as error:
        stepper.run(SLIDING, **{"step": 1e-3, "t_end": 1e-2, **options})
    assert words in str(error.value)


def test_starts_inside_the_ground_unknown_schemes_and_plastic_schemes_are_refused(stepper):
    with pytest.raises(InputError, match="inside the ground"):
        stepper.run({**SLIDING, "y_A": -1e-6}, step=1e-3, t_end=1e-2)
    with pytest.raises(InputError, match="Did you mean 'moreau-jean'"):
        TimeStepper(rod(), "moreau")
    with pytest.raises(InputError, match="plastic"):
        TimeStepper(rod(), "stewart-trinkle").run(SLIDING, step=1e-3, t_end=1e-2, e=0.5)
