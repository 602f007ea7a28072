"""Values in other units than SI: a number and a unit as text, converted by pint."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Mapping
from typing import Any

from painleve_sym.errors import InputError, shortened

Value = float | str
"""A number in SI units and rad, or a text with its unit, such as ``30 deg``."""

_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_POWER = r"(?:(?:\^|\*\*)-?[0-9])?"
_UNIT = rf"[A-Za-zμμ°]{{1,30}}{_POWER}(?:(?:[ ]?[*/·][ ]?|[ ])(?:[A-Za-zμμ°]{{1,30}}{_POWER}|1))*"
_UNIT_TEXT = re.compile(rf"(?:1[ ]?/[ ]?)?{_UNIT}|1")
_QUANTITY_TEXT = re.compile(rf"({_NUMBER})[ ]*({_UNIT})")
_LONGEST = 100
_INSTALL = "Fix: pip install 'painleve-sym[units]', or give the number in"


def is_quantity(text: str) -> bool:
    """Whether a text is a number with a unit, such as ``30 deg``."""
    return len(text) <= _LONGEST and _QUANTITY_TEXT.fullmatch(text.strip()) is not None


def in_unit(text: str, unit: str, name: str) -> float:
    """Return a number with its unit, such as ``30 deg`` or ``5 mm/s``, in the SI unit needed.

    Units are products of names with whole exponents. Nothing else reaches pint, whose own texts are
    expressions. The unit ``1`` stands for none; messages call the value `name`.

    Raises
    ------
    InputError
        Another text, a unit that is unknown or of another dimension, no pint for another unit.

    Examples
    --------
    >>> in_unit("200 g", "kg", "m")
    0.2
    """
    match = _QUANTITY_TEXT.fullmatch(text.strip()) if len(text) <= _LONGEST else None
    if match is None:
        raise InputError(
            f"{name}: got {shortened(repr(text))}, need a number in {_named(unit)}, or a number "
            "with a unit, such as '30 deg'."
        )
    number, own = match.groups()
    value = _converted(float(number), own, unit, name)
    if not math.isfinite(value):
        raise InputError(f"{name}: got {text!r}, need a finite number.")
    return value


def in_si(given: Mapping[str, Any], units: Mapping[str, str], where: str) -> dict[str, Any]:
    """Return the values with texts read in the unit of their name; see `in_unit`.

    Names without a unit are left to those which know them all.

    Examples
    --------
    >>> in_si({"theta": "180 deg", "mu": 0.5}, {"theta": "rad"}, "state")["mu"]
    0.5
    """
    return {
        name: in_unit(value, units[name], f"{where}: {name}")
        if isinstance(value, str) and name in units
        else value
        for name, value in given.items()
    }


def factor(own: str, unit: str, name: str) -> float:
    """Return how many of `unit` one `own` is; see `in_unit`.

    Examples
    --------
    >>> factor("mm/s", "m/s", "x_dot")
    0.001
    """
    if own != unit and (len(own) > _LONGEST or _UNIT_TEXT.fullmatch(own) is None):
        raise InputError(f"{name}: got the unit [{shortened(own)}], need [{unit}].")
    return _converted(1.0, own, unit, name)


_SI = re.compile(r"(?:m|s|kg|rad|N|Pa|J|W|1)(?:[ ]?[/*·][ ]?(?:m|s|kg|rad|N)(?:\^[0-9])?)*")


def si_factor(own: str, name: str) -> float:
    """Return how many units of SI and rad a unit is; no unit, ``-`` and ``1`` are 1.

    Raises
    ------
    InputError
        An unknown unit, one with a zero of its own, or no pint for one that is not of SI.

    Examples
    --------
    >>> si_factor("mm", "height"), si_factor("", "height")
    (0.001, 1.0)
    """
    if own in ("", "-") or _SI.fullmatch(own):
        return 1.0
    wrong = InputError(f"{name}: got the unit [{shortened(own)}], need one such as [m] or [ms].")
    if len(own) > _LONGEST or _UNIT_TEXT.fullmatch(own) is None:
        raise wrong
    try:
        registry = _registry()
    except ImportError:
        raise InputError(
            f"{name}: got the unit [{own}], and units other than those of SI need pint. "
            f"{_INSTALL} SI units."
        ) from None
    import pint

    try:
        unit = registry.parse_units(_pint_text(own))
        if registry.Quantity(0.0, unit).to_base_units().magnitude != 0:
            raise wrong
        return float(registry.Quantity(1.0, unit).to_base_units().magnitude)
    except (pint.PintError, ArithmeticError, ValueError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise wrong from error


def _converted(value: float, own: str, unit: str, name: str) -> float:
    if own == unit:
        return value
    try:
        registry = _registry()
    except ImportError:
        raise InputError(
            f"{name}: got the unit [{own}], and units other than [{unit}] need pint. "
            f"{_INSTALL} {_named(unit)}."
        ) from None
    import pint

    wrong = InputError(f"{name}: got the unit [{own}], need [{unit}] or a unit of its kind.")
    try:
        given, needed = (registry.parse_units(_pint_text(u)) for u in (own, unit))
        # A radian counts as a unit here, so that a frequency in Hz is not an angular velocity.
        kinds = [registry.get_base_units(u, check_nonmult=False)[1] for u in (given, needed)]
        # Degrees Celsius and decibels have a zero of their own.
        if kinds[0] != kinds[1] or registry.Quantity(0.0, given).to(needed).magnitude != 0:
            raise wrong
        return float(registry.Quantity(value, given).to(needed).magnitude)
    except (pint.PintError, ArithmeticError, ValueError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise wrong from error


def _pint_text(unit: str) -> str:
    text = re.sub(r"[ ]*([*/·])[ ]*", r"\1", unit).replace("·", "*").replace(" ", "*")
    return "dimensionless" if text == "1" else text.replace("^", "**").replace("°", "deg")


def _named(unit: str) -> str:
    return unit if unit != "1" else "no unit"


@functools.cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(cache_folder=None)
