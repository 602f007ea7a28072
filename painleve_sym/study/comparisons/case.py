"""One state that every method is asked about, and their answers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.at.cases import classify_at
from painleve_sym.at.classification import Classification
from painleve_sym.at.delassus import ContactNumbers, Delassus
from painleve_sym.at.jump import JumpResult, evaluate_jump
from painleve_sym.choices import EngineLike, Restitution
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, StopReason, refuse_unknown
from painleve_sym.laws.catalogue import compliant_law
from painleve_sym.laws.restitution import restitution_law
from painleve_sym.mechanics.declarations import ParameterSet
from painleve_sym.mechanics.mechanism import Mechanism, Place
from painleve_sym.motion.singular_limit import SingularLimit
from painleve_sym.motion.time_stepping.mpcc import MPCCSurvey, solve_mpcc_all
from painleve_sym.problem.complementarity.lcp import LCPSolution
from painleve_sym.problem.complementarity.lemke import LemkeResult, solve_lemke
from painleve_sym.problem.rounding import MOVED, rounded
from painleve_sym.problem.solution import ContactSolution

LIFTOFF = "liftoff"
"""Way of a rigid motion without an impact."""


@dataclass(frozen=True)
class AccelerationLevel:
    """The contact problem of the state itself, solved three ways; discs are only enumerated."""

    classification: Classification
    lemke: LemkeResult[LCPSolution] | None = None
    mpcc: MPCCSurvey | None = None


@dataclass(frozen=True, eq=False)
class Answer(Compared):
    """Result of one method: ``rigid``, ``stepping`` or ``softened``.

    `complete` tells whether it came to where methods are compared: the end time, and where the
    configuration is frozen, the end of the impact.

    `way` is the restitution rule and policy, the solver, or the contact law; `setting` the step in
    s or Young's modulus in Pa, nan for a rigid motion. `stop_detail` says in words why it ended.
    State and velocities are those at `final_time`, before the end time where the motion ended
    early.

    `impulse` is ∫F dt along n and the tangents, with the impulses of impacts up to then; of an
    impact that jams, up to where its impulse begins to grow without end; N s. `peak_force` is nan
    where forces are not distinguished from impulses; N. Events are times and kinds; time stepping
    has none. `contact_velocities` are those along n and the tangents at `times`; m/s.

    Of time stepping alone are the number of solutions and the impulse of the first step (−1 and nan
    elsewhere), and what the contact does in it: open, liftoff, slip or stick; else empty. `limit`
    is of a rigid motion that ended where its slip meets A = 0: where it would arrive.

    `reference` is the rigid motion nearest to the finest answer of this way: of the energetic rule
    for compliant motion, of Newton's for time stepping; empty for a rigid motion and for one that
    ended early. `error` is the distance to it in the metric of the kinetic energy, relative to the
    largest of the speeds of the start, of the rigid motion and of what its P_n alone would give,
    √W_nn P_n; else nan.
    """

    method: str
    way: str
    setting: float
    stop_reason: StopReason
    stop_detail: str
    complete: bool
    final_time: float
    state: dict[str, float]
    velocity: dict[str, float]
    impulse: tuple[float, ...]
    peak_force: float
    events: tuple[tuple[float, str], ...]
    times: Array = field(repr=False)
    contact_velocities: Array = field(repr=False)
    solutions_first_step: int = -1
    first_impulse: float = float("nan")
    first_mode: str = ""
    limit: SingularLimit | None = None
    reference: str = ""
    error: float = float("nan")

    @property
    def normal_impulse(self) -> float:
        """P_n; N s."""
        return self.impulse[0]

    @property
    def contact_velocity(self) -> Array:
        """The last of `contact_velocities`, 0 where it is rounding beside the largest; m/s."""
        largest = np.abs(self.contact_velocities).max()
        return rounded(self.contact_velocities[-1], largest, MOVED) + 0.0

    def same_end(self, other: Answer) -> bool:
        """Whether both end at one time, for one reason, with the same state."""
        ends = [(a.final_time, a.stop_reason, a.state) for a in (self, other)]
        return ends[0] == ends[1]


@dataclass(frozen=True)
class FirstStep:
    """The velocity-level problem of the first step, s, with all its solutions.

    Their forces are impulses, N s, and their accelerations velocities after the step, m/s.
    """

    step: float
    solutions: tuple[ContactSolution, ...]


@dataclass(frozen=True)
class Case(ABC):
    """One state with its parameters, complete and checked."""

    place: Place
    e: float
    t_end: float
    engine: EngineLike

    solvers: ClassVar[Collection[str]]
    """Solvers of its time steps, by name."""
    contrasted: ClassVar[Sequence[str]]
    """Those taken where none are named."""

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return self.place.mechanism

    @property
    def where(self) -> str:
        """Its name in error messages."""
        return f"contrast of {self.mechanism.name!r}"

    @cached_property
    def at(self) -> ContactNumbers:
        """The numbers of the contact at the start."""
        return Delassus.of(self.mechanism).at(self.place.values)

    @cached_property
    def closed_at_rest(self) -> tuple[bool, bool]:
        """Whether the gap of the start is 0, and whether its normal velocity is."""
        at = self.at
        closed = abs(at.gap) <= at.gap_tolerance, abs(at.gap_rate) <= at.rate_tolerance
        return bool(closed[0].all()), bool(closed[1].all())

    @property
    def velocities(self) -> tuple[str, ...]:
        """Names of the velocities."""
        return self.mechanism.outline.velocity_names

    @cached_property
    def start_velocities(self) -> Array:
        """Those of the start, in the order of `velocities`."""
        return np.array([self.place.state[name] for name in self.velocities])

    def check(
        self, steps: Sequence[float], stiffness: Sequence[float], solvers: Sequence[str]
    ) -> None:
        """Raise InputError for whatever cannot be used, before anything is computed."""
        e = restitution_law(Restitution.ENERGETIC).parameter
        ParameterSet(e).values(self.where, {e.name: self.e})
        for name, values in (("steps", steps), ("stiffness", stiffness), ("solvers", solvers)):
            if not values:
                raise InputError(f"{self.where}: {name}: got none, need at least one.")
        for solver in solvers:
            refuse_unknown("solver", solver, self.solvers, self.where)
        for step in steps:
            self.check_step(step)
        young = next(p for p in compliant_law("bilinear-hertz").parameters if p.name == "E")
        for value in stiffness:
            ParameterSet(young).values(f"{self.where}: stiffness", {"E": value})

    @abstractmethod
    def check_step(self, step: float) -> None:
        """Raise InputError for a step that cannot be used, s."""

    # ---- the answers ----

    def acceleration_level(self) -> AccelerationLevel | None:
        """Return the contact problem of the state, solved; None where it is open or closing."""
        if not all(self.closed_at_rest):
            return None
        classification = classify_at(self.place)
        if not classification.problem.in_plane:
            return AccelerationLevel(classification)
        lcp = classification.problem.lcp()
        return AccelerationLevel(classification, solve_lemke(lcp), solve_mpcc_all(lcp, compared=2))

    @abstractmethod
    def first_steps(self, steps: Sequence[float]) -> tuple[FirstStep, ...]:
        """Return the first time steps in which the contact is closed, solved."""

    @abstractmethod
    def rigid_answers(self, level: AccelerationLevel | None) -> list[Answer]:
        """Return the rigid answers: by both rules, and where several motions are possible all."""

    @abstractmethod
    def stepping(self, steps: Sequence[float], solvers: Sequence[str]) -> list[Answer]:
        """Return the answers of each solver, from the longest step to the shortest."""

    @abstractmethod
    def softened_answers(self, stiffness: Sequence[float]) -> tuple[list[Answer], float]:
        """Return the compliant answers, and the exponent of the law."""

    def jumps(self) -> dict[str, JumpResult]:
        """Return the energetic jump with e and with 0; nothing where the state is not an impact."""
        named = ("e", self.e), ("plastic", 0.0)
        jumps = {name: self.jump(Restitution.ENERGETIC, e) for name, e in named}
        return {name: jump for name, jump in jumps.items() if jump is not None}

    def jump(self, rule: Restitution, e: float) -> JumpResult | None:
        """Return the rigid jump by a rule; None where the state is not an impact."""
        if not self.closed_at_rest[0]:
            return None
        given = {**self.place.parameters, f"e_{rule}": e}
        try:
            return evaluate_jump(self.mechanism, rule, self.place.state, parameters=given)
        except InputError:  # the state is not an impact: the contact problem says what it is
            return None

    # ---- the ruler ----

    def measured(self, answers: Sequence[Answer], rigid: Sequence[Answer]) -> list[Answer]:
        """Return the answers of one way with their distance to the rigid motion they tend to."""
        complete = [a for a in answers if a.complete]
        softened = complete and complete[0].method == "softened"
        rule = Restitution.ENERGETIC if softened else Restitution.NEWTON
        known = [r for r in rigid if r.complete and r.way.startswith((rule, LIFTOFF))]
        if not (complete and known):
            return list(answers)
        # The last answer is the finest.
        nearest = min(known, key=lambda r: self.distance(complete[-1], r))
        done = [replace(a, reference=nearest.way, error=self.distance(a, nearest)) for a in answers]
        return [b if a.complete else a for a, b in zip(answers, done, strict=True)]

    @abstractmethod
    def distance(self, answer: Answer, rigid: Answer) -> float:
        """Return the distance by kinetic energy, relative to the largest speed; see `Answer`."""
