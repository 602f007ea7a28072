"""Motions that begin where another one ended: with its time, mode and memory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.automata.signature import mode_name
from painleve_sym.automata.watch import MEMORY_END
from painleve_sym.errors import InputError, StopReason, received
from painleve_sym.mechanics.declarations import TIME_NAME
from painleve_sym.motion.records import PIECE
from painleve_sym.motion.run_record import RunRecord
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.units import Value

if TYPE_CHECKING:
    from painleve_sym.motion.mechanism_with_laws import Start
    from painleve_sym.motion.simulator import Simulator

CONTINUES = (
    StopReason.T_END,
    StopReason.UNTIL,
    StopReason.STEP_LIMIT,
    StopReason.EVENT_LIMIT,
)
"""Reasons of an end from which a motion continues."""
_OF_A_START = ("close", "initial_force", "material")
SMALL = 1e-9
"""Part of the scale of a contact below which a change at a cut is rounding."""


def check_origin(where: str, origin: object, given: Mapping[str, Any], t_end: float) -> Trajectory:
    """Return a motion that can be continued; InputError for another one, or two starts."""
    if not isinstance(origin, Trajectory):
        raise InputError(f"{where}: start: got {received(origin)}, need a Trajectory.")
    for name in ("state", *_OF_A_START):
        if given.get(name) is not None:
            raise InputError(
                f"{where}: start: got {name}, too, which the motion before has settled. "
                "Fix: leave one of them out."
            )
    if origin.stop_reason not in CONTINUES:
        raise InputError(
            f"{where}: start: the motion before ended with {origin.stop_reason.label} at "
            f"t = {origin.final_time:g} s, from where it does not continue."
        )
    if not t_end > origin.final_time:
        raise InputError(
            f"{where}: t_end: got {t_end:g} s, need a time after {origin.final_time:g} s, at which "
            "the motion before ended."
        )
    return origin


def first_state(simulator: Simulator, origin: Trajectory) -> dict[str, Value]:
    """Return coordinates and velocities at the end of a motion."""
    final = origin.final
    names = simulator.mechanism.state_names
    missing = [name for name in names if name not in final]
    if missing:
        raise InputError(
            f"{simulator.where}: start: the motion before is one of {origin.mechanism!r}, without "
            f"{', '.join(missing)}. Fix: continue a motion of the same mechanism."
        )
    return {name: final[name] for name in names}


def same_parameters(simulator: Simulator, origin: Trajectory) -> dict[str, float]:
    """Return the parameters of a motion that the simulator has, too."""
    outline = simulator.mechanism.outline
    names = {p.name for p in (*outline.parameters, *simulator.own_parameters)}
    return {name: value for name, value in origin.parameters.items() if name in names}


def has_states_of(simulator: Simulator, origin: Trajectory) -> bool:
    """Whether mode and memory at the end of a motion mean the same to the simulator."""
    outline, names = simulator.outline, origin.names
    return (
        simulator.mechanism.name == names.mechanism
        and outline.state_names == names.states
        and outline.memory_names == tuple(name for name in names.memory if name != PIECE)
        and simulator.label == names.law
        and simulator.choices == names.choices
    )


def check_watches(simulator: Simulator, origin: Trajectory) -> None:
    """Raise InputError where a motion of the same laws watches other events."""
    own, names = simulator.contact.watch, origin.names
    before = {name for name in names.memory if name.endswith(MEMORY_END)}
    same_laws = simulator.mechanism.name == names.mechanism and simulator.label == names.law
    if same_laws and before != {w.memory for w in own}:
        known = ", ".join(repr(name.removesuffix(MEMORY_END)) for name in sorted(before))
        raise InputError(
            f"{simulator.where}: start: the motion before watches {known or 'no events'}, and this "
            "one others. Fix: give both the same watch=."
        )


def _at_time(simulator: Simulator, start: Start, origin: Trajectory) -> Start:
    """Return a start in a mode of its own at the time of an end."""
    names, state = simulator.outline.state_names, start.state
    if TIME_NAME in names:
        state = state.copy()
        state[names.index(TIME_NAME)] = origin.final_time
    return start._replace(state=state, time=origin.final_time)


def carried(simulator: Simulator, start: Start, origin: Trajectory) -> Start:
    """Return the start that has time, and of the same laws mode, memory and all states, of an end.

    Other laws begin at the same coordinates and velocities with a mode of their own.
    """
    if not has_states_of(simulator, origin):
        return _at_time(simulator, start, origin)
    outline, scale = simulator.outline, start.scale
    if start.place.parameters == origin.parameters and origin.record.scales:
        scale = np.array([origin.record.scales[name] for name in outline.state_names])
    # A motion in pieces remembers one thing more.
    own = origin.final_memory[: len(outline.memory_names)]
    name, memory = origin.mode_names[origin.final_mode], own.tolist()
    modes = [i for i in range(len(outline.modes)) if mode_name(outline, i, memory) == name]
    # Several contacts name their local modes alone: one name for the motion and its instants.
    mode = origin.record.engine_mode if origin.record.engine_mode in modes else modes[0]
    return start._replace(
        state=_moved_with_contacts(simulator, start, origin),
        scale=scale,
        time=origin.final_time,
        mode=mode,
        memory=own,
    )


def _moved_with_contacts(simulator: Simulator, start: Start, origin: Trajectory) -> Array:
    """Return the states at the end of a motion, with what the change at the cut moves.

    Gaps and slip velocities are states of their own. Other parameters, or another mechanism of the
    same name, change them at the same coordinates: of a contact that stays open, or slides to the
    same side, its mode remains; InputError for any other.
    """
    record = origin.record
    of_origin: Any = record.simulator if isinstance(record, RunRecord) else simulator
    place = of_origin.at(first_state(of_origin, origin), origin.parameters)
    shift = start.state - of_origin.prepared(place)[0].state
    state, names = origin.final_state.copy(), simulator.outline.state_names
    contacts = simulator.mechanism.outline.contacts
    for contact, row in zip(contacts, simulator.contact.rows, strict=True):
        places = [names.index(str(symbol)) for symbol in (row.gap, row.gap_rate, row.slip)]
        least = SMALL * start.scale[places]
        own = np.where(np.abs(shift[places]) > least, shift[places], 0.0)
        before, after = state[places], state[places] + own
        is_open = min(before[0], after[0]) > least[0]
        slides = not own[:2].any() and before[2] * after[2] > 0
        if own.any() and not (is_open or slides):
            raise InputError(
                f"{simulator.where}: start: what changes at t = {origin.final_time:g} s moves "
                f"contact {contact.name!r} while it is closed: gap by {own[0]:.3g} m, gap rate by "
                f"{own[1]:.3g} m/s, slip by {own[2]:.3g} m/s. Fix: change what leaves its surface "
                "in place, or begin a new motion with the final coordinates and velocities."
            )
        state[places] = after
    return state
