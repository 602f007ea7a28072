"""One mechanism through both doors: in the plane, and in space with a second tangent.

Where the second tangent is uncoupled from the rest, the plane of the others holds everything: the
JSON has the same keys, and vectors of the plane are those of space without their zeros.
"""

from __future__ import annotations

import math

import pytest

from tests.cli.cli_helpers import run_json

SLEDGE = """
title = "A sledge on two runners"
gravity = "g"
[coordinates]
x = {{ unit = "m", meaning = "place along the ground" }}
{across}
z = {{ unit = "m", meaning = "height" }}
theta = {{ unit = "rad", meaning = "tilt" }}
[parameters]
m = {{ default = 1.0, unit = "kg", meaning = "mass", positive = true }}
J = {{ default = 0.02, unit = "kg m^2", meaning = "moment of inertia", positive = true }}
g = {{ default = 9.8, unit = "m/s^2", meaning = "gravity" }}
mu = {{ default = 1.5, unit = "1", meaning = "friction" }}
[[bodies]]
name = "sledge"
mass = "m"
{body}
[[contacts]]
name = "back"
friction = "mu"
point = {{ body = "sledge", at = [{back}] }}
[[contacts]]
name = "front"
friction = "mu"
point = {{ body = "sledge", at = [{front}] }}
"""
PLANAR = {
    "across": "",
    "body": 'inertia = "J"\nangle = "theta"\ncentre = ["x", "z + 0.3"]',
    "back": '"-0.1", "-0.3"',
    "front": '"0.2", "-0.3"',
}
SPATIAL = {
    "across": 'y = { unit = "m", meaning = "place across" }',
    "body": 'inertia = ["J", "J", "J"]\norientation = [["y", "-theta"]]\n'
    'centre = ["x", "y", "z + 0.3"]',
    "back": '"-0.1", 0, "-0.3"',
    "front": '"0.2", 0, "-0.3"',
}
OF_THE_COORDINATES = ("mechanism", "state", "parameters", "velocity", "W", "b")
OF_THE_SECOND_TANGENT = ("half_angle", "least_over_normals", "promise", "guarantee", "chatter")
"""What depends on the directions that the plane does not have."""


def padded(plane, space, where=()):
    """Assert that data of the plane are those of space, whose vectors end with a zero."""
    last = where[-1] if where else ""
    if last in (*OF_THE_COORDINATES, *OF_THE_SECOND_TANGENT):
        return
    if isinstance(plane, dict):
        assert list(plane) == list(space), where
        for key, value in plane.items():
            padded(value, space[key], (*where, key))
    elif isinstance(plane, list) and all(isinstance(v, float) for v in plane) and plane:
        assert space == pytest.approx([*plane, 0.0], rel=1e-9, abs=1e-11), where
    elif isinstance(plane, list):
        assert len(plane) == len(space), where
        for k, pair in enumerate(zip(plane, space, strict=True)):
            padded(*pair, (*where, k))
    elif last in ("mode", "name") and "solutions" in where:
        assert plane.partition("_")[0] == space, where  # the sign is that of the direction
    elif last == "residual":
        assert plane < 1e-12 > space
    else:
        own = pytest.approx(plane, rel=1e-9, abs=1e-11) if isinstance(plane, float) else plane
        assert space == own, where


@pytest.fixture(scope="module")
def sledges(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sledges")
    files = folder / "plane.toml", folder / "space.toml"
    for file, parts in zip(files, (PLANAR, SPATIAL), strict=True):
        file.write_text(SLEDGE.format(**parts))
    return [str(file) for file in files]


def both(capsys, *calls):
    """Return the JSON of a command in the plane and in space."""
    return [run_json(capsys, *call) for call in calls]


@pytest.mark.parametrize("spin", [1.0, 5.0])
@pytest.mark.parametrize("slip", [-1.0, 0.0, 1.0])
def test_classify_of_one_contact_is_the_same_in_the_plane_and_in_space(capsys, spin, slip):
    state = f"theta=1,theta_dot={spin},x_A_dot={slip}"
    plane, space = both(
        capsys, *(("classify", name, "--state", state) for name in ("rod", "rod-3d"))
    )
    padded(plane, space)
    (own,), (other,) = plane["contacts"].values(), space["contacts"].values()
    assert own["least_over_normals"] == pytest.approx(other["least_over_normals"])
    assert own["sector"]["half_angle"] == 0
    assert other["sector"]["half_angle"] == pytest.approx(math.acos(own["mu_P"] / 1.4))


@pytest.mark.parametrize("state", ["x_dot=-1", "x_dot=1", "x_dot=-1,theta=0.1,z=0.03"])
def test_classify_of_several_contacts_is_the_same_in_the_plane_and_in_space(capsys, sledges, state):
    closed = ["--close", "back:z,back:z_dot"] if "theta" in state else []
    plane, space = both(
        capsys, *(("classify", name, "--state", state, *closed) for name in sledges)
    )
    assert plane["solutions"] or plane["case"] == "inconsistent"
    padded(plane, space)


@pytest.mark.parametrize("fall", [0.0, -0.3])
def test_jump_is_the_same_in_the_plane_and_in_space(capsys, fall):
    state = "theta=1,theta_dot=0.4,x_A_dot=-0.7"
    planar = "jump", "rod", "--state", f"{state},y_A_dot={fall}"
    padded(*both(capsys, planar, ("jump", "rod-3d", "--state", f"{state},z_A_dot={fall}")))


def keys(data, where=()):
    """Yield the path of every key but the names of states, parameters and thresholds."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield (*where, key)
            if key not in (*OF_THE_COORDINATES, "lemke", "mpcc", "step", "thresholds"):
                yield from keys(value, (*where, key))
    elif isinstance(data, list):
        for value in data:
            yield from keys(value, where)


@pytest.mark.slow
def test_contrast_and_map_have_the_same_keys_in_the_plane_and_in_space(capsys):
    state = "theta=1,theta_dot=1,x_A_dot=-1"
    for call in (
        ("contrast", "--state", state),
        ("map", "--over", "theta,theta_dot", "--points", "5"),
    ):
        plane, space = both(capsys, *((call[0], name, *call[1:]) for name in ("rod", "rod-3d")))
        assert set(keys(plane)) == set(keys(space))
    assert set(plane["thresholds"]) == {*space["thresholds"], "mu_C"}  # of the planar rods alone
    least = [of["thresholds"]["least_over_normals"] for of in (plane, space)]
    assert least == pytest.approx([4 / 3, 4 / 3])
