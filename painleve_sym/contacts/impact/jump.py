"""The velocity jump of a mechanism at one state: the path of one contact with all velocities."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.contacts.impact.one_contact import Impact, ImpactEnd, solve_impact
from painleve_sym.contacts.inputs import resolve_parameters, resolve_state, symbol_values
from painleve_sym.errors import InputError
from painleve_sym.laws.impact_cases import three_phase_jump
from painleve_sym.laws.restitution import RESTITUTIONS, RestitutionLaw, restitution_law
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_T, raw
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
        As in `ImpactPhase`: ``tangential``, ``sticking compression`` and ``sticking restitution``
        in the paper's three-phase jump.
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

    @property
    def normal_impulse(self) -> float:
        """P_n of the jump (up to the jam); N s."""
        return math.fsum(phase.normal_impulse for phase in self.phases)


def evaluate_jump(
    mechanism: Mechanism,
    restitution: RestitutionLaw | str,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
) -> JumpResult:
    """Evaluate the jump at one state: the phases of the impact's class.

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
    v_n, v_t = _contact_velocities(mechanism.contact, values)
    if v_n > 0:
        raise InputError(
            f"{where}: got v_n = {v_n:g} m/s, need v_n <= 0: the contact is opening. "
            f"Fix: let it fly until it touches again."
        )
    slip = (v_t > 0) - (v_t < 0)
    impact = _solved(mechanism, law, values, (v_n, v_t))
    if impact.case is ImpactClass.NO_IMPACT:
        raise InputError(f"{where}: {_no_impact(mechanism, values, slip)}")
    if law.name in RESTITUTIONS:
        phases, energy = _of_impact(mechanism, values, impact), impact.energy_change
    elif slip and impact.case is ImpactClass.C_STICKING and impact.end is not ImpactEnd.JAM:
        phases, energy = _of_law(mechanism, law, values, (v_n, v_t))
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
    """Return v_n and v_t, exactly 0 where they are only the rounding of their terms."""
    pair = []
    for rate, jacobian in ((contact.gap_rate, contact.J_N), (contact.slip_velocity, contact.J_T)):
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
    return solve_impact(((W_nn, W_nt), (W_nt, W_tt)), mu, velocity, name, e)


def _no_impact(mechanism: Mechanism, values: Values, slip: int) -> str:
    if not slip:
        return (
            "got v_t = 0 and v_n = 0, need a moving contact: at rest there is no impact without "
            "collision. Fix: give a slip with A < 0, or an approach v_n < 0."
        )
    c = mechanism.coefficients
    A, B = _numbers((c.A(slip), c.B), values)
    if B > 0:
        answer = "it lifts off (case 2 of the paper, B > 0)"
    elif B == 0:
        answer = "it grazes the surface (B = 0)"
    else:
        answer = "it slides on with F_n = -B/A (case 1 of the paper, A > 0 and B < 0)"
    return (
        f"got v_n = 0 with A = {A:g} 1/kg and B = {B:g} m/s^2, need A <= 0 for an impact without "
        f"collision: {answer}. Fix: integrate on, or give an approach v_n < 0."
    )


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
        v_n, v_t = phase.velocity
        phases.append(JumpPhase(phase.name, *impulses, stored, named, v_t, v_n))
    return tuple(phases)


def _of_law(
    mechanism: Mechanism, law: RestitutionLaw, values: Values, velocity: tuple[float, float]
) -> tuple[tuple[JumpPhase, ...], float]:
    """Return the phases and the energy of a law of one's own, from its closed forms."""
    v_n, v_t = velocity
    jump = three_phase_jump(mechanism.coefficients, law, 1 if v_t > 0 else -1, write=raw)
    values = values | {V_N: v_n, V_T: v_t}
    phases = []
    for phase in jump.phases:
        impulses = (phase.normal_impulse, phase.tangential_impulse, phase.stored_energy)
        ends = (phase.slip_velocity, phase.normal_velocity)
        P_n, P_t, stored, slip, normal = _numbers((*impulses, *ends), values)
        names = map(str, phase.velocity)
        after = dict(zip(names, _numbers(tuple(phase.velocity.values()), values), strict=True))
        phases.append(JumpPhase(phase.name, P_n, P_t, stored, after, slip, normal))
    return tuple(phases), _number(jump.energy_change, values)


def _number(expr: Any, values: Values) -> float:
    return _numbers((expr,), values)[0]


def _numbers(exprs: tuple[Any, ...], values: Values) -> list[float]:
    # Adding 0.0 turns -0.0 into 0.0.
    return [float(number) + 0.0 for number in numbers(exprs, values)]
