"""Memory and processors of the machine, and the memory that a batch takes."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import fields
from pathlib import Path

from painleve_sym.engines.batch import BatchOutputs, BatchRows
from painleve_sym.errors import InputError
from painleve_sym.motion.simulator import Simulator

_ALWAYS = 2**20
"""Bytes that are there: to ask costs more than a short batch."""


def available_memory() -> int | None:
    """Return the bytes that can be had without swapping; where unknown, all there are, else None.

    Linux tells both; macOS only how much there is; another system may tell neither.
    """
    try:
        for line in Path("/proc/meminfo").read_text("ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    for pages in ("SC_AVPHYS_PAGES", "SC_PHYS_PAGES"):
        with suppress(OSError, ValueError):
            if (count := os.sysconf(pages)) > 0:
                return count * os.sysconf("SC_PAGE_SIZE")
    return None


def processor_count() -> int:
    """Return how many processors this process may use; where unknown, how many there are."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def row_bytes(simulator: Simulator, kept: BatchOutputs) -> int:
    """Return the bytes that a batch keeps of one motion."""
    row = BatchRows.empty(1, simulator.outline, kept)
    return sum(int(getattr(row, f.name).nbytes) for f in fields(row))


def check_memory(where: str, subject: str, need: int, fix: str) -> None:
    """Raise InputError where memory is short of the `need` bytes of `subject`."""
    if need <= _ALWAYS:
        return
    have = available_memory()
    if have is not None and need > have:
        raise InputError(
            f"{where}: {subject} need {need / 1e9:.3g} GB of memory, there are "
            f"{have / 1e9:.3g} GB. Fix: {fix}."
        )
