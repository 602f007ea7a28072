"""Impacts closed by a restitution law: the equation that ends restitution, and what follows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.laws.restitution import RestitutionLaw, energetic
from painleve_sym.laws.restitution_equation import A_R, E_C, E_R1, P_C, P_R1, V_N_1, V_N_MINUS
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.impact.classes import ImpactCourse, impact_course
from painleve_sym.mechanics.impact.impact_class import CLASSES, ImpactClass
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_N_PLUS, Condition, Phase, Writer
from painleve_sym.mechanics.simplify import readable


@dataclass(frozen=True)
class ImpactCase:
    """One class of impact closed by a restitution law: all in the velocities before it."""

    law: RestitutionLaw
    course: ImpactCourse

    @property
    def rebound(self) -> sp.Expr:
        """v_n after the impact in `V_N_MINUS`, `P_C`, `E_C` and the configuration; m/s.

        For restitution along one ray.
        """
        return self.law.separation_velocity.subs(A_R, self.course.final_rate)

    @cached_property
    def separation_velocity(self) -> sp.Expr:
        """v_n after the impact in the velocities before it; m/s."""
        chain = self.course.from_start
        ends = len(self.course.compression)
        compression, earlier = chain[:ends], chain[ends:-1]
        closed = {
            V_N_MINUS: V_N,
            P_C: sp.Add(*(p.normal_impulse for p in compression)),
            E_C: sp.Add(*(p.stored_energy for p in compression)),
            A_R: self.course.final_rate,
            V_N_1: earlier[-1].normal_velocity if earlier else sp.Integer(0),
            P_R1: sp.Add(*(p.normal_impulse for p in earlier)),
            E_R1: sp.Add(*(p.stored_energy for p in earlier)),
        }
        return self.law.final_velocity.xreplace(closed)

    @cached_property
    def phases(self) -> tuple[Phase, ...]:
        """The phases in the velocities before the impact (`V_T`, `V_N` and the mechanism's)."""
        rebound = {V_N_PLUS: self.separation_velocity}
        return tuple(phase.started_from(rebound) for phase in self.course.from_start)

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """Conditions on the velocities before the impact for it to be of this class.

        Away from ties exactly one class has all of them, if W is positive definite and v_n < 0.
        """
        return tuple(condition for phase in self.phases for condition in phase.conditions)

    @property
    def velocity(self) -> Mapping[sp.Symbol, sp.Expr]:
        """Velocities of the mechanism after the impact by symbol."""
        return self.phases[-1].velocity

    @property
    def slip_velocity(self) -> sp.Expr:
        """v_t after the impact; m/s."""
        return self.phases[-1].slip_velocity

    @cached_property
    def energy_change(self) -> sp.Expr:
        """∫F_n v_n dt + ∫F_t v_t dt; J. The change of kinetic energy over a surface at rest."""
        friction = self.course.friction_work.xreplace({V_N_PLUS: self.separation_velocity})
        return friction - sp.Add(*(phase.stored_energy for phase in self.phases))


def impact_cases(
    coefficients: ContactCoefficients,
    restitution: RestitutionLaw | None = None,
    slip: int = -1,
    write: Writer = readable,
) -> dict[ImpactClass, ImpactCase]:
    """Return the closed forms of every class of impact of any mechanism with one contact.

    Choose one by its class, or by its rays: ``ImpactClass.of_rays(("slip", "reverse"))``.
    `solve_impact` tells which class an impact with given numbers has. Where W has rank one, classes
    that stick are left out: those impacts jam. `slip` is s = sign(v_t) before the impact; the
    restitution is the energetic one when left out.

    References
    ----------
    Routh (1905); Keller (1986); Stronge (1990); Wang & Mason (1992).
    """
    law = restitution or energetic()
    return {
        case: ImpactCase(law, impact_course(coefficients, case, slip, write))
        for case in CLASSES
        if not (coefficients.rank_one and "stick" in case.rays)
    }


def three_phase_jump(
    coefficients: ContactCoefficients,
    restitution: RestitutionLaw | None = None,
    slip: int = -1,
    write: Writer = readable,
) -> ImpactCase:
    """Return the paper's jump: slip until it stops, sticking compression, sticking restitution.

    It is the class ``C_STICKING`` of `impact_cases`; `ImpactCourse.phases` has its three phases,
    each in the velocities at its own start. A W of rank one (A′ = 0) is rejected: there is no exit
    from sticking.

    References
    ----------
    Impact model resolution on Painlevé's paradox, section 4, (14)–(21).
    """
    course = impact_course(coefficients, ImpactClass.C_STICKING, slip, write)
    return ImpactCase(restitution or energetic(), course)
