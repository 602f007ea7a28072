"""The friction above which the paradox is possible, and its minimum in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.simplify import readable, reduced, without_high_powers
from painleve_sym.mechanics.system import sample_values

# Beyond this many operations in W_nn and W_nt a search for closed forms takes minutes.
_OPERATIONS = 60
# Beyond this many operations a sum of squares is only lengthened by multiplying it out.
_READ_WHOLE = 100
# Roots with an imaginary part below this are real ones with round-off.
_ROUND_OFF = 1e-9
# A number that is larger than this after 30 digits of cancellation is not zero.
_NOT_ZERO = sp.Float("1e-15")


@dataclass(frozen=True)
class CriticalMinimum:
    """The smallest critical friction over one coordinate.

    `value` is min μ_P, or the limit it falls to where it is not attained, since W_nn tends to 0; 1.
    `variable` is what the minimum was sought in: a sine, cosine, tangent, tan(q/2) or the
    coordinate itself; `at` is where it takes the minimum.

    Where the stationary values are roots of a polynomial of degree three or more, that is the
    `equation` in `root`, in which `value` is written, and `at` is empty. The minimum is at its root
    with the smallest positive value, among those in [-1, 1] where `variable` is a sine or cosine.
    """

    value: sp.Expr
    variable: sp.Expr
    at: tuple[sp.Expr, ...]
    attained: bool = True
    equation: sp.Expr | None = None
    root: sp.Symbol | None = None

    def number(self, values: Mapping[sp.Symbol, float]) -> tuple[float, tuple[float, ...]]:
        """Return the minimum and the places of `variable` for numbers of every other symbol."""
        missing = (self.value.free_symbols | _free(self.at)) - {self.root} - set(values)
        if missing:
            names = ", ".join(sorted(map(str, missing)))
            raise InputError(f"critical friction: got no value of {names}. Fix: give one.")
        if self.equation is None or self.root is None:
            return float(self.value.subs(values)), tuple(float(p.subs(values)) for p in self.at)
        roots = sp.Poly(self.equation.subs(values), self.root).nroots(n=30)
        real = [sp.re(r) for r in roots if abs(sp.im(r)) < _ROUND_OFF]
        if isinstance(self.variable, sp.sin | sp.cos):
            # The polynomial knows nothing of |sin q| <= 1.
            real = [r for r in real if abs(r) <= 1]
        pairs = [(self.value.subs({**values, self.root: r}), r) for r in real]
        allowed = [(float(v), float(r)) for v, r in pairs if v.is_real and v > 0]
        least = min(v for v, _ in allowed)
        return least, tuple(r for v, r in allowed if v - least <= _ROUND_OFF * least)


@dataclass(frozen=True)
class CriticalFriction:
    """Friction coefficient above which A_s < 0: Painlevé's paradox becomes possible.

    A_s = W_nn − μ s W_nt < 0 needs s W_nt > 0 and μ > μ_P = W_nn/(s W_nt). In the other slip
    direction A_s > 0 for every μ.

    `slip` is s; 0 for the one in which the paradox can happen, s = sign(W_nt). `value` is μ_P(q),
    of either sign where `slip` is given: valid where it is positive; 1.
    """

    coefficients: ContactCoefficients
    slip: int
    value: sp.Expr

    @property
    def where(self) -> str:
        """Place of a fault, as messages name it."""
        return f"critical friction of mechanism {self.coefficients.contact.system.name!r}"

    def minimum(self, coordinate: str) -> CriticalMinimum:
        """Return the smallest positive μ_P over one coordinate, the others held.

        Where the coordinate turns the mobility without changing its eigenvalues, the minimum is
        `least_over_directions`. Otherwise the stationary values are compared; where they are roots
        of a polynomial of degree three or more, that polynomial is returned.

        Raises
        ------
        InputError
            Unknown name, or no closed form: μ_P is constant or not rational in the coordinate's
            sine, cosine or tangent, or its stationary values cannot be compared.
        """
        system = self.coefficients.contact.system
        q = system.coordinate(coordinate, self.where)
        t = sp.Dummy("t", real=True)
        # W_nn > 0, and the sign of W_nt only tells the slip direction: both are candidates.
        ratio = readable(self.coefficients.W_nn / self.coefficients.W_nt)
        form, variable = (None, q) if self._long else in_one_variable(ratio, q, t)
        if form is not None and variable == sp.tan(q) and self._turns(q):
            return self._by_eigenvalues(form, variable, t)
        minimum = form is not None and self._by_comparison(form, variable, t)
        if not minimum and not self._long and not self.value.free_symbols & set(system.q) - {q}:
            minimum = self._by_equation(q)
        if not minimum:
            raise InputError(
                f"{self.where}: got {ratio}, need it to vary with {coordinate!r}, to be rational "
                "in its sine, cosine or tangent, and its stationary values to be comparable. Fix: "
                "evaluate `value` on a grid."
            )
        return minimum

    def in_contact(self) -> sp.Expr:
        """Return |μ_P| at the closed gap, where that fixes all of the coordinates in it.

        Raises
        ------
        InputError
            μ_P holds other coordinates than the gap, or more than one, or the closed gap is not
            linear in that coordinate's sine, cosine or itself.
        """
        contact = self.coefficients.contact
        q_all = set(contact.system.q)
        inner = self.value.free_symbols & q_all
        if not self._long and len(inner) == 1 and contact.gap.free_symbols & q_all == inner:
            (q,) = inner
            x = sp.Dummy("x", real=True)
            for square, swap, _ in self._squares(q, x):
                gap = sp.expand(contact.gap.subs(swap))
                if q in gap.free_symbols or not gap.is_polynomial(x) or sp.degree(gap, x) != 1:
                    continue
                place = sp.solve(gap, x)[0]
                return _root_of_square(square.subs(x, place))
        raise InputError(
            f"{self.where}: got gap {contact.gap}, need one that fixes the only coordinate of "
            f"{self.value}. Fix: use `minimum`."
        )

    @property
    def _long(self) -> bool:
        c = self.coefficients
        operations = sp.count_ops(c.W_nn) + sp.count_ops(c.W_nt)
        return bool(operations > _OPERATIONS or without_high_powers(c.W_nn + c.W_nt)[1])

    def _turns(self, q: sp.Symbol) -> bool:
        """Return whether q turns W without changing its eigenvalues."""
        c = self.coefficients
        trace, determinant = c.W_nn + c.W_tt, c.W_nn * c.W_tt - c.W_nt**2
        return bool(
            determinant != 0 and all(_vanishes(sp.diff(form, q)) for form in (trace, determinant))
        )

    def _by_eigenvalues(self, form: sp.Expr, variable: sp.Expr, t: sp.Symbol) -> CriticalMinimum:
        value = least_over_directions(self.coefficients)
        slope = sp.fraction(sp.together(sp.diff(form, t)))[0]
        places = _quadratic_roots(slope, t)
        if self.slip:
            # The sign of W_nt at a place is that of the two axes: the same for all parameters.
            defaults = self.coefficients.contact.system.defaults
            places = [p for p in places if self.slip * form.subs(t, p).subs(defaults) > 0]
        return CriticalMinimum(value, variable, tuple(places))

    def _by_comparison(
        self, form: sp.Expr, variable: sp.Expr, t: sp.Symbol
    ) -> CriticalMinimum | None:
        slope = sp.fraction(sp.together(sp.diff(form, t)))[0]
        if sp.degree(slope, t) > 2:
            return None
        signs = (self.slip,) if self.slip else (1, -1)
        candidates = [(p, v) for s in signs for p, v in _extremes(s * form, t)]
        if any(v == 0 for _, v in candidates):
            places = tuple(dict.fromkeys(p for p, v in candidates if v == 0))
            return CriticalMinimum(sp.Integer(0), variable, places, attained=False)
        value = sp.Min(*(v for _, v in candidates)) if candidates else sp.oo
        if isinstance(value, sp.Min) or value is sp.oo:
            return None
        return CriticalMinimum(value, variable, tuple(p for p, v in candidates if v == value))

    def _squares(
        self, q: sp.Symbol, x: sp.Symbol
    ) -> list[tuple[sp.Expr, dict[sp.Expr, sp.Expr], sp.Expr]]:
        """Return μ_P² as a rational function of x = sin q, cos q or q, and how it got there."""
        c = self.coefficients
        squares: list[tuple[sp.Expr, dict[sp.Expr, sp.Expr], sp.Expr]] = []
        rest = sp.sqrt(1 - x**2)
        for swap, variable in (
            ({sp.sin(q): x, sp.cos(q): rest}, sp.sin(q)),
            ({sp.cos(q): x, sp.sin(q): rest}, sp.cos(q)),
            ({q: x}, q),
        ):
            square = sp.cancel(sp.together(sp.expand((c.W_nn / c.W_nt) ** 2).subs(swap)))
            if square.has(x) and square.is_rational_function(x) and q not in square.free_symbols:
                squares.append((square, swap, variable))
        return squares

    def _by_equation(self, q: sp.Symbol) -> CriticalMinimum | None:
        """Return the minimum by the polynomial of least degree whose root it is."""
        x = sp.Dummy("x", real=True)
        c = self.coefficients
        best: tuple[int, CriticalMinimum] | None = None
        for square, swap, variable in self._squares(q, x):
            slope = sp.fraction(sp.cancel(sp.diff(square, x)))[0]
            zero = sp.fraction(sp.together(square))[0]
            factors = [f for f, _ in sp.factor_list(slope)[1] if f.has(x)]
            # Where W_nn = 0 there is no contact problem to speak of.
            factors = [f for f in factors if sp.rem(zero, f, x) != 0]
            equation = sp.Mul(*(sp.collect(sp.expand(f), x) for f in factors))
            degree = sp.degree(equation, x)
            if len(factors) != 1 or degree < 1 or (best and best[0] <= degree):
                continue
            prefix = f"{variable.func}_" if variable.is_Function else ""
            root = sp.Symbol(f"{prefix}{q}", real=True)
            value = (c.W_nn / sp.Abs(c.W_nt)).subs(swap).subs(x, root)
            equation = equation.subs(x, root)
            minimum = CriticalMinimum(value, variable, (), equation=equation, root=root)
            best = (degree, minimum)
        return best[1] if best else None


def critical_friction(coefficients: ContactCoefficients, slip: int = 0) -> CriticalFriction:
    """Return μ_P(q) = W_nn/|W_nt|, or W_nn/(s W_nt) for a given slip direction.

    W_nt = 0 for every configuration is rejected: friction and normal motion are not coupled.
    """
    if slip not in (-1, 0, 1):
        raise InputError(f"slip direction: got {slip!r}, need -1, +1, or 0 for either.")
    W_nn, W_nt = coefficients.W_nn, coefficients.W_nt
    if W_nt == 0:
        name = coefficients.contact.system.name
        raise InputError(
            f"critical friction of mechanism {name!r}: got W_nt = 0, need a contact whose friction "
            f"moves it in the normal direction: here A > 0 for every friction."
        )
    ratio = readable(W_nn / ((slip or 1) * W_nt))
    value = ratio if slip else min(W_nn / sp.Abs(W_nt), sp.Abs(ratio), key=sp.count_ops)
    return CriticalFriction(coefficients, slip, value)


def least_over_directions(coefficients: ContactCoefficients) -> sp.Expr:
    """Return 2 √(λ₁ λ₂)/(λ₂ − λ₁), the least μ_P over all directions of the surface.

    λ₁ ≤ λ₂ are the eigenvalues of the mobility W = [[W_nn, W_nt], [W_nt, W_tt]] of the contact
    point. A surface whose normal is turned by ψ from the first axis of W has W_nn = λ₁ cos²ψ + λ₂
    sin²ψ and W_nt = (λ₂ − λ₁) sinψ cosψ, so that

        μ_P = (λ₁ + λ₂ tan²ψ)/((λ₂ − λ₁) |tanψ|),  least at tan²ψ = λ₁/λ₂.

    It is a lower bound of μ_P in the given configuration, and its minimum over a coordinate that
    turns W without changing the eigenvalues. It is 0 for a W of rank one, and infinite (SymPy's
    zoo) where λ₁ = λ₂ everywhere.
    """
    c = coefficients
    first, *others = _turned_together(c) or (None,)
    # The eigenvalues do not feel a common turn: the first angle is 0, the others differences.
    W_nn, W_nt, W_tt = (w.subs(first, 0) if others else w for w in (c.W_nn, c.W_nt, c.W_tt))
    determinant = readable(W_nn * W_tt - W_nt**2)
    spread = readable((W_nn - W_tt) ** 2 + 4 * W_nt**2)
    if spread == 0:
        return sp.zoo
    if sp.count_ops(spread) > _READ_WHOLE:
        top, bottom = sp.fraction(sp.together(spread))
        root = 2 * _root_of_square(determinant) * _root_of_square(bottom) / sp.sqrt(top)
    else:
        root = _root_of_square(4 * determinant / spread)
    return root.subs({q: q - first for q in others})


def _free(exprs: tuple[sp.Expr, ...]) -> set[sp.Symbol]:
    return set().union(*(e.free_symbols for e in exprs))


def _turned_together(coefficients: ContactCoefficients) -> tuple[sp.Symbol, ...]:
    """Return the angles of an arm whose common turn turns W: M is unchanged, J_N and J_T turn."""
    contact = coefficients.contact
    system = contact.system
    angles = [c.symbol for c in system.coordinates if c.unit == "rad"]
    if len(angles) < 2:
        return ()

    def turned(matrix: sp.Matrix) -> sp.Matrix:
        return sum((matrix.diff(q) for q in angles), sp.zeros(*matrix.shape))

    rates = (
        turned(system.mass_matrix),
        turned(contact.J_N) - contact.J_T,
        turned(contact.J_T) + contact.J_N,
    )
    if all(_vanishes(entry) for matrix in rates for entry in matrix):
        return tuple(angles)
    return ()


def _vanishes(expr: sp.Expr) -> bool:
    """Return whether an expression is 0 for all values: asked of a number before it is searched."""
    whole = without_high_powers(expr)[0]
    number = sp.N(whole.xreplace(sample_values(whole.free_symbols, 1)), 30)
    if number.is_Float and abs(number) > _NOT_ZERO:
        return False
    return bool(reduced(sp.fraction(sp.together(whole))[0]) == 0 or sp.simplify(whole) == 0)


def in_one_variable(expr: sp.Expr, q: sp.Symbol, t: sp.Symbol) -> tuple[sp.Expr | None, sp.Expr]:
    """Write `expr` as a rational function of t = tan q or q; None where it is not.

    Neither is it where it has powers of so high a degree that its roots have no closed form.
    """
    if without_high_powers(expr)[1]:
        return None, q
    root = sp.sqrt(1 + t**2)
    forms = ((sp.tan(q), {sp.sin(q): t / root, sp.cos(q): 1 / root}), (q, {q: t}))
    # sin(q + a) hides sin q and cos q.
    expr = sp.expand_trig(expr)
    for variable, swap in forms:
        form = sp.cancel(sp.together(expr.subs(swap)))
        if form.has(t) and form.is_rational_function(t) and q not in form.free_symbols:
            return form, variable
    return None, q


def _quadratic_roots(expr: sp.Expr, t: sp.Symbol) -> list[sp.Expr]:
    """Return the real roots of a polynomial that has degree two without its common factors."""
    coefficients = sp.Poly(sp.expand(expr), t).primitive()[1]
    a, b, c = (coefficients.coeff_monomial(t**k) for k in (2, 1, 0))
    width = sp.sqrt(sp.factor(b**2 - 4 * a * c))
    return [readable((sign * width - b) / (2 * a)) for sign in (1, -1)]


def _root_of_square(square: sp.Expr) -> sp.Expr:
    """Return √ of a quotient, with the squares in numerator and denominator taken out."""
    whole, powers = without_high_powers(square)
    top, bottom = sp.fraction(sp.cancel(sp.together(readable(whole))))
    if sp.factor(bottom).could_extract_minus_sign():
        top, bottom = -top, -bottom
    return (_root_of_factors(top) / _root_of_factors(bottom)).xreplace(powers)


def _root_of_factors(product: sp.Expr) -> sp.Expr:
    number, factors = sp.factor_list(product)
    outer, inner = sp.Integer(1), sp.sympify(number)
    for factor, power in factors:
        outer *= sp.Abs(factor) ** (power // 2)
        inner *= factor ** (power % 2)
    return outer * sp.sqrt(readable(inner))


def _extremes(form: sp.Expr, t: sp.Symbol) -> list[tuple[sp.Expr, sp.Expr]]:
    """Return stationary and end points of a rational function with a finite value >= 0.

    A limit 0 at an end counts, and so does a zero of W_nn.
    """
    slope = sp.fraction(sp.together(sp.diff(form, t)))[0]
    points = [(p, form.subs(t, p)) for p in sp.roots(slope, t) if p.is_real is not False]
    points += [(end, sp.limit(form, t, end)) for end in (sp.oo, -sp.oo)]
    # SymPy fails to simplify some infinite limits whose sign is open.
    infinite = (sp.oo, -sp.oo, sp.zoo, sp.nan)
    values = [(p, sp.simplify(v)) for p, v in points if not v.has(*infinite)]
    return [(p, v) for p, v in values if v.is_nonnegative and v.is_finite is not False]
