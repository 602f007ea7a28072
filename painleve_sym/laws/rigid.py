"""The rigid contact as a law: restitution at impacts, a policy where several solutions exist."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from painleve_sym.errors import InputError, unknown_name
from painleve_sym.laws.restitution import restitution_law
from painleve_sym.mechanics.declarations import Parameter

if TYPE_CHECKING:
    from sympy import Expr, Symbol

POLICIES = ("liftoff", "slip", "impact")
"""What to do in the indeterminate state, where several rigid solutions exist."""


@dataclass(frozen=True)
class RigidLaw:
    """A contact that does not yield.

    Parameters
    ----------
    restitution : {"energetic", "poisson", "newton"}
    policy : {"liftoff", "slip", "impact"}
        Followed in the indeterminate state; lift-off is what a contact without surface energy does.

    Raises
    ------
    InputError
        Unknown names.
    """

    restitution: str = "energetic"
    policy: str = "liftoff"

    name = "rigid"
    title = "rigid contact: contact problem between impacts, Routh's construction at them"
    source = "Routh (1905); Génot & Brogliato, Eur. J. Mech. A 18 (1999)"
    is_compliant: ClassVar[bool] = False
    """Whether the contact yields."""
    definitions: ClassVar[Mapping[Symbol, Expr]] = {}
    """Abbreviations in the parameters: none."""

    def __post_init__(self) -> None:
        if self.policy not in POLICIES:
            raise InputError("rigid contact: " + unknown_name("policy", self.policy, POLICIES))
        restitution_law(self.restitution)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The coefficient of restitution of the chosen law."""
        return (restitution_law(self.restitution).parameter,)

    def of_contact(self, contact: str) -> RigidLaw:
        """Return the law itself: all rigid contacts of a mechanism share its parameter."""
        return self

    @property
    def choices(self) -> Mapping[str, str]:
        """Restitution law and policy."""
        return {"restitution": self.restitution, "policy": self.policy}
