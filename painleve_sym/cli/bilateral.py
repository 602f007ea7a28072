"""What the commands say of a bilateral contact: its solutions and its tangential impact."""

from __future__ import annotations

from painleve_sym.cli.output import number, quantity, show, show_table
from painleve_sym.contacts.classify_bilateral import (
    BilateralClassification,
    TangentialImpact,
    solution_name,
)

CASES = {
    "inconsistent": "no finite forces hold the contact while it slips so",
    "unique": "one solution",
    "two solutions": "one for each sign of F_n, the rigid model does not choose",
    "several": "the rigid model does not choose",
}


def show_bilateral(found: BilateralClassification) -> None:
    """Print the coefficients of both sides, the case and every solution."""
    direction = "v_t < 0" if found.slip < 0 else "v_t > 0"
    moving = found.problem.slip_direction != 0
    show()
    show(f"the contact holds from both sides: 0 = A F_n + B in slip with {direction}")
    if not moving:
        show("(v_t = 0 here; slip along the free acceleration is meant)")
    B = f"B  = {number(found.B)} m/s^2"
    show_table(
        ("", "", ""),
        [
            ("F_n > 0", f"A  = {number(found.A_push)} 1/kg", B),
            ("F_n < 0", f"A  = {number(found.A_pull)} 1/kg", B),
            (
                "stick",
                f"A' = {number(found.A_stick)} 1/kg",
                f"B' = {number(found.B_stick)} m/s^2",
            ),
        ],
        left=(0, 1, 2),
    )
    show()
    sign, meaning = ("<", "one solution") if found.excess < 0 else (">=", "none, one or two")
    show(f"mu |W_nt| - W_nn = {quantity(found.excess, '1/kg')} {sign} 0: {meaning} while it slips")
    show(f"case: {found.case.value} ({CASES[found.case.value]})")
    if found.solutions:
        rows = [
            (
                solution_name(s, found.problem),
                number(s.normal_force),
                number(s.tangential_force),
                "0",
                number(s.tangential_acceleration),
            )
            for s in found.solutions
        ]
        show_table(("solution", "F_n [N]", "F_t [N]", "a_n [m/s^2]", "a_t [m/s^2]"), rows)
    if found.case.value == "inconsistent":
        show("Only an impulse can answer: see the command jump.")


def show_tangential_impact(found: TangentialImpact, units: dict[str, str]) -> None:
    """Print the impulse that stops the slip and the velocities around it."""
    show("tangential impact: the slip stops at once, the normal velocity stays 0")
    show()
    impulses = (number(found.normal_impulse), number(found.tangential_impulse))
    show_table(("P_n [N s]", "P_t [N s]"), [impulses], left=())
    show()
    names = list(found.velocity)
    rows = [
        ("before", *(number(found.velocity_before[n]) for n in names)),
        ("after", *(number(found.velocity[n]) for n in names)),
    ]
    show_table(("", *(f"{n} [{units[n]}]" for n in names)), rows)
    show()
    show(f"case before: {found.case.value} ({CASES[found.case.value]})")
    show(f"energy change {quantity(found.energy_change, 'J')}")
