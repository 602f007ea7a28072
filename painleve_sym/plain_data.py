"""Results as plain data, such as JSON holds, and the way back."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Mapping
from enum import Enum
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints


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


def finite(value: float) -> float | None:
    """Return a number for plain data, which have no nan and no infinity: None stands for these."""
    return value if math.isfinite(value) else None


def plain_fields(value: Any, *names: str) -> dict[str, Any]:
    """Return the named attributes of an object as plain data, in this order."""
    return {name: _part(getattr(value, name)) for name in names}


def _part(value: Any) -> Any:
    return value.to_dict() if hasattr(value, "to_dict") else to_plain(value)


def _key(key: Any) -> Any:
    return key.value if isinstance(key, Enum) else key


def of_plain(kind: Any, data: Any) -> Any:
    """Return the value of a type whose plain data `to_plain` wrote.

    Types are dataclasses and named tuples (their fields tell the rest), tuples, mappings by name,
    enums, and what is plain itself; None where a union allows it. KeyError, TypeError or ValueError
    where the data are not those of the type.
    """
    parts = get_args(kind)
    if isinstance(kind, UnionType) or get_origin(kind) is Union:
        return None if data is None else of_plain(parts[0], data)
    if get_origin(kind) is tuple:
        kinds = itertools.repeat(parts[0]) if parts[-1] is ... else parts
        return tuple(of_plain(part, value) for part, value in zip(kinds, data, strict=False))
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        return kind(**{n: of_plain(part, data[n]) for n, part in _fields(kind) if n in data})
    if hasattr(kind, "_fields"):
        return kind(*(of_plain(p, v) for (_, p), v in zip(_fields(kind), data, strict=True)))
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind(data)
    return data


@functools.cache
def _fields(kind: type) -> tuple[tuple[str, Any], ...]:
    """Return names and types of the fields of a dataclass or named tuple."""
    names = getattr(kind, "_fields", None) or [f.name for f in dataclasses.fields(kind) if f.init]
    hints = get_type_hints(kind)
    return tuple((name, hints[name]) for name in names)
