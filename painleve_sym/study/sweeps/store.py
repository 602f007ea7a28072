"""The columns of a sweep on disk: written by region, resumed from, and made into one result."""

from __future__ import annotations

import errno
import functools
import importlib
import io
import json
import math
import os
import shutil
import socket
import stat
import sys
import warnings
import zlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from painleve_sym.codegen.compile import find_compiler, flags
from painleve_sym.errors import CompilerMissing, InputError, PainleveError, PainleveWarning
from painleve_sym.files import write_beside
from painleve_sym.motion.energy_balance import batch_notices, open_from
from painleve_sym.motion.pressed_start import batch_past_notices
from painleve_sym.motion.timetable import Timetable
from painleve_sym.study.sweeps.sweep import FORMATS, Columns, Sweep
from painleve_sym.system import is_own, open_no_link
from painleve_sym.version import __version__

FORMAT = "painleve-sym sweep 1"
MANIFEST = "manifest.json"
SUMS = "chunk-sums"
LOCK, _HOLDER = "lock", ".holder"
SUFFIXES = tuple(f".{form}" for form in FORMATS)
_PROVENANCE = "provenance_"
_NEEDS = {".nc": ("NetCDF", "h5netcdf"), ".zarr": ("Zarr", "zarr")}


# One key is a word of Python.
QuantityRange = TypedDict(
    "QuantityRange",
    {"unit": str, "from": float | None, "to": float | None, "missing": int},
)
"""Least and largest value of a quantity, None without any, and points without a value."""


class SweepSummary(TypedDict):
    """Counts and ranges of a sweep, as `painleve_sym.sweep` returns them.

    Attributes
    ----------
    title, mechanism, law : str
    points : int
    axes : dict of str to str
        Unit of each axis.
    stop_reasons : dict of str to int
        Number of motions that ended for each reason.
    quantities : dict of str to QuantityRange
        Unit, ``from``, ``to``, and the number of points without a value.
    open_balances : int
        Motions whose energy balance does not close.
    notices : list of str

    Examples
    --------
    >>> import tempfile, painleve_sym as ps
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     summary = ps.sweep("examples/sweeps/table3_grid.toml", folder + "/table3.npz")
    >>> summary["points"] == sum(summary["stop_reasons"].values())
    True
    """

    title: str
    mechanism: str
    law: str
    points: int
    axes: dict[str, str]
    stop_reasons: dict[str, int]
    quantities: dict[str, QuantityRange]
    open_balances: int
    notices: list[str]


def check_format(out: Path) -> None:
    """Raise InputError where the packages that write the file are missing."""
    if out.suffix.lower() not in _NEEDS:
        return
    name, package = _NEEDS[out.suffix.lower()]
    try:
        importlib.import_module(package)
        importlib.import_module("xarray")
    except ImportError as error:
        raise InputError(
            f"--out {out}: {name} needs xarray and {package}. "
            "Fix: pip install 'painleve-sym[cluster]', or name a file that ends in .npz."
        ) from error


# Read from a file of the package, which takes a millisecond and more.
_installed = functools.cache(version)


def attributes(sweep: Sweep) -> dict[str, str]:
    """Return the metadata of a result: title, the sweep's own text, provenance.

    The provenance decides the numbers: versions, compiler, flags, cache key of the engine.
    """
    engine = sweep.simulator.stepped.integrator
    versions = {
        "painleve_sym": __version__,
        "python": ".".join(map(str, sys.version_info[:3])),
        **{name: _installed(name) for name in ("numpy", "scipy", "sympy", "casadi")},
        "engine": engine.name,
    }
    if (library := getattr(engine, "library", None)) is not None:
        versions |= {"cache_key": Path(library).stem, "flags": " ".join(flags())}
        try:
            versions["compiler"] = find_compiler().version
        except CompilerMissing:
            versions["compiler"] = "none here; the engine came from the cache"
    own = {
        "format": FORMAT,
        "title": sweep.scenario.title,
        "sweep": sweep.text,
        "mechanism_file": sweep.mechanism_text or "",
        "mechanism": sweep.mechanism.name,
        "law": sweep.simulator.label,
        "law_choices": json.dumps(dict(sweep.simulator.choices)),
    }
    if sweep.scenario.inputs:
        # Files may change while the sweep does not.
        own["inputs"] = json.dumps(
            Timetable.of(sweep.simulator, (), sweep.scenario.inputs).to_data()
        )
    return own | {f"{_PROVENANCE}{k}": v for k, v in versions.items()}


def parts_folder(out: Path) -> Path:
    """Return the folder of the columns of a result that is not finished."""
    return out.with_name(out.name + ".parts")


@contextmanager
def open_store(out: Path, sweep: Sweep, row: Columns) -> Iterator[Store]:
    """Make the store of a result file, or take it up again, for this process alone.

    The store is the folder ``OUT.parts`` beside the result; `row` are the columns of one point.
    InputError where the folder belongs to another sweep or another build, another process writes to
    it, or it cannot be written.
    """
    folder = parts_folder(out)
    with ExitStack() as stack:
        try:
            folder.mkdir(exist_ok=True)
            _check_owner(folder)
            stack.enter_context(_locked(folder))
            store = Store(folder, sweep, _columns(folder, sweep, row))
        except (OSError, json.JSONDecodeError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or error
            raise InputError(
                f"sweep folder {folder}: {reason}. Fix: give another --out, or remove the folder."
            ) from error
        yield store


def _check_owner(folder: Path) -> None:
    """Raise InputError for a folder that another may have made, with links to other files in it."""
    info = folder.lstat()
    if stat.S_ISLNK(info.st_mode) or not is_own(info):
        fault = "it is a link" if stat.S_ISLNK(info.st_mode) else "it belongs to another user"
        raise InputError(f"sweep folder {folder}: {fault}. Fix: give another --out.")


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold a folder for this process; InputError where another process holds it."""
    from filelock import FileLock, Timeout

    lock, holder = FileLock(folder / LOCK, blocking=False), folder / _HOLDER
    try:
        lock.acquire()
    except Timeout:
        raise InputError(
            f"sweep folder {folder}: {_short_text(holder) or 'another process'} is writing to it. "
            "Fix: wait until it ends, or give another --out."
        ) from None
    except (OSError, NotImplementedError) as error:
        if isinstance(error, OSError) and error.errno == errno.ELOOP:
            raise
        message = (
            f"sweep folder {folder}: it cannot be locked ({error}). Fix: make sure that no other "
            "process writes to it."
        )
        warnings.warn(message, PainleveWarning, stacklevel=2)
        yield
        return
    with lock:
        write_beside(holder, lambda file: file.write(_this_process().encode()))
        yield


def _this_process() -> str:
    return f"process {os.getpid()} on {socket.gethostname()}"


def _short_text(path: Path) -> str:
    """Return the beginning of a file, or an empty text where it cannot be read."""
    with suppress(OSError), open(path, "rb", opener=open_no_link) as file:
        return file.read(200).decode("utf-8", "replace").strip()
    return ""


def _columns(folder: Path, sweep: Sweep, row: Columns) -> Columns:
    """Return the columns in a folder and the sums of their chunks, mapped to memory."""
    _check_manifest(folder, attributes(sweep))
    shapes = {n: ((sweep.space.points, *a.shape[1:]), a.dtype) for n, a in row.items()}
    shapes[SUMS] = ((len(sweep.starts),), np.dtype(np.int64))
    return {name: _mapped(folder / f"{name}.npy", *shape) for name, shape in shapes.items()}


def _check_manifest(folder: Path, new: dict[str, str]) -> None:
    """Write the attributes of the result into a new folder, or compare them with those there."""
    path = folder / MANIFEST
    if all(p.name == LOCK or p.name.startswith(".") for p in folder.iterdir()):
        write_beside(path, lambda file: file.write(json.dumps(new, indent=2).encode()))
    old = json.loads(path.read_bytes()) if path.exists() else None
    if not isinstance(old, dict) or old.get("format") != FORMAT:
        raise InputError(f"sweep folder {folder}: not one of a sweep. Fix: give another --out.")
    other = sorted(k for k in {*old, *new} if old.get(k) != new.get(k))
    if not all(k.startswith(_PROVENANCE) for k in other):
        raise InputError(
            f"sweep folder {folder}: it holds chunks of another sweep, or of this file "
            "before it was changed. Fix: give another --out, or remove the folder."
        )
    if other:
        raise InputError(
            f"sweep folder {folder}: it was begun with another "
            f"{', '.join(k.removeprefix(_PROVENANCE) for k in other)}, and one result must not mix "
            "numbers of two. Fix: resume with that, or remove the folder."
        )


def _mapped(path: Path, shape: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return the array of a file; one that is missing or damaged is made of zeros.

    The header is compared and not read: it is known, and a damaged one could say anything.
    """
    known = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, known)
    start = header.tell()
    size = start + math.prod(shape) * dtype.itemsize
    with suppress(FileNotFoundError), open(path, "rb", opener=open_no_link) as file:
        if file.read(start) == header.getvalue() and os.fstat(file.fileno()).st_size == size:
            return np.memmap(file, dtype, "r", offset=start, shape=shape)
    with open(path, "w+b", opener=open_no_link) as file:
        file.write(header.getvalue())
        file.truncate(size)
        return np.memmap(file, dtype, "r", offset=start, shape=shape)


@dataclass(frozen=True)
class Store:
    """The folder of a sweep's columns: one NumPy file for each, with a row for every point.

    Chunks are written into the files; the sum of a chunk (CRC-32 of all its columns, plus 1) is
    written after it, so that a chunk counts only when it is whole. `columns` are maps of the files,
    and of the sums.
    """

    folder: Path
    sweep: Sweep
    columns: Columns

    def write(self, start: int, chunk: Columns) -> None:
        """Write the points of a chunk, and its sum once they are written."""
        for name, rows in chunk.items():
            self._put(name, start, rows)
        self._put(SUMS, start // self.sweep.chunk, np.array([_sum(chunk)]))

    def _put(self, name: str, first: int, rows: NDArray[Any]) -> None:
        # Written as a file, not through the map: there a full disk would end the process.
        array: Any = self.columns[name]
        with open(self.folder / f"{name}.npy", "r+b", opener=open_no_link) as file:
            file.seek(array.offset + first * array.strides[0])
            file.write(rows.data)

    def read(self, start: int) -> Columns:
        """Return a chunk."""
        rows = slice(start, self.sweep.stop(start))
        return {name: self.columns[name][rows] for name in self.sweep.columns}

    def missing(self) -> list[int]:
        """Return the first points of missing chunks; a damaged one counts as missing."""
        pairs = zip(self.sweep.starts, self.columns[SUMS].tolist(), strict=True)
        return [s for s, there in pairs if not there or there != _sum(self.read(s))]

    def summary(self) -> SweepSummary:
        """Return counts of the stop reasons, the range of every quantity, and notices."""
        sweep = self.sweep
        reasons = sweep.codes("stop_reason") or {}
        counts = np.zeros(len(reasons), int)
        ranges: dict[str, QuantityRange] = {}
        off, largest, limit = 0, 0.0, open_from(sweep.scenario.settings.rtol)
        pressed = sum(sweep.pressed_count(start, sweep.stop(start)) for start in sweep.starts)
        for chunk in map(self.read, sweep.starts):
            residuals = chunk["energy_residual"]
            off += int((residuals >= limit).sum())
            largest = max(largest, float(np.fmax.reduce(residuals, initial=0.0)))
            counts += np.bincount(chunk["stop_reason"], minlength=len(reasons))
            for name, quantity in sweep.columns.items():
                if name not in sweep.space.names and sweep.codes(quantity) is None:
                    _widen(ranges, name, chunk[name], sweep.unit(quantity))
        points = sweep.space.points
        past, energy = batch_past_notices(pressed, points), batch_notices(off, points, largest)
        return {
            "title": sweep.scenario.title,
            "mechanism": sweep.mechanism.name,
            "law": sweep.simulator.label,
            "points": points,
            "axes": {n: sweep.unit(n) for n in sweep.space.names},
            "stop_reasons": {r: int(n) for r, n in zip(reasons, counts, strict=True) if n},
            "quantities": ranges,
            "open_balances": off,
            "notices": [*past, *energy],
        }

    def finish(self, out: Path) -> None:
        """Write the result, whole or not at all, and remove the store.

        PainleveError for a full disk or another fault of writing; the store stays.
        """
        new = self.folder / "result" / out.name
        shutil.rmtree(new.parent, ignore_errors=True)
        try:
            new.parent.mkdir()
            # HDF5 crashes on a full disk; a megabyte is for texts and metadata.
            need = sum(column.nbytes for column in self.columns.values()) + 2**20
            if shutil.disk_usage(self.folder).free < need:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            self._write(new)
            if out.is_dir():  # an older Zarr store: folders do not replace each other
                os.replace(out, new.parent / "replaced")
            os.replace(new, out)
        except OSError as error:
            raise PainleveError(
                f"output file {out}: {error.strerror or error}. All points are written to "
                f"{self.folder}. Fix: make room and give the same command again."
            ) from error
        finally:
            shutil.rmtree(new.parent, ignore_errors=True)
        # In an order in which this too can be interrupted; the lock goes last.
        for path in (*self.folder.glob("*.npy"), self.folder / MANIFEST):
            path.unlink()
        shutil.rmtree(self.folder, ignore_errors=True)

    def _write(self, path: Path) -> None:
        table, texts = self._table(), attributes(self.sweep)
        suffix = path.suffix.lower()
        if suffix not in _NEEDS:
            sweep = self.sweep
            texts |= {
                "codes": json.dumps({n: c for n in sweep.kept if (c := sweep.codes(n))}),
                "dimensions": json.dumps(list(sweep.space.axes) or ["point"]),
                "event_dimensions": json.dumps({n: list(sweep.labels(n)) for n in sweep.kept}),
            }
            arrays: dict[str, Any] = {name: array for name, (_, array, _) in table.items()}
            with path.open("wb") as file:
                np.savez(file, text=json.dumps(texts), **arrays)
            return
        import xarray

        data: Any = xarray.Dataset(table, attrs=texts)
        # What the libraries below say of each other's versions is not about the result.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            warnings.simplefilter("ignore", FutureWarning)
            if suffix == ".nc":
                data.to_netcdf(path, engine="h5netcdf")
            else:
                # Version 2 of the format: every reader knows it, and texts and consolidated
                # metadata are part of it.
                data.to_zarr(path, zarr_format=2, consolidated=True)

    def _table(self) -> dict[str, tuple[tuple[str, ...], NDArray[Any], dict[str, Any]]]:
        """Return dimensions, values and attributes of all axes, labels and quantities by name."""
        sweep, axes = self.sweep, self.sweep.space.axes
        dims, lengths = tuple(axes) or ("point",), tuple(map(len, axes.values())) or (-1,)
        table: dict[str, Any] = {n: ((n,), a, {"units": sweep.unit(n)}) for n, a in axes.items()}
        for quantity in sweep.kept:
            table |= {dim: ((dim,), labels, {}) for dim, labels in sweep.labels(quantity).items()}
        for name, quantity in sweep.columns.items():
            values, codes = self.columns[name], sweep.codes(quantity)
            about: dict[str, Any] = {"units": sweep.unit(quantity)}
            if codes is not None:
                flags = np.array(list(codes.values()), values.dtype)
                about = {"flag_values": flags, "flag_meanings": " ".join(codes)}
            shaped = values.reshape(*lengths, *values.shape[1:])
            table[name] = ((*dims, *sweep.labels(quantity)), shaped, about)
        return table


def _sum(chunk: Columns) -> int:
    """Return the check sum of a chunk, which is not 0."""
    total = 0
    for rows in chunk.values():
        total = zlib.crc32(rows.data, total)
    return total + 1


def _widen(ranges: dict[str, QuantityRange], name: str, values: NDArray[Any], unit: str) -> None:
    """Widen the range of a quantity by the values of a chunk."""
    each = values.reshape(len(values), -1)
    there = np.isfinite(each)
    old = ranges.setdefault(name, {"unit": unit, "from": None, "to": None, "missing": 0})
    old["missing"] += int((~there.any(axis=1)).sum())
    if there.any():
        ends = [v for v in (old["from"], old["to"]) if v is not None]
        old["from"] = min([float(each[there].min()), *ends])
        old["to"] = max([float(each[there].max()), *ends])
