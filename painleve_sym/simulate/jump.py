"""Numbers for the three-phase jump: its closed forms evaluated at one state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.errors import InputError
from painleve_sym.laws.impact import (
    E_C,
    P_C,
    V_N_MINUS,
    RestitutionLaw,
    ThreePhaseJump,
    restitution_law,
    three_phase_jump,
)
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.impulses import V_N, V_N_PLUS, V_T, Phase, raw
from painleve_sym.mechanics.models import Mechanism
from painleve_sym.simulate.inputs import resolve_parameters, resolve_state, symbol_values

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
        ``tangential``, ``sticking compression`` or ``sticking restitution``.
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
        Sign of the slip velocity before the impact.
    phases : tuple of JumpPhase
    energy_change : float
        Work of the contact impulses as seen from the surface; J. With a surface at rest it is the
        change of the kinetic energy. Never positive with the energetic law.
    """

    mechanism: str
    restitution: str
    slip: int
    phases: tuple[JumpPhase, ...]
    energy_change: float

    @property
    def velocity(self) -> Mapping[str, float]:
        """Velocities of the mechanism after the jump, by state name."""
        return self.phases[-1].velocity


def evaluate_jump(
    mechanism: Mechanism,
    restitution: RestitutionLaw | str,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
) -> JumpResult:
    """Evaluate the three-phase jump at one state.

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
        Unknown or invalid entries (all at once); a state that is not an impact; an impact
        that is not made of these three phases. The message says which and what to do.
    """
    law = restitution_law(restitution) if isinstance(restitution, str) else restitution
    where = f"jump of mechanism {mechanism.name!r}"
    declared = (*mechanism.system.parameters, law.parameter)
    given = resolve_parameters(where, declared, parameters or {})
    start = resolve_state(mechanism, state, given)
    values = symbol_values(mechanism, start, given)
    values[law.parameter.symbol] = given[law.parameter.name]
    v_t, v_n = _contact_velocities(mechanism.contact, values)
    slip = int(math.copysign(1, v_t))
    _refuse_no_impact(mechanism, values, v_t, v_n, slip, where)
    jump = three_phase_jump(mechanism.coefficients, law, slip, write=raw)
    first = _run(jump.tangential, values | {V_T: v_t, V_N: v_n}, where)
    between = _moved(values, first) | {V_T: 0.0, V_N: first.normal_velocity}
    second = _run(jump.compression, between, where)
    rebound = _rebound(jump, values, v_n, first, second)
    third = _run(jump.restitution, _moved(values, second) | {V_N_PLUS: rebound}, where)
    # Slip falls linearly with the impulse: friction works against its mean.
    friction = first.tangential_impulse * v_t / 2
    stored = math.fsum(phase.stored_energy for phase in (first, second, third))
    return JumpResult(mechanism.name, law.name, slip, (first, second, third), friction - stored)


def _contact_velocities(contact: Contact, values: Values) -> tuple[float, float]:
    """Return v_t and v_n, exactly 0 where they are only the rounding of their terms."""
    pair = []
    for rate, jacobian in ((contact.slip_velocity, contact.J_T), (contact.gap_rate, contact.J_N)):
        value = _number(rate, values)
        rates = zip(contact.system.q_dot, jacobian, strict=True)
        terms = sum(abs(_number(j, values) * values[v]) for v, j in rates)
        pair.append(value if abs(value) > ROUND_OFF * terms else 0.0)
    return pair[0], pair[1]


def _refuse_no_impact(
    mechanism: Mechanism, values: Values, v_t: float, v_n: float, slip: int, where: str
) -> None:
    if v_n > 0:
        raise InputError(
            f"{where}: got v_n = {v_n:g} m/s, need v_n <= 0: the contact is opening. "
            f"Fix: let it fly until it touches again."
        )
    if v_t == 0:
        raise InputError(
            f"{where}: got v_t = 0, need a slip: its first phase ends when the slip stops. "
            f"Fix: start from a sliding contact, or simulate it softened."
        )
    if v_n < 0:
        return
    A = _number(mechanism.coefficients.A(slip), values)
    B = _number(mechanism.coefficients.B, values)
    if A >= 0:
        raise InputError(
            f"{where}: got v_n = 0 with A = {A:g} 1/kg and B = {B:g} m/s^2, need A < 0 for an "
            f"impact without collision: {_no_impact_case(A, B)}. "
            f"Fix: integrate on, or give an approach v_n < 0."
        )


def _no_impact_case(A: float, B: float) -> str:
    if B > 0:
        return "it lifts off (case 2 of the paper, B > 0)"
    if B == 0:
        return "it grazes the surface (B = 0)"
    if A == 0:
        return "A = 0 is the border between cases 1 and 3 of the paper"
    return "it slides on with F_n = -B/A (case 1 of the paper, A > 0 and B < 0)"


def _run(phase: Phase, values: Values, where: str) -> JumpPhase:
    """Check the conditions of a phase at its starting velocities, then evaluate it."""
    for condition in phase.conditions:
        margin = _number(condition.margin, values)
        if not condition.holds(margin):
            raise InputError(
                f"{where}, {phase.name} phase: {condition.meaning}: got margin {margin:g} of "
                f"{condition.name!r}, need {'>' if condition.strict else '>='} 0. The three-phase "
                f"jump does not hold here. Fix: simulate it with a softened contact."
            )
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
