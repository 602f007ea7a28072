"""Shapes with which a mechanism is drawn: sticks, polygons, discs, dots and pins.

A shape is a list of points, each a function of coordinates, time and parameters. So the place of
every body in a drawing follows from the kinematics of the mechanism, in Python as in other
languages.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

import sympy as sp

from painleve_sym.mechanics.bodies import Body, Point, Scalar, expr, moved

if TYPE_CHECKING:
    from painleve_sym.mechanics.system import LagrangianSystem

PLACE = (sp.Symbol("place x", real=True), sp.Symbol("place y", real=True))
"""A place (x, y) of the plane, in the formula of a surface; m. No parameter can have this name."""


class ShapeKind(StrEnum):
    """Kinds of shapes, by the meaning of their points."""

    STICK = "stick"
    POLYGON = "polygon"
    DISC = "disc"
    DOT = "dot"
    PIN = "pin"


@dataclass(frozen=True)
class Shape:
    """A shape that moves with a mechanism.

    A stick has its two ends, with points between them where it is bent; a polygon has its corners
    in order, a disc its centre and a point of its rim that turns with it, a dot its place. A pin is
    a joint that is fixed in space.

    Examples
    --------
    >>> from painleve_sym.mechanics import Shape
    >>> import sympy as sp
    >>> x, y, l, phi = sp.symbols("x y l phi")
    >>> Shape.stick((x, y), (x + l * sp.cos(phi), y + l * sp.sin(phi))).points[1]
    (l*cos(phi) + x, l*sin(phi) + y)
    >>> Shape.box((x, y), 2, 1).kind
    <ShapeKind.POLYGON: 'polygon'>
    """

    kind: ShapeKind
    points: tuple[Point, ...]

    @classmethod
    def stick(cls, *points: Point) -> Shape:
        """Return the open line through two points or more."""
        return cls(ShapeKind.STICK, points)

    @classmethod
    def polygon(cls, *corners: Point) -> Shape:
        """Return the closed line through at least three corners."""
        return cls(ShapeKind.POLYGON, corners)

    @classmethod
    def box(cls, centre: Point, width: Scalar, height: Scalar, angle: Scalar = 0) -> Shape:
        """Return a rectangle with its middle, its sides (m) and the angle of its width (rad)."""
        half = [(a * expr(width) / 2, b * expr(height) / 2) for a, b in _SIGNS]
        return cls.polygon(*(moved(centre, corner, angle) for corner in half))

    @classmethod
    def disc(cls, centre: Point, radius: Scalar, angle: Scalar = 0) -> Shape:
        """Return a circle with its middle, its radius (m) and the angle of a mark on it (rad)."""
        return cls(ShapeKind.DISC, (centre, moved(centre, (expr(radius), sp.Integer(0)), angle)))

    @classmethod
    def dot(cls, place: Point) -> Shape:
        """Return a point, drawn of a size that does not depend on the mechanism."""
        return cls(ShapeKind.DOT, (place,))

    @classmethod
    def pin(cls, place: Point) -> Shape:
        """Return a fixed joint, drawn of a size that does not depend on the mechanism."""
        return cls(ShapeKind.PIN, (place,))


@dataclass(frozen=True)
class ContactGeometry:
    """The place of a contact in the plane, with which its forces are drawn.

    `point` is that of the mechanism that touches, `rim` the disc whose rim touches. F_n acts on the
    mechanism along the unit vector `normal`, F_t along it turned clockwise by a right angle.
    `surface` is a function of `PLACE`, zero on the surface and positive on its free side.
    """

    point: Point
    normal: Point
    surface: sp.Expr
    rim: Shape | None = None

    @classmethod
    def straight(
        cls, point: Point, slope: Scalar = 0, gap: Scalar = 0, rim: Shape | None = None
    ) -> ContactGeometry:
        """Return the geometry of a point that is `gap` above a straight surface of this slope."""
        normal = (-sp.sin(slope), sp.cos(slope))
        away = [p - expr(q) for p, q in zip(PLACE, point, strict=True)]
        surface = sum((n * a for n, a in zip(normal, away, strict=True)), expr(gap))
        return cls(point, normal, surface, rim)


_SIGNS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def suggested_shapes(
    system: LagrangianSystem, geometries: Sequence[ContactGeometry]
) -> tuple[Shape, ...]:
    """Return the shapes that rims and bodies suggest (`shapes_of`); none without either."""
    shapes = tuple(_suggested(system, geometries))
    ends = [p for s in shapes if s.kind is ShapeKind.STICK for p in s.points]
    return (*shapes, *(Shape.pin(p) for p in ends if is_still(system, p)))


def _suggested(system: LagrangianSystem, geometries: Sequence[ContactGeometry]) -> Iterator[Shape]:
    rims = [g.rim for g in geometries if g.rim]
    yield from rims
    points = [g.point for g in geometries if not g.rim]
    for body in system.bodies:
        if any(_local(system, body, rim.points[0]) is not None for rim in rims):
            yield Shape.dot(body.centre)
        else:
            yield _body_shape(system, points, body)


def _body_shape(system: LagrangianSystem, points: Sequence[Point], body: Body) -> Shape:
    local = [p for p in (_local(system, body, point) for point in points) if p is not None]
    values = {p.symbol: sp.Float(p.default) for p in system.parameters}
    corners = _hull([*local, *((-x, -y) for x, y in local)], values)
    if expr(body.inertia) == 0 or not corners:
        if expr(body.inertia) == 0:
            return Shape.dot(body.centre)
        half = sp.sqrt(3 * expr(body.inertia) / expr(body.mass))
        corners = [(-half, sp.Integer(0)), (half, sp.Integer(0))]
    placed = [moved(body.centre, corner, body.angle) for corner in corners]
    return Shape.stick(*placed) if len(placed) == 2 else Shape.polygon(*placed)


def _local(system: LagrangianSystem, body: Body, point: Point) -> tuple[sp.Expr, sp.Expr] | None:
    """Return a point in the axes of a body, or None where it does not move with the body."""
    x, y = (expr(p) - expr(c) for p, c in zip(point, body.centre, strict=True))
    local = moved((0, 0), (x, y), -expr(body.angle))
    if not is_still(system, local):
        return None
    # What does not depend on the place has the same value at any.
    here = dict.fromkeys([*system.q, *system.clock], sp.Integer(0))
    return local[0].subs(here), local[1].subs(here)


def is_still(system: LagrangianSystem, values: Sequence[Scalar], *, driven: bool = False) -> bool:
    """Return whether expressions change with no coordinate, nor with the time unless `driven`."""
    from painleve_sym.mechanics.system import vanish_everywhere

    moving = [*system.q, *(() if driven else system.clock)]
    return vanish_everywhere(sp.diff(expr(v), s) for v in values for s in moving)


def _hull(points: Sequence[Point], values: dict[sp.Symbol, sp.Expr]) -> list[Point]:
    """Return the corners of the convex hull, counter-clockwise at these values of parameters.

    Two for points on one line, none for points that coincide.
    """
    at = [(float(expr(x).subs(values)), float(expr(y).subs(values))) for x, y in points]
    size = max((abs(v) for p in at for v in p), default=0.0)
    order = sorted(range(len(points)), key=lambda i: at[i])
    chains = []
    for direction in (order, order[::-1]):
        chain: list[int] = []
        for i in direction:
            while len(chain) >= 2 and _turn(at[chain[-2]], at[chain[-1]], at[i]) <= 1e-12 * size**2:
                chain.pop()
            chain.append(i)
        chains.append(chain[:-1])
    corners: list[int] = []
    for i in (*chains[0], *chains[1]) if size else ():
        if all(
            max(abs(at[i][0] - at[k][0]), abs(at[i][1] - at[k][1])) > 1e-9 * size for k in corners
        ):
            corners.append(i)
    return [points[i] for i in corners] if len(corners) > 1 else []


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
