"""The rigid contact problem of a mechanism at a state: coefficients, case, every solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from painleve_sym.arrays import Array
from painleve_sym.automata.model import guide_slip_mode, guide_stick_mode
from painleve_sym.equality import Compared
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.mechanism import Place
from painleve_sym.mechanics.outline import KINDS
from painleve_sym.notebooks import Shown
from painleve_sym.problem.complementarity.uniqueness import Uniqueness
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.impact.chatter import Chatter, chatter
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.one_contact import ContactAnswer, solution_data
from painleve_sym.problem.solution import ContactCase, ContactSolution, case_of, forces_data


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
    >>> round(answer.answer.mu_P, 6), round(answer.answer.sector.half_angle, 6)
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
    def promise(self) -> Uniqueness:
        """Existence and uniqueness for all loads, from W, μ and slip directions in the plane."""
        return self.problem.uniqueness()

    @cached_property
    def coefficients(self) -> tuple[NormalCoefficients, ...]:
        """A and B of each closed contact in the plane, the others open."""
        sticking = zip(self.A_sticks.tolist(), self.B_sticks.tolist(), strict=True)
        return tuple(
            NormalCoefficients.of(self.problem.alone(i), *stick) for i, stick in enumerate(sticking)
        )

    @cached_property
    def answer(self) -> ContactAnswer:
        """The contact where it is `single`: A, B, μ_P, sector, least μ_P over all normals."""
        return ContactAnswer(self.problem, self.solutions)

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
        contacts = {name: self._contact_data(i) for i, name in enumerate(self.contacts)}
        data = {
            "mechanism": self.mechanism,
            "state": self.state,
            "parameters": self.parameters,
            "contacts": contacts,
            "open": list(self.open),
            "W": self.problem.W.tolist(),
            "b": self.problem.b.tolist(),
            "complete": self.problem.complete,
            "guarantee": self.problem.guarantee,
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
        if self.problem.in_plane:
            data |= {
                "promise": self.promise.label,
                "chatter": [c.to_dict() for c in self.chatter],
            }
        return data

    def _contact_data(self, i: int) -> dict[str, Any]:
        """Return the numbers of one closed contact, the others open."""
        if not self.problem.in_plane:
            alone = self.problem.alone(i)
            return {"slip_velocity": list(alone.slips[0])} | ContactAnswer(
                alone, ()
            ).coefficient_data()
        return {
            "kind": KINDS[bool(self.problem.bilateral[i])],
            "slip_velocity": float(self.problem.slip_velocity[i]),
            **self.coefficients[i]._asdict(),
        }

    def _solution_data(self, solution: ContactSolution, i: int) -> dict[str, Any]:
        """Return mode, forces and accelerations of one contact in a solution as plain data."""
        if not self.problem.in_plane:
            return solution_data(solution, i)
        return {
            "mode": solution.modes[i].value,
            "name": solution_name(solution, self.problem, i),
            "normal_force": float(solution.normal_forces[i]),
            "tangential_force": float(solution.tangential_forces[i]),
            "normal_acceleration": float(solution.normal_accelerations[i]),
            "tangential_acceleration": float(solution.tangential_accelerations[i]),
        }


class NormalCoefficients(NamedTuple):
    """The line g̈_N = A F_n + B of one contact in slip and in sticking, the others open.

    Attributes
    ----------
    slip : int
        s = sign(v_t); at v_t = 0 the sign of the free acceleration b_t (−1 where b_t = 0).
    A, A_pull : float
        A in slip along s for F_n > 0, and for F_n < 0, which a bilateral contact has; 1/kg.
    B : float
        m/s².
    A_stick, B_stick : float
        A′ and B′ of g̈_N = A′ F_n + B′ in sticking; 1/kg and m/s².
    excess : float
        μ |W_nt| − W_nn: where positive A < 0 for one direction of slip, and a bilateral slip has no
        solution or two; 1/kg.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> [own] = ps.classify("rod", {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}).coefficients
    >>> own.slip, round(own.A, 6), round(own.B, 6), own.excess > 0
    (-1, -0.033745, -8.958529, True)
    """

    slip: int
    A: float
    A_pull: float
    B: float
    A_stick: float
    B_stick: float
    excess: float

    @classmethod
    def of(cls, problem: ContactProblem, A_stick: float, B_stick: float) -> NormalCoefficients:
        """Return the coefficients of a problem of one contact; A′, B′ in stick are given."""
        s = problem.slip_direction or (1 if problem.b_t > 0 else -1)
        A, A_pull = problem.A_slip(s), problem.A_slip(s, -1)
        return cls(s, A, A_pull, problem.B, A_stick, B_stick, -min(A, A_pull))


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
