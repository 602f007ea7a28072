"""The numbers of a mechanism with one contact at a state: motion, Delassus matrix, free motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.mechanics.mechanism import Mechanism


def contact_numbers(mechanism: Mechanism) -> Quantities:
    """Return gap, gap_rate, slip_velocity, W_nn, W_nt, W_tt, b_n, b_t, A_stick, B_stick.

    Also kinetic_energy and the diagonal of M as mass_0, mass_1, … All are functions of coordinates,
    velocities and parameters; units as in `Contact` and `ContactCoefficients`.

    Parameters
    ----------
    mechanism : Mechanism
        With one contact.
    """
    system = mechanism.system
    symbols = (*system.q, *system.q_dot, *(p.symbol for p in system.parameters))
    return quantities("contact", mechanism.definition, symbols, lambda: _formulas(mechanism))


def _formulas(mechanism: Mechanism) -> Mapping[str, Any]:
    system, contact, c = mechanism.system, mechanism.contact, mechanism.coefficients
    motion = ("gap", "gap_rate", "slip_velocity")
    forces = ("W_nn", "W_nt", "W_tt", "b_n", "b_t", "A_stick", "B_stick")
    formulas = {name: getattr(contact, name) for name in motion}
    formulas |= {name: getattr(c, name) for name in forces}
    formulas |= {f"mass_{i}": system.mass_matrix[i, i] for i in range(len(system.q))}
    return formulas | {"kinetic_energy": system.kinetic_energy}
