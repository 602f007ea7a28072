"""Functions of upper stages to which methods of lower ones hand their work.

A stage imports nothing that stands above it. `Trajectory.plot` asks here for the function that
draws; the package itself, which stands above all stages, says where each function is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_loaders: dict[str, Callable[[], Any]] = {}


def register(name: str, load: Callable[[], Any]) -> None:
    """Let `upper` find a function; `load` returns it when it is first needed."""
    _loaders[name] = load


def upper(name: str) -> Any:
    """Return the function that an upper stage has for a method, such as ``plot``."""
    return _loaders[name]()
