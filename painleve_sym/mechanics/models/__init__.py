"""Named mechanisms, each with its parameters, units and source."""

from __future__ import annotations

import importlib
import tomllib
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

    return load_mechanism(_path_of(name))


def _path_of(name: str) -> Path:
    return Path(__file__).parent / "everyday" / f"{name}.toml"


_EVERYDAY = (
    *("drawer", "ladder", "door", "chalk", "drum-brake", "sprag", "lead-screw", "wheelbarrow"),
    *("ball-on-slope", "slider-crank", "rocking-block", "newtons-cradle", "woodpecker"),
    "block-on-belt",
)
EVERYDAY: Mapping[str, Callable[..., Mechanism]] = {n: partial(_of_file, n) for n in _EVERYDAY}
"""Named mechanisms of everyday life, each a mechanism file."""

NAMED: Mapping[str, Callable[..., Mechanism]] = {**MODELS, **SPATIAL_MODELS, **EVERYDAY}
"""All named mechanisms."""

TITLES: Mapping[str, str] = {
    "rod": "slender rod with one end on rough ground (Painlevé's example)",
    "rod-inertia": "rod of any moment of inertia with one end on rough ground",
    "rod-bending": "elastic round bar with one end on rough ground",
    "block": "rectangular block on one corner on a slope",
    "block-two-feet": "block sliding on two feet on a slope",
    "eccentric-disc": "disc with its mass centre off the middle, on rough ground",
    "cart-pendulum": "pendulum on a cart sliding on rough ground",
    "two-link-arm": "two-link arm with its tip on a moving belt",
    "pr-robot": "prismatic-revolute robot sliding its tip along the ground",
    "strut": "pivoted strut pressed onto a moving surface (chalk, sprag)",
    "painleve-klein": "two blocks in parallel guides joined by a rod (Painlevé and Klein)",
    "rod-3d": "rod in space with one end on rough ground",
    "top": "symmetric top with its tip on rough ground",
    "brick": "brick with one corner on rough ground",
    "slider-3d": "carriage on a plane that drags a rod over the ground",
    "two-link-arm-3d": "arm of two links on a turning base with its tip on the ground",
}
"""What each of them is; those of everyday life say it in their files."""


def title_of(name: str) -> str:
    """Return the title of a named mechanism, which is not made for it."""
    if name in TITLES:
        return TITLES[name]
    with _path_of(name).open("rb") as file:
        title: str = tomllib.load(file)["title"]
    return title


COUNTS: Mapping[str, tuple[str, ...]] = {"rod-bending": ("bending modes", "axial modes")}
"""What may be counted in a model, as in ``rod-bending:5,3``: whole numbers from 0."""
