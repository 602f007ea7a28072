"""The numbers of a contact at a state: motion, Delassus matrix, free motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.mechanics.mechanism import Mechanism


def contact_numbers(mechanism: Mechanism, i: int = 0) -> Quantities:
    """Return gap, gap_rate, slip_velocity, W_nn, W_nt, W_tt, b_n, b_t, A_stick, B_stick.

    Also kinetic_energy and the diagonal of M as mass_0, mass_1, … All are functions of coordinates,
    velocities and parameters; units as in `Contact` and `ContactCoefficients`.

    Parameters
    ----------
    mechanism : Mechanism
    i : int
        Which of its contacts.
    """
    system = mechanism.system
    symbols = (*system.q, *system.q_dot, *(p.symbol for p in system.parameters))
    return quantities(
        f"contact {i}", mechanism.definition, symbols, lambda: _formulas(mechanism, i)
    )


def _formulas(mechanism: Mechanism, i: int) -> Mapping[str, Any]:
    system, contact, c = mechanism.system, mechanism.contacts[i], mechanism.all_coefficients[i]
    motion = ("gap", "gap_rate", "slip_velocity")
    forces = ("W_nn", "W_nt", "W_tt", "b_n", "b_t", "A_stick", "B_stick")
    formulas = {name: getattr(contact, name) for name in motion}
    formulas |= {name: getattr(c, name) for name in forces}
    formulas |= {f"mass_{k}": system.mass_matrix[k, k] for k in range(len(system.q))}
    return formulas | {"kinetic_energy": system.kinetic_energy}
