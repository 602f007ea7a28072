"""The command classify: the rigid contact problem at a state with every solution."""

from __future__ import annotations

import argparse
import math

from painleve_sym.at.classification import Classification, solution_name
from painleve_sym.cli.case import read_case
from painleve_sym.cli.output import (
    notices_data,
    number,
    print_json,
    quantity,
    show,
    show_notices,
    show_table,
    slip_cells,
    slip_head,
)
from painleve_sym.cli.run import show_case
from painleve_sym.contact_rows import axis_names
from painleve_sym.problem.coefficients import Sector
from painleve_sym.problem.solution import ContactCase

BORDERS = {
    "grazing": "a contact neither presses nor leaves",
    "edge": "friction is at its limit without slip",
    "infinity": "forces of any size are next to a solution",
}


def classify(arguments: argparse.Namespace) -> int:
    """Print the rigid contact problem at a state with every solution."""
    scenario = read_case(arguments)
    classification = scenario.classify()
    if arguments.json:
        print_json(classification.to_dict() | notices_data(scenario.contact_notices))
        return 0
    show_case(scenario.mechanism(), scenario, classification.parameters)
    show_classification(classification)
    show_notices(scenario.contact_notices)
    return 0


def show_classification(classification: Classification) -> None:
    """Print the coefficients, the case, every solution and what small bounces do."""
    show()
    if classification.single:
        _show_coefficients(classification)
    else:
        _show_closed(classification)
        if classification.promise is not None:
            show(
                f"{classification.promise.meaning[0].upper()}{classification.promise.meaning[1:]}."
            )
    show()
    _show_case(classification)
    if classification.solutions:
        show_solutions(classification)
    if not classification.problem.complete:
        show(classification.problem.guarantee)
    if classification.chatter:
        _show_chatter(classification)


def _show_case(classification: Classification) -> None:
    case = classification.case
    show(f"case: {case.value} ({case.sentence})")
    for border in classification.problem.borders:
        show(f"On a border within 1e-8: {BORDERS[border]}; a neighbouring state has another case.")
    if case is ContactCase.INCONSISTENT and classification.single:
        show("Only an impulse can answer: see the command jump.")


def _show_coefficients(classification: Classification) -> None:
    """Print A and B of the only contact in slip and in sticking, and its critical friction."""
    (own,), problem = classification.coefficients, classification.problem
    show("normal acceleration of the contact as a function of the normal force F_n")
    slips = [("slip", own.A)]
    if problem.bilateral[0]:
        show("(it is 0: the contact holds from both sides)")
        slips = [("slip, F_n > 0", own.A), ("slip, F_n < 0", own.A_pull)]
    if not any(problem.slip_velocity):
        show("(v_t = 0 here; slip as it would begin is meant)")
    B = f"B  = {number(own.B)} m/s^2"
    rows = [(name, "A F_n + B", f"A  = {number(A)} 1/kg", B) for name, A in slips]
    stick = f"A' = {number(own.A_stick)} 1/kg", f"B' = {number(own.B_stick)} m/s^2"
    show_table(("",) * 4, [*rows, ("stick", "A' F_n + B'", *stick)], left=(0, 1, 2, 3))
    if problem.bilateral[0]:
        sign, meaning = ("<", "one solution") if own.excess < 0 else (">=", "none, one or two")
        excess = quantity(own.excess, "1/kg")
        show(f"mu |W_nt| - W_nn = {excess} {sign} 0: {meaning} while it slips")
    above = "A > 0 in slip, whatever the friction"
    if math.isfinite(own.mu_P):
        above = f"A < 0 is possible for mu > mu_P = {number(own.mu_P)}"
    show(f"{above}; least mu_P of all normals: {number(own.least_over_normals)}")
    if own.sector is not None:
        show(f"A < 0 for slip {_directions(own.sector)}")


def _directions(sector: Sector) -> str:
    """Return the directions of slip of a sector in words; of one tangent, a sign."""
    first, *across = sector.direction
    if not across:
        return f"with v_t {'<' if first < 0 else '>'} 0"
    near = f"within {number(sector.half_angle)} rad of" if sector.half_angle else "along"
    return f"{near} ({', '.join(map(number, sector.direction))})"


def _show_closed(classification: Classification) -> None:
    """Print which contacts are closed, with their slip along each tangent, and which are open."""
    named = zip(classification.contacts, classification.problem.slips, strict=True)
    closed = ", ".join(f"{name} (slip {', '.join(map(number, v))} m/s)" for name, v in named)
    is_open = f"; open: {', '.join(classification.open)}" if classification.open else ""
    show(f"closed: {closed}{is_open}")


def show_solutions(classification: Classification) -> None:
    """Print a row for each contact in each solution: mode, slip, forces and accelerations.

    One contact has no names, and one tangent no direction besides its mode.
    """
    solutions, problem = classification.solutions, classification.problem
    force = max((abs(f) for s in solutions for f in s.forces.tolist()), default=0.0)
    rate = max((abs(a) for s in solutions for a in s.accelerations.tolist()), default=0.0)
    rate = max(rate, *map(abs, problem.b.tolist()))
    axes = axis_names(max(problem.tangents))
    rows = []
    for k, s in enumerate(solutions, 1):
        parts = zip(s.directions, s.contact_forces, s.contact_accelerations, strict=True)
        for i, (direction, F, a) in enumerate(parts):
            names = (str(k), classification.contacts[i])[2 * classification.single :]
            values = [number(f, size=force) for f in F.tolist()]
            values += [number(v, size=rate) for v in a.tolist()]
            rows.append((*names, solution_name(s, problem, i), *slip_cells(direction), *values))
    names = ("solution",) if classification.single else ("solution", "contact", "mode")
    head = (*names, *slip_head(len(axes) - 1), *(f"F_{k} [N]" for k in axes))
    # In 80 columns: a_t1 and a_t2 have the unit of a_n.
    head += tuple(f"a_{k}{' [m/s^2]' * (k in 'nt')}" for k in axes)
    show_table(head, rows, left=range(len(names)))
    if any(s.moves for s in solutions):
        show("Motions that belong to a continuum of motions: one of them is shown.")
    widest = max(s.open_forces for s in solutions)
    if widest:
        open_ = "one direction" if widest == 1 else f"{widest} directions"
        show(f"The forces are open in {open_}: the shortest ones are shown.")


def _show_chatter(classification: Classification) -> None:
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
        for c in classification.chatter
    ]
    show_table(("rule", "e", "ratio", "threshold", "bounces"), rows, left=(0, 4))
