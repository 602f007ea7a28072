"""Tables that pages take from numbers, each between ``<!-- NAME -->`` and ``<!-- /NAME -->``."""

from __future__ import annotations

import re
from collections.abc import Mapping


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
