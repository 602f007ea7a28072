"""C files that stand alone: generated functions, the event loop and an interface around them."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from string import Template
from typing import Any

from painleve_sym.codegen.compile import FLAGS
from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.engines.source import source
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.engines.taylor.source import source as taylor_source
from painleve_sym.hybrid.automaton import HybridAutomaton

_LIBRARY_ONLY = ("-fPIC", "-shared", "-fvisibility=hidden")

NUMERIC_FLAGS = tuple(flag for flag in FLAGS if flag not in _LIBRARY_ONLY)
"""The package's flags that decide the numbers; the others only make a library of the code."""


def filled(template: str, values: Mapping[str, Any]) -> str:
    """Return the named template (a file in ``templates``) with `values` inserted."""
    folder = resources.files(__package__).joinpath("templates")
    text = Template(folder.joinpath(template).read_text("utf-8")).substitute(values)
    return "\n".join(line.rstrip() for line in text.split("\n")).rstrip() + "\n"


def engine_text(automaton: HybridAutomaton, engine: str) -> str:
    """Return what the package compiles for the automaton, to be put into another C file."""
    write = taylor_source if engine == TaylorEngine.name else source
    return write(AutomatonFunctions(automaton))
