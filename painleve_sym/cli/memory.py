"""The memory that the numerical libraries need at least."""

from __future__ import annotations

import os

LIBRARIES = 600_000_000
"""Bytes of address space that the libraries take."""
_EACH_PROCESSOR = 50_000_000
_MAX_PROCESSORS = 16


def require_address_space() -> None:
    """Raise MemoryError where a limit of the process leaves too little for the libraries.

    Below it, OpenBLAS asks for memory without end while it is loaded.
    """
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    need = LIBRARIES + _EACH_PROCESSOR * min(os.cpu_count() or 1, _MAX_PROCESSORS)
    if limit not in (resource.RLIM_INFINITY, -1) and limit < need:
        raise MemoryError(
            f"the limit of the address space (ulimit -v) is {limit // 1024} kB, need "
            f"{need // 1024} kB or more. Fix: raise the limit, or leave it out."
        )
