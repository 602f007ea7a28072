"""Length and speed of a mechanism, and the parts of them within which a contact is closed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from painleve_sym.mechanics.mechanism import Mechanism

if TYPE_CHECKING:
    from sympy import Expr

CONTACT_TOLERANCE = 1e-12
"""Part of the mechanism's length and speed below which gap and its rate are 0: round-off."""


def length_formula(mechanism: Mechanism, i: int = 0, mobility: Expr | None = None) -> Expr:
    """Return the length that the mechanism gives to compare others with; m.

    The geometric mean of the positive parameters in m. Without one √(W_nn Σ M_aa) over the angles
    a, the lever by which they move the contact; with neither, the largest of the coordinates, the
    gap and the parameters in m, which may be 0.

    Parameters
    ----------
    mechanism : Mechanism
    i : int
        Which of its contacts.
    mobility : sympy.Expr, optional
        W_nn of that contact, where it is not to be taken from its coefficients.
    """
    import sympy as sp

    system = mechanism.system
    lengths = [p.symbol for p in system.parameters if p.unit == "m"]
    positive = [s for s in lengths if s.is_positive]
    if positive:
        return sp.Mul(*positive) ** sp.Rational(1, len(positive))
    angles = [k for k, v in enumerate(system.velocities) if v.unit == "rad/s"]
    if angles:
        inertia = sum(system.mass_matrix[k, k] for k in angles)
        if mobility is None:
            mobility = mechanism.all_coefficients[i].W_nn
        return sp.sqrt(inertia * mobility)
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
