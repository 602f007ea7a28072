"""One rule for readable closed forms: the shortest of a few equivalent writings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache

import sympy as sp
from sympy.simplify.fu import TR10i

from painleve_sym.mechanics.factors import factor_terms, factored
from painleve_sym.mechanics.kept_forms import kept
from painleve_sym.time_limit import within_time

# Beyond this many operations a search takes seconds and rarely finds a shorter writing.
_OPERATIONS = 100
# Beyond this many terms multiplying out takes seconds, and (a + b + …)**20 would never end.
_TERMS = 2000
# Beyond these, even common factors and sin² + cos² = 1 take seconds, for an unreadable result.
_LONG = 1500
_REDUCED = 300
# Beyond this many terms a long expression rarely collapses to a few.
_COLLAPSED = 250
# A numerator of more terms than this is rarely written shorter, and takes seconds.
_SEARCHED = 15
# Products of two angles are contracted pair by pair, which takes seconds for more terms.
_PAIRS = 10
# Powers with a larger denominator or exponent stay whole: x**0.333 would be the 333rd power of
# x**(1/1000), and a polynomial of that degree takes minutes to factor.
_ROOT = 6
_POWER = 24


def readable(expr: sp.Expr) -> sp.Expr:
    """Return an equal expression written as a person would: fewest operations wins.

    The candidates are a common denominator with numerator and denominator reduced modulo
    sin² + cos² = 1 (both ways), factored, nested in sin or cos, and with products of two angles'
    sine and cosine contracted. A long expression has its common factors taken out, and is searched
    where most of its terms cancel.

    Parameters
    ----------
    expr : sympy.Expr

    Returns
    -------
    sympy.Expr
        Equal to `expr` for all values of its symbols.
    """
    expr = sp.sympify(expr)
    if expr.is_Atom or not isinstance(expr, sp.Expr):
        return expr
    whole, powers = without_high_powers(expr)
    if _is_monomial(whole) or sp.count_ops(whole) > _LONG:
        return expr
    return _readable(whole).xreplace(powers)


# The same forms are asked for again and again, by each phase of a jump for example.
@lru_cache(maxsize=1024)
def _readable(expr: sp.Expr) -> sp.Expr:
    return within_time("closed form", lambda: kept("readable", expr, _written))


def _written(expr: sp.Expr) -> sp.Expr:
    operations = sp.count_ops(expr)
    if operations > _OPERATIONS or _too_many_terms(expr, _TERMS):
        return _cheapest((expr, factor_terms(expr), *_few_terms(expr)))
    whole = sp.cancel(sp.together(expr))
    if len(sp.Add.make_args(sp.fraction(whole)[0])) > _SEARCHED:
        return _cheapest((expr, factor_terms(expr), factor_terms(whole), *_few_terms(expr)))
    candidates = [expr, _quotient(*sp.fraction(whole)), _termwise(*sp.fraction(whole))]
    candidates.append(_quotient(*sp.fraction(sp.cancel(candidates[-1]))))
    return _cheapest(candidates)


def _few_terms(expr: sp.Expr) -> Iterator[sp.Expr]:
    """Yield quotients of the few terms that are left of a long expression; else nothing.

    Rounded numbers do not cancel.
    """
    if expr.has(sp.Float):
        return
    parts = sp.fraction(sp.together(expr))
    if any(_too_many_terms(part, _COLLAPSED) for part in parts):
        return
    short = []
    for part in parts:
        expanded = sp.expand(part)
        forms = (expanded, *_pythagorean(expanded))
        short.append(min(forms, key=lambda form: len(sp.Add.make_args(form))))
        if len(sp.Add.make_args(short[-1])) > _SEARCHED:
            return
    numerator, denominator = short
    # Sums of angles would hide from longer forms what cancels with their parts.
    yield _quotient(*sp.fraction(sp.cancel(numerator / denominator)), contracts=False)
    yield _quotient(numerator, denominator, contracts=False)


def reduced(expr: sp.Expr) -> sp.Expr:
    """Return a polynomial in sines and cosines multiplied out and shortened by sin² + cos² = 1.

    Meant for long determinants, of more terms than `readable` searches. What would have too many
    terms is returned unchanged.
    """
    if _too_many_terms(expr, _REDUCED):
        return expr
    masked, powers = without_high_powers(expr)
    whole = within_time("determinant", lambda: sp.expand(masked))
    shortest = min((whole, *_pythagorean(whole)), key=lambda form: len(sp.Add.make_args(form)))
    return shortest.xreplace(powers)


def on_unit_sphere(expr: sp.Expr, symbols: Sequence[sp.Symbol]) -> Iterator[sp.Expr]:
    """Yield writings of a polynomial in symbols whose squares add up to 1, without one's squares.

    Nothing where the symbols do not occur in it, or where it is long or no polynomial in them: the
    root in the normal of a curved surface would be multiplied out within, which has no end.
    """
    occurring = [s for s in symbols if s in expr.free_symbols and expr.is_polynomial(s)]
    if not occurring or _too_many_terms(expr, _REDUCED):
        return
    whole = sp.expand(expr)
    for symbol in occurring:
        rest = 1 - sum(s**2 for s in symbols if s != symbol)
        if (form := _without_squares(whole, symbol, rest)) != whole:
            yield form


def without_high_powers(expr: sp.Expr) -> tuple[sp.Expr, dict[sp.Symbol, sp.Expr]]:
    """Return the expression with a symbol for each power that polynomial algorithms would unroll.

    Parameters
    ----------
    expr : sympy.Expr

    Returns
    -------
    expr : sympy.Expr
        With symbols for powers of a high degree or a high root, those of exp included.
    powers : dict of sympy.Symbol to sympy.Expr
        What the symbols stand for.
    """
    swaps: dict[sp.Expr, sp.Expr] = {}
    powers: dict[sp.Symbol, sp.Expr] = {}
    high = [power for power in expr.atoms(sp.Pow, sp.exp) if _is_high(power)]
    for power in sorted(high, key=sp.default_sort_key):
        base, exponent = power.as_base_exp()
        number, rest = exponent.as_coeff_Mul(rational=True)
        # What differs by whole powers shares its symbol: x**1.333 is x times that of x**0.333.
        whole = sp.floor(number) if rest == 1 and abs(number) <= _POWER else sp.Integer(0)
        part = abs(number - whole)
        sign = 1 if number > whole else -1
        stands_for = sp.Pow(base, part * rest)
        symbol = next((s for s, p in powers.items() if p == stands_for), None)
        if symbol is None:
            symbol = sp.Dummy("power", positive=stands_for.is_positive or None)
            powers[symbol] = stands_for
        swaps[power] = symbol**sign * base**whole
    # A base may hold further powers.
    while (swapped := expr.xreplace(swaps)) != expr:
        expr = swapped
    return expr, powers


def _is_high(power: sp.Expr) -> bool:
    exponent = power.as_base_exp()[1]
    if exponent.is_Integer:
        return bool(abs(exponent.p) > _POWER)
    numbers = (t.as_coeff_Mul(rational=True)[0] for t in sp.Add.make_args(exponent))
    return any(abs(n.p) > _POWER or n.q > _ROOT for n in numbers)


def _too_many_terms(expr: sp.Expr, limit: int) -> bool:
    return max(_terms(expr)) > limit


def _terms(expr: sp.Expr) -> tuple[float, float]:
    """Return at most how many terms numerator and denominator have when multiplied out."""
    if expr.is_Add:
        parts = [_terms(a) for a in expr.args]
        common = float(math.prod(d for _, d in parts))
        return sum(n * common / d for n, d in parts), common
    if expr.is_Mul:
        parts = [_terms(a) for a in expr.args]
        return float(math.prod(n for n, _ in parts)), float(math.prod(d for _, d in parts))
    if expr.is_Pow and expr.exp.is_Integer:
        power = abs(int(expr.exp))
        top, bottom = (_power_terms(t, power) for t in _terms(expr.base))
        return (top, bottom) if expr.exp.is_positive else (bottom, top)
    return 1.0, 1.0


def _power_terms(terms: float, power: int) -> float:
    """Return how many terms a sum has in a power: the number of monomials of that degree."""
    if terms == 1:
        return 1.0
    if terms > _TERMS or power > _TERMS:
        return float(2 * _TERMS)
    return float(min(math.comb(int(terms) + power - 1, power), 2 * _TERMS))


def _quotient(numerator: sp.Expr, denominator: sp.Expr, *, contracts: bool = True) -> sp.Expr:
    plus = _shortest(denominator, contracts)
    minus = _shortest(-denominator, contracts)
    if _cheapest((plus, minus)) != plus:
        return _shortest(-numerator, contracts) / minus
    return _shortest(numerator, contracts) / plus


def _termwise(numerator: sp.Expr, denominator: sp.Expr) -> sp.Expr:
    """Write each group of terms with the same non-trigonometric factor over its own divisor."""
    groups: dict[sp.Expr, sp.Expr] = {}
    for term in sp.Add.make_args(sp.expand(numerator)):
        factor, angle = term.as_independent(sp.sin, sp.cos, as_Add=False)
        sign = -1 if factor.could_extract_minus_sign() else 1
        number, symbols = (sign * factor).as_coeff_Mul()
        groups[symbols] = groups.get(symbols, sp.Integer(0)) + sign * number * angle
    parts = []
    for factor, angles in groups.items():
        forms = [_quotient(angles, denominator)]
        for n, d in zip(_pythagorean(angles), _pythagorean(denominator), strict=False):
            forms.append(_quotient(*sp.fraction(sp.cancel(n / d))))
        parts.append(factor * _cheapest(forms))
    return sp.Add(*parts)


def _cheapest(forms: Iterable[sp.Expr]) -> sp.Expr:
    """Return the form of least cost, of equals the shortest as text, of equals the first."""
    costs = {form: _cost(form) for form in forms}
    least = min(costs.values())
    ties = [form for form, cost in costs.items() if cost == least]
    return ties[0] if len(ties) == 1 else min(ties, key=_length)


# A search asks for the same of the same parts over and over.
@lru_cache(maxsize=8192)
def _cost(expr: sp.Expr) -> tuple[int, int, int]:
    """Operations and minus signs, then symbols written, then integers."""
    minus = symbols = integers = 0
    for a in sp.preorder_traversal(expr):
        if a.is_Symbol:
            symbols += 1
        elif a.is_Integer:
            integers += abs(int(a))
        elif a.is_Mul and a.could_extract_minus_sign():
            minus += 1
    return int(sp.count_ops(expr)) + minus, symbols, integers


@lru_cache(maxsize=2048)
def _length(expr: sp.Expr) -> int:
    return len(str(expr))


@lru_cache(maxsize=2048)
def _shortest(expr: sp.Expr, contracts: bool) -> sp.Expr:
    return expr if _is_monomial(expr) else _cheapest(_writings(expr, contracts))


def _is_monomial(expr: sp.Expr) -> bool:
    """Return whether a product of whole powers of symbols and of single sines and cosines.

    It is short as it is; of squares of sines −cos² has the shorter writing sin² − 1.
    """
    powers = (factor.as_base_exp() for factor in sp.Mul.make_args(expr))
    return all(
        exponent == 1
        if isinstance(base, sp.sin | sp.cos)
        else exponent.is_Integer and (base.is_Symbol or base.is_Rational)
        for base, exponent in powers
    )


def _writings(expr: sp.Expr, contracts: bool) -> Iterator[sp.Expr]:
    """Yield writings, also with products of two angles contracted where that is asked for."""
    forms = [expr, *_pythagorean(expr)]
    if contracts and len({a.args[0] for a in expr.atoms(sp.sin, sp.cos)}) > 1:
        whole = sp.expand(expr)
        if len(sp.Add.make_args(whole)) <= _PAIRS:
            forms.append(TR10i(whole))
    for form in dict.fromkeys(forms):
        yield form
        yield factor_terms(form)
        yield factored(form)
        whole = sp.expand(form)
        for atom in sorted(form.atoms(sp.sin, sp.cos), key=str):
            yield from _gathered(whole, atom)


@lru_cache(maxsize=2048)
def _gathered(expanded: sp.Expr, atom: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Gather powers of an atom; then atom·(…) + rest, with the bracket's common factor outside."""
    rest, inner = expanded.as_independent(atom, as_Add=True)
    powers: dict[sp.Expr, list[sp.Expr]] = {}
    for term in sp.Add.make_args(inner):
        factors = sp.Mul.make_args(term)
        power = next((f for f in factors if f.as_base_exp()[0] == atom), sp.Integer(1))
        powers.setdefault(power, []).append(term / power)
    gathered = sp.Add(rest, *(power * sp.Add(*terms) for power, terms in powers.items()))
    return gathered, factor_terms(inner) + factor_terms(rest)


@lru_cache(maxsize=2048)
def _pythagorean(expr: sp.Expr) -> tuple[sp.Expr, ...]:
    """Reduce modulo sin² + cos² = 1, eliminating even powers of one or of the other."""
    expanded = sp.expand(expr)
    angles = sorted({a.args[0] for a in expanded.atoms(sp.sin, sp.cos)}, key=str)
    if not angles:
        return ()
    forms = []
    for keep in (sp.cos, sp.sin):
        drop = sp.sin if keep is sp.cos else sp.cos
        form = expanded
        for angle in angles:
            form = _without_squares(form, drop(angle), 1 - keep(angle) ** 2)
        forms.append(form)
    return tuple(forms)


def _without_squares(expanded: sp.Expr, atom: sp.Expr, square: sp.Expr) -> sp.Expr:
    """Put `square` for every atom² of an expanded sum; unchanged where it is not a polynomial."""
    powers = (p for p in expanded.atoms(sp.Pow) if p.base == atom and p.exp.is_Integer)
    if not any(p.exp > 1 for p in powers):
        return expanded
    s = sp.Dummy("s")
    poly = expanded.xreplace({atom: s})
    if not poly.is_polynomial(s):
        return expanded
    parts = []
    for term in sp.Add.make_args(poly):
        coefficient, power = term.as_coeff_exponent(s)
        parts.append(coefficient * square ** (power // 2) * atom ** (power % 2))
    return sp.expand(sp.Add(*parts))
