"""The numbers of all contacts of a mechanism at a state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from painleve_sym.arrays import Array
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.contacts.contact_states import ContactRow
from painleve_sym.mechanics.contact_set import ContactSet
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
class ContactNumbers:
    """Numbers of the contacts of a mechanism, on the states of its automaton.

    Parameters
    ----------
    mechanism : Mechanism
    states : tuple of sympy.Symbol
        Of the automaton.
    rows : tuple of ContactRow
        States of each contact.
    rigid : tuple of int
        Indices of the rigid contacts.
    """

    mechanism: Mechanism
    states: tuple[sp.Symbol, ...]
    rows: tuple[ContactRow, ...]
    rigid: tuple[int, ...]

    @cached_property
    def _terms(self) -> Quantities:
        system = self.mechanism.system
        symbols = (*self.states, *(p.symbol for p in system.parameters))
        return quantities("terms", self.mechanism.definition, symbols, self._formulas)

    def _formulas(self) -> dict[str, sp.Expr]:
        contacts = ContactSet(self.mechanism)
        velocity = [v for c in contacts for v in (c.gap_rate, c.slip_velocity)]
        matrices = {
            "W": contacts.W,
            "b": contacts.b,
            "directions": contacts.directions,
            "mu": sp.Matrix(contacts.mu),
            "drive_speeds": sp.Matrix(contacts.drive_speeds),
            "velocity": sp.Matrix(velocity),
        }
        return {f"{k}_{i}": e for k, m in matrices.items() for i, e in enumerate(m)}

    def terms(self, state: Array, values: Mapping[str, float]) -> ContactTerms:
        """Return the numbers of the contacts at a state vector."""
        parameters = [values[p.name] for p in self.mechanism.system.parameters]
        numbers = np.array(self._terms.function(np.append(state, parameters))).reshape(-1)
        n, nq = 2 * len(self.rows), len(self.mechanism.system.q)
        sizes = (n * n, n, nq * n, n // 2, n)
        W, b, directions, *rest = np.split(numbers, np.cumsum(sizes))
        W = W.reshape(n, n)
        return ContactTerms((W + W.T) / 2, b, directions.reshape(nq, n), *rest)

    @cached_property
    def _index(self) -> dict[Any, int]:
        return {s: i for i, s in enumerate(self.states)}

    def contact_values(self, state: Array) -> tuple[Array, Array, Array]:
        """Return gaps, gap rates and slip velocities, each of shape (n,)."""
        rows = np.array([[state[self._index[s]] for s in row.symbols] for row in self.rows])
        return rows[:, 0], rows[:, 1], rows[:, 2]
