"""Chunks of a sweep on a Dask cluster: the same file, the same numbers."""

from __future__ import annotations

import importlib
import logging
import os
import warnings
from collections.abc import Iterator, Sequence
from typing import Any

from painleve_sym.errors import InputError, PainleveError, PainleveWarning
from painleve_sym.study.sweeps.sweep import Sweep, sweep_of_texts

LOCAL = "local"
CONNECT_SECONDS = 20
# Of the status page; None would mean port 8787, which another cluster of this machine may have.
ANY_PORT = "127.0.0.1:0"


def compute_part(
    text: str, where: str, mechanism_text: str | None, start: int, stop: int
) -> dict[str, Any]:
    """Return the points start..stop − 1 of the sweep of a text; what a worker runs."""
    return dict(sweep_of_texts(text, where, mechanism_text).compute(start, stop, threads=1))


def check_cluster(address: str) -> Any:
    """Return the module dask.distributed.

    Raises
    ------
    InputError
        It is not installed, or this is no address; whether something answers is not tried.
    """
    try:
        distributed: Any = importlib.import_module("dask.distributed")
        comm: Any = importlib.import_module("distributed.comm")
    except ImportError as error:
        raise InputError(
            "--cluster: it needs dask.distributed. Fix: pip install 'painleve-sym[sweep]'."
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
) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield chunks as a cluster finishes them, in any order.

    Workers get the sweep's text and point numbers, and return arrays: they share no files with
    this process. A chunk on a lost worker is computed by another.

    Parameters
    ----------
    sweep : Sweep
    starts : sequence of int
        First points of the chunks.
    address : str
        Of the scheduler, such as ``tcp://10.0.0.1:8786``; ``local``: one worker per processor
        of this machine.

    Raises
    ------
    InputError
        As for `check_cluster`.
    PainleveError
        The scheduler cannot be reached, or was lost.
    """
    distributed = check_cluster(address)
    # What is wrong is said once, by the error below, and not in tracebacks of its own threads.
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    cluster = None
    if address == LOCAL:
        count = len(os.sched_getaffinity(0))
        cluster = distributed.LocalCluster(
            n_workers=count, threads_per_worker=1, dashboard_address=ANY_PORT
        )
    try:
        try:
            client = distributed.Client(cluster or address, timeout=CONNECT_SECONDS)
        except (OSError, TimeoutError, ValueError) as error:
            raise PainleveError(
                f"--cluster {address}: the scheduler cannot be reached ({error})"
            ) from error
        with client:
            yield from _finished(client, sweep, starts, address)
    finally:
        if cluster is not None:
            cluster.close()


def _finished(
    client: Any, sweep: Sweep, starts: Sequence[int], address: str
) -> Iterator[tuple[int, dict[str, Any]]]:
    as_completed: Any = importlib.import_module("dask.distributed").as_completed
    given = (sweep.text, sweep.scenario.where, sweep.mechanism_text)
    started: dict[str, int] = {}
    waiting = iter(starts)

    def submit() -> Any:
        start = next(waiting, None)
        if start is None:
            return None
        stop = min(start + sweep.chunk, sweep.space.points)
        future = client.submit(compute_part, *given, start, stop, pure=False)
        started[future.key] = start
        return future

    def more() -> Iterator[Any]:
        # Some chunks wait at the cluster, not all: the results held there stay few. Workers may
        # join later.
        ahead = 2 * sum(client.nthreads().values()) + 2
        while len(started) < ahead and (future := submit()) is not None:
            yield future

    if not client.nthreads():
        warnings.warn(
            PainleveWarning(f"--cluster {address}: no workers there yet; waiting for them."),
            stacklevel=2,
        )
    running = as_completed(list(more()))
    for future in running:
        try:
            chunk = future.result()
        except (InputError, MemoryError):
            raise
        except Exception as error:  # whatever a worker or the connection raised
            reason = f"{type(error).__name__}: {error}"
            if "scheduler-connection-lost" in reason:
                reason = "the connection to the scheduler was lost"
            raise PainleveError(f"--cluster {address}: {reason}") from error
        yield started.pop(future.key), chunk
        running.update(list(more()))
