"""Starts that a simulator rejects, and ends that it explains."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import NoReturn

from painleve_sym.at.cases import guide_faults
from painleve_sym.at.delassus import Delassus
from painleve_sym.at.inputs import inside
from painleve_sym.checks import number
from painleve_sym.engines.protocol import BEFORE, RawRun
from painleve_sym.errors import EventKind, InputError, StopReason
from painleve_sym.motion.force_jumps import jump_advice
from painleve_sym.motion.mechanism_with_laws import MechanismWithLaws, Start
from painleve_sym.units import Value

_JAM = (
    "the contacts wedge: no finite impulse ends this rigid impact; use a compliant law, or one "
    "contact at a time"
)
_GUIDE_MEETS = (
    "the slip meets A = 0, where the force of the guide grows without bound and rigid theory ends; "
    "end earlier, or start elsewhere"
)


def initial_force_fault(simulator: MechanismWithLaws) -> str:
    """Return why no initial force can be given, a sentence; empty where it can."""
    if simulator.contact.several:
        return (
            "initial_force: several contacts share no force. Fix: give the compression of each "
            "by the state."
        )
    if not simulator.contact.compliant:
        return (
            "initial_force: a rigid contact has no compression. Fix: leave it out, or give a "
            "compliant law."
        )
    return ""


def checked_force(simulator: MechanismWithLaws, force: Value) -> float:
    """Return an initial force; InputError where none can be given, or it is not a number >= 0."""
    if fault := initial_force_fault(simulator):
        raise InputError(f"{simulator.where}: {fault}")
    return number(force, "initial force", where=simulator.where, unit="N", lower=0.0)


def refuse_plastic(simulator: MechanismWithLaws, values: Mapping[str, float]) -> None:
    """Raise InputError where a compliant contact has e = 0, which has nothing to rest on."""
    for name in simulator.restitutions:
        if values[name] == 0:
            raise InputError(
                f"{simulator.where}: {name}: got 0, where a contact that stays loaded has no "
                "unloading curve to rest on, need a number > 0 for a run without an event that "
                "ends it (`until`). Fix: take a rigid contact, whose e may be 0, or 0.05."
            )


def refuse(simulator: MechanismWithLaws, start: Start) -> NoReturn:
    """Raise InputError with the reason why a start is not admitted."""
    where = simulator.where
    for name, value in simulator.constants(start.place.parameters).items():
        if not math.isfinite(value):
            raise InputError(
                f"{where}: {name} evaluates to {value!r}, need a finite number. "
                "Fix: check the parameters it is made of (stiffness, curvatures)."
            )
    inside(start.place)
    state = dict(zip(simulator.outline.state_names, start.state.tolist(), strict=True))
    if start.force >= 0:
        raise InputError(
            f"{where}: initial_force: got a start with gap "
            f"{state[simulator.contact.rows[0].gap]!r}, need 0. Fix: give the force or the "
            "compression, not both."
        )
    for i in simulator.rigid:
        _refuse_contact(simulator, i, state, start.place.values)
    raise InputError(f"{where}: the contact law does not admit the start.")


def _refuse_contact(
    simulator: MechanismWithLaws, i: int, state: Mapping[str, float], values: Mapping[str, float]
) -> None:
    """Raise InputError where a rigid contact is inside the ground, or a guide off its place."""
    row, several = simulator.contact.rows[i], simulator.contact.several
    gap, rate = state[row.gap], state[row.gap_rate]
    contact = simulator.mechanism.outline.contacts[i]
    name = f"contact {contact.name!r}"
    if contact.bilateral:
        at = Delassus.of(simulator.mechanism).at(values)
        subject = f"the bilateral {name}" if several else "a bilateral contact"
        within = (gap, at.gap_tolerance[i]), (rate, at.rate_tolerance[i])
        for fault in guide_faults(subject, *within):
            raise InputError(f"{simulator.where}: {fault}")
    elif gap < 0:
        subject = f"{name} starts" if several else "the start is"
        raise InputError(
            f"{simulator.where}: {subject} inside the ground, gap = {gap:g} m, and a rigid "
            "contact has no compression. Fix: start with gap >= 0, or give a compliant law."
        )


def end_detail(simulator: MechanismWithLaws, raw: RawRun, until: Collection[str]) -> str:
    """Return details of the end of a run; see `Trajectory.stop_detail`."""
    if raw.stop_reason is StopReason.UNTIL and raw.stop_transition >= 0:
        kind = simulator.outline.modes[raw.mode].transitions[raw.stop_transition].kind
        # A choice that no forces meet is an impact.
        return f"before {kind if BEFORE + kind in until else EventKind.IMPACT}"
    if raw.stop_reason in (StopReason.T_END, StopReason.UNTIL):
        return ""
    outline = simulator.mechanism.outline
    if raw.stop_reason is StopReason.LEFT_DOMAIN:
        mode = simulator.outline.modes[raw.mode]
        bound = mode.transitions[raw.stop_transition].bound
        return outline.domain[bound].meaning if bound is not None else ""
    if all(outline.bilateral) and raw.stop_reason is StopReason.SINGULAR:
        return _GUIDE_MEETS
    if simulator.contact.several and raw.stop_reason is StopReason.JAM:
        return _JAM
    if raw.stop_reason is StopReason.FORCE_JUMP:
        return jump_advice(simulator.mechanism)
    return raw.stop_reason.sentence
