"""Impacts of several rigid contacts within a run with derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.variational import VariationalFunctions
from painleve_sym.contact_rows import ContactRows
from painleve_sym.engines.impacts import COURSE, STEP, STRUCK, PathReader, doubles, read
from painleve_sym.laws.restitution import restitution_law
from painleve_sym.motion.sensitivity.path_slopes import ImpactData, impact_slopes, least_norm_slopes


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


class SensitiveImpacts:
    """Listener of a run with derivatives: adds the derivatives of impacts, and decides nothing.

    The run calls state and derivatives, those of `functions`, its state; the names are those of
    the contacts, the constants those of the extended automaton, `sizes` those of the directions,
    `scale` that of the states, `tolerance` that of `ImpactData`. Per event of an impact `notes` is
    empty, or a key of `NO_DERIVATIVE`.
    """

    def __init__(
        self,
        functions: VariationalFunctions,
        names: Sequence[str],
        constants: Array,
        sizes: Array,
        scale: Array,
        tolerance: float,
    ) -> None:
        automaton, given = functions.automaton, functions.automaton.impacts
        assert given is not None
        self.functions, self.names, self.given = functions, names, given
        self.constants = constants
        self.sizes, self.scale, self.tolerance = sizes, scale, tolerance
        self.notes: list[str] = []
        at = automaton.states.index
        self._places = np.array([[at(s) for s in row] for row in given.contacts])
        self._velocities = self._places[:, 1:].ravel()
        self._speeds = [at(s) for s in given.velocities]
        self._works = [None if s is None else at(s) for s in given.works]
        self._paths = PathReader(len(given.rigid))
        rows = len(self._velocities)
        self._change = doubles(
            *("n", "rows", "first", "after"),
            *(("contact", len(given.rigid)), ("row", rows), ("impulses", rows)),
            *(("before", functions.x.numel()), ("memory", functions.z.numel() + 1)),
        )

    def __call__(self, kind: int, address: int, state: Array) -> None:
        """Hear of the path of an impact, or add derivatives to the state after a change."""
        if kind in (COURSE, STEP):
            self._paths(kind, address, state)
            return
        change = read(self._change, address)
        numbers = self._at(change)
        jacobian = self.functions.unpacked(change["before"])[1]
        contacts = [int(i) for i in change["contact"][: int(change["n"])]]
        rows = [int(row) for row in change["row"][: int(change["rows"])]]
        if kind == STRUCK:
            self._strike(change, numbers, jacobian, contacts, rows)
        else:
            self._close(numbers, jacobian, contacts, rows)
        own = len(self.functions.automaton.states)
        state[:] = self.functions.packed(state[:own], jacobian)

    def _strike(
        self,
        change: Any,
        numbers: tuple[_Numbers, _Numbers],
        jacobian: Array,
        contacts: list[int],
        rows: list[int],
    ) -> None:
        """Add the derivatives of an impact of the closed contacts to those of the state."""
        given, slopes = numbers
        state, at = change["before"], ContactRows(len(contacts))
        velocities = self._velocities[rows]
        parted = self._parted(change, jacobian, contacts)
        bilateral = np.array([i in self.given.bilateral for i in contacts])
        own = [self.given.rigid.index(i) for i in contacts]
        path = impact_slopes(
            self._paths.path(bilateral, restitution_law(self.given.restitution), given.e[own]),
            ImpactData(
                W=slopes.W[np.ix_(rows, rows)],
                mu=slopes.mu[contacts],
                velocity=jacobian[velocities],
                e=slopes.e[own],
                floor=float(np.max(np.abs(state[velocities]))) / self.sizes,
                tolerance=self.tolerance,
            ),
        )
        impulses = np.zeros((len(self._velocities), len(self.sizes)))
        impulses[rows] = path.impulses
        self._push(jacobian, numbers, change["impulses"], impulses)
        jacobian[velocities] = path.velocities
        contact_work, friction_work, _ = self._works
        jacobian[contact_work] -= path.works[at.normals].sum(axis=0)
        jacobian[friction_work] -= path.works[at.tangentials].sum(axis=0)
        if parted:
            jacobian[:] = np.nan
        singular = not np.isfinite(path.velocities).all()
        self.notes.append("simultaneous" if parted else "tie" if singular else "")

    def _close(
        self,
        numbers: tuple[_Numbers, _Numbers],
        jacobian: Array,
        contacts: list[int],
        rows: list[int],
    ) -> None:
        """Add the derivatives of a closing of contacts to those of the state."""
        given, slopes = numbers
        velocities, block = self._velocities[rows], np.ix_(rows, rows)
        # The solution of W P = −v with the least norm.
        stop = -given.velocity[rows], -slopes.velocity[rows]
        P, change = least_norm_slopes(given.W[block], slopes.W[block], *stop)
        all_P = np.zeros(len(self._velocities))
        all_change = np.zeros((len(all_P), len(self.sizes)))
        all_P[rows], all_change[rows] = P, change
        v, slopes_v = given.velocity, slopes.velocity
        axes = ContactRows(len(self._places))
        works = [
            (v[k] @ all_change[k] + all_P[k] @ slopes_v[k]) / 2
            for k in (axes.normals, axes.tangentials)
        ]
        self._push(jacobian, numbers, all_P, all_change)
        for place, work in zip(self._works, works, strict=False):
            jacobian[place] -= work
        jacobian[velocities] = jacobian[self._places[contacts, 0]] = 0.0
        self.notes.append("")

    def _at(self, change: Any) -> tuple[_Numbers, _Numbers]:
        """Return the numbers of the contacts before a change, and their derivatives."""
        memory = change["memory"][:-1]
        results = self.functions.impact_slopes(change["before"], memory, self.constants)
        arrays = [np.array(r.full()) for r in results]
        n, nq = len(self._velocities), len(self._speeds)
        # Matrices are listed column by column.
        contacts, rigid = len(self._places), len(self.given.rigid)
        shapes = ((n, n), (n,), (n, nq), (contacts,), (n,), (n,), (rigid,))
        values = (a.reshape(s) for a, s in zip(arrays[: len(shapes)], shapes, strict=True))
        slopes = (a.reshape(*s, -1) for a, s in zip(arrays[len(shapes) :], shapes, strict=True))
        return _Numbers(*values), _Numbers(*slopes)

    def _parted(self, change: Any, jacobian: Array, contacts: list[int]) -> bool:
        """Return whether a direction parts contacts that touch down at one instant.

        It leaves them together where their gaps, at the moving time of the touchdown, stay 0.
        """
        if change["first"]:
            # Within the mode that it starts in, what touches stays touching.
            return False
        parted, state = False, change["before"]
        after = int(change["after"])
        last = self.functions.automaton.contacts[after] if after >= 0 else ""
        for i in contacts:
            gap, rate, _ = self._places[i]
            if last != self.names[i] and state[rate] < 0:
                moved = change["memory"][self.functions.event_entries["time"]]
                terms = np.abs(state[rate] * moved) + self.scale[gap] / self.sizes
                parted |= bool(np.any(np.abs(jacobian[gap]) > self.tolerance * terms))
                jacobian[gap] = 0.0
        return parted

    def _push(
        self, jacobian: Array, numbers: tuple[_Numbers, _Numbers], P: Array, change: Array
    ) -> None:
        """Add impulses P (2 n) with derivatives (2 n, k) to the derivatives of the state."""
        given, slopes = numbers
        velocities = jacobian[self._velocities] + _product(given.W, slopes.W, P, change)
        directions = given.directions.T, slopes.directions.swapaxes(0, 1)
        jacobian[self._speeds] += _product(*directions, P, change)
        # Last, since a generalised velocity may be that of a contact.
        jacobian[self._velocities] = velocities
        driven = self._works[2]
        if driven is not None:
            jacobian[driven] -= P @ slopes.drive_speeds + given.drive_speeds @ change


def _product(matrix: Array, slopes: Array, P: Array, change: Array) -> Array:
    """Return the derivatives of matrix · P."""
    product: Array = np.einsum("rck,c->rk", slopes, P) + matrix @ change
    return product
