"""Impacts of several rigid contacts within a run with derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.variational import VariationalFunctions
from painleve_sym.contact_rows import ContactRows
from painleve_sym.contacts.impact.path_slopes import ImpactData, impact_slopes, least_norm_slopes
from painleve_sym.contacts.terms import ImpactResult
from painleve_sym.engines.protocol import Answer, Question
from painleve_sym.motion.impact_resolver import ImpactResolver


class _Numbers(NamedTuple):
    """Numbers of all contacts, or their derivatives with the directions as last axis.

    The `directions` of contact i are a row here.
    """

    W: Array
    load: Array
    directions: Array
    mu: Array
    drive_speeds: Array
    velocity: Array
    e: Array


@dataclass
class SensitiveImpacts(ImpactResolver):
    """Answers the questions of a run with derivatives: decisions are those of the state alone.

    The run calls state and derivatives, those of `functions`, its state; the constants are those of
    the extended automaton, `sizes` those of the directions, `tolerance` that of `ImpactData`. Per
    event of the answers `notes` is empty, or a key of `NO_DERIVATIVE`.
    """

    functions: VariationalFunctions = field(kw_only=True)
    constants: Array = field(kw_only=True)
    sizes: Array = field(kw_only=True)
    tolerance: float = field(kw_only=True)
    notes: list[str] = field(default_factory=list)
    _question: Question | None = None

    def __call__(self, question: Question) -> Answer:
        """Return what follows, with its derivatives."""
        self._question = question
        answer = super().__call__(question)
        self.notes += [""] * (len(self.impulses) - len(self.notes))
        return answer

    def impact(self, state: Array) -> ImpactResult | None:
        """Return the impact of the closed contacts, its state with derivatives."""
        result = super().impact(state)
        if result is None:
            return None
        given, slopes, jacobian = self._at(state)
        contacts, at = list(result.contacts), ContactRows(len(result.contacts))
        rows = at.of_contacts(contacts)
        velocities = self.impacts.velocities
        speed = float(np.max(np.abs(state[velocities[rows]])))
        parted = self._parted(jacobian, state, contacts)
        path = impact_slopes(
            result.path,
            ImpactData(
                W=slopes.W[np.ix_(rows, rows)],
                mu=slopes.mu[contacts],
                velocity=jacobian[velocities[rows]],
                e=slopes.e[0],
                floor=speed / self.sizes,
                tolerance=self.tolerance,
            ),
        )
        impulses = np.zeros((len(velocities), len(self.sizes)))
        impulses[rows] = path.impulses
        self._push(jacobian, (given, slopes), result.impulses, impulses)
        jacobian[velocities[rows]] = path.velocities
        contact_work, friction_work, _ = self._works
        jacobian[contact_work] -= path.works[at.normals].sum(axis=0)
        jacobian[friction_work] -= path.works[at.tangentials].sum(axis=0)
        if parted:
            jacobian[:] = np.nan
        singular = not np.isfinite(path.velocities).all()
        self.notes.append("simultaneous" if parted else "tie" if singular else "")
        own = result.state[: len(self.impacts.states)]
        return result._replace(state=self.functions.packed(own, jacobian))

    def closed(self, state: Array, contacts: Sequence[int]) -> Array:
        """Return the state with contacts closed, and its derivatives."""
        after = super().closed(state, contacts)
        given, slopes, jacobian = self._at(state)
        closing = self.impacts.closing(state, contacts)
        rows = self.impacts.closing_rows(state, self.impacts.terms(state, self.values), closing)
        velocities = self.impacts.velocities
        at, block = velocities[rows], np.ix_(rows, rows)
        # The solution of W P = −v with the least norm.
        stop = -given.velocity[rows], -slopes.velocity[rows]
        P, change = least_norm_slopes(given.W[block], slopes.W[block], *stop)
        all_P = np.zeros(len(velocities))
        all_change = np.zeros((len(all_P), len(self.sizes)))
        all_P[rows], all_change[rows] = P, change
        v, slopes_v = given.velocity, slopes.velocity
        works = [(v[k::2] @ all_change[k::2] + all_P[k::2] @ slopes_v[k::2]) / 2 for k in (0, 1)]
        self._push(jacobian, (given, slopes), all_P, all_change)
        for place, work in zip(self._works, works, strict=False):
            jacobian[place] -= work
        jacobian[at] = jacobian[self.impacts.places[closing, 0]] = 0.0
        return self.functions.packed(after[: len(self.impacts.states)], jacobian)

    # ---- places in the state ----

    def _index(self, symbol: object) -> int:
        return self.impacts.states.index(str(symbol))

    @property
    def _works(self) -> list[int | None]:
        given = self.functions.automaton.impacts
        assert given is not None
        return [None if s is None else self._index(s) for s in given.works]

    # ---- derivatives ----

    def _at(self, state: Array) -> tuple[_Numbers, _Numbers, Array]:
        """Return the numbers of the contacts, their derivatives, and those of the state."""
        assert self._question is not None
        results = self.functions.impact_slopes(state, self._question.memory, self.constants)
        arrays = [np.array(r.full()) for r in results]
        n, nq = len(self.impacts.velocities), len(self.impacts.mechanism.system.q)
        # Matrices are listed column by column.
        shapes = ((n, n), (n,), (n, nq), (len(self.impacts.rows),), (n,), (n,), (1,))
        values = (a.reshape(s) for a, s in zip(arrays[: len(shapes)], shapes, strict=True))
        slopes = (a.reshape(*s, -1) for a, s in zip(arrays[len(shapes) :], shapes, strict=True))
        return _Numbers(*values), _Numbers(*slopes), self.functions.unpacked(state)[1]

    def _parted(self, jacobian: Array, state: Array, contacts: Sequence[int]) -> bool:
        """Return whether a direction parts contacts that touch down at one instant.

        It leaves them together where their gaps, at the moving time of the touchdown, stay 0.
        """
        question = self._question
        assert question is not None
        if question.kind is None:
            # Within the mode that it starts in, what touches stays touching.
            return False
        parted = False
        for i in contacts:
            gap, rate, _ = self.impacts.places[i]
            name = self.impacts.mechanism.outline.contacts[i].name
            if name != question.contact and state[rate] < 0:
                moved = question.memory[self.functions.event_entries["time"]]
                terms = np.abs(state[rate] * moved) + self.scale[gap] / self.sizes
                parted |= bool(np.any(np.abs(jacobian[gap]) > self.tolerance * terms))
                jacobian[gap] = 0.0
        return parted

    def _push(
        self, jacobian: Array, numbers: tuple[_Numbers, _Numbers], P: Array, change: Array
    ) -> None:
        """Add to derivatives of the state what impulses P (2 n) with derivatives (2 n, k) add."""
        given, slopes = numbers
        mechanism = self.functions.automaton.impacts
        assert mechanism is not None
        speeds = [self._index(s) for s in mechanism.velocities]
        velocities = jacobian[self.impacts.velocities] + _product(given.W, slopes.W, P, change)
        directions = given.directions.T, slopes.directions.swapaxes(0, 1)
        jacobian[speeds] += _product(*directions, P, change)
        # Last, since a generalised velocity may be that of a contact.
        jacobian[self.impacts.velocities] = velocities
        driven = self._works[2]
        if driven is not None:
            jacobian[driven] -= P @ slopes.drive_speeds + given.drive_speeds @ change


def _product(matrix: Array, slopes: Array, P: Array, change: Array) -> Array:
    """Return the derivatives of matrix · P."""
    product: Array = np.einsum("rck,c->rk", slopes, P) + matrix @ change
    return product
