"""What the commands print of several contacts: solutions, and events with their contact."""

from __future__ import annotations

from collections.abc import Sequence

from painleve_sym.cli.output import number, show, show_table
from painleve_sym.contacts.classify_several import SeveralClassification
from painleve_sym.simulate.trajectory import EventRecord

_CASES = {
    "inconsistent": "no forces of the rigid contacts are possible here",
    "unique": "one solution",
    "hyperstatic": "one motion, but rigidity leaves its forces open",
    "indeterminate": "several solutions, the rigid model does not choose",
}


def show_several(found: SeveralClassification) -> None:
    """Print the solutions of several contacts."""
    show()
    slips = zip(found.contacts, found.slip_velocities, strict=True)
    closed = ", ".join(f"{name} (slip {number(v)} m/s)" for name, v in slips)
    show(f"closed: {closed}" + (f"; open: {', '.join(found.open)}" if found.open else ""))
    show(f"for all loads: {found.promise.value[1]}")
    show()
    show(f"case: {found.case} ({_CASES[found.case]})")
    head = ("solution", "contact", "mode", "F_n [N]", "F_t [N]", "a_n [m/s^2]", "a_t [m/s^2]")
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
            rows.append((str(k), name, mode.value, *(number(float(v)) for v in values)))
    if rows:
        show_table(head, rows, left=(0, 1, 2))
    if any(s.isolated is False for s in found.solutions):
        show("Forces that belong to a continuum of solutions: one of them is shown.")


def event_table(
    events: Sequence[EventRecord],
) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return head and rows of a table of events; the contact where several are told apart."""
    several = len({e.contact for e in events}) > 1
    head: tuple[str, ...] = ("time [s]", "event", "mode after", "F_n [N]", "depth [m]")
    rows: list[tuple[str, ...]] = [
        (
            number(e.time, 9),
            f"{e.kind} {e.contact}" if several and e.contact else e.kind,
            e.mode_after,
            number(e.normal_force),
            number(e.compression),
        )
        for e in events
    ]
    return head, rows
