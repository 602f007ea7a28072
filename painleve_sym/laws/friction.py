"""Friction by the law of a contact: Coulomb's, static friction above kinetic, and Stribeck's.

These scale the friction coefficient μ of the contact, which may be a curve itself
(`mechanics.friction`), by a function of its slip velocity. A fourth law has a tangential spring in
series with Coulomb's friction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from painleve_sym.choices import Friction, FrictionLike, chosen
from painleve_sym.mechanics.declarations import Parameter, positive

if TYPE_CHECKING:
    from sympy import Expr

    from painleve_sym.mechanics.outline import ContactOutline

_STATIC_RATIO = Parameter(
    "static_ratio", 1.25, "1", "static friction over mu, the friction of fast slip", 1.0
)
_STRIBECK_VELOCITY = positive(
    name="stribeck_velocity",
    default=0.01,
    unit="m/s",
    meaning="slip velocity at which friction above mu has fallen to a half",
)
_TANGENTIAL_STIFFNESS = positive(
    "tangential_stiffness", 1e8, "N/m", "stiffness k_t of the spring in series with friction"
)

_PARAMETERS: Mapping[Friction, tuple[Parameter, ...]] = {
    Friction.COULOMB: (),
    Friction.STATIC: (_STATIC_RATIO,),
    Friction.STRIBECK: (_STATIC_RATIO, _STRIBECK_VELOCITY),
    Friction.SPRING: (_TANGENTIAL_STIFFNESS,),
}

_CONSTANT = (Friction.COULOMB, Friction.SPRING)
"""Laws with one coefficient for stick and slip."""

_SOURCES: Mapping[Friction, str] = {
    Friction.COULOMB: "",
    Friction.STATIC: "Armstrong-Hélouvry, Dupont & Canudas de Wit (1994)",
    Friction.STRIBECK: "Stribeck (1902); Hess & Soom (1990)",
    Friction.SPRING: "Mindlin (1949); Iwan (1966)",
}

_AT_REST = (
    "at v_t = 0 stick and slip both solve the contact problem where the tangential force that "
    "stick needs lies between mu F_n and mu_s F_n, so that the statements on one solution for "
    "every load fail there."
)
FRICTION_NOTICES: Mapping[str, str] = {
    Friction.STATIC: (
        "Classified with mu, the friction of slip. With a static friction mu_s above it, "
        f"{_AT_REST}"
    ),
    Friction.STRIBECK: (
        "Classified with mu, the friction of fast slip. With Stribeck's curve the case of a "
        "sliding contact is that of the coefficient at its slip velocity, the impact laws of a "
        f"constant mu do not hold, and {_AT_REST}"
    ),
    Friction.SPRING: (
        "Classified without the tangential spring, as the limit of infinite stiffness. With the "
        "spring a sliding contact keeps its case, and one that sticks has a force of its own, "
        "F_t = -k_t xi, so that its contact problem always has exactly one solution."
    ),
}
"""Statement on the rigid contact problem under a friction law, by the name of the law."""


def friction_notice(contact: ContactOutline) -> str:
    """Return the statement on the rigid contact problem of a contact; empty for one coefficient."""
    if contact.has_one_coefficient:
        return ""
    own = f"Contact {contact.name} was classified with its friction at the slip velocity of the "
    own += f"state, mu = {contact.friction_curve or contact.friction}"
    if not contact.static_friction:
        return f"{own}."
    return f"{own}. With the static friction mu_s = {contact.static_friction} {_AT_REST}"


@dataclass(frozen=True)
class FrictionLaw:
    """The friction of a contact: F_t = −s μ r(v_t) F_n in slip, |F_t| ≤ μ r_s F_n in stick.

    With Coulomb's law r = r_s = 1. With static friction above kinetic r = 1 and r_s = μ_s/μ. With
    Stribeck's curve r = 1 + (r_s − 1)/(1 + (v_t/v_s)²), so that r → r_s where slip begins.

    With a tangential spring r = r_s = 1, and F_t = −k_t ξ with the deflection ξ of the spring. In
    stick ξ̇ = v_t, and in slip ξ = s μ F_n/k_t, so that friction slips at v_t − ξ̇.

    The exponential exp(−(v_t/v_s)²) in place of the fraction is common, too. Its Taylor series at
    |v_t| ≫ v_s has vanishing coefficients that do not announce the rise at v_t = 0, so that steps
    must be limited (docs/friction-laws.md); the fraction has poles at v_t = ±i v_s, which do so.

    Parameters
    ----------
    kind : Friction
    parameters : tuple of Parameter
        r_s ≥ 1 and, with Stribeck's curve, v_s; k_t of a spring; by default those of the kind with
        its names.

    References
    ----------
    Stribeck (1902); Hess & Soom (1990) for the fraction; Bo & Pavelescu (1982) for the exponential;
    Armstrong-Hélouvry, Dupont & Canudas de Wit (1994) for a survey. Mindlin (1949) for the
    tangential stiffness of a contact, Iwan (1966) for a spring in series with Coulomb friction.
    """

    kind: Friction = Friction.COULOMB
    parameters: tuple[Parameter, ...] = field(default_factory=tuple)

    @classmethod
    def named(cls, name: FrictionLike) -> FrictionLaw:
        """Return the law of that name: ``coulomb``, ``static``, ``stribeck`` or ``spring``."""
        kind = chosen(Friction, name, "friction law")
        return cls(kind, _PARAMETERS[kind])

    @property
    def is_coulomb(self) -> bool:
        """Whether friction is μ F_n in slip and in stick."""
        return self.kind is Friction.COULOMB

    @property
    def source(self) -> str:
        """Works that describe the law; empty for Coulomb's."""
        return _SOURCES[self.kind]

    def renamed(self, new_name: Callable[[str], str]) -> FrictionLaw:
        """Return the law with other names of its parameters."""
        return replace(
            self, parameters=tuple(replace(p, name=new_name(p.name)) for p in self.parameters)
        )

    @property
    def static_ratio(self) -> Expr:
        """r_s = μ_s/μ."""
        from sympy import Integer

        return Integer(1) if self.kind in _CONSTANT else self.parameters[0].symbol

    @property
    def tangential_stiffness(self) -> Expr | None:
        """k_t of the spring in series with friction; N/m; None where there is no spring."""
        return self.parameters[0].symbol if self.kind is Friction.SPRING else None

    def kinetic_ratio(self, slip_velocity: Expr) -> Expr:
        """Return r at a slip velocity v_t of either sign; m/s."""
        from sympy import Integer

        if self.kind is not Friction.STRIBECK:
            return Integer(1)
        velocity = self.parameters[1].symbol
        return 1 + (self.static_ratio - 1) / (1 + (slip_velocity / velocity) ** 2)
