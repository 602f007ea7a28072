"""Differences of operating systems: cache folders, owners of files, links, libraries.

Windows has no owners by number and no modes; its folder of a user's cache is closed to other users.
"""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path

PLATFORM: str = sys.platform
"""The name of the operating system, as Python says it; tests simulate another one."""
_BY_OTHERS, _WRITTEN_BY_OTHERS = 0o077, 0o022


def on_windows() -> bool:
    """Whether the operating system is Windows."""
    return PLATFORM == "win32"


def user_cache() -> Path:
    """Return the folder in which programs of this user keep caches, with ``~`` where no home is.

    ``XDG_CACHE_HOME`` or ``~/.cache`` on Linux, ``~/Library/Caches`` on macOS, the local data of
    applications on Windows.
    """
    if PLATFORM == "linux":  # the same as platformdirs, without its import at every start
        return Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache")
    from platformdirs import user_cache_path

    return user_cache_path()


def is_own(info: os.stat_result) -> bool:
    """Whether a file belongs to this user."""
    return on_windows() or info.st_uid == os.geteuid()


def is_open(info: os.stat_result) -> bool:
    """Whether other users may read a file, or enter a folder."""
    return not on_windows() and bool(info.st_mode & _BY_OTHERS)


def is_written_by_others(info: os.stat_result) -> bool:
    """Whether other users may write to a file."""
    return not on_windows() and bool(info.st_mode & _WRITTEN_BY_OTHERS)


def open_no_link(path: str, flags: int, mode: int = 0o666) -> int:
    """Open a file as `os.open` does, but no link; it does not wait until a pipe is written."""
    if on_windows():
        if os.path.islink(path):
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), path)
        return os.open(path, flags | getattr(os, "O_BINARY", 0), mode)
    return os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, mode)


def library_suffix() -> str:
    """Return the end of the name of a compiled library."""
    return ".dll" if on_windows() else ".so"
