"""The command classify: the rigid contact problem at a state with every solution."""

from __future__ import annotations

import argparse

from painleve_sym.cli.case import read_case
from painleve_sym.cli.output import number, print_json, quantity, show, show_table
from painleve_sym.cli.run import show_case
from painleve_sym.contacts.classify import Classification, solution_name
from painleve_sym.contacts.problem import ContactCase


def classify(arguments: argparse.Namespace) -> int:
    """Print the rigid contact problem at a state with every solution."""
    scenario = read_case(arguments)
    found = scenario.classify()
    if arguments.json:
        print_json(found.to_dict())
        return 0
    show_case(scenario.mechanism(), scenario, found.parameters)
    show_classification(found)
    return 0


def show_classification(found: Classification) -> None:
    """Print the coefficients, the case, every solution and what small bounces do."""
    show()
    if found.single:
        _show_coefficients(found)
    else:
        _show_closed(found)
    show()
    if found.bilateral:
        sign, meaning = ("<", "one solution") if found.excess < 0 else (">=", "none, one or two")
        excess = quantity(found.excess, "1/kg")
        show(f"mu |W_nt| - W_nn = {excess} {sign} 0: {meaning} while it slips")
    show(f"case: {found.case.value} ({found.case.sentence})")
    if found.solutions:
        _show_solutions(found)
    if found.bilateral and found.case is ContactCase.INCONSISTENT:
        show("Only an impulse can answer: see the command jump.")
    if found.chatter:
        _show_chatter(found)


def _show_coefficients(found: Classification) -> None:
    """Print A and B of the only contact in slip and in sticking."""
    B = f"B  = {number(found.B)} m/s^2"
    stick = (f"A' = {number(found.A_stick)} 1/kg", f"B' = {number(found.B_stick)} m/s^2")
    if found.bilateral:
        direction = "v_t < 0" if found.slip < 0 else "v_t > 0"
        show(f"the contact holds from both sides: 0 = A F_n + B in slip with {direction}")
        if not found.problem.slip_direction:
            show("(v_t = 0 here; slip along the free acceleration is meant)")
        rows: list[tuple[str, ...]] = [
            ("F_n > 0", f"A  = {number(found.A_push)} 1/kg", B),
            ("F_n < 0", f"A  = {number(found.A_pull)} 1/kg", B),
            ("stick", *stick),
        ]
    else:
        show("normal acceleration of the contact as a function of the normal force F_n")
        rows = [
            ("slip", "A F_n + B", f"A  = {number(found.A)} 1/kg", B),
            ("stick", "A' F_n + B'", *stick),
        ]
    width = len(rows[0])
    show_table(("",) * width, rows, left=tuple(range(width)))


def _show_closed(found: Classification) -> None:
    """Print which contacts are closed, how they slip, and what their matrix promises."""
    slips = zip(found.contacts, found.problem.slip_velocity, strict=True)
    closed = ", ".join(f"{name} (slip {number(v)} m/s)" for name, v in slips)
    show(f"closed: {closed}" + (f"; open: {', '.join(found.open)}" if found.open else ""))
    show(f"for all loads: {found.promise.meaning}")


def _show_solutions(found: Classification) -> None:
    """Print the forces and accelerations of each contact in each solution."""
    rows = []
    for k, s in enumerate(found.solutions, 1):
        parts = zip(
            found.contacts,
            s.modes,
            s.normal_forces,
            s.tangential_forces,
            s.normal_accelerations,
            s.tangential_accelerations,
            strict=True,
        )
        for name, mode, *values in parts:
            several = (str(k), name, mode.value)
            first = (solution_name(s, found.problem),) if found.single else several
            rows.append((*first, *(number(float(v)) for v in values)))
    names = ("solution",) if found.single else ("solution", "contact", "mode")
    head = (*names, "F_n [N]", "F_t [N]", "a_n [m/s^2]", "a_t [m/s^2]")
    show_table(head, rows, left=tuple(range(len(names))))
    if not found.single and any(s.isolated is False for s in found.solutions):
        show("Forces that belong to a continuum of solutions: one of them is shown.")


def _show_chatter(found: Classification) -> None:
    show()
    show("small bounces near this contact: ratio of successive ones, and e where it is 1")
    rows = [
        (
            c.restitution,
            number(c.e),
            number(c.ratio),
            "none below 1" if c.threshold is None else number(c.threshold),
            "grow: reverse chatter" if c.reverse else "die out",
        )
        for c in found.chatter
    ]
    show_table(("rule", "e", "ratio", "threshold", "bounces"), rows, left=(0, 4))
