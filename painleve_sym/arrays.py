"""Array types of the numerical layers, and results in NPZ files."""

from __future__ import annotations

import importlib
import json
import math
import os
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from painleve_sym.errors import InputError
from painleve_sym.files import file_path, write_beside

Array = NDArray[np.float64]
"""An array of floating-point numbers."""


def table_library(name: str, noun: str) -> Any:
    """Return the library pandas or xarray; InputError where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        fix = "Fix: pip install 'painleve-sym[cluster]'."
        raise InputError(f"{noun} needs {name}. {fix}") from error


def save_npz(
    path: str | Path, form: str, texts: Mapping[str, Any], arrays: Mapping[str, Any]
) -> None:
    """Write an NPZ file (arrays and JSON text, no pickle): whole, or not at all.

    `form` is the name and version of the format, which `load_npz` asks for; arrays that are None
    are left out. InputError where the folder does not exist or cannot be written.
    """
    text = json.dumps({"format": form, **texts})
    kept = {name: array for name, array in arrays.items() if array is not None}
    write_beside(path, lambda file: np.savez_compressed(file, text=text, **kept))


def load_npz(
    path: str | Path,
    form: str,
    noun: str,
    texts: Sequence[str],
    arrays: Sequence[str],
    optional: Sequence[str] = (),
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return all texts and arrays that `save_npz` wrote; missing `optional` arrays are None.

    InputError, which calls the file by the noun (``trajectory``), where it is not readable, of
    another format, or lacks one of the names.
    """
    with npz_faults(path, noun), file_path(path, f"{noun} file").open("rb") as file:
        _check_sizes(file)
        file.seek(0)
        with np.load(file, allow_pickle=False) as data:
            text = json.loads(str(data["text"]))
            if text.get("format") != form:
                raise ValueError(f"got format {text.get('format')!r}, need {form!r}")
            missing = [name for name in texts if name not in text]
            missing += [name for name in arrays if name not in data]
            if missing:
                raise KeyError(missing[0])
            kept = {name: data[name] for name in data.files if name != "text"}
    return text, dict.fromkeys(optional) | kept


_FAULTS = (
    *(OSError, EOFError, ValueError, LookupError, TypeError, AttributeError, RecursionError),
    *(zipfile.BadZipFile, zlib.error, NotImplementedError),
)


@contextmanager
def npz_faults(path: str | Path, noun: str) -> Iterator[None]:
    """Turn whatever another content of a file leads to into an InputError about the file."""
    try:
        yield
    except InputError:
        raise
    except _FAULTS as error:
        raise InputError(
            f"{noun} file {path}: not readable ({error}). Fix: give a file written by save."
        ) from error


def _check_sizes(file: BinaryIO) -> None:
    """Raise ValueError, before any array is read, where arrays take far more than the file has."""
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
        total = sum(member.file_size for member in members)
        if total > max(_SMALL, _COMPRESSION * os.fstat(file.fileno()).st_size):
            raise ValueError(f"{total / 1e9:.3g} GB of arrays that compress like zeros")
        for member in members:
            with archive.open(member) as array:
                version = np.lib.format.read_magic(array)
                shape, _, dtype = _HEADERS[version](array)
            if math.prod(shape) * dtype.itemsize > member.file_size:
                raise ValueError(f"array {member.filename} is cut short")


# Numbers of motions compress to a half, and those that are constant in time to a tenth.
_SMALL, _COMPRESSION = 2**28, 20
_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
