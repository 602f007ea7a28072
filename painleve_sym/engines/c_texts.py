"""The hand-written C of the engines, file by file, and arrays in C."""

from __future__ import annotations

import math
from collections.abc import Iterable
from importlib import resources


def engine_texts(*parts: str) -> list[str]:
    """Return the hand-written C files of the engines, each named by folder and base name."""
    folder = resources.files("painleve_sym.engines")
    return [folder.joinpath(f"{part}.c").read_text("utf-8") for part in parts]


def number_text(value: float) -> str:
    """Return a number in C that reads as the same bits; infinity and NaN by names of math.h."""
    if math.isfinite(value):
        return repr(float(value))
    return "NAN" if math.isnan(value) else f"({'-' if value < 0 else ''}INFINITY)"


def initializer(values: Iterable[object]) -> str:
    """Return the initialiser of an array of C: its values, or 0 without any."""
    return f"{{{', '.join(map(str, values)) or '0'}}}"
