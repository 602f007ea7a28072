"""The forces of two closed contacts in a mode: slip or stick at each, the accelerations known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.contacts.contact_states import CONTACTS, FLIGHT
from painleve_sym.hybrid.guards import greatest, least
from painleve_sym.mechanics.system import determinant, sample_point, vanishes


@dataclass(frozen=True)
class ContactForces:
    """Forces (F_n, F_t of each contact, in this order) that hold the closed contacts in a mode.

    Every closed contact has g̈_N = 0; a sliding one F_t = −μ s F_n, a sticking one v̇_t = 0.

    Parameters
    ----------
    jacobian : sympy.Matrix, shape (2 n, number of coordinates)
        Rows n1, t1, n2, t2, ….
    W : sympy.Matrix, shape (2 n, 2 n)
        J M⁻¹ Jᵀ; 1/kg.
    b : sympy.Matrix, shape (2 n, 1)
        Accelerations without contact forces; m/s².
    friction : sequence of sympy.Symbol
    modes : sequence of {"flight", "slip_neg", "slip_pos", "stick"}
        What each contact does.
    """

    jacobian: sp.Matrix
    W: sp.Matrix
    b: sp.Matrix
    friction: Sequence[sp.Symbol]
    modes: Sequence[str]

    @cached_property
    def closed(self) -> tuple[int, ...]:
        """Indices of the closed contacts."""
        return tuple(i for i, mode in enumerate(self.modes) if mode != FLIGHT)

    @cached_property
    def _unknowns(self) -> tuple[tuple[int, ...], sp.Matrix]:
        """Rows whose acceleration is held at 0, and the force of each unknown, as columns."""
        rows: list[int] = []
        columns: list[sp.Matrix] = []
        unit = sp.eye(self.W.rows)
        for i in self.closed:
            n, t = 2 * i, 2 * i + 1
            rows.append(n)
            if self.modes[i] == "stick":
                rows.append(t)
                columns += [unit[:, n], unit[:, t]]
            else:
                columns.append(unit[:, n] - CONTACTS[self.modes[i]] * self.friction[i] * unit[:, t])
        return tuple(rows), sp.Matrix.hstack(*columns)

    @cached_property
    def _system(self) -> sp.Matrix:
        rows, columns = self._unknowns
        return self.W[list(rows), :] * columns

    @cached_property
    def redundant(self) -> int | None:
        """Index of an unknown that the others can replace everywhere; None where there is none.

        Two contacts of one planar body that both stick: three accelerations, four forces.
        """
        rows, _ = self._unknowns
        if len(rows) < self.W.rows:
            return None
        free = [k for k in reversed(rows) if k % 2 and _independent(self.jacobian, k)]
        whole = _independent(self.jacobian)
        return None if whole else rows.index(free[0] if free else rows[-1])

    @cached_property
    def _kept(self) -> tuple[int, ...]:
        return tuple(k for k in range(self._system.rows) if k != self.redundant)

    @cached_property
    def determinant(self) -> sp.Expr:
        """Determinant of the system of the mode, over the product of the diagonal of W."""
        rows, kept = self._unknowns[0], self._kept
        scale = sp.prod([self.W[rows[k], rows[k]] for k in kept])
        return determinant(self._system[list(kept), list(kept)]) / scale

    def _solve(self, right: sp.Matrix) -> sp.Matrix:
        """Return all forces, shape (2 n, 1), for the accelerations `right` of the held rows."""
        rows, columns = self._unknowns
        kept = list(self._kept)
        matrix = self._system[kept, kept]
        whole = determinant(matrix)
        values = sp.zeros(len(rows), 1)
        for i, k in enumerate(kept):
            replaced = matrix.copy()
            replaced[:, i] = right[kept, :]
            values[k] = determinant(replaced) / whole
        return columns * values

    @cached_property
    def particular(self) -> sp.Matrix:
        """Forces with the redundant one 0, shape (2 n, 1)."""
        if not self.closed:
            return sp.zeros(self.W.rows, 1)
        rows, _ = self._unknowns
        return self._solve(-self.b[list(rows), :])

    @cached_property
    def null(self) -> sp.Matrix | None:
        """Forces that move nothing, shape (2 n, 1); None where there are none."""
        k = self.redundant
        if k is None:
            return None
        _, columns = self._unknowns
        return self._solve(-self._system[:, k]) + columns[:, k]

    @cached_property
    def forces(self) -> sp.Matrix:
        """The forces, shape (2 n, 1); where they are not determined, those of least norm."""
        if not self.closed or self.null is None:
            return self.particular
        share = self.particular.dot(self.null) / self.null.dot(self.null)
        return self.particular - share * self.null

    def stick_margins(self, i: int) -> tuple[sp.Expr, sp.Expr]:
        """Return μ F_n + F_t and μ F_n − F_t of contact i; not for redundant forces."""
        return _margins(self.particular, self.friction, i)

    @cached_property
    def redundant_margin(self) -> sp.Expr:
        """Positive where some forces of the line `particular` + s `null` lie in both cones.

        Each edge of a cone bounds s from one side, so every two opposed edges must leave room.
        """
        assert self.null is not None
        at = [m for i in self.closed for m in _margins(self.particular, self.friction, i)]
        slope = [m for i in self.closed for m in _margins(self.null, self.friction, i)]
        # Unevaluated: comparing such formulas takes SymPy minutes.
        size = [sp.Abs(x, evaluate=False) for x in slope]
        pairs = [
            greatest(at[i] * size[j] + at[j] * size[i], slope[i] * slope[j])
            for i in range(len(at))
            for j in range(i)
        ]
        return least(*pairs)


def _independent(jacobian: sp.Matrix, left_out: int | None = None) -> bool:
    """Return whether the rows of J are independent, at least at one of two places."""
    rows = jacobian[[i for i in range(jacobian.rows) if i != left_out], :]
    places = [rows.subs(sample_point(rows, seed)).evalf(30) for seed in (1, 2)]
    return not all(vanishes(determinant(place * place.T)) for place in places)


def _margins(forces: sp.Matrix, friction: Sequence[sp.Symbol], i: int) -> tuple[sp.Expr, sp.Expr]:
    normal, tangential = friction[i] * forces[2 * i], forces[2 * i + 1]
    return normal + tangential, normal - tangential
