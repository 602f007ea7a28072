"""From the C of a module to WebAssembly, by clang or by the compiler of the package ziglang."""

from __future__ import annotations

import base64
import functools
import hashlib
import importlib.util
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from painleve_sym.cache import read_entry, write_entry
from painleve_sym.codegen.compile import environment, rejection
from painleve_sym.codegen.derivation_cache import ENGINE, entry_key
from painleve_sym.errors import CompileError, CompilerMissing
from painleve_sym.explorer.prebuilt import STORED
from painleve_sym.explorer.source import ModuleSource

FLAGS = ("-O2", "-ffp-contract=off", "-mexec-model=reactor", "-Wl,--strip-all")
"""No contraction, as in the package's own code; with names of functions it would be ten times as
long."""

_MADE_BY = (*ENGINE, "problem", "motion", "study", "c_export", "explorer")
"""Folders of the package that write a module and its description."""
_CLANG = ("--target=wasm32-wasi",)
_PLACES = ("/usr", "/opt/wasi-sdk/share/wasi-sysroot", "/usr/share/wasi-sysroot")


def module(source: ModuleSource) -> bytes:
    """Return the WebAssembly module of a mechanism with its laws, from the cache where it is there.

    CompilerMissing where neither clang with the C library of WASI nor the package ziglang is
    installed; CompileError where a compiler that works rejects the code.
    """
    key = _key(source)
    if stored := read_entry(key):
        return _code(stored)
    command = compiler()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as work:
        for name, text in source.files.items():
            Path(work, name).write_text(text, "utf-8")
        code = _compiled(command, work, source.units)
    write_entry(key, {"module": base64.b64encode(code).decode("ascii")})
    return code


def described_module(source: ModuleSource) -> tuple[dict[str, Any], Callable[[], bytes]]:
    """Return the description of a module, and the function that returns the module; see `module`.

    Where the cache has both nothing is derived.
    """
    key = entry_key("explorer", source, by=_MADE_BY)
    entry = read_entry(key) if key else None
    stored = read_entry(entry["module"]) if entry else None
    if entry and stored:
        return entry["description"], partial(_code, stored)

    def compiled() -> bytes:
        code = module(source)
        if key:
            write_entry(key, {"description": source.description, "module": _key(source)})
        return code

    return source.description, compiled


def _key(source: ModuleSource) -> str:
    text = "\n".join((*FLAGS, *source.units, *source.files.values()))
    return hashlib.sha256(text.encode()).hexdigest()[:40]


def _code(stored: Mapping[str, Any]) -> bytes:
    return base64.b64decode(stored["module"])


@functools.cache
def compiler() -> tuple[str, ...]:
    """Return the command of the first compiler that makes a module of a small program."""
    for command in _candidates():
        try:
            with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as work:
                Path(work, "probe.c").write_text(
                    "#include <math.h>\n#include <stdlib.h>\n"
                    '__attribute__((export_name("probe"))) double probe(double x) '
                    "{ return sin(x) + (malloc(8) != 0); }\n",
                    "ascii",
                )
                _compiled(command, work, ("probe.c",))
        except CompileError:
            continue
        return command
    raise CompilerMissing(
        "no compiler for WebAssembly: looked for clang with wasi-libc, and the package ziglang. "
        "Fix: run pip install 'painleve-sym[web]', or install clang, lld, wasi-libc and "
        f"libclang-rt-dev-wasm32; the {STORED} with its default law needs neither."
    )


def _candidates() -> Iterator[tuple[str, ...]]:
    clang = shutil.which("clang")
    for place in _PLACES:
        if clang and Path(place, "include/wasm32-wasi").is_dir():
            yield (clang, *_CLANG, f"--sysroot={place}")
    if importlib.util.find_spec("ziglang") and sys.executable:
        yield (sys.executable, "-m", "ziglang", "cc", "-target", "wasm32-wasi")


def _compiled(command: tuple[str, ...], work: str, units: tuple[str, ...]) -> bytes:
    target = Path(work, "module.wasm")
    arguments = [*command, *FLAGS, "-o", target.name, *units]
    try:
        answer = subprocess.run(
            arguments,
            cwd=work,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
            env=environment(Path(work)),
        )
    except OSError as error:
        raise CompileError(f"compiler {command[0]} cannot be run: {error.strerror}") from error
    if answer.returncode != 0 or not target.exists():
        raise rejection(command[0], answer, "install the package ziglang, or please report it")
    return target.read_bytes()
