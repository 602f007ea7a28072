"""Chunks of a sweep on a Dask cluster: the same file, the same numbers."""

from __future__ import annotations

import functools
import importlib
import logging
import warnings
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from typing import Any

from painleve_sym.errors import InputError, PainleveError, PainleveWarning
from painleve_sym.motion.batch.machine import processor_count
from painleve_sym.study.sweeps.sweep import Columns, Sweep

LOCAL = "local"
CONNECT_SECONDS = 20
# Of the status page; None would mean port 8787, which another cluster of this machine may have.
ANY_PORT = "127.0.0.1:0"


sweep_of_texts = functools.lru_cache(maxsize=4)(Sweep.from_text)
"""The sweep of its texts, built once per process."""


def compute_chunk(
    text: str, where: str, mechanism_text: str | None, start: int
) -> tuple[int, Columns]:
    """Return the chunk of a sweep that begins at a point, and this point; what a worker runs."""
    sweep = sweep_of_texts(text, where, mechanism_text)
    return start, sweep.compute(start, sweep.stop(start), threads=1)


def check_cluster(address: str) -> Any:
    """Return the module dask.distributed; InputError where that, or an address, is missing.

    Whether something answers at the address is not tried.
    """
    try:
        distributed: Any = importlib.import_module("dask.distributed")
        comm: Any = importlib.import_module("distributed.comm")
    except ImportError as error:
        raise InputError(
            "--cluster: it needs dask.distributed. Fix: pip install 'painleve-sym[cluster]'."
        ) from error
    try:
        scheme, _ = comm.parse_address(address)
        comm.registry.get_backend(scheme)
        if address != LOCAL and scheme != "inproc":  # a scheduler in this process has no port
            comm.get_address_host_port(address)
    except (ValueError, TypeError) as error:
        raise InputError(
            f"--cluster: got {address!r}, need the address of a Dask scheduler, such as "
            f"tcp://10.0.0.1:8786, or {LOCAL}."
        ) from error
    return distributed


def chunks_on_dask(
    sweep: Sweep, starts: Sequence[int], address: str
) -> Iterator[tuple[int, Columns]]:
    """Yield chunks as a cluster finishes them, in any order; `starts` are their first points.

    Workers get the sweep's text and point numbers, and return arrays: they share no files with this
    process. A chunk on a lost worker is computed by another. The address is that of the scheduler,
    such as ``tcp://10.0.0.1:8786``, or ``local``: one worker per processor of this machine.
    InputError as for `check_cluster`; PainleveError where the scheduler cannot be reached, or was
    lost.
    """
    distributed = check_cluster(address)
    # What is wrong is said once, by the error below, and not in lines and tracebacks of its own.
    for part in ("client", "nanny", "scheduler", "worker"):
        logging.getLogger(f"distributed.{part}").setLevel(logging.CRITICAL)
    with ExitStack() as stack:
        scheduler: Any = address
        if address == LOCAL:
            count = processor_count()
            scheduler = stack.enter_context(
                distributed.LocalCluster(
                    n_workers=count,
                    threads_per_worker=1,
                    dashboard_address=ANY_PORT,
                    silence_logs=logging.CRITICAL,
                )
            )
        try:
            client = distributed.Client(scheduler, timeout=CONNECT_SECONDS)
        except (OSError, TimeoutError, ValueError) as error:
            raise PainleveError(
                f"--cluster {address}: the scheduler cannot be reached ({error})"
            ) from error
        yield from _finished(stack.enter_context(client), sweep, starts, address)


def _finished(
    client: Any, sweep: Sweep, starts: Sequence[int], address: str
) -> Iterator[tuple[int, Columns]]:
    given = (sweep.text, sweep.scenario.where, sweep.mechanism_text)
    if not client.nthreads():
        warnings.warn(
            PainleveWarning(f"--cluster {address}: no workers there yet; waiting for them."),
            stacklevel=2,
        )
    running: Any = importlib.import_module("dask.distributed").as_completed(loop=client.loop)
    waiting = list(reversed(starts))
    while waiting or running.count():
        # Some chunks wait at the cluster, not all: the results held there stay few. Workers may
        # join later.
        ahead = 2 * sum(client.nthreads().values()) + 2
        while waiting and running.count() < ahead:
            running.add(client.submit(compute_chunk, *given, waiting.pop(), pure=False))
        try:
            chunk: tuple[int, Columns] = next(running).result()
        except (InputError, MemoryError):
            raise
        except Exception as error:  # whatever a worker or the connection raised
            reason = f"{type(error).__name__}: {error}"
            if "scheduler-connection-lost" in reason:
                reason = "the connection to the scheduler was lost"
            raise PainleveError(f"--cluster {address}: {reason}") from error
        yield chunk
