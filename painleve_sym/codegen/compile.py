"""C source to a loaded shared library, through a cache addressed by content."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import importlib.util
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from painleve_sym.cache import (
    COMPILER_LOG,
    PREFIX,
    ZIG_FOLDER,
    cache_folder,
    full,
    own_content,
    temporary_folder,
    work_folder,
)
from painleve_sym.errors import CompileError, CompilerMissing, InputError, PainleveError
from painleve_sym.system import library_suffix, on_windows

# Apple's compiler names its own processors by another flag.
_APPLE = (sys.platform, platform.machine()) == ("darwin", "arm64")
FLAGS = (
    "-O3",
    "-mcpu=native" if _APPLE else "-march=native",
    "-ffp-contract=off",
    "-fno-tree-slp-vectorize",
    # Code of Windows is always relocatable, and its compilers reject the flag.
    *(() if on_windows() else ("-fPIC",)),
    "-shared",
    "-fvisibility=hidden",
)
"""No fast-math and no contraction: a·d − b·c that is exactly zero must stay zero.

Vectors made of statements side by side are off: gcc 12 contracts there against the flag before
(products with sums and differences in turn become vfmaddsub).
"""


PORTABLE = tuple(flag for flag in FLAGS if "native" not in flag)
"""The flags of a library that other machines of its kind may run, too."""


def flags() -> tuple[str, ...]:
    """Return `FLAGS` with the level of optimization that PAINLEVE_OPTIMIZE names, 0 to 3.

    It takes the place of the level of every part: code of a lower one is compiled sooner, runs
    longer and computes the same numbers.

    Raises
    ------
    InputError
        For any other value.
    """
    level = os.environ.get("PAINLEVE_OPTIMIZE", "").strip()
    if level and level not in tuple("0123"):
        raise InputError(
            f"variable PAINLEVE_OPTIMIZE: got {level!r}, need 0, 1, 2 or 3. Fix: unset it."
        )
    return (*FLAGS, f"-O{level}") if level else FLAGS


_PART = re.compile(r"^#if PS_HAS\((\d+)\)(?: /\* (-O\w[\w= -]*) \*/)?$", re.M)
"""A part of a file, and how far it is to be optimized where that is not as in `FLAGS`."""
_PROGRAMS = (("cc",), ("gcc",), ("clang",))
# Where it optimizes little, zig adds checks of its own, of which a shared library has no part.
_ZIG = (sys.executable, "-m", "ziglang", "cc", "-fno-sanitize=undefined")
_LOOKED_FOR = "cc, gcc, clang and the package ziglang"


@dataclass(frozen=True)
class Compiler:
    """A C compiler that was asked for its version: program, with arguments before all others."""

    command: tuple[str, ...]
    version: str

    @property
    def identity(self) -> str:
        """Version, arguments, flags and processor: what makes the machine code with the source."""
        arguments = " ".join((*self.command[1:], *flags()))
        return "\n".join((self.version, arguments, platform.machine(), _processor()))

    def __str__(self) -> str:
        return shlex.join(self.command)


def _answer(command: Sequence[str], **options: Any) -> subprocess.CompletedProcess[str]:
    """Run a program to its end, and return its output."""
    pipes: Any = {"stdin": subprocess.DEVNULL, "capture_output": True}
    return subprocess.run(command, text=True, errors="replace", **pipes, **options)


@functools.lru_cache(maxsize=1)
def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            return next((line for line in lines if line.startswith(("flags", "Features"))), "")
    except OSError:
        pass
    try:
        # macOS.
        command = ["sysctl", "-n", "machdep.cpu.brand_string"]
        return _answer(command, timeout=30, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return platform.processor()


def _candidates() -> list[tuple[str, ...]]:
    """Return the commands that may be a compiler, best first; only that in CC where it is set."""
    if named := os.environ.get("CC", "").strip():
        try:
            # A path may hold spaces, and a command arguments.
            words = [named] if shutil.which(named) else shlex.split(named)
        except ValueError:
            words = [named]
        return [tuple(words)]
    return [*_PROGRAMS, *([_ZIG] if _zig_program() else [])]


def _zig_program() -> Path | None:
    package = importlib.util.find_spec("ziglang") if sys.executable else None
    places = (package and package.submodule_search_locations) or ()
    program = "zig.exe" if on_windows() else "zig"
    return next((Path(place, program) for place in places), None)


@functools.lru_cache(maxsize=16)
def _version(command: tuple[str, ...]) -> str | None:
    """Return the first line of a compiler's version, or None without one."""
    try:
        answer = _answer([*command, "--version"], timeout=30, check=True)
    except (OSError, ValueError, subprocess.SubprocessError):
        return None
    return answer.stdout.splitlines()[0] if answer.stdout else command[0]


def _compilers() -> Iterator[Compiler]:
    """Yield the compilers that say their version, each asked when it is its turn."""
    for command in _candidates():
        path = shutil.which(command[0])
        if path is None:
            continue
        whole = (path, *command[1:])
        if (version := _version(whole)) is not None:
            yield Compiler(whole, version)


def find_compiler() -> Compiler:
    """Return the compiler named by the variable CC, else cc, gcc, clang or that of ziglang.

    Raises
    ------
    CompilerMissing
        None of them compiles a small program.
    """
    faults = []
    for compiler in _compilers():
        if (fault := _fault(compiler)) is None:
            return compiler
        faults.append(fault)
    raise _no_compiler(faults)


def _no_compiler(faults: Sequence[str]) -> CompilerMissing:
    named = os.environ.get("CC", "").strip()
    tried = f"the variable CC names {named!r}" if named else f"looked for {_LOOKED_FOR}"
    return CompilerMissing(
        f"no working C compiler: {'; '.join((tried, *faults))}. Fix: install gcc (Debian, Ubuntu: "
        "apt install gcc) or run pip install 'painleve-sym[compiler]', and name a working compiler "
        "in the variable CC or unset it."
    )


@functools.lru_cache(maxsize=16)
def _fault(compiler: Compiler) -> str | None:
    """Return why a compiler cannot make a library of a small program, or None where it can."""
    text = "#include <math.h>\ndouble probe(double x) { return sin(x); }\n"
    try:
        with tempfile.TemporaryDirectory() as work:
            source = Path(work, "probe.c")
            source.write_text(text, "ascii")
            _run(compiler, Path(work, f"probe{library_suffix()}"), source, "-lm")
    except CompileError as error:
        return str(error).partition(" Fix:")[0].rstrip(".")
    except OSError as error:
        return f"temporary folder: {error.strerror or error}"
    return None


def compiler_mark() -> str | None:
    """Return a text that differs between compilers, flags and processors, without running any.

    The files of the compilers that `find_compiler` would try, by place, size and time, and their
    arguments; None where there is none.
    """
    marks = []
    try:
        for command in _candidates():
            path = _zig_program() if command is _ZIG else shutil.which(command[0])
            if path:
                real, info = os.path.realpath(path), os.stat(path)
                place = f"{path} {real} {info.st_size} {info.st_mtime_ns}"
                marks.append(" ".join((place, *command[1:])))
    except OSError:
        return None
    return "\n".join((*marks, *flags(), platform.machine(), _processor())) if marks else None


def library_key(source: str, compiler: Compiler) -> str:
    """Return the hash that names the library: whole source, compiler, flags, processor."""
    return hashlib.sha256(f"{compiler.identity}\n{source}".encode()).hexdigest()[:40]


def compiled_library(source: str) -> Path:
    """Return the path of the shared library of `source`, compiling it when it is not cached.

    A source in parts (`c_functions.c_file`) keeps several processors busy.

    A cached file is used only if its user alone can have written it and its content has the
    hash that is part of its name; any other is removed and rebuilt. Two processes may build at
    once: each writes a file of its own and renames it.

    Raises
    ------
    CompilerMissing
        Also where a compiler makes nothing, even of a small program.
    CompileError
        A compiler that works rejects the source.
    """
    faults = []
    for compiler in _compilers():
        folder, key = cache_folder(), library_key(source, compiler)
        for path in folder.glob(f"{PREFIX}{key}-*{library_suffix()}"):
            if _is_whole(path):
                return path
            with suppress(OSError):
                path.unlink()
        try:
            return _build_where_there_is_room(source, compiler, folder, key)
        except CompileError:
            if (fault := _fault(compiler)) is None:
                raise
            faults.append(fault)
    raise _no_compiler(faults)


def library_named(name: str) -> Path | None:
    """Return the cached library of that file name, or None where it is absent or damaged."""
    path = cache_folder() / name
    return path if path.name == name and _is_whole(path) else None


def _is_whole(path: Path) -> bool:
    """Whether a library is the user's own and has the content that its name says."""
    content = own_content(path)
    return content is not None and path.stem.rpartition("-")[2] == _content_hash(content)


def _content_hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:40]


def _build_where_there_is_room(source: str, compiler: Compiler, folder: Path, key: str) -> Path:
    """Build in the cache, or in a temporary folder where the cache's disk is full."""
    try:
        return _build(source, compiler, folder, key)
    except OSError as error:
        problem = error.strerror or str(error)
    except CompileError:
        if (reason := full(folder)) is None:
            raise
        problem = reason
    try:
        return _build(source, compiler, temporary_folder(folder, problem), key)
    except OSError as error:
        raise CompilerMissing(
            f"no place for compiled code: cache folder {folder}: {problem}; temporary folder: "
            f"{error.strerror or error}. Fix: make room, or set PAINLEVE_CACHE to a folder "
            "with room."
        ) from error


def _build(source: str, compiler: Compiler, folder: Path, key: str) -> Path:
    with work_folder(folder) as work:
        library = Path(work, f"model{library_suffix()}")
        _run(compiler, library, *_compiled_parts(source, compiler, library.parent), "-lm")
        library.chmod(0o700)
        target = folder / f"{PREFIX}{key}-{_content_hash(library.read_bytes())}{library_suffix()}"
        os.replace(library, target)
        return target


def _compiled_parts(source: str, compiler: Compiler, folder: Path) -> list[Path]:
    """Compile the parts of a file, side by side where there are processors.

    Where nothing is optimized the file is compiled as a whole: reading what the parts have in
    common would take a third of the time.
    """
    heads = [] if flags()[-1] == "-O0" else list(_PART.finditer(source))
    ends = [*(head.start() for head in heads[1:]), len(source)]

    def compiled(head: re.Match[str], end: int) -> Path:
        number, level = head.groups(default="")
        c_file = folder / f"part_{number}.c"
        # Reading the other parts would take as long as compiling a small one.
        c_file.write_text(source[: heads[0].start()] + source[head.start() : end], "utf-8")
        target = c_file.with_suffix(".o")
        _run(compiler, target, *level.split(), "-c", f"-DPS_PART={number}", c_file)
        return target

    if len(heads) < 2:
        c_file = folder / "model.c"
        c_file.write_text(source, "utf-8")
        return [c_file]
    # The event loop, part 0, takes longest: nothing should wait for it alone.
    parts = sorted(zip(heads, ends, strict=True), key=lambda part: part[0][1] != "0")
    with ThreadPoolExecutor(min(len(parts), os.cpu_count() or 1)) as pool:
        return list(pool.map(compiled, *zip(*parts, strict=True)))


def portable_library(texts: Mapping[str, str], source: str) -> bytes:
    """Return a shared library of one C file, `source` among texts by file name.

    It runs on any machine of this kind, whatever its processor has.

    Raises
    ------
    CompilerMissing, CompileError
    """
    compiler = find_compiler()
    native = ("-mcpu=baseline",) if "ziglang" in compiler.command else ()
    with work_folder(cache_folder()) as work:
        for name, text in texts.items():
            Path(work, name).write_text(text, "utf-8")
        library = Path(work, "unit.so")
        _run(compiler, library, *native, Path(work, source), "-lm", common=PORTABLE)
        return library.read_bytes()


def _run(
    compiler: Compiler, target: Path, *arguments: str | Path, common: Sequence[str] = FLAGS
) -> None:
    """Make `target`; CompileError where the compiler fails, or makes no file."""
    # A level that was asked for comes last: it decides.
    level = flags()[len(FLAGS) :]
    command = [*compiler.command, *common, "-o", *map(str, (target, *arguments)), *level]
    try:
        answer = _answer(command, env=environment(target.parent))
    except OSError as error:
        raise CompileError(f"compiler {compiler} cannot be run: {error.strerror}") from error
    if answer.returncode != 0 or not target.exists():
        raise rejection(f"{compiler} ({compiler.version})", answer)


_REMEDY = "name another compiler in the variable CC; if that one fails, too, please report it"


def rejection(
    compiler: str, answer: subprocess.CompletedProcess[str], remedy: str = _REMEDY
) -> CompileError:
    """Return the error of a compiler that made nothing; its text is kept in a file of the cache."""
    text = answer.stderr.strip()
    failed = f"exit code {answer.returncode}" if answer.returncode else "it wrote no file"
    kept = ""
    with suppress(OSError, PainleveError):
        log = cache_folder() / COMPILER_LOG
        log.write_text(f"{shlex.join(map(str, answer.args))}\n{text}\n", "utf-8")
        kept = f" Its text is in {log}."
    return CompileError(
        f"compiler {compiler} does not compile the generated code ({failed}).{kept} Fix: {remedy}.",
        text,
    )


def environment(work: Path) -> dict[str, str]:
    """Return the environment of a compiler; ziglang keeps its own libraries in the cache."""
    shared = str(cache_folder() / ZIG_FOLDER)
    own = {"ZIG_GLOBAL_CACHE_DIR": shared, "ZIG_LOCAL_CACHE_DIR": str(work / "zig")}
    return {**own, **os.environ}


def load(source: str) -> ctypes.CDLL:
    """Compile `source` (or find it in the cache) and load it."""
    return ctypes.CDLL(str(compiled_library(source)))
