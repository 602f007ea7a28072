"""The rigid contact problem of a mechanism in space at a state: sector, case, every solution."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from painleve_sym.contacts.classified import ClassifiedState, named_at
from painleve_sym.contacts.delassus import ContactNumbers
from painleve_sym.mechanics.mechanism import Place
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.one_contact import ContactAnswer, solution_data
from painleve_sym.problem.solution import ContactSolution


@dataclass(frozen=True, eq=False, repr=False)
class SpatialClassification(ClassifiedState):
    """The rigid contact problem of the closed contacts of a mechanism in space at one state.

    It has the attributes of `ClassifiedState`. `problem.guarantee` says whether the solutions are
    all.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> answer = ps.classify("rod-3d", {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0})
    >>> answer.case
    <ContactCase.INDETERMINATE: 'indeterminate'>
    >>> round(answer.answer.mu_P, 6), round(answer.answer.sector.half_angle, 6)
    (1.375259, 0.188277)
    """

    @cached_property
    def answer(self) -> ContactAnswer:
        """The contact where it is `single`: A, B, μ_P, sector, least μ_P over all normals."""
        return ContactAnswer(self.problem, self.solutions)

    def _contact_data(self, i: int) -> dict[str, Any]:
        alone = self.problem.alone(i)
        coefficients = ContactAnswer(alone, ()).coefficient_data()
        return {"slip_velocity": list(alone.slips[0]), **coefficients}

    def _solution_data(self, solution: ContactSolution, i: int) -> dict[str, Any]:
        return solution_data(solution, i)

    @property
    def _assurance(self) -> dict[str, Any]:
        return {"complete": self.problem.complete, "guarantee": self.problem.guarantee}


def classified_in_space(
    place: Place, numbers: ContactNumbers, closed: list[int]
) -> SpatialClassification:
    """Return the contact problem of the closed contacts of a mechanism in space."""
    at = numbers.of_contacts(closed)
    problem = ContactProblem(at.W, at.b, at.mu, at.slip_velocity)
    return SpatialClassification(
        **named_at(place, closed), problem=problem, solutions=problem.solutions()
    )
