"""Steps and events of a run, read from what the engine kept when they are first asked for."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.automata.model import ENERGIES, LOSSES
from painleve_sym.automata.signature import Outline, mode_name
from painleve_sym.automata.watch import WATCHED
from painleve_sym.choices import Record
from painleve_sym.contact_rows import ContactRows
from painleve_sym.engines.batch import checked_at_events, quantities_at_events
from painleve_sym.engines.protocol import RawRun, RunOptions
from painleve_sym.engines.records import EventRecords, StepRecords
from painleve_sym.equality import Compared
from painleve_sym.errors import EventKind
from painleve_sym.laws.catalogue import law_text
from painleve_sym.motion.energy_balance import balance_residual
from painleve_sym.motion.energy_gains import GAINING, EnergyGain, energy_gains
from painleve_sym.motion.pressed_start import PressedStart, pressed_starts
from painleve_sym.motion.pressing import ContactSurface, contact_surfaces
from painleve_sym.motion.records import EventRecord
from painleve_sym.motion.rigid import alternatives, chatter_at, final_slips, growing_bounces
from painleve_sym.motion.rigidity import BodyPeriod, body_periods
from painleve_sym.motion.singular_limit import ReverseChatter
from painleve_sym.version import __version__

if TYPE_CHECKING:
    from painleve_sym.motion.mechanism_with_laws import MechanismWithLaws, Start


def plain_options(o: RunOptions) -> dict[str, Any]:
    """Return end and bounds of a run, but for infinite ones, by the keywords of `simulate`."""
    names = ("t_end", "first_step", "max_step", "max_steps", "max_events")
    options = {n: getattr(o, n) for n in names if getattr(o, n) != math.inf}
    return options | {"until": list(map(str, o.until))}


@dataclass(frozen=True, eq=False)
class StoredRecord(Compared):
    """Recorded arrays of a motion that have been read; modes are indices into `mode_names`.

    The `engine_mode` is the index of the last one in the automaton, where one name may stand for
    several; -1 where it is not known.
    """

    steps: StepRecords
    mode_names: tuple[str, ...]
    final_mode: int
    events: tuple[EventRecord, ...]
    reverse_chatter: tuple[ReverseChatter, ...]
    energy_gains: tuple[EnergyGain, ...]
    constants: Array
    body_periods: tuple[BodyPeriod, ...] = ()
    surfaces: tuple[ContactSurface, ...] = ()
    pressed_starts: tuple[PressedStart, ...] = ()
    residual_at_events: float = math.nan
    scales: Mapping[str, float] = field(default_factory=dict)
    engine_mode: int = -1
    inputs: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, record: Any) -> StoredRecord:
        """Return all that a record gives."""
        return cls(**{f.name: getattr(record, f.name) for f in fields(cls)})


class LiveRecord:
    """A record with its simulator, compared and pickled as what is stored of it."""

    def __eq__(self, other: object) -> bool:
        """Whether the other record, live or stored, holds the same motion."""
        if not isinstance(other, LiveRecord | StoredRecord):
            return NotImplemented
        return StoredRecord.of(self) == StoredRecord.of(other)

    def __hash__(self) -> int:
        """Return the hash of the stored arrays."""
        return hash(StoredRecord.of(self))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the recorded arrays, without the simulator."""
        return StoredRecord.of, (StoredRecord.of(self),)


@dataclass(frozen=True, eq=False)
class RunRecord(LiveRecord):
    """The record of a run."""

    simulator: MechanismWithLaws
    start: Start
    raw: RawRun
    options: RunOptions

    @property
    def inputs(self) -> dict[str, Any]:
        """See `Trajectory.inputs`."""
        start = self.start
        options = plain_options(self.options)
        if start.force >= 0:
            options["initial_force"] = start.force
        if not np.array_equal(self.options.atol, self.options.rtol * start.scale):
            options["atol"] = self.options.atol.tolist()
        inputs = {
            "law": law_text(self.simulator.law),
            "state": start.place.state,
            "options": options,
            "version": __version__,
        }
        if start.time:
            inputs["continues"] = self._continued
        if self.simulator.watch:
            inputs["watch"] = list(self.simulator.watch)
        return inputs

    @property
    def _continued(self) -> dict[str, Any]:
        """Time, s, mode and memory with which a motion begins that continues another one."""
        return beginning_of(self.simulator.outline, self.start)

    @cached_property
    def constants(self) -> Array:
        """Parameters and definitions."""
        return self.simulator.integrator.constants(self.start.parameters)

    @cached_property
    def steps(self) -> StepRecords:
        """The steps; their modes are indices into `mode_names`."""
        return replace(self.raw.step_records, mode=self._modes[1][:-1])

    @property
    def entered(self) -> Iterator[tuple[int, list[float]]]:
        """Modes, by their indices in the automaton, and memory of the steps and after events."""
        steps, events = self.raw.step_records, self.raw.event_records
        for modes, memory in ((steps.mode, steps.memory), (events.mode_after, events.memory_after)):
            yield from zip(modes.tolist(), memory.tolist(), strict=True)

    @property
    def mode_names(self) -> tuple[str, ...]:
        """Names of the modes."""
        return self._modes[0]

    @property
    def final_mode(self) -> int:
        """Index into `mode_names`."""
        return int(self._modes[1][-1])

    @property
    def engine_mode(self) -> int:
        """Index of the last mode in the automaton."""
        return self.raw.mode

    @cached_property
    def _modes(self) -> tuple[tuple[str, ...], Any]:
        """Names of modes, and the index among them of the mode of each step and of the end."""
        outline, steps = self.simulator.outline, self.raw.step_records
        modes = np.append(steps.mode, self.raw.mode)
        if not outline.parts:
            return tuple(m.name for m in outline.modes), modes
        memory = np.vstack([steps.memory, self.raw.memory])
        every = [mode_name(outline, int(m), z) for m, z in zip(modes, memory, strict=True)]
        names = tuple(dict.fromkeys(every))
        return names, np.array([names.index(name) for name in every])

    @cached_property
    def events(self) -> tuple[EventRecord, ...]:
        """The events with all solutions where there are several, and with their impulses.

        No slip starts without friction: nothing had stuck.
        """
        mechanism, values = self.simulator.mechanism.outline, self.start.place.parameters
        smooth = {
            c.name
            for c in mechanism.contacts
            if c.has_one_coefficient and not values.get(c.friction, 1)
        }
        return tuple(
            e
            for e in self._every_event
            if e.kind is not EventKind.SLIP_START or e.contact not in smooth
        )

    @cached_property
    def _every_event(self) -> tuple[EventRecord, ...]:
        """The events of the engine, one a row of its record."""
        simulator, rows, outline = self.simulator, self.raw.event_records, self.simulator.outline
        outputs = simulator.integrator.outputs(*rows.before, self.constants)
        at = {name: outputs[:, i] for i, name in enumerate(outline.output_names)}
        first, *others = simulator.names.contacts
        # The last entries of the memory are the impulses of the last impact.
        count = ContactRows(len(simulator.names.contacts)).size
        records = []
        for i, after in enumerate(rows.state_after.tolist()):
            place, kind = int(rows.contact[i]), outline.kinds[rows.kind[i]]
            contact = outline.contacts[place] if place >= 0 else ""
            # A decision for several contacts at once has no force of its own.
            decided = place < 0 and rows.transition[i] < 0
            carried = ("normal_force", "tangential_force", "gap")
            named = (simulator.names.of_contact(n, contact or first) for n in carried)
            force, friction, gap = (0.0 if decided else float(at[n][i]) for n in named)
            state = dict(zip(outline.state_names, after, strict=True))
            several, impulses = tuple[str, ...](), tuple[float, ...]()
            if simulator.rigid and kind is EventKind.CONTACT:
                several = alternatives(simulator, state, self.start.place.parameters)
            if simulator.strikes and kind is EventKind.IMPACT:
                impulses = tuple(rows.memory_after[i, -count:].tolist())
                before = dict(zip(outline.state_names, rows.state_before[i].tolist(), strict=True))
                several = final_slips(simulator, before, self.start.place.parameters)
            records.append(
                EventRecord(
                    time=float(rows.time[i]),
                    kind=kind,
                    mode_before=mode_name(outline, int(rows.mode_before[i]), rows.memory_before[i]),
                    mode_after=mode_name(outline, int(rows.mode_after[i]), rows.memory_after[i]),
                    state=state,
                    normal_force=force,
                    tangential_force=friction,
                    compression=-gap,
                    alternatives=several,
                    contact=contact if others else first,
                    impulses=impulses,
                    quantity=self._watched_quantity(rows, i),
                )
            )
        return tuple(records)

    def _watched_quantity(self, rows: EventRecords, i: int) -> str:
        """Return the arguments of the watch of an event; empty for others."""
        outline, j = self.simulator.outline, int(rows.transition[i])
        if j < 0 or outline.kinds[rows.kind[i]] not in WATCHED:
            return ""
        label = outline.modes[int(rows.mode_before[i])].transitions[j].label
        return label.partition("(")[2].removesuffix(")")

    def at_events(self, name: str) -> Array:
        """Return a quantity at every event of a kind; see `Trajectory.at_events`."""
        rows, outline = self.raw.event_records, self.simulator.outline
        at = checked_at_events(name, outline, "trajectory: at_events")
        times = rows.time[rows.kind == [str(k) for k in outline.kinds].index(at.kind)]
        if at.side == "before":
            places, side = np.searchsorted(rows.time, times), rows.before
        else:
            places, side = np.searchsorted(rows.time, times, side="right") - 1, rows.after
        modes, states, memory = (values[places] for values in side)
        outputs = self.simulator.integrator.outputs(modes, states, memory, self.constants)
        column = quantities_at_events(outline).index(at.quantity)
        every: Array = np.hstack([outputs, states])
        return every[:, column]

    @cached_property
    def residual_at_events(self) -> float:
        """Energy residual from start, events and end, where these are kept without steps, else nan.

        See `Trajectory.energy_residual`.
        """
        if self.options.record != Record.EVENTS:
            return math.nan
        rows, raw, outline = self.raw.event_records, self.raw, self.simulator.outline
        after = rows.after
        first = (raw.mode, raw.memory)
        if len(rows.time):
            first = (int(rows.mode_before[0]), rows.memory_before[0])
        modes = np.array([first[0], *after[0], raw.mode])
        states = np.vstack([self.start.state, after[1], raw.state])
        memory = np.vstack([first[1], after[2], raw.memory])
        outputs = self.simulator.integrator.outputs(modes, states, memory, self.constants)
        terms = {name: outputs[:, outline.output_names.index(name)] for name in ENERGIES}
        names = outline.state_names
        terms |= {name: states[:, names.index(name)] for name in LOSSES if name in names}
        return balance_residual(terms)

    @cached_property
    def energy_gains(self) -> tuple[EnergyGain, ...]:
        """Impacts and reloads that add energy."""
        rows, outline = self.raw.event_records, self.simulator.outline
        causes = [outline.kinds.index(kind) for kind in GAINING if kind in outline.kinds]
        if not np.isin(rows.kind, causes).any():
            return ()
        outputs = self.simulator.integrator.outputs
        place = outline.output_names.index("kinetic_energy")
        before, after = (outputs(*at, self.constants)[:, place] for at in (rows.before, rows.after))
        return energy_gains(rows, self._every_event, (before, after), self.simulator.names)

    @cached_property
    def body_periods(self) -> tuple[BodyPeriod, ...]:
        """Natural periods of the bodies."""
        of_body = self.start.materials[0] if self.start.materials else None
        return body_periods(self.simulator.mechanism, self.start.place.parameters, of_body)

    @cached_property
    def surfaces(self) -> tuple[ContactSurface, ...]:
        """The surfaces of the compliant contacts that have a radius."""
        contact = self.simulator.contact
        names = [c.name for c in contact.mechanism.outline.contacts]
        values, materials = self.start.place.parameters, self.start.materials or ()
        return contact_surfaces(names, contact.laws, contact.own_laws, values, materials)

    @cached_property
    def pressed_starts(self) -> tuple[PressedStart, ...]:
        """Contacts that start pressed, not by an initial force, and whose law remembers."""
        if self.start.force >= 0 or self.start.memory is not None:
            return ()
        contact, names = self.simulator.contact, self.simulator.outline.state_names
        gaps = [names.index(row.gap) for row in contact.rows]
        own = ((float(self.start.state[i]), float(self.start.scale[i])) for i in gaps)
        given = zip(self.simulator.names.contacts, contact.own_laws, own, strict=True)
        return tuple(pressed_starts((name, law, *numbers) for name, law, numbers in given))

    @cached_property
    def scales(self) -> dict[str, float]:
        """Scale of each state, gap, gap rate and slip velocity below which it is not resolved."""
        contact = self.simulator.contact
        names, scales = self.simulator.outline.state_names, self.start.scale.tolist()
        of_states: dict[str, float] = dict(zip(names, scales, strict=True))
        of_contacts: dict[str, float] = {}
        for row, end in zip(contact.rows, contact.ends, strict=True):
            named = {"gap": row.gap, "gap_rate": row.gap_rate, "slip_velocity": row.slip}
            of_contacts |= {f"{k}{end}": of_states[name] for k, name in named.items()}
        return of_contacts | of_states

    @cached_property
    def reverse_chatter(self) -> tuple[ReverseChatter, ...]:
        """Rigid motion: stretches of bounces that grow out of contact."""
        contact, values = self.simulator.contact, self.start.place.parameters
        if not contact.can_open:
            return ()
        return growing_bounces(
            self.events, contact.rows[0].gap_rate, lambda state: chatter_at(contact, state, values)
        )


def beginning_of(outline: Outline, start: Any) -> dict[str, Any]:
    """Return time, s, mode and memory of a start, or cut, as plain data."""
    if start.memory is None:
        return {"time": start.time}
    return {
        "time": start.time,
        "mode": mode_name(outline, start.mode, start.memory.tolist()),
        "memory": dict(zip(outline.memory_names, start.memory.tolist(), strict=True)),
    }
