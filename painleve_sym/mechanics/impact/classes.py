"""The five courses of a planar impact with friction, each as a chain of impulse rays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.mechanics.impact.impulse_rays import (
    V_N,
    V_N_PLUS,
    V_T,
    Condition,
    ImpulseRay,
    Phase,
    Writer,
    sticking_compression,
    sticking_restitution,
    tangential_phase,
)
from painleve_sym.mechanics.simplify import readable


@dataclass(frozen=True)
class ImpactCourse:
    """One class of impact as phases; the last one ends at `V_N_PLUS`, which a law gives.

    `slip` is s = sign(v_t) before the impact, or of the slip that begins where v_t = 0. Each phase
    is in terms of the velocities at its own start. `final_rate` is dv_n/dP_n on the last ray; 1/kg.
    """

    case: ImpactClass
    slip: int
    compression: tuple[Phase, ...]
    restitution: tuple[Phase, ...]
    final_rate: sp.Expr

    @property
    def phases(self) -> tuple[Phase, ...]:
        """All phases in order."""
        return (*self.compression, *self.restitution)

    @cached_property
    def from_start(self) -> tuple[Phase, ...]:
        """The phases in the velocities before the impact and in `V_N_PLUS`.

        `V_T` and `V_N` then mean v_t and v_n before the impact, and the mechanism's velocity
        symbols its velocities before the impact.
        """
        first, *others = self.phases
        chain = [first]
        for phase in others:
            last = chain[-1]
            start = {V_T: last.slip_velocity, V_N: last.normal_velocity, **last.velocity}
            chain.append(phase.started_from(start))
        return tuple(chain)

    @cached_property
    def friction_work(self) -> sp.Expr:
        """∫F_t v_t dt over the impact, from the start and `V_N_PLUS`; J. Never positive."""
        work, before = sp.Integer(0), V_T
        for phase in self.from_start:
            # v_t is linear in P_n: the integral takes its mean.
            work += phase.tangential_impulse * (before + phase.slip_velocity) / 2
            before = phase.slip_velocity
        return work


def impact_course(
    coefficients: ContactCoefficients, case: ImpactClass, slip: int = -1, write: Writer = readable
) -> ImpactCourse:
    """Return the phases of one class of impact, with the conditions under which it happens.

    dv_n/dP_n and dv_t/dP_n are A_s, C_s in slip, A′, 0 in sticking, A_{−s}, C_{−s} in reverse slip.
    After a stop the slip goes to sign(W_nt), so that a reversal needs s W_nt < −μ W_tt. `slip` is s
    = sign(v_t); where v_t = 0, sign(W_nt) for ``SLIDING``, either for ``C_STICKING``.

    References
    ----------
    Wang & Mason (1992); Keller (1986).
    """
    if case is ImpactClass.NO_IMPACT:
        raise InputError("course of an impact: got no_impact, which has no phases.")
    sliding = ImpulseRay.slipping(coefficients, slip, write)
    if case is ImpactClass.C_STICKING:
        first = tangential_phase(coefficients, slip, write)
        then = sticking_compression(coefficients, write)
        last = sticking_restitution(coefficients, write)
        rate = ImpulseRay.sticking(coefficients, write).normal_rate
        return ImpactCourse(case, slip, (first, then), (last,), rate)
    if case is ImpactClass.C_REVERSED:
        first = tangential_phase(coefficients, slip, write)
        ray = _reversed_ray(coefficients, slip, write)
        then = ray.until_normal_velocity("reverse slip compression", sp.Integer(0))
        # The reverse slip starts at 0 with the ray, but has some speed when restitution begins.
        moving = replace(ray, slip_start=V_T, conditions=())
        last = moving.until_normal_velocity("reverse slip restitution", V_N_PLUS, sp.Integer(0))
        return ImpactCourse(case, slip, (first, then), (last,), ray.normal_rate)
    first = _slip_compression(sliding, slip)
    if case is ImpactClass.SLIDING:
        last = _slip_to_the_end(sliding, slip)
        return ImpactCourse(case, slip, (first,), (last,), sliding.normal_rate)
    then = _slip_restitution(sliding, slip)
    if case is ImpactClass.R_STICKING:
        ray, name = ImpulseRay.sticking(coefficients, write), "sticking restitution"
    else:
        ray, name = _reversed_ray(coefficients, slip, write), "reverse slip restitution"
    last = ray.until_normal_velocity(name, V_N_PLUS, V_N)
    continues = Condition(
        "restitution continues", last.normal_impulse, "the restitution ends before the slip does"
    )
    return ImpactCourse(case, slip, (first,), (then, last.needing(continues)), ray.normal_rate)


def _reversed_ray(coefficients: ContactCoefficients, slip: int, write: Writer) -> ImpulseRay:
    """Return the ray of slip −s that starts at v_t = 0."""
    ray = ImpulseRay.slipping(coefficients, -slip, write)
    begins = Condition(
        "slip reverses",
        -slip * ray.slip_rate,
        "friction holds the contact point, or lets it slip on in the old direction",
        strict=True,
    )
    return replace(ray, slip_start=sp.Integer(0), conditions=(begins,))


def _slip_compression(ray: ImpulseRay, slip: int) -> Phase:
    phase = ray.until_normal_velocity("slip compression", sp.Integer(0))
    return phase.needing(
        Condition("approach", -V_N, "the bodies do not approach", strict=True),
        Condition("compression ends", ray.normal_rate, "friction presses the bodies on", True),
        Condition(
            "slip continues",
            slip * phase.slip_velocity,
            "the slip stops before the compression ends",
        ),
    )


def _slip_to_the_end(ray: ImpulseRay, slip: int) -> Phase:
    phase = ray.until_normal_velocity("slip restitution", V_N_PLUS, sp.Integer(0))
    end = Condition(
        "slip lasts", slip * phase.slip_velocity, "the slip stops before the restitution ends"
    )
    return replace(phase, conditions=(end,))


def _slip_restitution(ray: ImpulseRay, slip: int) -> Phase:
    phase = ray.until_slip_stops("slip restitution").started_from({V_N: sp.Integer(0)})
    stops = Condition("slip stops", -slip * ray.slip_rate, "friction does not stop the slip", True)
    return replace(phase, conditions=(stops,))
