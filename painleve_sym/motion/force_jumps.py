"""Forces of a mechanism that jump where a velocity is 0, and motions that they hold there."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.engines.protocol import RawRun, RunOptions
from painleve_sym.errors import StopReason

if TYPE_CHECKING:
    from painleve_sym.mechanics.mechanism import Mechanism
    from painleve_sym.motion.mechanism_with_laws import MechanismWithLaws, Start

PROBE = 50_000
"""Steps after which a run is looked at."""
_LOOKED_AT, _FEWEST = 5, 20
"""The last fifth of the steps is looked at; it must have twenty."""
_FACTOR = 1e6
"""Tolerances by which a step that leads nowhere may change a state; 1e-3 of its size at most."""


def jumping_velocities(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the names of velocities in operations of the given forces that jump or have kinks."""
    import sympy as sp

    system = mechanism.system
    kinds = (sp.Abs, sp.sign, sp.Heaviside, sp.Min, sp.Max, sp.Piecewise)
    forces = system.generalized_forces.values()
    inside = {s for f in forces for e in sp.sympify(f).atoms(*kinds) for s in e.free_symbols}
    return tuple(v.name for v in system.velocities if v.symbol in inside)


def jump_advice(mechanism: Mechanism) -> str:
    """Return the sentence on a motion that is held where a force jumps."""
    names = jumping_velocities(mechanism)
    v = names[0] if names else "v"
    return (
        f"a force of the mechanism jumps where {' or '.join(names)} is 0 and holds the motion "
        f"there, where no step leads on; make it continuous, such as {v}/sqrt({v}**2 + w**2) with "
        f"a small w in place of {v}/abs({v}), or end the run here"
    )


def integrated(simulator: MechanismWithLaws, start: Start, options: RunOptions) -> RawRun:
    """Return a run, which ends early where a force that jumps holds the motion."""
    engine: Any = simulator.integrator

    def run(**changed: Any) -> RawRun:
        own = replace(options, **changed) if changed else options
        raw: RawRun = engine.run(start.state, start.parameters, own, start.memory)
        return raw

    if engine.name == "taylor":
        # No operation that jumps has a series.
        return run()
    first = {"max_steps": min(PROBE, options.max_steps)}
    raw = run(**first)
    if raw.stop_reason is StopReason.ACCUMULATION and _stands(simulator, raw, options):
        return raw._replace(stop_reason=StopReason.FORCE_JUMP)
    if raw.stop_reason is not StopReason.STEP_LIMIT:
        return raw
    seen = raw if options.record == "dense" else run(**first, record="dense")
    held = leads_nowhere(seen, options) and jumping_velocities(simulator.mechanism)
    if not held and first["max_steps"] < options.max_steps:
        return run()
    return raw._replace(stop_reason=StopReason.FORCE_JUMP) if held else raw


def _stands(simulator: MechanismWithLaws, raw: RawRun, options: RunOptions) -> bool:
    """Whether a velocity at which a force jumps is 0 at the end."""
    names = simulator.outline.state_names
    places = [names.index(v) for v in jumping_velocities(simulator.mechanism)]
    return any(abs(raw.state[i]) <= 1e-6 * options.atol[i] / options.rtol for i in places)


def leads_nowhere(raw: RawRun, options: RunOptions) -> bool:
    """Whether most of the last steps are short and change no state by more than rounding."""
    steps = raw.step_records
    last = len(steps.length) // _LOOKED_AT
    if last < _FEWEST:
        return False
    states = np.vstack([steps.polynomial[-last:, 0], raw.state])
    size = options.atol / options.rtol + np.abs(states[1:])
    least = min(_FACTOR * options.rtol, 1e-3) * size
    still = np.all(np.abs(np.diff(states, axis=0)) <= least, axis=1)
    short = steps.length[-last:] < options.max_step / 2
    return bool(np.mean(still & short) > 0.5)
