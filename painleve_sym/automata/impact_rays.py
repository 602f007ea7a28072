"""An impact as a chain of instantaneous modes: the straight rays of Routh's construction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.automata.automaton import Choice, Mode, Transition, greatest, least, positive
from painleve_sym.automata.contact_states import CONTACT_WORK, FORCE_WORK, FRICTION_WORK, OneContact
from painleve_sym.automata.model import CONTACTS, IMPULSES, SLIPS
from painleve_sym.errors import EventKind
from painleve_sym.laws.restitution import Measure, RestitutionLaw

BUDGET = sp.Symbol("impact_budget", real=True)
"""Compression: work or impulse so far. Restitution: the remaining part, or the final v_n."""
APPROACH = sp.Symbol("approach_velocity", real=True)
"""v_n at the start of the impact; m/s."""
NORMAL_IMPULSE = sp.Symbol(IMPULSES[0], real=True)
"""P_n of the impact so far; N s."""
TANGENTIAL_IMPULSE = sp.Symbol(IMPULSES[1], real=True)
"""P_t of the impact so far; N s."""
MEMORY = (BUDGET, APPROACH, NORMAL_IMPULSE, TANGENTIAL_IMPULSE)

RATE_ROUNDING = sp.Rational(1, 10**12)
"""|A_s|/W_nn that is the rounding of an inverse mass matrix: A_s then counts as 0."""


@dataclass(frozen=True)
class Ray:
    """A ray: per unit of P_n the contact velocity changes by (a_t, a_n), P_t by `ratio`."""

    contact: str
    ratio: sp.Expr
    a_n: sp.Expr
    a_t: sp.Expr


@dataclass(frozen=True)
class ImpactRays:
    """Builds the instantaneous modes ``impact/<contact>/<compression or restitution>``.

    Each has guards that fire at once, in this order: slip stops, no end (jam), the phase ends.
    """

    states: OneContact
    law: RestitutionLaw

    @staticmethod
    def first(contact: str) -> str:
        """Name of the mode in which an impact begins."""
        return f"impact/{contact}/compression"

    @cached_property
    def rays(self) -> dict[str, Ray]:
        """The three rays."""
        c = self.states.coefficients
        rays = {}
        for contact, s in CONTACTS.items():
            if contact == "stick":
                ratio, a_n, a_t = c.sticking_ratio, c.A_stick, sp.Integer(0)
            else:
                st = self.states
                ratio, a_n, a_t = -s * self._kinetic(s), st.A(s), st.slip_rate_coefficient(s)
            rays[contact] = Ray(contact, ratio, a_n, a_t)
        return rays

    def _kinetic(self, slip: int) -> sp.Expr:
        """Return the coefficient of friction of a slip."""
        return self.states.interface.kinetic_along(slip)

    def _at_rest(self, phase: str) -> tuple[Choice, ...]:
        """Return the choices at v_t = 0: slip to the side friction cannot hold, or stick."""
        c, static = self.states.coefficients, self.states.interface.static_coefficient
        return (
            Choice(f"impact/slip_neg/{phase}", positive(-c.W_nt - static * c.W_tt)),
            Choice(f"impact/slip_pos/{phase}", positive(c.W_nt - static * c.W_tt)),
            Choice(f"impact/stick/{phase}"),
        )

    def starts(self) -> tuple[Choice, ...]:
        """Choices of the first ray from the slip velocity."""
        slips = (
            Choice(self.first(name), positive(s * self.states.slip)) for s, name in SLIPS.items()
        )
        return (*slips, *self._at_rest("compression"))

    # ---- one ray ----

    def _after(self, ray: Ray, impulse: sp.Expr, phase: str) -> dict[sp.Symbol, sp.Expr]:
        """Reset of states and memory after the normal impulse `impulse` along a ray."""
        st, c = self.states, self.states.coefficients
        normal, tangential = c.force_directions
        per_impulse = normal + tangential * ray.ratio
        reset = {
            v: v + d * impulse for v, d in zip(st.mechanism.system.q_dot, per_impulse, strict=True)
        }
        v_n, v_t = st.gap_rate, st.slip
        reset |= {v_n: v_n + ray.a_n * impulse, v_t: v_t + ray.a_t * impulse}
        work = v_n * impulse + ray.a_n * impulse**2 / 2
        friction = ray.ratio * (v_t * impulse + ray.a_t * impulse**2 / 2)
        reset |= {CONTACT_WORK: CONTACT_WORK - work, FRICTION_WORK: FRICTION_WORK - friction}
        if FORCE_WORK in st.dissipations:
            reset[FORCE_WORK] = FORCE_WORK - st.drive_work((impulse, ray.ratio * impulse))
        spent = {
            Measure.VELOCITY: sp.Integer(0),
            Measure.IMPULSE: -impulse if phase == "compression" else impulse,
            Measure.WORK: work,
        }
        reset |= {
            BUDGET: BUDGET - spent[self.law.measure],
            NORMAL_IMPULSE: NORMAL_IMPULSE + impulse,
            TANGENTIAL_IMPULSE: TANGENTIAL_IMPULSE + ray.ratio * impulse,
        }
        return reset

    def _end_impulse(self, ray: Ray, phase: str) -> sp.Expr:
        """P_n along the ray until v_n = 0, or until the law ends restitution."""
        v_n = self.states.gap_rate
        if phase == "compression":
            return -v_n / ray.a_n
        if self.law.measure is Measure.IMPULSE:
            return BUDGET
        if self.law.measure is Measure.VELOCITY:
            return greatest(sp.Integer(0), (BUDGET - v_n) / ray.a_n)
        # Rounding may leave a budget just below zero: then nothing is left to give back.
        speed = sp.sqrt(v_n**2 + 2 * ray.a_n * sp.Max(BUDGET, 0))
        return (speed - v_n) / ray.a_n

    def _rising(self, ray: Ray) -> sp.Expr:
        """Positive where v_n rises along the ray, by more than the rounding of its rate."""
        return ray.a_n - RATE_ROUNDING * self.states.coefficients.W_nn

    def _slip_stop(self, ray: Ray, phase: str) -> Transition:
        v_t, s = self.states.slip, CONTACTS[ray.contact]
        until_stop = -v_t / ray.a_t
        if phase == "compression":
            # s v_t/(−s a_t) < −v_n/a_n, cross-multiplied, or compression has no end along the ray.
            before = s * v_t * ray.a_n - self.states.gap_rate * s * ray.a_t
            sooner = least(before, self._rising(ray))
        else:
            sooner = until_stop - self._end_impulse(ray, phase)
        reset = self._after(ray, until_stop, phase) | {v_t: sp.Integer(0)}
        guard = greatest(s * ray.a_t, sooner)
        kind = EventKind.IMPACT_SLIP_STOP
        choices = self._at_rest(phase)
        return self.states.transition("slip_stop", kind, guard, choices, reset)

    def _mode(self, ray: Ray, phase: str, decision: str) -> Mode:
        name = f"impact/{ray.contact}/{phase}"
        if ray.a_n == 0:
            # Rank one: sticking carries any impulse and the normal velocity never changes.
            return self.states.instant_mode(name, self.states.jam())
        if self._curved(ray):
            return self.states.instant_mode(name, self.states.curved_path())
        transitions = []
        if ray.a_t != 0:  # slip, where any motion slides the contact
            transitions.append(self._slip_stop(ray, phase))
            if phase == "compression":
                transitions.append(self.states.jam(self._rising(ray)))
        reset = self._after(ray, self._end_impulse(ray, phase), phase)
        if phase == "compression":
            share = self.law.share(self.law.parameter.symbol)
            kinematic = self.law.measure is Measure.VELOCITY
            reset[self.states.gap_rate] = sp.Integer(0)
            reset[BUDGET] = -share * APPROACH if kinematic else share * reset[BUDGET]
            target, kind = f"impact/{ray.contact}/restitution", EventKind.IMPACT_MAX_COMPRESSION
        else:
            target, kind = decision, EventKind.IMPACT_END
        end = self.states.transition("end", kind, None, (Choice(target),), reset)
        return self.states.instant_mode(name, *transitions, end)

    def modes(self, decision: str) -> list[Mode]:
        """Return the modes; the last ray of an impact leads to the mode `decision`."""
        phases = ("compression", "restitution")
        return [
            self._mode(ray, phase, decision)
            for ray in self.rays.values()
            for phase in phases[: 1 if self._curved(ray) else 2]
        ]

    def _curved(self, ray: Ray) -> bool:
        """Return whether the ratio of the forces changes along the slip: the path is not a ray."""
        return bool(ray.ratio.has(self.states.slip))
