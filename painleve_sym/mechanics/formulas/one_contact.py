"""Closed forms of one contact in the plane: mobility, slip, sticking, friction."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.mechanics.declarations import Coordinate
from painleve_sym.mechanics.formulas.formula import Formula, Section, plain
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.outline import SIDES
from painleve_sym.mechanics.paradox.bilateral import BilateralForms
from painleve_sym.mechanics.paradox.critical_friction import (
    CriticalFriction,
    CriticalMinimum,
    critical_friction,
    least_over_directions,
)
from painleve_sym.mechanics.simplify import readable

_ANY_FORCE = (
    "A' = 0: W has rank one, gap and slip velocity are tied, and sticking carries any normal "
    "force with F_t = F_t_stick(F_n)."
)
_NOTHING_TO_STOP = "W_tt = 0: no motion slides the contact, there is no slip to be stopped."
_NO_FORM = "has no closed form."

LEFT, RIGHT = "slip to the left (v_t < 0)", "slip to the right (v_t > 0)"


def contact_sections(mechanism: Mechanism) -> tuple[Section, ...]:
    """Return the sections of the only contact: mobility, slip, sticking, friction."""
    return (
        _contact(mechanism),
        _slip(mechanism),
        _stick(mechanism),
        *(_bilateral(mechanism) if mechanism.contact.bilateral else ()),
        _critical(mechanism),
    )


def _contact(mechanism: Mechanism) -> Section:
    c, contact = mechanism.coefficients, mechanism.contact
    values = {
        "gap": contact.gap,
        "gap_rate": contact.gap_rate,
        **({"gap_drift": contact.gap_drift} if contact.gap_drift != 0 else {}),
        "slip_velocity": contact.slip_velocity,
        "W_nn": c.W_nn,
        "W_nt": c.W_nt,
        "W_tt": c.W_tt,
        "b_n": c.b_n,
        "b_t": c.b_t,
    }
    note = "gap_ddot = W_nn F_n + W_nt F_t + b_n,  slip_dot = W_nt F_n + W_tt F_t + b_t"
    return _registered("contact", values, note)


def _slip(mechanism: Mechanism) -> Section:
    c = mechanism.coefficients
    return _registered(
        "slip", {"A_neg": c.A(-1), "A_pos": c.A(1), "B": c.B}, "gap_ddot = A F_n + B"
    )


def _stick(mechanism: Mechanism) -> Section:
    c = mechanism.coefficients
    values = {"F_t_stick": c.sticking_force, "A_stick": c.A_stick, "B_stick": c.B_stick}
    note = "gap_ddot = A' F_n + B'" + (f". {_ANY_FORCE}" if c.rank_one else "")
    return _registered("sticking", values, note)


def _registered(title: str, values: Mapping[str, sp.Expr], note: str) -> Section:
    return Section(title, tuple(Formula.of(n, v) for n, v in values.items()), note=note)


def _bilateral(mechanism: Mechanism) -> Iterator[Section]:
    """Yield the sections of a bilateral contact: two forces, their number, the impulse."""
    forms = BilateralForms(mechanism.coefficients)
    forces = []
    for direction, s, words in (("neg", -1, LEFT), ("pos", 1, RIGHT)):
        for side, sign in SIDES.items():
            forces.append(
                Formula(
                    f"F_n_{direction}_{side}",
                    readable(mechanism.coefficients.slip_force(s * sign)),
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
    if not mechanism.coefficients.slides:
        yield Section("tangential impact", note=_NOTHING_TO_STOP)
        return
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


def _critical(mechanism: Mechanism) -> Section:
    """Return the critical friction, and the closed forms of its minimum."""
    title, c = "friction and the paradox", mechanism.coefficients
    try:
        critical = critical_friction(c)
    except InputError:
        return Section(title, note="W_nt = 0: A > 0 for every friction, there is no paradox.")
    meaning = "critical friction: A < 0 is possible only above it"
    formulas = [Formula("mu_critical", critical.value, "1", meaning, r"\mu_P")]
    directions = least_over_directions(c)
    if directions.is_finite is not False:
        formulas.append(
            Formula(
                "mu_critical_any_direction",
                directions,
                "1",
                "least critical friction over all directions of the surface, "
                "2 sqrt(L1 L2)/(L2 - L1) with the eigenvalues L1 < L2 of W",
                r"\min_{\psi} \mu_P",
            )
        )
    minima = list(_minima(mechanism, critical))
    formulas += [form for _, forms in minima for form in forms]
    notes = [note for note, _ in minima if note]
    open_contact = ""
    try:
        closed = critical.in_contact()
        meaning = "critical friction where the contact is closed: the gap fixes the configuration"
        formulas.append(Formula("mu_critical_in_contact", closed, "1", meaning, r"\mu_P(g_N = 0)"))
    except InputError:
        if any(note.endswith(_NO_FORM) for note in notes):
            open_contact = mechanism.contact.name
    return Section(title, tuple(formulas), note=" ".join(notes), contact=open_contact)


def _minima(
    mechanism: Mechanism, critical: CriticalFriction
) -> Iterator[tuple[str, tuple[Formula, ...]]]:
    """Yield, per coordinate of the critical friction, a note and the formulas of its minimum."""
    inner = [c for c in mechanism.system.coordinates if c.symbol in critical.value.free_symbols]
    if len(inner) > 1:
        # Over one angle with the others held it would say little, and take minutes.
        yield f"The minimum over {', '.join(c.name for c in inner)} {_NO_FORM}", ()
        return
    for coordinate in inner:
        name = coordinate.name
        try:
            lowest = critical.minimum(name)
        except InputError:
            yield f"The minimum over {name} {_NO_FORM}", ()
            continue
        if lowest.attained:
            yield _minimum(mechanism, coordinate, lowest)
        else:
            where = " or ".join(dict.fromkeys(_at(coordinate.symbol, lowest)))
            yield (
                (
                    f"There is no minimum over {name}: mu_critical falls to {plain(lowest.value)} "
                    f"towards {where}."
                ),
                (),
            )


def _at(q: sp.Symbol, lowest: CriticalMinimum) -> Iterator[str]:
    """Yield where a minimum is, in words; an infinite tangent is given as the angle."""
    for place in lowest.at:
        if place.is_infinite and lowest.variable == sp.tan(q):
            yield f"{q} = pi/2"
        else:
            yield f"{lowest.variable} = {plain(place)}"


def _minimum(
    mechanism: Mechanism, coordinate: Coordinate, lowest: CriticalMinimum
) -> tuple[str, tuple[Formula, ...]]:
    name = coordinate.name
    left = rf"\min_{{{coordinate.latex or name}}} \mu_P"
    key, smallest = f"mu_critical_min_{name}", f"smallest critical friction over {name}"
    if lowest.equation is None:
        where = " or ".join(_at(coordinate.symbol, lowest))
        return "", (Formula(key, lowest.value, "1", f"{smallest}, at {where}", left),)
    value, places = lowest.number(mechanism.system.defaults)
    meaning = {lowest.root: f"{lowest.variable} at the minimum, a root of {key}_equation"}
    degree = sp.degree(lowest.equation, lowest.root)
    place = " or ".join(f"{x:.6g}" for x in places)
    return (
        f"The minimum over {name} is at a root of a polynomial of degree {degree}; at the default "
        f"parameters it is {value:.6g}, at {lowest.variable} = {place}."
    ), (
        Formula(
            key,
            lowest.value,
            "1",
            f"{smallest}, with {lowest.root} = {lowest.variable} at a root of {key}_equation",
            left,
            meaning,
        ),
        Formula(
            f"{key}_equation",
            lowest.equation,
            "SI",
            f"polynomial in {lowest.root}, zero where mu_critical is least",
            f"p({sp.latex(lowest.root)})",
            meaning,
        ),
    )
