"""The contacts of a mechanism with the law that each follows, before any formula is derived."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from painleve_sym.automata.watch import Watch
from painleve_sym.choices import Friction, Policy
from painleve_sym.errors import InputError
from painleve_sym.laws.contact_kind import ContactKind
from painleve_sym.laws.rigid_contact import GuideLaw, RigidLaw
from painleve_sym.mechanics.declarations import Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.outline import SIDES, ContactOutline

if TYPE_CHECKING:
    from painleve_sym.laws.catalogue import Law, OwnLaw
    from painleve_sym.laws.contact_law import ContactLaw


FLIGHT = "flight"
INDENTED = "flight_indented"
"""Flight above the indentation that a plastic law has left: the gap is still negative."""
CONTACTS = {"slip_neg": -1, "slip_pos": 1, "stick": 0}
"""Contact modes and their slip direction."""
SLIPS = {s: name for name, s in CONTACTS.items() if s}
"""Contact modes of slip by their direction."""

MOTION = "motion"
"""The one mode of several contacts in which time passes."""
START = "start"
"""The instantaneous mode in which several contacts with a law take up their local modes."""
CONTACT = "contact"
"""The instantaneous mode in which closed contacts find what follows."""

FRICTION_LOSS, CONTACT_LOSS, FORCE_LOSS = (
    f"{cause}_dissipation" for cause in ("friction", "contact", "force")
)
"""Names of the states that only account for energy."""
LOSSES = (FRICTION_LOSS, CONTACT_LOSS, FORCE_LOSS)
ENERGIES = ("kinetic_energy", "potential_energy", "stored_energy")
"""Names of the outputs that, with the losses, add up to a constant."""
IMPULSES = ("normal_impulse", "tangential_impulse")
"""Names of the memory in which one rigid contact adds up the impulses of an impact."""

_SIDES = {side: name for name, side in SIDES.items()}


def guide_slip_mode(slip: int, side: int, unstable: bool = False) -> str:
    """Return the name of a mode of slip, such as ``slip_neg/push`` or ``slip_pos/pull_unstable``.

    Unstable: A_{sσ} < 0, a force from which the smallest yielding of the guide runs away.
    """
    return f"{SLIPS[slip]}/{_SIDES[side]}" + "_unstable" * unstable


def guide_stick_mode(side: int) -> str:
    """Return the name of a mode of sticking, ``stick/push`` or ``stick/pull``."""
    return f"stick/{_SIDES[side]}"


class StateRow(NamedTuple):
    """Names of the states of one contact: gap, its rate, and slip velocity."""

    gap: str
    gap_rate: str
    slip: str

    @classmethod
    def of(cls, contact: ContactOutline, end: str) -> StateRow:
        """Return the row, with coordinates and velocities in place of states of its own.

        `end` stands behind ``gap`` and ``slip_velocity`` where there are several contacts.
        """
        gap = contact.gap_coordinate or f"gap{end}"
        return cls(gap, f"{gap}_dot", contact.slip_rate or f"slip_velocity{end}")


def _shared(law: RigidLaw) -> tuple[tuple[str, str], ...]:
    """Return the choices that all rigid contacts have in common: each has its own friction."""
    return tuple((name, value) for name, value in law.choices.items() if name != "friction")


@dataclass(frozen=True)
class ContactModel:
    """The contacts of a mechanism with their laws.

    There is one law for all contacts, or one for each in the mechanism's order. Events of `watch`
    change nothing.

    Raises
    ------
    InputError
        Laws that do not fit the contacts, or each other.
    """

    mechanism: Mechanism
    laws: tuple[Law, ...]
    watch: tuple[Watch, ...] = ()

    def __post_init__(self) -> None:
        _ = self.own_laws  # rejects names that the mechanism has, too
        self._check_guides()
        self._check_springs()
        if self.several:
            self._check_several()
        elif self.mechanism.locked:
            raise InputError(
                f"mechanism {self.mechanism.name!r}: the mobility of its bilateral contact has "
                "rank one: what holds the gap holds the slip, too. Fix: leave the contact out, or "
                "let it open."
            )

    def _check_guides(self) -> None:
        """Raise InputError where a law yields, and all its contacts hold from both sides."""
        pairs = zip(self.own_laws, self._given, strict=True)
        followed = [given for own, given in pairs if own.kind is not ContactKind.GUIDE]
        for law in self.laws:
            if law.is_compliant and law not in followed:
                raise InputError(
                    f"mechanism {self.mechanism.name!r} with law {law.name!r}: its contact "
                    "holds from both sides, and a law only pushes. Fix: use the law rigid, or "
                    "describe the guide as two contacts."
                )

    def _check_springs(self) -> None:
        """Raise InputError where a tangential spring is in series with friction that varies."""
        for contact, law in zip(self.mechanism.outline.contacts, self.own_laws, strict=True):
            if law.kind is ContactKind.SPRING and not contact.has_one_coefficient:
                raise InputError(
                    f"mechanism {self.mechanism.name!r}, contact {contact.name!r}: friction: got "
                    "'spring' for a contact whose friction differs between rest and slip, and the "
                    "spring is in series with one coefficient. Fix: leave friction=spring out."
                )

    def _check_several(self) -> None:
        """Raise InputError where several contacts cannot follow their laws together."""
        name, rigid = self.mechanism.name, self._rigid_laws
        if len(rigid) > 1:
            first, second = (
                ", ".join(f"{k} {v!r}" for k, v in law.choices.items()) for law in rigid[:2]
            )
            raise InputError(
                f"{name}: rigid contacts: got laws with {first} and with {second}, "
                "and contacts that have an impact together follow one law. "
                "Fix: give all rigid contacts the same choices; each has its own coefficient."
            )
        spring = [w for w in self.compliant.values() if w.choices.get("friction") == "spring"]
        if rigid and any(law.depends_on_rate for law in spring):
            raise InputError(
                f"{name}: friction: got 'spring' with a dashpot beside a rigid contact. The "
                "impacts of that contact make the normal force jump, and the force of a tangential "
                "spring cannot jump with it. Fix: take a law without damping there, such as hertz."
            )

    @property
    def several(self) -> bool:
        """Whether there is more than one contact."""
        return len(self.mechanism.outline.contacts) > 1

    @property
    def friction_varies(self) -> bool:
        """Whether the friction of any contact in slip is more than a parameter."""
        curves = (own.friction.kind is Friction.STRIBECK for own in self.own_laws)
        return self.mechanism.outline.has_curves or any(curves)

    @property
    def can_open(self) -> bool:
        """Whether the only contact is rigid and not a guide."""
        return self.kinds == (ContactKind.RIGID,)

    @cached_property
    def kinds(self) -> tuple[ContactKind, ...]:
        """The kind of each contact."""
        return tuple(law.kind for law in self.own_laws)

    def of_kind(self, *kinds: ContactKind) -> tuple[int, ...]:
        """Return the indices of the contacts of any of these kinds."""
        return tuple(i for i, kind in enumerate(self.kinds) if kind in kinds)

    @cached_property
    def rigid(self) -> tuple[int, ...]:
        """Indices of the contacts that do not yield: rigid ones and guides."""
        return self.of_kind(ContactKind.RIGID, ContactKind.GUIDE)

    @property
    def ends(self) -> tuple[str, ...]:
        """Ends of the names of each contact's states and outputs: empty for an only contact."""
        return tuple(f"_{c.name}" * self.several for c in self.mechanism.outline.contacts)

    @cached_property
    def rows(self) -> tuple[StateRow, ...]:
        """Names of the states of each contact."""
        return tuple(map(StateRow.of, self.mechanism.outline.contacts, self.ends))

    @property
    def _given(self) -> tuple[Law, ...]:
        return self.laws if len(self.laws) > 1 else self.laws * len(self.mechanism.outline.contacts)

    @cached_property
    def own_laws(self) -> tuple[OwnLaw, ...]:
        """The law that each contact follows, in its own symbols."""
        outline = self.mechanism.outline
        taken = [*(p.name for p in outline.parameters), *outline.state_names]

        def own(contact: ContactOutline, law: Law) -> OwnLaw:
            by_contact = law if len(self.laws) == 1 else law.of_contact(contact.name)
            if contact.bilateral:
                followed = by_contact if isinstance(by_contact, RigidLaw) else self.rigid_law
                return GuideLaw(Policy(self.rigid_law.policy), followed.friction)
            return by_contact.apart_from(taken)

        return tuple(map(own, outline.contacts, self._given))

    @cached_property
    def compliant(self) -> dict[int, ContactLaw]:
        """The law of each contact that yields, by the contact's index."""
        return {i: law for i, law in enumerate(self.own_laws) if law.is_compliant}

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the laws, each once; guides have none."""
        every = [p for law in self.own_laws for p in law.parameters]
        return tuple({p.name: p for p in every}.values())

    @property
    def rigid_law(self) -> RigidLaw:
        """The choices of all rigid contacts; the default ones where only guides are rigid."""
        return next(iter(self._rigid_laws), RigidLaw())

    @property
    def _rigid_laws(self) -> list[RigidLaw]:
        every = (law for law in self.laws if isinstance(law, RigidLaw))
        return list({_shared(law): law for law in every}.values())

    @cached_property
    def definition(self) -> str:
        """Everything the automaton is derived from, as one text."""
        laws = [f"{law.name} {dict(law.choices)}" for law in self.laws]
        own = [getattr(law, "definition", "") for law in self.laws]
        watch = [f"watch {w.label}" for w in self.watch]
        return "\n".join((self.mechanism.definition, *laws, *own, *watch))

    @property
    def title(self) -> str:
        """The mechanism with its laws."""
        return f"{self.mechanism.name} with {', '.join(law.name for law in self.laws)}"
