"""A lock on the folder of a sweep, which several processes must not write to at once."""

from __future__ import annotations

import errno
import fcntl
import os
import socket
import warnings
import weakref
from pathlib import Path

from painleve_sym.errors import InputError, PainleveWarning

NAME = "lock"
_HELD = (errno.EACCES, errno.EAGAIN)


class FolderLock:
    """Holds a folder for this process until it is released, collected, or the process ends.

    Parameters
    ----------
    folder : Path
        It exists; the lock is a file in it.

    Raises
    ------
    InputError
        Another process holds it.
    """

    def __init__(self, folder: Path) -> None:
        file = os.open(folder / NAME, os.O_RDWR | os.O_CREAT, 0o644)
        self.release = weakref.finalize(self, os.close, file)
        try:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in _HELD:
                holder = os.read(file, 200).decode("utf-8", "replace").strip()
                self.release()
                raise InputError(
                    f"sweep folder {folder}: {holder or 'another process'} is writing to it. "
                    "Fix: wait until it ends, or give another --out."
                ) from None
            warnings.warn(
                f"sweep folder {folder}: it cannot be locked ({error.strerror}). Fix: see to it "
                "that no other process writes to it.",
                PainleveWarning,
                stacklevel=2,
            )
            return
        os.ftruncate(file, 0)
        os.write(file, f"process {os.getpid()} on {socket.gethostname()}\n".encode())
