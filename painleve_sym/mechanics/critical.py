"""The friction above which the paradox is possible, and its minimum in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.readable import readable


@dataclass(frozen=True)
class CriticalMinimum:
    """The smallest critical friction over one coordinate.

    Attributes
    ----------
    value : sympy.Expr
        min μ_P; 1.
    variable : sympy.Expr
        What the minimum was sought in: tan q, tan(q/2) or the coordinate q itself.
    at : tuple of sympy.Expr
        Where `variable` takes the minimum.
    """

    value: sp.Expr
    variable: sp.Expr
    at: tuple[sp.Expr, ...]


@dataclass(frozen=True)
class CriticalFriction:
    """Friction coefficient above which A_s < 0: Painlevé's paradox becomes possible.

    A_s = W_nn − μ s W_nt < 0 needs s W_nt > 0 and μ > μ_P = W_nn/(s W_nt). In the other slip
    direction A_s > 0 for every μ.

    Attributes
    ----------
    coefficients : ContactCoefficients
    slip : {-1, +1, 0}
        Slip direction s; 0 for the one in which the paradox can happen, s = sign(W_nt).
    value : sympy.Expr
        μ_P(q), of either sign where `slip` is given: valid where it is positive; 1.
    """

    coefficients: ContactCoefficients
    slip: int
    value: sp.Expr

    def minimum(self, coordinate: str) -> CriticalMinimum:
        """Return the smallest positive μ_P over one coordinate, the others held.

        Parameters
        ----------
        coordinate : str
            Name of a coordinate, with the others and the parameters left as symbols.

        Raises
        ------
        InputError
            Unknown name, or no closed form: μ_P is constant or not rational in the coordinate's
            tangent, or its stationary values cannot be compared.
        """
        system = self.coefficients.contact.system
        names = [c.name for c in system.coordinates]
        where = f"critical friction of mechanism {system.name!r}"
        if coordinate not in names:
            raise InputError(f"{where}: {unknown_name('coordinate', coordinate, names)}")
        t = sp.Symbol("t", real=True)
        # W_nn > 0, and the sign of W_nt only tells the slip direction: both are candidates.
        ratio = readable(self.coefficients.W_nn / self.coefficients.W_nt)
        form, variable = in_one_variable(ratio, system.q[names.index(coordinate)], t)
        if form is None:
            raise InputError(
                f"{where}: got {ratio}, need it to vary with {coordinate!r} and to be rational in "
                f"its tangent. Fix: evaluate `value` on a grid."
            )
        signs = (self.slip,) if self.slip else (1, -1)
        candidates = [(p, v) for s in signs for p, v in _extremes(s * form, t)]
        value = sp.Min(*(v for _, v in candidates)) if candidates else sp.oo
        if isinstance(value, sp.Min) or value is sp.oo:
            raise InputError(
                f"{where}: got stationary values {[v for _, v in candidates]}, need comparable "
                f"ones. Fix: put numbers for the other symbols into `value`."
            )
        return CriticalMinimum(value, variable, tuple(p for p, v in candidates if v == value))


def critical_friction(coefficients: ContactCoefficients, slip: int = 0) -> CriticalFriction:
    """Return μ_P(q) = W_nn/|W_nt|, or W_nn/(s W_nt) for a given slip direction.

    Parameters
    ----------
    coefficients : ContactCoefficients
    slip : {0, -1, +1}

    Returns
    -------
    CriticalFriction

    Raises
    ------
    InputError
        W_nt = 0 for every configuration: friction and normal motion are not coupled.
    """
    if slip not in (-1, 0, 1):
        raise InputError(f"slip direction: got {slip!r}, need -1, +1, or 0 for either.")
    W_nn, W_nt = coefficients.W_nn, coefficients.W_nt
    if W_nt == 0:
        name = coefficients.contact.system.name
        raise InputError(
            f"critical friction of mechanism {name!r}: got W_nt = 0, need a contact whose friction "
            f"moves it in the normal direction. Fix: none; A > 0 for every friction."
        )
    value = readable(W_nn / (slip * W_nt)) if slip else W_nn / sp.Abs(W_nt)
    return CriticalFriction(coefficients, slip, value)


def in_one_variable(expr: sp.Expr, q: sp.Symbol, t: sp.Symbol) -> tuple[sp.Expr | None, sp.Expr]:
    """Write `expr` as a rational function of t = tan q, tan(q/2) or q; None where it is not."""
    root = sp.sqrt(1 + t**2)
    forms = (
        (sp.tan(q), {sp.sin(q): t / root, sp.cos(q): 1 / root}),
        (sp.tan(q / 2), {sp.sin(q): 2 * t / (1 + t**2), sp.cos(q): (1 - t**2) / (1 + t**2)}),
        (q, {q: t}),
    )
    for variable, swap in forms:
        form = sp.cancel(sp.together(expr.subs(swap)))
        if form.has(t) and form.is_rational_function(t) and q not in form.free_symbols:
            return form, variable
    return None, q


def _extremes(form: sp.Expr, t: sp.Symbol) -> list[tuple[sp.Expr, sp.Expr]]:
    """Return where a rational function is stationary, or ends, with a positive finite value."""
    slope = sp.fraction(sp.together(sp.diff(form, t)))[0]
    points = [(p, form.subs(t, p)) for p in sp.roots(slope, t) if p.is_real is not False]
    points += [(end, sp.limit(form, t, end)) for end in (sp.oo, -sp.oo)]
    values = [(p, sp.simplify(v)) for p, v in points]
    return [(p, v) for p, v in values if v.is_positive and v.is_finite is not False]
