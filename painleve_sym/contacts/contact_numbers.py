"""The numbers of a mechanism at a state: contact motion, Delassus matrix, scales, domain."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations, product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.contact_rows import ContactRows
from painleve_sym.mechanics.mechanism import Mechanism

if TYPE_CHECKING:
    from sympy import Expr

    from painleve_sym.mechanics.coefficients import ContactCoefficients

CONTACT_TOLERANCE = 1e-12
"""Part of the mechanism's length and speed below which gap and its rate are 0: round-off."""


_MOTION = ("gap", "gap_rate", "slip_velocity")
_OF_CONTACT = (*_MOTION, "A_stick", "B_stick", "gap_tolerance", "rate_tolerance")


class ContactNumbers(NamedTuple):
    """Numbers of all n contacts of a mechanism at one state.

    Attributes
    ----------
    gap, gap_rate, slip_velocity : ndarray, shape (n,)
        m, m/s, m/s.
    W : ndarray, shape (2 n, 2 n)
        Mobility with rows n1, t1, n2, t2, ...; 1/kg.
    b : ndarray, shape (2 n,)
        Accelerations without contact forces; m/s².
    mu : ndarray, shape (n,)
        Friction coefficients.
    A_stick, B_stick : ndarray, shape (n,)
        A′ and B′ of each contact with the others open; 1/kg and m/s².
    gap_tolerance, rate_tolerance : ndarray, shape (n,)
        See `closed_within`; m, m/s.
    margins : list of float
        Of the bounds of the domain, all positive inside.
    """

    gap: Array
    gap_rate: Array
    slip_velocity: Array
    W: Array
    b: Array
    mu: Array
    A_stick: Array
    B_stick: Array
    gap_tolerance: Array
    rate_tolerance: Array
    margins: list[float]


def all_contact_numbers(mechanism: Mechanism, values: Mapping[str, float]) -> ContactNumbers:
    """Return the numbers of all contacts, each formula evaluated once.

    Parameters
    ----------
    mechanism : Mechanism
    values : mapping of str to float
        Coordinates, velocities and parameters by name.
    """
    contacts = mechanism.outline.contacts
    n, names = len(contacts), argument_names(mechanism)
    numbers = _of_all_contacts(mechanism).of_vector([values[name] for name in names])
    size, count = ContactRows(n).size, len(_OF_CONTACT) * n
    rows = np.array(numbers[:count]).reshape(-1, n)
    end = count + size * size
    gap, rate, slip, A, B, near, slow = rows
    return ContactNumbers(
        gap,
        rate,
        slip,
        np.array(numbers[count:end]).reshape(size, size),
        np.array(numbers[end : end + size]),
        np.array([float(values[c.friction]) for c in contacts]),
        A,
        B,
        near,
        slow,
        numbers[end + size :],
    )


def _of_all_contacts(mechanism: Mechanism) -> Quantities:
    """Return the numbers of all contacts, the entries of W and b, the margins of the domain."""

    def formulas() -> tuple[dict[str, Any], tuple[Any, ...]]:
        n, entries = len(mechanism.contacts), _coupling_formulas(mechanism)
        own = [_formulas(mechanism, i)[0] for i in range(n)]
        named = {f"{name}_{i}": own[i][name] for name in _OF_CONTACT for i in range(n)}
        at, axis = ContactRows(n), ("t", "n")
        kinds = [axis[at.is_normal(row)] for row in range(at.size)]
        for r, c in product(range(at.size), repeat=2):
            i, low, high = at.contact(r), min(r, c), max(r, c)
            coupled = at.contact(c) != i
            name = f"W_{low}_{high}" if coupled else f"W_{kinds[low]}{kinds[high]}"
            named[f"W_{r}_{c}"] = (entries if coupled else own[i])[name]
        named |= {f"b_{r}": own[at.contact(r)][f"b_{kind}"] for r, kind in enumerate(kinds)}
        named |= {f"margin_{k}": bound.margin for k, bound in enumerate(mechanism.domain)}
        return named, argument_symbols(mechanism)

    return quantities("all", mechanism.definition, argument_names(mechanism), formulas)


def contact_numbers(mechanism: Mechanism, i: int = 0) -> Quantities:
    """Return gap, gap_rate, slip_velocity, W_nn, W_nt, W_tt, b_n, b_t, A_stick, B_stick.

    Also gap_tolerance and rate_tolerance, up to which the contact counts as closed (see
    `closed_within`). All are functions of coordinates, velocities and parameters; units as in
    `Contact` and `ContactCoefficients`.

    Parameters
    ----------
    mechanism : Mechanism
    i : int
        Which of its contacts.
    """
    names = argument_names(mechanism)
    return quantities(f"contact {i}", mechanism.definition, names, lambda: _formulas(mechanism, i))


def length_formula(mechanism: Mechanism, i: int = 0) -> Expr:
    """Return the length that the mechanism gives to compare others with; m.

    The geometric mean of the positive parameters in m. Without one √(W_nn Σ M_aa) over the angles
    a, the lever by which they move the contact; with neither, the largest of the coordinates, the
    gap and the parameters in m, which may be 0.

    Parameters
    ----------
    mechanism : Mechanism
    i : int
        Which of its contacts.
    """
    import sympy as sp

    system = mechanism.system
    lengths = [p.symbol for p in system.parameters if p.unit == "m"]
    positive = [s for s in lengths if s.is_positive]
    if positive:
        return sp.Mul(*positive) ** sp.Rational(1, len(positive))
    angles = [k for k, c in enumerate(system.coordinates) if c.unit == "rad"]
    if angles:
        inertia = sum(system.mass_matrix[k, k] for k in angles)
        return sp.sqrt(inertia * mechanism.all_coefficients[i].W_nn)
    lengths += [c.symbol for c in system.coordinates if c.unit == "m"]
    return sp.Max(*map(sp.Abs, (*lengths, mechanism.contacts[i].gap)))


def closed_within(length: Expr, kinetic: Expr, W_nn: Expr, b_n: Expr) -> tuple[Expr, Expr, Expr]:
    """Return the characteristic length L, and the gap and gap rate up to which a contact is closed.

    L measures coordinates and gap, in m: `length_formula`; where that is 0 the height
    2 T W_nn/|b_n| to which the motion could rise, and 1 m where nothing moves or nothing pulls
    back. The tolerances are parts of L, in m, and of the speed √(2 (T W_nn + |b_n| L)), in m/s,
    which the motion has or would gain over L. All follow a change of the units. Unevaluated:
    SymPy would rearrange long formulas.

    Parameters
    ----------
    length, kinetic, W_nn, b_n : sympy.Expr
        `length_formula` in m, kinetic energy T in J, mobility in 1/kg, acceleration in m/s².
    """
    import sympy as sp

    pull, twice = sp.Abs(b_n, evaluate=False), _product(sp.Integer(2), kinetic, W_nn)
    height = _product(twice, sp.Pow(pull, -1, evaluate=False))
    rises = sp.And(sp.Gt(pull, 0, evaluate=False), sp.Gt(height, 0, evaluate=False), evaluate=False)
    cases = (length, sp.Gt(length, 0, evaluate=False)), (height, rises), (1, True)
    measure = sp.Piecewise(*cases, evaluate=False)
    gain = _product(sp.Integer(2), pull, measure)
    speed = sp.Pow(sp.Add(twice, gain, evaluate=False), sp.Rational(1, 2), evaluate=False)
    part = sp.Float(CONTACT_TOLERANCE)
    return measure, _product(part, measure), _product(part, speed)


def _product(*factors: Expr) -> Expr:
    import sympy as sp

    return sp.Mul(*factors, evaluate=False)


def domain_margins(mechanism: Mechanism) -> Quantities:
    """Return margin_0, margin_1, … of the bounds of the domain, all positive inside.

    Functions of coordinates, velocities and parameters.
    """
    return quantities(
        "domain",
        mechanism.definition,
        argument_names(mechanism),
        lambda: (
            {f"margin_{i}": bound.margin for i, bound in enumerate(mechanism.domain)},
            argument_symbols(mechanism),
        ),
    )


def couplings(mechanism: Mechanism) -> Quantities:
    """Return the entries W_row_column above the diagonal that couple two contacts."""
    names = argument_names(mechanism)
    return quantities(
        "couplings",
        mechanism.definition,
        names,
        lambda: (_coupling_formulas(mechanism), argument_symbols(mechanism)),
    )


def _coupling_formulas(mechanism: Mechanism) -> dict[str, Any]:
    at = ContactRows(len(mechanism.contacts))
    rows = [row for c in mechanism.contacts for row in (c.J_N, c.J_T)]
    pairs = combinations(range(at.size), 2)
    coupled = [(r, c) for r, c in pairs if at.contact(r) != at.contact(c)]
    inverse = mechanism.system.inverse_mass_matrix if coupled else None
    return {f"W_{r}_{c}": (rows[r] * inverse * rows[c].T)[0] for r, c in coupled}


def argument_names(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the names of what the numbers of a mechanism depend on: states, then parameters."""
    return mechanism.outline.argument_names


def argument_symbols(mechanism: Mechanism) -> tuple[Any, ...]:
    """Return the symbols of `argument_names`."""
    return (*mechanism.motion, *(p.symbol for p in mechanism.system.parameters))


def sticking(c: ContactCoefficients) -> tuple[Expr, Expr]:
    """Return A′ and B′, with W_nn and b_n in states in which no motion slides the contact.

    There W_tt = W_nt = 0: sticking holds nothing.
    """
    import sympy as sp

    if c.W_tt.is_number:
        return c.A_stick, c.B_stick
    slides = sp.Gt(c.W_tt, 0, evaluate=False)
    pairs = (c.A_stick, c.W_nn), (c.B_stick, c.b_n)
    A, B = (sp.Piecewise((held, slides), (free, True)) for held, free in pairs)
    return A, B


def _formulas(mechanism: Mechanism, i: int) -> tuple[Mapping[str, Any], tuple[Any, ...]]:
    system, contact, c = mechanism.system, mechanism.contacts[i], mechanism.all_coefficients[i]
    forces = ("W_nn", "W_nt", "W_tt", "b_n", "b_t")
    formulas = {name: getattr(contact, name) for name in _MOTION}
    formulas |= {name: getattr(c, name) for name in forces}
    formulas["A_stick"], formulas["B_stick"] = sticking(c)
    given = length_formula(mechanism, i), system.kinetic_energy, c.W_nn, c.b_n
    _, near, slow = closed_within(*given)
    formulas |= {"gap_tolerance": near, "rate_tolerance": slow}
    return formulas, argument_symbols(mechanism)
