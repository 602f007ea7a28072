"""One thread of the linear algebra in small problems: those of more only wait for each other."""

from __future__ import annotations

import ctypes
import importlib.util
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

UNTHREADED = 8
"""Rows of a problem up to which no library uses several threads."""
_PACKAGES = ("numpy", "scipy")
_lock = threading.Lock()
_within = 0
_before: list[tuple[Callable[[int], None], int]] = []


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let OpenBLAS of NumPy and SciPy use one thread in this context, whoever is inside of it.

    A problem of twelve unknowns takes ten times as long on several: they spin while they wait. What
    was set before holds again when the last one leaves. Of another library nothing is known, and
    nothing is changed.
    """
    global _within
    with _lock:
        if not _within:
            loaded = [name for name in _PACKAGES if name in sys.modules]
            for ask, tell in filter(None, map(_library, loaded)):
                _before.append((tell, ask()))
                tell(1)
        _within += 1
    try:
        yield
    finally:
        with _lock:
            _within -= 1
            while not _within and _before:
                tell, threads = _before.pop()
                tell(threads)


@cache
def _library(package: str) -> tuple[Callable[[], int], Callable[[int], None]] | None:
    """Return the functions that ask for and set the threads of a package's own OpenBLAS."""
    place = importlib.util.find_spec(package)
    if place is None or place.origin is None:
        return None
    beside = Path(place.origin).parents[1] / f"{package}.libs"
    for path in sorted(beside.glob("*openblas*")):
        library = ctypes.CDLL(str(path))  # the one that is loaded
        for suffix in ("64_", ""):
            names = (f"scipy_openblas_{verb}_num_threads{suffix}" for verb in ("get", "set"))
            functions: list[Any] = [getattr(library, name, None) for name in names]
            if all(functions):
                return functions[0], functions[1]
    return None
