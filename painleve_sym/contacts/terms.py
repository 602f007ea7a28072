"""The numbers of all contacts of a mechanism at a state, and their impacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.contact_rows import ContactRows
from painleve_sym.contacts.impact.one_contact import ImpactEnd
from painleve_sym.contacts.impact.simultaneous import PathRecord, solve_simultaneous_impact
from painleve_sym.contacts.model import CONTACT_LOSS, FORCE_LOSS, FRICTION_LOSS, StateRow
from painleve_sym.mechanics.mechanism import Mechanism

TOUCHING = 1e-10
"""Of the scale of a gap and of its rate: contacts that touch down together do so to this part."""
_ROUNDING = 1e-12
"""Of the sum of the terms of a velocity: less is rounding."""


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


class ImpactResult(NamedTuple):
    """An impact and the state after it.

    Attributes
    ----------
    impulses : ndarray, shape (2 n,)
        P_n, P_t of every contact of the mechanism; N s.
    state : ndarray, shape (nx,)
    contacts : tuple of int
        Those that took part.
    path : PathRecord
        Of these contacts.
    """

    impulses: Array
    state: Array
    contacts: tuple[int, ...]
    path: PathRecord


@dataclass(frozen=True)
class ContactImpacts:
    """Impacts of the rigid contacts of a mechanism, on the states of its automaton.

    The rows are the states of each contact; `rigid` are the indices of the contacts that take part
    in impacts.
    """

    mechanism: Mechanism
    states: tuple[str, ...]
    rows: tuple[StateRow, ...]
    rigid: tuple[int, ...]

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

    def collides(self, state: Array) -> bool:
        """Return whether a closed rigid contact approaches."""
        gaps, rates, _ = state[self.places[list(self.rigid)]].T
        return bool(np.any((gaps <= 0) & (rates < 0)))

    def touching(self, state: Array, scale: Array, values: Mapping[str, float]) -> Array:
        """Return the state with gaps that close at the same instant, but for rounding, as 0.

        Those that seem to open by rounding alone rest.

        Both arrays, the state and the scale of each, have the shape (nx,); `values` are the
        parameters.
        """
        rigid = np.array(self.rigid)
        after, (gaps, rates, _) = state.copy(), self.places[rigid].T
        near = np.abs(state[gaps]) <= TOUCHING * scale[gaps]
        near &= state[rates] <= TOUCHING * scale[rates]
        after[gaps[near]] = 0.0
        self._book_loss(state, after, values)
        opening = rigid[near & (state[rates] > 0)].tolist()
        return self.closed(after, values, opening) if opening else after

    def _book_loss(self, before: Array, after: Array, values: Mapping[str, float]) -> None:
        """Book the energy that `after` lacks as lost in contacts."""
        if (before == after).all():
            return
        then, now = (sum(self._energy.of_vector(self._point(x, values))) for x in (before, after))
        after[self._index[CONTACT_LOSS]] += then - now

    @cached_property
    def _energy(self) -> Quantities:
        def derive() -> tuple[dict[str, Any], list[Any]]:
            system = self.mechanism.system
            return {"T": system.kinetic_energy, "V": system.potential_energy}, self._symbols()

        return quantities("energy", self.mechanism.definition, self._arguments, derive)

    def short_bounces(self, state: Array, values: Mapping[str, float], time: float) -> list[int]:
        """Return the rigid contacts that leave and would be back within `time`; s."""
        gaps, rates, _ = self.contact_values(state)
        leaving = [i for i in self.rigid if gaps[i] <= 0 and rates[i] > 0]
        if not leaving:
            return []
        falls = -self.terms(state, values).b[self._at.normals]
        return [i for i in leaving if 2 * rates[i] < time * falls[i]]

    def closing(self, state: Array, contacts: Sequence[int]) -> list[int]:
        """Return contacts that close, with those at rest."""
        gaps, rates, _ = self.contact_values(state)
        resting = [i for i in self.rigid if gaps[i] <= 0 and rates[i] == 0]
        return sorted({*contacts, *resting})

    def closing_rows(self, state: Array, terms: ContactTerms, contacts: Sequence[int]) -> list[int]:
        """Return the rows of the velocities that closing contacts makes vanish.

        All normal ones, and the slip velocity of a contact with friction that the normal impulses
        alone would start or turn: it sticks. So no energy is added.
        """
        _, _, slips = self.contact_values(state)
        normals = [self._at.normal(i) for i in contacts]
        alone = _least_norm(terms.W, normals, -terms.velocity[normals])
        change = np.abs(terms.W @ alone)[self._at.tangentials]
        stick = [i for i in contacts if terms.mu[i] > 0 and abs(slips[i]) <= change[i] != 0]
        return sorted([*normals, *map(self._at.tangent, stick)])

    def closed(self, state: Array, values: Mapping[str, float], contacts: Sequence[int]) -> Array:
        """Return the state with contacts closed: gap and normal velocity 0, by impulses.

        They are those whose gap and normal velocity are all but 0. Those at rest stay closed with
        them, guides too. The others move as the coordinates do, whose velocities are what stops.
        `values` are the parameters.
        """
        contacts, terms = self.closing(state, contacts), self.terms(state, values)
        rows = self.closing_rows(state, terms, contacts)
        impulses = _least_norm(terms.W, rows, -terms.velocity[rows])
        together = state.copy()
        together[self.places[contacts, 0]] = 0.0
        self._book_loss(state, together, values)
        after = self._pushed(together, terms, impulses)
        works = impulses * terms.velocity / 2
        after[self._index[CONTACT_LOSS]] -= works[self._at.normals].sum()
        after[self._index[FRICTION_LOSS]] -= works[self._at.tangentials].sum()
        others = self._at.of_contacts([i for i in self.rigid if i not in contacts])
        moved = np.column_stack([terms.velocity, terms.W * impulses])[others]
        resolved = np.abs(moved.sum(axis=1)) > _ROUNDING * np.abs(moved).sum(axis=1)
        after[self.velocities[others]] = np.where(resolved, moved.sum(axis=1), 0.0)
        after[self.velocities[rows]] = 0.0
        return after

    def _pushed(self, state: Array, terms: ContactTerms, impulses: Array) -> Array:
        """Return the state with the velocities after impulses, and the work of the drives."""
        after, n = state.copy(), len(self.mechanism.outline.coordinates)
        after[n : n + n] += terms.directions @ impulses
        # Last, since a generalised velocity may be that of a contact.
        after[self.velocities] = state[self.velocities] + terms.W @ impulses
        if FORCE_LOSS in self._index:
            after[self._index[FORCE_LOSS]] -= terms.drive_speeds @ impulses
        return after

    def impact(
        self, state: Array, values: Mapping[str, float], restitution: str, e: float
    ) -> ImpactResult | None:
        """Return the impact of the closed rigid contacts; None where it jams."""
        gaps, rates, _ = self.contact_values(state)
        closed = [i for i in self.rigid if gaps[i] <= 0 and rates[i] <= 0]
        terms, rows = self.terms(state, values), self._at.of_contacts(closed)
        at = self.velocities[rows]
        W, mu = terms.W[np.ix_(rows, rows)], terms.mu[closed]
        bilateral = np.array([self.mechanism.outline.contacts[i].bilateral for i in closed])
        impact = solve_simultaneous_impact(
            W, mu, state[at], restitution, e, load=terms.b[rows], bilateral=bilateral
        )
        if impact.end is ImpactEnd.JAM:
            return None
        impulses = np.zeros(len(self.velocities))
        impulses[rows] = impact.impulses
        after = self._pushed(state, terms, impulses)
        # What the impact made vanish is exactly 0.
        after[at] = impact.velocities
        after[self._index[CONTACT_LOSS]] -= impact.normal_work
        after[self._index[FRICTION_LOSS]] -= impact.tangential_work
        return ImpactResult(impulses, after, tuple(closed), impact.path)


def _least_norm(W: Array, rows: Sequence[int], change: Array) -> Array:
    """Return the impulses (2 n) in these rows, of least norm, that change the velocities there."""
    impulses = np.zeros(len(W))
    impulses[rows] = np.linalg.lstsq(W[np.ix_(rows, rows)], change, rcond=1e-12)[0]
    return impulses
