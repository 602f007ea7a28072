"""The rigid contact problem of a mechanism with two contacts at a state: every solution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.complementarity.several import SeveralContacts, SeveralSolution
from painleve_sym.complementarity.uniqueness import Uniqueness
from painleve_sym.contacts.inputs import (
    CONTACT_TOLERANCE,
    resolve_parameters,
    resolve_state,
    symbol_values,
)
from painleve_sym.contacts.two_contacts import TwoContacts
from painleve_sym.errors import InputError
from painleve_sym.mechanics.mechanism import Mechanism

CASES = ("inconsistent", "unique", "hyperstatic", "indeterminate")
"""No solution; one; several forces with the same accelerations; several accelerations."""


_SAME = 1e-9  # of the accelerations without forces


@dataclass(frozen=True)
class SeveralClassification:
    """Rigid solutions of several contacts at one state.

    Attributes
    ----------
    mechanism : str
    state, parameters : dict of str to float
        Complete, with defaults filled in.
    contacts : tuple of str
        Names of the closed contacts, in the order of the arrays.
    open : tuple of str
        Names of the contacts that are apart or leaving.
    slip_velocities : ndarray, shape (n,)
        m/s.
    promise : Uniqueness
        What W, μ and the slip directions promise for all loads.
    solutions : tuple of SeveralSolution
        Every solution, each with its verified residual; none and several are results.
    problem : SeveralContacts
    """

    mechanism: str
    state: dict[str, float]
    parameters: dict[str, float]
    contacts: tuple[str, ...]
    open: tuple[str, ...]
    slip_velocities: Array
    promise: Uniqueness
    solutions: tuple[SeveralSolution, ...]
    problem: SeveralContacts

    @property
    def case(self) -> str:
        """One of `CASES`."""
        if not self.solutions:
            return CASES[0]
        if len(self.solutions) == 1 and self.solutions[0].isolated:
            return CASES[1]
        motions = [
            np.append(s.normal_accelerations, s.tangential_accelerations) for s in self.solutions
        ]
        size = float(np.max(np.abs(self.problem.b), initial=0.0))
        same = all(np.allclose(m, motions[0], rtol=0, atol=_SAME * size) for m in motions)
        return CASES[2 if same else 3]

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        return {
            "mechanism": self.mechanism,
            "state": self.state,
            "parameters": self.parameters,
            "contacts": list(self.contacts),
            "open": list(self.open),
            "slip_velocities": self.slip_velocities,
            "W": self.problem.W,
            "b": self.problem.b,
            "promise": self.promise.value[0],
            "case": self.case,
            "solutions": [self._solution(s) for s in self.solutions],
        }

    def _solution(self, s: SeveralSolution) -> dict[str, Any]:
        rows = zip(
            self.contacts,
            s.modes,
            s.normal_forces,
            s.tangential_forces,
            s.normal_accelerations,
            s.tangential_accelerations,
            strict=True,
        )
        return {
            "contacts": {
                name: {
                    "mode": mode.value,
                    "normal_force": float(F_n),
                    "tangential_force": float(F_t),
                    "normal_acceleration": float(a_n),
                    "tangential_acceleration": float(a_t),
                }
                for name, mode, F_n, F_t, a_n, a_t in rows
            },
            "isolated": s.isolated,
            "residual": s.residual,
        }


def classify_several(
    mechanism: Mechanism,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
) -> SeveralClassification:
    """Return the contact problem of all closed contacts at a state, with every solution.

    Parameters
    ----------
    mechanism : Mechanism
        With two contacts that can open.
    state : mapping of str to float
        Coordinates and velocities; absent ones are 0. No contact may approach, one must be closed.
    parameters : mapping of str to float
        Absent ones have their defaults.

    Raises
    ------
    InputError
        Unknown names, numbers out of range, a contact inside its surface or approaching it, or
        none closed; all faults of the contacts at once.
    """
    values = resolve_parameters(
        f"{mechanism.name!r}", mechanism.system.parameters, parameters or {}
    )
    start = resolve_state(mechanism, state, values)
    joint, symbols = TwoContacts(mechanism), symbol_values(mechanism, start, values)
    parts = [(c.gap, c.gap_rate, c.slip_velocity) for c in mechanism.contacts]
    rows = numbers([p for row in parts for p in row], symbols).reshape(-1, 3)
    closed = _closed(mechanism, rows)
    names = tuple(c.name for c in mechanism.contacts)
    chosen = [r for i in closed for r in (2 * i, 2 * i + 1)]
    n = len(names)
    W = numbers(list(joint.mobility), symbols).reshape(2 * n, 2 * n)[np.ix_(chosen, chosen)]
    friction = [mechanism.contacts[i].friction for i in closed]
    problem = SeveralContacts(
        (W + W.T) / 2,
        numbers(list(joint.free), symbols)[chosen],
        numbers(friction, symbols),
        rows[closed, 2],
    )
    return SeveralClassification(
        mechanism=mechanism.name,
        state=start,
        parameters=values,
        contacts=tuple(names[i] for i in closed),
        open=tuple(name for i, name in enumerate(names) if i not in closed),
        slip_velocities=rows[closed, 2],
        promise=problem.uniqueness(),
        solutions=problem.solutions(),
        problem=problem,
    )


def _closed(mechanism: Mechanism, rows: Array) -> list[int]:
    """Return the indices of the closed contacts; `rows` are gap, gap rate and slip velocity."""
    faults, closed = [], []
    for i, (contact, (gap, rate, _)) in enumerate(zip(mechanism.contacts, rows, strict=True)):
        if gap < -CONTACT_TOLERANCE:
            faults.append(f"contact {contact.name!r} is inside the ground, gap = {gap:g} m.")
        elif gap <= CONTACT_TOLERANCE and rate < -CONTACT_TOLERANCE:
            faults.append(
                f"contact {contact.name!r} approaches with {-rate:g} m/s: an impact. "
                "Fix: use simulate with --law rigid."
            )
        elif gap <= CONTACT_TOLERANCE and rate <= CONTACT_TOLERANCE:
            closed.append(i)
    where = f"classify {mechanism.name!r}: "
    if faults:
        raise InputError(where + " ".join(faults))
    if not closed:
        raise InputError(where + "no contact is closed. Fix: start with a gap of 0.")
    return closed
