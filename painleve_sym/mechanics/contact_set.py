"""The contacts of a mechanism together: Jacobian, mobility, free accelerations, friction."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.mechanism import Mechanism


@dataclass(frozen=True)
class ContactSet:
    """Accelerations of all contacts of a mechanism: a = W F + b, rows n1, t1, n2, t2, ….

    The entries are as they come, unsimplified: they are meant for generated code. The closed forms
    of one contact are its `ContactCoefficients`.
    """

    mechanism: Mechanism

    def __iter__(self) -> Iterator[Contact]:
        return iter(self.mechanism.contacts)

    def __len__(self) -> int:
        return len(self.mechanism.contacts)

    @cached_property
    def J(self) -> sp.Matrix:
        """Jacobian of gaps and slip displacements, shape (2 n, number of coordinates)."""
        return sp.Matrix.vstack(*[c.J for c in self])

    @cached_property
    def directions(self) -> sp.Matrix:
        """M⁻¹ Jᵀ: accelerations of the coordinates per unit force, shape (coordinates, 2 n)."""
        return self.mechanism.system.inverse_mass_matrix * self.J.T

    @cached_property
    def W(self) -> sp.Matrix:
        """Mobility J M⁻¹ Jᵀ, shape (2 n, 2 n); 1/kg."""
        return self.J * self.directions

    @cached_property
    def b(self) -> sp.Matrix:
        """Accelerations of the contacts without contact forces, shape (2 n, 1); m/s²."""
        free = self.J * self.mechanism.system.free_acceleration
        return free + sp.Matrix.vstack(*[c.biases for c in self])

    @property
    def mu(self) -> tuple[sp.Symbol, ...]:
        """Friction coefficients."""
        return tuple(c.mu for c in self)
