"""The functions of a `Dynamics` for a mechanism in space, by linear algebra.

SymPy derives the mass matrix, the forces and the Jacobians; CasADi factorizes the mass matrix
inside the generated function. Its inverse in closed form may be long for bodies in space.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from painleve_sym.at.sticking import sticking_formulas
from painleve_sym.codegen.evaluate import expression_function
from painleve_sym.contact_rows import ContactRows
from painleve_sym.mechanics.closed_within import closed_within, length_formula

if TYPE_CHECKING:
    import casadi as ca

    from painleve_sym.mechanics.contact import Contact
    from painleve_sym.mechanics.mechanism import Mechanism


SHARED = 1e-12
"""Part of a velocity's inertia that it does not share, below which the mass matrix is singular."""
_LONG = 500
"""Operations of a velocity of a contact, above which CasADi differentiates it instead of SymPy."""
VANISHES = 1e-20
"""Inertia by the largest one of its unit, below which it is none."""


def contact_function(mechanism: Mechanism, symbols: tuple[Any, ...]) -> ca.Function:
    """Return the function of all `ContactNumbers` but mu."""
    import casadi as ca
    import sympy as sp

    contacts, n = mechanism.contacts, len(mechanism.contacts)
    at = ContactRows(n, 2)
    x = ca.SX.sym("x", len(symbols))
    parts = _Parts(mechanism, symbols, x)
    W, b = ca.mtimes(parts.J, parts.D), ca.mtimes(parts.J, parts.free) + parts.biases
    W = (W + W.T) / 2
    given = [sp.Symbol(f"given {k}", real=True) for k in range(2)]
    near, slow, A, B = list[ca.SX](), list[ca.SX](), list[ca.SX](), list[ca.SX]()
    for i in range(n):
        own = at.of(i)
        block, accelerations = W[own, own], b[own]
        length = length_formula(mechanism, i, given[0])
        _, *tolerances = closed_within(length, mechanism.system.kinetic_energy, *given)
        function = expression_function("closed", tolerances, (*symbols, *given))
        within = function(ca.vertcat(x, block[0, 0], accelerations[0]))
        near.append(within[0])
        slow.append(within[1])
        A_stick, B_stick = sticking_formulas(block, accelerations)
        A.append(A_stick)
        B.append(B_stick)
    states = [c.gap for c in contacts] + [c.gap_rate for c in contacts]
    states += [v for c in contacts for v in c.slip_velocities]
    motion = expression_function("motion", states, symbols)(x)
    margins = [bound.margin for bound in mechanism.domain]
    inside = expression_function("domain", margins, symbols)(x) if margins else ca.SX(0, 1)
    inside = ca.vertcat(inside, parts.regular)
    entries = [motion, *A, *B, *near, *slow, ca.vec(ca.densify(W)), b, inside]
    return ca.Function("contacts", [x], [ca.cse([ca.densify(ca.vertcat(*entries))])[0]])


def motion_function(mechanism: Mechanism, symbols: tuple[Any, ...]) -> ca.Function:
    """Return the function of all `MotionNumbers`."""
    import casadi as ca

    x = ca.SX.sym("x", len(symbols))
    parts = _Parts(mechanism, symbols, x)
    momenta = list(mechanism.system.still_momenta)
    at_rest = dict.fromkeys(mechanism.system.q_dot, 0)
    speeds = [v for c in mechanism.contacts for v in (c.gap_rate, *c.slip_velocities)]
    still = [v.subs(at_rest) for v in speeds]
    rest = expression_function(
        "rest", [*momenta, *still, mechanism.system.kinetic_energy], symbols
    )(x)
    count = len(momenta)
    # See `ContactCoefficients.drive_speeds`.
    drives = ca.mtimes(rest[:count].T, parts.D).T - rest[count:-1]
    entries = [ca.vec(parts.J.T), ca.vec(parts.D.T), parts.free, drives, rest[-1]]
    return ca.Function("motion", [x], [ca.cse([ca.densify(ca.vertcat(*entries))])[0]])


class _Parts:
    """Jacobian J, D = M⁻¹ Jᵀ, the free accelerations M⁻¹ h and the biases of the contacts at x."""

    def __init__(self, mechanism: Mechanism, symbols: tuple[Any, ...], x: ca.SX) -> None:
        import casadi as ca

        system = mechanism.system
        size, rows = len(system.q_dot), 3 * len(mechanism.contacts)
        jacobian = [e for c in mechanism.contacts for J in (c.J_N, c.J_T) for e in J]
        entries = [*system.mass_matrix, *system.bias_force, *jacobian]
        values = expression_function("parts", entries, symbols)(x)
        mass = ca.reshape(values[: size * size], size, size)
        force = values[size * size : size * size + size]
        ldl, self.units = ca.ldl(mass), [v.unit for v in system.velocities]
        self.mass, self.pivots = mass, ldl[0]
        self.J = ca.reshape(values[size * (size + 1) :], size, rows).T
        self.biases = ca.vertcat(*(_biases(mechanism, c, symbols, x) for c in mechanism.contacts))
        solved = ca.ldl_solve(ca.horzcat(self.J.T, force), *ldl)
        self.D, self.free = solved[:, :-1], solved[:, -1]

    @property
    def regular(self) -> ca.SX:
        """Positive where the mass matrix is regular; free of units.

        Of each velocity: the part of its inertia that those before it do not share, and its inertia
        by the largest one of its unit.
        """
        import casadi as ca

        inertia, parts = ca.diag(self.mass), list[ca.SX]()
        for unit in dict.fromkeys(self.units):
            own = [k for k, u in enumerate(self.units) if u == unit]
            largest = ca.mmax(inertia[own])
            parts += [inertia[k] / largest - VANISHES for k in own]
        parts.append(self.pivots / inertia - SHARED)
        return ca.mmin(ca.vertcat(*parts))


def _biases(mechanism: Mechanism, contact: Contact, symbols: tuple[Any, ...], x: ca.SX) -> ca.SX:
    """Return the parts of the accelerations of a contact that are not J u̇, at x."""
    import casadi as ca
    import sympy as sp

    speeds = [contact.gap_rate, *contact.slip_velocities]
    if sum(map(sp.count_ops, speeds)) <= _LONG:
        return expression_function("biases", [*contact.biases], symbols)(x)
    rates = {s: v for s, v in mechanism.system.rates.items() if s in symbols}
    function = expression_function("speeds", [*speeds, *rates.values()], symbols, list(rates))
    values = function(x)
    count, n = len(speeds), len(rates)
    slopes = ca.reshape(values[count + n :][: count * n], n, count).T
    return ca.mtimes(slopes, values[count : count + n])
