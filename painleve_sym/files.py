"""Files that are read up to a size, and written whole or not at all."""

from __future__ import annotations

import difflib
import itertools
import os
import re
import stat
import tomllib
from contextlib import suppress
from pathlib import Path
from typing import Any

from painleve_sym.errors import InputError, received


def write_beside(path: str | Path, write: Any) -> None:
    """Write through a temporary file in the same folder, then rename; `write` takes the open file.

    A file that is there keeps its permissions, a new one has those that the umask leaves.
    InputError where no file can be made there. OSError, with the name of the file, where it cannot
    be written (a full disk); nothing is left then.
    """
    path = file_path(path, "output file")
    name = beside(path)
    try:
        file = open(name, "xb", opener=no_link)  # noqa: SIM115, closed below
    except OSError as error:
        raise InputError(
            f"output file {path}: {error.strerror}. Fix: name a folder that exists and is writable."
        ) from error
    try:
        with file, suppress(FileNotFoundError):
            write(file)
            name.chmod(stat.S_IMODE(path.stat().st_mode))
        os.replace(name, path)
    except BaseException as error:
        name.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from error
        raise


def beside(path: Path) -> Path:
    """Return a hidden name beside a path, which is not in use and which no other user can guess."""
    return path.with_name(f".{path.name[:50]}.{os.urandom(6).hex()}")


def no_link(path: str, flags: int) -> int:
    """Open a file, as `opener` of `open`; OSError where it is a link that another may have made."""
    return os.open(path, flags | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)


def file_path(value: Any, where: str) -> Path:
    """Return the path of a file; InputError for what is none, such as a number or an empty text."""
    if isinstance(value, str | os.PathLike) and str(value).strip():
        return Path(os.fsdecode(value))
    raise InputError(f"{where}: got {received(value)}, need the path of a file.")


def read_text(path: str | Path, where: str, most: int, kind: str = "TOML file") -> str:
    """Return the UTF-8 text of a file; InputError as `read_bytes`, and where it is not UTF-8."""
    content = read_bytes(path, where, most, kind)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(f"{where}, line {line}: not UTF-8 text. Fix: save it as UTF-8.") from error


def read_bytes(path: str | Path, where: str, most: int, kind: str) -> bytes:
    """Return the content of a file that may be of any size or kind.

    Messages call the file `where`, and `kind` what it should be; at most `most` bytes are read,
    since a special file may never end. InputError where it is not readable, or too long.
    """
    path = file_path(path, where)
    try:
        with open(path, "rb") as file:
            content = file.read(most + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        near = _near_file(path) if isinstance(error, FileNotFoundError) else ""
        raise InputError(f"{where}: {reason}.{near} Fix: name a readable {kind}.") from error
    if len(content) > most:
        raise InputError(f"{where}: got more than {most} bytes. Fix: name a {kind}.")
    return content


def _near_file(path: Path) -> str:
    """Return a question with the name of a file beside an absent one that is much like it."""
    with suppress(OSError):
        kept = (p.stem for p in path.parent.iterdir() if p.suffix == path.suffix)
        for stem in difflib.get_close_matches(path.stem, list(itertools.islice(kept, 1000)), n=1):
            return f" Did you mean {str(path.with_stem(stem))!r}?"
    return ""


MAX_NESTING = 32
"""Tables and arrays within each other, and parts of a dotted key."""
_LONG_KEY = re.compile(
    r"""(?:^|[\[{,])[ \t]*(?:(?:[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*)"""
    f"{{{MAX_NESTING}}}",
    re.MULTILINE,
)


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Return the entries of TOML text.

    InputError where it is not TOML, nested too deeply, or has a whole number beyond 64 bits.
    """
    deep = InputError(
        f"{where}: tables, arrays or the parts of a dotted key are nested too deeply, need at "
        f"most {MAX_NESTING} within each other."
    )
    # The reader takes the square of the length of a dotted key.
    if _LONG_KEY.search(text):
        raise deep
    try:
        data = tomllib.loads(text)
    except RecursionError as error:
        raise deep from error
    except ValueError as error:
        raise InputError(f"{where}: not valid TOML: {error}.") from error
    level: list[Any] = [data]
    for _ in range(MAX_NESTING + 1):
        if any(isinstance(v, int) and not -(2**63) <= v < 2**63 for v in level):
            raise InputError(
                f"{where}: a whole number has more than the 64 bits of TOML. "
                "Fix: write it as a decimal, such as 1e20."
            )
        inner = (v.values() if isinstance(v, dict) else v for v in level if isinstance(v, _NESTED))
        level = [v for values in inner for v in values]
    if level:
        raise deep
    return data


_NESTED = (dict, list)
