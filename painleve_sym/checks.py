"""Checks of numbers that a user gives: every message says what, where, the value got and needed."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Any, Protocol

from painleve_sym.errors import MAX_FAULTS, InputError, received, unknown_name
from painleve_sym.units import in_unit

LARGEST = 1e100
"""Size limit of numbers that are given: products of three of them are in the range of doubles."""
SMALLEST = 1 / LARGEST
"""Size limit of numbers that must be positive, such as a mass, for the same reason."""
SYMMETRY = 1e-9
"""Of the roots of the diagonal of a mobility: roundings of a mass-matrix inverse."""
INDEFINITE = 1e-12
"""Per row, on a mobility scaled to a diagonal of ones."""
OBLIQUE = 1e-6
"""Least determinant of W_tt, scaled so, of a W of rank two: W_tt⁻¹ loses six digits there."""


def checked_number(
    value: Any,
    name: str,
    *,
    lower: float = -math.inf,
    upper: float = math.inf,
    above: float = -math.inf,
    below: float = math.inf,
) -> tuple[float, str]:
    """Return a value as float, and a sentence where it is not a number in range.

    Numbers are those of Python or NumPy; text and truth values are none, and the float is nan then.
    lower ≤ value ≤ upper, above < value < below, and none may be larger than `LARGEST` in size. The
    sentence calls the value by its name and is empty where there is no fault.
    """
    try:
        if isinstance(value, bool | str | bytes):
            raise TypeError
        number = float(value)
    except OverflowError:
        number = math.inf
    except (TypeError, ValueError):
        return math.nan, f"{name}: got {value!r}, need a number."
    if abs(number) <= LARGEST and lower <= number <= upper and above < number < below:
        return number, ""
    shown = number if isinstance(value, float) else value
    need = f"a finite number{_range(lower, upper, above, below)}{size_text(number)}"
    return number, f"{name}: got {shown!r}, need {need}."


def size_text(number: float) -> str:
    """Return what a message adds of the size limit: nothing unless the number is too large."""
    return f", of at most {LARGEST:g} in size" if LARGEST < abs(number) < math.inf else ""


def _range(lower: float, upper: float, above: float, below: float) -> str:
    ends = {">=": lower, ">": above, "<=": upper, "<": below}
    parts = [f"{sign} {end:g}" for sign, end in ends.items() if math.isfinite(end)]
    return f" {' and '.join(parts)}" if parts else ""


def number(value: Any, name: str, *, where: str, unit: str | None = None, **bounds: float) -> float:
    """Return a finite number in range as float; InputError, with `where` in front, for others.

    With the SI unit of the value, it may also be a text with a unit of that kind, such as ``1 ms``.
    See `checked_number` for the bounds.

    >>> number("1 ms", "t_end", where="run", unit="s")
    0.001
    """
    if unit is not None and isinstance(value, str):
        value = in_unit(value, unit, f"{where}: {name}")
    result, fault = checked_number(value, name, **bounds)
    if fault:
        raise InputError(f"{where}: {fault}")
    return result


def whole_number(value: Any, name: str, *, where: str, lower: int, upper: int) -> int:
    """Return a whole number from `lower` to `upper`; InputError where it is not one."""
    with suppress(TypeError):
        whole = operator.index(value)
        if lower <= whole <= upper and not isinstance(value, bool):
            return whole
    raise InputError(
        f"{where}: {name}: got {received(value)}, need a whole number from {lower} to {upper}."
    )


def by_name(value: Any, where: str, example: str = "{'theta': 1.0}") -> Mapping[str, Any]:
    """Return a mapping of names to values, empty for None; InputError for anything else.

    Names may be given as symbols, and the whole as a Series of pandas.

    >>> by_name({"mu": 1.5}, "parameters")
    {'mu': 1.5}
    """
    if value is None:
        return {}
    if isinstance(value, Mapping) and all(isinstance(name, str) for name in value):
        return value
    if (named := _named(value)) is not None:
        return named
    raise InputError(
        f"{where}: got {received(value)}, need a mapping of names to numbers, such as {example}."
    )


def _named(value: Any) -> dict[str, Any] | None:
    """Return the values of a mapping or Series by name; None where a key has none, or not its own.

    A key is a text, or a symbol or function of SymPy, whose derivative by the time is a velocity.
    """
    if not callable(items := getattr(value, "items", None)):
        return None
    pairs = [(_key_name(key), own) for key, own in items()]
    named = {name: own for name, own in pairs if name is not None}
    return named if len(named) == len(pairs) else None


def _key_name(key: Any) -> str | None:
    """Return the name that a key stands for."""
    if isinstance(key, str):
        return str(key)
    inner, count = getattr(key, "expr", None), getattr(key, "derivative_count", None)
    if inner is not None and count is not None:
        name = _key_name(inner)
        return f"{name}_dot" if name and count == 1 else None
    name = getattr(key, "name", None)
    return name if isinstance(name, str) else None


class Named(Protocol):
    """Values by names, such as a dict, or a Series or DataFrame of pandas."""

    def items(self) -> Iterable[tuple[Any, Any]]:
        """Return names and values."""
        ...


class Numbers(Protocol):
    """An array of NumPy, or what becomes one."""

    def __array__(self, *arguments: Any, **options: Any) -> Any:
        """Return the array."""
        ...


StateLike = Named | Sequence[float] | Numbers
"""Values of states by names or symbols, or in the order of the mechanism's `state_names`."""


def named_state(given: Any, names: Sequence[str], where: str) -> dict[str, Any]:
    """Return the values of states by name; InputError, with the order of names, where it cannot.

    Parameters
    ----------
    given : StateLike
        A mapping or pandas Series (see `by_name`), or a list or array with a number for each name,
        in their order; the last axis of an array of more dimensions is that of the names.
    names : sequence of str
    where : str

    Examples
    --------
    >>> named_state([1.0, 2.0], ("x", "x_dot"), "state")
    {'x': 1.0, 'x_dot': 2.0}
    """
    if type(given) is dict and all(type(name) is str for name in given):
        return given
    if (named := _named(given)) is not None:
        return named
    array = hasattr(given, "__array__") and getattr(given, "ndim", 0) > 0
    if array or isinstance(given, list | tuple):
        rows = list(_last_axis_first(given) if array else given)
        if len(rows) == len(names):
            return dict(zip(names, rows, strict=True))
    raise InputError(
        f"{where}: got {received(given)}, need a mapping of names to numbers, such as "
        f"{{{names[0]!r}: 1.0}}, or {len(names)} numbers in the order {', '.join(names)}."
    )


def _last_axis_first(array: Any) -> Any:
    """Return the entries of an array along its last axis."""
    if array.ndim == 1:
        return array.tolist()
    return [array[..., k] for k in range(array.shape[-1])]


def checked_values(
    where: str,
    kind: str,
    given: Mapping[str, Any],
    defaults: Mapping[str, float],
    unit: Callable[[str], str],
    fault: Callable[[str, float], str | None] = lambda name, value: None,
) -> dict[str, float]:
    """Return a number for every name of the defaults: the given one, else the default.

    A text is a number with a unit, which becomes one in `unit(name)`; `fault` returns a sentence
    where a finite number cannot have its name. InputError for all faults at once, of many the first
    `MAX_FAULTS`, with `where` in front; `kind` is what a name stands for, such as ``parameter``.
    """
    values, faults = dict(defaults), list[str]()
    for name, value in given.items():
        if len(faults) == MAX_FAULTS:
            faults.append("What follows was not checked.")
            break
        if name not in defaults:
            faults.append(unknown_name(kind, name, defaults))
            continue
        if isinstance(value, str):
            value = in_unit(value, unit(name), f"{where}: {kind} {name}")
        values[name], text = checked_number(value, f"{kind} {name}")
        if text and kind == "state" and hasattr(value, "__len__"):
            text += " Fix: arrays of states are for classify_batch and simulate_batch."
        faults += filter(None, [text or fault(name, values[name])])
    if faults:
        raise InputError(f"{where}: " + " ".join(faults))
    return values


def text_of(value: Any, where: str) -> str:
    """Return a text; InputError for anything else."""
    if not isinstance(value, str):
        raise InputError(f"{where}: got {received(value)}, need a text.")
    return value


def names_of(value: Any, where: str, example: str = "theta,mu") -> tuple[str, ...]:
    """Return the names in a text, separated by commas, or in a sequence of texts.

    InputError for anything else.

    >>> names_of("theta, mu", "axes") == names_of(["theta", "mu"], "axes")
    True
    """
    if isinstance(value, str):
        return tuple(name.strip() for name in value.split(",")) if value.strip() else ()
    if isinstance(value, Iterable) and not isinstance(value, Mapping | bytes):
        names = tuple(value)
        if all(isinstance(name, str) for name in names):
            return names
    raise InputError(f"{where}: got {received(value)}, need names, such as {example!r}.")


def split_outside_brackets(text: str) -> tuple[str, ...]:
    """Return the parts of a text between commas that are not in brackets.

    >>> split_outside_brackets("apex, strobe(0.1, 0.02)")
    ('apex', 'strobe(0.1, 0.02)')
    """
    parts, depth = [""], 0
    for letter in text:
        depth += (letter == "(") - (letter == ")")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return tuple(part.strip() for part in parts)


def spatial_mobility_faults(W: Sequence[Sequence[float]], *, definite: bool = False) -> list[str]:
    """Return a sentence where the mobility of a contact in space is not positive semidefinite.

    Its block W_tt has to be positive definite; with `definite` all of W.
    """
    scales = [math.sqrt(max(W[i][i], 0.0)) for i in range(3)]
    if scales[0] == 0.0 and not definite and not any(W[0]):
        # A contact that nothing moves along its normal.
        scales[0] = 1.0
    if min(scales) > 0:
        nn, n1, n2, m1, one, m12, m2, m21, two = (
            w / a / b
            for row, a in zip(W, scales, strict=True)
            for w, b in zip(row, scales, strict=True)
        )
        det = one * two - m12 * m21
        whole = nn * det - n1 * (m1 * two - m12 * m2) + n2 * (m1 * m21 - one * m2)
        uneven = max(abs(n1 - m1), abs(n2 - m2), abs(m12 - m21))
        regular = min(det, whole, nn * one - n1 * m1) > INDEFINITE
        singular = abs(whole) <= INDEFINITE and det > OBLIQUE
        if (regular or (singular and not definite)) and uneven <= SYMMETRY:
            return []
    return [
        f"mobility: got W = {W!r}, need a symmetric positive semidefinite matrix, with W_tt "
        "positive definite or of rank one. Fix: compute it as J M^-1 J' with a positive definite "
        "mass matrix M."
    ]


def mobility_faults(W_nn: float, W_nt: float, W_tn: float, W_tt: float) -> list[str]:
    """Return a sentence where the mobility of one contact is indefinite or not symmetric."""
    # Roots, since products of entries could leave the floating range.
    bound = math.sqrt(max(W_nn, 0.0)) * math.sqrt(max(W_tt, 0.0))
    definite = max(abs(W_nt), abs(W_tn)) <= bound * (1 + INDEFINITE)
    if min(W_nn, W_tt) >= 0 and definite and abs(W_nt - W_tn) <= SYMMETRY * bound:
        return []
    return [
        f"mobility: got W_nn, W_nt, W_tn, W_tt = {W_nn!r}, {W_nt!r}, {W_tn!r}, {W_tt!r}, need a "
        "symmetric positive semidefinite matrix: W_nn >= 0, W_tt >= 0 and W_nt**2 <= W_nn W_tt. "
        "Fix: compute it as J M^-1 J' with a positive definite mass matrix M."
    ]
