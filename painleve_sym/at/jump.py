"""The velocity jump of a mechanism at one state: the path of one contact with all velocities."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import mul
from typing import Any

from painleve_sym.at.delassus import ContactNumbers, Delassus, MotionNumbers
from painleve_sym.at.inputs import (
    border_notices,
    place_of,
    refuse_infinite,
    refuse_place,
)
from painleve_sym.checks import StateLike
from painleve_sym.choices import (
    ImpactFriction,
    ImpactFrictionLike,
    Restitution,
    RestitutionLike,
    chosen,
)
from painleve_sym.codegen.named_mechanisms import MechanismLike, as_mechanism
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, PainleveWarning
from painleve_sym.laws.restitution import RestitutionLaw, check_final_slip, restitution_law
from painleve_sym.mechanics.declarations import ParameterSet
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.mechanics.mechanism import Mechanism, Place
from painleve_sym.notebooks import Shown
from painleve_sym.plain_data import plain_fields
from painleve_sym.problem.impact.energy_gain import gain_notice
from painleve_sym.problem.impact.one_contact import Impact, ImpactEnd, solve_impact
from painleve_sym.problem.rounding import MOVED
from painleve_sym.units import Value

_SEVERAL = (
    "Several impulses obey the law of the final slip: this is the one of the least normal impulse."
)
Values = dict[str, float]
"""States and parameters by name."""


@dataclass(frozen=True, eq=False)
class JumpPhase(Compared):
    """One phase of a jump.

    Attributes
    ----------
    name : str
        As in `ImpactPhase`: ``tangential``, ``sticking compression`` and ``sticking restitution``
        in the paper's three-phase jump.
    normal_impulse : float
        N s.
    tangential_impulse : tuple of float
        Along t, in space along t1 and t2; N s.
    stored_energy : float
        Energy the compression gains, negative in restitution; J.
    velocity : mapping of str to float
        Velocities of the mechanism at the end of the phase, by state name (``theta_dot``).
    slip_velocity : tuple of float
        Of the contact at the end of the phase, along t, in space along t1 and t2; m/s.
    normal_velocity : float
        Of the contact at the end of the phase; m/s.
    direction : tuple of float
        Unit vector of the slip at the end of the phase, or of that along which it stops there, by
        tangent; 0 in sticking.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> for phase in ps.evaluate_jump("rod", "energetic", state).phases:
    ...     print(f"{phase.name}: {phase.normal_impulse:.4f} N s")
    tangential: 0.3322 N s
    sticking compression: 0.0088 N s
    sticking restitution: 0.0410 N s
    """

    name: str
    normal_impulse: float
    tangential_impulse: tuple[float, ...]
    stored_energy: float
    velocity: Mapping[str, float]
    slip_velocity: tuple[float, ...]
    normal_velocity: float
    direction: tuple[float, ...]

    def __repr__(self) -> str:
        """Return name and impulses in one line."""
        P_t = ", ".join(f"{P:.6g}" for P in self.tangential_impulse)
        P_t = f"({P_t})" if len(self.tangential_impulse) > 1 else P_t
        return f"JumpPhase {self.name!r}: P_n = {self.normal_impulse:.6g} N s, P_t = {P_t} N s"

    @property
    def impulse(self) -> tuple[float, ...]:
        """P_n and P_t of this phase, rows in the order of W; N s."""
        return (self.normal_impulse, *self.tangential_impulse)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        own = ("name", "normal_impulse", "tangential_impulse", "stored_energy", "velocity")
        return plain_fields(self, *own, "slip_velocity", "normal_velocity", "direction")


@dataclass(frozen=True, eq=False)
class JumpResult(Shown, Compared):
    """The velocity jump of a mechanism.

    Attributes
    ----------
    mechanism, restitution : str
        Names.
    slip_velocity : tuple of float
        Of the contact before the impact, by tangent, exactly 0 where it is rounding; m/s.
    phases : tuple of JumpPhase
        Those before the jam where the impact jams, else all.
    energy_change : float
        Work of the contact impulses as seen from the surface; J. With a surface at rest it is the
        change of the kinetic energy. Never positive with the energetic and with Poisson's law;
        Newton's can gain.
    case : ImpactClass
        ``C_STICKING`` with a slip before the impact is the paper's three-phase jump.
    end : ImpactEnd
        ``JAM`` where the impulse has no end: no rigid jump answers there.
    velocity_before : mapping of str to float
        Velocities of the mechanism before the jump, by state name.
    kinetic_energy : float
        Of the mechanism before the jump; J.
    contact : str
        Name of the contact.
    impact_friction : ImpactFriction
        Whether friction opposes the slip of each moment along the path, or the final slip.
    is_unique : bool
        Whether no other impulse obeys the law; see `Impact`.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> jump = ps.evaluate_jump("rod", "energetic", state)
    >>> [phase.name for phase in jump.phases]
    ['tangential', 'sticking compression', 'sticking restitution']
    >>> round(jump.velocity["y_A_dot"], 6), round(jump.energy_change, 6)
    (0.05247, -0.233397)
    """

    mechanism: str
    restitution: str
    slip_velocity: tuple[float, ...]
    phases: tuple[JumpPhase, ...]
    energy_change: float
    case: ImpactClass
    end: ImpactEnd
    velocity_before: Mapping[str, float]
    kinetic_energy: float
    contact: str
    impact_friction: ImpactFriction = ImpactFriction.PATH
    is_unique: bool = True

    def __repr__(self) -> str:
        """Return mechanism, law, class, end and energy in one line."""
        return (
            f"JumpResult of {self.mechanism!r} by {self.restitution!r}: {self.case.value}, ends in "
            f"{self.end.value}, P_n = {self.normal_impulse:.6g} N s, energy "
            f"{self.energy_change:+.6g} J"
        )

    @property
    def notice(self) -> str:
        """A sentence where the jump adds energy, and one where it is not the only one; or empty."""
        given = self.energy_change, self.kinetic_energy, self.restitution
        gain = gain_notice(*given, (self.contact,))
        return " ".join(text for text in (gain, "" if self.is_unique else _SEVERAL) if text)

    @property
    def velocity(self) -> Mapping[str, float]:
        """Velocities of the mechanism after the jump (up to the jam), by state name."""
        return self.phases[-1].velocity if self.phases else self.velocity_before

    @property
    def normal_impulse(self) -> float:
        """P_n of the jump (up to the jam); N s."""
        return math.fsum(phase.normal_impulse for phase in self.phases)


def evaluate_jump(
    mechanism: MechanismLike,
    restitution: RestitutionLaw | RestitutionLike,
    state: StateLike | None = None,
    *,
    e: Value | None = None,
    impact_friction: ImpactFrictionLike = ImpactFriction.PATH,
    parameters: Mapping[str, Value] | None = None,
    close: str | None = None,
    contact_velocity: Sequence[float] | None = None,
) -> JumpResult:
    """Evaluate the jump at one state: the phases of the impact's class.

    The contact is taken as closed whatever its gap, since a compliant contact is compressed. With
    A < 0 and B > 0 (the indeterminate case) the jump is the answer only if the contact carries
    more than −B/A; that is for the caller to know.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
        With one contact.
    restitution : RestitutionLaw, or Restitution or its text
        ``energetic`` is the paper's.
    state : mapping of str to (float or str), optional
        Coordinates and velocities by name, those absent are 0; SI units, rad. The mechanism's
        `start` where no state is given.
    e : float, optional
        Coefficient of restitution, in [0, 1]; by default that of the law, 0.75.
    impact_friction : ImpactFriction or its text
        Which slip friction opposes: that of each moment along the ``path`` of the impulse, or the
        ``final_slip``, which takes Newton's law; see `solve_impact`.
    parameters : mapping of str to float, optional
        Parameters of the mechanism; those absent keep their default. The restitution law's own name
        of e, such as ``e_newton``, may stand among them in place of `e`.
    close : str, optional
        A coordinate for which gap = 0 is solved from the given state, ``CONTACT:COORDINATE`` with
        several contacts; see `at.closing.closed_state`.
    contact_velocity : sequence of float, optional
        Of the only contact, along n and t, in space n, t1, t2, m/s: the velocities of the state are
        changed for it, with the least kinetic energy of the change; see
        `at.inputs.moving_place`.

    Returns
    -------
    JumpResult

    Raises
    ------
    InputError
        Unknown or invalid entries (all at once); a state that is not an impact. The message says
        which and what to do.
    CompilerMissing
        In space where there is no C compiler; see `solve_impact`.

    References
    ----------
    Impact model resolution on Painlevé's paradox, section 4; Wang & Mason (1992) for the other
    classes.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> jump = ps.evaluate_jump("rod", "energetic", state)
    >>> [phase.name for phase in jump.phases]
    ['tangential', 'sticking compression', 'sticking restitution']
    """
    mechanism = as_mechanism(mechanism)
    law = restitution
    if not isinstance(law, RestitutionLaw):
        law = restitution_law(chosen(Restitution, law, "restitution law", "jump"))
    where = _where(mechanism)
    friction = chosen(ImpactFriction, impact_friction, "impact friction", where)
    mechanism.require_one_contact()
    if e is not None:
        parameters = _with_coefficient(where, law.parameter.name, e, parameters or {})
    declared = ParameterSet(*mechanism.outline.parameters, law.parameter)
    checks = {"declared": declared, "where": where}
    place = place_of(mechanism, state, parameters, close, contact_velocity, **checks)
    result = jump_at(place, law, friction)
    for notice in border_notices(place):
        warnings.warn(notice, PainleveWarning, stacklevel=2)
    return result


def _where(mechanism: Mechanism) -> str:
    return f"jump of mechanism {mechanism.name!r}"


def _with_coefficient(
    where: str, name: str, e: Value, parameters: Mapping[str, Value]
) -> dict[str, Value]:
    """Return the parameters with e by its name there; InputError where it has it already."""
    if name in parameters:
        raise InputError(
            f"{where}: got e = {e!r} and {name} = {parameters[name]!r} among the parameters, and "
            "both are the coefficient of restitution. Fix: give it once, as e."
        )
    return {**parameters, name: e}


def jump_at(
    place: Place, law: RestitutionLaw, impact_friction: ImpactFriction = ImpactFriction.PATH
) -> JumpResult:
    """Return the jump at a place with the law's coefficient; see `evaluate_jump`."""
    mechanism, values = place.mechanism, place.values
    where, of = _where(mechanism), Delassus.of(mechanism)
    at, moves = of.whole_at(values)
    refuse_place(place, at)
    refuse_infinite(mechanism, values, at)
    velocity = contact_velocity_at(mechanism, values, at, moves)
    v_n, *v_t = velocity
    mechanism.require_one_coefficient(where, "simulate with a compliant law")
    if v_n > 0:
        raise InputError(
            f"{where}: got v_n = {v_n:g} m/s, need v_n <= 0: the contact is opening. "
            f"Fix: simulate the flight up to the next contact."
        )
    e = values[law.parameter.name]
    check_final_slip(impact_friction, law, where)
    W, mu = (at.W + 0.0).tolist(), at.mu.item()
    impact = solve_impact(W, mu, velocity, law, e, impact_friction=impact_friction)
    if impact.case is ImpactClass.NO_IMPACT:
        raise InputError(f"{where}: {_no_impact(at, v_t)}")
    phases, energy = _of_impact(mechanism, values, moves, impact), impact.energy_change
    before = {name: values[name] for name in mechanism.outline.velocity_names}
    contact = mechanism.outline.contacts[0].name
    own = (impact.case, impact.end, before, moves.kinetic_energy.item(), contact)
    read = impact.impact_friction, impact.is_unique
    return JumpResult(mechanism.name, law.name, tuple(v_t), phases, energy, *own, *read)


def contact_velocity_at(
    mechanism: Mechanism, values: Values, at: ContactNumbers, moves: MotionNumbers
) -> list[float]:
    """Return v_n and v_t, each exactly 0 where it is only the rounding of its terms."""
    speeds = [values[name] for name in mechanism.outline.velocity_names]
    velocity = []
    of_contact = *at.gap_rate.tolist(), *at.slip_velocity.ravel().tolist()
    for value, row in zip(of_contact, moves.J.tolist(), strict=True):
        terms = sum(map(abs, map(mul, row, speeds)))
        velocity.append(value if abs(value) > MOVED * terms else 0.0)
    return velocity


def _no_impact(at: ContactNumbers, v_t: Sequence[float]) -> str:
    speed = math.hypot(*v_t)
    if not speed:
        return (
            "got v_t = 0 and v_n = 0, need a moving contact: at rest there is no impact without "
            "collision. Fix: give a slip with A < 0, or an approach v_n < 0, by the state or by "
            "--contact-velocity."
        )
    along = math.fsum(w * v / speed for w, v in zip(at.W[0, 1:].tolist(), v_t, strict=True))
    A, B = float(at.W[0, 0] - at.mu[0] * along) + 0.0, float(at.b[0]) + 0.0
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


def _of_impact(
    mechanism: Mechanism, values: Values, moves: MotionNumbers, impact: Impact
) -> tuple[JumpPhase, ...]:
    names = mechanism.outline.velocity_names
    directions = (moves.D + 0.0).tolist()
    velocity, phases = [values[name] for name in names], []
    for phase in impact.phases:
        impulses = phase.impulse
        terms = [(v, *map(mul, row, impulses)) for v, row in zip(velocity, directions, strict=True)]
        velocity = [
            after if abs(after := math.fsum(of_one)) > MOVED * sum(map(abs, of_one)) else 0.0
            for of_one in terms
        ]
        named = dict(zip(names, velocity, strict=True))
        stored = -phase.normal_work + 0.0
        v_n, *v_t = phase.velocity
        given = phase.name, phase.normal_impulse, phase.tangential_impulse, stored, named
        phases.append(JumpPhase(*given, tuple(v_t), v_n, phase.direction))
    return tuple(phases)
