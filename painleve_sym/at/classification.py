"""The rigid contact problem of a mechanism at a state: coefficients, case, every solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from painleve_sym.arrays import Array
from painleve_sym.automata.model import guide_slip_mode, guide_stick_mode
from painleve_sym.equality import Compared
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.mechanism import Place
from painleve_sym.mechanics.outline import KINDS
from painleve_sym.notebooks import Shown
from painleve_sym.problem.coefficients import NormalCoefficients
from painleve_sym.problem.complementarity.uniqueness import Uniqueness
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.impact.chatter import Chatter, chatter
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.solution import ContactCase, ContactSolution, case_of, solution_data


@dataclass(frozen=True, eq=False, repr=False)
class Classification(Shown, Compared):
    """The rigid contact problem of the closed contacts at one state, with every solution.

    None and several solutions are results. `problem.guarantee` says whether the solutions are all.

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
    A_sticks, B_sticks : ndarray, shape (n,)
        A′ and B′ of each closed contact; see `NormalCoefficients`.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> answer = ps.classify("rod", {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0})
    >>> answer.case
    <ContactCase.INDETERMINATE: 'indeterminate'>
    >>> len(answer.solutions), answer.contacts
    (2, ('A',))

    In space:

    >>> answer = ps.classify("rod-3d", {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0})
    >>> [own] = answer.coefficients
    >>> round(own.mu_P, 6), round(own.sector.half_angle, 6)
    (1.375259, 0.188277)
    """

    mechanism: str
    state: dict[str, float]
    parameters: dict[str, float]
    contacts: tuple[str, ...]
    open: tuple[str, ...]
    problem: ContactProblem
    solutions: tuple[ContactSolution, ...]
    A_sticks: Array
    B_sticks: Array

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

    @cached_property
    def promise(self) -> Uniqueness | None:
        """Existence and uniqueness for all loads, from W, μ and slip directions; None in space."""
        return self.problem.uniqueness() if self.problem.in_plane else None

    @cached_property
    def coefficients(self) -> tuple[NormalCoefficients, ...]:
        """A, B, critical friction and more of each closed contact, the others open."""
        sticking = zip(self.A_sticks.tolist(), self.B_sticks.tolist(), strict=True)
        return tuple(map(self.problem.coefficients_of, range(self.problem.size), sticking))

    # ---- one contact: where it is `single` ----

    @cached_property
    def chatter(self) -> tuple[Chatter, ...]:
        """Course of small bounces near a contact at v_t = 0 that can open.

        For every restitution law, with the default of its coefficient. Empty in space, in slip,
        where they die out, where B ≥ 0, where impacts jam, for a contact that cannot open, and for
        a mechanism with several contacts.
        """
        if not (self.single and self.problem.in_plane) or self.problem.slip_direction:
            return ()
        laws = RESTITUTIONS.values()
        chatters = [chatter(self.problem, law.name, law.parameter.default) for law in laws]
        return tuple(c for c in chatters if c is not None)

    @property
    def A(self) -> float:
        """A of g̈_N = A F_n + B in slip with F_n > 0; 1/kg."""
        return self._only.A

    @property
    def B(self) -> float:
        """B of the same; m/s²."""
        return self._only.B

    @property
    def A_stick(self) -> float:
        """A′ of g̈_N = A′ F_n + B′ in sticking; 1/kg."""
        return self._only.A_stick

    @property
    def B_stick(self) -> float:
        """B′; m/s²."""
        return self._only.B_stick

    @property
    def _only(self) -> NormalCoefficients:
        (own,) = self.coefficients
        return own

    # ---- plain data ----

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        given = zip(self.contacts, self.problem.bilateral.tolist(), strict=True)
        kinds = {name: KINDS[bilateral] for name, bilateral in given}
        numbers = zip(kinds.items(), self.problem.slips, self.coefficients, strict=True)
        return {
            "mechanism": self.mechanism,
            "state": self.state,
            "parameters": self.parameters,
            "contacts": {
                name: {"kind": kind, "slip_velocity": list(slip), **own.to_dict()}
                for (name, kind), slip, own in numbers
            },
            "open": list(self.open),
            "W": self.problem.W.tolist(),
            "b": self.problem.b.tolist(),
            "complete": self.problem.complete,
            "guarantee": self.problem.guarantee,
            "case": self.case.value,
            "borders": list(self.problem.borders),
            "solutions": list(map(self._solution_data, self.solutions)),
            "promise": None if self.promise is None else self.promise.label,
            "chatter": [c.to_dict() for c in self.chatter],
        }

    def _solution_data(self, solution: ContactSolution) -> dict[str, Any]:
        data = solution_data(solution, self.contacts)
        for i, own in enumerate(data["contacts"].values()):
            own["name"] = solution_name(solution, self.problem, i)
        return data


def solution_name(solution: ContactSolution, problem: ContactProblem, i: int = 0) -> str:
    """Return the mode of rigid motion that a solution is for one contact, the others open.

    Such as ``slip_neg``, and ``slip_neg/pull_unstable`` of a bilateral contact.
    """
    mode = solution.modes[i]
    if not problem.bilateral[i]:
        return mode.value
    side = 1 if solution.normal_forces[i] >= 0 else -1
    if mode is ContactMode.STICK:
        return guide_stick_mode(side)
    slip = 1 if mode is ContactMode.SLIP_POS else -1
    return guide_slip_mode(slip, side, problem.alone(i).A_slip(slip, side) < 0)


def classification(
    place: Place, closed: Sequence[int], problem: ContactProblem, sticking: tuple[Array, Array]
) -> Classification:
    """Return the classification of a problem of the closed contacts at a place."""
    names = [c.name for c in place.mechanism.outline.contacts]
    return Classification(
        place.mechanism.name,
        place.state,
        place.parameters,
        tuple(names[i] for i in closed),
        tuple(name for i, name in enumerate(names) if i not in closed),
        problem,
        problem.solutions(),
        *sticking,
    )
