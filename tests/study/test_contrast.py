"""Every method on the starts of the paper's tables: the solutions and the orders."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from painleve_sym.at.jump import evaluate_jump
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, StopReason
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.comparisons.comparison import compare
from tests.oracles import rod_scipy

STEPS = (1e-3, 5e-4)
SOLVERS = ("least-impulse", "largest-impulse", "lemke")


def _contrast(**options):
    state = {"theta": options.pop("theta", 1.0), "x_A_dot": -1.0}
    state["theta_dot"] = options.pop("theta_dot")
    return compare(rod(), state, **({"steps": STEPS, "solvers": SOLVERS} | options))


@pytest.fixture(scope="module")
def table_3():
    return _contrast(theta_dot=1.0)


@pytest.fixture(scope="module")
def table_4():
    return _contrast(theta_dot=5.0, stiffness=(20.9e14,))


def test_table_3_stepping_finds_the_plastic_jump_and_no_paradox(table_3):
    level = table_3.acceleration_level
    assert level.classification.case.value == "inconsistent"
    assert level.lemke.status.label == "ray"
    assert level.mpcc.solutions == ()
    assert table_3.plastic_jump_unnoticed
    assert not table_3.solver_dependent
    impulse = sum(p.normal_impulse for p in table_3.jumps["plastic"].phases)
    for answer in table_3.stepping:
        assert (answer.solutions_first_step, answer.first_mode) == (1, "stick")
        assert answer.first_impulse == pytest.approx(impulse, abs=10 * answer.setting)
        assert [answer.velocity[n] for n in ("x_A_dot", "y_A_dot")] == pytest.approx([0, 0])
        assert answer.reference == "newton"


def test_table_3_step_could_warn_of_the_paradox(table_3):
    """A_s < 0 is known to the step, and Λ/h grows like 1/h: the text of docs/contrast.md."""
    answers = [a for a in table_3.stepping if a.way.endswith("lemke")]
    forces = [a.first_impulse / a.setting for a in answers]
    assert forces[1] / forces[0] == pytest.approx(STEPS[0] / STEPS[1], rel=0.02)
    page = (Path(__file__).parents[2] / "docs" / "contrast.md").read_text("utf-8")
    rows = re.findall(r"(?m)^\| (1e-\d) \| (0\.\d+) \|", page)
    printed = [f"{float(impulse) / float(h):.0f}" for h, impulse in rows]
    words = " ".join(page.split())
    assert f"({printed[0]} N, {printed[1]} N and {printed[2]} N in the table below)" in words
    assert float(rows[0][1]) == pytest.approx(answers[0].first_impulse, abs=5e-6)


def test_table_3_orders(table_3):
    for orders in table_3.step_orders.values():
        assert orders == pytest.approx([1], abs=0.05)
    assert table_3.expected_stiffness_order == pytest.approx(-1 / 3)
    assert np.all(np.diff([a.error for a in table_3.softened]) < 0)
    assert all(-0.34 < p < -0.2 for p in table_3.stiffness_orders)
    page = (Path(__file__).parents[2] / "docs" / "contrast.md").read_text("utf-8")
    first, second = (f"−{-p:.3f}" for p in table_3.stiffness_orders)
    assert f"orders {first} and {second} in E" in page


def test_table_3_softened_impacts_are_those_of_the_reference(table_3):
    middle = table_3.softened[1]
    assert middle.setting == 20.9e14
    kinds = [kind for _, kind in middle.events]
    assert kinds[:2] == ["slip_stop", "max_compression"]
    assert "separation" in kinds
    oracle = rod_scipy.simulate(1.0, 1.0, -1.0, n=1.5, t_end=0.01, until="separation")
    stop, turn = oracle.events[:2]
    assert (stop.kind, turn.kind) == ("slip_stop", "max_compression")
    assert middle.events[0][0] == pytest.approx(stop.time, rel=1e-9)
    assert middle.peak_force == pytest.approx(turn.F_n, rel=1e-5)
    # What the rule drops is the impulse of finite forces while the slip lasts.
    jump = sum(p.normal_impulse for p in table_3.jumps["e"].phases)
    assert middle.normal_impulse == pytest.approx(jump, rel=0.05)


def test_rigid_impulse_is_that_of_the_jump_and_of_the_weight_after_it(table_3):
    energetic, newton = table_3.rigid
    assert (energetic.way, newton.way) == ("energetic", "newton")
    jumps = {name: sum(p.normal_impulse for p in j.phases) for name, j in table_3.jumps.items()}
    assert energetic.normal_impulse == pytest.approx(jumps["e"], rel=1e-9)
    assert newton.normal_impulse > jumps["plastic"]
    finest = min(table_3.stepping, key=lambda a: a.setting)
    assert newton.normal_impulse == pytest.approx(finest.normal_impulse, rel=2e-3)


def test_table_4_the_answer_depends_on_the_solver(table_4):
    assert table_4.acceleration_level.classification.case.value == "indeterminate"
    assert [len(f.solutions) for f in table_4.first_steps] == [3, 3]
    assert table_4.solver_dependent
    assert not table_4.plastic_jump_unnoticed
    answers = {(a.way, a.first_mode, a.reference) for a in table_4.stepping}
    assert ("least-impulse", "liftoff", "newton, liftoff") in answers
    assert any(way == "largest-impulse" and mode == "stick" for way, mode, _ in answers)
    assert {a.way for a in table_4.rigid} >= {"energetic, liftoff", "energetic, impact"}
    assert all(a.normal_impulse == 0 for a in table_4.softened)


def test_unique_slip_is_found_by_all():
    comparison = _contrast(theta=0.5, theta_dot=1.0, stiffness=(20.9e12,), t_end=2e-3)
    assert comparison.acceleration_level.classification.case.value == "slip"
    assert comparison.jumps == {}
    assert not (comparison.solver_dependent or comparison.plastic_jump_unnoticed)
    errors = [a.error for a in comparison.stepping]
    assert max(errors) < 1e-4
    assert np.isnan(comparison.expected_stiffness_order)


def test_steps_follow_the_end_time_where_none_are_given():
    comparison = compare(
        rod(),
        {"theta": 1.0, "y_A": 0.01},
        t_end=1e-3,
        stiffness=(20.9e14,),
        solvers=("lemke",),
    )
    assert [a.setting for a in comparison.stepping] == pytest.approx([1e-4, 1e-5, 1e-6])


def test_falling_rod_has_no_contact_problem_of_accelerations():
    state = {"theta": 1.0, "y_A": 0.01, "x_A_dot": -1.0}
    comparison = compare(rod(), state, steps=STEPS, stiffness=(20.9e14,), solvers=("lemke",))
    assert comparison.acceleration_level is None
    assert comparison.first_steps == ()
    assert all(
        a.normal_impulse == 0
        for a in (*comparison.rigid, *comparison.stepping, *comparison.softened)
    )


# ---- rigid motion that ends early ----

WEDGED = {"theta": 0.9272952180016122}  # the tip of the strut touches the surface
ONE = {"steps": (1e-3,), "stiffness": (20.9e14,), "solvers": ("least-impulse", "lemke")}

# A sprag held by a spring between a pivot and a belt, to the right (side = 1) or its mirror image.
SPRAG = """
name = "sprag"
[coordinates]
phi = { unit = "rad", meaning = "angle of the sprag from the upright" }
[parameters]
J = { default = 0.3, unit = "kg m^2", meaning = "inertia", positive = true }
L = { default = 0.5, unit = "m", meaning = "length", positive = true }
k = { default = 4.0, unit = "N m/rad", meaning = "stiffness", lower = 0 }
side = { default = 1.0, unit = "1", meaning = "1 to the right, -1 to the left" }
u = { default = 0.8, unit = "m/s", meaning = "speed of the belt" }
mu = { default = 1.5, unit = "1", meaning = "friction coefficient" }
[[bodies]]
mass = "J"
inertia = "J"
angle = "phi"
centre = [0, 0]
[[springs]]
extension = "phi - 0.2"
stiffness = "k"
[[contacts]]
name = "tip"
point = ["side*L*sin(phi)", "0.4 - L*cos(phi)"]
surface_speed = "-side*u"
friction = "mu"
"""


def test_rigid_motion_that_jams_is_an_answer_beside_the_others():
    """Rank one: cos θ (v_n, v_t + u) ∝ θ̇, so that the slip stops at θ̇ = u/(2 l sin θ) = 1.25."""
    wedged = compare(model("strut"), WEDGED, parameters={"mu": 2.0}, **ONE)
    assert [a.way for a in wedged.rigid] == ["energetic", "newton"]
    for answer in wedged.rigid:
        assert answer.stop_reason is StopReason.JAM
        assert "no exit" in answer.stop_detail
        assert answer.events[-1] == (0.0, "jam")
        assert answer.final_time == 0
        assert answer.state == pytest.approx(WEDGED | {"theta_dot": 1.25}, rel=1e-12)
        # J Δθ̇ = 2 l (μ sin θ − cos θ) P_n with J = 4 m l²/3 about the pivot.
        assert answer.normal_impulse == pytest.approx(1.25 / 3 / (1.6 - 0.6), rel=1e-12)
        assert len(answer.times) == len(answer.contact_velocities) >= 2
    assert all(a.stop_reason is StopReason.NO_MODE for a in wedged.stepping)
    assert all("gives no impulses" in a.stop_detail for a in wedged.stepping)
    (softened,) = wedged.softened
    assert softened.complete and softened.peak_force > 1e6
    assert np.isnan(softened.error)
    assert wedged.jams and not wedged.impact_without_collision
    assert np.isnan(wedged.expected_stiffness_order)
    assert wedged.jumps["e"].normal_impulse == wedged.rigid[0].normal_impulse


def test_rigid_motion_that_jams_on_its_way_ends_after_the_impulse_up_to_there():
    start = {"theta": 0.9, "theta_dot": 4.0}
    comparison = compare(model("strut"), start, parameters={"mu": 2.0}, **ONE)
    jammed = comparison.rigid[0]
    assert jammed.stop_reason is StopReason.JAM
    assert 0 < jammed.final_time < comparison.t_end
    assert jammed.velocity["theta_dot"] == pytest.approx(1.25, rel=1e-12)
    # The drawn curve ends after the impulse, too: at v_t = 0 and v_n = −2 l cos θ θ̇.
    assert jammed.contact_velocities[-1] == pytest.approx([-0.75, 0], abs=1e-12)
    landing = Simulator(model("strut"), RigidLaw()).run(start, parameters={"mu": 2.0}, t_end=1e-2)
    (touchdown,) = landing.events_of("touchdown")
    at = {name: touchdown.state[name] for name in ("theta", "theta_dot")}
    jump = evaluate_jump(model("strut"), "energetic", at, parameters={"mu": 2.0})
    assert jammed.normal_impulse == pytest.approx(jump.normal_impulse, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_another_mechanism_jams_as_does_its_mirror_image(side):
    start = {"phi": float(np.arccos(0.8))}
    mechanism = mechanism_from_text(SPRAG)
    comparison = compare(mechanism, start, parameters={"side": side}, **ONE)
    answer = comparison.rigid[0]
    # v_t = side (L cos φ φ̇ + u) stops at φ̇ = −2, where J Δφ̇ = L (sin φ − μ cos φ) P_n.
    assert (answer.stop_reason, answer.final_time) == (StopReason.JAM, 0)
    assert answer.velocity["phi_dot"] == pytest.approx(-2, rel=1e-12)
    assert answer.normal_impulse == pytest.approx(0.6 / 0.3, rel=1e-12)
    normal, slip = answer.contact_velocities.T
    assert slip[0] == pytest.approx(0.8 * side)
    assert (normal[-1], slip[-1]) == pytest.approx((-0.6, 0), abs=1e-12)
    assert comparison.softened[0].complete


@pytest.mark.parametrize("sign", [1, -1])
def test_rigid_motion_that_jams_dynamically_says_where_it_would_arrive(sign):
    """A rod that jams (A = B = 0 at θ = 45° with g = 10, μ = 5/3), and its mirror image."""
    given = {"g": 10.0, "mu": 5 / 3}
    start = {"theta": np.radians(31), "x_A_dot": -30.0}
    near = Simulator(rod(), RigidLaw()).run(start, parameters=given, t_end=0.8).final
    state = {n: near[n] for n in rod().state_names}
    if sign < 0:
        state = {n: -v if n in ("x_A", "x_A_dot", "theta_dot") else v for n, v in state.items()}
        state["theta"] = np.pi - state["theta"]
    comparison = compare(rod(), state, parameters=given, t_end=0.02, **ONE)
    answer = comparison.rigid[0]
    assert answer.stop_reason is StopReason.DYNAMIC_JAM
    assert answer.limit.time == pytest.approx(0.8145496574 - 0.8, abs=2e-9)
    assert np.cos(answer.limit.state["theta"]) == pytest.approx(sign * np.sqrt(0.5), abs=1e-8)
    assert answer.state["theta"] == pytest.approx(answer.limit.state["theta"], abs=1e-6)
    assert all(
        a.complete and np.isnan(a.error) for a in (*comparison.stepping, *comparison.softened)
    )


# ---- the impulse and the ruler ----


@pytest.mark.parametrize("theta_dot", [1.0, 5.0])
def test_impulse_of_every_motion_is_that_of_the_momentum_balance(theta_dot):
    """P = m (v⁺ − v⁻ − a t): v_x = ẋ_A − l sin θ θ̇ and v_y = ẏ_A + l cos θ θ̇ of the centre."""
    comparison = _contrast(theta_dot=theta_dot, stiffness=(20.9e12,))
    for answer in (*comparison.rigid, *comparison.softened):
        before, after = (
            np.array([s["y_A_dot"], s["x_A_dot"]])
            + np.array([np.cos(s["theta"]), -np.sin(s["theta"])]) * s["theta_dot"]
            for s in (comparison.state, answer.state)
        )
        balance = after - before + np.array([9.8, 0.0]) * answer.final_time
        assert answer.impulse == pytest.approx(balance, rel=1e-10, abs=1e-12)


def test_impulse_of_impacts_that_reverse_the_slip_of_a_pivoted_strut():
    """W has rank one: only along the path of the impulse do velocities tell P_n."""
    comparison = compare(model("strut"), {"theta": 0.9, "theta_dot": 4.0}, **ONE)
    energetic = comparison.rigid[0]
    assert energetic.complete
    assert energetic.impulse == pytest.approx(comparison.softened[0].impulse, rel=2e-4)


def test_error_of_a_body_held_at_rest_is_relative_to_what_the_contact_stops():
    start = {"theta": WEDGED["theta"] - 1e-7}
    comparison = compare(model("strut"), start, **(ONE | {"steps": (1e-4,)}))
    assert comparison.rigid[0].normal_impulse == pytest.approx(
        comparison.stepping[0].normal_impulse, rel=1e-3
    )
    assert all(a.complete and a.error < 1e-3 for a in comparison.stepping)


def test_several_contacts_are_refused_with_their_names():
    with pytest.raises(InputError, match=r"got 2 contacts, need one.*'A', 'B'"):
        compare(model("block-two-feet"), {"theta": 0.3})


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"steps": ()}, "steps: got none"),
        ({"steps": (-1e-3,)}, "step: got -0.001"),
        ({"steps": (float("nan"),)}, "steps: got nan"),
        ({"stiffness": (0.0,)}, "0 < E"),
        ({"e": 2.0}, "0 <= e_energetic <= 1"),
        ({"solvers": ("lemk",)}, "Did you mean 'lemke'?"),
        ({"t_end": -1.0}, "t_end: got -1.0"),
    ],
)
def test_bad_options_are_refused(options, words):
    with pytest.raises(InputError) as error:
        _contrast(theta_dot=1.0, **options)
    assert words in str(error.value)
