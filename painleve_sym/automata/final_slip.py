"""An impact by the final slip: an instantaneous mode for what the contact does after it."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from painleve_sym.automata.automaton import Choice, Mode, all_positive
from painleve_sym.automata.contact_states import CONTACT_WORK, FORCE_WORK, FRICTION_WORK, OneContact
from painleve_sym.automata.impact_rays import (
    APPROACH,
    NORMAL_IMPULSE,
    RATE_ROUNDING,
    TANGENTIAL_IMPULSE,
)
from painleve_sym.automata.model import CONTACTS, SLIPS
from painleve_sym.errors import EventKind
from painleve_sym.laws.restitution import RestitutionLaw

_VARYING = "impact/varying_friction"


@dataclass(frozen=True)
class FinalSlip:
    """Builds the instantaneous modes ``impact/<contact>``, by Newton's law and the slip after it.

    v_n⁺ = −e v_n⁻, and friction opposes v_t⁺: with r = P_t/P_n in [−μ, μ] the v_t⁺ that belongs to
    P_n = −(1 + e) v_n⁻/(W_nn + r W_nt) grows with r, dv_t⁺/dr = P_n det W/(W_nn + r W_nt), from −∞
    where that denominator vanishes. So one impulse obeys Coulomb's law: r = −μ sign(v_t⁺), or
    v_t⁺ = 0. Without collision it is the stop of a slip with A_s ≤ 0.

    References
    ----------
    Moreau (1988).
    """

    states: OneContact
    law: RestitutionLaw

    def first(self, contact: str) -> str:
        """Return the name of the mode of an impact without collision, which stops the slip."""
        return "impact/stick" if self._has_one_coefficient else _VARYING

    @property
    def _has_one_coefficient(self) -> bool:
        """Whether rest and slip have one: else a slip and stick can both be final."""
        return self.states.interface.is_coulomb

    def starts(self) -> tuple[Choice, ...]:
        """Choices of what the contact does after an impact with v_n⁻ < 0."""
        c, st = self.states.mechanism.coefficients, self.states
        if not self._has_one_coefficient:
            return (Choice(_VARYING),)
        choices = []
        for s, name in SLIPS.items():
            A, C = st.A(s), st.slip_rate_coefficient(s)
            # s v_t⁺ times A_s.
            ahead = s * (st.slip * A + C * self._change)
            possible = all_positive(A - RATE_ROUNDING * c.W_nn, ahead)
            choices.append(Choice(f"impact/{name}", possible))
        return (*choices, Choice("impact/stick"))

    @property
    def _change(self) -> sp.Expr:
        """v_n⁺ − v_n⁻ = −(1 + e) v_n⁻."""
        return -(1 + self.law.parameter.symbol) * self.states.gap_rate

    def _impulses(self, contact: str) -> tuple[sp.Expr, sp.Expr]:
        """P_n and P_t."""
        c, st, v_t = self.states.mechanism.coefficients, self.states, self.states.slip
        if contact != "stick":
            s = CONTACTS[contact]
            normal = self._change / st.A(s)
            return normal, -s * st.interface.kinetic_along(s) * normal
        normal = (self._change - c.sticking_ratio * v_t) / c.A_stick
        stop = v_t / c.W_tt if c.slides else sp.Integer(0)
        return normal, c.sticking_ratio * normal - stop

    def _mode(self, contact: str, decision: str) -> Mode:
        st, c, name = self.states, self.states.mechanism.coefficients, f"impact/{contact}"
        if contact == "stick" and c.rank_one:
            # Sticking carries any impulse and the normal velocity never changes.
            return st.instant_mode(name, st.jam())
        P_n, P_t = self._impulses(contact)
        normal, tangential = c.force_directions
        given = zip(st.mechanism.system.q_dot, normal, tangential, strict=True)
        reset = {v: v + by_n * P_n + by_t * P_t for v, by_n, by_t in given}
        v_n = -self.law.parameter.symbol * st.gap_rate
        v_t = sp.Integer(0)
        if contact != "stick":
            v_t = st.slip + st.slip_rate_coefficient(CONTACTS[contact]) * P_n
        reset |= {
            st.gap_rate: v_n,
            st.slip: v_t,
            CONTACT_WORK: CONTACT_WORK - P_n * (st.gap_rate + v_n) / 2,
            FRICTION_WORK: FRICTION_WORK - P_t * (st.slip + v_t) / 2,
            NORMAL_IMPULSE: P_n,
            TANGENTIAL_IMPULSE: P_t,
            APPROACH: st.gap_rate,
        }
        if FORCE_WORK in st.dissipations:
            reset[FORCE_WORK] = FORCE_WORK - st.drive_work((P_n, P_t))
        return st.instant_mode(
            name, st.transition("end", EventKind.IMPACT_END, None, (Choice(decision),), reset)
        )

    def modes(self, decision: str) -> list[Mode]:
        """Return the three modes, each of which leads to the mode `decision`; or a stop."""
        if not self._has_one_coefficient:
            return [self.states.instant_mode(_VARYING, self.states.curved_path())]
        return [self._mode(contact, decision) for contact in CONTACTS]
