"""Fonts that have the letters of a text, in whatever script it is written."""

from __future__ import annotations

import functools
import warnings
from typing import Any

from matplotlib.font_manager import FontProperties, findfont, fontManager, get_font
from matplotlib.textpath import TextPath

from painleve_sym.errors import PainleveWarning

FAMILY = "STIXGeneral"
"""It comes with matplotlib and looks like a journal's text: the same on every machine."""


def make_legible(text: Any) -> None:
    """Give a text a font that has its letters; a letter that no font has becomes "?".

    PainleveWarning names the letters that no installed font has.
    """
    words = text.get_text()
    own = _letters(findfont(FAMILY))
    if all(ord(c) in own for c in words if c != "\n"):
        return
    family, letters = _best_font(frozenset(words))
    # A text with formulas has one font for its words, others fall back on the style's.
    kept = letters if "$" in words else letters | own
    lost = sorted({c for c in words if c != "\n" and ord(c) not in kept})
    text.set_fontfamily([family, FAMILY])
    if lost:
        shown = ", ".join(f"{c!r} (U+{ord(c):04X})" for c in lost)
        warnings.warn(
            f"figure: no installed font has {shown}; drawn as '?'. "
            "Fix: install a font for this script, such as Noto.",
            PainleveWarning,
            stacklevel=2,
        )
        text.set_text("".join("?" if c in lost else c for c in words))


@functools.cache
def _letters(path: str) -> frozenset[int]:
    return frozenset(get_font(path).get_charmap())


@functools.cache
def _best_font(letters: frozenset[str]) -> tuple[str, frozenset[int]]:
    """Return the family, and letters, of the installed font with most of the letters."""
    wanted = {ord(c) for c in letters}
    fonts = {
        entry.name: _letters(entry.fname)
        for entry in sorted(fontManager.ttflist, key=lambda e: (e.name, e.fname))
        # Matplotlib's font of last resort has a box for every letter.
        if entry.style == "normal" and entry.weight == 400 and "last" not in entry.name.lower()
    }
    name = max(fonts, key=lambda family: len(wanted & fonts[family]))
    return name, fonts[name]


def text_width(text: str, size: float) -> float:
    """Return the width of a text of this size in points; inch."""
    own = _letters(findfont(FAMILY))
    known = "".join(c if ord(c) in own else "M" for c in text)
    font = FontProperties(family=FAMILY, size=size)
    return float(TextPath((0, 0), known, prop=font).get_extents().width) / 72 if known else 0.0
