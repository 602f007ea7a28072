"""Restitution laws as the equation that ends restitution, and the three-phase jump they close."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.impulses import (
    V_N,
    V_N_PLUS,
    Phase,
    Writer,
    sticking_compression,
    sticking_restitution,
    tangential_phase,
)
from painleve_sym.mechanics.readable import readable
from painleve_sym.mechanics.system import Parameter

V_N_MINUS = sp.Symbol("v_n_minus", nonpositive=True)
"""Normal velocity before the impact; m/s."""
P_C = sp.Symbol("P_c", nonnegative=True)
"""Normal impulse of compression; N s."""
P_R = sp.Symbol("P_r", nonnegative=True)
"""Normal impulse of restitution; N s."""
E_C = sp.Symbol("E_c", nonnegative=True)
"""Energy stored by compression; J."""
E_R = sp.Symbol("E_r", nonpositive=True)
"""Energy stored by restitution, negative: it is released; J."""
A_R = sp.Symbol("A_r", positive=True)
"""dv_n/dP_n during restitution (A′ in sticking); 1/kg."""


@dataclass(frozen=True)
class RestitutionLaw:
    """A restitution law: one equation between compression and restitution.

    The three laws of this module agree when the force keeps one direction during the whole impact
    (no slip stops, or A_s = A′), and at restitution 0. Otherwise they differ; for an impact
    without collision v_n⁻ = 0, and Newton's law gives no rebound at all.

    Attributes
    ----------
    name, title, source : str
    parameter : Parameter
        Coefficient of restitution, in [0, 1].
    equation : sympy.Eq
        In `V_N_MINUS`, `V_N_PLUS`, `P_C`, `P_R`, `E_C`, `E_R` and the parameter.
    note : str
        What the law assumes and where it fails.
    """

    name: str
    title: str
    source: str
    parameter: Parameter
    equation: sp.Eq
    note: str

    @cached_property
    def separation_velocity(self) -> sp.Expr:
        """v_n⁺ that solves `equation` for restitution along one ray; m/s.

        There P_r = v_n⁺/A_r and E_r = −v_n⁺²/(2 A_r), with A_r the symbol `A_R`.
        """
        ray = {P_R: V_N_PLUS / A_R, E_R: -(V_N_PLUS**2) / (2 * A_R)}
        equation = self.equation.lhs - self.equation.rhs
        # Solved for a symbol of no sign, since SymPy drops roots whose sign it cannot decide.
        unknown = sp.Symbol("v", real=True)
        roots = sp.solve(equation.subs(ray).subs(V_N_PLUS, unknown), unknown)
        return max(roots, key=lambda root: not root.could_extract_minus_sign())


def newton() -> RestitutionLaw:
    """Return Newton's law, v_n⁺ = −e v_n⁻.

    With friction and a change of slip it can add energy, and it gives no rebound where the
    approach velocity is zero.
    """
    e = Parameter("e_newton", 0.75, "1", "Newton's coefficient of restitution", 0.0, 1.0)
    return RestitutionLaw(
        "newton",
        "Newton's kinematic restitution",
        "Newton, Principia (1687); Brogliato, Nonsmooth Mechanics (2016), ch. 4",
        e,
        sp.Eq(V_N_PLUS, -e.symbol * V_N_MINUS, evaluate=False),
        "kinematic; can add energy where the slip stops or reverses during the impact",
    )


def poisson() -> RestitutionLaw:
    """Return Poisson's law, P_r = e P_c, between the impulses of restitution and compression."""
    e = Parameter("e_poisson", 0.75, "1", "Poisson's coefficient of restitution", 0.0, 1.0)
    return RestitutionLaw(
        "poisson",
        "Poisson's kinetic restitution",
        "Poisson, Traité de mécanique (1833); Routh, Rigid Dynamics (1905), §179",
        e,
        sp.Eq(P_R, e.symbol * P_C, evaluate=False),
        "kinetic; the compression can release more energy than it stored where the slip stops",
    )


def energetic() -> RestitutionLaw:
    """Return Stronge's law, E_r = −e² E_c: the paper's. Never adds energy.

    References
    ----------
    Zhao, Liu & Chen, (9) and (21).
    """
    e = Parameter("e_energetic", 0.75, "1", "energetic coefficient of restitution", 0.0, 1.0)
    return RestitutionLaw(
        "energetic",
        "Stronge's energetic restitution",
        "Stronge, Proc. R. Soc. A 431 (1990) 169–181",
        e,
        sp.Eq(E_R, -(e.symbol**2) * E_C, evaluate=False),
        "energetic; releases the part e² of the stored energy whatever the slip does",
    )


RESTITUTIONS: dict[str, Callable[[], RestitutionLaw]] = {
    "newton": newton,
    "poisson": poisson,
    "energetic": energetic,
}


def restitution_law(name: str) -> RestitutionLaw:
    """Return the named restitution law; InputError suggests the nearest name."""
    if name not in RESTITUTIONS:
        raise InputError(unknown_name("restitution law", name, RESTITUTIONS))
    return RESTITUTIONS[name]()


@dataclass(frozen=True)
class ThreePhaseJump:
    """The paper's jump: slip until it stops, sticking compression, sticking restitution.

    It holds where every `Condition` of its phases does; otherwise the slip reverses or outlasts
    the compression, and the impact is made of other rays (see `ImpulseRay`).

    Attributes
    ----------
    law : RestitutionLaw
    slip : {-1, +1}
        s = sign(v_t) before the impact.
    tangential, compression, restitution : Phase
        Each in terms of the velocities at its own start; `restitution` also in `V_N_PLUS`.
    """

    law: RestitutionLaw
    slip: int
    tangential: Phase
    compression: Phase
    restitution: Phase

    @property
    def phases(self) -> tuple[Phase, Phase, Phase]:
        """The three phases in order."""
        return self.tangential, self.compression, self.restitution

    @cached_property
    def separation_velocity(self) -> sp.Expr:
        """v_n(t3) in `V_N_MINUS`, `P_C`, `E_C` and the configuration; m/s."""
        rate = V_N_PLUS / self.restitution.normal_impulse
        return self.law.separation_velocity.subs(A_R, rate)

    @cached_property
    def from_start(self) -> tuple[Phase, Phase, Phase]:
        """The three phases with everything in the velocities before the impact.

        `V_T` and `V_N` then mean v_t(t0) and v_n(t0), and the mechanism's velocity symbols q̇(t0).
        """
        first = self.tangential
        second = self.compression.started_from({**first.velocity, V_N: first.normal_velocity})
        closed = {
            V_N_MINUS: V_N,
            P_C: first.normal_impulse + second.normal_impulse,
            E_C: first.stored_energy + second.stored_energy,
        }
        rebound = self.separation_velocity.subs(closed)
        third = self.restitution.started_from({**second.velocity, V_N_PLUS: rebound})
        return first, second, third


def three_phase_jump(
    coefficients: ContactCoefficients,
    restitution: RestitutionLaw | None = None,
    slip: int = -1,
    write: Writer = readable,
) -> ThreePhaseJump:
    """Return the closed forms of the three-phase jump of any mechanism with one contact.

    Parameters
    ----------
    coefficients : ContactCoefficients
    restitution : RestitutionLaw, optional
        The paper's energetic one when left out.
    slip : {-1, +1}
        s = sign(v_t) before the impact.
    write : callable
        `readable`, or `raw` where nobody reads the forms.

    Returns
    -------
    ThreePhaseJump

    References
    ----------
    Zhao, Liu & Chen, section 4, (14)–(21).
    """
    return ThreePhaseJump(
        restitution or energetic(),
        slip,
        tangential_phase(coefficients, slip, write),
        sticking_compression(coefficients, write),
        sticking_restitution(coefficients, write),
    )
