"""Named mechanisms, each with its parameters, units and source."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from painleve_sym.mechanics.mechanism import Mechanism


def _imported(module: str, function: str, *counts: int) -> Mechanism:
    home = importlib.import_module(f"{__name__}.{module}")
    mechanism: Mechanism = getattr(home, function)(*counts)
    return mechanism


MODELS: Mapping[str, Callable[..., Mechanism]] = {
    "rod": partial(_imported, "rods", "rod"),
    "rod-inertia": partial(_imported, "rods", "rod_inertia"),
    "rod-bending": partial(_imported, "rods", "rod_bending"),
    "block": partial(_imported, "blocks", "block"),
    "block-two-feet": partial(_imported, "blocks", "block_two_feet"),
    "eccentric-disc": partial(_imported, "discs", "eccentric_disc"),
    "cart-pendulum": partial(_imported, "pendulums", "cart_pendulum"),
    "two-link-arm": partial(_imported, "robots", "two_link_arm"),
    "pr-robot": partial(_imported, "robots", "pr_robot"),
    "strut": partial(_imported, "struts", "strut"),
    "painleve-klein": partial(_imported, "sliders", "painleve_klein"),
}
"""Named planar mechanisms: functions that make them; see `codegen.named_mechanisms.model`."""

SPATIAL_MODELS: Mapping[str, Callable[..., Mechanism]] = {
    "rod-3d": partial(_imported, "spatial", "rod_3d"),
    "top": partial(_imported, "spatial", "top"),
    "brick": partial(_imported, "spatial", "brick"),
    "slider-3d": partial(_imported, "spatial", "slider_3d"),
    "two-link-arm-3d": partial(_imported, "spatial", "two_link_arm_3d"),
}
"""Named mechanisms in space."""


def _of_file(name: str) -> Mechanism:
    from painleve_sym.mechanics.toml.mechanism_file import load_mechanism

    return load_mechanism(Path(__file__).parent / "everyday" / f"{name}.toml")


_EVERYDAY = (
    *("drawer", "ladder", "door", "chalk", "drum-brake", "sprag", "lead-screw", "wheelbarrow"),
    *("ball-on-slope", "slider-crank", "rocking-block", "newtons-cradle"),
)
EVERYDAY: Mapping[str, Callable[..., Mechanism]] = {n: partial(_of_file, n) for n in _EVERYDAY}
"""Named mechanisms of everyday life, each a mechanism file."""

NAMED: Mapping[str, Callable[..., Mechanism]] = {**MODELS, **SPATIAL_MODELS, **EVERYDAY}
"""All named mechanisms."""

COUNTS: Mapping[str, tuple[str, ...]] = {"rod-bending": ("bending modes", "axial modes")}
"""What may be counted in a model, as in ``rod-bending:5,3``: whole numbers from 0."""
