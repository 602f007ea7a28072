"""Scales of the states of a contact, below which only absolute errors count."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.evaluate import power
from painleve_sym.contacts.contact_numbers import characteristic_length

AT_REST = 1e-20
"""Part of the energy to be gained below which a motion starts from rest."""


def gained_energy(numbers: Mapping[str, Array], length: Array) -> Array:
    """Return what the free contact forces |b|/W would give to a motion over the lengths (n,); J.

    1 where there are none: what nothing drives needs no scale.
    """
    gained = np.zeros_like(length)
    for row in ("n", "t"):
        pull, mobility = np.abs(numbers[f"b_{row}"]), numbers[f"W_{row}{row}"]
        held = np.divide(pull, mobility, out=np.zeros_like(length), where=mobility > 0)
        gained = np.maximum(gained, held * length)
    return np.where(gained > 0, gained, 1.0)


def rigid_scales(numbers: Mapping[str, Array]) -> tuple[Array, ...]:
    """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a rigid contact."""
    kinetic, length = numbers["kinetic_energy"], characteristic_length(numbers)
    gained = gained_energy(numbers, length)
    energy = np.where(kinetic > AT_REST * gained, kinetic, gained)
    return length, np.sqrt(2 * energy * numbers["W_nn"]), energy


def compliant_scales(
    numbers: Mapping[str, Array], gap: Array, stiffness: Array, exponent: Array
) -> tuple[Array, ...]:
    """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a compliant contact.

    The gap's is the compression δ_c under the free normal force |b_n|/W_nn, its rate's δ_c/T
    with T the time of a contact under that force.

    Parameters
    ----------
    numbers : mapping of str to ndarray, shape (n,)
        What `contact_numbers` gives.
    gap : ndarray, shape (n,)
        m.
    stiffness, exponent : ndarray, shape (n,)
        K and n of the loading curve K δⁿ.
    """
    k, n = stiffness, exponent
    W_nn, b_n = numbers["W_nn"], np.abs(numbers["b_n"])
    force, depth = b_n / W_nn, np.maximum(0.0, -gap)
    kinetic = numbers["kinetic_energy"]
    stored = k * power(depth, n + 1) / (n + 1)
    pressed = force > 0
    # Where nothing presses: a hundredth of what the available energy can compress.
    delta, root = force / k, 1 / n
    delta[~pressed] = ((n + 1) * (kinetic + stored) / k)[~pressed]
    root[~pressed] = 1 / (n + 1)[~pressed]
    delta = np.where(pressed, 1.0, 0.01) * power(delta, root)
    energy = kinetic + stored + force * delta
    still, length = energy == 0, characteristic_length(numbers)
    delta = np.where(still, length, delta)
    energy = np.where(still, gained_energy(numbers, length), energy)
    rate = np.where(pressed, np.sqrt(delta * b_n), 0.01 * np.sqrt(2 * energy * W_nn))
    return delta, rate, energy
