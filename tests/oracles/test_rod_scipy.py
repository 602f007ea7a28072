"""Check the oracle against closed forms, conservation laws and independently computed values."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.benchmarks.cases import ROD
from tests.oracles.rod_scipy import (
    KINDS,
    RodEvent,
    RodRun,
    compression_for_force,
    simulate,
    stiffness,
)

NU, R, N, MU, G = 0.3, 0.00645, 1.764, 1.4, 9.8
SOFT, STIFF, STIFFEST = 20.9e10, 20.9e14, 20.9e16
#: The stiffness rounded to five digits, with which the reference values at E = 20.9e14 were made:
#: the exact 1.229683914e14 moves the times by 3e-6 of their value.
ROUNDED = STIFF * 1.2297e14 / stiffness(STIFF, NU, R)


def table3(E: float, **options: Any) -> RodRun:
    return simulate(1.0, 1.0, -1.0, E=E, t_end=1.0, until="separation", **options)


def table1(E: float, t_end: float, **options: Any) -> RodRun:
    return simulate(0.5, 1.0, -1.0, E=E, t_end=t_end, **options)


def from_force(F_n: float, E: float, **options: Any) -> RodRun:
    delta = compression_for_force(F_n, E, NU, R, N)
    return simulate(1.0, 5.0, -1.0, -delta, E=E, t_end=1.0, until="separation", **options)


def drop(speed: float, e: float, **options: Any) -> RodRun:
    """Let an upright frictionless rod, which is a point mass, fall on its gliding end."""
    return simulate(math.pi / 2, 0.0, -1.0, 0.0, -speed, mu=0.0, e=e, E=SOFT, **options)


def kinds(run: RodRun) -> list[str]:
    return [event.kind for event in run.events]


def first(run: RodRun, kind: str) -> RodEvent:
    return next(event for event in run.events if event.kind == kind)


def energy(state: dict[str, float]) -> float:
    """Return the mechanical energy of the rod with m = l = 1, without the contact's."""
    omega = state["theta_dot"]
    return 0.5 * (state["x_dot"] ** 2 + state["y_dot"] ** 2 + omega**2 / 3.0) + G * state["y"]


# --- Values computed independently of this project -------------------------------------------


def test_stiffness_matches_initial_forces_of_tables_5_and_6():
    assert stiffness(STIFF, NU, R) == pytest.approx(1.2297e14, abs=0.5e10)
    table5 = [stiffness(STIFF, NU, R) * d**N for d in (1.7628e-7, 2.6113e-7)]
    table6 = [stiffness(STIFFEST, NU, R) * d**N for d in (2.0942e-8, 2.5635e-8, 3.7974e-8)]
    # Half of the last printed digit of y_A, times n, is 5e-5 of the force.
    assert table5 + table6 == pytest.approx([150, 300, 350, 500, 1000], rel=5e-5)


def test_table3_events_match_reference_at_rounded_stiffness():
    run = table3(ROUNDED)
    assert kinds(run) == ["slip_stop", "max_compression", "slip_start", "separation"]
    stop, turn, _, separation = run.events
    assert stop.time == pytest.approx(4.0886112007e-4, abs=0.5e-14)
    assert stop.state["y_A_dot"] == pytest.approx(-0.0149123, abs=0.7e-7)
    assert stop.state["theta_dot"] == pytest.approx(1.6356694, abs=0.5e-7)
    assert turn.time == pytest.approx(4.1085837523e-4, abs=0.5e-14)
    assert turn.delta == pytest.approx(1.41009580e-6, abs=0.5e-14)
    assert turn.F_n == pytest.approx(5875.891, abs=0.5e-3)
    assert separation.time == pytest.approx(4.2816207e-4, abs=0.5e-11)
    # The reference stays in sticking to the end, which moves y_A_dot by 1e-7.
    assert separation.state["y_A_dot"] == pytest.approx(0.0656115, abs=2e-7)
    assert separation.state["theta_dot"] == pytest.approx(1.6029856, abs=0.5e-7)


def test_table3_events_at_exact_stiffness_do_not_depend_on_the_tolerance():
    rough, fine = table3(STIFF, rtol=1e-11), table3(STIFF, rtol=1e-13)
    expected = [4.08862422061e-4, 4.10859686824e-4, 4.28124005178e-4, 4.28163464097e-4]
    assert [event.time for event in fine.events] == pytest.approx(expected, rel=1e-11)
    for a, b in zip(rough.events, fine.events, strict=True):
        assert a.state["y_A_dot"] == pytest.approx(b.state["y_A_dot"], rel=3e-11, abs=1e-15)
        assert a.state["theta_dot"] == pytest.approx(b.state["theta_dot"], rel=1e-11)


def test_table3_separation_matches_80_bit_taylor_reference():
    final = table3(STIFF, rtol=1e-13).final
    for name, value in ROD.reference[True].items():
        # The reverse slip is a small rest of large velocities: 1e-13 of the 1 m/s before impact.
        assert final[name] == pytest.approx(value, rel=1e-12, abs=1e-13), name


def test_table3_soft_events_match_reference():
    run = table3(SOFT)
    assert first(run, "slip_stop").time == pytest.approx(3.509089e-3, abs=0.5e-9)
    separation = run.events[-1]
    assert separation.time == pytest.approx(3.987858e-3, abs=0.5e-9)
    assert separation.state["y_A_dot"] == pytest.approx(0.1245591, abs=0.5e-7)
    assert separation.state["theta_dot"] == pytest.approx(1.5664694, abs=0.6e-7)


def test_table3_reverse_slip_lasts_4e_minus_8_s():
    _, turn, start, separation = table3(STIFF).events
    assert start.mode == ("unloading", "right")
    assert separation.time - start.time == pytest.approx(4e-8, rel=0.05)
    assert turn.F_n_before == turn.F_n
    assert 0.0 < separation.state["x_A_dot"] < 1e-5


def test_table1_first_maximum_matches_reference():
    event = table1(SOFT, 2.5e-3).events[0]
    assert event.kind == "max_compression"
    assert event.time == pytest.approx(1.918e-3, abs=0.5e-6)
    assert event.F_n == pytest.approx(16.763, abs=0.5e-3)


def test_table1_virgin_reload_settles_and_follows_the_drifting_force():
    run = table1(STIFF, 1.5e-3)
    peaks = [event.F_n for event in run.events if event.kind == "max_compression"]
    amplitudes = [peak - 6.0 for peak in peaks[:3]]
    assert amplitudes == pytest.approx([10.7, 2.5, 0.4], abs=0.05)
    assert run.final["F_n"] == pytest.approx(6.07, abs=0.5e-2)
    later = table1(STIFF, 0.0175, rtol=1e-9)
    assert later.final["F_n"] == pytest.approx(6.40, abs=0.5e-2)


def test_table1_elastic_reload_never_settles():
    run = table1(SOFT, 0.01, reload="elastic")
    assert kinds(run)[:4] == ["max_compression", "reload", "yield", "max_compression"]
    assert min(event.F_n for event in run.events) < 0.02
    assert max(event.F_n for event in run.events) == pytest.approx(2.76 * 6.1, rel=0.02)


def test_table1_reload_rules_agree_until_the_first_reload():
    virgin = table1(SOFT, 4e-3)
    elastic = table1(SOFT, 4e-3, reload="elastic")
    assert kinds(virgin) == kinds(elastic) == ["max_compression", "reload"]
    assert virgin.events[1].time == elastic.events[1].time
    assert elastic.events[1].F_n == elastic.events[1].F_n_before
    assert virgin.events[1].F_n > 100.0 * virgin.events[1].F_n_before


def test_table2_jumps_up_without_any_event():
    run = simulate(0.5, 5.0, -1.0, E=SOFT, t_end=0.01)
    assert run.events == []
    assert run.mode == ("free", "free")
    assert run.final["y_A"] > 0.0


def test_table5_states_lift_off_while_slipping():
    assert simulate(1.0, 5.0, -1.0, t_end=0.01).events == []
    for delta in (1.7628e-7, 2.6113e-7):
        run = simulate(1.0, 5.0, -1.0, -delta, E=STIFF, t_end=0.01)
        assert kinds(run) == ["separation"]
        assert run.events[0].state["x_A_dot"] < 0.0
        assert run.events[0].delta == pytest.approx(delta * (1.0 - 0.75**2), rel=1e-14)


def test_table6_states_impact():
    for delta in (2.0942e-8, 2.5635e-8, 3.7974e-8):
        run = simulate(1.0, 5.0, -1.0, -delta, E=STIFFEST, t_end=0.01, until="separation")
        assert kinds(run) == ["slip_stop", "max_compression", "slip_start", "separation"]


def test_critical_force_separates_lift_off_from_impact():
    # Below it the end leaves the ground slipping; above it the slip stops in contact.
    assert kinds(from_force(346.8784, STIFF)) == ["max_compression", "separation"]
    assert kinds(from_force(346.8785, STIFF))[:2] == ["max_compression", "slip_stop"]
    # From a second one on, the slip stops before the compression does.
    assert kinds(from_force(346.9994, STIFF))[0] == "max_compression"
    assert kinds(from_force(346.9995, STIFF))[0] == "slip_stop"


def test_force_just_above_equilibrium_turns_at_once():
    # The compression turns inside the first step of the integrator, where the acceleration is
    # still a + j t: at -2 a / j, with j = (dA/dtheta F + dB/dtheta) omega + dB/domega alpha.
    F_n, omega, s, c = 333.0, 5.0, math.sin(1.0), math.cos(1.0)
    a = (1.0 + 3.0 * c * (c - MU * s)) * F_n + omega**2 * s - G
    alpha = 3.0 * (MU * s - c) * F_n
    j = -3.0 * (2.0 * s * c + MU * (c * c - s * s)) * F_n * omega + omega**3 * c
    j += 2.0 * omega * s * alpha
    run = from_force(F_n, STIFF)
    assert kinds(run) == ["max_compression", "separation"]
    assert run.events[0].time == pytest.approx(-2.0 * a / j, rel=1e-3)


# --- Closed forms and conservation ------------------------------------------------------------


def test_drop_upright_follows_energy_balance():
    speed, e, K = 0.5, 0.6, stiffness(SOFT, NU, R)
    turn, separation = drop(speed, e, t_end=1.0, until="separation").events
    work = K * turn.delta ** (N + 1.0) / (N + 1.0)
    assert work == pytest.approx(0.5 * speed**2 + G * turn.delta, rel=1e-11)
    rise = turn.delta - separation.delta
    assert separation.delta == pytest.approx((1.0 - e**2) * turn.delta, rel=1e-14)
    kinetic = e**2 * work - G * rise
    assert 0.5 * separation.state["y_A_dot"] ** 2 == pytest.approx(kinetic, rel=1e-11)


def test_drop_elastic_rule_touches_down_in_its_indentation_and_virgin_rule_reloads():
    # A slow drop with a weak rebound: the end turns round before its gap opens again.
    virgin = drop(0.002, 0.5, t_end=0.05, max_events=3)
    elastic = drop(0.002, 0.5, t_end=0.05, max_events=3, reload="elastic")
    assert kinds(virgin) == ["max_compression", "separation", "reload"]
    assert kinds(elastic) == ["max_compression", "separation", "touchdown"]
    left, back = elastic.events[1:]
    assert back.delta == left.delta
    assert back.mode == ("unloading", "left")
    assert back.state["y_A_dot"] == pytest.approx(-left.state["y_A_dot"], rel=1e-10)
    assert back.time - left.time == pytest.approx(2.0 * left.state["y_A_dot"] / G, rel=1e-10)
    turned = virgin.events[2]
    assert 0.0 < turned.delta < left.delta
    assert turned.F_n_before == 0.0
    assert turned.F_n == pytest.approx(stiffness(SOFT, NU, R) * turned.delta**N, rel=1e-14)


def test_drop_that_opens_the_gap_meets_a_virgin_surface():
    for reload in ("virgin", "elastic"):
        run = drop(0.5, 0.9, t_end=1.0, max_events=4, reload=reload)
        assert kinds(run) == ["max_compression", "separation", "touchdown", "max_compression"]
        touchdown = run.events[2]
        assert touchdown.delta == 0.0
        assert touchdown.mode[0] == "virgin"


def test_contact_states_agree_with_the_centre_of_mass():
    final = table3(STIFF).final
    s, c, omega = math.sin(final["theta"]), math.cos(final["theta"]), final["theta_dot"]
    assert final["y_A"] == pytest.approx(final["y"] - s, abs=1e-14)
    assert final["x_A"] == pytest.approx(final["x"] - c, abs=1e-12)
    assert final["y_A_dot"] == pytest.approx(final["y_dot"] - omega * c, abs=1e-12)
    assert final["x_A_dot"] == pytest.approx(final["x_dot"] + omega * s, abs=1e-12)


def test_sticking_phase_loses_only_the_energy_stored_in_the_contact():
    K = stiffness(STIFF, NU, R)
    ends = [table3(STIFF, max_events=count) for count in (1, 2)]
    total = [energy(run.final) + K * run.final["delta"] ** (N + 1) / (N + 1) for run in ends]
    assert total[0] == pytest.approx(total[1], rel=1e-13)


def test_flight_keeps_energy_and_rotation():
    run = simulate(0.7, 3.0, 0.4, 0.5, 1.0, t_end=0.1)
    start = {"x_dot": 0.4 - 3.0 * math.sin(0.7), "y_dot": 1.0 + 3.0 * math.cos(0.7)}
    start |= {"theta_dot": 3.0, "y": 0.5 + math.sin(0.7)}
    assert run.events == []
    assert energy(run.final) == pytest.approx(energy(start), rel=1e-13)
    assert run.final["theta_dot"] == 3.0


@pytest.mark.parametrize("slip", [0.0, -1.0, 1.0])
def test_mirrored_rod_mirrors_the_motion(slip: float):
    run = simulate(1.0, 1.0, slip, 0.0, -0.1, t_end=1.0, until="separation")
    mirror = simulate(math.pi - 1.0, -1.0, -slip, 0.0, -0.1, t_end=1.0, until="separation")
    assert kinds(run) == kinds(mirror)
    for a, b in zip(run.events, mirror.events, strict=True):
        assert a.time == pytest.approx(b.time, rel=1e-10)
        assert a.F_n == pytest.approx(b.F_n, rel=1e-9, abs=1e-12)
        assert a.F_t == pytest.approx(-b.F_t, rel=1e-9, abs=1e-12)


def test_simulate_refuses_unknown_names():
    with pytest.raises(ValueError, match="reload"):
        simulate(1.0, 1.0, -1.0, t_end=1.0, reload="both")
    with pytest.raises(ValueError, match="until"):
        simulate(1.0, 1.0, -1.0, t_end=1.0, until="landing")
    assert len(set(KINDS)) == len(KINDS)
