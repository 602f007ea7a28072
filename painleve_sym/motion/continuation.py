"""Motions that begin where another one ended: with its time, mode and memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.automata.model import CONTACT
from painleve_sym.automata.signature import mode_name
from painleve_sym.automata.watch import MEMORY_END
from painleve_sym.engines.protocol import RawRun, RunOptions
from painleve_sym.errors import InputError, StopReason, received
from painleve_sym.laws.contact_kind import ContactKind
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
    if TIME_NAME in names and TIME_NAME not in simulator.mechanism.state_names:
        state = state.copy()
        state[names.index(TIME_NAME)] = origin.final_time
    return start._replace(state=state, time=origin.final_time)


class Cut(NamedTuple):
    """Beginning of a motion that continues another one, besides its states and parameters.

    Mode and memory are -1 and None under other laws, which begin in a mode of their own.
    """

    time: float
    mode: int = -1
    memory: Array | None = None


def cut_of(simulator: Simulator, origin: Trajectory) -> Cut:
    """Return time, mode and memory at the end of a motion."""
    if not has_states_of(simulator, origin):
        return Cut(origin.final_time)
    outline = simulator.outline
    # A motion in pieces remembers one thing more.
    own = origin.final_memory[: len(outline.memory_names)]
    name, memory = origin.mode_names[origin.final_mode], own.tolist()
    modes = [i for i in range(len(outline.modes)) if mode_name(outline, i, memory) == name]
    # Several contacts name their local modes alone: one name for the motion and its instants.
    mode = origin.record.engine_mode if origin.record.engine_mode in modes else modes[0]
    return Cut(origin.final_time, mode, own)


def carried(simulator: Simulator, start: Start, origin: Trajectory) -> Start:
    """Return the start that has time, and of the same laws mode, memory and all states, of an end.

    Other laws begin at the same coordinates and velocities with a mode of their own.
    """
    cut = cut_of(simulator, origin)
    if cut.mode < 0:
        return _at_time(simulator, start, origin)
    scale = start.scale
    if start.place.parameters == origin.parameters and origin.record.scales:
        scale = known_scale(simulator, origin)
    states, decides, moved = states_of_end(simulator, start.state[None], scale[None], origin)
    if moved is not None:
        raise InputError(f"{simulator.where}: start: {moved}")
    if decides[0]:
        modes = [m.name for m in simulator.outline.modes]
        cut = cut._replace(mode=modes.index(CONTACT))
    return start._replace(state=states[0], scale=scale, **cut._asdict())


def known_scale(simulator: Simulator, origin: Trajectory) -> Array:
    """Return the scales of the states in a motion."""
    return np.array([origin.record.scales[name] for name in simulator.outline.state_names])


def states_of_end(
    simulator: Simulator, prepared: Array, scale: Array, origin: Trajectory
) -> tuple[Array, Any, str | None]:
    """Return the states at the end of a motion, with what the changes at the cut move.

    Gaps and slip velocities are states of their own. Other parameters, or another mechanism of the
    same name, change them at the same coordinates: of a contact that stays open, or slides to the
    same side, its mode remains. A closed rigid contact whose velocities change decides as after an
    impact; a compliant one follows its normal velocity.

    Parameters
    ----------
    simulator : Simulator
    prepared, scale : ndarray, shape (n, nx)
        States as they begin at the same coordinates, and their scales.
    origin : Trajectory

    Returns
    -------
    states : ndarray, shape (n, nx)
    decides : ndarray of bool, shape (n,)
        Whether closed rigid contacts decide what they do.
    fault : str or None
        Sentences on the first row in which a closed contact moves.
    """
    record = origin.record
    of_origin: Any = record.simulator if isinstance(record, RunRecord) else simulator
    place = of_origin.at(first_state(of_origin, origin), origin.parameters)
    shift = prepared - of_origin.prepared(place)[0].state
    names, fault, model = simulator.outline.state_names, None, simulator.contact
    decides = np.zeros(len(prepared), dtype=bool)
    states = np.tile(origin.final_state, (len(prepared), 1))
    contacts = zip(simulator.mechanism.outline.contacts, model.rows, model.kinds, strict=True)
    for contact, row, kind in contacts:
        places = [names.index(str(symbol)) for symbol in (row.gap, row.gap_rate, row.slip)]
        least = SMALL * scale[:, places]
        own = np.where(np.abs(shift[:, places]) > least, shift[:, places], 0.0)
        before, after = states[:, places], states[:, places] + own
        is_open = np.minimum(before[:, 0], after[:, 0]) > least[:, 0]
        yields = kind not in (ContactKind.RIGID, ContactKind.GUIDE)
        same_slip = (own[:, 2] == 0) | (before[:, 2] * after[:, 2] > 0)
        slides = (own[:, 0] == 0) & same_slip & ((own[:, 1] == 0) | yields)
        moved = own.any(axis=1) & ~is_open & ~slides
        answers = moved & (own[:, 0] == 0) & (kind is ContactKind.RIGID)
        decides |= answers
        wrong = moved & ~answers
        if fault is None and wrong.any():
            change = own[int(np.argmax(wrong))]
            fault = (
                f"what changes at t = {origin.final_time:g} s moves "
                f"contact {contact.name!r} while it is closed: gap by {change[0]:.3g} m, gap rate "
                f"by {change[1]:.3g} m/s, slip by {change[2]:.3g} m/s. Fix: change what leaves its "
                "surface in place, take a rigid law, which answers a jump of speeds, or begin a "
                "new motion with the final coordinates and velocities."
            )
        states[:, places] = after
    return states, decides, fault


def options_of_rest(options: RunOptions, cut: Cut | Start) -> RunOptions:
    """Return the options of a motion that begins at a later time, which engines count from 0."""
    rest = replace(options, t_end=options.t_end - cut.time, start_mode=cut.mode)
    # What an earlier piece ended before happens at once.
    return replace(rest, start_events=True) if cut.mode >= 0 else rest


def at_its_time(raw: RawRun, options: RunOptions, time: float) -> RawRun:
    """Return a run that began at a later time with its own times."""
    later = raw.later(time)
    ended = later.stop_reason is StopReason.T_END
    return later._replace(time=options.t_end) if ended else later
