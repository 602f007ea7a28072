"""Memory estimates for batches."""

from __future__ import annotations

import os
from dataclasses import fields
from pathlib import Path

from painleve_sym.engines.batch import BatchOutputs, BatchRows
from painleve_sym.errors import InputError
from painleve_sym.motion.simulator import Simulator


def available_memory() -> int:
    """Return the bytes that can be had without swapping."""
    try:
        for line in Path("/proc/meminfo").read_text("ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def row_bytes(simulator: Simulator, kept: BatchOutputs) -> int:
    """Return the bytes that a batch keeps of one motion."""
    row = BatchRows.empty(1, simulator.outline, kept)
    return sum(int(getattr(row, f.name).nbytes) for f in fields(row))


def check_memory(where: str, subject: str, need: int, fix: str) -> None:
    """Raise InputError where there is no memory for `subject`, which needs `need` bytes."""
    have = available_memory()
    if need > have:
        raise InputError(
            f"{where}: {subject} need {need / 1e9:.3g} GB of memory, there are "
            f"{have / 1e9:.3g} GB. Fix: {fix}."
        )
