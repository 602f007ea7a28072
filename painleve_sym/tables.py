"""Tables as text, Markdown and HTML: a head, and rows of cells below it."""

from __future__ import annotations

import textwrap
import unicodedata
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import zip_longest
from typing import Any

from painleve_sym.escape import html_text


class Html(str):
    """A cell of a table that is HTML already."""


def cell_text(value: Any) -> str:
    """Return the text of a cell, before any marks are escaped: numbers with ten digits."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value + 0.0:.10g}" if isinstance(value, float) else str(value)


def display_width(text: str) -> int:
    """Return how many columns a text takes: a dot above a θ takes none."""
    return sum(1 for c in text if not unicodedata.combining(c))


def text_lines(
    rows: Iterable[Sequence[str]], widths: Sequence[int], left: Collection[int], indent: int = 0
) -> Iterator[str]:
    """Return lines of columns two spaces apart, those in `left` flush left and wrapped."""
    for row in rows:
        cells = [
            textwrap.wrap(c, w, break_on_hyphens=False) or [""] if i in left and len(c) > w else [c]
            for i, (c, w) in enumerate(zip(row, widths, strict=True))
        ]
        for line in zip_longest(*cells, fillvalue=""):
            gaps = [" " * (w - display_width(c)) for c, w in zip(line, widths, strict=True)]
            padded = (c + gaps[i] if i in left else gaps[i] + c for i, c in enumerate(line))
            yield (" " * indent + "  ".join(padded)).rstrip()


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of cells that are Markdown already."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def html_table(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Return a table with a heading row; cells are numbers, text or `Html`."""
    top = "".join(f'<th scope="col">{_html(c)}</th>' for c in head)
    lines = (f"<tr>{''.join(f'<td>{_html(value)}</td>' for value in row)}</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{''.join(lines)}</tbody></table>"


def _html(value: Any) -> str:
    if isinstance(value, Html):
        return value
    text = html_text(cell_text(value))
    if isinstance(value, float):
        mantissa, _, power = text.replace("-", "\u2212").partition("e")
        text = mantissa
        if power:
            sign, digits = power[0].strip("+"), power[1:].lstrip("0")
            text += f"&nbsp;·&nbsp;10<sup>{sign}{digits}</sup>"
    return text
