"""Dry-friction contact where rigid-body theory has no solution, or several.

The names that people need first, loaded when first used, so that importing the package stays quick.
`models` and `laws` hold the named mechanisms and contact laws as functions; the other names stand
in folders such as `painleve_sym.study`, each with a list of its own.
"""

from functools import partial
from importlib import import_module
from typing import Any

from painleve_sym.doors import door
from painleve_sym.hooks import register
from painleve_sym.version import __version__ as __version__

_UPPER = {
    "animate": ("present.animation", "animated"),
    "casadi_equations": ("codegen.mode_equations", "casadi_equations"),
    "explore": ("explorer.page", "explore_motion"),
    "html": ("present.notebook", "html"),
    "lambdified_equations": ("codegen.mode_equations", "lambdified_equations"),
    "mechanism_from_sympy": ("mechanics.imported", "mechanism_from_sympy"),
    "plot": ("present.figure_of_quantities", "motion_figure"),
    "plot_map": ("present.figure_of_map", "map_figure"),
    "quantity_function": ("at.casadi_functions", "quantity_function"),
    "sensitivities": ("motion.sensitivity.variational", "differentiated"),
}
"""Functions to which methods of lower stages hand their work; see `hooks`."""


def _load(home: str, name: str) -> Any:
    return getattr(import_module(f"painleve_sym.{home}"), name)


for _method, _place in _UPPER.items():
    register(_method, partial(_load, *_place))

__all__, __getattr__, __dir__ = door(__name__)
