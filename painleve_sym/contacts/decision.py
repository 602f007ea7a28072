"""What two rigid contacts do next: the contact problem of both at a state, and impacts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from painleve_sym.arrays import Array
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.contacts.contact_states import CONTACT_WORK, FLIGHT, FORCE_WORK, FRICTION_WORK
from painleve_sym.contacts.impact.one_contact import ImpactEnd
from painleve_sym.contacts.impact.simultaneous import solve_simultaneous_impact
from painleve_sym.contacts.local_mode import ContactMode
from painleve_sym.contacts.problem import ContactProblem, ContactSolution
from painleve_sym.contacts.two_contacts import TwoContacts, mode_name

_REST = 1e-9
"""Of the scale of a velocity: what counts as zero when an event decides."""
_TOUCH = 1e-10
"""Of the scale of a gap: contacts that touch down together do so to rounding."""
_STILL = 1e-9
"""Of the terms of an acceleration: a contact at rest that moves less sticks."""


@dataclass(frozen=True)
class ContactTerms:
    """Numbers of all contacts at one state, in the order n1, t1, n2, t2.

    Attributes
    ----------
    W : ndarray, shape (4, 4)
    b : ndarray, shape (4,)
    directions : ndarray, shape (n, 4)
        M⁻¹ Jᵀ.
    mu : ndarray, shape (2,)
    drive_speeds : ndarray, shape (4,)
        `ContactCoefficients.drive_speeds` of each contact.
    velocity : ndarray, shape (4,)
        Of the contacts, from the coordinates' velocities.
    """

    W: Array
    b: Array
    directions: Array
    mu: Array
    drive_speeds: Array
    velocity: Array

    def problem(self, closed: tuple[int, ...], slip: Array) -> ContactProblem:
        """Return the contact problem of the closed contacts; `slip` are all slip velocities."""
        rows = rows_of(closed)
        chosen = list(closed)
        return ContactProblem(
            self.W[np.ix_(rows, rows)], self.b[rows], self.mu[chosen], slip[chosen]
        )


def rows_of(closed: tuple[int, ...]) -> list[int]:
    """Return the rows n, t of contacts."""
    return [r for i in closed for r in (2 * i, 2 * i + 1)]


@dataclass(frozen=True)
class Decision:
    """What follows a state.

    Attributes
    ----------
    mode : str or None
        Name of the mode to go on in; None where nothing is possible.
    state : ndarray, shape (nx,)
        With closed gaps and resting velocities exactly 0.
    departs : tuple of str
        Labels of guards that are zero and will leave it.
    alternatives : tuple of str
        All solutions, where there were several; the impact without collision is "impact".
    """

    mode: str | None
    state: Array
    departs: tuple[str, ...] = ()
    alternatives: tuple[str, ...] = ()


@dataclass(frozen=True)
class Decider:
    """Finds what follows a state of a mechanism with two rigid contacts.

    Parameters
    ----------
    contact : TwoContacts
    policy : {"liftoff", "slip", "impact"}
    """

    contact: TwoContacts
    policy: str

    @cached_property
    def _terms(self) -> Quantities:
        system = self.contact.mechanism.system
        symbols = (*self.contact.states, *(p.symbol for p in system.parameters))
        return quantities("terms", self.contact, symbols, self._formulas)

    def _formulas(self) -> dict[str, sp.Expr]:
        contact = self.contact
        contacts = contact.mechanism.contacts
        matrices = {
            "W": contact.mobility,
            "b": contact.free,
            "directions": contact.directions,
            "mu": sp.Matrix([c.friction for c in contacts]),
            "drive_speeds": sp.Matrix(
                [v for c in contact.mechanism.all_coefficients for v in c.drive_speeds]
            ),
            "velocity": sp.Matrix([v for c in contacts for v in (c.gap_rate, c.slip_velocity)]),
        }
        return {f"{k}_{i}": e for k, m in matrices.items() for i, e in enumerate(m)}

    def terms(self, state: Array, values: Mapping[str, float]) -> ContactTerms:
        """Return the numbers of the contacts at a state vector."""
        vector = np.append(state, self._own(values))
        found = np.array(self._terms.function(vector)).reshape(-1)
        n = len(self.contact.mechanism.system.q)
        W, b, directions, *rest = np.split(found, np.cumsum([16, 4, 4 * n, 2, 4]))
        W = W.reshape(4, 4)
        return ContactTerms((W + W.T) / 2, b, directions.reshape(n, 4), *rest)

    def _own(self, values: Mapping[str, float]) -> list[float]:
        return [values[p.name] for p in self.contact.mechanism.system.parameters]

    @cached_property
    def _index(self) -> dict[Any, int]:
        return {s: i for i, s in enumerate(self.contact.states)}

    def contact_values(self, state: Array) -> tuple[Array, Array, Array]:
        """Return gaps, gap rates and slip velocities, each of shape (2,)."""
        rows = np.array([[state[self._index[s]] for s in row.symbols] for row in self.contact.rows])
        return rows[:, 0], rows[:, 1], rows[:, 2]

    def rested(self, state: Array, values: Mapping[str, float], scale: Array) -> Array:
        """Return the state with gaps and contact velocities that are zero but for rounding as 0.

        The coordinates' velocities are changed with them, by the least kinetic energy.
        """
        rested, rows, zeros = state.copy(), list[int](), list[int]()
        for k, row in enumerate(self.contact.rows):
            gap, rate, slip = (self._index[s] for s in row.symbols)
            if abs(state[gap]) > _TOUCH * scale[gap]:
                continue
            rested[gap] = 0.0
            for i, which in ((rate, 2 * k), (slip, 2 * k + 1)):
                if abs(state[i]) <= _REST * scale[i]:
                    zeros.append(i)
                    rows.append(which)
        if rows:
            terms, n = self.terms(rested, values), len(self.contact.mechanism.system.q)
            impulses = np.linalg.lstsq(
                terms.W[np.ix_(rows, rows)], -terms.velocity[rows], rcond=1e-12
            )[0]
            rested[n : 2 * n] += terms.directions[:, rows] @ impulses
            rested[zeros] = 0.0  # exactly, where a velocity of the contact is a coordinate's
        return rested

    # ---- forces ----

    def decide(
        self, state: Array, values: Mapping[str, float], ahead: Array | None = None
    ) -> Decision:
        """Return what follows a state without approach: a mode, or an impact without collision.

        Parameters
        ----------
        state : ndarray, shape (nx,)
            As `rested` returns it.
        values : mapping of str to float
            Parameters.
        ahead : ndarray, shape (nx,)
            Where several solutions meet (a force that has come down to zero, sticking at its
            limit), the change of the state along the mode left by which to look ahead.
        """
        gaps, rates, slips = self.contact_values(state)
        closed = tuple(i for i in range(len(gaps)) if gaps[i] <= 0 and rates[i] == 0)
        if not closed:
            return Decision(mode_name((FLIGHT,) * len(gaps)), state)
        terms = self.terms(state if ahead is None else state + ahead, values)
        solutions = terms.problem(closed, slips).solutions()
        found = {self._modes(terms, closed, slips, s): s for s in reversed(solutions)}
        names = [mode_name(modes) for modes in found]
        chosen = self._choose(tuple(found))
        several = (*names, "impact") if len(found) > 1 else ()
        if chosen is None:
            return Decision("impact", state, (), several)
        return Decision(mode_name(chosen), state, self._departs(chosen, gaps, slips), several)

    def _choose(self, found: tuple[tuple[str, ...], ...]) -> tuple[str, ...] | None:
        """Return the modes of the policy, None for an impact."""
        if len(found) == 1:
            return found[0]
        if not found or self.policy == "impact":
            return None
        open_contacts = [sum(mode == FLIGHT for mode in modes) for modes in found]
        best = max(open_contacts) if self.policy == "liftoff" else min(open_contacts)
        return found[open_contacts.index(best)]

    def _modes(
        self, terms: ContactTerms, closed: tuple[int, ...], slips: Array, found: ContactSolution
    ) -> tuple[str, ...]:
        """Return what each contact does; one at rest that gains no speed sticks."""
        modes = [FLIGHT] * len(slips)
        for k, i in enumerate(closed):
            mode = found.modes[k]
            if mode is ContactMode.LIFTOFF:
                continue
            a_t, row = found.tangential_accelerations[k], 2 * i + 1
            terms_of = np.abs(terms.W[row, rows_of(closed)]) @ np.abs(
                np.ravel([found.normal_forces, found.tangential_forces], order="F")
            ) + abs(terms.b[row])
            still = slips[i] == 0 and abs(a_t) <= _STILL * terms_of
            modes[i] = "stick" if still or mode is ContactMode.STICK else mode.value
        return tuple(modes)

    def _departs(self, modes: tuple[str, ...], gaps: Array, slips: Array) -> tuple[str, ...]:
        labels = []
        for i, (mode, contact) in enumerate(
            zip(modes, self.contact.mechanism.contacts, strict=True)
        ):
            if mode == FLIGHT and gaps[i] == 0:
                labels.append(f"touchdown:{contact.name}")
            if mode.startswith("slip") and slips[i] == 0:
                labels.append(f"slip_stop:{contact.name}")
        return tuple(labels)

    # ---- impacts ----

    def impact(
        self,
        state: Array,
        values: Mapping[str, float],
        restitution: str,
        e: float,
    ) -> tuple[Array, Array] | None:
        """Return the impulses of an impact of the closed contacts, shape (4,), and the state after.

        None where the impact jams.
        """
        gaps, rates, slips = self.contact_values(state)
        closed = [i for i in range(len(gaps)) if gaps[i] <= 0 and rates[i] <= 0]
        terms, rows = self.terms(state, values), rows_of(tuple(closed))
        velocity = np.ravel([rates, slips], order="F")
        W, mu = terms.W[np.ix_(rows, rows)], terms.mu[closed]
        impact = solve_simultaneous_impact(
            W, mu, velocity[rows], restitution, e, load=terms.b[rows]
        )
        if impact.end is ImpactEnd.JAM:
            return None
        impulses = np.zeros(len(velocity))
        impulses[rows] = impact.impulses
        velocity = velocity + terms.W @ impulses
        velocity[rows] = impact.velocities
        after, n = state.copy(), len(self.contact.mechanism.system.q)
        after[n : 2 * n] += terms.directions @ impulses
        for i, row in enumerate(self.contact.rows):
            after[self._index[row.gap_rate]] = velocity[2 * i]
            after[self._index[row.slip]] = velocity[2 * i + 1]
        after[self._index[CONTACT_WORK]] -= impact.normal_work
        after[self._index[FRICTION_WORK]] -= impact.tangential_work
        if FORCE_WORK in self._index:
            along = [terms.drive_speeds[i::2] @ impulses[i::2] for i in (1, 0)]
            after[self._index[FORCE_WORK]] -= sum(along)
        return impulses, after
