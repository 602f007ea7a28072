"""The function that is positive where a contact has A > 0 for every direction of slip.

A(φ) = W_nn − μ w·e(φ) is positive for every φ exactly where W_nn > μ |w|. Since W_nn >= 0, this is
W_nn² − μ² |w|² > 0, which has no root.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from painleve_sym.contacts.delassus import Delassus
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.mechanism import Mechanism

if TYPE_CHECKING:
    import casadi as ca


def positive_function(
    mechanism: Mechanism,
    over: Mapping[str, tuple[float, float]],
    values: Mapping[str, float],
) -> tuple[ca.Function, dict[str, float]]:
    """Return W_nn² − μ² |w|² of the only contact as a function of the quantities of a box.

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
    casadi.Function
    dict of str to float
        The values of all states and parameters that do not vary.

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
    known = outline.argument_names
    for name in (*over, *values):
        if name not in known:
            raise InputError(f"{where}: {unknown_name('quantity', name, known)}")
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
    entries = Delassus.of(mechanism).contact_quantities
    x = ca.SX.sym("x", len(over))
    at: dict[str, Any] = {**whole, **dict(zip(over, ca.vertsplit(x), strict=True))}
    of = dict(
        zip(
            entries.names,
            ca.vertsplit(entries.function(ca.vertcat(*(at[n] for n in entries.arguments)))),
            strict=True,
        )
    )
    rows = range(1 + Delassus.of(mechanism).dynamics.n_tangents)
    W = ca.vertcat(*(ca.horzcat(*(of[f"W_{r}_{c}"] for c in rows)) for r in rows))
    fixed = {name: v for name, v in whole.items() if name not in over}
    return positive_where(x, W, at[outline.contacts[0].friction]), fixed


def positive_where(x: ca.SX, W: ca.SX, mu: Any) -> ca.Function:
    """Return the function W_nn² − μ² |w|² of x, for the mobility W of one contact, normal first."""
    import casadi as ca

    value = W[0, 0] ** 2 - mu**2 * ca.sumsqr(W[1:, 0])
    return ca.Function("positive", [x], [ca.cse(ca.densify(value))])
