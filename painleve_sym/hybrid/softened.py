"""The automaton of a mechanism with one softened frictional contact."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.errors import InputError, StopReason
from painleve_sym.hybrid.automaton import Choice, HybridAutomaton, Mode, Transition
from painleve_sym.laws.compliance import (
    DELTA,
    DELTA_DOT,
    SEPARATED,
    Branch,
    ContactLaw,
    Exit,
)
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.models import Mechanism
from painleve_sym.mechanics.readable import readable

GAP, GAP_RATE = sp.Symbol("gap", real=True), sp.Symbol("gap_dot", real=True)
SLIP = sp.Symbol("slip_velocity", real=True)
FRICTION_WORK = sp.Symbol("friction_dissipation", real=True)
CONTACT_WORK = sp.Symbol("contact_dissipation", real=True)
FORCE_WORK = sp.Symbol("force_dissipation", real=True)

FLIGHT, INDENTED = "flight", "flight_indented"
CONTACTS = {"slip_neg": -1, "slip_pos": 1, "stick": 0}


@dataclass(frozen=True)
class SoftenedContact:
    """Builds the automaton: flight, slip ±, stick, each with the branches of the law.

    The gap, its rate and the slip velocity are states of their own where they are not
    coordinates already: computed from q they cancel and lose precision.

    Parameters
    ----------
    mechanism : Mechanism
        With exactly one contact.
    law : ContactLaw
    """

    mechanism: Mechanism
    law: ContactLaw

    def __post_init__(self) -> None:
        taken = {p.name for p in self.mechanism.system.parameters}
        clash = sorted(taken & {p.name for p in self.law.parameters})
        if clash:
            raise InputError(
                f"mechanism {self.mechanism.name!r} with law {self.law.name!r}: both have a "
                f"parameter {clash[0]!r}. Fix: rename it in the mechanism."
            )

    @cached_property
    def gap(self) -> sp.Symbol:
        """State that holds g_N."""
        gap = self.mechanism.contact.gap
        return gap if gap in self.mechanism.system.q else GAP

    @cached_property
    def gap_rate(self) -> sp.Symbol:
        """State that holds ġ_N."""
        rate = self.mechanism.contact.gap_rate
        return rate if self.gap is not GAP else GAP_RATE

    @cached_property
    def slip(self) -> sp.Symbol:
        """State that holds v_t."""
        slip = self.mechanism.contact.slip_velocity
        return slip if slip in self.mechanism.system.q_dot else SLIP

    @cached_property
    def states(self) -> tuple[sp.Symbol, ...]:
        """Coordinates, velocities, contact states where needed, then dissipated energies."""
        system = self.mechanism.system
        extra = [s for s in (self.gap, self.gap_rate, self.slip) if s in (GAP, GAP_RATE, SLIP)]
        work = [FRICTION_WORK, CONTACT_WORK]
        if system.dissipated_power != 0:
            work.append(FORCE_WORK)
        return (*system.q, *system.q_dot, *extra, *work)

    def _of_state(self, expr: sp.Expr) -> sp.Expr:
        """Write a law's expression in the states of the automaton."""
        return sp.sympify(expr).xreplace({DELTA: -self.gap, DELTA_DOT: -self.gap_rate})

    def _tangential_force(self, contact: str, force: sp.Expr) -> sp.Expr:
        c = self.mechanism.coefficients
        if contact == "stick":
            return c.sticking_force.xreplace({F_N: force})
        return -CONTACTS[contact] * c.mu * force

    def _field(self, contact: str | None, branch: Branch | None) -> dict[sp.Symbol, sp.Expr]:
        system, c = self.mechanism.system, self.mechanism.coefficients
        force = self._of_state(branch.force) if branch else sp.Integer(0)
        friction = self._tangential_force(contact, force) if contact else sp.Integer(0)
        rates = dict(zip(system.q, system.q_dot, strict=True))
        accelerations = c.accelerations.xreplace({F_N: force, F_T: friction})
        rates |= dict(zip(system.q_dot, accelerations, strict=True))
        # The contact rows in the form A F_n + B: no cancellation, and exactly 0 in sticking.
        slip = CONTACTS[contact] if contact else 0
        if contact == "stick":
            normal, tangential = c.A_stick * force + c.B_stick, sp.Integer(0)
        else:
            normal = c.A(slip) * force + c.B if contact else c.B
            tangential = c.slip_rate_coefficient(slip) * force + c.b_t if contact else c.b_t
        rates |= {self.gap: self.gap_rate, self.gap_rate: normal, self.slip: tangential}
        rates[FRICTION_WORK] = -friction * self.slip if contact != "stick" else sp.Integer(0)
        rates[CONTACT_WORK] = self._of_state(branch.dissipated_power) if branch else sp.Integer(0)
        if FORCE_WORK in self.states:
            rates[FORCE_WORK] = system.dissipated_power
        return rates

    def _outputs(self, contact: str | None, branch: Branch | None) -> dict[str, sp.Expr]:
        force = self._of_state(branch.force) if branch else sp.Integer(0)
        friction = self._tangential_force(contact, force) if contact else sp.Integer(0)
        system = self.mechanism.system
        return {
            "normal_force": force,
            "tangential_force": friction,
            "compression": -self.gap,
            "gap": self.gap,
            "gap_rate": self.gap_rate,
            "slip_velocity": self.slip,
            "kinetic_energy": system.kinetic_energy,
            "potential_energy": system.potential_energy,
            "stored_energy": self._of_state(branch.stored_energy) if branch else sp.Integer(0),
        }

    def _leave_domain(self) -> list[Transition]:
        return [
            Transition(f"domain_{i}", "left_domain", bound.margin, stop=StopReason.LEFT_DOMAIN)
            for i, bound in enumerate(self.mechanism.domain)
        ]

    def _contact_choices(self, branch: str) -> tuple[Choice, ...]:
        return (
            Choice(f"slip_neg/{branch}", -self.slip),
            Choice(f"slip_pos/{branch}", self.slip),
            Choice(f"stick/{branch}"),
        )

    def _exit(self, number: int, contact: str, branch: Branch, e: Exit) -> Transition:
        if e.target == SEPARATED:
            target = INDENTED if self.law.recontacts else FLIGHT
            reset: dict[sp.Symbol, sp.Expr] = {}
            after = sp.Integer(0)
        else:
            target = f"{contact}/{e.target}"
            reset = {s: self._of_state(v) for s, v in e.memory.items()}
            after = self.law.branch(e.target).stored_energy.xreplace(dict(e.memory))
        # What the stored energy jumps by goes to the law: nothing where the force is continuous,
        # a loss where a stretched dashpot lets go, a gain under the virgin reload rule.
        released = self._of_state(branch.stored_energy - after)
        if released != 0:
            reset[CONTACT_WORK] = CONTACT_WORK + released
        label = f"{e.kind}_{number}"
        return Transition(label, e.kind, self._of_state(e.guard), (Choice(target),), reset)

    def _contact_mode(self, contact: str, branch: Branch) -> Mode:
        mu, name = self.mechanism.coefficients.mu, f"{contact}/{branch.name}"
        force = self._of_state(branch.force)
        needed = self._tangential_force("stick", force)
        changes = []
        if contact == "stick":
            for direction, margin in (("neg", mu * force - needed), ("pos", mu * force + needed)):
                enter = Choice(f"slip_{direction}/{branch.name}", departs=("slip_stop",))
                changes.append(Transition(f"slip_{direction}", "slip_start", margin, (enter,)))
        else:
            s = CONTACTS[contact]
            other = "slip_pos" if s < 0 else "slip_neg"
            reverse = Choice(f"{other}/{branch.name}", s * needed - mu * force, ("slip_stop",))
            stop = (reverse, Choice(f"stick/{branch.name}"))
            reset = {self.slip: sp.Integer(0)}
            changes.append(Transition("slip_stop", "slip_stop", s * self.slip, stop, reset))
        exits = [self._exit(i, contact, branch, e) for i, e in enumerate(branch.exits)]
        return Mode(
            name,
            self._field(contact, branch),
            # Friction first: at a start at rest it decides which normal motion follows.
            (*changes, *exits, *self._leave_domain()),
            self._outputs(contact, branch),
        )

    def _flight_modes(self) -> list[Mode]:
        loading = self._contact_choices(self.law.loading.name)
        land = Transition("touchdown", "touchdown", self.gap, loading)
        free, outputs = self._field(None, None), self._outputs(None, None)
        modes = [Mode(FLIGHT, free, (land, *self._leave_domain()), outputs)]
        if self.law.recontacts:
            clean = {s: sp.Integer(0) for s in self.law.memory}
            leave = Transition("liftoff", "liftoff", -self.gap, (Choice(FLIGHT),), clean)
            back = [
                Transition(
                    f"recontact_{i}",
                    e.kind,
                    self._of_state(e.guard),
                    self._contact_choices(e.target),
                    self._recontact_reset(e),
                )
                for i, e in enumerate(self.law.recontacts)
            ]
            modes.append(Mode(INDENTED, free, (leave, *back, *self._leave_domain()), outputs))
        return modes

    def _recontact_reset(self, e: Exit) -> dict[sp.Symbol, sp.Expr]:
        reset = {s: self._of_state(v) for s, v in e.memory.items()}
        gained = self._of_state(self.law.branch(e.target).stored_energy.xreplace(dict(e.memory)))
        reset[CONTACT_WORK] = CONTACT_WORK - gained
        return reset

    @cached_property
    def automaton(self) -> HybridAutomaton:
        """The automaton, validated."""
        mechanism, law = self.mechanism, self.law
        contact_modes = [self._contact_mode(c, b) for c in CONTACTS for b in law.branches]
        return HybridAutomaton(
            name=f"{mechanism.name} with {law.name}",
            states=self.states,
            memory=law.memory,
            parameters=tuple(p.symbol for p in (*mechanism.system.parameters, *law.parameters)),
            definitions={s: readable(v) for s, v in law.definitions.items()},
            modes=(*self._flight_modes(), *contact_modes),
            starts=self._start_choices(),
            uncontrolled=tuple(
                s for s in self.states if s in (FRICTION_WORK, CONTACT_WORK, FORCE_WORK)
            ),
        )

    def _start_choices(self) -> tuple[Choice, ...]:
        # Inside the surface: loading, whose guards then sort out unloading. On it: flight, whose
        # touchdown guard (gap, its rate, its acceleration) decides between flight and contact.
        inside = self._contact_choices(self.law.loading.name)
        within = [sp.Min(-self.gap, c.condition or -self.gap) for c in inside]
        pairs = zip(inside, within, strict=True)
        return (*(Choice(c.target, w) for c, w in pairs), Choice(FLIGHT))
