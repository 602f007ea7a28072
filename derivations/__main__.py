"""Run every derivation: assert it, write its page and its Python form."""

from __future__ import annotations

from collections.abc import Callable

from derivations import (
    compliance_energies,
    contact_coefficients,
    equations_of_motion,
    paradox_conditions,
    sticking,
    three_phase_jump,
)
from derivations._page import Derivation, run

DERIVATIONS: tuple[Callable[[], Derivation], ...] = (
    equations_of_motion.derive,
    contact_coefficients.derive,
    sticking.derive,
    paradox_conditions.derive,
    compliance_energies.derive,
    three_phase_jump.derive,
)


def main() -> None:
    """Run them in the order in which they build on each other."""
    for derive in DERIVATIONS:
        run(derive)


if __name__ == "__main__":
    main()
