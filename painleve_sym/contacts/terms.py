"""The numbers of all contacts of a mechanism at a state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.contact_rows import ContactRows
from painleve_sym.contacts.model import StateRow
from painleve_sym.mechanics.mechanism import Mechanism


class ContactTerms(NamedTuple):
    """Numbers of n contacts at one state, in the order n1, t1, n2, t2, ….

    Attributes
    ----------
    W : ndarray, shape (2 n, 2 n)
        1/kg.
    b : ndarray, shape (2 n,)
        m/s².
    directions : ndarray, shape (coordinates, 2 n)
        M⁻¹ Jᵀ.
    mu : ndarray, shape (n,)
    drive_speeds : ndarray, shape (2 n,)
        Of the surfaces; m/s.
    velocity : ndarray, shape (2 n,)
        Of the contacts, from the coordinates' velocities; m/s.
    """

    W: Array
    b: Array
    directions: Array
    mu: Array
    drive_speeds: Array
    velocity: Array


@dataclass(frozen=True)
class ContactImpacts:
    """Numbers of the contacts of a mechanism, on the states of its automaton.

    The rows are the states of each contact.
    """

    mechanism: Mechanism
    states: tuple[str, ...]
    rows: tuple[StateRow, ...]

    @property
    def _at(self) -> ContactRows:
        return ContactRows(len(self.rows))

    @cached_property
    def _terms(self) -> Quantities:
        return quantities("terms", self.mechanism.definition, self._arguments, self._formulas)

    @property
    def _arguments(self) -> tuple[str, ...]:
        return (*self.states, *(p.name for p in self.mechanism.outline.parameters))

    def _symbols(self) -> list[Any]:
        import sympy as sp

        known = {s.name: s for s in self.mechanism.motion}
        symbols = [known.get(s) or sp.Symbol(s, real=True) for s in self.states]
        return symbols + [p.symbol for p in self.mechanism.outline.parameters]

    def _point(self, state: Array, values: Mapping[str, float]) -> list[float]:
        """Return the values of the arguments at a state vector, which more may follow."""
        parameters = [values[p.name] for p in self.mechanism.outline.parameters]
        return [*state[: len(self.states)].tolist(), *parameters]

    def _formulas(self) -> tuple[dict[str, Any], list[Any]]:
        import sympy as sp

        from painleve_sym.mechanics.contact_set import ContactSet

        contacts = ContactSet(self.mechanism)
        velocity = [v for c in contacts for v in (c.gap_rate, c.slip_velocity)]
        matrices = {
            "W": contacts.W,
            "b": contacts.b,
            "directions": contacts.directions,
            "mu": sp.Matrix(contacts.mu),
            "drive_speeds": sp.Matrix(self.mechanism.drive_speeds),
            "velocity": sp.Matrix(velocity),
        }
        every = {f"{k}_{i}": e for k, m in matrices.items() for i, e in enumerate(m)}
        return every, self._symbols()

    def terms(self, state: Array, values: Mapping[str, float]) -> ContactTerms:
        """Return the numbers of the contacts at a state vector, which more may follow."""
        numbers = np.array(self._terms.of_vector(self._point(state, values)))
        n, nq = self._at.size, len(self.mechanism.outline.coordinates)
        sizes = (n * n, n, nq * n, len(self.rows), n)
        W, b, directions, *rest = np.split(numbers, np.cumsum(sizes))
        W = W.reshape(n, n)
        return ContactTerms((W + W.T) / 2, b, directions.reshape(nq, n), *rest)

    @cached_property
    def _index(self) -> dict[str, int]:
        return {s: i for i, s in enumerate(self.states)}

    @cached_property
    def places(self) -> NDArray[np.intp]:
        """Places in the state of gap, gap rate and slip velocity of each contact, shape (n, 3)."""
        return np.array([[self._index[s] for s in row] for row in self.rows])

    @cached_property
    def velocities(self) -> NDArray[np.intp]:
        """Places in the state of v_n, v_t of each contact, shape (2 n,)."""
        return self.places[:, 1:].ravel()

    def contact_values(self, state: Array) -> Array:
        """Return gaps, gap rates and slip velocities, each of shape (n,)."""
        return state[self.places].T
