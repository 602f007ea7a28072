"""Variants of modes whose local modes are data, each made when a run first enters it."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

_MAKE = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
_ADDING = threading.Lock()

Compiled = Callable[[int, Sequence[float]], Path]


class Entered:
    """Callback of a library whose run enters a memory for which it has no variant.

    `compiled` returns the library of the variant of a mode, by its index, for a memory of that
    length. What it raises cannot pass through C; it is raised when the run has ended.
    """

    def __init__(self, library: Any, length: int, compiled: Compiled) -> None:
        self._library, self._length, self._compiled = library, length, compiled
        library.ps_add_variant.argtypes = (ctypes.c_void_p,)
        self._lock = threading.Lock()
        self._loaded: dict[Path, tuple[ctypes.CDLL, int]] = {}
        self._faults = threading.local()
        self._callback = _MAKE(self._enter)
        self.address = ctypes.cast(self._callback, ctypes.c_void_p)

    def _enter(self, mode: int, memory: int) -> int | None:
        try:
            values = (ctypes.c_double * self._length).from_address(memory)
            with self._lock:
                return self._variant(self._compiled(mode, tuple(values)))
        except BaseException as fault:
            self._faults.all.append(fault)
            return None

    def _variant(self, path: Path) -> int:
        if path not in self._loaded:
            library = ctypes.CDLL(str(path))
            address = ctypes.addressof(ctypes.c_char.in_dll(library, "ps_own_variant"))
            with _ADDING:
                if not self._library.ps_add_variant(address):
                    raise MemoryError("no memory for a variant of the contacts' motion.")
            self._loaded[path] = library, address
        return self._loaded[path][1]

    @contextmanager
    def raising(self) -> Iterator[None]:
        """Raise at the end what failed where a variant was made in this thread."""
        faults = self._faults.all = list[BaseException]()
        yield
        if faults:
            raise faults[0]


@contextmanager
def entering(entered: Entered | None, options: Any) -> Iterator[None]:
    """Let a run with these options in C make variants, where it has any."""
    if entered is None:
        yield
        return
    options.make = entered.address
    with entered.raising():
        yield
