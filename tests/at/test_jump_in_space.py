"""The velocity jump of a mechanism in space: the plane in it, azimuth, energy, the command."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.cli import main
from painleve_sym.errors import InputError
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text

FALL = {"theta": 1.0, "theta_dot": 0.4, "x_A_dot": -0.7, "z_A_dot": -0.3}


@pytest.mark.parametrize("law", ["energetic", "poisson", "newton"])
@pytest.mark.parametrize("fall", [0.0, -0.3])
def test_rod_in_its_plane_is_the_planar_rod(law, fall):
    parameters = {"mu": 1.4, f"e_{law}": 0.6}
    state = {"theta": 1.0, "theta_dot": 0.4 if fall else 0.0, "x_A_dot": -0.7}
    plane = ps.evaluate_jump("rod", law, state | {"y_A_dot": fall}, parameters=parameters)
    space = ps.evaluate_jump("rod-3d", law, state | {"z_A_dot": fall}, parameters=parameters)
    assert (plane.case, plane.end) == (space.case, space.end)
    assert space.slip_velocity == (*plane.slip_velocity, 0.0) == (-0.7, 0.0)
    assert space.energy_change == pytest.approx(plane.energy_change, rel=1e-13)
    for one, other in zip(plane.phases, space.phases, strict=True):
        assert one.name == other.name
        assert other.normal_impulse == pytest.approx(one.normal_impulse, rel=1e-12)
        assert other.tangential_impulse == pytest.approx((*one.tangential_impulse, 0.0), abs=1e-14)
        assert other.stored_energy == pytest.approx(one.stored_energy, rel=1e-10, abs=1e-15)
        own = {"x_A_dot": "x_A_dot", "z_A_dot": "y_A_dot", "theta_dot": "theta_dot"}
        for name, planar in own.items():
            assert other.velocity[name] == pytest.approx(one.velocity[planar], abs=1e-13)
        assert all(abs(other.velocity[n]) < 1e-13 for n in ("y_A_dot", "psi_dot", "phi_dot"))
        sticks = one.name.startswith("sticking")
        assert one.direction == ((0.0,) if sticks else (-1.0,))
        assert other.direction == pytest.approx((*one.direction, 0.0), abs=1e-15)
        assert one.to_dict().keys() == other.to_dict().keys()


def test_azimuth_of_the_rod_turns_its_jump():
    parameters = {"mu": 0.4, "e_poisson": 0.7}
    state = FALL | {"y_A_dot": 0.9, "psi_dot": 0.3}
    one = ps.evaluate_jump("rod-3d", "poisson", state, parameters=parameters)
    turn = 2.1
    c, s = math.cos(turn), math.sin(turn)
    x, y = state["x_A_dot"], state["y_A_dot"]
    turned = state | {"psi": turn, "x_A_dot": c * x - s * y, "y_A_dot": s * x + c * y}
    other = ps.evaluate_jump("rod-3d", "poisson", turned, parameters=parameters)
    assert [p.name for p in one.phases] == [p.name for p in other.phases]
    for name in ("z_A_dot", "theta_dot", "psi_dot", "phi_dot"):
        assert other.velocity[name] == pytest.approx(one.velocity[name], abs=1e-11)
    x, y = one.velocity["x_A_dot"], one.velocity["y_A_dot"]
    after = other.velocity["x_A_dot"], other.velocity["y_A_dot"]
    assert after == pytest.approx((c * x - s * y, s * x + c * y), abs=1e-11)
    along, across = one.slip_velocity
    turned = c * along - s * across, s * along + c * across
    assert other.slip_velocity == pytest.approx(turned, abs=1e-13)


def test_jump_changes_the_kinetic_energy_by_its_work():
    state = FALL | {"y_A_dot": 0.9, "psi_dot": 0.3, "phi_dot": 2.0}
    jump = ps.evaluate_jump("rod-3d", "energetic", state, parameters={"mu": 0.4})
    mechanism = ps.model("rod-3d")
    kinetic = mechanism.system.kinetic_energy
    values = mechanism.at(state).values
    symbols = {s: values[s.name] for s in kinetic.free_symbols}
    moved = {s: (values | dict(jump.velocity))[s.name] for s in kinetic.free_symbols}
    change = float(kinetic.subs(moved) - kinetic.subs(symbols))
    assert jump.energy_change == pytest.approx(change, abs=1e-12)
    assert jump.kinetic_energy == pytest.approx(float(kinetic.subs(symbols)), rel=1e-13)


def test_command_has_phases_with_the_direction_of_slip(capsys):
    words = "jump rod-3d --state theta=1,x_A_dot=-1,y_A_dot=0.05 --set mu=1.4 --restitution 0.75"
    assert main([*words.split(), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["slip_velocity"] == pytest.approx([-1.0, 0.05])
    assert data["case"] == "c_sticking"
    first, *_, last = data["phases"]
    assert first["direction"] == pytest.approx([-1, 0], abs=1e-12) and last["direction"] == [0, 0]
    assert first["slip_velocity"] == [0.0, 0.0] and len(first["tangential_impulse"]) == 2
    assert main(words.split()) == 0
    text = capsys.readouterr().out
    assert "P_t1 [N s]" in text and "slip [rad]" in text


@pytest.mark.parametrize(
    ("state", "text"),
    [
        ({"theta": 1.0}, "at rest there is no impact"),
        ({"theta": 1.0, "x_A_dot": 1.0}, "got v_n = 0 with A = 3.7"),
        ({"theta": 1.0, "z_A_dot": 1.0}, "the contact is opening"),
    ],
)
def test_jump_refuses_what_is_not_an_impact(state, text):
    with pytest.raises(InputError, match=text):
        ps.evaluate_jump("rod-3d", "energetic", state)


ON_A_BELT = """
gravity = "9.8"
[coordinates]
h = {{ unit = "m" }}
[parameters]
m = {{ default = 2.0, unit = "kg", positive = true }}
mu = {{ default = 0.5, unit = "1" }}
[[bodies]]
mass = "m"
{}
[[contacts]]
name = "A"
friction = "mu"
gap = "h"
slip_velocity = {}
"""
PLANE = 'centre = ["0", "h"]', '"-0.8"'
SPACE = 'centre = ["0", "0", "h"]\ninertia = [1, 1, 1]'


@pytest.mark.parametrize("belt", [(0.8, 0.0), (0.0, 0.8), (0.48, -0.64)])
def test_ball_that_only_rises_and_falls_hits_a_belt(belt):
    """No motion slides it: P_n = m v (1 + e) and P_t = μ P_n along the belt, by hand."""
    state, parameters = {"h_dot": -1.0}, {"e_newton": 0.75}
    flat = mechanism_from_text(ON_A_BELT.format(*PLANE), "flat")
    plane = ps.evaluate_jump(flat, "newton", state, parameters=parameters)
    slip = json.dumps([str(-u) for u in belt])
    ball = mechanism_from_text(ON_A_BELT.format(SPACE, slip), "ball")
    space = ps.evaluate_jump(ball, "newton", state, parameters=parameters)
    for jump, along in ((plane, (1.0,)), (space, np.array(belt) / 0.8)):
        impulse = np.sum([p.impulse for p in jump.phases], axis=0)
        assert impulse == pytest.approx([3.5, *(1.75 * np.array(along))], rel=1e-14)
        assert jump.velocity == {"h_dot": 0.75}
        assert jump.energy_change == pytest.approx(0.75**2 - 1 - 1.75 * 0.8, rel=1e-14)
        assert jump.case.value == "sliding"
