"""The tangential impact of a bilateral contact: the impulse that stops its slip at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from painleve_sym.at.cases import closed_contacts
from painleve_sym.at.delassus import Delassus, argument_symbols
from painleve_sym.at.inputs import inside, place_of
from painleve_sym.checks import StateLike
from painleve_sym.codegen.named_mechanisms import MechanismLike
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.mechanics.mechanism import Mechanism, Place
from painleve_sym.plain_data import plain_fields
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.solution import ContactCase
from painleve_sym.units import Value

_SLIP_VELOCITY = "v_t"
"""Name of the slip velocity in the closed forms."""


@dataclass(frozen=True, eq=False)
class TangentialImpact(Compared):
    """The impulse that stops the slip of a bilateral contact at once.

    Attributes
    ----------
    mechanism : str
    slip_velocity : tuple of float
        (v_t,) before; m/s.
    normal_impulse : float
        P_n of either sign; N s.
    tangential_impulse : tuple of float
        (P_t,), |P_t| ≤ μ |P_n|; N s.
    velocity_before, velocity : dict of str to float
        Velocities of the mechanism, by state name.
    energy_change : float
        Work of P_t as seen from the guide; J.
    case : ContactCase
        Of the state before: INCONSISTENT leaves nothing else, INDETERMINATE offers slips as well.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> from painleve_sym.at import tangential_impact
    >>> klein = ps.models.painleve_klein()
    >>> impact = tangential_impact(klein, klein.start)
    >>> impact.case, round(impact.energy_change, 6)
    (<ContactCase.INDETERMINATE: 'indeterminate'>, -1.0)
    """

    mechanism: str
    slip_velocity: tuple[float, ...]
    normal_impulse: float
    tangential_impulse: tuple[float, ...]
    velocity_before: dict[str, float]
    velocity: dict[str, float]
    energy_change: float
    case: ContactCase

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        impulses = ("normal_impulse", "tangential_impulse", "energy_change")
        return {
            "bilateral": True,
            **plain_fields(self, "mechanism", "slip_velocity", *impulses, "case"),
            "before": {"velocity": self.velocity_before},
            "final": {"velocity": self.velocity},
        }


def tangential_impact(
    mechanism: MechanismLike,
    state: StateLike,
    *,
    parameters: Mapping[str, Value] | None = None,
) -> TangentialImpact:
    """Return the tangential impact of a bilateral contact at a state of slip.

    W P = (0, −v_t): the only impulse other than 0 that keeps v_n = 0 and obeys Coulomb's law for
    impulses. It lies in the friction cone exactly where μ |W_nt| ≥ W_nn.

    Parameters
    ----------
    mechanism, state, parameters
        As for `classify`, of a mechanism with one bilateral contact.

    Raises
    ------
    InputError
        Also for v_t = 0 and for μ |W_nt| < W_nn, where finite forces answer.

    Examples
    --------
    >>> from painleve_sym.at import tangential_impact
    >>> impact = tangential_impact("painleve-klein", {"phi": 1.2, "x_dot": -1.0})
    >>> impact.energy_change < 0
    True
    """
    return tangential_impact_at(inside(place_of(mechanism, state, parameters)))


def tangential_impact_at(place: Place) -> TangentialImpact:
    """Return the tangential impact at a place; see `tangential_impact`."""
    mechanism = place.mechanism
    where = f"jump of mechanism {mechanism.name!r}"
    mechanism.require_one_contact()
    if not mechanism.outline.contacts[0].bilateral:
        raise InputError(f"{where}: its contact can open. Fix: use evaluate_jump.")
    at = Delassus.of(mechanism).at(place.values)
    closed_contacts(where, mechanism, at)
    bilateral = np.array(mechanism.outline.bilateral)
    problem = ContactProblem(at.W, at.b, at.mu, at.slip_velocity, bilateral)
    if not problem.slip_direction:
        raise InputError(f"{where}: got v_t = 0, need a slip for an impact to stop.")
    worst = min(problem.A_slip(1), problem.A_slip(1, -1))
    if worst > 0:
        raise InputError(
            f"{where}: got mu |W_nt| - W_nn = {-worst:g} 1/kg, need >= 0 for a tangential impact: "
            "the slip has one solution with finite forces. Fix: integrate on, or raise mu."
        )
    results = _impulse_numbers(mechanism)(
        {**place.values, _SLIP_VELOCITY: problem.slip_velocity.item()}
    )
    P_n, P_t, loss, *velocity = (v + 0.0 for v in results.values())
    names = mechanism.outline.velocity_names
    return TangentialImpact(
        mechanism=mechanism.name,
        slip_velocity=(problem.slip_velocity.item(),),
        normal_impulse=P_n,
        tangential_impulse=(P_t,),
        velocity_before={n: place.state[n] for n in names},
        velocity=dict(zip(names, velocity, strict=True)),
        energy_change=-loss,
        case=problem.case,
    )


def _impulse_numbers(mechanism: Mechanism) -> Quantities:
    """Return P_n, P_t, the friction loss and the velocities after, in this order."""

    def derive() -> tuple[dict[str, Any], tuple[Any, ...]]:
        from painleve_sym.mechanics.impact.impulse_rays import V_T
        from painleve_sym.mechanics.paradox.bilateral import BilateralForms

        forms = BilateralForms(mechanism.coefficients)
        names = ("normal_impulse", "tangential_impulse", "friction_loss")
        formulas = {name: getattr(forms, name) for name in names}
        formulas |= dict(zip(mechanism.outline.velocity_names, forms.velocity_after, strict=True))
        return formulas, (*argument_symbols(mechanism), V_T)

    arguments = (*mechanism.outline.argument_names, _SLIP_VELOCITY)
    return quantities("tangential impact", mechanism.definition, arguments, derive)
