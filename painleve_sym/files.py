"""Files: results are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
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
