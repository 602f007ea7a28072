"""Runs a sweep chunk by chunk: each is written as it is finished, and never computed twice."""

from __future__ import annotations

import json
import shutil
import sys
import time
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import scipy
from numpy.typing import NDArray

import painleve_sym
from painleve_sym.codegen.compile import FLAGS, find_compiler
from painleve_sym.errors import CompilerMissing, InputError, PainleveError
from painleve_sym.files import write_beside
from painleve_sym.mechanics.definition import SYMPY_VERSION
from painleve_sym.simulate.batch.memory import check_memory
from painleve_sym.study.sweeps.lock import FolderLock
from painleve_sym.study.sweeps.sweep import Sweep

FORMAT = "painleve-sym sweep 1"
MANIFEST = "manifest.json"

Chunk = dict[str, NDArray[Any]]
Progress = Callable[[int, int], None]
"""Called with the points done and the points in all."""


def provenance(sweep: Sweep) -> dict[str, str]:
    """Return what decides the numbers: versions, compiler, flags, cache key of the engine."""
    found = {
        "painleve_sym": painleve_sym.__version__,
        "python": ".".join(map(str, sys.version_info[:3])),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "sympy": SYMPY_VERSION,
        "casadi": ca.CasadiMeta.version(),
        "engine": sweep.simulator.integrator.name,
    }
    library = getattr(sweep.simulator.integrator, "library", None)
    if library is not None:
        found["cache_key"] = Path(library).stem
        found["flags"] = " ".join(FLAGS)
        try:
            found["compiler"] = find_compiler().version
        except CompilerMissing:
            found["compiler"] = "none here; the engine came from the cache"
    return found


def parts_folder(out: Path) -> Path:
    """Return the folder of the finished chunks of a result file."""
    return out.with_name(out.name + ".parts")


@dataclass(frozen=True)
class Parts:
    """The folder of a sweep's finished chunks, beside the file it will become.

    Attributes
    ----------
    folder : Path
    sweep : Sweep
    lock : FolderLock
        Keeps other processes out.
    """

    folder: Path
    sweep: Sweep
    lock: FolderLock

    @classmethod
    def beside(cls, out: Path, sweep: Sweep) -> Parts:
        """Return the folder for the result file `out`, made or taken up again.

        Raises
        ------
        InputError
            It holds chunks of another sweep or of another build, another process is at it, or it
            cannot be written.
        """
        folder = parts_folder(out)
        mark = {"format": FORMAT, "sweep": sweep.fingerprint, "provenance": provenance(sweep)}
        try:
            folder.mkdir(exist_ok=True)
            parts = cls(folder, sweep, FolderLock(folder))
            if not (folder / MANIFEST).exists():
                content = json.dumps(mark, indent=2) + "\n"
                write_beside(folder / MANIFEST, lambda f: f.write(content.encode()))
            found = json.loads((folder / MANIFEST).read_bytes())
        except (OSError, json.JSONDecodeError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or error
            raise InputError(
                f"sweep folder {folder}: {reason}. Fix: give another --out, or remove the folder."
            ) from error
        parts._check(found, mark)
        parts.clear()
        return parts

    def clear(self) -> None:
        """Remove what an interrupted writing left; finished chunks stay."""
        for left in self.folder.glob(".chunk-*"):
            left.unlink(missing_ok=True)
        shutil.rmtree(self.unfinished, ignore_errors=True)

    @property
    def unfinished(self) -> Path:
        """Folder in which the result is written, before it takes its place."""
        return self.folder / "result"

    def _check(self, found: Any, mark: dict[str, Any]) -> None:
        if not isinstance(found, dict) or found.get("format") != FORMAT:
            raise InputError(
                f"sweep folder {self.folder}: not one of a sweep. Fix: give another --out."
            )
        if found.get("sweep") != mark["sweep"]:
            raise InputError(
                f"sweep folder {self.folder}: it holds chunks of another sweep, or of this file "
                "before it was changed. Fix: give another --out, or remove the folder."
            )
        if found.get("provenance") != mark["provenance"]:
            old, new = found.get("provenance") or {}, mark["provenance"]
            what = sorted(k for k in {*old, *new} if old.get(k) != new.get(k))
            raise InputError(
                f"sweep folder {self.folder}: it was begun with another {', '.join(what)}, and "
                "one result must not mix numbers of two. Fix: resume with that, or remove the "
                "folder."
            )

    def path(self, start: int) -> Path:
        """Return the file of the chunk that begins at a point."""
        return self.folder / f"chunk-{start:012d}.npz"

    def read(self, start: int, name: str) -> NDArray[Any]:
        """Return one quantity of a chunk."""
        with np.load(self.path(start), allow_pickle=False) as data:
            return np.asarray(data[name])

    def write(self, start: int, chunk: Chunk) -> None:
        """Write a chunk, whole or not at all."""
        arrays: dict[str, Any] = dict(chunk)
        write_beside(self.path(start), lambda f: np.savez(f, **arrays))

    def missing(self) -> list[int]:
        """Return where the chunks begin that are not written; a damaged one counts as missing."""
        present = {p.name for p in self.folder.glob("chunk-*.npz")}
        return [s for s in self.sweep.starts if not self._is_whole(s, present)]

    def _is_whole(self, start: int, present: set[str]) -> bool:
        path = self.path(start)
        if path.name not in present:
            return False
        try:
            with zipfile.ZipFile(path) as file:
                return set(file.namelist()) == {f"{n}.npy" for n in self.sweep.kept}
        except (OSError, zipfile.BadZipFile):
            return False

    def remove(self) -> None:
        """Remove the folder: the result is written."""
        shutil.rmtree(self.folder)
        self.lock.release()


def check_room(sweep: Sweep, out: Path) -> None:
    """Raise InputError where disk or memory cannot hold the result.

    One quantity of all points is in memory at a time; chunks and result are on disk together.
    """
    points, where = sweep.space.points, sweep.scenario.where
    widths = [sweep.width(name) for name in sweep.kept]
    fix = "fewer points, fewer events, or fewer names in keep"
    check_memory(where, f"{points:,} points", 3 * 8 * points * max(widths), fix)
    need = 2 * 8 * points * (sum(widths) + len(sweep.space.names))
    need -= sum(p.stat().st_size for p in parts_folder(out).glob("chunk-*.npz"))
    free = shutil.disk_usage(out.parent).free
    if need > free:
        raise InputError(
            f"{where}: {points:,} points need {need / 1e9:.3g} GB of disk {out.parent}, "
            f"there are {free / 1e9:.3g} GB. Fix: {fix}."
        )


def finished_chunks(
    sweep: Sweep, starts: Sequence[int], threads: int | None
) -> Iterator[tuple[int, Chunk]]:
    """Yield the chunks that begin at `starts`, computed in this process."""
    for start in starts:
        stop = min(start + sweep.chunk, sweep.space.points)
        yield start, sweep.compute(start, stop, threads)


def run_sweep(
    sweep: Sweep,
    out: Path,
    *,
    threads: int | None = None,
    cluster: str | None = None,
    progress: Progress = lambda done, points: None,
) -> Parts:
    """Compute every chunk that is not written yet and write it; return them.

    Parameters
    ----------
    sweep : Sweep
    out : Path
        The result file; chunks are written to the folder ``OUT.parts`` beside it.
    threads : int, optional
        Of this process.
    cluster : str, optional
        Address of a Dask scheduler, or ``local``.
    progress : callable

    Raises
    ------
    InputError
        Before anything runs: bad input, no room, a folder of another sweep.
    PainleveError
        A full disk, a cluster that cannot be reached or was lost: what is written stays, and the
        same call resumes.
    """
    if cluster is not None:
        from painleve_sym.study.sweeps.dask_backend import check_cluster

        check_cluster(cluster)
    check_room(sweep, out)
    sweep.check_run()
    parts = Parts.beside(out, sweep)
    missing, points = parts.missing(), sweep.space.points
    done = points - sum(min(s + sweep.chunk, points) - s for s in missing)
    progress(done, points)
    if missing:
        if cluster is None:
            chunks = finished_chunks(sweep, missing, threads)
        else:
            from painleve_sym.study.sweeps.dask_backend import chunks_on_dask

            chunks = chunks_on_dask(sweep, missing, cluster)
        _write_all(parts, chunks, done, progress)
    return parts


def _write_all(
    parts: Parts, chunks: Iterator[tuple[int, Chunk]], done: int, progress: Progress
) -> None:
    points = parts.sweep.space.points
    try:
        for start, chunk in chunks:
            parts.write(start, chunk)
            done += len(chunk["stop_reason"])
            progress(done, points)
    except (OSError, MemoryError, PainleveError) as error:
        reason = getattr(error, "strerror", None) or str(error) or "no memory"
        raise PainleveError(
            f"sweep {parts.sweep.scenario.where}: {reason.rstrip('.')}. {done:,} of {points:,} "
            f"points are written to {parts.folder}. Fix: remove the cause and give the same "
            "command again; it goes on from there."
        ) from error


class Reporter:
    """Shows points done, their rate and the time left, on one line of a stream.

    Parameters
    ----------
    stream : text stream
    clock : callable
        Returns seconds.
    """

    def __init__(self, stream: Any, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream, self._clock = stream, clock
        self._begun: tuple[float, int] | None = None
        self._shown = -float("inf")
        self._live = bool(getattr(stream, "isatty", lambda: False)())

    def __call__(self, done: int, points: int) -> None:
        """Show the progress, at most once a second, or every ten where it is no terminal."""
        now = self._clock()
        if self._begun is None:
            self._begun = (now, done)
        if done < points and now - self._shown < (1 if self._live else 10):
            return
        self._shown = now
        begun, before = self._begun
        rate = (done - before) / (now - begun) if now > begun else 0.0
        text = f"painleve: {done:,} of {points:,} points"
        if rate > 0:
            text += f", {rate:,.0f} per second"
            text += f", {_duration((points - done) / rate)} left" if done < points else ""
        end = "\r" if self._live and done < points else "\n"
        self._stream.write(text.ljust(78 if self._live else 0) + end)
        self._stream.flush()


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
