"""The named contact laws, compliant and rigid."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Mapping

from painleve_sym.checks import text_of
from painleve_sym.choices import Friction, ImpactFriction, Policy, Reload, Restitution
from painleve_sym.errors import InputError, received, refuse_unknown, unknown_name
from painleve_sym.laws.compliant_laws import COMPLIANT_LAWS
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.laws.rigid_contact import GuideLaw, RigidLaw

LAWS = (*COMPLIANT_LAWS, RigidLaw.name)
"""Names that `law` knows."""

CHOICES: Mapping[str, tuple[str, ...]] = {
    "reload": tuple(Reload),
    "friction": tuple(Friction),
    "restitution": tuple(Restitution),
    "impact_friction": tuple(ImpactFriction),
    "policy": tuple(Policy),
}
"""Every named choice of a contact law and its values."""

CHOICE_NOTES: Mapping[str, str] = {
    Reload.VIRGIN: "thermodynamically inadmissible: each reload creates energy; for reproduction",
    ImpactFriction.PATH: "the slip of each moment along the path of the impulse, which friction "
    "opposes (Routh); several contacts that push together by Newton's law have the final slip",
    ImpactFriction.FINAL_SLIP: "the slip after the impact, which friction opposes, as in time "
    "stepping (Moreau); with Newton's law",
    Friction.STATIC: "mu in slip, and static_ratio mu (1.25 mu) before slip starts",
    Friction.STRIBECK: "static_ratio mu (1.25 mu) before slip starts, falling to mu with the slip "
    "velocity over stribeck_velocity (0.01 m/s)",
    Friction.SPRING: "mu in series with a tangential spring of tangential_stiffness (1e8 N/m)",
}
"""What to know before a choice is made, by its value."""


Law = ContactLaw | RigidLaw
OwnLaw = Law | GuideLaw
"""What one contact follows: a law that was given, or that of a guide."""
LawLike = Law | str
"""A law or its name."""
LawsLike = LawLike | Mapping[str, LawLike]
"""One law for all contacts, or the law of each by the contact's name."""


class LawsByContact(Mapping[str, Law]):
    """The law of each contact by the contact's name.

    Parameters
    ----------
    laws : mapping of str to (ContactLaw or RigidLaw)

    Attributes
    ----------
    name : str
        Such as ``A=hertz,B=rigid``.
    parameters : tuple of Parameter
        Of all laws; those of a compliant law have the contact's name behind theirs: ``E_A``.
    choices : dict of str to str
        See `choices_by_contact`.
    """

    def __init__(self, laws: Mapping[str, Law]) -> None:
        self._laws = dict(laws)
        self.name = law_text(self._laws)
        own = [chosen.of_contact(contact) for contact, chosen in self._laws.items()]
        every = [p for chosen in own for p in chosen.parameters]
        self.parameters = tuple({p.name: p for p in every}.values())
        self.choices = choices_by_contact(self._laws)

    def __repr__(self) -> str:
        return f"LawsByContact {self.name!r}"

    def __getitem__(self, contact: str) -> Law:
        return self._laws[contact]

    def __iter__(self) -> Iterator[str]:
        return iter(self._laws)

    def __len__(self) -> int:
        return len(self._laws)


def choices_by_contact(laws: Mapping[str, OwnLaw]) -> dict[str, str]:
    """Return the named choices of laws by contact; one that differs has the contact behind it."""
    choices: dict[str, str] = {}
    for name in dict.fromkeys(k for own in laws.values() for k in own.choices):
        values = {c: own.choices[name] for c, own in laws.items() if name in own.choices}
        if len(set(values.values())) == 1:
            choices[name] = next(iter(values.values()))
        else:
            choices |= {f"{name}_{contact}": value for contact, value in values.items()}
    return choices


def each_law(given: Law | Mapping[str, Law]) -> tuple[Law, ...]:
    """Return the law, or those of all contacts."""
    return tuple(given.values()) if isinstance(given, Mapping) else (given,)


def all_choices(given: Law | LawsByContact) -> dict[str, str]:
    """Return every named choice of a law and its value, also Coulomb's friction."""
    own = given.choices
    by_contact = any(name.startswith("friction") for name in own)
    return {**({} if by_contact else {"friction": str(Friction.COULOMB)}), **own}


def choice_values(given: Law | LawsByContact, choice: str) -> tuple[str, ...]:
    """Return the values that a law takes of a choice: a tangential spring needs one that yields."""
    yields = any(own.is_compliant for own in each_law(given))
    return tuple(v for v in CHOICES[choice] if yields or v != Friction.SPRING)


def law(name: str, **choices: str) -> Law | LawsByContact:
    """Return the named law, rigid or compliant, or the law of each contact.

    Parameters
    ----------
    name : str
        One of `LAWS`; or such a name for each contact, ``A=hertz,B=rigid``.
    **choices : str
        Named choices of the law, such as ``reload="virgin"`` (which creates energy); see `CHOICES`.
        Of several laws each takes those that it has.

    Raises
    ------
    InputError
        Unknown name, a choice that the law does not have, or a value it cannot have.

    Examples
    --------
    >>> from painleve_sym import law
    >>> law("bilinear-hertz", reload="virgin").choices
    {'reload': 'virgin'}
    >>> law("A=hertz,B=rigid").name
    'A=hertz,B=rigid'
    """
    by_contact = "=" in text_of(name, "contact law")
    return _laws_by_contact(name, choices) if by_contact else one_law(name, **choices)


@functools.cache
def parameter_names() -> frozenset[str]:
    """Return the names of the parameters of all laws, with each of their choices.

    Examples
    --------
    >>> from painleve_sym.laws.catalogue import parameter_names
    >>> {"E", "e_energetic", "stribeck_velocity"} <= parameter_names()
    True
    """
    names = set[str]()
    for name in LAWS:
        plain = law(name)
        # The friction of an impact has no parameter, and one of its values takes Newton's law.
        kinds = [k for k in all_choices(plain) if k != "impact_friction"]
        pairs = ((k, v) for k in kinds for v in choice_values(plain, k))
        own = [plain, *(law(name, **{k: v}) for k, v in pairs)]
        names |= {p.name for one in own for p in one.parameters}
    return frozenset(names)


def law_text(given: Law | Mapping[str, Law]) -> str:
    """Return the text of which `law` makes the law, or the laws by contact; choices apart."""
    if not isinstance(given, Mapping):
        return given.name
    return ",".join(f"{contact}={own.name}" for contact, own in given.items())


def as_law(given: LawsLike) -> Law | Mapping[str, Law]:
    """Return the law or the laws by contact; a text is what `law` knows."""
    if isinstance(given, str):
        return law(given)
    if isinstance(given, ContactLaw | RigidLaw | LawsByContact):
        return given
    if isinstance(given, Mapping):
        laws = {name: one_law(own) if isinstance(own, str) else own for name, own in given.items()}
        if laws and all(isinstance(own, ContactLaw | RigidLaw) for own in laws.values()):
            return laws
    raise InputError(
        f"contact law: got {received(given)}, need a law, its name, or one of these for each "
        "contact. Fix: the order is mechanism, law, state."
    )


def one_law(name: str, **choices: str) -> Law:
    """Return the named law of one contact, or of all alike; see `law`."""
    if name != RigidLaw.name:
        return compliant_law(name, LAWS, **choices)
    _check_choices(name, choices, [*RigidLaw().choices, "friction"])
    return RigidLaw(**choices)  # type: ignore[arg-type]


def _laws_by_contact(text: str, choices: Mapping[str, str]) -> LawsByContact:
    laws: dict[str, Law] = {}
    known: set[str] = set()
    for part in text.split(","):
        contact, equal, name = (piece.strip() for piece in part.partition("="))
        if not (contact and equal and name) or contact in laws:
            raise InputError(
                f"contact law {text!r}: got {part!r}, need a law for each contact, once, such as "
                "A=hertz,B=rigid."
            )
        own = all_choices(one_law(name))
        known |= set(own)
        laws[contact] = one_law(name, **{k: v for k, v in choices.items() if k in own})
    _check_choices(text, choices, sorted(known))
    return LawsByContact(laws)


def compliant_law(
    name: str, known_laws: Iterable[str] = tuple(COMPLIANT_LAWS), /, **choices: str
) -> ContactLaw:
    """Return the named law of a contact that yields; see `law`. A message names those known."""
    if name not in COMPLIANT_LAWS:
        raise InputError(unknown_name("contact law", name, known_laws))
    make, known = COMPLIANT_LAWS[name]
    _check_choices(name, choices, [*known, "friction"])
    friction = choices.pop("friction", Friction.COULOMB)
    return make(**choices).with_friction(friction)  # type: ignore[arg-type]


def _check_choices(
    name: str, given: Mapping[str, str], known: Mapping[str, str] | list[str]
) -> None:
    for key in given:
        refuse_unknown("choice", key, known, f"law {name!r}")
