"""Chunks of a sweep on a Dask cluster: the same file, the same numbers."""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterator, Sequence
from typing import Any

from painleve_sym.errors import InputError, PainleveError
from painleve_sym.study.sweep import Sweep, sweep_of_texts

LOCAL = "local"
CONNECT_SECONDS = 20
# Of the status page; None would mean port 8787, which another cluster of this machine may have.
ANY_PORT = "127.0.0.1:0"


def compute_part(
    text: str, where: str, mechanism_text: str | None, start: int, stop: int
) -> dict[str, Any]:
    """Return the points start..stop − 1 of the sweep of a text; what a worker runs."""
    return dict(sweep_of_texts(text, where, mechanism_text).compute(start, stop, threads=1))


def check_dask() -> Any:
    """Return the module dask.distributed; InputError where it is not installed."""
    try:
        return importlib.import_module("dask.distributed")
    except ImportError as error:
        raise InputError(
            "--cluster: it needs dask.distributed. Fix: pip install 'painleve-sym[sweep]'."
        ) from error


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
        dask.distributed is not installed.
    PainleveError
        The scheduler cannot be reached, or was lost.
    """
    distributed = check_dask()
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

    # Some chunks wait at the cluster, not all: the results held there stay few.
    ahead = 2 * sum(client.nthreads().values()) + 2
    running = as_completed([f for f in (submit() for _ in range(ahead)) if f is not None])
    for future in running:
        try:
            chunk = future.result()
        except (InputError, MemoryError):
            raise
        except Exception as error:  # whatever a worker or the connection raised
            raise PainleveError(f"--cluster {address}: {type(error).__name__}: {error}") from error
        yield started.pop(future.key), chunk
        following = submit()
        if following is not None:
            running.add(following)
