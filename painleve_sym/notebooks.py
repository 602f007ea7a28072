"""HTML of results in notebooks, and the names that `dir` lists."""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

from painleve_sym.hooks import upper


class Shown:
    """Base of results: HTML in a notebook, and a `dir` of what users may use.

    `present` is loaded when a notebook asks. `_INNER` are names without an underscore that are
    not for users.
    """

    _INNER: ClassVar[tuple[str, ...]] = ()

    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
        text: str = upper("html")(self)
        return text

    def __dir__(self) -> Iterable[str]:
        """Return the names of attributes and methods for users."""
        return [n for n in super().__dir__() if n[0] != "_" and n not in self._INNER]
