"""Contacts at rest whose forces rigidity leaves open, between floor and wall: they stay at rest."""

from __future__ import annotations

import math

import numpy as np
import pytest

from painleve_sym.errors import StopReason
from painleve_sym.laws.catalogue import law
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.simulator import Simulator
from tests.scenes import LADDER, TABLE, parameter, simulator, standing_body

PUSH = """
[[loads]]
point = ["x", "y + h"]
force = ["P + Q*t", "0"]
"""


@pytest.fixture(scope="module")
def ladder() -> Simulator:
    return simulator(LADDER)


@pytest.fixture(scope="module")
def box() -> Simulator:
    """A box on two feet that is pushed against a wall."""
    body = standing_body(
        {"left": ("-a", "-h"), "right": ("a", "-h"), "wall": ("a", "-0.1*h")},
        contacts={"wall": 'through = ["a", "0"]\nslope = "pi/2"'},
        parameters=parameter("P", 12.0, "N", "push towards the wall")
        + parameter("Q", 0.0, "N/s", "growth of the push"),
        more=PUSH,
    )
    return Simulator(body, law("rigid"))


def leaning(angle):
    return {"x": 2 * math.cos(angle), "theta": angle}


HELD = {"mu_floor": 0.6, "mu_wall": 0.5}


def forces(run):
    """Return F_n and F_t by contact."""
    every = run.final_forces
    return {
        c: (every[f"normal_force_{c}"], every[f"tangential_force_{c}"]) for c in run.names.contacts
    }


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.8, math.pi / 3, 1.2, 1.4])
def test_a_ladder_that_friction_holds_stays(ladder, angle):
    """Four forces, three equations: they balance the weight, and one is at its bound."""
    run = ladder.run(leaning(angle), t_end=3.0, parameters=HELD, max_events=100)
    assert run.stop_reason is StopReason.T_END
    assert [e.mode_after for e in run.events] == ["stick + stick"]
    assert abs(run.final["theta"] - angle) < 1e-12
    (n_floor, t_floor), (n_wall, t_wall) = forces(run)["floor"], forces(run)["wall"]
    assert t_floor + n_wall == pytest.approx(0, abs=1e-9)
    assert n_floor - t_wall == pytest.approx(49.0)  # the tangent of the wall points down
    c, s = math.cos(angle), math.sin(angle)
    assert c * 49.0 + 2 * c * t_wall - 2 * s * n_wall == pytest.approx(0, abs=1e-9)
    shares = abs(t_floor) / (0.6 * n_floor), abs(t_wall) / (0.5 * n_wall)
    assert max(shares) == pytest.approx(1)


def test_a_ladder_too_flat_slides(ladder):
    """Both ends slide where tan θ < (1 − μ_f μ_w)/(2 μ_f)."""
    limit = math.atan(0.7 / 1.2)
    for angle, holds in ((limit + 1e-6, True), (limit - 1e-6, False)):
        run = ladder.run(leaning(angle), t_end=0.1, parameters=HELD, max_events=100)
        assert (run.events[0].mode_after == "stick + stick") == holds
        assert (abs(run.final["theta"] - angle) < 1e-9) == holds


@pytest.mark.slow
def test_engines_and_batches_agree_on_a_ladder_at_rest(ladder):
    ends = []
    for engine in ("auto", "compiled"):
        run = simulator(LADDER, engine=engine).run(
            leaning(1.0), t_end=1.0, parameters=HELD, max_events=100
        )
        assert [e.mode_after for e in run.events] == ["stick + stick"]
        ends.append([force for pair in forces(run).values() for force in pair])
    np.testing.assert_allclose(ends, [ends[0]] * 2, rtol=1e-9)
    angles = np.linspace(0.7, 1.4, 9)
    batch = run_batch(ladder, {"x": 2 * np.cos(angles), "theta": angles}, HELD, t_end=1.0)
    assert batch.counts() == {"t_end": 9}
    assert np.abs(batch["theta"] - angles).max() < 1e-12


@pytest.mark.parametrize("push", [3.0, 12.0])
@pytest.mark.slow
def test_a_box_against_a_wall_stays(box, push):
    """Feet bear up to μ m g = 5.88 N, and leave the wall without force; it bears the rest."""
    run = box.run({"t": 0.0}, t_end=1.0, parameters={"P": push}, max_events=100)
    assert run.stop_reason is StopReason.T_END
    assert len(run.events) == 1
    own = forces(run)
    for n, t in own.values():
        assert abs(t) <= 0.3 * n * (1 + 1e-9) + 1e-9
    (n_left, t_left), (n_right, t_right), (n_wall, t_wall) = own.values()
    assert push + t_left + t_right - n_wall == pytest.approx(0, abs=1e-9)
    assert n_left + n_right + t_wall == pytest.approx(2 * 9.8)
    assert (n_wall > 1e-9) == (push > 5.88)
    assert max(abs(run.final[n]) for n in ("x", "y", "theta")) < 1e-13


@pytest.mark.slow
def test_a_push_that_grows_is_taken_over_by_the_wall(box):
    run = box.run({"t": 0.0}, t_end=1.0, parameters={"P": 1.0, "Q": 10.0}, max_events=100)
    assert run.stop_reason is StopReason.T_END
    (start,) = run.events_of("slip_start")[:1]
    assert start.time == pytest.approx(0.488, rel=1e-9)
    assert forces(run)["wall"][0] > 0
    assert max(abs(run.final[n]) for n in ("x", "y", "theta")) < 1e-12
    at_rest = {"stick", "flight"}
    assert {m for e in run.events for m in e.mode_after.split(" + ")} <= at_rest


@pytest.mark.slow
def test_what_rests_unloaded_bears_load_as_soon_as_the_others_do_not_hold_it():
    """A level table stands on its middle leg; a push that grows like t³ loads an outer one."""
    text = TABLE.read_text("utf-8")
    push = '[[loads]]\npoint = ["x", "y + h"]\nforce = ["Q*t**3", "0"]\n\n[[contacts]]'
    text = text.replace("[[contacts]]", push, 1)
    text = text.replace(
        "mu_left =",
        'Q = { default = 20.0, unit = "N/s^3", meaning = "growth of a push" }\nmu_left =',
        1,
    )
    run = Simulator(mechanism_from_text(text, name="legs"), law("rigid")).run(
        {"t": 0.0}, t_end=1.0, max_events=100
    )
    assert run.stop_reason is StopReason.T_END
    own = forces(run)
    assert sum(n for n, _ in own.values()) == pytest.approx(98.0)
    assert sum(t for _, t in own.values()) == pytest.approx(-20.0)
    # About the middle of the feet: 0.7 m · 20 N.
    assert 0.6 * (own["right"][0] - own["left"][0]) == pytest.approx(14.0)
    assert max(abs(run.final[n]) for n in ("x", "y", "theta")) < 1e-10


def test_forces_of_a_ladder_at_rest_do_not_depend_on_units(ladder):
    """Of the forces that would do, rounding does not choose."""
    ends = []
    for length, mass, time in ((1, 1, 1), (1e-6, 1e-9, 1e-3), (1e6, 1e9, 1e3), (3e-5, 7e4, 0.02)):
        unit = mass * length / time**2
        p = HELD | {"l": length, "m": 5.0 * mass, "g": 9.8 * length / time**2}
        start = leaning(1.0)
        start["x"] *= length
        run = ladder.run(start, t_end=time, parameters=p, max_events=100)
        ends.append([force / unit for pair in forces(run).values() for force in pair])
    np.testing.assert_allclose(ends, [ends[0]] * 4, rtol=1e-12)
