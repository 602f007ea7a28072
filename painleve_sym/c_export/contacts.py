"""The rigid contact problem of an export: mobility, free accelerations, A and B, the case."""

from __future__ import annotations

from typing import Any

import casadi as ca

from painleve_sym.at.delassus import Delassus
from painleve_sym.codegen.c_functions import c_functions
from painleve_sym.contact_rows import ContactRows
from painleve_sym.engines.c_texts import engine_texts
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.problem import law
from painleve_sym.problem.complementarity.solution_sets import RANK
from painleve_sym.problem.families import RANGE
from painleve_sym.problem.solution import ContactCase

_OF_SEVERAL = (ContactCase.UNIQUE, ContactCase.UNKNOWN, ContactCase.ONE_KNOWN)
CASES = tuple(case for case in ContactCase if case not in _OF_SEVERAL)
"""What a single contact may be, in the order of the enum of an export."""

TOLERANCES = {
    "rounding": law.ROUNDING,
    "zero": law.ZERO,
    "sign": law.SIGN,
    "equal": law.EQUAL,
    "least_of_larger": law.LEAST_OF_LARGER,
    "infinite": law.INFINITE,
    "epsilon": law.EPSILON,
    "rank_one": 2 * RANK,  # two rows
    "range": RANGE,
}
"""The tolerances of the law, which an export has too."""

_EACH = ("slip_velocity", "A_stick", "B_stick")


def contact_values(mechanism: Mechanism, macros: str) -> dict[str, Any]:
    """Return what the template ``contact.c`` says of a mechanism, besides names of states.

    `macros` begins the names of macros.
    """
    function = _function(mechanism)
    outline = mechanism.outline
    names = [p.name for p in outline.parameters]
    return {
        "rows": engine_texts("loop/rows")[0],
        "functions": c_functions([function]),
        "work": 1 + function.sz_w(),
        "motion": len(outline.state_names),
        "own": len(names),
        **_friction(mechanism, names, macros),
        "sides": ", ".join(str(len(c.sides)) for c in outline.contacts),
        **{name: repr(value) for name, value in TOLERANCES.items()},
    }


def _friction(mechanism: Mechanism, names: list[str], macros: str) -> dict[str, str]:
    """Return what the template says of friction: parameters, or numbers that are generated, too."""
    outline = mechanism.outline
    if outline.has_curves:
        return {
            "own_friction": "FRICTION, ",
            "of_friction": "Of each contact ",
            "friction": "",
            "each_friction": "all[FIRST + EACH * i + FRICTION]",
            "contact_friction": "own[FRICTION]",
        }
    places = ", ".join(str(names.index(c.friction)) for c in outline.contacts)
    return {
        "own_friction": "",
        "of_friction": "The parameter that is the friction coefficient of a contact; ",
        "friction": f"static const int FRICTION[{macros}_CONTACTS] = {{{places}}};\n",
        "each_friction": "p[FRICTION[i]]",
        "contact_friction": "p[FRICTION[contact]]",
    }


def _function(mechanism: Mechanism) -> ca.Function:
    """Return W row by row, b, and slip velocity, A′ and B′ of each contact as one function."""
    numbers = Delassus.of(mechanism).contact_quantities
    x, n = ca.SX.sym("x", len(numbers.arguments)), len(mechanism.outline.contacts)
    values = dict(zip(numbers.names, ca.vertsplit(numbers.function(x)), strict=True))
    each: tuple[str, ...] = _EACH
    if mechanism.outline.has_curves:
        each = (*each, "friction")
        arguments = dict(zip(numbers.arguments, ca.vertsplit(x), strict=True))
        own = Delassus.of(mechanism).friction_of(arguments)
        values |= {f"friction_{i}": mu for i, mu in enumerate(own)}
    rows = range(ContactRows(n).size)
    names = [f"W_{r}_{c}" for r in rows for c in rows] + [f"b_{r}" for r in rows]
    names += [f"{name}_{i}" for i in range(n) for name in each]
    return ca.Function(
        "contact_formulas", [x], [ca.densify(ca.vertcat(*(values[name] for name in names)))]
    )
