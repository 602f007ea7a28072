"""Disk cache of derived functions and signatures of automata.

An entry is a text file: the hash of its content, then the content as JSON. Nothing in it is ever
executed. Its name is the hash of what the derivation starts from and of what derives it; an entry
whose content does not have its hash is removed and made again.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.util
import json
import os
from pathlib import Path
from typing import Any

from painleve_sym.codegen.cache import PREFIX, cache_folder, own_content, work_folder
from painleve_sym.version import __version__

MECHANISM = ("mechanics", "codegen")
"""Folders that derive a mechanism."""
FORMULAS = (*MECHANISM, "laws", "hybrid", "contacts")
"""Folders that derive an automaton and other formulas of contacts."""
ENGINE = (*FORMULAS, "engines")
"""Folders that write the C of an engine."""
_AT_ONCE = 1 << 20


def entry_key(title: str, *objects: Any, by: tuple[str, ...] = FORMULAS) -> str | None:
    """Return the name of an entry, or None where an object has no definition to go by.

    The title says what the entry holds, and all else that it depends on; the objects are what it is
    derived from: texts, or what has a `definition` or a `definition_text`. An entry is made again
    where code changes in one of the folders of the package that it is derived `by`.
    """
    try:
        texts = [_definition(source) for source in objects]
    except TypeError:
        return None
    return _hash("\n".join((_versions(), *map(code_mark, by), title, *texts)))[:40]


def _definition(source: Any) -> str:
    known = source if isinstance(source, str) else getattr(source, "definition", None)
    if isinstance(known, str):
        return known
    from painleve_sym.mechanics.definition import definition_text

    return definition_text(source)


@functools.lru_cache(maxsize=1)
def _versions() -> str:
    """Return the versions of the packages that derive."""
    marks = (_package_mark("sympy", "release.py"), _package_mark("casadi", "_casadi.so"))
    return "\n".join((__version__, *marks))


@functools.lru_cache(maxsize=16)
def code_mark(folder: str) -> str:
    """Return a hash of the code in a folder of the package."""
    code = hashlib.sha256()
    for path in _code_files(folder):
        # Read with `os.read`, without the overhead of file objects: this runs at every start.
        file = os.open(path, os.O_RDONLY)
        try:
            while content := os.read(file, _AT_ONCE):
                code.update(content)
        finally:
            os.close(file)
    return code.hexdigest()


def _package_mark(name: str, file: str) -> str:
    """Return a mark of a package's version, without importing it."""
    try:
        spec = importlib.util.find_spec(name)
    except ValueError:  # a stand-in without a specification
        spec = None
    home = os.path.dirname(spec.origin) if spec and spec.origin else ""
    for path in (os.path.join(home, file), os.path.join(home, "__init__.py")):
        try:
            info = os.stat(path)
        except OSError:
            continue
        return f"{path} {info.st_size} {info.st_mtime_ns}"
    return name


def _code_files(folder: str) -> list[str]:
    folders, files = [os.path.join(os.path.dirname(os.path.dirname(__file__)), folder)], []
    while folders:
        with os.scandir(folders.pop()) as entries:
            for entry in entries:
                if entry.name.endswith((".py", ".c")):
                    files.append(entry.path)
                elif entry.is_dir() and entry.name != "__pycache__":
                    folders.append(entry.path)
    return sorted(files)


def read_entry(key: str) -> dict[str, Any] | None:
    """Return the content of an entry; None where there is none, or a damaged one was removed."""
    path = _path(key)
    stored = own_content(path)
    if stored is None:
        return None
    try:
        text = stored.decode("utf-8")
    except UnicodeDecodeError:
        text = ""
    mark, _, content = text.partition("\n")
    if mark != _hash(content):
        path.unlink(missing_ok=True)
        return None
    entry: dict[str, Any] = json.loads(content)
    return entry


def write_entry(key: str, entry: dict[str, Any]) -> None:
    """Store an entry in one step: a process that reads at the same time sees all or nothing.

    A cache that cannot be written (a full disk) only costs time, and is not a failure.
    """
    content = json.dumps(entry)
    path = _path(key)
    try:
        with work_folder(path.parent) as work:
            written = Path(work, path.name)
            written.write_text(f"{_hash(content)}\n{content}", "utf-8")
            written.chmod(0o600)
            os.replace(written, path)
    except OSError:
        return


def _path(key: str) -> Path:
    return cache_folder() / f"{PREFIX}{key}.json"


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
