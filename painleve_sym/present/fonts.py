"""Fonts that have the letters of a text, in whatever script it is written."""

from __future__ import annotations

import functools
import warnings
from typing import Any

from matplotlib.cbook import is_math_text
from matplotlib.font_manager import FontProperties, findfont, fontManager, get_font
from matplotlib.textpath import text_to_path

from painleve_sym.errors import PainleveWarning

FAMILY = "STIXGeneral"
"""It comes with matplotlib and looks like a journal's text: the same on every machine."""


def make_legible(text: Any) -> None:
    """Give a text a font that has its letters; a letter that no font has becomes "?".

    PainleveWarning names the letters that no installed font has.
    """
    words, own = text.get_text(), _letters(findfont(FAMILY))
    letters = frozenset(map(ord, words)) - {ord("\n")}
    if letters <= own:
        return
    family, others = _best_font(letters - own)
    # A text with formulas has one font for its words, others fall back on the style's.
    formulas = words.count("$") > words.count(r"\$")
    lost = letters - (others if formulas else others | own)
    if len(lost) < len(letters - own):
        text.set_fontfamily([family, FAMILY])
    else:
        lost = letters - own
    if lost:
        shown = ", ".join(f"{chr(c)!r} (U+{c:04X})" for c in sorted(lost))
        warnings.warn(
            f"figure: no installed font has {shown}; drawn as '?'. "
            "Fix: install a font for this script, such as Noto.",
            PainleveWarning,
            stacklevel=2,
        )
        text.set_text("".join("?" if ord(c) in lost else c for c in words))


def is_foreign(text: str) -> bool:
    """Return whether a text has letters that the font of figures lacks."""
    return not set(map(ord, text)) <= _letters(findfont(FAMILY))


@functools.cache
def _letters(path: str) -> frozenset[int]:
    return frozenset(get_font(path).get_charmap())


@functools.cache
def _best_font(wanted: frozenset[int]) -> tuple[str, frozenset[int]]:
    """Return family and letters of the installed font with most of the letters wanted."""
    fonts = {
        entry.name: _letters(entry.fname)
        for entry in sorted(fontManager.ttflist, key=lambda e: (e.name, e.fname))
        # Matplotlib's font of last resort has a box for every letter.
        if entry.style == "normal" and entry.weight == 400 and "last" not in entry.name.lower()
    }
    name = max(fonts, key=lambda family: (len(wanted & fonts[family]), len(fonts[family])))
    return name, fonts[name]


def text_width(text: str, size: float) -> float:
    """Return the width of a text of this size in points; inch."""
    own = _letters(findfont(FAMILY))
    drawable = "".join(c if ord(c) in own else "M" for c in text)
    has_formulas = bool(is_math_text(drawable))
    written = drawable if has_formulas else drawable.replace(r"\$", "$")
    font = FontProperties(family=FAMILY, size=size)
    return float(text_to_path.get_text_width_height_descent(written, font, has_formulas)[0]) / 72
