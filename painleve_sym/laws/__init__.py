"""Contact laws as symbolic expressions with parameters; nothing is integrated here.

The functions of this module return each law with its choices, and with other defaults of its
parameters where these are given.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from painleve_sym.choices import (
    Policy,
    PolicyLike,
    Reload,
    ReloadLike,
    Restitution,
    RestitutionLike,
)

if TYPE_CHECKING:
    from painleve_sym.laws.contact_law import ContactLaw
    from painleve_sym.laws.rigid_contact import RigidLaw

__all__ = [
    "bilinear_hertz",
    "hertz",
    "hunt_crossley",
    "linear",
    "rigid",
]


def bilinear_hertz(
    *, reload: ReloadLike = Reload.ELASTIC, bodies: int = 1, **parameters: float
) -> ContactLaw:
    """Return the paper's elasto-plastic law, (4)–(10).

    Parameters
    ----------
    reload : Reload or its text
        What follows when compression grows again before separation. ``virgin`` is
        thermodynamically inadmissible, since it creates energy; the paper's Fig. 4 needs it.
    bodies : {1, 2}
        1: both bodies of one material. 2: each has its own, and its curvature.
    **parameters : float
        ``E``, ``nu``, ``R``, ``n``, ``l_0``, ``e_energetic``; of two bodies ``E_1``, ``nu_1``,
        ``kappa_1``, …; SI units.

    Raises
    ------
    InputError
        Unknown names, values out of range.

    Examples
    --------
    >>> from painleve_sym import laws
    >>> laws.bilinear_hertz(E=20.9e14, reload="virgin").parameters[0].default
    2090000000000000.0
    """
    from painleve_sym.laws import contact_law

    return contact_law.bilinear_hertz(reload, bodies).with_parameters(**parameters)


def hertz(*, bodies: int = 1, **parameters: float) -> ContactLaw:
    """Return Hertz's elastic law F_n = K_e δⁿ, which dissipates nothing.

    Parameters
    ----------
    bodies, **parameters
        As for `bilinear_hertz`, without ``e_energetic``.

    Examples
    --------
    >>> from painleve_sym import laws
    >>> laws.hertz(E=1e9)
    ContactLaw 'hertz': E=1e+09, nu=0.3, R=0.00645, n=1.5, l_0=1
    """
    from painleve_sym.laws import contact_law

    return contact_law.hertz(bodies).with_parameters(**parameters)


def linear(**parameters: float) -> ContactLaw:
    """Return the spring and dashpot F_n = k δ + c δ̇, released where the force would pull.

    Parameters
    ----------
    **parameters : float
        ``k`` in N/m, ``c`` in N s/m.

    Examples
    --------
    >>> from painleve_sym import laws
    >>> laws.linear(k=1e6)
    ContactLaw 'linear': k=1e+06, c=0
    """
    from painleve_sym.laws import contact_law

    return contact_law.linear().with_parameters(**parameters)


def hunt_crossley(*, bodies: int = 1, **parameters: float) -> ContactLaw:
    """Return F_n = K_e δⁿ (1 + c δ̇), whose dashpot vanishes with the compression.

    Parameters
    ----------
    bodies, **parameters
        As for `hertz`, and the damping factor ``c`` in s/m.

    Examples
    --------
    >>> from painleve_sym import laws
    >>> laws.hunt_crossley(c=0.2)
    ContactLaw 'hunt-crossley': E=2.09e+11, nu=0.3, R=0.00645, n=1.5, l_0=1, c=0.2
    """
    from painleve_sym.laws import contact_law

    return contact_law.hunt_crossley(bodies).with_parameters(**parameters)


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
    from painleve_sym.laws.rigid_contact import RigidLaw

    return RigidLaw(restitution, policy, e)
