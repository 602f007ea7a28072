"""The closed forms of a mechanism as named formulas, for printing in any format."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.laws.impact import RESTITUTIONS, three_phase_jump
from painleve_sym.mechanics.bilateral import SIDES, BilateralForms
from painleve_sym.mechanics.critical import critical_friction
from painleve_sym.mechanics.impulses import Phase, tangential_phase
from painleve_sym.mechanics.models import Mechanism
from painleve_sym.mechanics.readable import readable

LEFT, RIGHT = "slip to the left (v_t < 0)", "slip to the right (v_t > 0)"


@dataclass(frozen=True)
class Formula:
    """One closed form.

    Attributes
    ----------
    name : str
        Also the name of the Python function.
    value : sympy.Expr or sympy.Matrix
    unit, meaning, latex : str
        `latex` is the left side.
    """

    name: str
    value: sp.Basic | sp.MatrixBase
    unit: str
    meaning: str
    latex: str


@dataclass(frozen=True)
class Impulse:
    """A phase of the jump, with the names and meanings of what it gives.

    Attributes
    ----------
    name : str
    meaning : str
    values : mapping of str to sympy.Expr
        In the velocities at the start of the phase.
    conditions : tuple of str
        What must hold at its start, in words with the margin.
    """

    name: str
    meaning: str
    values: Mapping[str, sp.Expr]
    conditions: tuple[tuple[str, sp.Expr, bool], ...]


@dataclass(frozen=True)
class Section:
    """A group of formulas, or of phases of the jump."""

    title: str
    formulas: tuple[Formula, ...] = ()
    phases: tuple[Impulse, ...] = ()
    note: str = ""


def sections(mechanism: Mechanism) -> tuple[Section, ...]:
    """Return every closed form of a mechanism with one contact, in reading order."""
    return (
        energies(mechanism),
        _motion(mechanism),
        *contact_sections(mechanism),
        *(() if mechanism.contact.bilateral else _jump(mechanism)),
    )


def contact_sections(mechanism: Mechanism) -> tuple[Section, ...]:
    """Return what the only contact of a mechanism feels: mobility, slip, sticking, friction."""
    return (
        _contact(mechanism),
        _slip(mechanism),
        _stick(mechanism),
        *(_bilateral(mechanism) if mechanism.contact.bilateral else ()),
        Section("friction and the paradox", tuple(_critical(mechanism))),
    )


def energies(mechanism: Mechanism) -> Section:
    """Return T and V."""
    system = mechanism.system
    return Section(
        "energies",
        (
            Formula("T", system.kinetic_energy, "J", "kinetic energy", "T"),
            Formula("V", system.potential_energy, "J", "potential energy", "V"),
        ),
    )


def _motion(mechanism: Mechanism) -> Section:
    system, contact = mechanism.system, mechanism.contact
    names = ", ".join(c.name for c in system.coordinates)
    return Section(
        "equations of motion",
        (
            Formula("M", system.mass_matrix, "SI", "mass matrix", "M"),
            Formula("h", system.bias_force, "SI", "forces without those of the contact", "h"),
            Formula("J_N", contact.J_N, "SI", "Jacobian of the gap", "J_N"),
            Formula("J_T", contact.J_T, "SI", "Jacobian of the slip velocity", "J_T"),
        ),
        note=f"M q_ddot = h + J_N^T F_n + J_T^T F_t with q = ({names})",
    )


def _contact(mechanism: Mechanism) -> Section:
    c, contact = mechanism.coefficients, mechanism.contact
    normal, slip = "normal acceleration", "slip acceleration"
    return Section(
        "contact",
        (
            Formula("gap", contact.gap, "m", "gap, positive when apart", "g_N"),
            Formula("gap_rate", contact.gap_rate, "m/s", "normal velocity v_n", r"\dot{g}_N"),
            Formula("slip_velocity", contact.slip_velocity, "m/s", "slip velocity v_t", "v_t"),
            Formula("W_nn", c.W_nn, "1/kg", f"{normal} per normal force", "W_{nn}"),
            Formula("W_nt", c.W_nt, "1/kg", f"{normal} per tangential force", "W_{nt}"),
            Formula("W_tt", c.W_tt, "1/kg", f"{slip} per tangential force", "W_{tt}"),
            Formula("b_n", c.b_n, "m/s^2", f"{normal} without contact forces", "b_n"),
            Formula("b_t", c.b_t, "m/s^2", f"{slip} without contact forces", "b_t"),
        ),
        note="gap_ddot = W_nn F_n + W_nt F_t + b_n,  slip_dot = W_nt F_n + W_tt F_t + b_t",
    )


def _slip(mechanism: Mechanism) -> Section:
    c = mechanism.coefficients
    per_force = "normal acceleration per normal force"
    return Section(
        "slip",
        (
            Formula("A_neg", c.A(-1), "1/kg", f"A, {per_force}, {LEFT}", "A_{-}"),
            Formula("A_pos", c.A(1), "1/kg", f"A, {per_force}, {RIGHT}", "A_{+}"),
            Formula("B", c.B, "m/s^2", "B, normal acceleration without normal force", "B"),
        ),
        note="gap_ddot = A F_n + B",
    )


def _stick(mechanism: Mechanism) -> Section:
    c = mechanism.coefficients
    return Section(
        "sticking",
        (
            Formula(
                "F_t_stick",
                c.sticking_force,
                "N",
                "tangential force that keeps the slip velocity 0 (where |F_t| <= mu F_n)",
                r"F_t^{\mathrm{stick}}",
            ),
            Formula("A_stick", c.A_stick, "1/kg", "A' in sticking", "A'"),
            Formula("B_stick", c.B_stick, "m/s^2", "B' in sticking", "B'"),
        ),
        note="gap_ddot = A' F_n + B'",
    )


def _bilateral(mechanism: Mechanism) -> Iterator[Section]:
    """Yield what a contact held from both sides adds: two forces, their number, the impulse."""
    forms = BilateralForms(mechanism.coefficients)
    forces = []
    for direction, s, words in (("neg", -1, LEFT), ("pos", 1, RIGHT)):
        for side, sign in SIDES.items():
            forces.append(
                Formula(
                    f"F_n_{direction}_{side}",
                    readable(forms.slip_force(s, sign)),
                    "N",
                    f"{words}: a solution where this is {'>' if sign > 0 else '<'} 0",
                    f"F_n^{{{'-' if s < 0 else '+'}, \\mathrm{{{side}}}}}",
                )
            )
    yield Section(
        "slip held from both sides",
        tuple(forces),
        note="W_nn F_n - mu s W_nt |F_n| + B = 0 with s = sign(v_t): F_n of either sign",
    )
    yield Section(
        "number of solutions in slip",
        (
            Formula(
                "excess",
                forms.excess,
                "1/kg",
                "mu |W_nt| - W_nn; < 0: one solution",
                r"\mu |W_{nt}| - W_{nn}",
            ),
            Formula(
                "selector",
                forms.selector,
                "m/(kg s^2)",
                "W_nt B; with excess > 0: two solutions where s W_nt B > 0, none where < 0",
                "W_{nt} B",
            ),
        ),
    )
    yield Section(
        "tangential impact",
        (
            Formula("P_n", forms.normal_impulse, "N s", "normal impulse", "P_n"),
            Formula("P_t", forms.tangential_impulse, "N s", "tangential impulse", "P_t"),
            Formula(
                "loss",
                forms.friction_loss,
                "J",
                "kinetic energy lost on a fixed guide",
                r"\Delta T",
            ),
            Formula(
                "velocity_after", forms.velocity_after, "SI", "velocities after", r"\dot q^{+}"
            ),
        ),
        note="stops the slip v_t at once and keeps v_n = 0; |P_t| <= mu |P_n| where excess >= 0",
    )


def _critical(mechanism: Mechanism) -> Iterator[Formula]:
    """Yield the critical friction and its minimum over each coordinate that has one."""
    c = mechanism.coefficients
    try:
        critical = critical_friction(c)
    except InputError:
        return
    meaning = "critical friction: A < 0 is possible only above it"
    yield Formula("mu_critical", critical.value, "1", meaning, r"\mu_P")
    for coordinate in mechanism.system.coordinates:
        if coordinate.symbol not in critical.value.free_symbols:
            continue
        try:
            lowest = critical.minimum(coordinate.name)
        except InputError:
            continue
        where = " or ".join(f"{lowest.variable} = {place}" for place in lowest.at)
        yield Formula(
            f"mu_critical_min_{coordinate.name}",
            lowest.value,
            "1",
            f"smallest critical friction over {coordinate.name}, at {where}",
            rf"\min_{{{coordinate.latex or coordinate.name}}} \mu_P",
        )


def _jump(mechanism: Mechanism) -> Iterator[Section]:
    c = mechanism.coefficients
    left = three_phase_jump(c)
    right = tangential_phase(c, 1)
    opening = (
        "v_t and v_n are slip and normal velocity at the start of the phase, "
        "the velocities of the mechanism those at its start."
    )
    yield Section(
        "jump, phase 1: tangential impact until the slip stops",
        phases=(
            _impulse("tangential_neg", LEFT, left.tangential),
            _impulse("tangential_pos", RIGHT, right),
        ),
        note=opening,
    )
    yield Section(
        "jump, phase 2: sticking compression until the normal velocity is 0",
        phases=(_impulse("sticking_compression", "", left.compression),),
    )
    rebounds = []
    for make in RESTITUTIONS.values():
        rule = make()
        rebounds.append(
            Formula(
                f"rebound_{rule.name}",
                three_phase_jump(c, rule).separation_velocity,
                "m/s",
                f"v_n_plus by {rule.title}",
                r"v_n^{+}",
            )
        )
    yield Section(
        "jump, phase 3: sticking restitution up to the normal velocity v_n_plus",
        tuple(rebounds),
        (_impulse("sticking_restitution", "", left.restitution),),
        "E_c and P_c are energy and impulse of phases 1 and 2, v_n_minus is v_n before phase 1.",
    )


def _impulse(name: str, meaning: str, phase: Phase) -> Impulse:
    values = {
        "normal_impulse": phase.normal_impulse,
        "tangential_impulse": phase.tangential_impulse,
        "stored_energy": phase.stored_energy,
        "slip_velocity": phase.slip_velocity,
        "normal_velocity": phase.normal_velocity,
        **{str(symbol): value for symbol, value in phase.velocity.items()},
    }
    conditions = tuple((c.name, c.margin, c.strict) for c in phase.conditions)
    return Impulse(name, meaning, {k: sp.sympify(v) for k, v in values.items()}, conditions)


def impulse_units(mechanism: Mechanism) -> dict[str, str]:
    """Return the units of what a phase of the jump gives."""
    velocities = {f"{c.name}_dot": f"{c.unit}/s" for c in mechanism.system.coordinates}
    impulses = {"normal_impulse": "N s", "tangential_impulse": "N s", "stored_energy": "J"}
    return {**impulses, "slip_velocity": "m/s", "normal_velocity": "m/s", **velocities}
