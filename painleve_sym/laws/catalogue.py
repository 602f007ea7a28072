"""The named contact laws, compliant and rigid."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from painleve_sym.errors import InputError, unknown_name
from painleve_sym.laws.compliance import (
    ContactLaw,
    bilinear_hertz,
    hertz,
    hunt_crossley,
    linear,
)
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.laws.rigid import POLICIES, RigidLaw

COMPLIANT_LAWS: Mapping[str, Callable[..., ContactLaw]] = {
    "bilinear-hertz": bilinear_hertz,
    "bilinear-hertz-two-bodies": partial(bilinear_hertz, bodies=2),
    "hertz": hertz,
    "linear": linear,
    "hunt-crossley": hunt_crossley,
}
"""Laws of contacts that yield, by name."""

LAWS = (*COMPLIANT_LAWS, RigidLaw.name)
"""Names that `law` knows."""

CHOICES: Mapping[str, tuple[str, ...]] = {
    "reload": ("elastic", "virgin"),
    "restitution": tuple(RESTITUTIONS),
    "policy": POLICIES,
}
"""Every named choice of a contact law and its values."""


def law(name: str, **choices: str) -> ContactLaw | RigidLaw:
    """Return the named contact law, rigid or compliant.

    Parameters
    ----------
    name : str
        One of `LAWS`.
    **choices : str
        Named choices of the law, such as ``reload="virgin"``; see `CHOICES`.

    Raises
    ------
    InputError
        Unknown name, a choice that the law does not have, or a value it cannot have.
    """
    if name not in LAWS:
        raise InputError(unknown_name("contact law", name, LAWS))
    if name in COMPLIANT_LAWS:
        return compliant_law(name, **choices)
    _check_choices(name, choices, RigidLaw().choices)
    return RigidLaw(**choices)


def compliant_law(name: str, **choices: str) -> ContactLaw:
    """Return the named law of a contact that yields; see `law`."""
    if name not in COMPLIANT_LAWS:
        raise InputError(unknown_name("contact law", name, COMPLIANT_LAWS))
    _check_choices(name, choices, ["reload"] if name.startswith("bilinear-hertz") else [])
    return COMPLIANT_LAWS[name](**choices)


def _check_choices(
    name: str, given: Mapping[str, str], known: Mapping[str, str] | list[str]
) -> None:
    for key in given:
        if key not in known:
            raise InputError(f"law {name!r}: " + unknown_name("choice", key, known))
