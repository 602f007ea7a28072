"""The velocity jump of a mechanism at one state: its three-phase closed forms, or all cases."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.contacts.impact.one_contact import Impact, ImpactEnd, solve_impact
from painleve_sym.contacts.inputs import resolve_parameters, resolve_state, symbol_values
from painleve_sym.errors import InputError
from painleve_sym.laws.restitution import (
    E_C,
    P_C,
    RESTITUTIONS,
    V_N_MINUS,
    RestitutionLaw,
    ThreePhaseJump,
    restitution_law,
    three_phase_jump,
)
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.impact.classes import ImpactClass
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_N_PLUS, V_T, Phase, raw
from painleve_sym.mechanics.models import Mechanism

# A velocity that is a sum of rounded products counts as zero below this part of its terms.
ROUND_OFF = 1e-14

Values = dict[Any, float]
"""Numbers by symbol."""


@dataclass(frozen=True)
class JumpPhase:
    """One phase of a jump.

    Attributes
    ----------
    name : str
        ``tangential``, ``sticking compression`` and ``sticking restitution`` in the paper's
        three-phase jump; otherwise as in `ImpactPhase`.
    normal_impulse, tangential_impulse : float
        N s.
    stored_energy : float
        Energy the compression gains, negative in restitution; J.
    velocity : mapping of str to float
        Velocities of the mechanism at the end of the phase, by state name (``theta_dot``).
    slip_velocity, normal_velocity : float
        Of the contact at the end of the phase; m/s.
    """

    name: str
    normal_impulse: float
    tangential_impulse: float
    stored_energy: float
    velocity: Mapping[str, float]
    slip_velocity: float
    normal_velocity: float


@dataclass(frozen=True)
class JumpResult:
    """The velocity jump of a mechanism.

    Attributes
    ----------
    mechanism, restitution : str
        Names.
    slip : int
        Sign of the slip velocity before the impact, 0 for a start at v_t = 0.
    phases : tuple of JumpPhase
        Those before the jam where the impact jams, else all.
    energy_change : float
        Work of the contact impulses as seen from the surface; J. With a surface at rest it is the
        change of the kinetic energy. Never positive with the energetic and with Poisson's law.
    case : ImpactClass
        ``C_STICKING`` with a slip before the impact is the paper's three-phase jump.
    end : ImpactEnd
        ``JAM`` where the impulse has no end: no rigid jump answers there.
    velocity_before : mapping of str to float
        Velocities of the mechanism before the jump, by state name.
    """

    mechanism: str
    restitution: str
    slip: int
    phases: tuple[JumpPhase, ...]
    energy_change: float
    case: ImpactClass
    end: ImpactEnd
    velocity_before: Mapping[str, float]

    @property
    def velocity(self) -> Mapping[str, float]:
        """Velocities of the mechanism after the jump (up to the jam), by state name."""
        return self.phases[-1].velocity if self.phases else self.velocity_before


def evaluate_jump(
    mechanism: Mechanism,
    restitution: RestitutionLaw | str,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
) -> JumpResult:
    """Evaluate the jump at one state: the paper's three phases, or those of the impact's class.

    The contact is taken as closed whatever its gap, since a softened contact is compressed. With
    A < 0 and B > 0 (the indeterminate case) the jump is the answer only if the contact carries
    more than −B/A; that is for the caller to know.

    Parameters
    ----------
    mechanism : Mechanism
        With one contact.
    restitution : RestitutionLaw or str
        ``energetic`` is the paper's.
    state : mapping of str to float
        Coordinates and velocities by name, those absent are 0; SI units, rad.
    parameters : mapping of str to float, optional
        Parameters of the mechanism and of the restitution law; those absent keep their default.

    Returns
    -------
    JumpResult

    Raises
    ------
    InputError
        Unknown or invalid entries (all at once); a state that is not an impact. The message says
        which and what to do.

    References
    ----------
    Zhao, Liu & Chen, section 4; Wang & Mason (1992) for the other classes.
    """
    law = restitution_law(restitution) if isinstance(restitution, str) else restitution
    where = f"jump of mechanism {mechanism.name!r}"
    declared = (*mechanism.system.parameters, law.parameter)
    given = resolve_parameters(where, declared, parameters or {})
    start = resolve_state(mechanism, state, given)
    values = symbol_values(mechanism, start, given)
    values[law.parameter.symbol] = given[law.parameter.name]
    return _jump(mechanism, law, values, where)


def _jump(mechanism: Mechanism, law: RestitutionLaw, values: Values, where: str) -> JumpResult:
    v_t, v_n = _contact_velocities(mechanism.contact, values)
    if v_n > 0:
        raise InputError(
            f"{where}: got v_n = {v_n:g} m/s, need v_n <= 0: the contact is opening. "
            f"Fix: let it fly until it touches again."
        )
    slip = (v_t > 0) - (v_t < 0)
    impact = _solved(mechanism, law, values, (v_t, v_n))
    if impact.case is ImpactClass.NO_IMPACT:
        raise InputError(f"{where}: {_no_impact(mechanism, values, slip)}")
    phases = None
    if slip and impact.case is ImpactClass.C_STICKING and impact.end is not ImpactEnd.JAM:
        phases = _three_phases(mechanism, law, values, (v_t, v_n))
    energy = impact.energy_change
    if phases is not None:
        # Slip falls linearly with the impulse: friction works against its mean.
        friction = phases[0].tangential_impulse * v_t / 2
        energy = friction - math.fsum(phase.stored_energy for phase in phases)
    elif law.name in RESTITUTIONS:
        phases = _of_impact(mechanism, values, impact)
    else:
        raise InputError(
            f"{where}: got restitution law {law.name!r} in an impact of class "
            f"{impact.case.value!r}, need one of {sorted(RESTITUTIONS)}. Fix: give one of these."
        )
    before = {str(v): values[v] for v in mechanism.system.q_dot}
    return JumpResult(
        mechanism.name, law.name, slip, phases, energy, impact.case, impact.end, before
    )


def _contact_velocities(contact: Contact, values: Values) -> tuple[float, float]:
    """Return v_t and v_n, exactly 0 where they are only the rounding of their terms."""
    pair = []
    for rate, jacobian in ((contact.slip_velocity, contact.J_T), (contact.gap_rate, contact.J_N)):
        value = _number(rate, values)
        rates = zip(contact.system.q_dot, jacobian, strict=True)
        terms = sum(abs(_number(j, values) * values[v]) for v, j in rates)
        pair.append(value if abs(value) > ROUND_OFF * terms else 0.0)
    return pair[0], pair[1]


def _solved(
    mechanism: Mechanism, law: RestitutionLaw, values: Values, velocity: tuple[float, float]
) -> Impact:
    c = mechanism.coefficients
    W_nn, W_nt, W_tt, mu = _numbers((c.W_nn, c.W_nt, c.W_tt, c.mu), values)
    # Whether the slip stops in compression does not depend on the law: any known one tells.
    known = law.name in RESTITUTIONS
    name, e = (law.name, values[law.parameter.symbol]) if known else ("newton", 0.0)
    return solve_impact(((W_tt, W_nt), (W_nt, W_nn)), mu, velocity, name, e)


def _no_impact(mechanism: Mechanism, values: Values, slip: int) -> str:
    if not slip:
        return (
            "got v_t = 0 and v_n = 0, need a moving contact: at rest there is no impact without "
            "collision. Fix: give a slip with A < 0, or an approach v_n < 0."
        )
    # A is not negative here but for its rounding.
    A = max(0.0, _number(mechanism.coefficients.A(slip), values))
    B = _number(mechanism.coefficients.B, values)
    return (
        f"got v_n = 0 with A = {A:g} 1/kg and B = {B:g} m/s^2, need A < 0 for an impact without "
        f"collision: {_no_impact_case(A, B)}. Fix: integrate on, or give an approach v_n < 0."
    )


def _no_impact_case(A: float, B: float) -> str:
    if B > 0:
        return "it lifts off (case 2 of the paper, B > 0)"
    if B == 0:
        return "it grazes the surface (B = 0)"
    if A == 0:
        return "A = 0 is the border between cases 1 and 3 of the paper"
    return "it slides on with F_n = -B/A (case 1 of the paper, A > 0 and B < 0)"


def _of_impact(mechanism: Mechanism, values: Values, impact: Impact) -> tuple[JumpPhase, ...]:
    """Return the phases of an impact with the velocities of the mechanism."""
    symbols = mechanism.system.q_dot
    directions = [_numbers(tuple(d), values) for d in mechanism.coefficients.force_directions]
    velocity, phases = [values[v] for v in symbols], []
    for phase in impact.phases:
        impulses = (phase.normal_impulse, phase.tangential_impulse)
        moved = []
        for v, *per_impulse in zip(velocity, *directions, strict=True):
            terms = (v, *(d * P for d, P in zip(per_impulse, impulses, strict=True)))
            after, size = math.fsum(terms), sum(map(abs, terms))
            moved.append(after if abs(after) > ROUND_OFF * size else 0.0)
        velocity = moved
        named = {str(s): v for s, v in zip(symbols, velocity, strict=True)}
        # Adding 0.0 turns -0.0 into 0.0.
        stored = -phase.normal_work + 0.0
        phases.append(JumpPhase(phase.name, *impulses, stored, named, *phase.velocity))
    return tuple(phases)


def _three_phases(
    mechanism: Mechanism, law: RestitutionLaw, values: Values, velocity: tuple[float, float]
) -> tuple[JumpPhase, ...] | None:
    """Return the paper's closed forms; None where rounding at a tie breaks their conditions."""
    v_t, v_n = velocity
    jump = three_phase_jump(mechanism.coefficients, law, 1 if v_t > 0 else -1, write=raw)
    first = _run(jump.tangential, values | {V_T: v_t, V_N: v_n})
    if first is None:
        return None
    between = _moved(values, first) | {V_T: 0.0, V_N: first.normal_velocity}
    second = _run(jump.compression, between)
    if second is None:
        return None
    rebound = _rebound(jump, values, v_n, first, second)
    third = _run(jump.restitution, _moved(values, second) | {V_N_PLUS: rebound})
    return None if third is None else (first, second, third)


def _run(phase: Phase, values: Values) -> JumpPhase | None:
    """Evaluate a phase at its starting velocities; None where a condition does not hold."""
    margins = _numbers(tuple(c.margin for c in phase.conditions), values)
    if not all(c.holds(m) for c, m in zip(phase.conditions, margins, strict=True)):
        return None
    velocities = tuple(phase.velocity.values())
    impulses = (phase.normal_impulse, phase.tangential_impulse, phase.stored_energy)
    ends = (phase.slip_velocity, phase.normal_velocity)
    found = _numbers((*impulses, *ends, *velocities), values)
    names = (str(symbol) for symbol in phase.velocity)
    return JumpPhase(
        phase.name,
        normal_impulse=found[0],
        tangential_impulse=found[1],
        stored_energy=found[2],
        velocity=dict(zip(names, found[5:], strict=True)),
        slip_velocity=found[3],
        normal_velocity=found[4],
    )


def _rebound(
    jump: ThreePhaseJump, values: Values, v_n: float, first: JumpPhase, second: JumpPhase
) -> float:
    summary = {
        V_N_MINUS: v_n,
        P_C: first.normal_impulse + second.normal_impulse,
        E_C: first.stored_energy + second.stored_energy,
    }
    return _number(jump.separation_velocity, values | summary)


def _moved(values: Values, phase: JumpPhase) -> Values:
    return {symbol: phase.velocity.get(str(symbol), value) for symbol, value in values.items()}


def _number(expr: Any, values: Values) -> float:
    return _numbers((expr,), values)[0]


def _numbers(exprs: tuple[Any, ...], values: Values) -> list[float]:
    # Adding 0.0 turns -0.0 into 0.0.
    return [float(number) + 0.0 for number in numbers(exprs, values)]
