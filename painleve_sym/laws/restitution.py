"""Restitution laws: what each measures, and its coefficient."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from functools import cached_property, reduce
from operator import mul
from typing import TYPE_CHECKING, TypeVar

from painleve_sym.choices import ImpactFriction, Restitution
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.mechanics.declarations import Parameter

if TYPE_CHECKING:
    from sympy import Eq, Expr

_Number = TypeVar("_Number", float, "Expr")


class Measure(enum.StrEnum):
    """The quantity of compression of which restitution returns a share eᵖ, p the power of a law."""

    VELOCITY = "velocity"
    """v_n⁺ = −eᵖ v_n⁻: a kinematic coefficient."""
    IMPULSE = "impulse"
    """P_r = eᵖ P_c: a kinetic coefficient."""
    WORK = "work"
    """E_r = −eᵖ E_c: an energetic coefficient."""


@dataclass(frozen=True)
class RestitutionLaw:
    """A restitution law: one equation between compression and restitution.

    The laws differ by their `measure` and by the `power` of the coefficient in the share of it that
    comes back. Those of this module agree at restitution 0, where the whole impact follows one ray
    (slip throughout, or a start at v_t = 0), and where W_nt = 0 (a central impact: dv_n/dP_n is
    W_nn on every ray). Otherwise they differ; for an impact without collision v_n⁻ = 0, and
    Newton's law gives no rebound at all.

    With restitution in [0, 1] and Coulomb friction the energetic and Poisson's law never add energy
    in a planar impact of a single contact over ground at rest; Newton's can. They are laws of one
    contact: how several contacts share an impact is a rule of this package, with which the same
    holds; see `solve_simultaneous_impact`.

    The parameter is the coefficient of restitution e, in [0, 1]. The note says what the law assumes
    and where it fails.
    """

    name: str
    title: str
    source: str
    parameter: Parameter
    measure: Measure
    power: int
    note: str

    def share(self, e: _Number) -> _Number:
        """Return the share eᵖ of the measure that comes back; 1."""
        return reduce(mul, [e] * self.power)

    def share_slope(self, e: float) -> float:
        """Return the derivative of the share by the coefficient, p eᵖ⁻¹; 1."""
        return reduce(mul, [e] * (self.power - 1), float(self.power))

    @cached_property
    def equation(self) -> Eq:
        """The law in e, `V_N_MINUS`, `V_N_PLUS`, `P_C`, `P_R`, `E_C` and `E_R`."""
        from painleve_sym.laws.restitution_equation import equation_of

        return equation_of(self.measure, self.share(self.parameter.symbol))

    @cached_property
    def separation_velocity(self) -> Expr:
        """v_n⁺ that solves `equation` for restitution along one ray; m/s.

        There P_r = v_n⁺/A_r and E_r = −v_n⁺²/(2 A_r), with A_r the symbol `A_R`.
        """
        from painleve_sym.laws.restitution_equation import separation_velocity

        return separation_velocity(self.equation)

    @cached_property
    def final_velocity(self) -> Expr:
        """v_n⁺ that solves `equation` where restitution ends along a later ray; m/s.

        That ray starts at v_n = `V_N_1` when restitution has spent `P_R1` and stored `E_R1` ≤ 0:
        P_r = P_r1 + (v_n⁺ − v_n1)/A_r and E_r = E_r1 − (v_n⁺² − v_n1²)/(2 A_r).
        """
        from painleve_sym.laws.restitution_equation import final_velocity

        return final_velocity(self.equation)


def newton() -> RestitutionLaw:
    """Return Newton's law, v_n⁺ = −e v_n⁻.

    It gives no rebound where the approach velocity is zero: it is inert in an impact without
    collision. The kinetic energy changes by (P_t (v_t⁺ + v_t⁻) − (1 − e) P_n |v_n⁻|)/2, summed over
    the contacts: it grows where friction, opposed to the slip at the end, pushed along the slip
    before by more than restitution loses. Without friction, and with e = 0, it never does.

    References
    ----------
    Kane & Levinson (1985) on the energy it adds.
    """
    e = Parameter("e_newton", 0.75, "1", "Newton's coefficient of restitution", 0.0, 1.0)
    return RestitutionLaw(
        name="newton",
        title="Newton's kinematic coefficient of restitution",
        source="Newton (1687); Brogliato (2016), ch. 4",
        parameter=e,
        measure=Measure.VELOCITY,
        power=1,
        note="kinematic; can add energy where the slip stops or reverses during the impact",
    )


def poisson() -> RestitutionLaw:
    """Return Poisson's law, P_r = e P_c, between the impulses of restitution and compression.

    The normal force can release more than it stored, E_r < −E_c; in the impact of a single contact
    friction has then taken at least the difference, so that the impact as a whole never gains
    energy. With several contacts that argument fails; what restitution is left then lapses where
    the energy would grow (`solve_simultaneous_impact`).

    References
    ----------
    Wang & Mason (1992); Ivanov (1992) and Batlle (1993) on its energy.
    """
    e = Parameter("e_poisson", 0.75, "1", "Poisson's coefficient of restitution", 0.0, 1.0)
    return RestitutionLaw(
        name="poisson",
        title="Poisson's kinetic coefficient of restitution",
        source="Poisson (1833); Routh (1905)",
        parameter=e,
        measure=Measure.IMPULSE,
        power=1,
        note="kinetic; the compression can release more energy than it stored where the slip stops",
    )


def energetic() -> RestitutionLaw:
    """Return Stronge's law of a single contact, E_r = −e² E_c: the paper's. It never adds energy.

    With several contacts each gives back e² of the energy that its own normal force took, and no
    energy is gained either: friction opposes the slip of each moment. How the contacts share the
    impulse is a rule of this package (`solve_simultaneous_impact`), not Stronge's.

    References
    ----------
    Stronge (1990); Impact model resolution on Painlevé's paradox, (9) and (21).
    """
    e = Parameter("e_energetic", 0.75, "1", "energetic coefficient of restitution", 0.0, 1.0)
    return RestitutionLaw(
        name="energetic",
        title="Stronge's energetic coefficient of restitution",
        source="Stronge (1990)",
        parameter=e,
        measure=Measure.WORK,
        power=2,
        note="energetic; releases the part e² of the stored energy whatever the slip does",
    )


RESTITUTIONS = {law.name: law for law in (newton(), poisson(), energetic())}
"""The restitution laws by name."""


def check_final_slip(
    impact_friction: ImpactFriction, law: str | RestitutionLaw, where: str
) -> None:
    """Raise InputError where friction is to oppose the final slip, and the law is not Newton's."""
    name = str(law) if isinstance(law, str) else law.name
    if impact_friction is ImpactFriction.FINAL_SLIP and name != Restitution.NEWTON:
        raise InputError(
            f"{where}: impact_friction: got 'final_slip' with the restitution law {name!r}, need "
            "'newton': the other laws compare compression and restitution along a path. Fix: take "
            "the restitution 'newton', or impact_friction='path'."
        )


def restitution_law(name: str) -> RestitutionLaw:
    """Return the named restitution law; InputError suggests the nearest name."""
    refuse_unknown("restitution law", name, RESTITUTIONS)
    return RESTITUTIONS[name]
