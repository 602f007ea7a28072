"""Doors: the public names of a folder, listed once in its stub file and loaded when first used.

A door is a folder of the package with a file ``__init__.pyi``, as in SPEC 1 of Scientific Python.
Type checkers and editors read that file; `door` reads it, too.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent
_LISTED = re.compile(r"^from ([\w.]+) import (?:\(\s*)?(\w+) as \2\b", re.M)


@cache
def listed(package: str) -> dict[str, str]:
    """Return the public names of a package with the module that each is in."""
    stub = ROOT.joinpath(*package.split(".")[1:], "__init__.pyi")
    return {name: home for home, name in _LISTED.findall(stub.read_text("utf-8"))}


@cache
def doors() -> tuple[str, ...]:
    """Return the names of all doors, the package itself apart."""
    return tuple(sorted(f"{ROOT.name}.{p.parent.name}" for p in ROOT.glob("*/__init__.pyi")))


@cache
def public_names() -> dict[str, str]:
    """Return every public name with the package that has it, the package itself before doors."""
    places = (ROOT.name, *doors())
    return {name: place for place in reversed(places) for name in listed(place)}


def door(package: str) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """Return ``__all__``, ``__getattr__`` and ``__dir__`` of a package with a stub file."""
    homes = listed(package)
    names = sorted(homes)

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}{_remedy(name)}")
        home = homes[name]
        inner = f"{home}.{name}"
        value = import_module(inner) if home == package else getattr(import_module(home), name)
        setattr(sys.modules[package], name, value)
        return value

    return names, load, lambda: names


def _remedy(name: str) -> str:
    """Return where else a name is public, as the end of a message."""
    if name.startswith("_"):
        return ""
    if f"{ROOT.name}.{name}" in doors():
        return f". Fix: import {ROOT.name}.{name}"
    place = public_names().get(name)
    return f". Fix: from {place} import {name}" if place else ""
