"""The numbers of a mechanism at a state: contact motion, Delassus matrix, free motion, domain."""

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
    return quantities(
        f"contact {i}", mechanism.definition, _symbols(mechanism), lambda: _formulas(mechanism, i)
    )


def domain_margins(mechanism: Mechanism) -> Quantities:
    """Return margin_0, margin_1, … of the bounds of the domain, all positive inside.

    Functions of coordinates, velocities and parameters.
    """
    return quantities(
        "domain",
        mechanism.definition,
        _symbols(mechanism),
        lambda: {f"margin_{i}": bound.margin for i, bound in enumerate(mechanism.domain)},
    )


def _symbols(mechanism: Mechanism) -> tuple[Any, ...]:
    return (*mechanism.motion, *(p.symbol for p in mechanism.system.parameters))


def _formulas(mechanism: Mechanism, i: int) -> Mapping[str, Any]:
    system, contact, c = mechanism.system, mechanism.contacts[i], mechanism.all_coefficients[i]
    motion = ("gap", "gap_rate", "slip_velocity")
    forces = ("W_nn", "W_nt", "W_tt", "b_n", "b_t", "A_stick", "B_stick")
    formulas = {name: getattr(contact, name) for name in motion}
    formulas |= {name: getattr(c, name) for name in forces}
    formulas |= {f"mass_{k}": system.mass_matrix[k, k] for k in range(len(system.q))}
    return formulas | {"kinetic_energy": system.kinetic_energy}
