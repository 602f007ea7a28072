"""Impacts and solutions of a robot's contact against named mechanisms and the laws of mechanics."""

from __future__ import annotations

import math
import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import painleve_sym as ps
from painleve_sym.errors import CompilerMissing, InputError
from painleve_sym.problem.impact import spatial
from painleve_sym.problem.risk import slip_angle

FILES = Path(__file__).parent / "files"
DOG = Path(__file__).parents[2] / "examples" / "robots" / "quadruped.urdf"
LAWS = ("energetic", "poisson", "newton")
FRACTION = st.floats(-1, 1, allow_subnormal=False)


def standing(*feet, **options):
    return ps.robot(DOG).contact(feet or ("LF_foot",), pose="standing", **options)


def phases(jump):
    return [[*p.impulse, p.stored_energy] for p in jump.phases]


def vars_of(classification):
    (own,) = classification.coefficients
    return [own.A, own.B, own.mu_P, own.sector.direction, own.sector.half_angle]


def mass_matrix(contact):
    """Return M of the coordinates, from the kinetic energy of pairs of velocities."""
    mechanism = contact.mechanism
    names = mechanism.outline.velocity_names
    values = {**mechanism.at({}, {"mu": 0.0}).values, **dict.fromkeys(names, 0.0)}

    size = len(names)
    pairs = [(i, k) for i in range(size) for k in range(i + 1)]
    speeds = np.zeros((size, len(pairs)))
    for at, (i, k) in enumerate(pairs):
        speeds[i, at] = speeds[k, at] = 1.0
    moving = {**values, **dict(zip(names, speeds, strict=True))}
    energy = contact.mechanism.numbers.whole_at_each(moving)[1].kinetic_energy[0]
    of = dict(zip(pairs, energy.tolist(), strict=True))
    M = np.diag([2 * of[i, i] for i in range(size)])
    for i, k in pairs:
        if i != k:
            M[i, k] = M[k, i] = of[i, k] - of[i, i] - of[k, k]
    return M


# ---- against named mechanisms ----


@pytest.mark.parametrize(
    ("mu", "spins"),
    [(0.3, (0.8, 2.9)), (3.0, (0.8, 2.9)), (3.0, (-0.4, -0.9)), (0.0, (0.2, 1.5))],
)
@pytest.mark.parametrize("law", LAWS)
def test_planar_robot_has_the_jump_of_the_named_mechanism(mu, spins, law):
    arm = ps.robot(FILES / "two_link.urdf")
    upper, lower = -0.7, -1.9
    tip = arm.contact("tip", joints={"theta_1": upper, "theta_2": lower - upper})
    own = tip.jump(law, mu, 0.5, {"theta_1": spins[0], "theta_2": spins[1] - spins[0]})
    state = {"theta_1": upper, "theta_2": lower}
    state |= {"theta_1_dot": spins[0], "theta_2_dot": spins[1]}
    parameters = {"l_1": 1.0, "l_2": 1.0, "u": 0.0, "mu": mu, f"e_{law}": 0.5}
    named = ps.evaluate_jump("two-link-arm", law, state, parameters=parameters)
    assert [p.name for p in own.phases] == [p.name for p in named.phases]
    assert own.case is named.case and own.end is named.end
    np.testing.assert_allclose(np.delete(phases(own), 2, axis=1), phases(named), atol=1e-13)
    assert {p.tangential_impulse[1] for p in own.phases} == {0.0}
    after = named.velocity["theta_2_dot"] - named.velocity["theta_1_dot"]
    assert own.velocity["theta_2_dot"] == pytest.approx(after, rel=1e-12, abs=1e-13)
    assert own.energy_change == pytest.approx(named.energy_change, rel=1e-12)
    assert own.kinetic_energy == pytest.approx(named.kinetic_energy, rel=1e-12)


@pytest.mark.parametrize("velocity", [None, (-0.5, 0.3, -0.4), (-1.0, 0.0, 0.0)])
@pytest.mark.parametrize("law", LAWS)
def test_turning_robot_has_the_jump_and_the_solutions_of_the_named_mechanism(velocity, law):
    upper, lower, mu = -0.6435011087932844, -0.9272952180016122, 2.5
    tip = ps.robot(FILES / "turning_arm.urdf").contact(
        "tip", joints={"psi": 0.4, "shoulder": upper, "elbow": lower - upper}
    )
    state = {"psi": 0.4, "theta_1": upper, "theta_2": lower}
    parameters = {"mu": mu, "g": 9.81}
    if velocity is None:
        worst = slip_angle(tip.risk().direction) + 0.1
        velocity = (0.0, math.cos(worst), math.sin(worst))
    place = {"parameters": parameters, "contact_velocity": velocity}
    if velocity[0] == 0:
        own = tip.classify(mu, contact_velocity=velocity)
        named = ps.classify("two-link-arm-3d", state, **place)
        assert own.case is named.case
        for ours, theirs in zip(*(vars_of(a) for a in (own, named)), strict=True):
            assert ours == pytest.approx(theirs, rel=1e-10)
        assert own.to_dict()["contacts"]["tip"]["A"] < 0
    parameters[f"e_{law}"] = 0.6
    own = tip.jump(law, mu, 0.6, contact_velocity=velocity)
    named = ps.evaluate_jump("two-link-arm-3d", law, state, **place)
    assert [p.name for p in own.phases] == [p.name for p in named.phases]
    np.testing.assert_allclose(phases(own), phases(named), atol=1e-10)
    for joint, angle in (("psi", "psi"), ("shoulder", "theta_1")):
        for ours, theirs in (
            (own.velocity, named.velocity),
            (own.velocity_before, named.velocity_before),
        ):
            assert ours[f"{joint}_dot"] == pytest.approx(theirs[f"{angle}_dot"], abs=1e-10)


# ---- the laws of mechanics ----


@settings(max_examples=40)
@given(
    st.lists(FRACTION, min_size=12, max_size=12),
    st.lists(FRACTION, min_size=3, max_size=3),
    st.lists(FRACTION, min_size=3, max_size=3),
    st.floats(0.0, 3.0),
    st.floats(0.0, 1.0),
    st.sampled_from(LAWS),
    st.sampled_from(["free", "stuck"]),
)
def test_impact_balances_momentum_and_energy(bends, turn, motion, mu, e, law, others):
    robot = ps.robot(DOG)
    joints = {
        name: (j.lower + j.upper) / 2 + 0.49 * bend * (j.upper - j.lower)
        for bend, (name, j) in zip(bends, robot.joints.items(), strict=True)
    }
    normal = (0.3 * turn[0], 0.3 * turn[1], 1.0)
    feet = ("LF_foot", "RH_foot")
    foot = robot.contact(feet, joints=joints, normal=normal, others=others)
    velocity = (-abs(motion[0]) - 1e-3, motion[1], motion[2])
    # Beside stuck feet the base cannot turn about the vertical alone.
    moving = {"base_yaw": turn[2]} if others == "free" else {}
    jump = foot.jump(law, mu, e, moving, contact_velocity=velocity)
    names = foot.mechanism.outline.velocity_names
    before, after = (np.array([v[n] for n in names]) for v in (jump.velocity_before, jump.velocity))
    place = foot.mechanism.at(jump.velocity, {"mu": mu})
    _, moves = foot.mechanism.numbers.whole_at(place.values)
    both = foot._delassus.whole_at({**foot.values, **jump.velocity})[1]
    M = mass_matrix(foot)
    P = np.sum([p.impulse for p in jump.phases], axis=0)
    size = float(np.abs(P).max())
    gained = M @ (after - before)
    if others == "free":
        np.testing.assert_allclose(gained, moves.J.T @ P, atol=1e-9 * size)
    else:
        # What holds the other foot acts there alone, and its velocity stays.
        rest = np.linalg.lstsq(both.J[3:].T, gained - moves.J.T @ P, rcond=None)[0]
        np.testing.assert_allclose(both.J[3:].T @ rest, gained - moves.J.T @ P, atol=1e-8 * size)
        np.testing.assert_allclose(both.J[3:] @ (after - before), 0, atol=1e-9 * size)
    np.testing.assert_allclose(moves.J @ before, velocity, atol=1e-11)
    last = jump.phases[-1]
    reached = [last.normal_velocity, *last.slip_velocity]
    np.testing.assert_allclose(moves.J @ after, reached, atol=1e-9)
    change = after @ M @ after / 2 - before @ M @ before / 2
    assert change == pytest.approx(jump.energy_change, abs=1e-9 * jump.kinetic_energy)
    assert before @ M @ before / 2 == pytest.approx(jump.kinetic_energy, rel=1e-9)
    for p in jump.phases:
        assert math.hypot(*p.tangential_impulse) <= mu * p.normal_impulse * (1 + 1e-9) + 1e-15
    if law == "newton":
        assert last.normal_velocity >= -e * velocity[0] - 1e-9
    else:
        assert jump.energy_change <= 1e-12 * jump.kinetic_energy


def test_velocity_of_the_contact_takes_the_least_kinetic_energy():
    foot = standing()
    wanted = np.array([-0.2, 0.7, -0.4])
    jump = foot.jump("newton", 0.5, contact_velocity=wanted)
    names = foot.mechanism.outline.velocity_names
    M = mass_matrix(foot)
    J = foot.mechanism.numbers.whole_at(foot.mechanism.at({}, {"mu": 0.5}).values)[1].J
    # Lagrange's conditions of the least ½ u·M u with J u as wanted.
    whole = np.block([[M, J.T], [J, np.zeros((3, 3))]])
    least = np.linalg.solve(whole, [*np.zeros(len(names)), *wanted])[: len(names)]
    np.testing.assert_allclose([jump.velocity_before[n] for n in names], least, atol=1e-11)
    assert jump.kinetic_energy == pytest.approx(
        wanted @ np.linalg.solve(foot.mobility(), wanted) / 2, rel=1e-11
    )


def test_scene_that_is_turned_about_the_normal_has_the_same_impact():
    angle = 0.9
    c, s = math.cos(angle), math.sin(angle)
    straight = standing().jump("energetic", 2.0, 0.5, contact_velocity=(0.0, 1.0, 0.2))
    turned = standing()
    turned.values["base_yaw"] = angle
    there = turned.jump("energetic", 2.0, 0.5, contact_velocity=(0.0, c - 0.2 * s, s + 0.2 * c))
    assert [p.name for p in there.phases] == [p.name for p in straight.phases]
    for name, speed in straight.velocity.items():
        if not name.startswith("base"):
            assert there.velocity[name] == pytest.approx(speed, rel=1e-9, abs=1e-12)
    for a, b in zip(straight.phases, there.phases, strict=True):
        assert b.normal_impulse == pytest.approx(a.normal_impulse, rel=1e-10)
        x, y = a.tangential_impulse
        np.testing.assert_allclose(b.tangential_impulse, (c * x - s * y, s * x + c * y), atol=1e-11)
        x, y = a.direction
        assert b.direction == pytest.approx((c * x - s * y, s * x + c * y), abs=1e-9)
    x, y = straight.velocity["base_x_dot"], straight.velocity["base_y_dot"]
    moved = there.velocity["base_x_dot"], there.velocity["base_y_dot"]
    np.testing.assert_allclose(moved, (c * x - s * y, s * x + c * y), atol=1e-12)


def test_plastic_impact_that_sticks_is_that_of_pinocchio():
    pin = pytest.importorskip("pinocchio", reason="needs the group robots (pin)")
    model = pin.buildModelFromUrdf(str(DOG), pin.JointModelFreeFlyer())
    data = model.createData()
    robot = ps.robot(DOG)
    joints = {"LF_HFE": 0.7, "LF_KFE": -1.2, "RF_HAA": 0.1}
    foot = robot.contact("LF_foot", joints=joints)
    jump = foot.jump("energetic", 2.0, 0.0, {"RH_KFE": 0.3}, contact_velocity=(0.0, 1.0, 0.1))
    assert [p.name for p in jump.phases][:2] == ["tangential", "sticking compression"]
    q, v = pin.neutral(model), []
    for velocities in (jump.velocity_before, jump.velocity):
        v.append(np.zeros(model.nv))
        v[-1][:6] = [velocities[f"base_{n}_dot"] for n in ("x", "y", "z", "roll", "pitch", "yaw")]
        for name in robot.joints:
            at = model.joints[model.getJointId(name)]
            q[at.idx_q], v[-1][at.idx_v] = foot.values[name], velocities[f"{name}_dot"]
    world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    J = pin.computeFrameJacobian(model, data, q, model.getFrameId("LF_foot"), world)[:3]
    after = pin.impulseDynamics(model, data, q, v[0], J, 0.0, 0.0)
    np.testing.assert_allclose(v[1], after, atol=1e-12)
    P = np.sum([[*p.tangential_impulse, p.normal_impulse] for p in jump.phases], axis=0)
    np.testing.assert_allclose(data.impulse_c, P, atol=1e-12)
    M = pin.crba(model, data, q)
    M = np.triu(M) + np.triu(M, 1).T
    np.testing.assert_allclose(M @ (v[1] - v[0]), J.T @ P, atol=1e-12)


# ---- impact without collision ----


def test_foot_in_the_paradox_has_an_impact_without_collision():
    foot = standing()
    risk = foot.risk(2.0)
    for angle, inside in ((0.0, True), (0.9 * risk.sector.half_angle, True), (2.0, False)):
        slip = slip_angle(risk.direction) + angle
        velocity = (0.0, math.cos(slip), math.sin(slip))
        assert (foot.classify(2.0, contact_velocity=velocity).A < 0) == inside
        if not inside:
            with pytest.raises(InputError, match=r"need A <= 0 for an impact without collision"):
                foot.jump("energetic", 2.0, contact_velocity=velocity)
            continue
        assert foot.classify(2.0, contact_velocity=velocity).case.value == "inconsistent"
        jump = foot.jump("energetic", 2.0, 0.75, contact_velocity=velocity)
        assert jump.phases[0].name == "tangential" and jump.phases[0].normal_velocity < 0
        assert jump.phases[-1].normal_velocity > 0 and jump.energy_change < 0
        plain = ps.solve_impact(foot.mobility(), 2.0, velocity, "energetic", 0.75)
        assert plain.without_collision
        assert jump.normal_impulse == pytest.approx(plain.normal_impulse, rel=1e-9)


def test_risk_without_a_compiler_leaves_its_impact_out_and_says_so(monkeypatch):
    def none():
        raise CompilerMissing("no working C compiler: looked for cc. Fix: install gcc.")

    whole = standing().risk(2.0)
    monkeypatch.setattr(spatial, "_compiled", none)
    with pytest.warns(ps.PainleveWarning, match=r"impact .* is left out: .* Fix: install gcc"):
        risk = standing().risk(2.0)
    assert risk.impact is None and whole.impact is not None and risk.mu_P == whole.mu_P


def test_stuck_feet_change_the_impact_and_keep_their_velocity():
    feet = ("LF_foot", "RF_foot", "LH_foot", "RH_foot")
    stuck, free = standing(*feet, others="stuck"), standing(*feet)
    velocity = (0.0, 1.0, 0.0)
    jumps = [c.jump("energetic", 2.0, 0.5, contact_velocity=velocity) for c in (stuck, free)]
    # The trunk is heavy: what the others do hardly matters.
    assert 1e-6 < abs(jumps[0].normal_impulse / jumps[1].normal_impulse - 1) < 1e-3
    numbers, _ = stuck._delassus.whole_at({**stuck.values, **jumps[0].velocity})
    np.testing.assert_allclose(numbers.v[3:], 0, atol=1e-12)
    own = stuck.mechanism.numbers.at(stuck.mechanism.at({}, {"mu": 2.0}).values)
    np.testing.assert_allclose(own.W, stuck.mobility(), rtol=1e-12)
    np.testing.assert_allclose(own.A_stick, 1 / np.linalg.inv(own.W)[0, 0], rtol=1e-9)


# ---- a mechanism ----


def test_contact_is_a_mechanism_for_classify_and_jump():
    foot = standing()
    mechanism = foot.mechanism.with_parameters(mu=2.0)
    given = {"contact_velocity": (0.0, 1.0, 0.0)}
    assert ps.classify(mechanism, **given).case.value == "inconsistent"
    jump = ps.evaluate_jump(mechanism, "energetic", {"LF_KFE": "-80 deg"}, **given)
    assert jump.mechanism == "quadruped" and jump.contact == "LF_foot"
    assert "2.0" not in str(foot.mechanism.notices) and "ideal torque" in mechanism.notices[-1]
    assert mechanism.only("LF_foot").at().state["LF_HFE"] == 0.7
    assert mechanism == mechanism and mechanism != foot.mechanism and hash(mechanism)
    assert pickle.loads(pickle.dumps(mechanism)).at().values == mechanism.at().values
    with pytest.raises(InputError, match="numbers in space but no formulas"):
        _ = mechanism.system
    with pytest.raises(InputError, match="got contacts in space, need contacts in the plane"):
        ps.simulate(mechanism, "rigid", t_end=0.1)


def test_torques_and_velocities_move_the_free_acceleration():
    foot = standing()
    rest = foot.classify(0.5, contact_velocity=(0.0, 0.1, 0.0))
    pushed = foot.classify(0.5, torques={"LF_KFE": "5 N m"}, contact_velocity=(0.0, 0.1, 0.0))
    assert pushed.parameters["torque_LF_KFE"] == 5.0 and pushed.B != rest.B


def test_normal_velocity_of_rounding_is_none():
    foot = standing()
    assert foot.classify(0.5, {"base_z": 1e-10, "base_x": 0.1}).case.value == "slip"
    with pytest.raises(InputError, match=r"normal velocity 1e-08 m/s, need 0"):
        foot.classify(0.5, {"base_z": 1e-8, "base_x": 0.1})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mu": -1.0}, "parameter mu .*need a finite number with 0 <= mu"),
        ({"mu": math.nan}, "parameter mu"),
        ({"e": 1.5}, "need a finite number with 0 <= e_energetic <= 1"),
        ({"restitution": "bouncy"}, "bouncy"),
        ({"velocities": {"LF_KF": 1.0}}, "unknown velocity 'LF_KF'"),
        ({"contact_velocity": None}, "at rest there is no impact without collision"),
        ({"contact_velocity": (0.0, 1.0)}, "need 3 finite numbers along n, t1, t2"),
        ({"contact_velocity": (0.0, 1.0, math.inf)}, "need 3 finite numbers"),
        ({"contact_velocity": (0.1, 1.0, 0.0)}, "need v_n <= 0: the contact is opening"),
    ],
)
def test_what_a_jump_cannot_use_is_one_sentence(change, message):
    given = {"restitution": "energetic", "mu": 2.0, "contact_velocity": (0.0, 1.0, 0.0)}
    with pytest.raises(InputError, match=message):
        standing().jump(**given | change)


def test_what_a_pose_cannot_be_is_one_sentence():
    mechanism = standing(locked="LF_KFE").mechanism
    for state, message in (
        ({"LF_HFE": 9.0}, "joint LF_HFE: got 9 rad, need a value within its limits"),
        ({"LF_KFE_dot": 1.0}, "LF_KFE_dot: got 1 rad/s, need 0: joint LF_KFE is locked"),
        ({"base_pitch": math.pi / 2}, "base_pitch: got 1.5708 rad, need less than a right angle"),
    ):
        with pytest.raises(InputError, match=message):
            mechanism.at(state, {"mu": 0.5})
    stuck = standing("LF_foot", "RF_foot", others="stuck")
    with pytest.raises(InputError, match=r"contact RF_foot is stuck and moves with 0\.5 m/s"):
        stuck.classify(0.5, {"base_x": -0.5})
    with pytest.raises(InputError, match="mu: missing, need the friction coefficient"):
        mechanism.at()
    arm = ps.robot(FILES / "two_link.urdf").contact(
        "tip", joints={"theta_1": -0.5, "theta_2": -0.4}
    )
    with pytest.raises(InputError, match=r"cannot have here: the nearest is \[-1.0, 1.0, 0.0\]"):
        arm.jump("newton", 0.5, contact_velocity=(-1.0, 1.0, 0.3))
