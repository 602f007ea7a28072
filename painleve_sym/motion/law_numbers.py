"""Numbers of the laws of a simulator: loading curves, and parameters that materials give."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.checks import number
from painleve_sym.codegen.quantities import quantities
from painleve_sym.mechanics.materials import MaterialsLike, material_values, two_materials
from painleve_sym.motion.mechanism_with_laws import MechanismWithLaws
from painleve_sym.units import Value


def loading_curve(
    simulator: MechanismWithLaws, values: Mapping[str, Array], i: int = 0
) -> tuple[Array, Array]:
    """Return K and n of a compliant contact's loading curve K δⁿ, each of shape (n,)."""

    def derive() -> tuple[dict[str, Any], tuple[Any, ...]]:
        automaton = simulator.automaton
        curves = {
            f"{name}_{k}": getattr(law, name)
            for k, law in simulator.contact.compliant.items()
            for name in ("stiffness", "exponent")
        }
        return curves, (*automaton.parameters, *automaton.definitions)

    names, definition = simulator.outline.constant_names, simulator.contact.definition
    curve = quantities("loading curves", definition, names, derive).at(values)
    return curve[f"stiffness_{i}"], curve[f"exponent_{i}"]


def compression_of_force(
    simulator: MechanismWithLaws, force: Value, parameters: Mapping[str, float]
) -> float:
    """Return δ₀ > 0 with F_n(δ₀) = `force` on the loading curve at rest; m.

    The initial surface energy of the paper, (10), is given this way.
    """
    force = number(force, "initial force", where=simulator.where, unit="N", lower=0.0)
    _ = simulator.contact_law  # rejects laws without a loading curve
    values = {s: np.array([v]) for s, v in simulator.constants(parameters).items()}
    k, n = (float(v[0]) for v in loading_curve(simulator, values))
    return float((force / k) ** (1 / n))


def values_of_materials(
    simulator: MechanismWithLaws, materials: MaterialsLike, given: Mapping[str, Any] | None = None
) -> dict[str, float]:
    """Return the values that materials give to parameters of mechanism and laws.

    Parameters
    ----------
    simulator : Simulator
    materials : Material or its name, or two
        That of both bodies in contact, or those of the moving body and of the other:
        ``steel,rubber``.
    given : mapping of str to object
        Parameters that have their values, and are left out.

    Raises
    ------
    InputError
        Unknown names, a property that a material lacks.
    """
    pair, known = two_materials(materials), given or {}
    declared, law = simulator.mechanism.outline.parameters, f"law {simulator.label!r}"
    return {
        **material_values(simulator.where, pair, declared, known),
        **material_values(law, pair, simulator.own_parameters, known),
    }
