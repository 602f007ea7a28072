"""A function of CasADi as a list of elementary operations, which any arithmetic can follow."""

from __future__ import annotations

from typing import Any

import casadi as ca

from painleve_sym.errors import InputError

Step = tuple[str, int, tuple[Any, ...]]
"""Operation, place of its result, and places of what it takes; of a constant its value."""

_NAMES = {
    getattr(ca, f"OP_{name.upper()}"): name
    for name in (
        *("assign", "add", "sub", "mul", "div", "neg", "sq", "twice", "inv", "sqrt"),
        *("sin", "cos", "pow", "constpow", "const", "input", "output"),
    )
}


def program_of(function: ca.Function) -> list[Step]:
    """Return the steps of a function of one vector, in order.

    An input step takes the index of an entry, an output step has the index of a result as place.

    Raises
    ------
    InputError
        An operation whose range is not known.
    """
    steps: list[Step] = []
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        name = _NAMES.get(code)
        if name is None:
            raise InputError(
                "certify: the formulas have an operation other than sums, products, quotients, "
                "powers, roots, sine and cosine. Fix: choose a model without it."
            )
        inputs, outputs = function.instruction_input(k), function.instruction_output(k)
        if name == "const":
            value = float(function.instruction_constant(k))
            steps.append((name, outputs[0], (value.hex(),)))
        elif name == "input":
            steps.append((name, outputs[0], (inputs[1],)))
        elif name == "output":
            steps.append((name, outputs[1], tuple(inputs)))
        else:
            steps.append((name, outputs[0], tuple(inputs)))
    return steps
