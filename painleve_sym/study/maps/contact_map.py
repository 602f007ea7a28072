"""The grids and curves of a map of one contact, for one direction of slip or, in space, over it."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.at.closing import unknowns
from painleve_sym.at.delassus import Delassus, argument_symbols
from painleve_sym.codegen.evaluate import at_arrays
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.errors import InputError
from painleve_sym.mechanics.declarations import TIME_NAME
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.problem.case_codes import LEGEND, can_stick, case_codes
from painleve_sym.problem.risk import (
    LEAST,
    friction_threshold,
    least_over_normals,
    slip_slope,
)
from painleve_sym.study.maps.axes import SLIP_DIRECTION, MapPlace
from painleve_sym.study.maps.zero_curves import SharedCurve, common_zeros, zero_segments

if TYPE_CHECKING:
    import casadi as ca

ROD_FAMILY = ("rod", "rod-inertia")
SIDE_OF_SLIP = "direction of slip times sign of the normal force"
CURVES = ("A", "B", "A_pull")
"""Of a contact that can open, the first two."""

Grids = dict[str, Any]


@dataclass(frozen=True)
class ContactMap:
    """The map of the only contact of a mechanism.

    `slip` is the sign of the slip velocity in the plane, its angle from t1 towards t2 in space.
    """

    mechanism: Mechanism
    place: MapPlace
    slip: float

    @cached_property
    def _numbers(self) -> Delassus:
        return Delassus.of(self.mechanism)

    @property
    def _tangents(self) -> int:
        return self.mechanism.outline.rows.n_tangents

    @property
    def _sides(self) -> tuple[int, ...]:
        return self.mechanism.outline.contacts[0].sides

    # ---- grids ----

    def grids(
        self, grid: Mapping[str, Any]
    ) -> tuple[Grids, NDArray[np.bool_], dict[str, float], list[float]]:
        """Return the fields of the map, whether the contact is open where inside, thresholds.

        Last come the margins of points at which W and b lose digits (`DomainBound.near`).
        The thresholds are the least on the grid; `closed_thresholds` has the others.
        """
        grid = dict(zip(grid, np.broadcast_arrays(*grid.values()), strict=True))
        at = self._numbers.at_each(grid)
        W, b, mu, B = at.W, at.b, at.mu[0], at.b[0]
        inside = (at.margins > 0).all(axis=0) & np.isfinite(W).all(axis=(0, 1))
        inside &= np.isfinite(b).all(axis=0) & np.isfinite(mu)
        inside &= np.isfinite([at.A_stick[0], at.B_stick[0]]).all(axis=0)
        along = self._along(np.asarray(grid.get(SLIP_DIRECTION, self.slip)), np.cos, np.sin)
        with np.errstate(all="ignore"):
            A, *pull = (slip_slope(W, mu, along, side) for side in self._sides)
            rest = self._numbers.friction_at_rest(grid)
            held = mu if rest is None else rest[0]
            sticks = can_stick(W, at.b, held, (at.A_stick[0], at.B_stick[0]), self._sides)
        case = np.where(inside, case_codes((A, *pull), B), LEGEND["outside"]).astype(np.int8)
        fields = {"A": A, "B": B, "A_stick": at.A_stick[0], "B_stick": at.B_stick[0]}
        grids: Grids = {n: np.where(inside, v, np.nan) for n, v in fields.items()}
        grids |= {"case": case, "stick_feasible": inside & sticks}
        grids["A_pull"] = np.where(inside, pull[0], np.nan) if pull else None
        grids["flow"] = self._flow(grid, B, case)
        is_open = (np.abs(at.gap) > at.gap_tolerance) | (np.abs(at.gap_rate) > at.rate_tolerance)
        near = [
            margin[inside & (margin < bound.near)]
            for bound, margin in zip(self.mechanism.outline.domain, at.margins, strict=False)
        ]
        lost = [value for values in near for value in values.tolist()]
        thresholds = _least_thresholds(W[..., inside])
        return grids, is_open[0][inside], thresholds, lost

    def _along(self, slip: Any, cos: Any, sin: Any) -> tuple[Any, ...]:
        """Return the unit vector of the slip along the tangents: its sign, or of its angle."""
        return (slip,) if self._tangents == 1 else (cos(slip), sin(slip))

    def _flow(self, grid: Mapping[str, Any], B: Array, case: NDArray[np.int8]) -> Array | None:
        """Return the rates of both axes in slip; None in space, and where one is a parameter."""
        outline, over = self.mechanism.outline, self.place.over
        if self._tangents > 1 or not set(over) <= set(outline.state_names):
            return None
        slips = case == LEGEND["slip"]
        # Where there is one solution, F_n has the sign of −B, and friction that of the slip for it.
        sides = np.where(B <= 0, 1, -1) if len(self._sides) > 1 else np.ones(B.shape)
        values = {name: v[slips] for name, v in {**grid, SIDE_OF_SLIP: self.slip * sides}.items()}
        rates = _slip_accelerations(self._numbers).at(values)
        rates |= {v.row: values[v.name] for v in outline.velocities}
        rates[TIME_NAME] = np.ones(int(slips.sum()))
        flow = np.full((2, *B.shape), np.nan)
        flow[:, slips] = [rates[name] for name in over]
        return flow

    def closed_thresholds(self) -> dict[str, float]:
        """Return μ_P, and μ_C of the rods, where they have a closed form, as numbers.

        Both are of a contact in the plane whose friction threshold depends on one coordinate.
        """
        if self._tangents > 1:
            return {}
        mechanism, place = self.mechanism, self.place
        over = [c.name for c in mechanism.outline.coordinates if c.name in place.over]
        # A bilateral contact has both signs of A in either slip direction.
        slip = 0 if len(self._sides) > 1 else int(self.slip)
        symbolic = quantities(
            f"critical friction in slip {slip} over {over}",
            mechanism.definition,
            mechanism.outline.argument_names,
            lambda: (
                {"mu_P": _least_critical_friction(mechanism, over, slip)},
                argument_symbols(mechanism),
            ),
            compiles=False,
        )
        # It is nan where it depends on an axis.
        values = {**place.state, **place.parameters, **dict.fromkeys(place.over, math.nan)}
        least = symbolic(values)["mu_P"]
        if not (math.isfinite(least) and least > 0):
            return {}
        thresholds = {"mu_P": least}
        if mechanism.name in ROD_FAMILY:
            thresholds["mu_C"] = 2 / math.sqrt(3) * least
        return thresholds

    # ---- curves ----

    def zeros(self, grids: Grids) -> tuple[dict[str, Array], Array, list[SharedCurve]]:
        """Return the curves A = 0 and B = 0, where they cross, and where both vanish together."""
        x, y = self.place.values
        curves, crossings, shared = dict[str, Array](), list[list[float]](), list[SharedCurve]()
        for side, name in zip(self._sides, ("A", "A_pull"), strict=False):
            system = functools.partial(self._system, side)
            for row, curve in enumerate((name, "B")):
                if curve not in curves:
                    one = functools.partial(self._row, side, row)
                    curves[curve] = zero_segments(one, x, y, grids[curve])
            points, lines = common_zeros(system, x, y, grids[name], grids["B"])
            if len(points):
                margins = self._values(side, points[:, 0], points[:, 1])[6:]
                points = points[(margins > 0).all(axis=0)]
            crossings += points.tolist()
            shared += [line for line in lines if line not in shared]
        return curves, np.array(sorted(crossings)).reshape(-1, 2), shared

    def _row(self, side: int, row: int, first: Array, second: Array) -> Array:
        """Return A or B."""
        return np.asarray(self._evaluated(self._functions[side][0], first, second)[row])

    def _system(self, side: int, first: Array, second: Array) -> Array:
        """Return A, B and their derivatives along the axes, A's first."""
        return self._values(side, first, second)[:6]

    def _values(self, side: int, first: Array, second: Array) -> Array:
        """Return A, B, derivatives of both along the axes, margins of the domain.

        A is that with normal forces of the sign `side`.
        """
        return self._evaluated(self._functions[side][1], first, second)

    def _evaluated(self, function: ca.Function, first: Array, second: Array) -> Array:
        """Return a function of all arguments at points of the map."""
        values = self.place.at(first, second)
        values.setdefault(SLIP_DIRECTION, self.slip)
        columns = np.broadcast_arrays(*(np.asarray(values[n], float) for n in self._arguments))
        return at_arrays(function, columns)

    @property
    def _arguments(self) -> tuple[str, ...]:
        return (*self.mechanism.outline.argument_names, SLIP_DIRECTION)

    @cached_property
    def _functions(self) -> dict[int, tuple[ca.Function, ca.Function]]:
        """A and B by all arguments; both with their derivatives along the axes, and the margins."""
        import casadi as ca

        quantities = self._numbers.contact_quantities
        places = {name: k for k, name in enumerate(quantities.names)}
        arguments = self._arguments
        x = ca.SX.sym("x", len(arguments))
        values = quantities.function(x[:-1])
        (friction,) = self._numbers.friction_of(dict(zip(arguments, ca.vertsplit(x), strict=True)))
        direction = self._along(x[-1], ca.cos, ca.sin)
        W_nt = [values[places[f"W_0_{k}"]] for k in range(1, 1 + len(direction))]
        coupling = sum((w * d for w, d in zip(W_nt, direction, strict=True)), ca.SX(0))
        margins = [values[k] for name, k in places.items() if name.startswith("margin_")]
        functions: dict[int, Any] = {}
        for side in self._sides:
            A = values[places["W_0_0"]] - side * friction * coupling
            both = ca.vertcat(A, values[places["b_0"]])
            slopes = ca.jacobian(both, x)
            along = slopes[:, [arguments.index(name) for name in self.place.over]]
            for unknown in unknowns(self.mechanism, self.place.close) if self.place.close else ():
                # Along the axes what is solved for changes as its equation says.
                zero = values[places["gap_rate_0" if unknown.is_velocity else "gap_0"]]
                rates = ca.jacobian(zero, x)
                column = arguments.index(unknown.name)
                change = -rates[[arguments.index(n) for n in self.place.over]] / rates[column]
                along += ca.mtimes(slopes[:, column], change)
            parts = ca.densify(ca.vertcat(both, ca.vec(along.T), *margins))
            pair = ca.densify(both), parts
            functions[side] = tuple(ca.Function("map", [x], ca.cse([part])) for part in pair)
        return functions


def _slip_accelerations(numbers: Delassus) -> Quantities:
    """Return the accelerations of a mechanism whose only contact, in the plane, slips.

    Functions of states and parameters and of s sign(F_n), s the direction of slip: F_n = −B/A.
    """
    outline = numbers.dynamics.outline
    names = outline.velocity_names

    def derive() -> tuple[list[str], ca.Function]:
        import casadi as ca

        whole = numbers.whole_quantities
        x = ca.SX.sym("x", len(whole.arguments) + 1)
        of = dict(zip(whole.names, ca.vertsplit(whole.function(x[:-1])), strict=True))
        (mu,) = numbers.friction_of(dict(zip(whole.arguments, ca.vertsplit(x[:-1]), strict=True)))
        friction = x[-1] * mu
        force = -of["b_0"] / (of["W_0_0"] - friction * of["W_0_1"])
        rates = [
            of[f"free_{i}"] + (of[f"D_{i}_0"] - friction * of[f"D_{i}_1"]) * force
            for i in range(len(names))
        ]
        return list(names), ca.Function("slip", [x], ca.cse([ca.densify(ca.vertcat(*rates))]))

    arguments = (*outline.argument_names, SIDE_OF_SLIP)
    return quantities("slip", numbers.dynamics.definition, arguments, derive)


def _least_critical_friction(mechanism: Mechanism, over: list[str], slip: int) -> Any:
    """Return μ_P over the only one of these, or of all, coordinates in it; 0 for no closed form."""
    import sympy as sp

    from painleve_sym.mechanics.paradox.critical_friction import critical_friction

    c = mechanism.coefficients
    inner = (c.W_nn.free_symbols | c.W_nt.free_symbols) & set(mechanism.system.q)
    names = [s.name for s in inner if s.name in over] or [s.name for s in inner]
    if len(names) != 1 or c.W_nt == 0:
        return sp.Integer(0)
    try:
        value = critical_friction(c, slip).minimum(names[0]).value
    except (InputError, TypeError):
        return sp.Integer(0)  # no closed form, or values that cannot be compared
    known = value.is_finite is not False and value.free_symbols <= set(argument_symbols(mechanism))
    return value if known else sp.Integer(0)


def _least_thresholds(W: Array) -> dict[str, float]:
    """Return the least thresholds of friction of mobilities, shape (d, d, n); none without end.

    In the plane μ_P has a closed form.
    """
    if len(W) > 2:
        least = {"mu_P": friction_threshold(W), "least_over_normals": least_over_normals(W)}
    else:
        least = {"least_over_normals": least_over_normals(_most_uneven(W) if W.size else W)}
    values = {name: float(v.min(initial=np.inf)) for name, v in least.items()}
    return {name: v if v > LEAST else 0.0 for name, v in values.items() if np.isfinite(v)}


def _most_uneven(W: Array) -> Array:
    """Return the planar mobility with the least ratio of eigenvalues, shape (2, 2, 1).

    det W/(tr W)² increases with that ratio, and takes no search for eigenvalues at each point.
    """
    trace = W[0, 0] + W[1, 1]
    with np.errstate(all="ignore"):
        even = W[0, 0] / trace * (W[1, 1] / trace) - (W[0, 1] / trace) ** 2
    return W[..., [np.argmin(np.where(trace > 0, even, np.inf))]]
