"""Named mechanisms, each with its parameters, units and source."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path

from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.mechanism import DomainBound, Mechanism
from painleve_sym.mechanics.models.blocks import block, block_two_feet
from painleve_sym.mechanics.models.discs import eccentric_disc
from painleve_sym.mechanics.models.pendulums import cart_pendulum
from painleve_sym.mechanics.models.robots import pr_robot, two_link_arm
from painleve_sym.mechanics.models.rods import rod, rod_inertia
from painleve_sym.mechanics.models.sliders import painleve_klein
from painleve_sym.mechanics.models.struts import strut

__all__ = ["MODELS", "DomainBound", "Mechanism", "MechanismLike", "as_mechanism", "model", "rod"]

MODELS: dict[str, Callable[[], Mechanism]] = {
    "rod": rod,
    "rod-inertia": rod_inertia,
    "block": block,
    "block-two-feet": block_two_feet,
    "eccentric-disc": eccentric_disc,
    "cart-pendulum": cart_pendulum,
    "two-link-arm": two_link_arm,
    "pr-robot": pr_robot,
    "strut": strut,
    "painleve-klein": painleve_klein,
}


MechanismLike = Mechanism | str | Path
"""A mechanism, its name, or the path of a mechanism file."""


def model(name: str | Path, **parameters: float) -> Mechanism:
    """Return the named mechanism, or the one a mechanism file ending in .toml describes.

    Parameters
    ----------
    name : str or path
        A named mechanism is made once.
    **parameters : float
        Other defaults of its parameters; see `Mechanism.with_parameters`.

    Raises
    ------
    InputError
        Suggests the nearest name; for a file, what is wrong and in which line.

    Examples
    --------
    >>> from painleve_sym import model
    >>> model("rod", mu=1.5).parameters["mu"]
    1.5
    """
    chosen = _built_in(str(name))
    return chosen.with_parameters(**parameters) if parameters else chosen


def as_mechanism(given: MechanismLike) -> Mechanism:
    """Return the mechanism itself, or the one of that name or file; see `model`."""
    if isinstance(given, Mechanism):
        return given
    if isinstance(given, str | Path):
        return model(given)
    raise InputError(f"mechanism: got {type(given).__name__}, need a mechanism, a name or a file.")


def _built_in(name: str) -> Mechanism:
    if name.endswith(".toml"):
        from painleve_sym.mechanics.toml.mechanism_file import load_mechanism

        return load_mechanism(name)
    if name not in MODELS:
        raise InputError(unknown_name("model", name, MODELS))
    return _named(name)


@functools.cache
def _named(name: str) -> Mechanism:
    return MODELS[name]()
