"""Every closed form of a mechanism: motion, contact, friction, and the jump by each restitution."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import sympy as sp

from painleve_sym.errors import InputError, received
from painleve_sym.laws.impact_cases import three_phase_jump
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.formulas.formula import Formula, ImpulsePhase, Section
from painleve_sym.mechanics.formulas.one_contact import LEFT, RIGHT
from painleve_sym.mechanics.formulas.whole_mechanism import motion_sections
from painleve_sym.mechanics.impact.impulse_rays import Phase, tangential_phase
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.quantities import QUANTITIES
from painleve_sym.time_limit import within_time

_JAM = (
    "A' = 0: sticking changes neither velocity, whatever its impulse. An impact whose slip stops "
    "before the normal velocity is 0 jams: rigid bodies have no exit from it, a compliant "
    "contact has one."
)
_NOTHING_SLIDES = (
    "W_tt = 0: no motion slides the contact, and the impact begins with the next phase."
)


IMPULSE_VALUES = (
    "normal_impulse",
    "tangential_impulse",
    "stored_energy",
    "slip_velocity",
    "normal_velocity",
)
"""What a phase of the jump gives besides the velocities of the mechanism after it."""


def closed_forms(mechanism: Mechanism) -> tuple[Section, ...]:
    """Return every closed form of a mechanism by section, in reading order.

    Parameters
    ----------
    mechanism : Mechanism
        With one contact: also its jump. With several: each contact alone and all together. In
        space: each contact alone, without jump.

    Returns
    -------
    tuple of Section
        Each with its formulas, and in those of the jump its phases.

    Raises
    ------
    InputError
        The mechanism has no contact.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> ps.closed_forms(ps.models.rod())[0].title
    'energies'
    """
    given: Any = mechanism
    if not isinstance(given, Mechanism):
        raise InputError(f"closed forms: got {received(given)}, need a mechanism. Fix: ps.model.")
    return within_time(f"mechanism {mechanism.name!r}", lambda: _closed_forms(mechanism))


def _closed_forms(mechanism: Mechanism) -> tuple[Section, ...]:
    rows, (bilateral, *others) = mechanism.outline.rows, mechanism.outline.bilateral
    jumps = not (bilateral or others or rows.n_tangents > 1)
    return (*motion_sections(mechanism), *(_jump(mechanism) if jumps else ()))


def _jump(mechanism: Mechanism) -> Iterator[Section]:
    c = mechanism.coefficients
    phases: tuple[ImpulsePhase, ...] = ()
    note = (
        "v_t and v_n are slip and normal velocity at the start of the phase, "
        "the velocities of the mechanism those at its start."
    )
    if not c.slides:
        note = f"{_NOTHING_SLIDES} {note}"
    else:
        left, right = (tangential_phase(c, slip) for slip in (-1, 1))
        phases = (_impulse("tangential_neg", LEFT, left), _impulse("tangential_pos", RIGHT, right))
    yield Section("jump, phase 1: tangential impact until the slip stops", phases=phases, note=note)
    if c.rank_one:
        yield Section("jump, phase 2: jam", note=_JAM)
        return
    _, compression, restitution = three_phase_jump(c).course.phases
    yield Section(
        "jump, phase 2: sticking compression until the normal velocity is 0",
        phases=(_impulse("sticking_compression", "", compression),),
    )
    rebounds = []
    for rule in RESTITUTIONS.values():
        rebounds.append(
            Formula(
                f"rebound_{rule.name}",
                three_phase_jump(c, rule).rebound,
                "m/s",
                f"v_n_plus by {rule.title}",
                r"v_n^{+}",
            )
        )
    yield Section(
        "jump, phase 3: sticking restitution up to the normal velocity v_n_plus",
        tuple(rebounds),
        (_impulse("sticking_restitution", "", restitution),),
        "E_c and P_c are energy and impulse of phases 1 and 2, v_n_minus is v_n before phase 1.",
    )


def _impulse(name: str, meaning: str, phase: Phase) -> ImpulsePhase:
    values = {name: getattr(phase, name) for name in IMPULSE_VALUES}
    values |= {str(symbol): value for symbol, value in phase.velocity.items()}
    conditions = tuple((c.name, c.margin, c.strict) for c in phase.conditions)
    return ImpulsePhase(name, meaning, {k: sp.sympify(v) for k, v in values.items()}, conditions)


def impulse_units(mechanism: Mechanism) -> dict[str, str]:
    """Return the units of the results of a phase of the jump."""
    velocities = {v.name: v.unit for v in mechanism.system.velocities}
    return {name: QUANTITIES[name].unit for name in IMPULSE_VALUES} | velocities
