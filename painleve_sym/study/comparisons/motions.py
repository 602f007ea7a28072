"""The answers of each method by motions up to the end time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.automata.model import IMPULSES
from painleve_sym.choices import Policy, Restitution
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.errors import StopReason
from painleve_sym.laws.catalogue import compliant_law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.motion.run_record import RunRecord
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.time_stepping.step_solvers import SOLVERS
from painleve_sym.motion.time_stepping.stepping import SteppingRun, TimeStepper
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.problem.solution import ContactCase
from painleve_sym.study.comparisons.case import AccelerationLevel, Answer, Case, FirstStep

CONTRASTED = ("least-impulse", "largest-impulse", "lemke", "mpcc")
RULES = (Restitution.ENERGETIC, Restitution.NEWTON)
SINGLE = ("lemke", "mpcc")
"""Solvers that end at one solution; the others enumerate all and choose."""
GAUSS_POINTS = 16
"""Of the impulse of a step: as many as a Taylor series over it has good terms."""
MPCC_SOLVES = 12
"""IPOPT takes some 0.1 s per problem: enough for ten steps in contact."""


@dataclass(frozen=True)
class MotionCase(Case):
    """Rigid, stepped and compliant motions of a planar contact up to the end time."""

    solvers = SOLVERS
    contrasted = CONTRASTED

    @cached_property
    def _stepper(self) -> TimeStepper:
        return TimeStepper(self.mechanism)

    def check_step(self, step: float) -> None:
        """Raise InputError for a step that is longer than the motion, or not positive."""
        self._stepper.check(step, self.t_end)

    def first_steps(self, steps: Sequence[float]) -> tuple[FirstStep, ...]:
        """Return the first time steps in which the contact is closed, solved."""
        first_steps, parameters = [], self.place.parameters
        for h in steps:
            problem = self._stepper.first_problem(
                self.place.state, h, e=self.e, parameters=parameters
            )
            if problem is not None:
                first_steps.append(FirstStep(h, problem.solutions()))
        return tuple(first_steps)

    # ---- motions ----

    def rigid_answers(self, level: AccelerationLevel | None) -> list[Answer]:
        """Return the event-driven motions: both rules, and each policy where it matters."""
        several = level and level.classification.case is ContactCase.INDETERMINATE
        answers: list[Answer] = []
        for rule in RULES:
            for policy in Policy if several else (Policy.LIFTOFF,):
                simulator = Simulator(self.mechanism, RigidLaw(rule, policy), self.engine)
                given = {**self.place.parameters, f"e_{rule}": self.e}
                run = simulator.run(self.place.state, parameters=given, t_end=self.t_end)
                name = f"{rule}, {policy}" if several else rule
                answer = self._answer("rigid", name, float("nan"), run)
                total = np.array(answer.impulse) + _impulse_of_impacts(run)
                answers.append(replace(answer, impulse=tuple(total.tolist())))
        return answers

    def softened_answers(self, stiffness: Sequence[float]) -> tuple[list[Answer], float]:
        """Return the answers, and the exponent of the law."""
        chosen = compliant_law("bilinear-hertz", reload="virgin")
        simulator = Simulator(self.mechanism, chosen, self.engine)
        answers = []
        # With e = 0 nothing is given back: the impact ends with its compression.
        until = () if self.e else "max_compression"
        for value in stiffness:
            given = {**self.place.parameters, "E": value, "e_energetic": self.e}
            run = simulator.run(self.place.state, parameters=given, t_end=self.t_end, until=until)
            answers.append(self._answer("softened", chosen.name, value, run))
        constants = simulator.constants(simulator.parameters(given))
        return answers, float(numbers([chosen.exponent], constants)[0])

    def _answer(self, method: str, way: str, setting: float, run: Trajectory) -> Answer:
        # Each event has its instant and the one before, so that a jump is drawn as one.
        events = np.array([e.time for e in run.events])
        times = np.concatenate([run.fine_times(8), events, np.nextafter(events, -np.inf)])
        times = np.unique(times[times >= 0])
        outputs = run.outputs(times)
        rigid = method == "rigid"
        contact_velocities = np.column_stack([outputs["gap_rate"], outputs["slip_velocity"]])
        # A rigid jump at t = 0 is drawn from the start.
        times = np.append(0.0, times)
        contact_velocities = np.vstack([self.at.v, contact_velocities])
        return Answer(
            method=method,
            way=way,
            setting=setting,
            stop_reason=run.stop_reason,
            stop_detail=run.stop_detail,
            complete=run.stop_reason is StopReason.T_END,
            final_time=run.final_time,
            state={n: run.final[n] for n in self.place.state},
            velocity={n: run.final[n] for n in self.velocities},
            impulse=_impulse_of_forces(run),
            peak_force=float("nan") if rigid else float(np.max(outputs["normal_force"])),
            events=tuple((e.time, e.kind) for e in run.events),
            times=times,
            contact_velocities=contact_velocities,
            limit=run.limit,
        )

    def stepping(self, steps: Sequence[float], solvers: Sequence[str]) -> list[Answer]:
        """Return the answers of each solver, from the longest step to the shortest."""
        enumerated: dict[float, SteppingRun] = {}
        answers = []
        for solver in solvers:
            for h in steps:
                run = enumerated.get(h)
                if run is None or solver in SINGLE:
                    options: dict[str, Any] = (
                        {"max_solves": MPCC_SOLVES} if solver == "mpcc" else {}
                    )
                    run = self._stepper.run(
                        self.place.state,
                        step=h,
                        t_end=self.t_end,
                        solver=solver,
                        e=self.e,
                        parameters=self.place.parameters,
                        **options,
                    )
                    if solver not in SINGLE and np.all(run.solutions_found <= 1):
                        enumerated[h] = run  # no choice anywhere: every rule gives this run
                answers.append(self._stepped(run, solver))
        return answers

    def _stepped(self, run: SteppingRun, solver: str) -> Answer:
        none = not len(run.impulses)
        return Answer(
            method="stepping",
            way=solver,
            setting=run.step,
            stop_reason=run.stop_reason,
            stop_detail=run.stop_detail,
            complete=run.stop_reason is StopReason.T_END,
            final_time=float(run.times[-1]),
            state=run.final,
            velocity={n: run.final[n] for n in self.velocities},
            impulse=tuple(float(np.sum(column)) for column in run.impulses.T),
            peak_force=float("nan"),
            events=(),
            times=run.times,
            contact_velocities=run.contact_velocities,
            solutions_first_step=0 if none else int(run.solutions_found[0]),
            first_impulse=float("nan") if none else float(run.impulses[0, 0]),
            first_mode="" if none else self._mode(run),
        )

    def _mode(self, run: SteppingRun) -> str:
        normal, tangential = run.impulses[0]
        if run.solutions_found[0] < 0:
            return "open"
        if normal == 0:
            return "liftoff"
        mu = self.place.parameters[str(self.mechanism.contact.friction)]
        # Round-off of the solvers; sticking on the edge of the cone counts as slip.
        return "stick" if abs(tangential) < mu * normal * (1 - 1e-9) else "slip"

    # ---- the ruler ----

    @cached_property
    def mass(self) -> Array:
        """M at the start, shape (n, n)."""
        M = self.mechanism.system.mass_matrix
        return numbers(list(M), self.place.values).reshape(M.shape)

    def distance(self, answer: Answer, rigid: Answer) -> float:
        """Return the distance by kinetic energy, relative to the largest speed; see `Answer`."""
        ends = [np.array([x.velocity[n] for n in self.velocities]) for x in (answer, rigid)]
        # Beyond 1e154 m/s an energy has no number, and neither has the distance: inf or nan.
        with np.errstate(over="ignore", invalid="ignore"):
            moving = (ends[0] - ends[1], ends[1], self.start_velocities)
            difference, *sizes = (float(np.sqrt(u @ self.mass @ u)) for u in moving)
        # A body held at rest has no speed but round-off: what its contact has stopped counts too.
        sizes.append(rigid.normal_impulse * float(np.sqrt(self.at.W[0, 0])))
        return difference / max(sizes) if max(sizes) > 0 else difference


def _impulse_of_forces(run: Trajectory) -> tuple[float, ...]:
    """Return ∫F dt over all steps along n and t, by Gauss's rule in each; N s."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    times = run.step_time[:, None] + (1 + nodes) / 2 * run.step_length[:, None]
    outputs = run.outputs(times.ravel())
    forces = (outputs[name].reshape(times.shape) for name in ("normal_force", "tangential_force"))
    return tuple(float(run.step_length @ force @ weights) / 2 for force in forces)


def _impulse_of_impacts(run: Trajectory) -> Array:
    """Return the sum of the impulses along n and t of the impacts of a rigid motion; N s."""
    if IMPULSES[0] not in run.memory_names:
        return np.zeros(2)
    assert isinstance(run.record, RunRecord)
    events, names = run.record.raw.event_records, run.memory_names
    columns = [names.index(name) for name in IMPULSES]
    growth = (events.memory_after - events.memory_before)[:, columns]
    # That along n grows with every phase of an impact, and both begin at 0 with the next one.
    return np.asarray(growth[growth[:, 0] > 0].sum(axis=0))
