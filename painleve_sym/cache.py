"""The folder of compiled libraries and derivations: private to its user, or not used.

A derivation is an entry: a text file with the hash of its content, then the content as JSON.
Nothing in it is ever executed. Its name is the hash of what the derivation starts from and of what
derives it; an entry whose content does not have its hash is removed and made again.
"""

from __future__ import annotations

import atexit
import functools
import hashlib
import importlib.util
import json
import os
import re
import shutil
import stat
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from painleve_sym.errors import PainleveError, PainleveWarning
from painleve_sym.system import is_open, is_own, is_written_by_others, open_no_link, user_cache
from painleve_sym.version import RELEASE

PREFIX = "painleve-"
"""Of all names in the cache: its folder may have another purpose, too."""
ZIG_FOLDER = f"{PREFIX}zig"
"""Where the compiler of the package ziglang keeps what it made of its own libraries."""
COMPILER_LOG = f"{PREFIX}compiler.log"
"""Text of a compiler that failed last."""
_WORK = f"{PREFIX}work-"
ENTRY, FORM = ".json", ".form"
"""Ends of the names of entries, and of those that hold one expression."""
_AT_ONCE = 1 << 20
# Libraries, derivations, the folders in which both are made, and what a compiler keeps or says.
_OWN_NAME = re.compile(
    rf"{PREFIX}[0-9a-f]{{40}}(?:-[0-9a-f]{{40}}\.(?:so|dll)|\.json|\.form)|{_WORK}[a-z0-9_]{{8}}|{ZIG_FOLDER}"
    rf"|{re.escape(COMPILER_LOG)}"
)


def named_folder() -> Path:
    """Return where the cache is meant to be, whether or not it can be used.

    ``PAINLEVE_CACHE``, else ``painleve-sym`` in `system.user_cache`, ``~/.cache`` on Linux; with
    the ``~`` in it where there is no home folder.
    """
    named = os.environ.get("PAINLEVE_CACHE")
    folder = Path(named) if named else user_cache() / "painleve-sym"
    with suppress(RuntimeError):
        return folder.expanduser()
    return folder


def cache_folder() -> Path:
    """Return the folder of compiled libraries, readable and writable by its owner only.

    Where `named_folder` cannot be written, is not the user's own, or cannot be closed to other
    users because it holds other files too: a temporary folder, with a notice, that is removed when
    the process ends. What lay in a cache to which others could write is removed, with a notice.
    """
    folder = named_folder()
    problem = _make_private(folder)
    return folder if problem is None else temporary_folder(folder, problem)


def _make_private(folder: Path) -> str | None:
    """Create the folder with mode 0700; return why it cannot be used, or None."""
    if folder.parts[:1] and folder.parts[0].startswith("~"):
        return "there is no home folder (HOME is not set, and the user has no passwd entry)"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        problem = _foreign(folder)
        if problem is None and is_open(folder.stat()):
            problem = _close(folder)
        if problem is None and not os.access(folder, os.R_OK | os.W_OK | os.X_OK):
            problem = "it cannot be written"
        return problem
    except OSError as error:
        return error.strerror or str(error)


def _foreign(folder: Path) -> str | None:
    return None if is_own(folder.stat()) else "it belongs to another user"


def _close(folder: Path) -> str | None:
    """Close the folder to other users; return why it stays open and cannot be used, or None."""
    info = folder.stat()
    written = is_written_by_others(info)
    # A folder of another purpose, or one that is meant to be shared: its mode is the user's choice.
    if any(not _OWN_NAME.fullmatch(entry.name) for entry in folder.iterdir()):
        holds = "other users can write to it, and it holds files that are not the cache's"
        return holds if written else None
    if info.st_mode & stat.S_ISVTX:
        return "it is a folder that users share (its sticky bit is set)" if written else None
    folder.chmod(0o700)
    if written and (removed := sum(1 for path in _entries(folder) if _remove(path))):
        warnings.warn(
            f"cache folder {folder}: other users could write to it. It is closed to them now, and "
            f"what it held is removed ({removed} files or folders).",
            PainleveWarning,
            stacklevel=5,
        )
    return None


@functools.lru_cache(maxsize=8)
def temporary_folder(folder: Path, problem: str) -> Path:
    """Return the folder that serves this process in place of the cache, with a notice."""
    warnings.warn(
        f"cache folder {folder}: {problem}; compiled code is kept in a temporary folder for this "
        "run only. Fix: set PAINLEVE_CACHE to a folder of your own.",
        PainleveWarning,
        stacklevel=4,
    )
    path = Path(tempfile.mkdtemp(prefix="painleve-sym-"))
    atexit.register(_remove_at_exit, path, os.getpid())
    return path


def _remove_at_exit(path: Path, owner: int) -> None:
    # A process that was forked off shares the folder with the one that made it.
    if os.getpid() == owner:
        shutil.rmtree(path, ignore_errors=True)


def own_content(path: Path) -> bytes | None:
    """Return the content of a file that only this user can have written, else None.

    None also where there is no such file: links and special files are not read.
    """
    try:
        with open(path, "rb", opener=open_no_link) as file:
            info = os.fstat(file.fileno())
            own = is_own(info) and not is_written_by_others(info)
            return file.read() if own and stat.S_ISREG(info.st_mode) else None
    except OSError:
        return None


def work_folder(folder: Path) -> tempfile.TemporaryDirectory[str]:
    """Return a context that makes and removes a folder in the cache, in which a file is made."""
    return tempfile.TemporaryDirectory(dir=folder, prefix=_WORK, ignore_cleanup_errors=True)


def full(folder: Path) -> str | None:
    """Return why a file of 1 MiB cannot be written into the folder, or None where it can."""
    try:
        with tempfile.TemporaryFile(dir=folder, prefix=_WORK) as file:
            file.write(bytes(1 << 20))
            file.flush()
    except OSError as error:
        return error.strerror or str(error)
    return None


# ---- entries ----


def entry_name(title: str, *texts: str, by: tuple[str, ...]) -> str:
    """Return the name of an entry: of its title, of texts that it is derived from, and of the code.

    An entry is made again where code changes in one of the folders `by` of the package, and with
    another version of what derives.
    """
    return _hash("\n".join((_versions(), *map(code_mark, by), title, *texts)))[:40]


@functools.lru_cache(maxsize=1)
def _versions() -> str:
    """Return the versions of the packages that derive, and a hash of the package's own modules.

    Those that lie in no folder, such as kinds of events and units, play a part in every entry.
    """
    modules = _content_mark(sorted(_listed(os.path.dirname(__file__))))
    marks = (_package_mark("sympy", "release.py"), _package_mark("casadi", "_casadi.so"), modules)
    return "\n".join((RELEASE, *marks))


@functools.lru_cache(maxsize=16)
def code_mark(folder: str) -> str:
    """Return a hash of the code in a folder of the package."""
    return _content_mark(_code_files(folder))


def _content_mark(paths: list[str]) -> str:
    """Return a hash of the content of files."""
    code = hashlib.sha256()
    for path in paths:
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


_CODE = (".py", ".c", ".h", ".toml")


def _listed(folder: str) -> list[str]:
    """Return the code files of a folder, without those of the folders in it."""
    with os.scandir(folder) as entries:
        return [entry.path for entry in entries if entry.name.endswith(_CODE)]


def _code_files(folder: str) -> list[str]:
    folders, files = [os.path.join(os.path.dirname(__file__), folder)], []
    while folders:
        with os.scandir(folders.pop()) as entries:
            for entry in entries:
                if entry.name.endswith(_CODE):
                    files.append(entry.path)
                elif entry.is_dir() and entry.name != "__pycache__":
                    folders.append(entry.path)
    return sorted(files)


def kept_entry(key: str | None, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Return the content of an entry, which is made and written where there is none.

    Without a key it is made each time.
    """
    entry = read_entry(key) if key else None
    if entry is None:
        entry = make()
        if key:
            write_entry(key, entry)
    return entry


def read_entry(key: str, suffix: str = ENTRY) -> dict[str, Any] | None:
    """Return the content of an entry; None where there is none, or a damaged one was removed."""
    path = _path(key, suffix)
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


def write_entry(key: str, entry: dict[str, Any], suffix: str = ENTRY) -> None:
    """Store an entry in one step: a process that reads at the same time sees all or nothing.

    A cache that cannot be written (a full disk) only costs time, and is not a failure.
    """
    content = json.dumps(entry)
    path = _path(key, suffix)
    try:
        with work_folder(path.parent) as work:
            written = Path(work, path.name)
            written.write_text(f"{_hash(content)}\n{content}", "utf-8")
            written.chmod(0o600)
            os.replace(written, path)
    except OSError:
        return


def _path(key: str, suffix: str) -> Path:
    return cache_folder() / f"{PREFIX}{key}{suffix}"


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


# ---- what it holds ----


@dataclass(frozen=True)
class CacheContent:
    """Numbers of compiled libraries and of entries, forms among them; bytes of all files."""

    folder: Path
    libraries: int
    derivations: int
    size: int


def cache_content() -> CacheContent:
    """Return what the cache holds; nothing is created, and nothing where there is no folder."""
    folder = named_folder()
    try:
        entries = list(_entries(folder))
        libraries = sum(path.suffix == ".so" for path in entries)
        kept = sum(path.suffix in (ENTRY, FORM) for path in entries)
        return CacheContent(folder, libraries, kept, sum(map(_size, entries)))
    except FileNotFoundError:
        return CacheContent(folder, 0, 0, 0)
    except OSError as error:
        raise _unusable(folder, error.strerror or str(error)) from error


def clear_cache() -> CacheContent:
    """Remove what the cache holds, other files in its folder apart; return what was removed.

    PainleveError where the folder belongs to another user, or a file cannot be removed.
    """
    content = cache_content()
    if content.folder.exists():
        if problem := _foreign(content.folder):
            raise _unusable(content.folder, problem)
        kept = [path for path in _entries(content.folder) if not _remove(path)]
        if kept:
            raise _unusable(content.folder, f"{kept[0].name} cannot be removed")
    return content


def _unusable(folder: Path, problem: str) -> PainleveError:
    return PainleveError(f"cache folder {folder}: {problem}.")


def _entries(folder: Path) -> Iterator[Path]:
    return (path for path in list(folder.iterdir()) if _OWN_NAME.fullmatch(path.name))


def _size(path: Path) -> int:
    """Return the bytes of a file, or of all files in a folder; another process may remove some."""
    with suppress(FileNotFoundError):
        if stat.S_ISDIR(path.lstat().st_mode):
            return sum(map(_size, path.iterdir()))
        return path.lstat().st_size
    return 0


def _remove(path: Path) -> bool:
    """Remove a file or folder; return whether it is gone."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):
            path.unlink()
    return not os.path.lexists(path)
