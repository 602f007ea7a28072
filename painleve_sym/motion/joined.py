"""Pieces of a motion joined to one: their steps, events and outputs under common names."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.automata.model import LOSSES
from painleve_sym.codegen.tape import TapeOutputs
from painleve_sym.engines.batch import AtEvents
from painleve_sym.engines.records import StepRecords
from painleve_sym.motion.energy_gains import EnergyGain
from painleve_sym.motion.pressed_start import PressedStart
from painleve_sym.motion.pressing import ContactSurface
from painleve_sym.motion.records import PIECE, EngineOutputs, EventRecord, MotionNames
from painleve_sym.motion.rigidity import BodyPeriod
from painleve_sym.motion.run_record import LiveRecord
from painleve_sym.motion.singular_limit import ReverseChatter

if TYPE_CHECKING:
    from painleve_sym.motion.simulator import Simulator
    from painleve_sym.motion.timetable import Timetable
    from painleve_sym.motion.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class PieceOutputs:
    """Outputs of the pieces of one simulator, and the columns in which the whole motion has them.

    `modes` are the indices of its own modes by those of the motion, `constants` their number.
    """

    evaluator: EngineOutputs | TapeOutputs
    states: tuple[int, ...]
    memory: tuple[int, ...]
    outputs: tuple[int, ...]
    modes: tuple[int, ...]
    constants: int


_PLACES = ("states", "memory", "outputs", "modes")


@dataclass(frozen=True, eq=False)
class JoinedOutputs:
    """Outputs of a motion in pieces; the last memory is the index of the piece.

    `kinds` are those of the simulators, `of` the kind of each piece, and `none` the values of
    outputs that a piece lacks.
    """

    kinds: tuple[PieceOutputs, ...]
    of: tuple[int, ...]
    none: tuple[float, ...]

    def outputs(self, modes: Any, states: Array, memory: Array, constants: Array) -> Array:
        """Return the outputs at n points, shape (n, no); constants have a row for each piece."""
        values = np.tile(np.array(self.none), (len(states), 1))
        pieces, modes = memory[:, -1].astype(np.int64), np.asarray(modes)
        for piece in np.unique(pieces):
            rows, kind = np.flatnonzero(pieces == piece), self.kinds[self.of[piece]]
            own = np.array(kind.modes)[modes[rows]]
            at = states[np.ix_(rows, kind.states)], memory[np.ix_(rows, kind.memory)]
            held = constants[piece, : kind.constants]
            values[np.ix_(rows, kind.outputs)] = kind.evaluator.outputs(own, *at, held)
        return values

    def portable(self) -> JoinedOutputs:
        """Return the same with tapes in place of engines."""
        kinds = (replace(k, evaluator=k.evaluator.portable()) for k in self.kinds)
        return replace(self, kinds=tuple(kinds))

    def to_data(self) -> dict[str, Any]:
        """Return the tapes, of `portable` outputs, and their places as plain data."""
        kinds = [
            {"tapes": k.evaluator.portable().to_data(), "constants": k.constants}
            | {name: list(getattr(k, name)) for name in _PLACES}
            for k in self.kinds
        ]
        return {"kinds": kinds, "of": list(self.of), "none": list(self.none)}

    @classmethod
    def of_data(cls, data: Mapping[str, Any]) -> JoinedOutputs:
        """Return the outputs of data by `to_data`; ValueError for places that there are not."""
        kinds = tuple(
            PieceOutputs(
                evaluator=TapeOutputs.of_data(kind["tapes"]),
                constants=int(kind["constants"]),
                **{name: tuple(map(int, kind[name])) for name in _PLACES},
            )
            for kind in data["kinds"]
        )
        of = tuple(map(int, data["of"]))
        if not all(0 <= k < len(kinds) for k in of):
            raise ValueError("outputs: a piece has no formulas")
        return cls(kinds, of, tuple(map(float, data["none"])))


def outputs_of_data(data: Any) -> TapeOutputs | JoinedOutputs:
    """Return the outputs of a file, of one piece or of several."""
    return JoinedOutputs.of_data(data) if isinstance(data, Mapping) else TapeOutputs.of_data(data)


@dataclass(frozen=True, eq=False)
class JoinedRecord(LiveRecord):
    """The records of pieces under common names; see `StoredRecord`.

    `simulator` is that of the whole mechanism with its pulses, `timetable` what changes.
    """

    simulator: Simulator = field(repr=False)
    timetable: Timetable
    pieces: tuple[Trajectory, ...]

    # ---- names ----

    @cached_property
    def names(self) -> MotionNames:
        """Names of the whole motion."""
        own = self.simulator.stepped.names
        every = self._firsts
        return replace(
            own,
            law=", then ".join(dict.fromkeys(n.law for n in every)),
            choices={k: v for n in reversed(every) for k, v in n.choices.items()},
            states=_union(self._whole(n, n.states) for n in every),
            memory=(*_union(n.memory for n in every), PIECE),
            outputs=_union(self._whole(n, n.outputs) for n in every),
            units=own.units | {k: v for n in every for k, v in n.units.items()},
            source="; ".join(dict.fromkeys(t for n in every for t in n.source.split("; "))),
        )

    @property
    def _firsts(self) -> list[MotionNames]:
        """Names of the simulators, in the order in which they ran."""
        return [self.pieces[self.of.index(k)].names for k in range(len(set(self.of)))]

    @cached_property
    def of(self) -> tuple[int, ...]:
        """Index of the simulator of each piece, in the order in which they ran."""
        known: dict[int, int] = {}
        return tuple(known.setdefault(id(p.names), len(known)) for p in self.pieces)

    def _whole(self, names: MotionNames, own: Iterable[str]) -> list[str]:
        """Return names of states or outputs as the whole mechanism has them."""
        outline = self.simulator.stepped.outline
        known = (*outline.state_names, *outline.output_names)
        if len(names.contacts) > 1:
            return list(own)
        end = f"_{names.contacts[0]}"
        full = {n: f"{n.removesuffix('_dot')}{end}{'_dot' * n.endswith('_dot')}" for n in own}
        return [full[n] if full[n] in known and n not in known else n for n in own]

    @cached_property
    def mode_names(self) -> tuple[str, ...]:
        """Names of the modes of all pieces."""
        return _union(p.mode_names for p in self.pieces)

    @cached_property
    def kinds(self) -> tuple[PieceOutputs, ...]:
        """Outputs of each simulator with their places."""
        names, kinds = self.names, []
        for k, own in enumerate(self._firsts):
            piece = self.pieces[self.of.index(k)]
            evaluator: Any = piece.evaluator
            modes = {name: i for i, name in enumerate(piece.mode_names)}
            kinds.append(
                PieceOutputs(
                    evaluator=evaluator,
                    states=_places(self._whole(own, own.states), names.states),
                    memory=_places(own.memory, names.memory),
                    outputs=_places(self._whole(own, own.outputs), names.outputs),
                    modes=tuple(modes.get(name, 0) for name in self.mode_names),
                    constants=len(piece.constants),
                )
            )
        return tuple(kinds)

    # ---- arrays ----

    @cached_property
    def constants(self) -> Array:
        """Parameters and definitions of each piece, a row each."""
        most = max(kind.constants for kind in self.kinds)
        values = np.full((len(self.pieces), most), np.nan)
        for row, piece in zip(values, self.pieces, strict=True):
            row[: len(piece.constants)] = piece.constants
        return values

    @cached_property
    def steps(self) -> StepRecords:
        """The steps of all pieces."""
        return StepRecords(
            time=np.concatenate([p.step_time for p in self.pieces]),
            length=np.concatenate([p.step_length for p in self.pieces]),
            mode=np.concatenate(
                [self._modes(p)[np.asarray(p.step_mode, np.int64)] for p in self.pieces]
            ),
            memory=np.vstack([self.memory_of(k, p.step_memory) for k, p in enumerate(self.pieces)]),
            polynomial=self._polynomials,
            bend=np.concatenate([p.step_bend for p in self.pieces]),
        )

    @property
    def _polynomials(self) -> Array:
        """Polynomials of all steps; those of lower degree have rows of zeros."""
        rows = max(p.step_rows.shape[1] for p in self.pieces)
        nx, every = len(self.names.states), []
        for kind, p in zip(self.of, self.pieces, strict=True):
            own = np.zeros((len(p.step_time), rows, nx))
            own[:, 0] = _none(self.names.states)
            own[:, : p.step_rows.shape[1], self.kinds[kind].states] = p.step_rows
            every.append(own)
        return np.concatenate(every)

    def _modes(self, piece: Trajectory) -> Any:
        """Return the indices of modes of a piece among those of the motion."""
        return np.array([self.mode_names.index(name) for name in piece.mode_names])

    def memory_of(self, place: int, own: Array) -> Array:
        """Return rows of memory of a piece as rows of the motion."""
        values = np.full((len(own), len(self.names.memory)), np.nan)
        values[:, self.kinds[self.of[place]].memory] = own
        values[:, -1] = place
        return values

    @property
    def final_state(self) -> Array:
        """State at the end."""
        values = np.array(_none(self.names.states))
        values[list(self.kinds[self.of[-1]].states)] = self.pieces[-1].final_state
        return values

    @property
    def final_mode(self) -> int:
        """Index into `mode_names`."""
        last = self.pieces[-1]
        return int(self._modes(last)[last.final_mode])

    @property
    def engine_mode(self) -> int:
        """Index of the mode at the end in the automaton of the last piece."""
        return self.pieces[-1].record.engine_mode

    # ---- what happened ----

    @cached_property
    def events(self) -> tuple[EventRecord, ...]:
        """The events of all pieces, in order."""
        if len(self.kinds) == 1:
            return tuple(e for p in self.pieces for e in p.events)
        none = dict(zip(self.names.states, _none(self.names.states), strict=True))
        return tuple(
            replace(e, state=none | self._renamed(p, e.state))
            for p in self.pieces
            for e in p.events
        )

    def _renamed(self, piece: Trajectory, values: Mapping[str, float]) -> dict[str, float]:
        """Return values of a piece by the names that the whole motion has."""
        return dict(zip(self._whole(piece.names, values), values.values(), strict=True))

    @cached_property
    def reverse_chatter(self) -> tuple[ReverseChatter, ...]:
        """Stretches of bounces that grow out of contact."""
        return tuple(r for p in self.pieces for r in p.record.reverse_chatter)

    @cached_property
    def energy_gains(self) -> tuple[EnergyGain, ...]:
        """Impacts and reloads that add energy."""
        return tuple(g for p in self.pieces for g in p.record.energy_gains)

    @cached_property
    def body_periods(self) -> tuple[BodyPeriod, ...]:
        """Natural periods of the bodies at the start."""
        return self.pieces[0].record.body_periods

    @cached_property
    def surfaces(self) -> tuple[ContactSurface, ...]:
        """Surfaces of compliant contacts, by the names of all pieces."""
        return tuple(dict.fromkeys(s for p in self.pieces for s in p.record.surfaces))

    @cached_property
    def pressed_starts(self) -> tuple[PressedStart, ...]:
        """Contacts that start pressed."""
        return self.pieces[0].record.pressed_starts

    def at_events(self, name: str) -> Array:
        """Return a quantity at every event of a kind; see `Trajectory.at_events`."""
        records: list[Any] = [p.record for p in self.pieces]
        has = [r for r in records if AtEvents.of(name, r.simulator.outline.kinds)]
        return np.concatenate([record.at_events(name) for record in has or records[:1]])

    @cached_property
    def residual_at_events(self) -> float:
        """The largest energy residual of a piece whose steps were not kept."""
        return max((p.record.residual_at_events for p in self.pieces), default=math.nan)

    @cached_property
    def scales(self) -> dict[str, float]:
        """Scale of each state below which it is not resolved, the largest of all pieces."""
        scales: dict[str, float] = {}
        for p in self.pieces:
            for name, own in self._renamed(p, p.record.scales).items():
                scales[name] = max(own, scales.get(name, 0.0))
        return scales

    @cached_property
    def inputs(self) -> dict[str, Any]:
        """See `Trajectory.inputs`."""
        first, last = self.pieces[0].inputs, self.pieces[-1].inputs
        options = first["options"] | {"t_end": last["options"]["t_end"]}
        return first | {"options": options, **self.timetable.to_data()}


def _union(groups: Iterable[Sequence[str]]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for group in groups for name in group))


def _places(own: Sequence[str], whole: Sequence[str]) -> tuple[int, ...]:
    return tuple(whole.index(name) for name in own)


def _none(names: Sequence[str]) -> tuple[float, ...]:
    """Return what a piece has that lacks a state or output: no force and no work, else nan."""
    zero = (*LOSSES, "stored_energy")
    return tuple(0.0 if "_force" in n or n in zero else math.nan for n in names)


def joined(simulator: Simulator, timetable: Timetable, pieces: Sequence[Trajectory]) -> Trajectory:
    """Return pieces, each of which continues the one before, as one motion.

    It has all states, memory and outputs that any piece has; of those that a piece lacks, forces
    and works are 0 there and others nan. The index of the piece is a further memory.
    """
    first, last = pieces[0], pieces[-1]
    record = JoinedRecord(simulator, timetable, tuple(pieces))
    names, declared = record.names, simulator.declared.by_name
    return replace(
        last,
        names=names,
        parameters={n: v for n, v in first.parameters.items() if n in declared},
        record=record,
        final_state=record.final_state,
        final_memory=record.memory_of(len(pieces) - 1, last.final_memory[None])[0],
        counters={n: sum(p.counters[n] for p in pieces) for n in last.counters},
        evaluator=JoinedOutputs(record.kinds, record.of, _none(names.outputs)),
        subject=simulator.stepped.mechanism,
    )


def timetable_of(origin: object) -> Timetable | None:
    """Return what changes in a motion in pieces; None of any other."""
    record = getattr(origin, "record", None)
    return record.timetable if isinstance(record, JoinedRecord) else None
