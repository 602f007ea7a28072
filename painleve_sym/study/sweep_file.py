"""From the chunks of a sweep to one labelled file: NetCDF, or NPZ without further packages."""

from __future__ import annotations

import json
import os
import tempfile
import warnings
import zipfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.errors import InputError, PainleveError
from painleve_sym.study.sweep import Sweep
from painleve_sym.study.sweep_run import FORMAT, Parts, provenance
from painleve_sym.study.sweep_space import Grid

SUFFIXES = (".nc", ".npz")


def check_format(out: Path) -> None:
    """Raise InputError where the packages that write the file are missing."""
    if out.suffix.lower() != ".nc":
        return
    try:
        import h5netcdf  # noqa: F401
        import xarray  # noqa: F401
    except ImportError as error:
        raise InputError(
            f"--out {out}: NetCDF needs xarray and h5netcdf. "
            "Fix: pip install 'painleve-sym[sweep]', or name a file that ends in .npz."
        ) from error


def attributes(sweep: Sweep) -> dict[str, str]:
    """Return what a result says of itself: title, the sweep's own text, provenance."""
    found = {
        "format": FORMAT,
        "title": sweep.scenario.title,
        "sweep": sweep.text,
        "mechanism_file": sweep.mechanism_text or "",
        "mechanism": sweep.mechanism.name,
        "law": sweep.simulator.label,
        "law_choices": json.dumps(dict(sweep.simulator.choices)),
    }
    return found | {f"provenance_{k}": v for k, v in provenance(sweep).items()}


def write_result(parts: Parts, out: Path) -> None:
    """Write the chunks into one file: whole, or not at all; one quantity in memory at a time.

    Raises
    ------
    PainleveError
        A full disk or another fault of writing; the chunks stay.
    """
    write = _write_netcdf if out.suffix.lower() == ".nc" else _write_npz
    handle, name = -1, ""
    try:
        handle, name = tempfile.mkstemp(dir=out.parent, prefix=f".{out.name}.")
        os.close(handle)
        write(parts, Path(name))
        Path(name).chmod(0o644)
        os.replace(name, out)
    except OSError as error:
        raise PainleveError(
            f"output file {out}: {error.strerror or error}. All points are written to "
            f"{parts.folder}. Fix: make room and give the same command again."
        ) from error
    finally:
        if name:
            Path(name).unlink(missing_ok=True)


def _quantities(parts: Parts) -> Iterator[tuple[str, Callable[[], NDArray[Any]]]]:
    """Yield names, and what reads all points of each; points of a sample come first."""
    sweep = parts.sweep

    def varied(name: str) -> NDArray[Any]:
        ends = [min(s + sweep.chunk, sweep.space.points) for s in sweep.starts]
        pieces = zip(sweep.starts, ends, strict=True)
        return np.concatenate([sweep.space.values(a, b)[name] for a, b in pieces])

    def kept(name: str) -> NDArray[Any]:
        return np.concatenate([parts.read(s, name) for s in sweep.starts])

    if not isinstance(sweep.space, Grid):
        for name in sweep.space.names:
            yield name, partial(varied, name)
    for name in sweep.kept:
        yield result_name(sweep, name), partial(kept, name)


def result_name(sweep: Sweep, name: str) -> str:
    """Return a quantity's name in the file: ``final_`` comes before a state that is varied."""
    return f"final_{name}" if name in sweep.space.names else name


def _write_npz(parts: Parts, path: Path) -> None:
    sweep = parts.sweep
    text = attributes(sweep) | {
        "codes": json.dumps({n: c for n in sweep.kept if (c := sweep.codes(n))}),
        "dimensions": json.dumps(_dims(sweep)),
    }
    with zipfile.ZipFile(path, "w") as file:

        def put(name: str, array: NDArray[Any]) -> None:
            with file.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)

        put("text", np.array(json.dumps(text)))
        if isinstance(sweep.space, Grid):
            for name, values in sweep.space.axes.items():
                put(name, values)
        for name, read in _quantities(parts):
            put(name, read().reshape(_shape(sweep)))


def _write_netcdf(parts: Parts, path: Path) -> None:
    import xarray

    sweep = parts.sweep
    coordinates: dict[str, Any] = {}
    if isinstance(sweep.space, Grid):
        coordinates = {n: (n, v, {"units": sweep.unit(n)}) for n, v in sweep.space.axes.items()}
    start = xarray.Dataset(coords=coordinates, attrs=attributes(sweep))
    with warnings.catch_warnings():
        # What the libraries below say of each other's versions is not about the result.
        warnings.simplefilter("ignore", DeprecationWarning)
        warnings.simplefilter("ignore", FutureWarning)
        start.to_netcdf(path, mode="w", engine="h5netcdf")
        for name, read in _quantities(parts):
            values = read().reshape(_shape(sweep))
            variable = (_dims(sweep), values, _variable_attributes(sweep, name))
            xarray.Dataset({name: variable}).to_netcdf(path, mode="a", engine="h5netcdf")


def _variable_attributes(sweep: Sweep, name: str) -> dict[str, Any]:
    name = name.removeprefix("final_")
    codes = sweep.codes(name)
    if codes is None:
        return {"units": sweep.unit(name)}
    values = np.array(list(codes.values()), dtype=np.int8 if name != "mode" else np.int16)
    return {"flag_values": values, "flag_meanings": " ".join(codes)}


def _dims(sweep: Sweep) -> list[str]:
    return list(sweep.space.names) if isinstance(sweep.space, Grid) else ["point"]


def _shape(sweep: Sweep) -> tuple[int, ...]:
    return sweep.space.shape if isinstance(sweep.space, Grid) else (sweep.space.points,)
