"""Events of several contacts whose forces or guards are at rounding level."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import painleve_sym as ps
from tests.scenes import FEET, LADDER, TABLE
from tests.scenes import simulator as scene

ENGINES = ("taylor", "compiled")


@pytest.mark.slow
def test_a_foot_that_comes_back_with_no_force_slips_on_both_engines():
    """Foot B meets its indented surface again with F_n = 0 while A is in the air.

    Its friction must not be divided by its normal force: such a series reaches nowhere.
    """
    runs = [
        scene(FEET, "linear", engine).run(
            {"y_A": 1e-3, "x_A_dot": -0.5},
            t_end=0.6,
            parameters={"k": 1e5, "c": 100.0, "beta": 0.0},
        )
        for engine in ENGINES
    ]
    assert {run.stop_reason for run in runs} == {ps.StopReason.T_END}
    assert max(run.energy_residual for run in runs) < 1e-10
    series, steps = ([(e.kind, e.contact, e.mode_after) for e in run.events] for run in runs)
    assert len(series) > 100
    assert series == steps
    times = [[e.time for e in run.events] for run in runs]
    assert np.allclose(*times, rtol=0, atol=1e-9)
    assert np.allclose(*(run.final_state[:3] for run in runs), rtol=0, atol=1e-11)


@pytest.mark.parametrize("state", [{"y_A": 1e-3, "x_A_dot": -0.5}, {"x_A_dot": 0.3}])
@pytest.mark.parametrize("damping", [100.0, 1000.0])
def test_state_and_time_of_an_event_agree_where_its_guard_is_at_rounding_level(state, damping):
    """Coordinates change by the integrals of their velocities over every recorded step."""
    run = scene(FEET, "linear", "compiled").run(
        state, t_end=3.0, parameters={"k": 1e5, "c": damping, "beta": 0.0}
    )
    assert run.final_time == 3.0
    place, weight = np.polynomial.legendre.leggauss(6)
    u = (place[:, None, None] + 1) / 2
    v, row = 1 - u, np.moveaxis(np.asarray(run.step_rows), 1, 0)[:, None]
    dense = row[7]
    for k, factor in zip(range(6, -1, -1), (u, v) * 4, strict=False):
        dense = row[k] + factor * dense
    names = list(run.state_names)
    for q in ("x_A", "y_A", "theta"):
        speed = dense[:, :, names.index(f"{q}_dot")]
        change = row[1][0][:, names.index(q)]
        missed = change - np.asarray(run.step_length) * (weight @ speed) / 2
        assert np.max(np.abs(missed)) < 5e-15


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("state", "damping", "t_end"),
    [
        ({"y_A": -4.9e-5}, 1000.0, 0.5),  # where the springs carry the weight exactly
        ({"y_A": -5e-5}, 1000.0, 3.0),
        ({"y_A": 1e-3, "x_A_dot": -0.5}, 100.0, 3.0),
    ],
)
def test_feet_that_have_come_to_rest_stay_there(engine, state, damping, t_end):
    """At rest δ̇ is noise: a turn is not followed by the turn back at the same instant."""
    run = scene(FEET, "linear", engine).run(
        state, t_end=t_end, parameters={"k": 1e5, "c": damping, "beta": 0.0}
    )
    assert run.stop_reason is ps.StopReason.T_END
    end = dict(zip(run.state_names, run.final_state, strict=True))
    assert abs(end["y_A"] + 9.8 / (2 * 1e5)) < 1e-12 and abs(end["theta"]) < 1e-12
    assert max(abs(end[v]) for v in ("x_A_dot", "y_A_dot", "theta_dot")) < 1e-9
    assert len(run.events) < 2000


def _bounces(fall, stiffness, gravity=9.8, mass=1.0):
    """Return times of landing and lift-off of a mass on two springs K δ^1.5 each, by quadrature."""
    speed = np.sqrt(2 * gravity * fall)

    def half_squared(depth):
        return speed**2 / 2 + gravity * depth - 2 * stiffness / mass * depth**2.5 / 2.5

    guess = (speed**2 * 2.5 / 2 / (2 * stiffness / mass)) ** 0.4
    deepest = brentq(half_squared, 0.5 * guess, 2 * guess, xtol=1e-300, rtol=1e-15)

    # With depth = deepest (1 - s²) the end of the integral is not singular.
    def slowness(s):
        value = half_squared(deepest * (1 - s * s)) if s > 1e-6 else None
        slope = 2 * stiffness / mass * deepest**1.5 - gravity
        root = np.sqrt(2 * value) / s if value is not None else np.sqrt(2 * slope * deepest)
        return 2 * deepest / root

    contact = 2 * quad(slowness, 0, 1, epsabs=0, epsrel=1e-12)[0]
    first, flight = speed / gravity, 2 * speed / gravity
    land = first + (contact + flight) * np.arange(5)
    return land, land + contact


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_level_feet_that_nothing_pulls_stick_through_every_bounce(engine):
    """Rounding alone loads their friction, also where their normal forces vanish together."""
    block = scene(FEET, "hertz", engine)
    run = block.run({"y_A": 1e-4}, t_end=0.05, parameters={"beta": 0.0})
    assert run.stop_reason is ps.StopReason.T_END
    modulus = 20.9e10 / (2 * (1 - 0.3**2))
    land, leave = _bounces(1e-4, 4 / 3 * modulus * np.sqrt(0.00645))
    for kind, expected in (("touchdown", land), ("separation", leave)):
        times = [e.time for e in run.events if e.kind == kind]
        assert times == pytest.approx(np.repeat(expected, 2), rel=1e-9)
    kinds = {str(e.kind) for e in run.events}
    assert kinds == {"touchdown", "max_compression", "separation"}
    assert run.energy_residual < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("law", ["hertz", "linear", "bilinear-hertz"])
@pytest.mark.parametrize("beta", [0.0, 0.2])
def test_feet_that_stick_close_together_without_force(law, beta, engine):
    """They begin with no gap, no speed and no force; the friction that they share begins at 0."""
    block = scene(FEET, law, engine)
    run = block.run({}, t_end=0.02, parameters={"beta": beta, "mu_A": 0.8, "mu_B": 0.8})
    assert run.stop_reason is ps.StopReason.T_END
    # Heights change by 1e-7 m: the energy of position knows seven digits less of that.
    assert run.energy_residual < 3e-9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "own"),
    [
        ("linear", {"mu_A": 0.4231, "mu_B": 0.0527, "h": 0.8001}),
        ("linear", {"mu_A": 0.423, "mu_B": 0.0527, "h": 0.8}),
        ("bilinear-hertz", {"mu_A": 0.0, "mu_B": 0.0, "h": 0.392}),
        ("bilinear-hertz", {"mu_A": 0.0, "mu_B": 0.0, "h": 0.873}),
    ],
)
def test_level_feet_bounce_on_where_rounding_hides_what_they_do(law, own):
    """No choice passes all tests at some closings: that which misses them least is taken."""
    run = scene(FEET, law).run({}, t_end=0.02, parameters=own | {"beta": 0.0})
    assert run.stop_reason is ps.StopReason.T_END
    assert run.energy_residual < 1e-8


@pytest.mark.parametrize("engine", ENGINES)
def test_gap_that_the_time_of_landing_leaves_is_none(engine):
    """A gap of 1.5e-19 m at 0.1 m/s is less than the time resolves: the foot has landed."""
    block = scene(FEET, "linear", engine)
    own = {"mu_A": 0.49830213037750776, "mu_B": 0.8923733301777431}
    own |= {"beta": 0.10784175032648641, "h": 0.8163479044588333}
    run = block.run({"y_A": 0.0005798963765634185}, t_end=0.1, parameters=own)
    assert run.stop_reason is ps.StopReason.T_END
    assert run.energy_residual < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_sprung_feet_that_land_together_pass_an_event_nearer_than_the_time_resolves(engine):
    own = {"E": 18701767256.49657, "e_energetic": 0.24499203746959647, "h": 0.1, "beta": 0.0}
    own |= {"mu_A": 0.0910257529392581, "mu_B": 0.4087910282735886}
    block = scene(FEET, "bilinear-hertz/spring", engine)
    run = block.run(
        {"y_A": 0.00019075344280769594}, t_end=0.02, parameters=own, rtol=1e-10, max_steps=20_000
    )
    assert run.stop_reason is ps.StopReason.T_END
    assert run.energy_residual < 1e-8


@pytest.mark.slow
def test_a_foot_whose_weight_pushes_it_along_slips_from_its_landing():
    """The ladder needs more friction per normal force than its floor has, from the start."""
    start = {"x": 1.0271218761271212, "y": 0.0006081081719470687, "theta": np.pi / 3}
    own = {"E": 69394331.93289804, "mu_floor": 0.2373631913771071, "mu_wall": 0.07047214230554795}
    for engine in ENGINES:
        run = scene(LADDER, "hertz", engine).run(start, t_end=0.03, parameters=own)
        assert run.events[0].mode_after == "slip_pos/compression + flight"
        assert [str(e.kind) for e in run.events] == ["touchdown", "max_compression"]


def test_a_step_that_an_event_makes_short_is_followed_by_one_that_can_be_made():
    """A guard that leaves zero and is back is sought by steps of 5e-17 s, at 0.012 s."""
    block = scene(FEET, "hertz", "compiled")
    fall, own = 6.919952583881844e-05, {"E": 19189113328.286472, "beta": 0.0}
    own |= {"mu_A": 0.14538932077643346, "mu_B": 0.11982759220630222, "h": 0.38866298232119584}
    run = block.run({"y_A": fall, "theta": -2.6634709631866107e-13}, t_end=0.02, parameters=own)
    assert run.stop_reason is ps.StopReason.T_END
    land, leave = _bounces(fall, own["E"] * 2 / 3 / (1 - 0.3**2) * np.sqrt(0.00645))
    for kind, expected in (("touchdown", land[:2]), ("separation", leave[:2])):
        times = [e.time for e in run.events if e.kind == kind]
        assert times == pytest.approx(np.repeat(expected, 2), rel=0, abs=2e-9)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_a_foot_that_lands_alone_slips_or_sticks_as_its_friction_says(engine):
    """Its friction per normal force is fixed by the place of the mass centre, in contact alone."""
    block = scene(FEET, "hertz", engine)
    own = {"mu_A": 0.8262412390067099, "mu_B": 0.09413360451043679, "h": 0.33813055104407247}
    own |= {"E": 2312883840.526052, "beta": 0.0}
    run = block.run({"y_A": 0.00012753422704046038, "theta": 1e-8}, t_end=0.018, parameters=own)
    m, J, a, h = 1.0, 0.02, 0.1, own["h"]
    needed = (a * h / J) / (1 / m + h**2 / J)
    assert own["mu_B"] < needed < own["mu_A"]
    landings = [i for i, e in enumerate(run.events) if str(e.kind) == "touchdown"]
    # Nothing happens before the other foot lands, 4e-8 s and 1.2e-7 s later.
    assert np.diff(landings)[::2].tolist() == [1, 1]
    modes = [run.events[i].mode_after for i in landings[::2]]
    assert modes == ["stick/compression + flight", "flight + slip_pos/compression"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "engines"),
    [
        ("linear", ENGINES),
        ("hertz", ENGINES),
        ("linear/static", ("taylor",)),
        ("hunt-crossley/stribeck", ("taylor",)),
        ("bilinear-hertz", ("taylor",)),
    ],
)
@pytest.mark.parametrize("own", [{"mu_floor": 0.3, "mu_wall": 0.3}, {"mu_floor": 0.9}])
def test_a_ladder_that_just_touches_floor_and_wall_begins_to_move(law, engines, own):
    """In free fall the gap of the wall, its rate and its acceleration are exactly zero.

    Only the force of the floor, which begins at 0, moves it. No residue of a force may decide.
    """
    runs = [
        scene(LADDER, law, engine).run({"x": 1.0, "theta": np.pi / 3}, t_end=0.004, parameters=own)
        for engine in engines
    ]
    assert {run.stop_reason for run in runs} == {ps.StopReason.T_END}
    assert max(run.energy_residual for run in runs) < 1e-8
    first, last = runs[0].final_state, runs[-1].final_state
    assert np.allclose(first, last, rtol=1e-5, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_smooth_ladder_on_linear_springs_moves_as_its_equations_say(engine):
    m, half, g, k = 5.0, 1.0, 9.8, 1e6

    def rates(t, s):
        x, y, angle, *speeds = s
        floor = k * max(-y, 0.0)
        wall = k * max(2 * half * np.cos(angle) - x, 0.0)
        # The lower end, in terms of the centre at (x - l cos, y + l sin).
        moment = half * (np.sin(angle) * wall - np.cos(angle) * floor)
        turn = 3 * moment / (m * half**2)
        w = speeds[2]
        push = wall / m - half * (np.sin(angle) * turn + np.cos(angle) * w**2)
        lift = floor / m - g - half * (np.cos(angle) * turn - np.sin(angle) * w**2)
        return [*speeds, push, lift, turn]

    start = [1.0, 0.0, np.pi / 3, 0.0, 0.0, 0.0]
    run = scene(LADDER, "linear", engine).run(
        {"x": 1.0, "theta": np.pi / 3},
        t_end=0.02,
        parameters={"mu_floor": 0.0, "mu_wall": 0.0, "k": k, "c": 0.0, "m": m, "l": half, "g": g},
    )
    exact = solve_ivp(rates, (0, 0.02), start, method="DOP853", rtol=1e-12, atol=1e-15)
    assert run.stop_reason is ps.StopReason.T_END
    names = list(run.state_names)
    places = [names.index(n) for n in ("x", "y", "theta", "x_dot", "y_dot", "theta_dot")]
    assert np.allclose(run.final_state[places], exact.y[:, -1], rtol=1e-8, atol=1e-9)


@pytest.mark.slow
def test_a_ladder_that_lands_upright_is_turned_by_the_floor_alone():
    """The wall is touched at no speed and no acceleration; the floor pushes little at first."""
    run = scene(LADDER, "hunt-crossley/stribeck").run(
        {"x": 1.0, "theta": np.pi / 3, "y_dot": 0.6},
        t_end=0.2,
        parameters={"mu_floor": 0.4, "mu_wall": 0.2},
        law_parameters={"E": 5e5, "static_ratio": 1.0},
        max_steps=2000,
    )
    assert run.stop_reason is ps.StopReason.T_END
    assert run.energy_residual < 1e-10
    # The floor lets it sink by 2 cm, and pushes the foot away from the wall.
    assert run.final["y"] < -0.01 and run.final["theta_dot"] < -0.1


@pytest.mark.slow
def test_feet_that_touch_just_before_a_rigid_one_do_not_slip_without_end():
    """Outer feet touch a moment before the middle one, by rounding, with forces of 1e-18 N."""
    v, g = 0.7348396471738055, 9.8
    run = scene(TABLE, "left=hunt-crossley,middle=rigid,right=hunt-crossley").run(
        {"y_dot": v},
        t_end=0.6,
        parameters={"mu_left": 0.0, "mu_middle": 0.0, "mu_right": 0.19986306051302952},
        law_parameters={
            "E_left": 108758881.0758459,
            "E_right": 25167224.34611439,
            "e_energetic_middle": 1.0,
        },
    )
    assert run.stop_reason is ps.StopReason.T_END
    since = 0.6 - 4 * (2 * v / g)
    assert run.final["y"] == pytest.approx(v * since - g * since**2 / 2, abs=1e-14)
    assert run.final["y_dot"] == pytest.approx(v - g * since, rel=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("v", "friction"), [(0.6929, (0, 0, 0.0787)), (0.6496, (0.8875, 0, 0.4342))]
)
def test_a_table_that_comes_straight_down_has_no_events_of_slip(v, friction):
    """No foot ever slips: a slip by rounding, which is within its tolerance, has no end either."""
    own = dict(zip(("mu_left", "mu_middle", "mu_right"), friction, strict=True))
    run = scene(TABLE, "left=hunt-crossley,middle=rigid,right=hunt-crossley").run(
        {"y_dot": v}, t_end=0.3, parameters=own
    )
    assert run.stop_reason is ps.StopReason.T_END and len(run.events) > 20
    assert [e.kind for e in run.events if "slip" in str(e.kind)] == []


def test_energy_of_a_block_that_stays_at_rest_closes():
    run = scene(FEET).run({}, t_end=0.6)
    assert max(abs(v) for n, v in run.final.items() if n.endswith("_dot")) < 1e-12
    assert run.energy_residual == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_a_foot_without_friction_holds_nothing_beside_one_that_sticks(engine):
    """The feet of a tilted block slip differently; near its rest both seem to stick."""
    block = scene(FEET, "A=rigid,B=hertz", engine)
    a, h, m, g, E = 0.5, 0.4, 2.0, 9.8, 1e7

    def turn(tilt):
        run = block.run({"theta": tilt}, t_end=1e-9, parameters=own, law_parameters={"E_B": E})
        return run.final["theta_dot"]

    own = {"a": a, "h": h, "m": m, "g": g, "mu_A": 1.2, "mu_B": 0.0, "beta": 0.0}
    rest = brentq(turn, -1e-2, -1e-6, xtol=1e-15)
    run = block.run({"theta": 1.001 * rest}, t_end=0.2, parameters=own, law_parameters={"E_B": E})
    assert run.stop_reason is ps.StopReason.T_END
    gap = 2 * a * np.sin(run.final["theta"])
    assert run.final["gap_B"] == pytest.approx(gap, abs=1e-13)
    assert run.final["slip_velocity_B"] == pytest.approx(-gap * run.final["theta_dot"], abs=1e-11)
    assert run.energy_residual < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_a_ladder_that_falls_along_its_wall_bounces_upright(engine):
    """The wall is touched all the time; rounding of the impacts does not decide whether it is."""
    v, g = 0.88, 9.8
    run = scene(LADDER, "rigid", engine).run(
        {"x": 1.0, "theta": np.pi / 3, "y_dot": v},
        t_end=0.7,
        parameters={"mu_floor": 0.43, "mu_wall": 0.0, "g": g},
        law_parameters={"e_energetic": 1.0},
    )
    assert run.stop_reason is ps.StopReason.T_END
    assert run.final["theta"] == pytest.approx(np.pi / 3, abs=1e-13)
    since = 0.7 - 3 * (2 * v / g)
    assert run.final["y"] == pytest.approx(v * since - g * since**2 / 2, abs=1e-12)


@pytest.mark.slow
def test_a_rigid_foot_does_not_jam_where_a_soft_one_separates():
    """Level, on the middle foot: the left foot separates with 1e-17 N as the right one touches."""
    run = scene(TABLE, "left=hertz,middle=rigid,right=linear").run(
        {
            "x_dot": 0.45096014299683307,
            "y_dot": 0.407682742667409,
            "theta_dot": 0.0257346603088362,
        },
        t_end=0.3,
        parameters={
            "mu_left": 0.31672326114270627,
            "mu_middle": 1.081373465453624,
            "mu_right": 0.0,
        },
        law_parameters={
            "E_left": 9076060.599591434,
            "k_right": 14523.597897218177,
            "e_energetic_middle": 0.0,
        },
    )
    assert run.stop_reason is ps.StopReason.T_END
    assert run.energy_residual < 1e-9


@pytest.mark.slow
def test_of_motions_that_rank_alike_the_first_is_taken():
    """Two of three sliding legs carry the table, in three ways: the first combination is taken.

    Under the policy liftoff each of them has one leg open, and none is preferred.
    """
    run = scene(TABLE, "rigid").run({"x_dot": 1.0}, t_end=1e-3)
    assert run.mode_names[run.final_mode] == "flight + slip_pos + slip_pos"
    assert abs(run.final_forces["normal_force_left"]) < 1e-20
