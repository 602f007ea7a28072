"""C source to a loaded shared library, through a cache addressed by content."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import os
import platform
import re
import shutil
import stat
import subprocess
import tempfile
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from painleve_sym.errors import CompileError, CompilerMissing, PainleveWarning

FLAGS = (
    "-O3",
    "-march=native",
    "-ffp-contract=off",
    "-fno-tree-slp-vectorize",
    "-fPIC",
    "-shared",
    "-fvisibility=hidden",
)
"""No fast-math and no contraction: a·d − b·c that is exactly zero must stay zero.

Vectors made of statements side by side are off: gcc 12 contracts there against the flag before
(products with sums and differences in turn become vfmaddsub).
"""


_PART = re.compile(r"^#if PS_HAS\((\d+)\)(?: /\* (-O\d) \*/)?$", re.M)
"""A part of a file, and how far it is to be optimized where that is not as in `FLAGS`."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler that was asked for its version.

    Attributes
    ----------
    path, version : str
    """

    path: str
    version: str

    @property
    def identity(self) -> str:
        """Version, flags and processor: what decides the machine code besides the source."""
        return "\n".join((self.version, " ".join(FLAGS), platform.machine(), _processor()))


@functools.lru_cache(maxsize=1)
def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            return next((line for line in lines if line.startswith(("flags", "Features"))), "")
    except OSError:
        return platform.processor()


def _candidates(command: str | None) -> tuple[str, ...]:
    return (command,) if command else ("cc", "gcc", "clang")


@functools.lru_cache(maxsize=8)
def _compiler(command: str | None) -> Compiler:
    candidates = _candidates(command)
    for name in candidates:
        path = shutil.which(name)
        if path is None:
            continue
        try:
            answer = subprocess.run(
                [path, "--version"], capture_output=True, text=True, timeout=30, check=True
            )
        except (OSError, subprocess.SubprocessError):
            continue
        return Compiler(path, answer.stdout.splitlines()[0] if answer.stdout else path)
    raise CompilerMissing(
        f"no working C compiler: looked for {', '.join(candidates)}. "
        "Fix: install gcc (Debian, Ubuntu: apt install gcc) or name one in the variable CC."
    )


def find_compiler() -> Compiler:
    """Return the compiler named by the variable CC, else cc, gcc or clang.

    Raises
    ------
    CompilerMissing
        There is no compiler that runs.
    """
    return _compiler(os.environ.get("CC") or None)


def compiler_mark() -> str | None:
    """Return a text that differs between compilers, flags and processors, without running any.

    The files of the compilers that `find_compiler` would try, by place, size and time; None where
    there is none.
    """
    compilers = [p for p in map(shutil.which, _candidates(os.environ.get("CC") or None)) if p]
    try:
        files = [(p, os.path.realpath(p), os.stat(p)) for p in compilers]
    except OSError:
        return None
    marks = [f"{p} {real} {s.st_size} {s.st_mtime_ns}" for p, real, s in files]
    return "\n".join((*marks, *FLAGS, platform.machine(), _processor())) if marks else None


def cache_folder() -> Path:
    """Return the folder of compiled libraries, readable and writable by its owner only.

    ``PAINLEVE_CACHE``, else ``XDG_CACHE_HOME/painleve-sym``, else ``~/.cache/painleve-sym``. Where
    that cannot be written, or is not the user's own, a temporary folder with a notice.
    """
    named = os.environ.get("PAINLEVE_CACHE")
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    folder = Path(named or Path(base, "painleve-sym")).expanduser()
    problem = _make_private(folder)
    if problem is None:
        return folder
    return _temporary_cache(str(folder), problem)


def _make_private(folder: Path) -> str | None:
    """Create the folder with mode 0700; return why it cannot be used, or None."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        info = folder.stat()
        if info.st_uid != os.getuid():
            return "it belongs to another user"
        if stat.S_IMODE(info.st_mode) & 0o077:
            folder.chmod(0o700)
        with tempfile.TemporaryFile(dir=folder):
            return None
    except OSError as error:
        return error.strerror or str(error)


@functools.lru_cache(maxsize=8)
def _temporary_cache(folder: str, problem: str) -> Path:
    warnings.warn(
        f"cache folder {folder}: {problem}; compiled code is kept in a temporary folder for this "
        "run only. Fix: set PAINLEVE_CACHE to a folder of your own.",
        PainleveWarning,
        stacklevel=4,
    )
    return Path(tempfile.mkdtemp(prefix="painleve-sym-"))


def library_key(source: str, compiler: Compiler) -> str:
    """Return the hash that names the library: whole source, compiler, flags, processor."""
    return hashlib.sha256(f"{compiler.identity}\n{source}".encode()).hexdigest()[:40]


def compiled_library(source: str) -> Path:
    """Return the path of the shared library of `source`, compiling it when it is not cached.

    A source in parts (`c_functions.c_file`) keeps several processors busy.

    A cached file is used only if its content has the hash that is part of its name; a damaged or
    foreign one is removed and rebuilt. Two processes may build at once: each writes a file of its
    own and renames it.

    Raises
    ------
    CompilerMissing, CompileError
    """
    compiler, folder = find_compiler(), cache_folder()
    key = library_key(source, compiler)
    for path in folder.glob(f"{key}-*.so"):
        if path.stem.rpartition("-")[2] == _content_hash(path):
            return path
        path.unlink(missing_ok=True)
    return _build(source, compiler, folder, key)


def library_named(name: str) -> Path | None:
    """Return the cached library of that file name, or None where it is absent or damaged."""
    path = cache_folder() / name
    whole = path.name == name and path.stem.rpartition("-")[2] == _content_hash(path)
    return path if whole else None


def _content_hash(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()[:40]
    except OSError:
        return ""


def _build(source: str, compiler: Compiler, folder: Path, key: str) -> Path:
    with tempfile.TemporaryDirectory(dir=folder) as work:
        c_file, library = Path(work, "model.c"), Path(work, "model.so")
        c_file.write_text(source, "utf-8")
        inputs = _compiled_parts(source, compiler, c_file) or [c_file]
        _run(compiler, "-o", library, *inputs, "-lm")
        library.chmod(0o700)
        target = folder / f"{key}-{_content_hash(library)}.so"
        os.replace(library, target)
        return target


def _compiled_parts(source: str, compiler: Compiler, c_file: Path) -> list[Path]:
    """Compile the parts of a file, side by side where there are processors; none of one part."""
    parts = list(dict.fromkeys(_PART.findall(source)))
    if len(parts) < 2:
        return []

    def compiled(part: tuple[str, str]) -> Path:
        number, level = part
        target = c_file.with_name(f"part_{number}.o")
        _run(compiler, *filter(None, [level]), "-c", f"-DPS_PART={number}", "-o", target, c_file)
        return target

    with ThreadPoolExecutor(min(len(parts), os.cpu_count() or 1)) as pool:
        return list(pool.map(compiled, parts))


def _run(compiler: Compiler, *arguments: str | Path) -> None:
    command = [compiler.path, *FLAGS, *map(str, arguments)]
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    if answer.returncode != 0:
        raise CompileError(
            f"compiler {compiler.path} ({compiler.version}) failed with exit code "
            f"{answer.returncode}:\n{answer.stderr.strip()[-2000:]}"
        )


def load(source: str) -> ctypes.CDLL:
    """Compile `source` (or find it in the cache) and load it."""
    return ctypes.CDLL(str(compiled_library(source)))
