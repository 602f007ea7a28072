"""Motions in pieces: each continues the one before, with what changes at a known time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from painleve_sym.engines.protocol import RunSettings
from painleve_sym.errors import InputError, StopReason, refuse_unknown
from painleve_sym.laws.catalogue import as_law
from painleve_sym.motion.joined import JoinedRecord, joined
from painleve_sym.motion.timetable import MAX_PIECES, Timetable
from painleve_sym.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from painleve_sym.motion.simulator import Simulator

_TABLES = ("parameters", "law_parameters")


def run_in_pieces(
    simulator: Simulator,
    timetable: Timetable,
    settings: RunSettings,
    given: Mapping[str, Any],
    origin: Trajectory | None = None,
) -> Trajectory:
    """Return a motion from a start, or from the end of another one, with what changes on its way.

    Its pieces are those of `Trajectory.continued`, cut where something changes.

    Parameters
    ----------
    simulator : Simulator
        Of the whole mechanism with its law at the start.
    timetable : Timetable
    settings : RunSettings
    given : mapping
        State and parameters, as for `Simulator.run`.
    origin : Trajectory, optional
        The motion before.
    """
    pieces = _Pieces(simulator, timetable, settings, given, origin)
    return joined(simulator, pieces.timetable, pieces.run())


class _Pieces:
    """The pieces of one motion, as they are run."""

    def __init__(
        self,
        simulator: Simulator,
        timetable: Timetable,
        settings: RunSettings,
        given: Mapping[str, Any],
        origin: Trajectory | None,
    ) -> None:
        self.simulator, self.left, self.given = simulator, settings, dict(given)
        self.last = origin
        if origin is not None and isinstance(origin.record, JoinedRecord):
            self.last = origin.record.pieces[-1]
        self.time = 0.0 if origin is None else origin.final_time
        self.t_end = float(settings.t_end)
        timetable.check(simulator.where, self.time, self.t_end)
        self.timetable = timetable.beginning(self._state(origin), self.time)
        # What was in force before this motion began; a change at its beginning is one of its own.
        self.since = -math.inf if origin is None else math.nextafter(self.time, -math.inf)
        self.kinds = self.timetable.changes(self.since, -math.inf)
        self.runners: dict[Any, Simulator] = {}
        self.before: Simulator | None = None
        self.values: dict[str, float] = {}

    def _state(self, origin: Trajectory | None) -> Mapping[str, float]:
        """Return the state at the beginning, to be given to the first piece."""
        if origin is not None:
            return origin.final
        mechanism, state = self.simulator.mechanism, self.given.get("state")
        where = f"state of {mechanism.name!r}"
        whole = mechanism.outline.state(where, mechanism.start if state is None else state)
        if self.simulator.pulses:
            own = self.simulator.stepped.mechanism.state_names
            self.given["state"] = {name: whole[name] for name in own}
        return whole

    def run(self) -> list[Trajectory]:
        """Return the pieces up to the end, or to where the motion stops before."""
        pieces = list[Trajectory]()
        while True:
            run, stop = self._piece(begins=not pieces)
            self.since, self.time, self.last = self.time, stop, run
            pieces.append(run)
            if run.stop_reason is not StopReason.T_END or stop >= self.t_end:
                return pieces
            if (reason := self._limit(run, len(pieces))) is not None:
                pieces[-1] = replace(run, stop_reason=reason)
                return pieces

    def _limit(self, run: Trajectory, count: int) -> StopReason | None:
        """Return the reason to stop after a piece, where a limit of the whole motion is reached."""
        if count >= MAX_PIECES:
            raise InputError(
                f"{self.simulator.where}: got more than {MAX_PIECES:,} changes up to t = "
                f"{self.time:g} s, need fewer. Fix: end earlier, or continue from there."
            )
        did, left = run.counters, self.left
        steps = left.max_steps - did["accepted_steps"] - did["rejected_steps"]
        events = left.max_events - did["events"]
        if steps < 1 or events < 1:
            return StopReason.STEP_LIMIT if steps < 1 else StopReason.EVENT_LIMIT
        self.left = replace(left, max_steps=steps, max_events=events)
        return None

    def _piece(self, begins: bool) -> tuple[Trajectory, float]:
        """Return the next piece and its end, with what changes at its beginning."""
        change = self.timetable.changes(self.time, self.since, begins)
        given = {k: v for k, v in change.items() if k in _TABLES}
        runner, stop = self._runner(change), min(self.timetable.after(self.time), self.t_end)
        if begins:
            given = {**self.given, **{k: {**(self.given.get(k) or {}), **given[k]} for k in given}}
        elif runner is not self.before:
            given = self._of_runner(runner, given)
        if self.timetable.pulses:
            stop, pulses = self.timetable.pulsed(
                runner.where, self.time, stop, self._numbers(runner, given)
            )
            given["parameters"] = {**(given.get("parameters") or {}), **pulses}
        settings = replace(self.left, t_end=stop)
        if self.last is None:
            run = runner.fresh(given.pop("state", None), settings, given)
        else:
            run = runner.rest(self.last, settings, given)
        self.before = runner
        self.values |= {self._whole_name(runner, n): v for n, v in run.parameters.items()}
        return run, stop

    def _numbers(self, runner: Simulator, given: Mapping[str, Any]) -> Mapping[str, float]:
        """Return the parameters of the next piece."""
        begins = {k: given.get(k) for k in (*_TABLES, "material")}
        if not self.values and self.last is None:
            return runner.at({}, **begins).parameters
        before = self.values if self.last is None or self.values else self.last.parameters
        own = {n: before[n] for n in runner.declared.by_name if n in before}
        return runner.parameters(own | runner.given(*(given.get(k) for k in _TABLES)))

    def _runner(self, change: Mapping[str, Any]) -> Simulator:
        """Return the simulator of the law and the contacts that there are from a change on."""
        self.kinds |= change
        law, contacts = self.kinds.get("law"), self.kinds.get("contacts")
        key = repr(law), repr(contacts)
        if key not in self.runners:
            self.runners[key] = _simulator(self.simulator.stepped, law, contacts)
        return self.runners[key]

    def _of_runner(self, runner: Simulator, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return all parameters by the names that another simulator has for them."""
        own = {n: self._whole_name(runner, n) for n in runner.declared.by_name}
        by_whole = {whole: n for n, whole in own.items()}
        known = {n: self.values[whole] for n, whole in own.items() if whole in self.values}
        named = {
            table: {by_whole.get(n, n): v for n, v in values.items()}
            for table, values in given.items()
        }
        return named | {"parameters": known | named.get("parameters", {})}

    def _whole_name(self, runner: Simulator, name: str) -> str:
        """Return the name of a parameter in the whole mechanism, where one contact is left."""
        return whole_name(name, runner.names.contacts, self.simulator.stepped.declared.by_name)


def whole_name(name: str, contacts: tuple[str, ...], known: Mapping[str, Any]) -> str:
    """Return a name with the only contact behind it, where that is known and the name is not."""
    full = f"{name}_{contacts[0]}"
    return full if len(contacts) == 1 and name not in known and full in known else name


def _simulator(whole: Simulator, law: Any, contacts: Sequence[str] | None) -> Simulator:
    """Return the simulator of some contacts with another law; None leaves either as it is."""
    if law is None and contacts is None:
        return whole
    own = whole.law if law is None else as_law(law)
    names = [c.name for c in whole.mechanism.outline.contacts]
    for name in contacts or ():
        refuse_unknown("contact", name, names, f"{whole.where}: phases: contacts")
    present = [n for n in names if contacts is None or n in contacts]
    if not present:
        raise InputError(
            f"{whole.where}: phases: contacts: got none, need one at least. Fix: keep one that is "
            "out of reach."
        )
    mechanism = whole.mechanism
    if len(present) < len(names):
        mechanism = mechanism.only(*present)
        if isinstance(own, Mapping):
            own = {name: own[name] for name in present}
    return type(whole)(mechanism, own, whole.engine, whole.watch)
