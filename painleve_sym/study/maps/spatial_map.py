"""The grids and curves of a map of a contact in space, for one direction of slip or over it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.codegen.evaluate import at_points
from painleve_sym.contacts.closing import unknowns
from painleve_sym.contacts.delassus import Delassus
from painleve_sym.contacts.local_mode import rounded_difference
from painleve_sym.contacts.risk import friction_threshold, least_over_normals
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.study.maps.axes import SLIP_DIRECTION, MapPlace
from painleve_sym.study.maps.case_codes import LEGEND, case_codes
from painleve_sym.study.maps.zero_curves import SharedCurve, common_zeros, zero_segments

if TYPE_CHECKING:
    import casadi as ca

Grids = Mapping[str, Any]


@dataclass(frozen=True)
class SpatialMap:
    """The map of the one contact of a mechanism in space; `slip` is the angle of slip, rad."""

    mechanism: Mechanism
    place: MapPlace
    slip: float

    def grids(
        self, grid: Mapping[Any, Any]
    ) -> tuple[dict[str, Any], NDArray[np.bool_], dict[str, float]]:
        """Return the fields of the map, whether the contact is open where inside, thresholds."""
        named = {symbol.name: value for symbol, value in grid.items()}
        shape = np.broadcast_shapes(*(np.shape(value) for value in named.values()))
        named = {name: np.broadcast_to(value, shape) for name, value in named.items()}
        angle = named.get(SLIP_DIRECTION, np.array(self.slip))
        at = Delassus.of(self.mechanism).at_each(named)
        W, b, mu, B = at.W, at.b, at.mu[0], at.b[0]
        inside = (at.margins > 0).all(axis=0) & np.isfinite(W).all(axis=(0, 1))
        inside &= np.isfinite(b).all(axis=0) & np.isfinite(mu)
        coupling = W[0, 1] * np.cos(angle) + W[0, 2] * np.sin(angle)
        A = rounded_difference(np.broadcast_to(W[0, 0], coupling.shape), mu * coupling)
        case = np.where(inside, case_codes((A,), B), LEGEND["outside"]).astype(np.int8)
        sticks, thresholds = np.zeros(inside.shape, np.bool_), {}
        if inside.any():
            matrix = np.moveaxis(W[:, :, inside], -1, 0)
            stretch, axes = np.linalg.eigh(matrix)
            regular = stretch[:, 0] > 1e-13 * stretch[:, 2]
            with np.errstate(all="ignore"):
                along = (np.swapaxes(axes, 1, 2) @ -b[:, inside].T[:, :, None])[:, :, 0] / stretch
                force = (axes @ along[:, :, None])[:, :, 0]
                held = np.hypot(force[:, 1], force[:, 2]) <= mu[inside] * force[:, 0]
                sticks[inside] = regular & (force[:, 0] > 0) & held
            least = {
                "mu_P": float(friction_threshold(W[:, :, inside]).min()),
                "least_over_normals": float(least_over_normals(W[:, :, inside]).min()),
            }
            thresholds = {name: v for name, v in least.items() if np.isfinite(v)}
        fields = {"A": A, "B": B, "A_stick": at.A_stick[0], "B_stick": at.B_stick[0]}
        grids: dict[str, Any] = {n: np.where(inside, v, np.nan) for n, v in fields.items()}
        grids |= {"case": case, "stick_feasible": sticks, "flow": None, "A_pull": None}
        is_open = (np.abs(at.gap) > at.gap_tolerance) | (np.abs(at.gap_rate) > at.rate_tolerance)
        return grids, is_open[0][inside], thresholds

    def zeros(self, grids: Grids) -> tuple[dict[str, Array], Array, list[SharedCurve]]:
        """Return the curves A = 0 and B = 0, where they cross, and where both vanish together."""
        x, y = self.place.values
        A, B = grids["A"], grids["B"]
        curves = {
            "A": zero_segments(lambda p, q: self._system(p, q)[0], x, y, A),
            "B": zero_segments(lambda p, q: self._system(p, q)[1], x, y, B),
        }
        crossings, shared = common_zeros(self._system, x, y, A, B)
        if len(crossings):
            margins = self._values(*crossings.T)[6:]
            crossings = crossings[(margins > 0).all(axis=0)]
        return curves, crossings, shared

    def _system(self, first: Array, second: Array) -> Array:
        """Return A, B and their derivatives along the axes, A's first."""
        return self._values(first, second)[:6]

    def _values(self, first: Array, second: Array) -> Array:
        """Return A, B, derivatives of both along the axes, margins of the domain."""
        named = {s.name: v for s, v in self.place.at(first, second).items()}
        named.setdefault(SLIP_DIRECTION, self.slip)
        columns = np.broadcast_arrays(*(np.asarray(named[n], float) for n in self._arguments))
        points = np.stack([column.reshape(-1) for column in columns], axis=1)
        rows = at_points(self._function, np.ascontiguousarray(points)).T
        return rows.reshape(len(rows), *columns[0].shape)

    @property
    def _arguments(self) -> tuple[str, ...]:
        return (*self.mechanism.outline.argument_names, SLIP_DIRECTION)

    @cached_property
    def _function(self) -> ca.Function:
        """A, B, their derivatives along the axes, and the margins, by all arguments."""
        import casadi as ca

        quantities = Delassus.of(self.mechanism).contact_quantities
        places = {name: k for k, name in enumerate(quantities.names)}
        arguments = self._arguments
        x = ca.SX.sym("x", len(arguments))
        values = quantities.function(x[:-1])
        friction = arguments.index(self.mechanism.outline.contacts[0].friction)
        w = [values[places[f"W_0_{k}"]] for k in range(3)]
        A = w[0] - x[friction] * (w[1] * ca.cos(x[-1]) + w[2] * ca.sin(x[-1]))
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
        margins = [values[k] for name, k in places.items() if name.startswith("margin_")]
        parts = [both, ca.vec(along.T), *margins]
        return ca.Function("map", [x], [ca.cse([ca.densify(ca.vertcat(*parts))])[0]])
