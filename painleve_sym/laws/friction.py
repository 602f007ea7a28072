"""Friction of a contact that yields: Coulomb's law, static friction above kinetic, and Stribeck's.

Each law scales the friction coefficient μ of the contact by a function of its slip velocity.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from painleve_sym.choices import Friction, FrictionLike, chosen
from painleve_sym.mechanics.declarations import Parameter

if TYPE_CHECKING:
    from sympy import Expr

_STATIC_RATIO = Parameter(
    "static_ratio", 1.25, "1", "static friction over mu, the friction of fast slip", 1.0
)
_STRIBECK_VELOCITY = Parameter(
    "stribeck_velocity",
    0.01,
    "m/s",
    "slip velocity at which friction above mu has fallen to a half",
    0.0,
    lower_closed=False,
)

_PARAMETERS: Mapping[Friction, tuple[Parameter, ...]] = {
    Friction.COULOMB: (),
    Friction.STATIC: (_STATIC_RATIO,),
    Friction.STRIBECK: (_STATIC_RATIO, _STRIBECK_VELOCITY),
}

_SOURCES: Mapping[Friction, str] = {
    Friction.COULOMB: "",
    Friction.STATIC: "Armstrong-Hélouvry, Dupont & Canudas de Wit (1994)",
    Friction.STRIBECK: "Stribeck (1902); Hess & Soom (1990)",
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
}
"""Statement on the rigid contact problem under a friction law, by the name of the law."""


@dataclass(frozen=True)
class FrictionLaw:
    """The friction of a contact: F_t = −s μ r(v_t) F_n in slip, |F_t| ≤ μ r_s F_n in stick.

    With Coulomb's law r = r_s = 1. With static friction above kinetic r = 1 and r_s = μ_s/μ. With
    Stribeck's curve r = 1 + (r_s − 1)/(1 + (v_t/v_s)²), so that r → r_s where slip begins.

    The exponential exp(−(v_t/v_s)²) in place of the fraction is common, too. Its Taylor series at
    |v_t| ≫ v_s has vanishing coefficients that do not announce the rise at v_t = 0, so that steps
    must be limited (docs/friction-laws.md); the fraction has poles at v_t = ±i v_s, which do so.

    Parameters
    ----------
    kind : Friction
    parameters : tuple of Parameter
        r_s ≥ 1 and, with Stribeck's curve, v_s; by default those of the kind with its names.

    References
    ----------
    Stribeck (1902); Hess & Soom (1990) for the fraction; Bo & Pavelescu (1982) for the exponential;
    Armstrong-Hélouvry, Dupont & Canudas de Wit (1994) for a survey.
    """

    kind: Friction = Friction.COULOMB
    parameters: tuple[Parameter, ...] = field(default_factory=tuple)

    @classmethod
    def named(cls, name: FrictionLike) -> FrictionLaw:
        """Return the law of that name.

        Parameters
        ----------
        name : {"coulomb", "static", "stribeck"}

        Raises
        ------
        InputError
            Another name.
        """
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

        return self.parameters[0].symbol if self.parameters else Integer(1)

    def kinetic_ratio(self, slip_velocity: Expr) -> Expr:
        """Return r at a slip velocity.

        Parameters
        ----------
        slip_velocity : sympy.Expr
            v_t of either sign; m/s.
        """
        from sympy import Integer

        if self.kind is not Friction.STRIBECK:
            return Integer(1)
        velocity = self.parameters[1].symbol
        return 1 + (self.static_ratio - 1) / (1 + (slip_velocity / velocity) ** 2)
