"""The common part of what a state's contacts do, in the plane and in space."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from painleve_sym.equality import Compared
from painleve_sym.mechanics.mechanism import Place
from painleve_sym.notebooks import Shown
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.solution import ContactCase, ContactSolution, case_of, forces_data


@dataclass(frozen=True, eq=False, repr=False)
class ClassifiedState(Shown, ABC, Compared):
    """The rigid contact problem of the closed contacts at one state, with its solutions.

    Attributes
    ----------
    mechanism : str
    state, parameters : dict of str to float
        Complete, with defaults filled in.
    contacts : tuple of str
        Names of the closed contacts, in the order of the arrays.
    open : tuple of str
        Names of the contacts that are apart or leaving.
    problem : ContactProblem
        Of the closed contacts.
    solutions : tuple of ContactSolution
        Each with its verified residual.
    """

    mechanism: str
    state: dict[str, float]
    parameters: dict[str, float]
    contacts: tuple[str, ...]
    open: tuple[str, ...]
    problem: ContactProblem
    solutions: tuple[ContactSolution, ...]

    def __repr__(self) -> str:
        """Return mechanism, case and the modes of the solutions in one line."""
        modes = [", ".join(mode.value for mode in s.modes) for s in self.solutions]
        ends = f": {'; '.join(modes)}" if modes else ""
        return f"{type(self).__name__} of {self.mechanism!r}: {self.case.value}{ends}"

    @cached_property
    def case(self) -> ContactCase:
        """The case, by number and kind of the solutions."""
        return case_of(self.solutions, not self.single, self.problem.complete)

    @property
    def single(self) -> bool:
        """Whether the mechanism has one contact."""
        return len(self.contacts) + len(self.open) == 1

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys, the same for any contacts."""
        return {
            "mechanism": self.mechanism,
            "state": self.state,
            "parameters": self.parameters,
            "contacts": {name: self._contact_data(i) for i, name in enumerate(self.contacts)},
            "open": list(self.open),
            "W": self.problem.W.tolist(),
            "b": self.problem.b.tolist(),
            **self._assurance,
            "case": self.case.value,
            "borders": list(self.problem.borders),
            "solutions": [
                {
                    "contacts": {
                        name: self._solution_data(s, i) for i, name in enumerate(self.contacts)
                    },
                    **forces_data(s),
                }
                for s in self.solutions
            ],
        }

    @abstractmethod
    def _contact_data(self, i: int) -> dict[str, Any]:
        """Return the numbers of one closed contact, the others open."""

    @abstractmethod
    def _solution_data(self, solution: ContactSolution, i: int) -> dict[str, Any]:
        """Return what one contact does in a solution."""

    @property
    @abstractmethod
    def _assurance(self) -> dict[str, Any]:
        """Promise or guarantee of the solutions as plain data."""


def named_at(place: Place, closed: Sequence[int]) -> dict[str, Any]:
    """Return the fields of a `ClassifiedState` that say where and between what it is."""
    names = [c.name for c in place.mechanism.outline.contacts]
    return {
        "mechanism": place.mechanism.name,
        "state": place.state,
        "parameters": place.parameters,
        "contacts": tuple(names[i] for i in closed),
        "open": tuple(name for i, name in enumerate(names) if i not in closed),
    }
