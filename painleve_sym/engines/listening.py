"""Python functions that compiled code calls while it runs."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.engines.protocol import Listener

CALLBACK = ctypes.CFUNCTYPE(None, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
"""A `ps_listener`."""


@contextmanager
def listening(listener: Listener, size: int) -> Iterator[Any]:
    """Give a `ps_listener` that calls the listener with a view of the state, of shape (size,).

    What the listener raises cannot pass through C; it is raised at the end.
    """
    faults: list[BaseException] = []
    none = np.empty(0)

    def hear(kind: int, numbers: int, state: int | None) -> None:
        if faults:
            return
        try:
            after: Array = none
            if state:
                after = np.ctypeslib.as_array((ctypes.c_double * size).from_address(state))
            listener(kind, numbers, after)
        except BaseException as fault:
            faults.append(fault)

    callback = CALLBACK(hear)
    yield ctypes.cast(callback, ctypes.c_void_p)
    if faults:
        raise faults[0]
