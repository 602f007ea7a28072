"""The velocity jump of one contact as impulse integrals: rays, phases and their closed forms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.simplify import readable

V_T = sp.Symbol("v_t", real=True)
"""Slip velocity at the start of a phase; m/s."""
V_N = sp.Symbol("v_n", real=True)
"""Normal velocity at the start of a phase, negative on approach; m/s."""
V_N_PLUS = sp.Symbol("v_n_plus", nonnegative=True)
"""Normal velocity at the end of restitution; m/s."""

Writer = Callable[[sp.Expr], sp.Expr]
"""How closed forms are written: `readable`, or `raw`, which keeps them as they were composed."""


def raw(expr: sp.Expr) -> sp.Expr:
    """Return the expression unchanged: much quicker to build than `readable`, as exact."""
    return expr


@dataclass(frozen=True)
class Condition:
    """Condition for a phase to take place: `margin` ≥ 0, or > 0 where `strict`.

    The margin is written in the configuration, the parameters and the velocities at the start of
    the phase; `meaning` says what the impact does instead where the condition fails.
    """

    name: str
    margin: sp.Expr
    meaning: str
    strict: bool = False

    def holds(self, margin: float) -> bool:
        """Return whether the condition holds for this value of the margin."""
        return margin > 0 if self.strict else margin >= 0


@dataclass(frozen=True)
class Phase:
    """A part of an impact in which tangential and normal force keep one ratio.

    Every expression is in the configuration, the parameters, and the velocities at the *start* of
    the phase: the velocity symbols of the mechanism, `V_T` and `V_N` (and `V_N_PLUS` where the end
    is given by the final normal velocity).

    The force ratio F_t/F_n is −μ s in slip, −W_nt/W_tt in sticking. The impulses are P_n = ∫F_n dt
    and P_t = ∫F_t dt over the phase, N s; the velocities q̇, v_t and v_n are those at its end. The
    stored energy, −∫F_n v_n dt, is what the compression gains in the phase, J: negative in
    restitution. The conditions must hold for the phase to take place in this form.
    """

    name: str
    force_ratio: sp.Expr
    normal_impulse: sp.Expr
    tangential_impulse: sp.Expr
    velocity: Mapping[sp.Symbol, sp.Expr]
    slip_velocity: sp.Expr
    normal_velocity: sp.Expr
    stored_energy: sp.Expr
    conditions: tuple[Condition, ...] = ()

    def needing(self, *conditions: Condition) -> Phase:
        """Return the phase with further conditions."""
        return replace(self, conditions=(*self.conditions, *conditions))

    def started_from(self, start: Mapping[sp.Symbol, sp.Expr]) -> Phase:
        """Return the phase with its starting velocities replaced by other expressions."""

        def put(expr: sp.Expr) -> sp.Expr:
            return sp.sympify(expr).xreplace(dict(start))

        return replace(
            self,
            normal_impulse=put(self.normal_impulse),
            tangential_impulse=put(self.tangential_impulse),
            velocity={v: put(e) for v, e in self.velocity.items()},
            slip_velocity=put(self.slip_velocity),
            normal_velocity=put(self.normal_velocity),
            stored_energy=put(self.stored_energy),
            conditions=tuple(replace(c, margin=put(c.margin)) for c in self.conditions),
        )


@dataclass(frozen=True)
class ImpulseRay:
    """A direction of the contact impulse: P_t = ratio · P_n.

    The configuration is frozen and the impulses of other forces are neglected (the paper's
    approximate impulse theory), so M Δq̇ = J_Nᵀ P_n + J_Tᵀ P_t and all velocities are linear in
    P_n: dv_n/dP_n = W_nn + ratio W_nt, dv_t/dP_n = W_nt + ratio W_tt. An impact is a chain of such
    rays; each ends where v_t or v_n reaches a value, or where restitution ends.

    The force ratio is F_t/F_n, `slip_start` v_t at the start: `V_T` in slip, 0 in sticking. The
    rates are dv_n/dP_n and dv_t/dP_n, 1/kg, and by velocity symbol dq̇/dP_n. The conditions are
    those of being on this ray at all.
    """

    force_ratio: sp.Expr
    slip_start: sp.Expr
    normal_rate: sp.Expr
    slip_rate: sp.Expr
    velocity_rates: Mapping[sp.Symbol, sp.Expr]
    conditions: tuple[Condition, ...] = ()
    write: Writer = field(default=readable, compare=False)

    @classmethod
    def slipping(
        cls, coefficients: ContactCoefficients, slip: int = -1, write: Writer = readable
    ) -> ImpulseRay:
        """Return the ray of sliding friction, F_t = −μ s F_n with s = sign(v_t), −1 or +1."""
        if slip not in (-1, 1):
            raise InputError(f"slip direction: got {slip!r}, need -1 or +1. Fix: give sign(v_t).")
        moving = Condition(
            "slip direction", slip * V_T, "the contact point does not slip this way", strict=True
        )
        return cls._of(coefficients, -slip * coefficients.mu, V_T, (moving,), write)

    @classmethod
    def sticking(cls, coefficients: ContactCoefficients, write: Writer = readable) -> ImpulseRay:
        """Return the ray that keeps v_t = 0, F_t = −(W_nt/W_tt) F_n.

        Where no motion slides the contact (W_tt = 0), F_t = 0. The cone condition is
        |W_nt| ≤ μ W_tt; where it fails the contact point slips again.

        Raises
        ------
        InputError
            W has rank one (A′ = 0): sticking carries any impulse and changes no velocity.
        """
        if coefficients.rank_one:
            raise InputError(
                f"sticking of mechanism {coefficients.contact.system.name!r}: got A' = 0, need "
                "A' > 0: its mobility has rank one, so that sticking carries any impulse, and an "
                "impact that comes to it jams. Fix: use a compliant contact."
            )
        holds = Condition(
            "sticking",
            coefficients.mu * coefficients.W_tt - sp.Abs(coefficients.W_nt),
            "friction cannot hold the contact point, which slips on or back",
        )
        ratio = coefficients.sticking_ratio
        return cls._of(coefficients, ratio, sp.Integer(0), (holds,), write)

    @classmethod
    def _of(
        cls,
        coefficients: ContactCoefficients,
        ratio: sp.Expr,
        slip_start: sp.Expr,
        conditions: tuple[Condition, ...],
        write: Writer,
    ) -> ImpulseRay:
        W_nn, W_nt, W_tt = coefficients.W_nn, coefficients.W_nt, coefficients.W_tt
        normal, tangential = coefficients.force_directions
        rates = zip(coefficients.contact.system.q_dot, normal, tangential, strict=True)
        return cls(
            write(ratio),
            slip_start,
            write(W_nn + ratio * W_nt),
            write(W_nt + ratio * W_tt),
            {v: write(n + ratio * t) for v, n, t in rates},
            conditions,
            write,
        )

    def until_slip_stops(self, name: str) -> Phase:
        """Return the phase that ends with v_t = 0, with P_n = −v_t/(dv_t/dP_n)."""
        return self._phase(name, self.slip_rate, -self.slip_start, V_N)

    def until_normal_velocity(self, name: str, end: sp.Expr, start: sp.Expr = V_N) -> Phase:
        """Return the phase from v_n = `start` to v_n = `end`, with P_n = Δv_n/(dv_n/dP_n)."""
        return self._phase(name, self.normal_rate, sp.sympify(end) - start, sp.sympify(start))

    def _phase(self, name: str, rate: sp.Expr, change: sp.Expr, start: sp.Expr) -> Phase:
        """Move along the ray until the velocity that changes at `rate` has changed by `change`."""
        impulse = change / rate

        def after(value: sp.Expr, slope: sp.Expr) -> sp.Expr:
            return value + self.write(slope / rate) * change

        normal = after(start, self.normal_rate)
        return Phase(
            name=name,
            force_ratio=self.force_ratio,
            normal_impulse=impulse,
            tangential_impulse=self.force_ratio * impulse,
            velocity={v: after(v, r) for v, r in self.velocity_rates.items()},
            slip_velocity=after(self.slip_start, self.slip_rate),
            normal_velocity=normal,
            # v_n is linear in P_n: the integral is the mean. Unlike (17) it needs no A ≠ 0.
            stored_energy=-impulse * (start + normal) / 2,
            conditions=self.conditions,
        )


def tangential_phase(
    coefficients: ContactCoefficients, slip: int = -1, write: Writer = readable
) -> Phase:
    """Return the first phase: slip in direction s until v_t = 0, still in compression.

    P_n = −v_t/C_s and v_n(t1) = v_n − (A_s/C_s) v_t. With v_n = 0 at the start it is the impact
    without collision, and then needs A_s < 0.

    References
    ----------
    Impact model resolution on Painlevé's paradox, (14) and (17).
    """
    ray = ImpulseRay.slipping(coefficients, slip, write)
    phase = ray.until_slip_stops("tangential")
    return phase.needing(
        Condition("approach", -V_N, "the bodies separate: there is no impact"),
        Condition("slip stops", -slip * ray.slip_rate, "friction does not stop the slip", True),
        Condition(
            "compression continues",
            -phase.normal_velocity,
            "the compression ends before the slip does",
        ),
    )


def sticking_compression(coefficients: ContactCoefficients, write: Writer = readable) -> Phase:
    """Return the second phase: v_t = 0 until v_n = 0, with P_n = −v_n/A′.

    References
    ----------
    Impact model resolution on Painlevé's paradox, (18) and (20).
    """
    ray = ImpulseRay.sticking(coefficients, write)
    phase = ray.until_normal_velocity("sticking compression", sp.Integer(0))
    return phase.needing(Condition("approach", -V_N, "the bodies separate already"))


def sticking_restitution(coefficients: ContactCoefficients, write: Writer = readable) -> Phase:
    """Return the third phase: v_t = 0 from v_n = 0 to `V_N_PLUS`, which a restitution law gives.

    References
    ----------
    Impact model resolution on Painlevé's paradox, (21).
    """
    ray = ImpulseRay.sticking(coefficients, write)
    return ray.until_normal_velocity("sticking restitution", V_N_PLUS, sp.Integer(0))
