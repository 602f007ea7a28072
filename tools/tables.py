"""Tables that pages take from numbers, each between ``<!-- NAME -->`` and ``<!-- /NAME -->``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def written(page: str, tables: Mapping[str, str]) -> str:
    """Return the page with each table in its place.

    Raises
    ------
    ValueError
        The place of a table is missing, or there are several.
    """
    for name, text in tables.items():
        mark = re.compile(rf"(<!-- {name} -->\n).*?(<!-- /{name} -->)", re.DOTALL)
        page, count = mark.subn(lambda m, t=text: f"{m[1]}{t}\n{m[2]}", page)
        if count != 1:
            raise ValueError(f"page: got {count} places for the table {name!r}, need one.")
    return page
