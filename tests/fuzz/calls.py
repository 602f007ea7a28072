"""One input in this process: what the program answers, and what of that is a fault."""

from __future__ import annotations

import builtins
import json
import os
import pickle
import shutil
import sys
import tempfile
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from painleve_sym.cli import main
from painleve_sym.codegen import quantities
from painleve_sym.errors import StopReason
from painleve_sym.study.sweeps.store import open_store, parts_folder
from painleve_sym.study.sweeps.sweep import Sweep
from tests.fuzz.inputs import CANARY, ROOT, FuzzInput, damaged

DOCUMENTED = (0, 1, 2, 3)
"""Exit codes that a call in this process may have."""
MAX_LINE = 12_000
"""Characters of an error line."""


@dataclass(frozen=True)
class Outcome:
    """Answer of one call.

    Attributes
    ----------
    code : int or None
        Exit code; None where an exception escaped.
    faults : tuple of str
        What is wrong with it; empty where nothing is.
    error : str
        Begin of what it wrote to standard error.
    """

    code: int | None
    faults: tuple[str, ...]
    error: str


def call(given: FuzzInput, store: Path) -> Outcome:
    """Run an input in a new folder and judge the answer.

    Parameters
    ----------
    given : FuzzInput
    store : Path
        Where what the program itself writes (cache, chunks) is kept whole, to be damaged.
    """
    executed: list[object] = []
    setattr(builtins, CANARY, executed.append)
    with tempfile.TemporaryDirectory(prefix="painleve-fuzz-") as name, _in_folder(name):
        folder = Path(name)
        for file, content in given.files.items():
            (folder / file).write_bytes(content)
        with _damaged_store(given, store, folder), warnings.catch_warnings():
            warnings.simplefilter("always")
            warnings.showwarning = _show
            before = {p.name for p in folder.iterdir()}
            with _captured() as streams:
                code, escaped = _code(list(given.arguments))
            written = {p.name for p in folder.iterdir()} - before
        out, error = streams
        faults = [f"traceback: {escaped}"] if escaped else list(_faults(given, code, out, error))
        if code == 2 and any(not n.endswith(".parts") for n in written):
            faults.append(f"bad input, but written: {sorted(written)}")
        if given.kind == "chunk" and code == 0:
            whole = (store / "whole.npz").read_bytes()
            if (folder / "o.npz").read_bytes() != whole:
                faults.append("the result differs from the one of undamaged chunks")
    if executed:
        faults.append("text of the input was executed")
    return Outcome(code, tuple(faults), error[:2000])


def _code(arguments: list[str]) -> tuple[int | None, str]:
    try:
        return main(arguments), ""
    except BaseException as error:
        frames = traceback.extract_tb(error.__traceback__)
        own = [f for f in frames if f"{os.sep}painleve_sym{os.sep}" in f.filename] or list(frames)
        places = [f"{Path(f.filename).name}:{f.lineno}" for f in own[-3:]]
        return None, f"{type(error).__name__}: {str(error)[:200]} ({' < '.join(places[::-1])})"


def _faults(given: FuzzInput, code: int | None, out: str, error: str) -> Iterator[str]:
    if code not in DOCUMENTED:
        yield f"exit code {code}"
    lines = error.splitlines()
    other = [line for line in lines if not line.startswith("painleve: ")]
    if other:
        yield f"on standard error: {other[0][:300]}"
    errors = [line for line in lines if line.startswith("painleve: error: ")]
    if (code in (1, 2)) != (len(errors) == 1):
        yield f"exit code {code} with {len(errors)} error lines"
    if any(len(line) > MAX_LINE for line in lines):
        yield f"a line of {max(map(len, lines))} characters on standard error"
    if code == 2 and out:
        yield f"bad input, but output: {out[:100]}"
    if code in (0, 3) and "--json" in given.arguments and "--help" not in given.arguments:
        try:
            json.loads(out, parse_constant=_refused)
        except ValueError as reason:
            yield f"not JSON: {reason}"
    # A motion may end in any way; other answers that are computed hold numbers. A name or a unit of
    # the input may be nan.
    reasons = [r.label for r in StopReason]
    named = any(b"nan" in content for content in given.files.values())
    if code == 0 and not named and " nan" in out and not any(r in out for r in reasons):
        line = next(line for line in out.splitlines() if " nan" in line)
        yield f"nan in the answer: {line[:100]}"


def _show(
    message: Warning | str, category: type[Warning], filename: str, lineno: int, *_: object
) -> None:
    print(f"{filename}:{lineno}: {category.__name__}: {message}", file=sys.stderr)


def _refused(name: str) -> None:
    raise ValueError(f"{name} is not JSON")


@contextmanager
def _in_folder(name: str) -> Iterator[None]:
    before = os.getcwd()
    os.chdir(name)
    try:
        yield
    finally:
        os.chdir(before)


@contextmanager
def _captured() -> Iterator[list[str]]:
    """Collect what is written to both streams, also by compiled code: [output, errors]."""
    texts: list[str] = []
    streams = sys.stdout, sys.stderr
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as error:
        kept = [os.dup(1), os.dup(2)]
        os.dup2(out.fileno(), 1)
        os.dup2(error.fileno(), 2)
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        try:
            yield texts
        finally:
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
            sys.stdout, sys.stderr = streams
            for number, descriptor in enumerate(kept, 1):
                os.dup2(descriptor, number)
                os.close(descriptor)
            for file in (out, error):
                file.seek(0)
                texts.append(file.read().decode("utf-8", "replace"))


# ---- what the program itself wrote ----


def make_store(store: Path) -> None:
    """Write what inputs of the kinds cache and chunk damage, unless it is there."""
    from tests.fuzz.inputs import input_of

    if (store / "whole.npz").exists():
        return
    (store / "cache").mkdir(parents=True, exist_ok=True)
    with _cache(store / "cache"):
        call(FuzzInput("command", input_of("cache", 0).arguments), store)
    text = input_of("chunk", 0).files["f.toml"].decode()
    sweep, out = Sweep.from_text(text, "f.toml"), store / "o.npz"
    with open_store(out, sweep, sweep.check_run()) as chunks:
        for start in chunks.missing():
            chunks.write(start, sweep.compute(start, sweep.stop(start)))
        shutil.copytree(parts_folder(out), store / "parts", dirs_exist_ok=True)
        chunks.finish(store / "whole.npz")


@contextmanager
def _damaged_store(given: FuzzInput, store: Path, folder: Path) -> Iterator[None]:
    if given.kind not in ("cache", "chunk"):
        yield
        return
    source, name = {"cache": ("cache", "cache"), "chunk": ("parts", "o.npz.parts")}[given.kind]
    copy = folder / name
    shutil.copytree(store / source, copy)
    # A library that is damaged is the compiler's cache, and loading it would end this process.
    files = sorted(p for p in copy.rglob("*") if p.is_file() and p.suffix != ".so")
    for choice, place, action in given.damage:
        path = files[choice % len(files)]
        path.write_bytes(damaged(path.read_bytes(), place, action))
    if given.kind == "chunk":
        yield
        return
    with _cache(copy):
        yield


@contextmanager
def _cache(folder: Path) -> Iterator[None]:
    before = os.environ.get("PAINLEVE_CACHE")
    os.environ["PAINLEVE_CACHE"] = str(folder)
    quantities._stored.cache_clear()
    try:
        yield
    finally:
        quantities._stored.cache_clear()
        if before is None:
            del os.environ["PAINLEVE_CACHE"]
        else:
            os.environ["PAINLEVE_CACHE"] = before


# ---- a process that answers one input after the other ----


def serve(store: Path) -> None:
    """Read pickled inputs from standard input and write pickled outcomes to standard output."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    while True:
        try:
            given = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        pickle.dump(call(given, store), answers)
        answers.flush()


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    serve(Path(sys.argv[1]))
