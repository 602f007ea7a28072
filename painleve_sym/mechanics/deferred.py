"""Dataclasses whose formulas are made when first asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Self


class Deferred:
    """Base of a dataclass of which some fields may be known before the others are made.

    Its fields have no plain defaults, which would stand in the place of what is not made yet.
    """

    @classmethod
    def deferred(cls, make: Callable[[], Self], **known: Any) -> Self:
        """Return what `make` returns; it is called when a field is asked for that is not known.

        `known` are fields and cached properties that are known before; they must be those of the
        result.
        """
        instance = object.__new__(cls)
        instance.__dict__.update(known, _make=make)
        return instance

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            # Asked for what is not there: a field that has not been made yet.
            if name not in self.__dataclass_fields__ or "_make" not in self.__dict__:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            fields = vars(self._make())
            for other in fields:
                self.__dict__.setdefault(other, fields[other])
            return fields[name]
