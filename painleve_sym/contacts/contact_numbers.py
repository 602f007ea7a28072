"""The numbers of a mechanism at a state: contact motion, Delassus matrix, free motion, domain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.mechanics.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class ContactNumbers:
    """Numbers of all n contacts of a mechanism at one state.

    Attributes
    ----------
    gap, gap_rate, slip_velocity : ndarray, shape (n,)
        m, m/s, m/s.
    W : ndarray, shape (2 n, 2 n)
        Mobility with rows n1, t1, n2, t2, ...; 1/kg.
    b : ndarray, shape (2 n,)
        Accelerations without contact forces; m/s².
    mu : ndarray, shape (n,)
        Friction coefficients.
    A_stick, B_stick : ndarray, shape (n,)
        A′ and B′ of each contact with the others open; 1/kg and m/s².
    """

    gap: Array
    gap_rate: Array
    slip_velocity: Array
    W: Array
    b: Array
    mu: Array
    A_stick: Array
    B_stick: Array


def all_contact_numbers(
    mechanism: Mechanism, values: Mapping[Any, float], parameters: Mapping[str, float]
) -> ContactNumbers:
    """Return the numbers of all contacts, each formula evaluated once.

    Parameters
    ----------
    mechanism : Mechanism
    values : mapping of sympy.Symbol to float
        Coordinates, velocities and parameters (`symbol_values`).
    parameters : mapping of str to float
        By name.
    """
    n = len(mechanism.contacts)
    found = [contact_numbers(mechanism, i)(values) for i in range(n)]
    W = np.zeros((2 * n, 2 * n))
    for i, own in enumerate(found):
        block = [[own["W_nn"], own["W_nt"]], [own["W_nt"], own["W_tt"]]]
        W[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = block
    if n > 1:
        for name, value in _couplings(mechanism)(values).items():
            row, column = map(int, name.split("_")[1:])
            W[row, column] = W[column, row] = value
    motion = {
        name: np.array([own[name] for own in found])
        for name in ("gap", "gap_rate", "slip_velocity", "A_stick", "B_stick")
    }
    return ContactNumbers(
        W=W,
        b=np.array([own[name] for own in found for name in ("b_n", "b_t")]),
        mu=np.array([float(parameters[c.friction.name]) for c in mechanism.contacts]),
        **motion,
    )


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


def _couplings(mechanism: Mechanism) -> Quantities:
    """Return the entries W_row_column above the diagonal that couple two contacts."""

    def formulas() -> dict[str, Any]:
        rows = [row for c in mechanism.contacts for row in (c.J_N, c.J_T)]
        inverse = mechanism.system.inverse_mass_matrix
        return {
            f"W_{r}_{c}": (rows[r] * inverse * rows[c].T)[0]
            for r, c in combinations(range(len(rows)), 2)
            if r // 2 != c // 2
        }

    return quantities("couplings", mechanism.definition, _symbols(mechanism), formulas)


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
