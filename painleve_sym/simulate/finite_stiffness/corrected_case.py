"""The jump at finite stiffness from one state, with the names of its phases and of the method."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.contacts.inputs import resolve_parameters, resolve_state
from painleve_sym.errors import InputError
from painleve_sym.laws.compliance import DELTA, DELTA_DOT, ContactLaw, ramp
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.simulate.finite_stiffness.corrected_jump import CONFIGURATIONS, CorrectedJumpRule
from painleve_sym.simulate.finite_stiffness.damped_impact import DampedImpact, damped_impact
from painleve_sym.simulate.finite_stiffness.frozen_impact import (
    COEFFICIENTS,
    FrozenEnd,
    FrozenImpactSolver,
    Method,
)


@dataclass(frozen=True)
class CorrectedPhase:
    """One phase of a jump at finite stiffness.

    Attributes
    ----------
    name : str
        ``slip``, ``sticking`` or ``reverse slip``, then ``compression`` or ``restitution``.
    duration : float
        s.
    normal_impulse, tangential_impulse : float
        N s.
    compression : float
        δ at the end; m.
    slip_velocity, normal_velocity : float
        Of the contact at the end; m/s.
    """

    name: str
    duration: float
    normal_impulse: float
    tangential_impulse: float
    compression: float
    slip_velocity: float
    normal_velocity: float


@dataclass(frozen=True)
class CorrectedJump:
    """A jump at finite stiffness.

    Attributes
    ----------
    mechanism, law : str
        Names.
    configuration : {"frozen", "carried"}
    method : str
        ``hypergeometric``, ``elementary``, ``quadrature`` (several are joined by a comma),
        ``matrix exponential`` or ``integration``.
    stiffness, exponent : float
        K (N/mⁿ) and n.
    initial_compression : float
        δ₀; m.
    end : FrozenEnd
    phases : tuple of CorrectedPhase
    velocity, velocity_before : mapping of str to float
        Of the mechanism, by state name.
    """

    mechanism: str
    law: str
    configuration: str
    method: str
    stiffness: float
    exponent: float
    initial_compression: float
    end: FrozenEnd
    phases: tuple[CorrectedPhase, ...]
    velocity: Mapping[str, float]
    velocity_before: Mapping[str, float]

    @property
    def largest_compression(self) -> float:
        """Largest δ at the end of a phase; m."""
        return max([self.initial_compression, *(p.compression for p in self.phases)])

    @property
    def duration(self) -> float:
        """Of the whole impact; s."""
        return float(sum(p.duration for p in self.phases))


def evaluate_corrected_jump(
    mechanism: Mechanism,
    law: ContactLaw,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
    *,
    initial_force: float = 0.0,
    configuration: str = "frozen",
    engine: str = "auto",
) -> CorrectedJump:
    """Evaluate the jump at finite stiffness from one state.

    Parameters
    ----------
    mechanism : Mechanism
        With one contact.
    law : ContactLaw
        With a dashpot the linear law is exact in time, and others are integrated; `method` says
        so.
    state : mapping of str to float
        Coordinates and velocities by name, those absent are 0; SI units, rad. The contact counts
        as closed whatever its gap.
    parameters : mapping of str to float, optional
        Of the mechanism and of the law; those absent keep their default.
    initial_force : float
        Surface energy at the start as the force of the initial compression; N.
    configuration : {"frozen", "carried"}
    engine : {"auto", "compiled", "python"}

    Raises
    ------
    InputError
        Unknown or invalid entries; ``carried`` with a dashpot.
    """
    where = f"corrected jump of {mechanism.name!r}"
    declared = (*mechanism.system.parameters, *law.parameters)
    given = resolve_parameters(where, declared, parameters or {})
    start = resolve_state(mechanism, state, given)
    if not (np.isfinite(initial_force) and initial_force >= 0):
        raise InputError(f"{where}: initial force: got {initial_force!r}, need >= 0 and finite.")
    if configuration not in CONFIGURATIONS:
        known = ", ".join(CONFIGURATIONS)
        raise InputError(f"{where}: configuration: got {configuration!r}, need one of {known}.")
    rule = CorrectedJumpRule(mechanism, law, engine)
    inputs = {name: float(value) for name, value in rule.law_inputs(given).items()}
    delta = (initial_force / inputs["K"]) ** (1 / inputs["n"])
    before = {str(v): start[str(v)] for v in mechanism.system.q_dot}
    common: dict[str, Any] = {
        "mechanism": mechanism.name,
        "law": law.name,
        "configuration": configuration,
        "stiffness": inputs["K"],
        "exponent": inputs["n"],
        "initial_compression": delta,
        "velocity_before": before,
    }
    if inputs["dashpot"]:
        if configuration == "carried":
            raise InputError(
                f"{where}: the carried configuration needs a law without dashpot. Fix: set its "
                "damping to 0, or leave the configuration frozen."
            )
        return CorrectedJump(**common, **_damped(rule, start, given, inputs, delta))
    found = rule(start, given, delta, configuration)
    head, phase = found.impacts.head, found.impacts.phase
    names = ("duration", "normal_impulse", "tangential_impulse", "compression", "slip_velocity")
    phases = []
    for k in range(int(head["phases"])):
        values = {name: float(phase[name][k]) for name in names}
        kind = _name(int(phase["slip"][k]), bool(phase["loading"][k]), phase["slip"][0])
        rate = float(phase["compression_rate"][k])
        phases.append(CorrectedPhase(name=kind, normal_velocity=0.0 - rate, **values))
    return CorrectedJump(
        **common,
        method=Method(int(head["methods"])).text,
        end=found.impacts.ends[0],
        phases=tuple(phases),
        velocity={name: float(value) for name, value in found.velocity.items()},
    )


def _name(slip: int, loading: bool, first: float) -> str:
    kind = "sticking" if slip == 0 else ("slip" if slip == first else "reverse slip")
    return f"{kind} {'compression' if loading else 'restitution'}"


def _damped(
    rule: CorrectedJumpRule,
    start: Mapping[str, float],
    given: Mapping[str, float],
    inputs: Mapping[str, float],
    delta: float,
) -> dict[str, Any]:
    at = {name: np.asarray(value) for name, value in rule.coefficients(start, given).items()}
    contact = {name: float(at[name]) for name in (*COEFFICIENTS, "mu")}
    v_t, rate = float(at["slip_velocity"]), 0.0 - float(at["normal_velocity"])
    elastic = FrozenImpactSolver(rule.engine)(
        **contact,
        K=inputs["K"],
        n=inputs["n"],
        slip_velocity=v_t,
        compression=delta,
        compression_rate=rate,
    )
    speeds = np.abs(np.nan_to_num(elastic.phase["compression_rate"]))
    scale = (float(elastic.head["largest_compression"]), float(max(speeds.max(), abs(rate))))
    linear, force = None, None
    if rule.law.name == "linear":
        linear = (inputs["K"], inputs["dashpot"])
    else:
        force = _force(rule.law, given)
    impact = damped_impact(
        contact,
        v_t,
        (delta, rate),
        linear=linear,
        force=force,
        scale=(scale[0] or 1.0, scale[1] or 1.0),
    )
    return {
        "method": impact.method,
        "end": impact.end,
        "phases": _damped_phases(impact),
        "velocity": _velocity(rule, at, impact, start),
    }


def _force(law: ContactLaw, given: Mapping[str, float]) -> Callable[[float, float], float]:
    expression = law.loading.force.replace(
        lambda e: isinstance(e, ramp), lambda e: sp.Max(e.args[0], 0)
    )
    values: dict[Any, Any] = {p.symbol: given[p.name] for p in law.parameters}
    for symbol, definition in law.definitions.items():
        values[symbol] = float(numbers([definition], values)[0])
    function: Callable[[float, float], float] = sp.lambdify(
        [DELTA, DELTA_DOT], expression.subs(values), modules="math"
    )
    return function


def _damped_phases(impact: DampedImpact) -> tuple[CorrectedPhase, ...]:
    first = impact.phases[0].slip if impact.phases else 0
    return tuple(
        CorrectedPhase(
            _name(p.slip, p.loading, first),
            p.duration,
            p.normal_impulse,
            p.tangential_impulse,
            p.compression,
            p.slip_velocity,
            0.0 - p.compression_rate,
        )
        for p in impact.phases
    )


def _velocity(
    rule: CorrectedJumpRule,
    at: Mapping[str, Any],
    impact: DampedImpact,
    start: Mapping[str, float],
) -> dict[str, float]:
    P = sum(p.normal_impulse for p in impact.phases)
    P_t = sum(p.tangential_impulse for p in impact.phases)
    t = sum(p.duration for p in impact.phases)
    moved = at["normal"] * P + at["tangential"] * P_t + at["free"] * t
    names = [str(v) for v in rule.mechanism.system.q_dot]
    return {name: start[name] + float(d) for name, d in zip(names, moved, strict=True)}
