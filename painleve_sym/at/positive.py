"""Functions that are positive where a contact has A > 0 for every direction of slip.

A(φ) = W_nn − μ w·e(φ) is positive for every φ exactly where W_nn > μ |w|. Since W_nn >= 0, this is
W_nn² − μ² |w|² > 0, which has no root. Before it come the bounds of the mechanism's domain, and the
pivots of its mass matrix: where one of them is not positive, W is not that of a mechanism.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from painleve_sym.at.delassus import Delassus, argument_symbols
from painleve_sym.at.spatial_numbers import SHARED, VANISHES
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.mechanics.mechanism import Mechanism

if TYPE_CHECKING:
    import casadi as ca


NO_PARADOX = "A > 0 for every direction of slip"
"""The last condition."""


class PositiveFunction(NamedTuple):
    """Conditions under which a contact has A > 0 for every direction of slip.

    Attributes
    ----------
    function : casadi.Function
        Of the quantities of a box in their order, one vector, to as many numbers as conditions.
    conditions : tuple of str
        Meaning of each number where it is positive; the last is `NO_PARADOX`.
    fixed : dict of str to float
        Values of what does not vary.
    """

    function: ca.Function
    conditions: tuple[str, ...]
    fixed: dict[str, float]


def positive_function(
    mechanism: Mechanism,
    over: Mapping[str, tuple[float, float]],
    values: Mapping[str, float],
) -> PositiveFunction:
    """Return W_nn² − μ² |w|² of the only contact, after all that a mechanism needs, on a box.

    Parameters
    ----------
    mechanism : Mechanism
        With one contact.
    over : mapping of str to (float, float)
        Coordinates, velocities and parameters that vary.
    values : mapping of str to float
        Values of others; absent ones have their default, states their start.

    Returns
    -------
    PositiveFunction

    Raises
    ------
    InputError
        Several contacts; unknown names; a parameter out of its range; ends in the wrong order.
    """
    import casadi as ca

    outline, where = mechanism.outline, f"certify {mechanism.name!r}"
    if len(outline.contacts) != 1:
        raise InputError(
            f"{where}: got {len(outline.contacts)} contacts, need one. Fix: name it (--contact)."
        )
    mechanism.require_one_coefficient(where, "give the coefficient as a parameter")
    known = outline.argument_names
    for name in (*over, *values):
        refuse_unknown("quantity", name, known, where)
        if name in over and (reason := outline.part_fault(name)):
            fix = "Fix: vary velocities or parameters, or give the body angles."
            raise InputError(f"{where}: {reason} {fix}")
    twice = set(over) & set(values)
    if twice:
        raise InputError(f"{where}: got {min(twice)} both varied and set. Fix: give it once.")
    start = dict(mechanism.start or {})
    whole = {name: float(start.get(name, 0.0)) for name in outline.state_names}
    whole |= {p.name: p.default for p in outline.parameters}
    whole |= values
    whole = outline.with_unit_quaternions(where, whole, {**start, **values})
    faults = []
    for name, (low, high) in over.items():
        if not low < high:
            faults.append(f"{name} from {low:g} to {high:g}, need ends that grow.")
    for parameter in outline.parameters:
        ends = over.get(parameter.name, (whole[parameter.name],))
        faults += [fault for end in ends if (fault := parameter.fault(end))]
    if faults:
        raise InputError(f"{where}: " + " ".join(faults))
    entries = _entries(mechanism)
    x = ca.SX.sym("x", len(over))
    at: dict[str, Any] = {**whole, **dict(zip(over, ca.vertsplit(x), strict=True))}
    fixed = {name: v for name, v in whole.items() if name not in over}
    numbers = entries.function(ca.vertcat(*(at[name] for name in entries.arguments)))
    bounds = [f"{b.margin} > 0 ({b.meaning})" for b in outline.domain]
    locks = ", which it loses in gimbal lock" if any(b.near for b in outline.domain) else ""
    bounds += [own_inertia(name) + locks for name in outline.velocity_names]
    count = len(bounds)
    rows = 1 + Delassus.of(mechanism).dynamics.n_tangents
    W = ca.reshape(numbers[count:], rows, rows).T
    mu = at[outline.contacts[0].friction]
    return PositiveFunction(positive_where(x, numbers[:count], W, mu), (*bounds, NO_PARADOX), fixed)


def _entries(mechanism: Mechanism) -> Quantities:
    """Return margins of the domain, `shares` of the mass matrix and W, row by row."""
    contacts = Delassus.of(mechanism).contact_quantities
    inside = [f"margin_{i}" for i in range(len(mechanism.outline.domain))]
    rows = range(1 + Delassus.of(mechanism).dynamics.n_tangents)
    mobility = [f"W_{r}_{c}" for r in rows for c in rows]
    names = [*inside, *mechanism.outline.velocity_names, *mobility]

    def derive() -> tuple[list[str], ca.Function]:
        import casadi as ca

        from painleve_sym.codegen.evaluate import expression_function

        system, symbols = mechanism.system, argument_symbols(mechanism)
        x = ca.SX.sym("x", len(symbols))
        of = dict(zip(contacts.names, ca.vertsplit(contacts.function(x)), strict=True))
        size = len(system.q_dot)
        mass = expression_function("mass", [*system.mass_matrix], symbols)(x)
        own = shares(ca.reshape(mass, size, size), [v.unit for v in system.velocities])
        parts = (*(of[n] for n in inside), own, *(of[n] for n in mobility))
        return names, ca.Function("positive", [x], [ca.cse(ca.densify(ca.vertcat(*parts)))])

    arguments = mechanism.outline.argument_names
    return quantities("positive", mechanism.definition, arguments, derive, compiles=False)


def own_inertia(velocity: str) -> str:
    """Return the meaning of a positive entry of `shares`."""
    return f"a regular mass matrix, with kinetic energy of {velocity} alone"


def shares(mass: ca.SX, units: Sequence[str]) -> ca.SX:
    """Return numbers that are positive where a mass matrix is regular, one for each velocity.

    The part of its inertia that those eliminated before it do not share, less `SHARED` of its
    inertia and `VANISHES` of those of the same unit.
    """
    import casadi as ca

    pivots, _, order = ca.ldl(ca.sparsify(mass))
    inertia = ca.diag(mass)
    others = [
        sum((inertia[j] for j, u in enumerate(units) if u == unit and j != k), ca.SX(0))
        for k, unit in enumerate(units)
    ]
    own = pivots[[order.index(k) for k in range(len(units))]]
    return own - SHARED * inertia - VANISHES * ca.vertcat(*others)


def positive_where(x: ca.SX, bounds: ca.SX, W: ca.SX, mu: Any) -> ca.Function:
    """Return the function of x to bounds and W_nn² − μ² |w|², for the mobility W of one contact.

    The normal is the first row of W.
    """
    import casadi as ca

    value = W[0, 0] ** 2 - mu**2 * ca.sumsqr(W[1:, 0])
    return ca.Function("positive", [x], [ca.cse(ca.densify(ca.vertcat(bounds, value)))])
