"""Shapes of mechanisms: those declared, those suggested, and those that a file gives."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import sympy as sp

from painleve_sym import (
    InputError,
    LagrangianSystem,
    Mechanism,
    ModelError,
    load_mechanism,
    model,
)
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.mechanics.bars import bending_modes
from painleve_sym.mechanics.drawing import (
    contact_geometries,
    ground_surfaces,
    scene_formulas,
    shapes_of,
)
from painleve_sym.mechanics.models import EVERYDAY, MODELS
from painleve_sym.mechanics.shapes import PLACE, Shape
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text

FILES = sorted(
    path
    for path in (Path(__file__).parents[2] / "examples" / "mechanisms").glob("*.toml")
    if path.stem not in ("rod-on-ball", "tumbling-brick")  # in space: not drawn
)
TWO_BODIES = ("newtons-cradle", "sprag")
"""Their contacts are between two bodies that move."""
EVERY = [*MODELS, *EVERYDAY, *map(str, FILES)]

BODY = """
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
phi = { unit = "rad" }
[parameters]
m = { default = 2.0, unit = "kg", positive = true }
J = { default = 0.06, unit = "kg m^2", positive = true }
mu = { default = 0.3, unit = "1" }
[[bodies]]
mass = "m"
inertia = "J"
angle = "phi"
centre = ["x", "y"]
[[contacts]]
name = "A"
friction = "mu"
"""

WEDGE = """
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
z = { unit = "m" }
[parameters]
m = { default = 1.0, unit = "kg", positive = true }
alpha = { default = 0.35, unit = "rad" }
mu = { default = 0.3, unit = "1" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[[bodies]]
mass = "m"
centre = ["0", "z"]
[[contacts]]
name = "floor"
point = ["x", "y"]
friction = "mu"
[[contacts]]
name = "face"
gap = "(z - y + x*tan(alpha))*cos(alpha)"
slip_velocity = "-x_dot*cos(alpha) + (z_dot - y_dot)*sin(alpha)"
at = ["0", "z"]
slope = "-alpha"
friction = "mu"
"""


def _values(mechanism: Mechanism, **state: float) -> dict[str, float]:
    zero = dict.fromkeys(mechanism.state_names, 0.0)
    return zero | dict(mechanism.start) | mechanism.parameters | state


def _places(mechanism: Mechanism, values: dict[str, float]) -> dict[str, float]:
    formulas = scene_formulas(mechanism, shapes_of(mechanism))
    return dict(zip(formulas, map(float, numbers(list(formulas.values()), values)), strict=True))


@pytest.mark.parametrize("name", EVERY)
def test_every_mechanism_has_shapes_and_places(name):
    mechanism = model(name)
    places = _places(mechanism, _values(mechanism))
    assert all(math.isfinite(v) for v in places.values())
    assert shapes_of(mechanism)
    assert list(contact_geometries(mechanism)) == [c.name for c in mechanism.contacts]


@pytest.mark.parametrize("name", EVERY)
def test_force_along_the_normal_does_work_on_the_gap(name):
    """The rows of the Jacobian are the point's motion along normal and tangent (virtual work)."""
    mechanism = model(name)
    values = _values(mechanism)
    values |= {q.name: values[q.name] + 0.05 * (i + 1) for i, q in enumerate(mechanism.system.q)}
    for contact in mechanism.contacts:
        geometry = contact.geometry
        if geometry.rim is not None:
            continue  # the point that touches is not one of the disc
        n_x, n_y = geometry.normal
        point = sp.Matrix(geometry.point).jacobian(mechanism.system.q)
        rows = sp.Matrix([[n_x, n_y], [n_y, -n_x]]) * point
        expected = sp.Matrix.vstack(contact.J_N, contact.J_T)
        if "bowl" in name:
            rows, expected = rows[1, :], expected[1, :]  # its gap is a distance to first order
        if name in TWO_BODIES:  # the point belongs to one of them
            own = [i for i in range(point.cols) if any(point[:, i])]
            rows, expected = rows[:, own], expected[:, own]
        difference = numbers([*(rows - expected)], values)
        assert abs(difference).max() < 1e-12


@pytest.mark.parametrize("name", EVERY)
def test_point_of_a_closed_contact_is_on_its_surface(name):
    mechanism = model(name)
    values = _values(mechanism)
    for contact in mechanism.contacts:
        geometry = contact.geometry
        level = [
            geometry.surface.subs(
                {
                    p: x + h * n
                    for p, x, n in zip(PLACE, geometry.point, geometry.normal, strict=True)
                }
            )
            for h in (0, 1e-3)
        ]
        gap, here, above = numbers([contact.gap, *level], values)
        assert abs(here) < 1e-12 if abs(gap) < 1e-12 else (here > 0) == (gap > 0)
        assert above > here


def test_rod_is_a_stick_of_its_length():
    rod = model("rod")
    places = _places(rod, _values(rod, x_A=0.5, theta=0.7))
    ends = [[places[f"shape_0_point_{k}_{axis}"] for axis in "xy"] for k in range(2)]
    assert ends[0] == [0.5, 0.0]
    assert ends[1] == pytest.approx([0.5 + 2 * math.cos(0.7), 2 * math.sin(0.7)])


def test_bodies_suggest_the_links_of_an_arm():
    arm = model("two-link-arm")
    places = _places(arm, _values(arm))
    joint = [places[f"shape_0_point_1_{a}"] for a in "xy"]
    assert [places[f"shape_1_point_0_{a}"] for a in "xy"] == pytest.approx(joint)
    tip = [places[f"shape_1_point_1_{a}"] for a in "xy"]
    assert tip == pytest.approx([places["tip_x"], places["tip_y"]])
    assert [places[f"shape_0_point_0_{a}"] for a in "xy"] == pytest.approx([0, 0.7])
    # The base of the upper link is fixed in space.
    assert [s.kind for s in shapes_of(arm)] == ["stick", "stick", "pin"]
    assert [places[f"shape_2_point_0_{a}"] for a in "xy"] == pytest.approx([0, 0.7])


def test_surfaces_of_bodies_are_no_ground_and_belts_have_a_speed():
    wedge = mechanism_from_text(WEDGE)
    assert list(contact_geometries(wedge)) == ["floor", "face"]
    assert list(ground_surfaces(wedge)) == ["floor"]
    table = load_mechanism(str(FILES[[f.stem for f in FILES].index("oscillating-table")]))
    assert list(ground_surfaces(table)) == ["table"]
    arm = model("two-link-arm")
    assert _places(arm, _values(arm) | {"u": 0.3})["tip_surface_speed"] == 0.3
    assert _places(wedge, _values(wedge))["face_surface_speed"] == 0


def test_elastic_rod_is_bent_as_its_modes_and_its_end_is_the_contact_point():
    rod = model("rod-bending")
    values = _values(rod, theta=0.7, w_1=0.01, w_2=-0.004, u_1=0.002)
    places = _places(rod, values)
    count = len(shapes_of(rod)[0].points)
    line = [
        complex(places[f"shape_0_point_{k}_x"], places[f"shape_0_point_{k}_y"])
        for k in range(count)
    ]
    assert line[0] == pytest.approx(complex(places["A_x"], places["A_y"]))
    beta = float(bending_modes(("free", "free"), 1)[0].wavenumber)
    # The first free mode by the textbook: (cosh + cos) − σ (sinh + sin), 2 at the ends.
    sigma = (math.cosh(beta) - math.cos(beta)) / (math.sinh(beta) - math.sin(beta))
    still = _places(rod, _values(rod, theta=0.7))
    bent = _places(rod, _values(rod, theta=0.7, w_1=0.01))
    for k in range(count):
        across = [bent[f"shape_0_point_{k}_{a}"] - still[f"shape_0_point_{k}_{a}"] for a in "xy"]
        own = across[1] * math.cos(0.7) - across[0] * math.sin(0.7)
        x = beta * k / (count - 1)
        shape = math.cosh(x) + math.cos(x) - sigma * (math.sinh(x) + math.sin(x))
        assert own == pytest.approx(0.01 * shape, abs=1e-9)


def test_feet_suggest_a_box_with_the_mass_centre_in_its_middle():
    table = load_mechanism(str(FILES[[f.stem for f in FILES].index("three-legged-table")]))
    (shape,) = shapes_of(table)
    corners = numbers([v for p in shape.points for v in p], _values(table)).reshape(-1, 2)
    expected = [[-0.6, 0.0], [0.6, 0.0], [0.6, 1.4], [-0.6, 1.4]]
    assert abs(corners - expected).max() < 1e-12


def test_one_contact_of_several_keeps_the_shapes_of_all():
    table = load_mechanism(str(FILES[[f.stem for f in FILES].index("three-legged-table")]))
    assert shapes_of(table.only("left")) == shapes_of(table)


def test_body_without_a_point_of_contact_is_the_stick_of_its_inertia():
    text = BODY + 'gap = "y"\nslip_velocity = "x_dot"\n'
    mechanism = mechanism_from_text(text)
    (shape,) = shapes_of(mechanism)
    x_1, y_1, x_2, y_2 = numbers([v for p in shape.points for v in p], _values(mechanism, phi=0.4))
    assert math.hypot(x_2 - x_1, y_2 - y_1) == pytest.approx(math.sqrt(12 * 0.06 / 2.0))
    assert math.atan2(y_2 - y_1, x_2 - x_1) == pytest.approx(0.4)
    assert contact_geometries(mechanism) == {}


def test_shapes_of_a_file():
    text = BODY + 'point = ["x", "y"]\n'
    for shape in (
        'stick = [["x", "y"], ["x + cos(phi)", "y"]]',
        'polygon = [["x", "y"], ["x + 1", "y"], ["x", "y + 1"]]',
        'box = { centre = ["x", "y"], width = "0.2", height = 0.1, angle = "phi" }',
        'disc = { centre = ["x", "y"], radius = "0.2", angle = "phi" }',
        'stick = [["x", "y"], ["x + 1", "y"], ["x + 2", "y"]]',
        'dot = ["x", "y"]',
        'pin = ["1", "m"]',
    ):
        (drawn,) = mechanism_from_text(f"{text}[[shapes]]\n{shape}\n").shapes
        assert drawn.kind == shape.split()[0].replace("box", "polygon")


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ('stick = [["x", "y"]]', "got 1 points, need at least 2 points"),
        ('polygon = [["x", "y"], ["x", 1]]', "got 2 points, need at least 3"),
        ('stick = ["x", "y"]', "need a list of points"),
        ('dot = ["x", "z"]', "unknown name 'z'"),
        ('dot = ["x", "x_dot"]', "depends on a velocity"),
        ('dot = ["x", "y"]\nstick = [["x", "y"], ["x", 0]]', "got stick and dot, need one of"),
        ('circle = ["x", "y"]', "unknown key 'circle'"),
        ('box = { centre = ["x", "y"], width = 1 }', "height is missing"),
    ],
)
def test_fault_of_a_shape_names_its_line(shape, message):
    with pytest.raises(ModelError, match=message.replace("(", r"\(")):
        mechanism_from_text(f'{BODY}point = ["x", "y"]\n[[shapes]]\n{shape}\n')


def test_energies_alone_are_nothing_to_draw():
    text = BODY.replace("[[bodies]]", "").replace('mass = "m"', "").replace('inertia = "J"', "")
    text = text.replace('angle = "phi"', "").replace('centre = ["x", "y"]', "")
    text += 'gap = "y"\nslip_velocity = "x_dot"\n'
    text += '[energy]\nkinetic = "m*(x_dot**2 + y_dot**2)/2 + J*phi_dot**2/2"\n'
    with pytest.raises(InputError, match="nothing to draw"):
        shapes_of(mechanism_from_text(text))


def test_shapes_play_no_part_in_derivations():
    rod = model("rod")
    other = Mechanism(
        rod.name,
        rod.title,
        rod.source,
        rod.system,
        rod.contacts,
        rod.domain,
        rod.sketch,
        rod.start,
        (Shape.dot((0, 0)),),
    )
    assert other.definition == rod.definition and other == rod
    assert isinstance(other.system, LagrangianSystem)
