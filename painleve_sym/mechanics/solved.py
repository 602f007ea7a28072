"""Contact coefficients by a solution of M q̈ = h + Jᵀ F, step by step.

Closed forms of M⁻¹ grow without bound with the number of velocities, the steps of an elimination
with its cube.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import sympy as sp

from painleve_sym.mechanics.bodies import expr, rate
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.system import LagrangianSystem, sample_values

if TYPE_CHECKING:
    from painleve_sym.mechanics.mechanism import Mechanism

MOST_VELOCITIES = 3
"""Velocities up to which closed forms are short, and of use to readers."""

Steps = dict[sp.Symbol, sp.Expr]
"""Abbreviations, each of which may use those before it."""


@dataclass(frozen=True)
class SolvedCoefficients(ContactCoefficients):
    """Coefficients of one of several contacts as symbols that `steps` define.

    `entries` are W and b of its rows n and t, and the columns M⁻¹ h, M⁻¹ J_Nᵀ and M⁻¹ J_Tᵀ.
    """

    entries: Mapping[str, sp.Expr] = field(hash=False)
    columns: tuple[sp.Matrix, sp.Matrix, sp.Matrix] = field(hash=False)

    @property
    def W_nn(self) -> sp.Expr:
        """J_N M⁻¹ J_Nᵀ; 1/kg."""
        return self.entries["W_nn"]

    @property
    def W_nt(self) -> sp.Expr:
        """J_N M⁻¹ J_Tᵀ; 1/kg."""
        return self.entries["W_nt"]

    @property
    def W_tt(self) -> sp.Expr:
        """J_T M⁻¹ J_Tᵀ; 1/kg."""
        return self.entries["W_tt"]

    @property
    def b_n(self) -> sp.Expr:
        """Normal acceleration without contact forces; m/s²."""
        return self.entries["b_n"]

    @property
    def b_t(self) -> sp.Expr:
        """Tangential acceleration without contact forces; m/s²."""
        return self.entries["b_t"]

    @property
    def force_directions(self) -> tuple[sp.Matrix, sp.Matrix]:
        """M⁻¹J_Nᵀ and M⁻¹J_Tᵀ."""
        return self.columns[1:]

    @property
    def free_acceleration(self) -> sp.Matrix:
        """M⁻¹ h."""
        return self.columns[0]


class SolvedMotion:
    """Accelerations of a mechanism as symbols with the steps that lead to them.

    W, b, the free accelerations a and the directions D = M⁻¹ Jᵀ, rows n1, t1, n2, t2, …, have the
    names of the terms of several contacts.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        system, J = mechanism.system, _jacobian(mechanism)
        right = [bias_force(system), *(J[i, :].T for i in range(J.rows))]
        self.steps, columns = _solution(system.mass_matrix, right)
        names = ["a_{}_1", *(f"D_{{}}_{i + 1}" for i in range(J.rows))]
        self._columns = [self._named(name, c) for name, c in zip(names, columns, strict=True)]
        self._W = sp.zeros(J.rows, J.rows)
        for i, j in itertools.combinations_with_replacement(range(J.rows), 2):
            product = (J[i, :] * self._columns[1 + j])[0]
            self._W[i, j] = self._W[j, i] = self._step(f"W_{i + 1}_{j + 1}", product)
        biases = sp.Matrix.vstack(*(c.biases for c in mechanism.contacts))
        free = J * self._columns[0] + biases
        self._b = [self._step(f"b_{i + 1}_1", b) for i, b in enumerate(free)]

    def _step(self, name: str, value: sp.Expr) -> sp.Symbol:
        symbol = sp.Symbol(name, real=True)
        self.steps[symbol] = value
        return symbol

    def _named(self, name: str, values: Iterable[sp.Expr]) -> sp.Matrix:
        return sp.Matrix([self._step(name.format(i), v) for i, v in enumerate(values, 1)])

    @cached_property
    def coefficients(self) -> tuple[SolvedCoefficients, ...]:
        """Coefficients of every contact, each as if the others were open."""
        return tuple(self._of_contact(i) for i in range(len(self._mechanism.contacts)))

    def _of_contact(self, i: int) -> SolvedCoefficients:
        n, t, W, b = 2 * i, 2 * i + 1, self._W, self._b
        entries = {"W_nn": W[n, n], "W_nt": W[n, t], "W_tt": W[t, t], "b_n": b[n], "b_t": b[t]}
        columns = self._columns[0], self._columns[1 + n], self._columns[1 + t]
        return SolvedCoefficients(self._mechanism.contacts[i], entries, columns)


def solved_motion(mechanism: Mechanism) -> SolvedMotion | None:
    """Return the accelerations of a mechanism where they are solved for, derived once."""
    return mechanism._solved_motion


def is_solved(mechanism: Mechanism) -> bool:
    """Whether accelerations are solved for: above `MOST_VELOCITIES`, where W is regular.

    Closed forms show where a contact cannot slide, or its gap and slip velocity are tied.
    """
    system = mechanism.system
    if len(system.velocities) <= MOST_VELOCITIES or system.quaternions:
        return False
    return all(_rank(c.J) == c.J.rows for c in mechanism.contacts)


def _rank(J: sp.Matrix) -> int:
    return int(J.xreplace(sample_values(J.free_symbols, 1)).evalf(30).rank(iszerofunc=_is_small))


def _is_small(value: sp.Expr) -> bool:
    return bool(abs(value) <= sp.Float("1e-20"))


def _jacobian(mechanism: Mechanism) -> sp.Matrix:
    return sp.Matrix.vstack(*(c.J for c in mechanism.contacts))


def bias_force(system: LagrangianSystem) -> sp.Matrix:
    """Return h, by the bodies where the kinetic energy is theirs alone; shape (n, 1).

    By d'Alembert's principle h = Q − ∂V/∂q − Σ (m Jᵀ J̇ q̇ + I (∂φ/∂q)ᵀ φ̈₀) with the Jacobian J of
    each mass centre, its acceleration J̇ q̇ and that of the angle, φ̈₀, for q̈ = 0: as short as
    bodies have it, without a search for short forms.
    """
    of_bodies = sum((body.kinetic_energy(system.rates) for body in system.bodies), sp.Integer(0))
    if any(body.modes for body in system.bodies) or of_bodies != system.kinetic_energy:
        return system.bias_force
    moved = []
    for body in system.bodies:
        moved += [(expr(body.mass), expr(place)) for place in body.centre]
        moved.append((expr(body.inertia), expr(body.angle)))
    inertial = [(m, p, rate(rate(p, system.rates), system.rates)) for m, p in moved if m != 0]
    rows = []
    for velocity, q in zip(system.velocities, system.q, strict=True):
        row = system.generalized_forces.get(velocity.row, sp.Integer(0))
        row -= sp.diff(system.potential_energy, q)
        rows.append(row - sp.Add(*(m * sp.diff(p, q) * a for m, p, a in inertial)))
    return sp.Matrix(rows)


def _solution(M: sp.Matrix, right: Sequence[sp.Matrix]) -> tuple[Steps, list[list[sp.Expr]]]:
    """Return the steps of M = L D Lᵀ and of M x = r for each column r, and the columns x.

    Rows are eliminated in an order that leaves few entries of L: bodies with modes, and branches
    of a tree, do not meet.
    """
    steps: Steps = {}

    def step(name: str, value: sp.Expr) -> sp.Expr:
        if value == 0 or value.is_Symbol or value.is_Number:
            return value
        symbol = sp.Symbol(f"solve_{name}_{len(steps)}", real=True)
        steps[symbol] = value
        return symbol

    n, order = M.rows, _order(M)
    rows = [[step("M", M[i, j]) for j in order] for i in order]
    L, d = [[sp.Integer(0)] * n for _ in range(n)], list[sp.Expr]()
    for j in range(n):
        weighted = [L[j][k] * d[k] for k in range(j)]
        d.append(step("d", rows[j][j] - _dot(L[j][:j], weighted)))
        for i in range(j + 1, n):
            L[i][j] = step("L", (rows[i][j] - _dot(L[i][:j], weighted)) / d[j])
    columns = []
    for r in right:
        x = [r[i] for i in order]
        for i in range(n):
            x[i] = step("y", x[i] - _dot(L[i][:i], x[:i]))
        for i in reversed(range(n)):
            below = [L[k][i] for k in range(i + 1, n)]
            x[i] = step("x", x[i] / d[i] - _dot(below, x[i + 1 :]))
        columns.append([x[order.index(i)] for i in range(n)])
    return steps, columns


def _dot(a: Sequence[sp.Expr], b: Sequence[sp.Expr]) -> sp.Expr:
    return sp.Add(*(x * y for x, y in zip(a, b, strict=True)))


def _order(M: sp.Matrix) -> list[int]:
    """Return the rows by least degree: each the one with the fewest others that it still meets."""
    meets = {i: {j for j in range(M.rows) if j != i and M[i, j] != 0} for i in range(M.rows)}
    order = []
    while meets:
        i = min(meets, key=lambda k: (len(meets[k]), k))
        others = meets.pop(i)
        for j in others:
            meets[j] |= others
            meets[j] -= {i, j}
        order.append(i)
    return order
