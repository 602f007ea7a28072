"""Contacts that do not yield: rigid ones, with restitution at impacts, and guides."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from painleve_sym.choices import (
    Friction,
    FrictionLike,
    ImpactFriction,
    ImpactFrictionLike,
    Policy,
    PolicyLike,
    Restitution,
    RestitutionLike,
    chosen,
)
from painleve_sym.errors import InputError
from painleve_sym.laws.contact_kind import ContactKind
from painleve_sym.laws.friction import FrictionLaw
from painleve_sym.laws.restitution import check_final_slip, restitution_law
from painleve_sym.mechanics.declarations import (
    NOT_DERIVED_FROM,
    Parameter,
    settings_text,
    with_defaults,
    with_fields,
)
from painleve_sym.units import Value

if TYPE_CHECKING:
    from sympy import Expr, Symbol

    from painleve_sym.laws.compliance import Branch


@dataclass(frozen=True, repr=False)
class RigidLaw:
    """A contact that does not yield.

    Parameters
    ----------
    restitution : Restitution or its text
    policy : Policy or its text
        Followed in the indeterminate state; lift-off is what a contact without surface energy does.
    e : float, optional
        Default of the coefficient of restitution, in [0, 1]; that of the restitution law where it
        is None.
    impact_friction : ImpactFriction or its text
        Which slip friction opposes in an impact: that of each moment along the path of the impulse
        (Routh), or that after the impact (Moreau), for which the restitution has to be Newton's.
    friction : FrictionLaw, Friction or its text
        How the friction of rest and of slip follow from the coefficient μ of the contact; without a
        tangential spring, which yields.

    Raises
    ------
    InputError
        Unknown names, a coefficient out of range, restitution laws that have no final slip,
        the friction of a spring.

    Notes
    -----
    One law of all contacts has one coefficient. A law for each contact has its own, with the
    contact's name behind it: ``e_newton_A``.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> ps.RigidLaw("poisson", e=0.5)
    RigidLaw 'rigid' (restitution=poisson, impact_friction=path, policy=liftoff): e_poisson=0.5
    """

    restitution: RestitutionLike = Restitution.ENERGETIC
    policy: PolicyLike = Policy.LIFTOFF
    e: float | None = field(default=None, metadata=NOT_DERIVED_FROM)
    impact_friction: ImpactFrictionLike = ImpactFriction.PATH
    friction: FrictionLaw = field(default_factory=FrictionLaw)
    _contact: str = field(default="", init=False)

    name = "rigid"
    title = "rigid contact: contact problem between impacts, Routh's or Moreau's at them"
    is_compliant: ClassVar[Literal[False]] = False
    """Whether the contact yields."""
    kind: ClassVar[ContactKind] = ContactKind.RIGID
    branches: ClassVar[tuple[Branch, ...]] = ()
    """Branches of a force: none."""
    definitions: ClassVar[Mapping[Symbol, Expr]] = {}
    """Abbreviations in the parameters: none."""

    def __post_init__(self) -> None:
        policy = chosen(Policy, self.policy, "policy", "rigid contact")
        object.__setattr__(self, "policy", policy)
        restitution = chosen(Restitution, self.restitution, "restitution law")
        object.__setattr__(self, "restitution", restitution)
        friction = chosen(ImpactFriction, self.impact_friction, "impact friction", "rigid contact")
        object.__setattr__(self, "impact_friction", friction)
        check_final_slip(friction, restitution, "rigid contact")
        given: Any = self.friction
        if not isinstance(given, FrictionLaw):
            object.__setattr__(self, "friction", FrictionLaw.named(given))
        if self.friction.kind is Friction.SPRING:
            raise InputError(
                "law 'rigid': friction: got 'spring', and a rigid contact does not yield along its "
                "tangent. Fix: take a compliant law, such as linear."
            )
        _ = self.parameters  # rejects a coefficient out of range

    @property
    def source(self) -> str:
        """Works on rigid contact and its impacts, and on the laws of restitution and friction."""
        by_path = self.impact_friction is ImpactFriction.PATH
        impact = "Routh (1905)" if by_path else "Moreau (1988)"
        own = restitution_law(self.restitution).source, self.friction.source
        return "; ".join((impact, "Génot & Brogliato (1999)", *filter(None, own)))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The coefficient of restitution of the chosen law, and those of its friction."""
        own = restitution_law(self.restitution).parameter
        if self._contact:
            own = replace(own, name=f"{own.name}_{self._contact}")
        given = {} if self.e is None else {own.name: self.e}
        return (*with_defaults(f"law {self.name!r}", [own], given), *self.friction.parameters)

    def __repr__(self) -> str:
        """Return name, choices and parameters."""
        return f"RigidLaw {self.name!r} {settings_text(self.choices, self.parameters)}"

    @property
    def definition(self) -> str:
        """Everything its derivations start from, as one text."""
        friction = "" if self.friction.is_coulomb else f" {self.friction.kind}"
        impact = f"{self.restitution} {self.impact_friction}"
        return f"rigid {impact} {self.policy}{friction}{self._contact}"

    def with_parameters(self, **values: Value) -> RigidLaw:
        """Return the law with other defaults of its parameters, by their names."""
        own, *rubbing = with_defaults(f"law {self.name!r}", self.parameters, values)
        friction = FrictionLaw(self.friction.kind, tuple(rubbing))
        return with_fields(self, e=own.default, friction=friction)

    def of_contact(self, contact: str) -> RigidLaw:
        """Return the law with the contact's name behind the names of its parameters."""
        rubbing = self.friction.renamed(lambda name: f"{name}_{contact}")
        return with_fields(self, _contact=contact, friction=rubbing)

    def apart_from(self, names: Collection[str]) -> RigidLaw:
        """Return the law itself; InputError where the mechanism has its name, too."""
        for own in self.parameters:
            if own.name in names:
                raise InputError(
                    f"law {self.name!r}: the mechanism has the name {own.name!r} too. "
                    "Fix: rename that of the mechanism."
                )
        return self

    @property
    def choices(self) -> Mapping[str, str]:
        """Restitution law, the slip that friction opposes in an impact, policy, and friction.

        Coulomb's friction is left out.
        """
        rubbing = {} if self.friction.is_coulomb else {"friction": str(self.friction.kind)}
        return {
            "restitution": str(self.restitution),
            "impact_friction": str(self.impact_friction),
            "policy": str(self.policy),
            **rubbing,
        }


@dataclass(frozen=True)
class GuideLaw:
    """A bilateral contact: it cannot open, pushes to either side and has no restitution.

    Parameters
    ----------
    policy : Policy
        Followed where there are several solutions, and its sides differ.
    friction : FrictionLaw
    """

    policy: Policy = Policy.LIFTOFF
    friction: FrictionLaw = field(default_factory=FrictionLaw)

    name = "guide"
    is_compliant: ClassVar[Literal[False]] = False
    """Whether the contact yields."""
    kind: ClassVar[ContactKind] = ContactKind.GUIDE
    definitions: ClassVar[Mapping[Symbol, Expr]] = {}
    """Abbreviations in the parameters: none."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those of its friction."""
        return self.friction.parameters

    @property
    def choices(self) -> Mapping[str, str]:
        """The policy."""
        return {"policy": str(self.policy)}


def rigid(
    *,
    restitution: RestitutionLike = Restitution.ENERGETIC,
    policy: PolicyLike = Policy.LIFTOFF,
    e: float | None = None,
    impact_friction: ImpactFrictionLike = ImpactFriction.PATH,
    friction: FrictionLike = Friction.COULOMB,
) -> RigidLaw:
    """Return the contact that does not yield.

    Parameters
    ----------
    restitution : Restitution or its text
        The law of restitution.
    policy : Policy or its text
        What it does where several motions are possible.
    e : float, optional
        Coefficient of that law of restitution, in [0, 1].
    impact_friction : ImpactFriction or its text
        Which slip friction opposes in an impact: ``path`` or ``final_slip``; see `RigidLaw`.
    friction : Friction or its text
        ``coulomb``, ``static`` or ``stribeck``: how μ of the contact changes between rest and slip.

    Raises
    ------
    InputError
        Unknown names, a coefficient out of range, restitution laws that have no final slip.

    Examples
    --------
    >>> from painleve_sym import laws
    >>> laws.rigid(restitution="newton", e=0.5, impact_friction="final_slip")
    RigidLaw 'rigid' (restitution=newton, impact_friction=final_slip, policy=liftoff): e_newton=0.5
    """
    return RigidLaw(restitution, policy, e, impact_friction, FrictionLaw.named(friction))
