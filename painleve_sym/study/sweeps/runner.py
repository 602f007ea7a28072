"""Runs a sweep chunk by chunk: each is written as it is finished, and never computed twice."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

from painleve_sym.errors import InputError, PainleveError
from painleve_sym.progress import progress
from painleve_sym.study.sweeps.store import (
    Store,
    SweepSummary,
    check_format,
    open_store,
    parts_folder,
)
from painleve_sym.study.sweeps.sweep import Columns, Sweep


def sweep(
    source: str | Path, out: str | Path, *, threads: int | None = None, cluster: str | None = None
) -> SweepSummary:
    """Run or resume the sweep that a TOML file describes; see `run_sweep`.

    Parameters
    ----------
    source : path
        Of the sweep file.
    out : path
        The result: its suffix tells the format.
    threads, cluster
        As for `run_sweep`.

    Returns
    -------
    SweepSummary
        Points, axes, stop reasons, ranges of the quantities.

    Examples
    --------
    >>> import tempfile, painleve_sym as ps
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     summary = ps.sweep("examples/sweeps/table3_grid.toml", folder + "/table3.npz")
    >>> summary["mechanism"]
    'rod'
    """
    return run_sweep(Sweep.read(source), Path(out), threads=threads, cluster=cluster)


def run_sweep(
    sweep: Sweep, out: Path, *, threads: int | None = None, cluster: str | None = None
) -> SweepSummary:
    """Compute every chunk that is not written yet, write the result and return its summary.

    Until the result file is whole, everything is in the folder ``OUT.parts`` beside it. Threads are
    those of this process; the cluster is the address of a Dask scheduler, or ``local``. InputError,
    before anything runs, for bad input, no room, or a folder of another sweep. PainleveError for a
    full disk, and a cluster that cannot be reached or was lost: what is written stays, and the same
    call resumes.
    """
    check_format(out)
    if cluster is not None:
        from painleve_sym.study.sweeps.dask_backend import check_cluster

        check_cluster(cluster)
    row = sweep.check_run()
    check_room(sweep, out, row)
    with open_store(out, sweep, row) as store:
        _compute(store, threads, cluster)
        summary = store.summary()
        store.finish(out)
    return summary


def check_room(sweep: Sweep, out: Path, row: Columns) -> None:
    """Raise InputError where the disk cannot hold the store and the result at once."""
    points = sweep.space.points
    need = 2 * points * sum(column.nbytes for column in row.values())
    there = parts_folder(out).glob("*.npy")
    need -= sum(512 * path.stat().st_blocks for path in there)  # without holes
    free = shutil.disk_usage(out.parent).free
    if need > free:
        raise InputError(
            f"{sweep.scenario.where}: {points:,} points need {need / 1e9:.3g} GB of disk "
            f"{out.parent}, there are {free / 1e9:.3g} GB. Fix: fewer points, fewer events, or "
            "fewer names in keep."
        )


def _compute(store: Store, threads: int | None, cluster: str | None) -> None:
    sweep, missing, points = store.sweep, store.missing(), store.sweep.space.points
    done = points - sum(sweep.stop(s) - s for s in missing)
    if not missing:
        return
    chunks: Iterator[tuple[int, Columns]]
    if cluster is None:
        chunks = ((s, sweep.compute(s, sweep.stop(s), threads)) for s in missing)
    else:
        from painleve_sym.study.sweeps.dask_backend import chunks_on_dask

        chunks = chunks_on_dask(sweep, missing, cluster)
    try:
        with progress(f"sweep {sweep.scenario.where}", points, "points", done) as advance:
            for start, chunk in chunks:
                store.write(start, chunk)
                done += sweep.stop(start) - start
                advance(sweep.stop(start) - start)
    except (OSError, MemoryError, PainleveError) as error:
        reason = getattr(error, "strerror", None) or str(error) or "no memory"
        raise PainleveError(
            f"sweep {sweep.scenario.where}: {reason.rstrip('.')}. {done:,} of {points:,} "
            f"points are written to {store.folder}. Fix: remove the cause and give the same "
            "command again; it resumes there."
        ) from error
