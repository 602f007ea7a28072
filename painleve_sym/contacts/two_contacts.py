"""The automaton of a mechanism with two rigid frictional contacts.

A mode is a pair: each contact flies, slips either way, or sticks. What follows an event is found
by the contact problem of both contacts together, whose solutions no list of conditions holds: the
mode ``contact`` hands the state over and the run goes on in the mode found.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import sympy as sp

from painleve_sym.contacts.contact_forces import ContactForces
from painleve_sym.contacts.contact_states import (
    CONTACT_WORK,
    CONTACTS,
    FLIGHT,
    FORCE_WORK,
    FRICTION_WORK,
    ContactRow,
    domain_transitions,
)
from painleve_sym.contacts.impact_rays import restitution_parameter
from painleve_sym.contacts.rigid import DECISION, SINGULAR_MARGIN
from painleve_sym.errors import EventKind, InputError, StopReason
from painleve_sym.hybrid.automaton import Choice, HybridAutomaton, Mode, Transition
from painleve_sym.laws.rigid import RigidLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import TIME, Parameter

CONTACT_MODES = (FLIGHT, *CONTACTS)
"""What one contact may do."""


def mode_name(modes: tuple[str, ...]) -> str:
    """Return the name of the mode in which the contacts, in their order, do `modes`."""
    return " + ".join(modes)


@dataclass(frozen=True)
class TwoContacts:
    """Builds the automaton of sixteen modes, and the decision between them.

    Gaps, their rates and slip velocities are states of their own where they are not coordinates.

    Parameters
    ----------
    mechanism : Mechanism
        With two contacts that can open.
    restitution : {"energetic", "poisson", "newton"}

    References
    ----------
    Várkonyi & Or, Nonlinear Dynamics 88 (2017); Champneys & Várkonyi (2016).
    """

    mechanism: Mechanism
    restitution: str = "energetic"

    def __post_init__(self) -> None:
        RigidLaw(self.restitution)
        m = self.mechanism
        if len(m.contacts) != 2:
            raise InputError(
                f"mechanism {m.name!r}: got {len(m.contacts)} contacts, need two here. "
                "Fix: choose contacts with Mechanism.only."
            )
        for contact in m.contacts:
            if contact.bilateral:
                raise InputError(
                    f"mechanism {m.name!r}: contact {contact.name!r} is bilateral, and motion with "
                    "two contacts needs both to open."
                )

    # ---- states ----

    @cached_property
    def rows(self) -> tuple[ContactRow, ...]:
        """States of each contact."""
        return tuple(
            ContactRow.of(
                c,
                sp.Symbol(f"gap_{c.name}", real=True),
                sp.Symbol(f"gap_{c.name}_dot", real=True),
                sp.Symbol(f"slip_velocity_{c.name}", real=True),
            )
            for c in self.mechanism.contacts
        )

    @cached_property
    def dissipations(self) -> tuple[sp.Symbol, ...]:
        """States that only account for energy."""
        moving = any(any(c.drive_speeds) for c in self.mechanism.all_coefficients)
        driven = self.mechanism.system.dissipated_power != 0 or moving
        return (FRICTION_WORK, CONTACT_WORK, *((FORCE_WORK,) if driven else ()))

    @cached_property
    def states(self) -> tuple[sp.Symbol, ...]:
        """What `Mechanism.motion` has, contact states where needed, then dissipated energies."""
        own = self.mechanism.motion
        extra = [s for row in self.rows for s in row.symbols if s not in own]
        return (*own, *extra, *self.dissipations)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the rigid contacts: the coefficient of restitution of both."""
        return (restitution_parameter(self.restitution),)

    # ---- the contact problem ----

    @cached_property
    def jacobian(self) -> sp.Matrix:
        """J with rows n1, t1, n2, t2, shape (4, n)."""
        return sp.Matrix.vstack(*[row for c in self.mechanism.contacts for row in (c.J_N, c.J_T)])

    @cached_property
    def directions(self) -> sp.Matrix:
        """M⁻¹ Jᵀ: accelerations per unit force, shape (n, 4)."""
        return self.mechanism.system.inverse_mass_matrix * self.jacobian.T

    @cached_property
    def mobility(self) -> sp.Matrix:
        """W = J M⁻¹ Jᵀ, shape (4, 4); 1/kg."""
        return self.jacobian * self.directions

    @cached_property
    def free(self) -> sp.Matrix:
        """Accelerations of the contacts without forces, shape (4, 1); m/s²."""
        parts = [p for c in self.mechanism.all_coefficients for p in (c.b_n, c.b_t)]
        return sp.Matrix(parts)

    def forces(self, modes: tuple[str, ...]) -> ContactForces:
        """Return the forces of a mode."""
        friction = [c.friction for c in self.mechanism.contacts]
        return ContactForces(self.jacobian, self.mobility, self.free, friction, modes)

    # ---- modes ----

    def _field(self, modes: tuple[str, ...], forces: sp.Matrix) -> dict[sp.Symbol, sp.Expr]:
        system = self.mechanism.system
        rates = dict(zip(system.q, system.q_dot, strict=True))
        accelerations = system.free_acceleration + self.directions * forces
        rates |= dict(zip(system.q_dot, accelerations, strict=True))
        contact = self.mobility * forces + self.free
        friction = drive = sp.Integer(0)
        for i, (row, mode) in enumerate(zip(self.rows, modes, strict=True)):
            closed, sticks = mode != FLIGHT, mode == "stick"
            rates[row.gap] = sp.Integer(0) if closed else row.gap_rate
            rates[row.gap_rate] = sp.Integer(0) if closed else contact[2 * i]
            rates[row.slip] = sp.Integer(0) if sticks else contact[2 * i + 1]
            if closed and not sticks:
                friction -= forces[2 * i + 1] * row.slip
            if closed:
                speeds = self.mechanism.all_coefficients[i].drive_speeds
                drive -= forces[2 * i + 1] * speeds[1] + forces[2 * i] * speeds[0]
        rates |= {FRICTION_WORK: friction, CONTACT_WORK: sp.Integer(0)}
        if FORCE_WORK in self.dissipations:
            rates[FORCE_WORK] = system.dissipated_power + drive
        if self.mechanism.depends_on_time:
            rates[TIME] = sp.Integer(1)
        return rates

    def outputs(self, forces: sp.Matrix) -> dict[str, sp.Expr]:
        """Return forces, gaps and velocities of each contact by name, and energies."""
        system = self.mechanism.system
        found: dict[str, sp.Expr] = {}
        for i, row in enumerate(self.rows):
            values = {
                "normal_force": forces[2 * i],
                "tangential_force": forces[2 * i + 1],
                "gap": row.gap,
                "gap_rate": row.gap_rate,
                "slip_velocity": row.slip,
            }
            found |= {f"{name}_{row.contact.name}": value for name, value in values.items()}
        return found | {
            "kinetic_energy": system.kinetic_energy,
            "potential_energy": system.potential_energy,
            "stored_energy": sp.Integer(0),
        }

    def _ends(self, modes: tuple[str, ...], found: ContactForces) -> list[Transition]:
        """Return what ends a mode, one contact after the other."""
        ends: list[Transition] = []

        def end(kind: EventKind, i: int, guard: sp.Expr, side: str = "") -> None:
            name, row, zero = self.mechanism.contacts[i].name, self.rows[i], sp.Integer(0)
            reset = {EventKind.TOUCHDOWN: {row.gap: zero}, EventKind.SLIP_STOP: {row.slip: zero}}
            ends.append(
                Transition(
                    f"{kind}{side}:{name}",
                    kind,
                    guard,
                    (Choice(DECISION),),
                    reset.get(kind, {}),
                    contact=name,
                )
            )

        for i, (row, mode) in enumerate(zip(self.rows, modes, strict=True)):
            if mode == FLIGHT:
                end(EventKind.TOUCHDOWN, i, row.gap)
                continue
            if mode != "stick":
                end(EventKind.SLIP_STOP, i, CONTACTS[mode] * row.slip)
            if found.redundant is not None:
                continue
            end(EventKind.LIFTOFF, i, found.forces[2 * i])
            if mode == "stick":
                for side, margin in zip(
                    ("_neg", "_pos"), found.stick_margins(i)[::-1], strict=True
                ):
                    end(EventKind.SLIP_START, i, margin, side)
        if found.closed and found.redundant is not None:
            margin = found.redundant_margin
            ends.append(Transition("slip_start", EventKind.SLIP_START, margin, (Choice(DECISION),)))
        sliding = any(modes[i] != "stick" for i in found.closed)
        if sliding:
            margin = sp.Abs(found.determinant, evaluate=False) - SINGULAR_MARGIN
            kind, reason = EventKind.SINGULAR, StopReason.SINGULAR
            ends.append(Transition("singular", kind, margin, stop=reason))
        return [*ends, *domain_transitions(self.mechanism)]

    def _mode(self, modes: tuple[str, ...]) -> Mode:
        found = self.forces(modes)
        field = self._field(modes, found.forces)
        return Mode(
            mode_name(modes), field, tuple(self._ends(modes, found)), self.outputs(found.forces)
        )

    def _decision(self) -> Mode:
        kinds = (EventKind.CONTACT, EventKind.IMPACT, EventKind.SETTLE)
        decide = Transition("decide", EventKind.CONTACT, None, decides=kinds)
        return Mode(DECISION, {}, (decide,), self.outputs(sp.zeros(4, 1)))

    @cached_property
    def automaton(self) -> HybridAutomaton:
        """The automaton, validated. A run starts in ``contact``, which asks for a decision."""
        system = self.mechanism.system
        pairs = list(product(CONTACT_MODES, repeat=2))
        parameters = (*system.parameters, *self.parameters)
        return HybridAutomaton(
            name=f"{self.mechanism.name}, two rigid contacts, {self.restitution} restitution",
            states=self.states,
            memory=(),
            parameters=tuple(p.symbol for p in parameters),
            definitions={},
            modes=(*(self._mode(pair) for pair in pairs), self._decision()),
            starts=(Choice(DECISION),),
            uncontrolled=self.dissipations,
        )
