"""A contact on a viscous film: F_t = −c v_t."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.automata.automaton import Alternative, Part, Test, Transition
from painleve_sym.automata.compliant import CompliantInterface
from painleve_sym.automata.contact_forces import ContactMotion, Forces, Known, LocalMode
from painleve_sym.automata.interfaces import not_negative


class FilmForces(Forces):
    """Forces of a contact on a film, of which none grows with the normal force."""

    def known_friction(self, normal_force: sp.Expr) -> sp.Expr:
        """Return 0."""
        return sp.Integer(0)


@dataclass(frozen=True)
class FilmInterface(CompliantInterface):
    """A contact on a film, whose law has the parameter `film`."""

    @cached_property
    def forces(self) -> Forces:
        """The law gives F_n, and the film F_t."""
        (c,) = (p.symbol for p in self.law.parameters if p.name.startswith("film"))
        slips = LocalMode(self.closed, Known.GIVEN, Known.GIVEN, gap_moves=True, slip_moves=True)
        film = -c * self.closed * self.row.slip
        return FilmForces(self, (self._flies, slips), **self._of_law, spring_force=film)

    @property
    def part(self) -> Part:
        """It keeps on, whatever the others choose."""
        return self._part(alternatives=(Alternative(not_negative(self.closed)),))

    def _friction_changes(self, motion: ContactMotion) -> list[Transition]:
        return []

    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return none: its forces follow from its state."""
        return []
