"""From the chunks of a sweep to one result: NetCDF, Zarr, or NPZ without further packages."""

from __future__ import annotations

import importlib
import json
import os
import warnings
import zipfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.errors import InputError, PainleveError
from painleve_sym.study.sweeps.runner import FORMAT, Parts, provenance
from painleve_sym.study.sweeps.space import Grid
from painleve_sym.study.sweeps.sweep import FORMATS, Sweep

SUFFIXES = tuple(f".{form}" for form in FORMATS)
_NEEDS = {".nc": ("NetCDF", "h5netcdf"), ".zarr": ("Zarr", "zarr")}


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
    """Write the chunks into one result: whole, or not at all; one quantity in memory at a time.

    It is written among the chunks and moved to its place when it is finished.

    Raises
    ------
    PainleveError
        A full disk or another fault of writing; the chunks stay.
    """
    write = {".nc": _write_netcdf, ".zarr": _write_zarr}.get(out.suffix.lower(), _write_npz)
    parts.clear()
    new = parts.unfinished / out.name
    try:
        parts.unfinished.mkdir()
        write(parts, new)
        if out.is_dir():  # an older Zarr store: folders do not replace each other
            os.replace(out, parts.unfinished / "replaced")
        os.replace(new, out)
    except OSError as error:
        raise PainleveError(
            f"output file {out}: {error.strerror or error}. All points are written to "
            f"{parts.folder}. Fix: make room and give the same command again."
        ) from error
    finally:
        parts.clear()


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


def _kept_name(name: str) -> str:
    return name.removeprefix("final_")


def _write_npz(parts: Parts, path: Path) -> None:
    sweep = parts.sweep
    text = attributes(sweep) | {
        "codes": json.dumps({n: c for n in sweep.kept if (c := sweep.codes(n))}),
        "dimensions": json.dumps(_dims(sweep)),
        "event_dimensions": json.dumps({n: list(sweep.labels(n)) for n in sweep.kept}),
    }
    with zipfile.ZipFile(path, "w") as file:

        def put(name: str, array: NDArray[Any]) -> None:
            with file.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)

        put("text", np.array(json.dumps(text)))
        if isinstance(sweep.space, Grid):
            for name, values in sweep.space.axes.items():
                put(name, values)
        for dim, labels in _event_labels(sweep).items():
            put(dim, labels)
        for name, read in _quantities(parts):
            put(name, _shaped(sweep, read()))


def _write_netcdf(parts: Parts, path: Path) -> None:
    # What the libraries below say of each other's versions is not about the result.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        warnings.simplefilter("ignore", FutureWarning)
        for i, dataset in enumerate(_datasets(parts)):
            dataset.to_netcdf(path, mode="a" if i else "w", engine="h5netcdf")


def _write_zarr(parts: Parts, path: Path) -> None:
    # Version 2 of the format: every reader knows it, and texts and consolidated metadata are part
    # of it.
    for i, dataset in enumerate(_datasets(parts)):
        dataset.to_zarr(path, mode="a" if i else "w", zarr_format=2, consolidated=True)


def _datasets(parts: Parts) -> Iterator[Any]:
    """Yield what a labelled file is made of: coordinates, then one quantity after another."""
    import xarray

    sweep, own = parts.sweep, attributes(parts.sweep)
    coordinates: dict[str, Any] = {d: (d, labels) for d, labels in _event_labels(sweep).items()}
    if isinstance(sweep.space, Grid):
        for name, values in sweep.space.axes.items():
            coordinates[name] = (name, values, {"units": sweep.unit(name)})
    yield xarray.Dataset(coords=coordinates, attrs=own)
    for name, read in _quantities(parts):
        dims = (*_dims(sweep), *sweep.labels(_kept_name(name)))
        variable = (dims, _shaped(sweep, read()), _variable_attributes(sweep, name))
        yield xarray.Dataset({name: variable}, attrs=own)


def _variable_attributes(sweep: Sweep, name: str) -> dict[str, Any]:
    name = _kept_name(name)
    codes = sweep.codes(name)
    if codes is None:
        return {"units": sweep.unit(name)}
    values = np.array(list(codes.values()), dtype=np.int8 if name != "mode" else np.int16)
    return {"flag_values": values, "flag_meanings": " ".join(codes)}


def _dims(sweep: Sweep) -> list[str]:
    return list(sweep.space.names) if isinstance(sweep.space, Grid) else ["point"]


def _shaped(sweep: Sweep, values: NDArray[Any]) -> NDArray[Any]:
    """Return values of all points in the shape of the points, own dimensions last."""
    points = sweep.space.shape if isinstance(sweep.space, Grid) else (sweep.space.points,)
    return values.reshape(points + values.shape[1:])


def _event_labels(sweep: Sweep) -> dict[str, NDArray[Any]]:
    """Return the labels of all dimensions besides those of the points."""
    return {d: labels for name in sweep.kept for d, labels in sweep.labels(name).items()}
