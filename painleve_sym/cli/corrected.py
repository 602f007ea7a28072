"""The jump at finite stiffness, as text and as data, for the command jump."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from painleve_sym.cli.output import number, quantity, show, show_table
from painleve_sym.contacts.impact.jump import JumpResult
from painleve_sym.files import plain_fields
from painleve_sym.simulate.finite_stiffness import CorrectedJump
from painleve_sym.simulate.frozen_impact import FrozenEnd

_ENDS = {
    FrozenEnd.SEPARATION: "the contact opens",
    FrozenEnd.STAYS: "the contact stays closed: no jump",
    FrozenEnd.NO_IMPACT: "the contact opens at once: no jump",
    FrozenEnd.FAILED: "the numbers leave the range of floating point",
}

_PHASE = (
    *("name", "duration", "normal_impulse", "tangential_impulse"),
    *("compression", "slip_velocity", "normal_velocity"),
)


def corrected_data(found: CorrectedJump) -> dict[str, Any]:
    """Return the jump as plain data with the documented keys."""
    shape = ("stiffness", "exponent", "initial_compression", "largest_compression", "duration")
    return {
        **plain_fields(found, "law", "configuration", "method", *shape),
        "end": found.end.name.lower(),
        "phases": [plain_fields(phase, *_PHASE) for phase in found.phases],
        "final": {"velocity": dict(found.velocity)},
    }


def show_corrected(found: CorrectedJump, rigid: JumpResult, units: Mapping[str, str]) -> None:
    """Print the phases at finite stiffness and both jumps side by side."""
    show()
    text = f"law {found.law}, K = {number(found.stiffness)} N/m^n, n = {number(found.exponent)}"
    show(f"at finite stiffness: {text}, configuration {found.configuration}")
    show()
    head = ("phase", "time [s]", "P_n [N s]", "P_t [N s]", "depth [m]", "v_t [m/s]", "v_n [m/s]")
    rows = [
        (
            p.name,
            number(p.duration, 5),
            number(p.normal_impulse, 5),
            number(p.tangential_impulse, 5),
            number(p.compression, 4),
            number(p.slip_velocity, 4),
            number(p.normal_velocity, 5),
        )
        for p in found.phases
    ]
    show_table(head, rows, indent=0)
    show()
    names = list(found.velocity)
    after = [
        ("classical rule", *(number(rigid.velocity[n]) for n in names)),
        ("at this stiffness", *(number(found.velocity[n]) for n in names)),
    ]
    show_table(("velocity after", *(f"{n} [{units[n]}]" for n in names)), after)
    show()
    show(f"{_ENDS[found.end]} after {quantity(found.duration, 's')}; by {found.method}")
