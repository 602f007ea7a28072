"""Quantities of a mechanism as CasADi functions of its state and parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from painleve_sym.at.delassus import Delassus, NumericalMechanism, argument_symbols
from painleve_sym.errors import refuse_unknown
from painleve_sym.mechanics.mechanism import Mechanism

if TYPE_CHECKING:
    import casadi as ca

OF_SLIDING = ("A", "B", "mu_P")
"""Quantities of each contact while it slides, made of W, b and the slip velocity."""
OF_SYSTEM = {
    "T": "kinetic_energy",
    "V": "potential_energy",
    "M": "mass_matrix",
    "h": "bias_force",
}
"""Quantities of the Lagrangian system, by the attribute that has their formula."""


def quantity_function(mechanism: Mechanism, quantity: str) -> ca.Function:
    """Return a quantity of a mechanism as a CasADi function; see `Mechanism.casadi`."""
    import casadi as ca

    outline, numbers = mechanism.outline, Delassus.of(mechanism)
    of_system = {} if isinstance(mechanism, NumericalMechanism) else OF_SYSTEM
    names = (*numbers.array_names, *OF_SLIDING, *of_system)
    refuse_unknown("quantity", quantity, names, f"mechanism {mechanism.name!r}: casadi")
    state = ca.SX.sym("state", len(outline.state_names))
    parameters = ca.SX.sym("parameters", len(outline.parameters))
    entries = [*ca.vertsplit(state), *ca.vertsplit(parameters)]
    values = dict(zip(outline.argument_names, entries, strict=True))
    if quantity in of_system:
        value = _of_system(mechanism, of_system[quantity], entries)
    elif quantity in OF_SLIDING:
        # Contacts of a robot that stay stuck come behind its own.
        mu = numbers.friction_of(values)[: len(outline.contacts)]
        value = _of_sliding(quantity, numbers.arrays(values), mu)
    else:
        value = numbers.arrays(values)[quantity]
    results = [ca.cse(ca.densify(value))]
    return ca.Function(quantity, [state, parameters], results, ["state", "parameters"], [quantity])


def _of_system(mechanism: Mechanism, attribute: str, x: list[ca.SX]) -> ca.SX:
    """Return a formula of the Lagrangian system, which may be a matrix."""
    import casadi as ca

    from painleve_sym.codegen.bridge import Translator

    formula = getattr(mechanism.system, attribute)
    table = dict(zip(argument_symbols(mechanism), x, strict=True))
    rows, columns = getattr(formula, "shape", (1, 1))
    entries = list(formula) if hasattr(formula, "shape") else [formula]
    return ca.reshape(Translator(table, floor=0.0).vector(entries), columns, rows).T


def _of_sliding(quantity: str, arrays: Mapping[str, ca.SX], mu: list[ca.SX]) -> ca.SX:
    """Return A = W_nn − μ e·W_tn, B = b_n or μ_P = W_nn/|W_tn| of every contact.

    e is the direction of slip: A is nan where the contact does not slide.
    """
    import casadi as ca

    W, b, slips = arrays["W"], arrays["b"], arrays["slip_velocity"]
    n = len(mu)
    size = b.numel() // n
    values = []
    for i in range(n):
        normal, tangents = size * i, slice(size * i + 1, size * (i + 1))
        W_nn, W_tn = W[normal, normal], W[tangents, normal]
        if quantity == "B":
            values.append(b[normal])
        elif quantity == "mu_P":
            values.append(W_nn / ca.norm_2(W_tn))
        else:
            v = ca.vec(slips[i, :])
            values.append(W_nn - mu[i] * ca.dot(v, W_tn) / ca.norm_2(v))
    return ca.vertcat(*values)
