"""C files that stand alone: generated functions, the event loop and an interface around them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import resources
from string import Template
from typing import Any

import casadi as ca

from painleve_sym.codegen.bridge import Translator
from painleve_sym.codegen.c_functions import c_functions
from painleve_sym.codegen.compile import FLAGS
from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.codegen.quantities import Quantities
from painleve_sym.engines.source import source
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.engines.taylor.source import source as taylor_source
from painleve_sym.hybrid.automaton import HybridAutomaton

_LIBRARY_ONLY = ("-fPIC", "-shared", "-fvisibility=hidden")

NUMERIC_FLAGS = tuple(flag for flag in FLAGS if flag not in _LIBRARY_ONLY)
"""The package's flags that decide the numbers; the others only make a library of the code."""


def filled(template: str, values: Mapping[str, Any]) -> str:
    """Return the named template (a file in ``templates``) with `values` put in."""
    folder = resources.files(__package__).joinpath("templates")
    text = Template(folder.joinpath(template).read_text("utf-8")).substitute(values)
    return "\n".join(line.rstrip() for line in text.split("\n")).rstrip() + "\n"


def engine_text(automaton: HybridAutomaton, engine: str) -> str:
    """Return what the package compiles for the automaton, to be put into another C file.

    Parameters
    ----------
    automaton : HybridAutomaton
    engine : {"taylor", "compiled"}
    """
    write = taylor_source if engine == TaylorEngine.name else source
    return write(AutomatonFunctions(automaton))


def start_functions(
    numbers: Sequence[Quantities], automaton: HybridAutomaton, loading: Sequence[Any]
) -> tuple[str, int]:
    """Return the C functions ``quantities`` and ``loading``, and the size of their work space.

    Parameters
    ----------
    numbers : sequence of Quantities
        The numbers of each contact, see `contact_numbers`.
    automaton : HybridAutomaton
    loading : sequence of sympy.Expr
        Stiffness and exponent of each contact in parameters and definitions, which the function
        ``loading`` takes in this order.
    """
    functions = [numbers[0].function]
    if len(numbers) > 1:
        x = ca.SX.sym("x", len(numbers[0].arguments))
        functions = [
            ca.Function("quantities", [x], [ca.vertcat(*(f.function(x) for f in numbers))])
        ]
    constants = (*automaton.parameters, *automaton.definitions)
    c = ca.SX.sym("c", len(constants))
    translate = Translator({s: c[i] for i, s in enumerate(constants)}, floor=0.0)
    functions.append(ca.Function("loading", [c], [ca.densify(translate.vector(list(loading)))]))
    return c_functions(functions), 1 + max(f.sz_w() for f in functions)
