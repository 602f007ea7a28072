"""Time stepping at velocity level: no events, one complementarity problem per step.

A step of length h takes the velocities u to u⁺ with the impulses Λ of the whole step::

    u_free = u + h M⁻¹ h(q, u)        u⁺ = u_free + M⁻¹ (J_Nᵀ Λ_n + J_Tᵀ Λ_t)
    0 <= Λ_n  ⟂  v_n⁺ + c >= 0        |Λ_t| <= μ Λ_n, against v_t⁺, at its limit where v_t⁺ ≠ 0

Forces and impacts are not distinguished. With impulses for forces and velocities after the step for
accelerations this is the contact problem of `ContactProblem` at v_t = 0: three complementary pairs.
For a positive definite mobility it always has a solution, also where the accelerations have none:
the jump of the impact without collision then takes one step and looks like any other.

References
----------
Moreau (1988) and Jean (1999), Stewart & Trinkle (1996) and Anitescu & Potra (1997) for the schemes;
Stewart (1998) and Stewart (2000) for their convergence through Painlevé's paradox.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.at.delassus import Delassus
from painleve_sym.at.inputs import inside
from painleve_sym.checks import StateLike, number
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, StopReason, refuse_unknown
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.time_stepping.step_solvers import SOLVERS, Answer, Impulse
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.units import Value

SCHEMES = ("moreau-jean", "stewart-trinkle")
_ENDS = {
    StopReason.NO_MODE: "the solver gives no impulses for the contact problem of the next step",
    StopReason.STEP_LIMIT: "as many contact problems were solved as max_solves allows",
}
"""What these reasons mean in time stepping; the others mean what their advice says."""
MAX_STEPS = 1_000_000
"""States of this number of steps still fit into memory; smaller steps drown in round-off anyway."""


@dataclass(frozen=True, eq=False)
class SteppingRun(Compared):
    """A motion by time stepping, by names of mechanism, scheme and solver, with its step in s.

    The last step is shorter where the end asks for it. `times` (s) and `states` (coordinates, then
    velocities) have k + 1 rows, as have `contact_velocities`, ġ_N and v_t of these states.
    `impulses`, Λ_n and Λ_t of each step, have k; N s. `solutions_found` counts those the solver
    found in each step; −1 where the contact was open and none was asked.

    `contact_work` is the work of the impulses on the contact's velocity, Λ·(v⁺ + v_free)/2; J. It
    is never positive with Newton's restitution `e` = 0 and Moreau–Jean's scheme.

    It stops for T_END; LEFT_DOMAIN; NON_FINITE; NO_MODE where the solver has no solution;
    STEP_LIMIT where `max_solves` was used up.
    """

    mechanism: str
    scheme: str
    solver: str
    step: float
    e: float
    state_names: tuple[str, ...]
    times: Array
    states: Array
    contact_velocities: Array
    impulses: Array
    solutions_found: NDArray[np.int64]
    contact_work: Array
    stop_reason: StopReason

    @property
    def final(self) -> dict[str, float]:
        """The last state by name."""
        return dict(zip(self.state_names, map(float, self.states[-1]), strict=True))

    @property
    def stop_detail(self) -> str:
        """Reason of the end, in words."""
        return _ENDS.get(self.stop_reason, self.stop_reason.sentence)

    @property
    def normal_impulse(self) -> float:
        """Sum of Λ_n over all steps; N s."""
        return float(np.sum(self.impulses[:, 0]))

    def values(self, name: str) -> Array:
        """Return one state by name at all times, shape (k + 1,)."""
        refuse_unknown("state", name, self.state_names)
        return self.states[:, self.state_names.index(name)]


@dataclass(frozen=True)
class TimeStepper:
    """A mechanism with one unilateral contact, ready to be stepped; build once, run often.

    Moreau–Jean evaluates M and J half a step ahead, q + h u/2, and asks for contact where the gap
    there is closed; then c = e v_n⁻ (Newton's restitution). Stewart–Trinkle evaluates them at q and
    has c = g_N/h, so that the gap is closed at the end of the step: impacts are plastic. The scheme
    is ``moreau-jean`` or ``stewart-trinkle``. Friction opposes the slip after the step, in an
    impact as in `ImpactFriction.FINAL_SLIP`, whatever the law of a rigid contact chooses.
    """

    mechanism: Mechanism
    scheme: str = "moreau-jean"

    def __post_init__(self) -> None:
        refuse_unknown("scheme", self.scheme, SCHEMES, self.where)
        self.mechanism.require_one_contact()
        self.mechanism.require_opening(self.where, "choose another mechanism")
        self.mechanism.require_one_coefficient(self.where, "simulate with the law rigid")

    @property
    def where(self) -> str:
        """Place of a fault, as messages name it."""
        return f"stepping of {self.mechanism.name!r}"

    @cached_property
    def numbers(self) -> Delassus:
        """The numbers of the contact."""
        return Delassus.of(self.mechanism)

    def run(
        self,
        state: StateLike,
        *,
        step: Value,
        t_end: Value,
        solver: str = "least-impulse",
        e: float = 0.0,
        parameters: Mapping[str, Value] | None = None,
        max_solves: int = MAX_STEPS,
    ) -> SteppingRun:
        """Step from t = 0 to `t_end` in steps h of (0, t_end], with one of `SOLVERS`; s.

        Absent coordinates and velocities are 0, absent parameters have their defaults. `e` is
        Newton's coefficient of restitution, in [0, 1]; 0 with Stewart–Trinkle. Of a run that
        stopped early `stop_reason` says why.

        Raises
        ------
        InputError
            Unknown names, numbers out of range, a start outside the domain or inside the ground.
        """
        step = number(step, "step", where=self.where, unit="s")
        t_end = number(t_end, "t_end", where=self.where, unit="s")
        self.check(step, t_end, solver, e)
        stepping, start = self._begin(state, parameters, solver, e, max_solves)
        times = _times(step, t_end)
        states, impulses, counts, works, reason = stepping.through(start, times)
        return SteppingRun(
            mechanism=self.mechanism.name,
            scheme=self.scheme,
            solver=solver,
            step=step,
            e=e,
            state_names=self.mechanism.state_names,
            times=times[: len(states)],
            states=np.array(states),
            contact_velocities=stepping.contact_velocities(np.array(states)),
            impulses=np.array(impulses, dtype=float).reshape(-1, 2),
            solutions_found=np.array(counts, dtype=np.int64),
            contact_work=np.array(works, dtype=float),
            stop_reason=reason,
        )

    def first_problem(
        self,
        state: StateLike,
        step: float,
        *,
        e: float = 0.0,
        parameters: Mapping[str, Value] | None = None,
    ) -> ContactProblem | None:
        """Return the velocity-level problem of the first step; None where the contact is open."""
        self.check(step, step, e=e)
        stepping, start = self._begin(state, parameters, "first", e, 1)
        return stepping.problem(start, step)[0]

    def _begin(
        self,
        state: StateLike,
        parameters: Mapping[str, Value] | None,
        solver: str,
        e: float,
        max_solves: int,
    ) -> tuple[_Stepping, Array]:
        place = inside(self.mechanism.at(state, parameters, where=self.where))
        start = np.array(list(place.state.values()))
        at = self.numbers.at(place.values)
        closed = float(at.gap_tolerance[0])
        stepping = _Stepping(self, place.parameters, SOLVERS[solver], e, max_solves, closed)
        gap = float(at.gap[0])
        if not gap >= -closed:
            raise InputError(
                f"{self.where}: the start is inside the ground, gap = {gap:g} m, and a rigid "
                "contact has no compression. Fix: start with gap >= 0."
            )
        return stepping, start

    def check(self, step: float, t_end: float, solver: str = "first", e: float = 0.0) -> None:
        """Raise InputError for options of `run` that cannot be used."""
        number(t_end, "t_end", where=self.where, above=0.0)
        if not (math.isfinite(step) and 0 < step <= t_end * (1 + 1e-9)):
            raise InputError(
                f"{self.where}: step: got {step!r}, need a number in (0, t_end = {t_end!r}]."
            )
        if t_end / step > MAX_STEPS:
            raise InputError(
                f"{self.where}: step: got {step!r}, which takes {t_end / step:.3g} steps, need at "
                f"most {MAX_STEPS}. Fix: a longer step or an earlier end."
            )
        refuse_unknown("solver", solver, SOLVERS, self.where)
        if not 0 <= e <= 1:
            raise InputError(f"{self.where}: e: got {e!r}, need 0 <= e <= 1.")
        if self.scheme == "stewart-trinkle" and e > 0:
            raise InputError(
                f"{self.where}: e: got {e!r}, need 0 with the scheme "
                "'stewart-trinkle', whose impacts are plastic. Fix: use 'moreau-jean'."
            )


def _times(step: float, t_end: float) -> Array:
    """Return the ends of the steps; a remainder below 1e-9 steps is round-off, not a step."""
    number = max(1, math.ceil(t_end / step - 1e-9))
    return np.append(step * np.arange(number), t_end)


@dataclass(frozen=True)
class _Stepping:
    """One run's numbers: the state has coordinates, velocities, and t where it occurs."""

    stepper: TimeStepper
    parameters: Mapping[str, float]
    solve: Callable[[ContactProblem], Answer]
    e: float
    max_solves: int
    closed: float
    """Gap up to which the contact is closed; m."""

    @cached_property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.stepper.mechanism.outline.coordinates)

    def split(self, states: Array) -> tuple[Array, Array, Array]:
        """Return coordinates, velocities and times of states in columns; no times without t."""
        n = self.size
        return states[:n], states[n : 2 * n], states[2 * n :]

    def values(self, q: Array, u: Array, t: Array) -> dict[str, Any]:
        """Return states and parameters by name."""
        names = self.stepper.mechanism.state_names
        return {**self.parameters, **dict(zip(names, (*q, *u, *t), strict=True))}

    @cached_property
    def mu(self) -> float:
        """Friction coefficient."""
        return self.parameters[str(self.stepper.mechanism.contact.friction)]

    def contact_velocities(self, states: Array) -> Array:
        """Return ġ_N and v_t of states in rows, shape (len(states), 2)."""
        return self.stepper.numbers.at_each(self.values(*self.split(states.T))).v.T

    def problem(self, q_u: Array, h: float) -> tuple[ContactProblem | None, Any]:
        """Return the contact problem of one step and the terms that it is made of."""
        q, u, t = self.split(q_u)
        ahead = self.stepper.scheme == "moreau-jean"
        place = q + h / 2 * u if ahead else q
        moment = t + h / 2 if ahead else t
        at, moves = self.stepper.numbers.whole_at(self.values(place, u, moment))
        normal, tangential = moves.D.T
        free = u + h * moves.free
        rates = self.stepper.numbers.at(self.values(place, free, moment)).v
        gap, W_nn, W_nt, W_tt = map(float, (at.gap[0], *at.W[0], at.W[1, 1]))
        scalars = np.array([gap, W_nn, W_nt, W_tt, *at.margins])
        terms = (place, free, normal, tangential, rates, scalars)
        finite = all(np.all(np.isfinite(part)) for part in terms)
        if not finite or (ahead and gap > self.closed):
            return None, terms
        if ahead:
            shift = self.e * float(at.gap_rate[0])
        else:
            shift = gap / h
        b_n, b_t = float(rates[0]) + shift, float(rates[1])
        return ContactProblem.single(W_nn, W_nt, W_tt, b_n, b_t, self.mu, 0.0), terms

    def through(
        self, q_u: Array, times: Array
    ) -> tuple[list[Array], list[Impulse], list[int], list[float], StopReason]:
        """Return states, impulses, numbers of solutions and works of all steps, and the end."""
        states, impulses, counts, works = [q_u], list[Impulse](), list[int](), list[float]()
        solves = 0
        for h in np.diff(times):
            problem, terms = self.problem(states[-1], float(h))
            place, free, normal, tangential, rates, scalars = terms
            count, impulse = -1, (0.0, 0.0)
            if not (np.all(np.isfinite(free)) and np.all(np.isfinite(scalars))):
                return states, impulses, counts, works, StopReason.NON_FINITE
            if np.any(scalars[4:] <= 0):
                return states, impulses, counts, works, StopReason.LEFT_DOMAIN
            if problem is not None:
                if solves == self.max_solves:
                    return states, impulses, counts, works, StopReason.STEP_LIMIT
                solves += 1
                count, answer = self.solve(problem)
                if answer is None:
                    return states, impulses, counts, works, StopReason.NO_MODE
                impulse = answer
            u = free + normal * impulse[0] + tangential * impulse[1]
            forward = h / 2 if self.stepper.scheme == "moreau-jean" else h
            after = states[-1][2 * self.size :] + h
            states.append(np.concatenate([place + forward * u, u, after]))
            impulses.append(impulse)
            counts.append(count)
            works.append(_work(impulse, rates, scalars[1:4]))
        return states, impulses, counts, works, StopReason.T_END


def _work(impulse: Impulse, free: Array, W: Array) -> float:
    """Return Λ·(v_free + v⁺)/2 = Λ·v_free + Λ·W Λ/2."""
    normal, tangential = impulse
    own = W[0] * normal**2 + 2 * W[1] * normal * tangential + W[2] * tangential**2
    return float(normal * free[0] + tangential * free[1] + own / 2)
