"""The rigid contact problem of an export: mobility, free accelerations, A and B, the case."""

from __future__ import annotations

from typing import Any

import casadi as ca

from painleve_sym.codegen.c_functions import c_functions
from painleve_sym.contact_rows import ContactRows
from painleve_sym.contacts.contact_numbers import contact_numbers, couplings
from painleve_sym.contacts.problem import ROUNDING, ContactCase
from painleve_sym.engines.source import engine_texts
from painleve_sym.mechanics.mechanism import Mechanism

CASES = tuple(case for case in ContactCase if case is not ContactCase.HYPERSTATIC)
"""What a single contact may be, in the order of the enum of an export."""

_EACH = ("slip_velocity", "A_stick", "B_stick")


def contact_values(mechanism: Mechanism) -> dict[str, Any]:
    """Return what the template ``contact.c`` says of a mechanism, besides names of states."""
    function = _function(mechanism)
    names = [p.name for p in mechanism.system.parameters]
    friction = [names.index(c.friction.name) for c in mechanism.contacts]
    return {
        "rows": engine_texts("loop/rows")[0],
        "functions": c_functions([function]),
        "work": 1 + function.sz_w(),
        "motion": len(mechanism.motion),
        "own": len(names),
        "friction": ", ".join(map(str, friction)),
        "bilateral": ", ".join(str(int(c.bilateral)) for c in mechanism.contacts),
        "rounding": repr(ROUNDING),
    }


def _function(mechanism: Mechanism) -> ca.Function:
    """Return W row by row, b, and slip velocity, A′ and B′ of each contact as one function."""
    n = len(mechanism.contacts)
    numbers = [contact_numbers(mechanism, i) for i in range(n)]
    x = ca.SX.sym("x", len(numbers[0].arguments))
    rows = []
    at = ContactRows(n)
    W = ca.SX.zeros(at.size, at.size)
    for i, own in enumerate(numbers):
        values = dict(zip(own.names, ca.vertsplit(own.function(x)), strict=True))
        rows.append(values)
        n_row, t_row = at.normal(i), at.tangent(i)
        W[n_row, n_row], W[t_row, t_row] = values["W_nn"], values["W_tt"]
        W[n_row, t_row] = W[t_row, n_row] = values["W_nt"]
    if n > 1:
        between = couplings(mechanism)
        entries = ca.vertsplit(between.function(x))
        for name, entry in zip(between.names, entries, strict=True):
            row, column = map(int, name.split("_")[1:])
            W[row, column] = W[column, row] = entry
    b = [row[name] for row in rows for name in ("b_n", "b_t")]
    each = [row[name] for row in rows for name in _EACH]
    # CasADi stores by columns; W is symmetric.
    return ca.Function("contact_formulas", [x], [ca.densify(ca.vertcat(ca.vec(W), *b, *each))])
