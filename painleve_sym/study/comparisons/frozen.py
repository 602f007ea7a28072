"""The answers of each method with the configuration frozen: those of one impact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.at.closing import closing_hint
from painleve_sym.at.delassus import ContactNumbers, Delassus, MotionNumbers
from painleve_sym.at.inputs import refuse_infinite, refuse_place
from painleve_sym.at.jump import JumpResult, contact_velocity_at
from painleve_sym.choices import Restitution
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.errors import EventKind, InputError, StopReason
from painleve_sym.laws.catalogue import compliant_law
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.impact.one_contact import ImpactEnd
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.rounding import MOVED, rounded
from painleve_sym.problem.solution import ContactSolution
from painleve_sym.study.comparisons.case import LIFTOFF, AccelerationLevel, Answer, Case, FirstStep

if TYPE_CHECKING:
    from painleve_sym.motion.frozen_in_space import FrozenSpatialMotion

_HELD = "the compression oscillates without end: the contact is held, and there is no impact"
_LONG = "the contact has not opened by the end time: it is held, or a longer end time is needed"
_NO_STEP = "the step has no solution"
NAN = float("nan")
_PLACES = {"least-impulse": 0, "largest-impulse": -1}
"""Places of the solutions that solvers take, in the order of their normal impulse."""


@dataclass(frozen=True)
class FrozenCase(Case):
    """A contact with the W, b and μ of its state: the impact that follows.

    Rigid answers are jumps, at t = 0. A time step is a single one, with the friction that its own
    last slip velocity has. A compliant motion goes up to where the contact opens.
    """

    solvers = tuple(_PLACES)
    contrasted = tuple(_PLACES)

    @cached_property
    def _whole(self) -> tuple[ContactNumbers, MotionNumbers]:
        at, moves = Delassus.of(self.mechanism).whole_at(self.place.values)
        refuse_place(self.place, at)
        refuse_infinite(self.mechanism, self.place.values, at)
        gap = float(at.gap[0])
        if not abs(gap) <= at.gap_tolerance[0]:
            side = "inside the ground" if gap < 0 else "above the ground"
            raise InputError(
                f"{self.where}: the contact starts {side}, gap = {gap:g} m, need 0: in space the "
                f"configuration is frozen. {closing_hint(self.mechanism, 0)}."
            )
        return at, moves

    @cached_property
    def _contact(self) -> tuple[Array, Array, float]:
        """W, b and μ."""
        at, _ = self._whole
        return (at.W + at.W.T) / 2, at.b, float(at.mu[0])

    @cached_property
    def _velocity(self) -> Array:
        """Velocity of the contact at the start, along n, t1, t2; m/s."""
        velocity = np.array(contact_velocity_at(self.mechanism, self.place.values, *self._whole))
        if self.closed_at_rest[1]:
            velocity[0] = 0.0
        return velocity

    def check_step(self, step: float) -> None:
        """Raise InputError for a step that is longer than the end time, or not positive."""
        if not 0 < step <= self.t_end * (1 + 1e-9):
            raise InputError(
                f"{self.where}: step: got {step!r}, need a number in (0, t_end = {self.t_end!r}]."
            )

    # ---- one time step ----

    def first_steps(self, steps: Sequence[float]) -> tuple[FirstStep, ...]:
        """Return the problems of one time step of each length, solved."""
        return tuple(FirstStep(h, self._step(h).solutions()) for h in steps)

    def _step(self, h: float) -> ContactProblem:
        """Return the problem v⁺ = v + h b + W P of a step, v_n⁺ counted from −e v_n of the start.

        It is that of a contact at rest, with impulses for forces and velocities after the step for
        accelerations.
        """
        W, b, mu = self._contact
        free = self._velocity + h * b
        free[0] += self.e * min(self._velocity[0], 0.0)
        return ContactProblem(W, free, mu, np.zeros(2))

    # ---- the answers ----

    def rigid_answers(self, level: AccelerationLevel | None) -> list[Answer]:
        """Return the jumps by every rule, and lift-off where that is possible."""
        answers = []
        if level and any(s.mode is ContactMode.LIFTOFF for s in level.classification.solutions):
            none = np.zeros(3)
            answers.append(self._answer("rigid", LIFTOFF, NAN, 0.0, none, StopReason.UNTIL))
        rules = [(str(rule), rule, self.e) for rule in Restitution]
        for way, rule, e in (*rules, ("plastic", Restitution.ENERGETIC, 0.0)):
            if (jump := self.jump(rule, e)) is not None:
                answers.append(self._of_jump(way, jump))
        return answers

    def _of_jump(self, way: str, jump: JumpResult) -> Answer:
        parts = [p.impulse for p in jump.phases]
        jams = jump.end is ImpactEnd.JAM
        reason = StopReason.JAM if jams else StopReason.UNTIL
        impulse = np.array(parts).sum(axis=0) if parts else np.zeros(3)
        events = ((0.0, str(EventKind.JAM if jams else EventKind.IMPACT)),)
        return self._answer("rigid", way, NAN, 0.0, impulse, reason, events=events)

    def stepping(self, steps: Sequence[float], solvers: Sequence[str]) -> list[Answer]:
        """Return the answers of one step of each length."""
        solutions = {h: self._step(h).solutions() for h in steps}
        return [self._stepped(solver, h, solutions[h]) for solver in solvers for h in steps]

    def _stepped(self, solver: str, h: float, solutions: Sequence[ContactSolution]) -> Answer:
        if not solutions:
            none, end = np.zeros(3), StopReason.NO_MODE
            return self._answer("stepping", solver, h, 0.0, none, end, stop_detail=_NO_STEP)
        taken = solutions[_PLACES[solver]]
        return self._answer(
            method="stepping",
            way=solver,
            setting=h,
            time=h,
            impulse=taken.force,
            reason=StopReason.UNTIL,
            solutions_first_step=len(solutions),
            first_impulse=float(taken.force[0]),
            first_mode=taken.mode.value,
        )

    def softened_answers(self, stiffness: Sequence[float]) -> tuple[list[Answer], float]:
        """Return the compliant motions up to where the contact opens, and the law's exponent."""
        law = compliant_law("bilinear-hertz", reload="elastic")
        from painleve_sym.motion.frozen_in_space import FrozenSpatialSolver

        solver, (W, b, mu) = FrozenSpatialSolver(law, self.engine), self._contact
        # With e = 0 nothing is given back: the impact ends with its compression.
        until = (EventKind.SEPARATION if self.e else EventKind.MAX_COMPRESSION,)
        answers = []
        for value in stiffness:
            given = {"E": value, "e_energetic": self.e}
            motion = solver(W, b, mu, self._velocity, given, t_end=self.t_end, until=until)
            answers.append(self._of_motion(law.name, value, motion))
        values = {p.name: p.default for p in law.parameters}
        return answers, float(numbers([law.exponent], values)[0])

    def _of_motion(self, way: str, value: float, motion: FrozenSpatialMotion) -> Answer:
        flies = motion.stop_reason is StopReason.T_END and not motion.impulse.any()
        reason = motion.stop_reason
        if not self.e and any(kind == EventKind.MAX_COMPRESSION for _, kind in motion.events):
            reason = StopReason.UNTIL  # of what follows at that instant there is no end
        ends = flies or reason is StopReason.UNTIL
        details = {StopReason.EVENT_LIMIT: _HELD, StopReason.T_END: _LONG}
        return self._answer(
            method="softened",
            way=way,
            setting=value,
            time=motion.duration,
            impulse=motion.impulse,
            reason=reason,
            complete=ends,
            stop_detail="" if ends else details.get(reason, reason.sentence),
            peak_force=motion.peak_force,
            events=motion.events,
            times=np.append(motion.times, motion.duration),
            contact_velocities=np.vstack([motion.velocities, motion.velocity]),
        )

    def _answer(
        self,
        method: str,
        way: str,
        setting: float,
        time: float,
        impulse: Array,
        reason: StopReason,
        **own: Any,
    ) -> Answer:
        """Return the answer of an impulse that has acted by a time."""
        _, moves = self._whole
        W, b, _ = self._contact
        before = self.start_velocities
        change = moves.D @ impulse
        after = before + change + time * moves.free
        sizes = abs(before) + abs(moves.D) @ abs(impulse) + abs(time * moves.free)
        after = rounded(after, sizes, MOVED) + 0.0
        velocity = dict(zip(self.velocities, after.tolist(), strict=True))
        end = self._velocity + W @ impulse + time * b
        own = {
            "peak_force": NAN,
            "events": (),
            "complete": reason is StopReason.UNTIL,
            "stop_detail": "" if reason is StopReason.UNTIL else reason.sentence,
            "times": np.array([0.0, time]),
            "contact_velocities": np.stack([self._velocity, end]),
            **own,
        }
        return Answer(
            method=method,
            way=way,
            setting=setting,
            stop_reason=reason,
            final_time=time,
            state={**self.place.state, **velocity},
            velocity=velocity,
            impulse=tuple(impulse.tolist()),
            **own,
        )

    # ---- the ruler ----

    def distance(self, answer: Answer, rigid: Answer) -> float:
        """Return the distance by kinetic energy, relative to the largest speed; see `Answer`.

        It is that of the velocities at one time, the rigid motion being free after its jump: they
        differ by M⁻¹Jᵀ ΔP, and √(ΔP·W ΔP) is the size of that.
        """
        W, _, _ = self._contact
        _, moves = self._whole
        P, energy = np.array(rigid.impulse), float(moves.kinetic_energy[0])
        gained = float((moves.J @ self.start_velocities) @ P + P @ W @ P / 2)
        difference = np.array(answer.impulse) - P
        sizes = (
            float(np.sqrt(2 * energy)),
            float(np.sqrt(max(0.0, 2 * (energy + gained)))),
            float(np.sqrt(W[0, 0])) * rigid.normal_impulse,
        )
        size = float(np.sqrt(max(0.0, difference @ W @ difference)))
        return size / max(sizes) if max(sizes) > 0 else size
