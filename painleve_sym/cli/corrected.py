"""The jump at finite stiffness, as text and as data, for the command jump."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from painleve_sym.at.jump import JumpResult
from painleve_sym.cli.output import number, quantity, show, show_table, velocity_table
from painleve_sym.plain_data import plain_fields

if TYPE_CHECKING:
    from painleve_sym.motion.finite_stiffness import CorrectedJump

_ENDS = {
    "SEPARATION": "the contact opens",
    "STAYS": "the contact stays closed: no jump",
    "NO_IMPACT": "the contact opens at once: no jump",
    "FAILED": "the numbers leave the range of floating point",
}

_PHASE = {
    **{"duration": 5, "normal_impulse": 5, "tangential_impulse": 5},
    **{"compression": 4, "slip_velocity": 4, "normal_velocity": 5},
}
"""Numbers of a phase, with the digits that are shown."""


def corrected_data(corrected: CorrectedJump) -> dict[str, Any]:
    """Return the jump as plain data with the documented keys."""
    shape = ("stiffness", "exponent", "initial_compression", "largest_compression", "duration")
    return {
        **plain_fields(corrected, "law", "configuration", "method", *shape),
        "end": corrected.end.value,
        "phases": [plain_fields(phase, "name", *_PHASE) for phase in corrected.phases],
        "final": {"velocity": dict(corrected.velocity)},
    }


def show_corrected(corrected: CorrectedJump, rigid: JumpResult, units: Mapping[str, str]) -> None:
    """Print the phases at finite stiffness and both jumps side by side."""
    show()
    K, n = number(corrected.stiffness), number(corrected.exponent)
    text = f"law {corrected.law}, K = {K} N/m^n, n = {n}"
    show(f"at finite stiffness: {text}, configuration {corrected.configuration}")
    show()
    head = ("phase", "time [s]", "P_n [N s]", "P_t [N s]", "depth [m]", "v_t [m/s]", "v_n [m/s]")
    rows = [
        (p.name, *(number(getattr(p, name), digits) for name, digits in _PHASE.items()))
        for p in corrected.phases
    ]
    show_table(head, rows, indent=0)
    show()
    courses = [("classical rule", rigid.velocity), ("at this stiffness", corrected.velocity)]
    after = velocity_table(courses, units, "velocity after")
    show_table(after[0], after[1:])
    show()
    end = _ENDS[corrected.end.name]
    show(f"{end} after {quantity(corrected.duration, 's')}; by {corrected.method}")
