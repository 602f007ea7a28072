"""Places of the rows of contacts in W, b, velocities, accelerations and forces.

The rows of each contact stand together, its normal one before its tangential ones. The macros of
``engines/loop/rows.c`` say the same in C.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from typing import NamedTuple


def axis_names(n_tangents: int) -> tuple[str, ...]:
    """Return the names of the rows of one contact: n, t of one tangent; n, t1, t2, ... of several.

    >>> axis_names(1), axis_names(2)
    (('n', 't'), ('n', 't1', 't2'))
    """
    return ("n", "t") if n_tangents == 1 else ("n", *(f"t{k + 1}" for k in range(n_tangents)))


class ContactRows(NamedTuple):
    """Rows of n contacts, each with one normal and `n_tangents` tangential directions.

    Parameters
    ----------
    n_contacts : int
        How many contacts there are.
    n_tangents : int
        Tangential directions of a contact: 1 in the plane.

    Examples
    --------
    >>> rows = ContactRows(2)
    >>> rows.size, rows.normal(1), list(rows.tangents(1))
    (4, 2, [3])
    >>> forces = [10.0, -1.0, 20.0, 3.0]
    >>> forces[rows.normals], forces[rows.tangentials]
    ([10.0, 20.0], [-1.0, 3.0])
    """

    n_contacts: int
    n_tangents: int = 1

    @property
    def _axes(self) -> int:
        return 1 + self.n_tangents

    @property
    def size(self) -> int:
        """The number of all rows."""
        return self._axes * self.n_contacts

    def row(self, i: int, axis: int) -> int:
        """Return the row of contact i along an axis: 0 normal, from 1 tangential."""
        return self._axes * i + axis

    def normal(self, i: int) -> int:
        """Return the normal row of contact i."""
        return (1 + self.n_tangents) * i

    def tangent(self, i: int, k: int = 0) -> int:
        """Return the row of contact i along its tangential direction k."""
        return self.row(i, 1 + k)

    def tangents(self, i: int) -> range:
        """Return the tangential rows of contact i."""
        return range(self.tangent(i), self.normal(i + 1))

    def of(self, i: int) -> slice:
        """Return all rows of contact i."""
        return slice(self.normal(i), self.normal(i + 1))

    def block(self, i: int, j: int) -> tuple[slice, slice]:
        """Return rows and columns of W by which the forces of contact j act on contact i."""
        return self.of(i), self.of(j)

    def along(self, axis: int) -> slice:
        """Return the rows of all contacts along an axis."""
        return slice(axis, self.size, self._axes)

    @property
    def normals(self) -> slice:
        """The normal rows of all contacts."""
        return self.along(0)

    @property
    def tangentials(self) -> slice:
        """The rows of all contacts along their first tangential direction."""
        return self.along(1)

    @functools.lru_cache(maxsize=64)  # noqa: B019 - a few small values
    def each(self) -> tuple[tuple[int, ...], ...]:
        """Return the rows of each contact, the normal one first."""
        starts = map(self.normal, range(self.n_contacts))
        return tuple(tuple(range(start, start + self._axes)) for start in starts)

    def of_contacts(self, contacts: Iterable[int]) -> list[int]:
        """Return the rows of some contacts, in their order."""
        return [self.row(i, axis) for i in contacts for axis in range(self._axes)]

    def contact(self, row: int) -> int:
        """Return the contact of a row."""
        return row // self._axes

    def is_normal(self, row: int) -> bool:
        """Return whether a row is a normal one."""
        return row % self._axes == 0
