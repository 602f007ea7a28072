"""Contacts that do not yield: rigid ones, with restitution at impacts, and guides."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, ClassVar, Literal

from painleve_sym.choices import (
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

    Raises
    ------
    InputError
        Unknown names, a coefficient out of range, restitution laws that have no final slip.

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
        _ = self.parameters  # rejects a coefficient out of range

    @property
    def source(self) -> str:
        """Works on rigid contact and on the restitution law."""
        return f"Routh (1905); Génot & Brogliato (1999); {restitution_law(self.restitution).source}"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The coefficient of restitution of the chosen law."""
        own = restitution_law(self.restitution).parameter
        if self._contact:
            own = replace(own, name=f"{own.name}_{self._contact}")
        given = {} if self.e is None else {own.name: self.e}
        return with_defaults(f"law {self.name!r}", [own], given)

    def __repr__(self) -> str:
        """Return name, choices and parameters."""
        return f"RigidLaw {self.name!r} {settings_text(self.choices, self.parameters)}"

    @property
    def definition(self) -> str:
        """Everything its derivations start from, as one text."""
        return f"rigid {self.restitution} {self.impact_friction} {self.policy}{self._contact}"

    def with_parameters(self, **values: Value) -> RigidLaw:
        """Return the law with another default of its coefficient, by the parameter's name."""
        (own,) = with_defaults(f"law {self.name!r}", self.parameters, values)
        return with_fields(self, e=own.default)

    def of_contact(self, contact: str) -> RigidLaw:
        """Return the law with the contact's name behind that of its coefficient."""
        return with_fields(self, _contact=contact)

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
        """Restitution law, the slip that friction opposes in an impact, and policy."""
        return {
            "restitution": str(self.restitution),
            "impact_friction": str(self.impact_friction),
            "policy": str(self.policy),
        }


@dataclass(frozen=True)
class GuideLaw:
    """A bilateral contact: it cannot open, pushes to either side and has no restitution.

    Parameters
    ----------
    policy : Policy
        Followed where there are several solutions, and its sides differ.
    """

    policy: Policy = Policy.LIFTOFF

    name = "guide"
    is_compliant: ClassVar[Literal[False]] = False
    """Whether the contact yields."""
    kind: ClassVar[ContactKind] = ContactKind.GUIDE
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    definitions: ClassVar[Mapping[Symbol, Expr]] = {}
    """Abbreviations in the parameters: none."""

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
    return RigidLaw(restitution, policy, e, impact_friction)
