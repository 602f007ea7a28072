"""Contact laws as symbolic expressions with parameters; nothing is integrated here.

The functions of this module return each law with its choices, and with other defaults of its
parameters where these are given.
"""

from __future__ import annotations

from painleve_sym.choices import Policy, PolicyLike, Restitution, RestitutionLike
from painleve_sym.laws.compliant_laws import *  # noqa: F403 - each law that its file offers
from painleve_sym.laws.compliant_laws import __all__ as _compliant
from painleve_sym.laws.rigid_contact import RigidLaw

__all__ = [*_compliant, "rigid"]


def rigid(
    *,
    restitution: RestitutionLike = Restitution.ENERGETIC,
    policy: PolicyLike = Policy.LIFTOFF,
    e: float | None = None,
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

    Raises
    ------
    InputError
        Unknown names, a coefficient out of range.

    Examples
    --------
    >>> from painleve_sym import laws
    >>> laws.rigid(restitution="poisson", e=0.5)
    RigidLaw 'rigid' (restitution=poisson, policy=liftoff): e_poisson=0.5
    """
    return RigidLaw(restitution, policy, e)
