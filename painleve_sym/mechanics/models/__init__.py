"""Named mechanisms, each with its parameters, units and source."""

from __future__ import annotations

from collections.abc import Callable

from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.mechanism import DomainBound, Mechanism
from painleve_sym.mechanics.models.blocks import block, block_two_feet
from painleve_sym.mechanics.models.discs import eccentric_disc
from painleve_sym.mechanics.models.pendulums import cart_pendulum
from painleve_sym.mechanics.models.robots import pr_robot, two_link_arm
from painleve_sym.mechanics.models.rods import rod, rod_inertia
from painleve_sym.mechanics.models.sliders import painleve_klein
from painleve_sym.mechanics.models.struts import strut

__all__ = ["MODELS", "DomainBound", "Mechanism", "model", "rod"]

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


def model(name: str) -> Mechanism:
    """Return the named mechanism, or the one a mechanism file ending in .toml describes.

    Raises
    ------
    InputError
        Suggests the nearest name; for a file, what is wrong and in which line.
    """
    if name.endswith(".toml"):
        from painleve_sym.mechanics.toml.mechanism_file import load_mechanism

        return load_mechanism(name)
    if name not in MODELS:
        raise InputError(unknown_name("model", name, MODELS))
    return MODELS[name]()
