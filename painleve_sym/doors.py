"""Doors: the public names of a folder, listed once in its stub file and loaded when first used.

A door is a folder of the package with a file ``__init__.pyi``, as in SPEC 1 of Scientific Python.
Type checkers and editors read that file; `door` reads it, too.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any

# No pathlib, which would take a sixth of the time in which the package is imported.
FOLDER = os.path.dirname(__file__)
ROOT = os.path.basename(FOLDER)
STUB = "__init__.pyi"
_LISTED = re.compile(r"^from ([\w.]+) import (?:\(\s*)?(\w+) as \2\b", re.M)


@cache
def listed(package: str) -> dict[str, str]:
    """Return the public names of a package with the module that each is in."""
    with open(os.path.join(FOLDER, *package.split(".")[1:], STUB), encoding="utf-8") as stub:
        return {name: home for home, name in _LISTED.findall(stub.read())}


@cache
def doors() -> tuple[str, ...]:
    """Return the names of all doors, the package itself apart."""
    parts = [n for n in os.listdir(FOLDER) if os.path.exists(os.path.join(FOLDER, n, STUB))]
    return tuple([f"{ROOT}.{name}" for name in sorted(parts)])


@cache
def public_names() -> dict[str, str]:
    """Return every public name with the package that has it, the package itself before doors."""
    places = (ROOT, *doors())
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
    if f"{ROOT}.{name}" in doors():
        return f". Fix: import {ROOT}.{name}"
    place = public_names().get(name)
    return f". Fix: from {place} import {name}" if place else ""
