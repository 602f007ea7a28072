"""Plain data of results, and files that are written whole or not at all."""

from __future__ import annotations

import dataclasses
import os
import tempfile
from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import Any

from painleve_sym.errors import InputError


def write_beside(path: Path, write: Any) -> None:
    """Write through a temporary file in the same folder, then rename; InputError if not."""
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise InputError(
            f"output file {path}: {error.strerror}. Fix: name a folder that exists and is writable."
        ) from error
    try:
        with os.fdopen(handle, "wb") as f:
            write(f)
        Path(name).chmod(0o644)
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def to_plain(value: Any) -> Any:
    """Return a value as plain data: dict, list, text, number, bool or None.

    Dataclasses become dicts of their fields (or what their ``to_dict`` returns where they are part
    of something else), enums their value, arrays and tuples lists.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return plain_fields(value, *(f.name for f in dataclasses.fields(value)))
    if isinstance(value, Enum):
        return to_plain(value.value)
    if isinstance(value, Mapping):
        return {_key(k): _part(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_part(v) for v in value]
    return value.tolist() if hasattr(value, "tolist") else value


def plain_fields(value: Any, *names: str) -> dict[str, Any]:
    """Return the named attributes of an object as plain data, in this order."""
    return {name: _part(getattr(value, name)) for name in names}


def _part(value: Any) -> Any:
    return value.to_dict() if hasattr(value, "to_dict") else to_plain(value)


def _key(key: Any) -> Any:
    return key.value if isinstance(key, Enum) else key
