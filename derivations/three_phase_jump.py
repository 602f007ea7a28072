"""By how much do the velocities jump in an impact of the rod?"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from derivations._page import Derivation, Quantity, Step
from derivations.contact_coefficients import COEFFICIENTS, A
from derivations.equations_of_motion import accelerations, mechanism, quantities, symbol
from derivations.sticking import A_STICK
from painleve_sym.laws.impact_cases import ImpactCase, three_phase_jump
from painleve_sym.laws.restitution_equation import E_C
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_N_PLUS, V_T, Phase
from painleve_sym.mechanics.simplify import readable

X_0 = sp.Symbol("x_A_dot_0", real=True)
Y_0, Y_1, Y_3 = sp.symbols("y_A_dot_0 y_A_dot_1 y_A_dot_3", real=True)
OMEGA_0, OMEGA_1, OMEGA_2, OMEGA_3 = sp.symbols("theta_dot_0:4", real=True)
P_1, P_2, P_3 = sp.symbols("P_n1 P_n2 P_n3", real=True)
E_1, E_2, E_R = sp.symbols("E_n1 E_n2 E_nr", real=True)
E_S = sp.Symbol("e_energetic", nonnegative=True)


def own_quantities() -> tuple[Quantity, ...]:
    """Return the symbols of this page with their meaning."""
    times = {0: "before the impact", 1: "when the slip stops", 2: "at the largest compression"}
    times[3] = "after the impact"
    rows = [Quantity(X_0, r"\dot{x}_A(t_0)", "m/s", f"slip velocity {times[0]}")]
    for index, y in ((0, Y_0), (1, Y_1), (3, Y_3)):
        latex = rf"\dot{{y}}_A(t_{index})"
        rows.append(Quantity(y, latex, "m/s", f"normal velocity {times[index]}"))
    for index, omega in enumerate((OMEGA_0, OMEGA_1, OMEGA_2, OMEGA_3)):
        latex = rf"\dot{{\theta}}(t_{index})"
        rows.append(Quantity(omega, latex, "rad/s", f"angular velocity {times[index]}"))
    phases = ("the tangential impact", "sticking compression", "sticking restitution")
    for index, (impulse, phase) in enumerate(zip((P_1, P_2, P_3), phases, strict=True), 1):
        rows.append(Quantity(impulse, f"P_{{n{index}}}", "N s", f"normal impulse of {phase}"))
    return (
        *rows,
        Quantity(E_1, "E_{n1}", "J", f"energy stored in {phases[0]}"),
        Quantity(E_2, "E_{n2}", "J", f"energy stored in {phases[1]}"),
        Quantity(E_R, "E_{nr}", "J", f"energy stored in {phases[2]}, negative"),
        Quantity(E_S, "e_s", "1", "energetic coefficient of restitution"),
        Quantity(A_STICK, "A'", "1/kg", "normal acceleration per normal force in sticking"),
    )


@dataclass(frozen=True)
class Rates:
    """Change of the velocities of A and of θ̇ per unit of normal impulse."""

    slip: sp.Expr
    normal: sp.Expr
    spin: sp.Expr

    @classmethod
    def at_ratio(cls, ratio: sp.Expr) -> Rates:
        """Integrate the equations of motion over a moment in which F_t = ratio · F_n.

        The finite terms (gravity, θ̇²) give nothing: only what multiplies the forces remains.
        """
        names = ("x_A_ddot", "y_A_ddot", "theta_ddot")
        motion = [accelerations()[symbol(name)] for name in names]
        return cls(*(readable(a.diff(F_N) + ratio * a.diff(F_T)) for a in motion))


def stored(rates: Rates, start: sp.Expr, end: sp.Expr) -> sp.Expr:
    """Return −∫ v_n dP_n between two normal velocities."""
    p, rate, first, last = sp.symbols("p rate first last", real=True)
    work = sp.integrate(first + rate * p, (p, 0, (last - first) / rate))
    return -sp.factor(work).subs({rate: rates.normal, first: start, last: end})


def slip_steps(rates: Rates, phase: Phase) -> list[Step]:
    """Return the steps of the tangential impact, (14) and (17)."""
    impulse = -X_0 / rates.slip
    normal = Y_0 + rates.normal * impulse
    named = {V_T: X_0, V_N: Y_0, symbol("theta_dot"): OMEGA_0}
    given = {X_0: -rates.slip * P_1}
    energy = stored(rates, Y_0, Y_1)
    from_y_1 = {X_0: (Y_0 - Y_1) * rates.slip / rates.normal}
    spin = phase.velocity[symbol("theta_dot")]
    return [
        Step(
            "**Tangential impact.** The configuration is frozen and finite forces have no impulse; "
            "$F_t = \\mu F_n$ until $\\dot x_A(t_1) = 0$. So the normal impulse is",
            sp.Eq(P_1, impulse),
            "eq-14-impulse",
            package=phase.normal_impulse.subs(named),
        ),
        Step(
            "which gives A the normal velocity",
            sp.Eq(Y_1, normal),
            "eq-14-normal",
            package=phase.normal_velocity.subs(named),
        ),
        Step(
            "and the rod the angular velocity",
            sp.Eq(OMEGA_1, OMEGA_0 + rates.spin * P_1),
            "eq-14-spin",
            package=spin.subs(named).subs(given),
        ),
        Step(
            "The contact stores $E_{n1} = -\\int F_n \\dot y_A\\,dt$. With $\\dot y_A$ linear in "
            "the impulse,",
            sp.Eq(E_1, energy),
            "eq-16",
            package=phase.stored_energy.subs(named).subs(from_y_1),
        ),
        Step(
            "In an impact without collision $\\dot y_A(t_0) = 0$, which (17) takes for granted, "
            "and $A < 0$ makes it positive:",
            sp.Eq(E_1, energy.subs(Y_0, 0)),
            "eq-17",
            function="E_n1_without_collision",
        ),
    ]


def compression_steps(rates: Rates, phase: Phase) -> list[Step]:
    """Return the steps of sticking compression, (18) and (20)."""
    named = {V_N: Y_1, symbol("theta_dot"): OMEGA_1}
    impulse = -Y_1 / rates.normal
    return [
        Step(
            "**Sticking compression.** Now $F_t = -(W_{nt}/W_{tt}) F_n$ keeps $\\dot x_A = 0$, "
            "until $\\dot y_A(t_2) = 0$:",
            sp.Eq(P_2, impulse),
            "eq-18-impulse",
            package=phase.normal_impulse.subs(named),
        ),
        Step(
            "The angular velocity becomes",
            sp.Eq(OMEGA_2, OMEGA_1 + readable(rates.spin * impulse)),
            "eq-18-spin",
            package=phase.velocity[symbol("theta_dot")].subs(named),
        ),
        Step(
            "and the contact stores",
            sp.Eq(E_2, stored(rates, Y_1, sp.Integer(0))),
            "eq-20",
            package=phase.stored_energy.subs(named),
        ),
    ]


def restitution_steps(rates: Rates, jump: ImpactCase) -> list[Step]:
    """Return the steps of sticking restitution, (21), and the jump in one formula."""
    given_back = stored(rates, sp.Integer(0), Y_3)
    per_energy = sp.simplify(Y_3**2 / given_back)
    # E_nr = −Y_3²/(2A′) solved for Y_3 ≥ 0, with the energy that Stronge's law releases.
    total = sp.Symbol("E_total", nonnegative=True)
    released = -(E_S**2) * (E_1 + E_2)
    rebound = sp.sqrt(per_energy * released)
    package = jump.rebound.subs(E_C, total)
    squares = sp.simplify((package**2 - (rebound**2).subs(E_2, total - E_1)).subs(total, E_1 + E_2))
    assert sp.simplify(squares) == 0, "package's separation velocity differs"
    named = {V_N_PLUS: Y_3, symbol("theta_dot"): OMEGA_2}
    spin = jump.course.restitution[0].velocity[symbol("theta_dot")]
    impulse = Y_3 / rates.normal
    return [
        Step(
            "**Sticking restitution.** Of the stored energy the contact releases the part $e_s^2$:",
            sp.Eq(E_R, released),
            "energy-released",
        ),
        Step(
            "In sticking $E_{nr} = -\\dot y_A^2(t_3)/(2A')$, so that A leaves with",
            sp.Eq(Y_3, sp.sqrt(per_energy * E_R)),
            "eq-21-normal",
        ),
        Step(
            "and the angular velocity is",
            sp.Eq(OMEGA_3, OMEGA_2 + readable(rates.spin * impulse)),
            "eq-21-spin",
            package=spin.subs(named),
        ),
        Step(
            "The normal impulse of this phase:",
            sp.Eq(P_3, impulse),
            package=jump.course.restitution[0].normal_impulse.subs(named),
        ),
        closed_form_step(),
    ]


def closed_form_step() -> Step:
    """Return ẏ_A(t3) of an impact without collision, in A and A′."""
    ratio = sp.expand(2 * A_STICK * (Y_1**2 / (2 * A_STICK) - Y_1**2 / (2 * A)) / Y_1**2)
    return Step(
        "In an impact without collision (17) and (20) add up to "
        "$\\dot y_A^2(t_1)\\,(1/A' - 1/A)/2$. So A rebounds with",
        sp.Eq(Y_3, -E_S * Y_1 * sp.sqrt(ratio)),
        function="y_A_dot_3_without_collision",
    )


def derive() -> Derivation:
    """Derive (14)–(21)."""
    jump = three_phase_jump(mechanism().coefficients)
    tangential, compression, _ = jump.course.phases
    slipping = Rates.at_ratio(symbol("mu"))
    sideways = accelerations()[symbol("x_A_ddot")]
    sticking = Rates.at_ratio(-sideways.diff(F_N) / sideways.diff(F_T))
    assert sticking.slip == 0
    return Derivation(
        "three_phase_jump",
        "The three-phase jump of the rod",
        "An impact of the sliding rod: the slip stops while the contact is compressed, the "
        "compression ends in sticking, and the contact releases a part of what it stored.",
        (*quantities(), *COEFFICIENTS, *own_quantities()),
        (
            *slip_steps(slipping, tangential),
            *compression_steps(sticking, compression),
            *restitution_steps(sticking, jump),
        ),
    )
