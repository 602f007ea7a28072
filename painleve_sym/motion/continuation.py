"""Motions that begin where another one ended: with its time, mode and memory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.automata.signature import mode_name
from painleve_sym.errors import InputError, StopReason, received
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
        outline.state_names == names.states
        and outline.memory_names == names.memory
        and simulator.label == names.law
        and simulator.choices == names.choices
    )


def carried(simulator: Simulator, start: Start, origin: Trajectory) -> Start:
    """Return the start that has time, and of the same laws mode, memory and all states, of an end.

    Other laws begin at the same coordinates and velocities with a mode of their own.
    """
    if not has_states_of(simulator, origin):
        return start._replace(time=origin.final_time)
    outline, scale = simulator.outline, start.scale
    if start.place.parameters == origin.parameters and origin.record.scales:
        scale = np.array([origin.record.scales[name] for name in outline.state_names])
    name, memory = origin.mode_names[origin.final_mode], origin.final_memory.tolist()
    modes = range(len(outline.modes))
    mode = next(i for i in modes if mode_name(outline, i, memory) == name)
    return start._replace(
        state=origin.final_state,
        scale=scale,
        time=origin.final_time,
        mode=mode,
        memory=origin.final_memory,
    )
