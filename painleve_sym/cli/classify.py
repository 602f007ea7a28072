"""The command classify: the rigid contact problem at a state with every solution."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator

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
)
from painleve_sym.cli.run import show_case
from painleve_sym.problem.risk import slip_angle
from painleve_sym.problem.solution import ContactCase, ContactSolution

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
    if not classification.problem.in_plane:
        _show_in_space(classification)
        return
    if classification.single:
        _show_coefficients(classification)
    else:
        _show_closed(classification, classification.problem.slips)
        show(f"for all loads: {classification.promise.meaning}")
    show()
    _show_case(classification)
    if classification.solutions:
        _show_solutions(classification)
    if classification.chatter:
        _show_chatter(classification)


def _show_case(classification: Classification) -> None:
    case = classification.case
    show(f"case: {case.value} ({case.sentence})")
    for border in classification.problem.borders:
        show(f"On a border within 1e-8: {BORDERS[border]}; a neighbouring state has another case.")
    if case is ContactCase.INCONSISTENT and classification.single:
        show("Only an impulse can answer: see the command jump.")


def _show_in_space(classification: Classification) -> None:
    """Print the sector of the paradox, the case and every solution of contacts in space."""
    problem, solutions = classification.problem, classification.solutions
    if classification.single:
        answer = classification.answer
        show("normal acceleration of the contact A F_n + B in slip along an angle from t1 to t2")
        rows = [("B", number(answer.B), "m/s^2", "")]
        if answer.A is not None:
            along = slip_angle(answer.slip)
            rows.insert(0, ("A", number(answer.A), "1/kg", f"slip along {number(along)} rad"))
        if answer.mu_P is not None:
            rows.append(("mu_P", number(answer.mu_P), "", "A < 0 is possible above"))
        if answer.least_over_normals is not None:
            least = number(answer.least_over_normals)
            rows.append(("least mu_P", least, "", "over all normals of the surface"))
        show_table(("",) * 4, rows, left=(0, 2, 3))
        sector = answer.sector
        show(
            "A >= 0 for every direction of slip"
            if sector is None
            else f"A < 0 for slip within {number(sector.half_angle)} rad of "
            f"{number(sector.direction)} rad"
        )
    else:
        _show_closed(classification, problem.slips)
    show()
    _show_case(classification)
    force = max((abs(f) for s in solutions for f in s.forces.tolist()), default=0.0)
    rate = max((abs(v) for s in solutions for v in s.accelerations.tolist()), default=0.0)

    def cells(s: ContactSolution) -> Iterator[tuple[str, ...]]:
        parts = zip(s.modes, s.directions, s.contact_forces, s.contact_accelerations, strict=True)
        for mode, angle, F, a in parts:
            way = "" if angle is None else number(angle)
            values = [number(f, size=force) for f in F.tolist()]
            values += [number(v, size=max(rate, 1e-300)) for v in a.tolist()]
            yield mode.value, way, *values

    if solutions:
        forces, rates = ("F_n [N]", "F_t1 [N]", "F_t2 [N]"), ("a_n [m/s^2]", "a_t1", "a_t2")
        head = ("slip [rad]", *forces, *rates)
        _show_each_contact(classification, head, map(cells, solutions))
    if not problem.complete:
        show(problem.guarantee)


def _show_each_contact(
    classification: Classification,
    head: tuple[str, ...],
    cells: Iterable[Iterable[tuple[str, ...]]],
) -> None:
    """Print a row for each contact in each solution: its mode, then the cells under the head."""
    rows: list[tuple[str, ...]] = [
        (str(k), name, *own)
        for k, solution in enumerate(cells, 1)
        for name, own in zip(classification.contacts, solution, strict=True)
    ]
    names: tuple[str, ...] = ("solution", "contact", "mode")
    if classification.single:  # its solutions have names
        rows, names = [row[2:] for row in rows], names[:1]
    show_table((*names, *head), rows, left=tuple(range(len(names))))
    if any(s.moves for s in classification.solutions):
        show("Motions that belong to a continuum of motions: one of them is shown.")
    widest = max(s.open_forces for s in classification.solutions)
    if widest:
        open_ = "one direction" if widest == 1 else f"{widest} directions"
        show(f"The forces are open in {open_}: the shortest ones are shown.")


def _show_coefficients(classification: Classification) -> None:
    """Print A and B of the only contact in slip and in sticking."""
    (own,), problem = classification.coefficients, classification.problem
    show("normal acceleration of the contact as a function of the normal force F_n")
    slips = [("slip", own.A)]
    if problem.bilateral[0]:
        show("(it is 0: the contact holds from both sides)")
        slips = [("slip, F_n > 0", own.A), ("slip, F_n < 0", own.A_pull)]
    if not problem.slip_direction:
        show("(v_t = 0 here; slip along the free acceleration is meant)")
    B = f"B  = {number(own.B)} m/s^2"
    rows = [(name, "A F_n + B", f"A  = {number(A)} 1/kg", B) for name, A in slips]
    stick = f"A' = {number(own.A_stick)} 1/kg", f"B' = {number(own.B_stick)} m/s^2"
    show_table(("",) * 4, [*rows, ("stick", "A' F_n + B'", *stick)], left=(0, 1, 2, 3))
    if len(slips) > 1:
        sign, meaning = ("<", "one solution") if own.excess < 0 else (">=", "none, one or two")
        excess = quantity(own.excess, "1/kg")
        show(f"mu |W_nt| - W_nn = {excess} {sign} 0: {meaning} while it slips")


def _show_closed(
    classification: Classification, slips: Iterable[Iterable[float]]
) -> None:
    """Print which contacts are closed, with their slip along each tangent, and which are open."""
    named = zip(classification.contacts, slips, strict=True)
    closed = ", ".join(f"{name} (slip {', '.join(map(number, v))} m/s)" for name, v in named)
    is_open = f"; open: {', '.join(classification.open)}" if classification.open else ""
    show(f"closed: {closed}{is_open}")


def _show_solutions(classification: Classification) -> None:
    """Print the forces and accelerations of each contact in each solution."""
    solutions, problem = classification.solutions, classification.problem
    force = max((abs(float(f)) for s in solutions for f in s.forces), default=0.0)
    rate = max((abs(float(a)) for s in solutions for a in s.accelerations), default=0.0)
    rate = max(rate, *map(abs, problem.b.tolist()))
    sizes = force, force, rate, rate

    def cells(s: ContactSolution) -> Iterator[tuple[str, ...]]:
        forces = s.normal_forces, s.tangential_forces
        rates = s.normal_accelerations, s.tangential_accelerations
        for i, values in enumerate(zip(*forces, *rates, strict=True)):
            pairs = zip(values, sizes, strict=True)
            yield solution_name(s, problem, i), *(number(float(v), size=size) for v, size in pairs)

    head = ("F_n [N]", "F_t [N]", "a_n [m/s^2]", "a_t [m/s^2]")
    _show_each_contact(classification, head, map(cells, solutions))


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
