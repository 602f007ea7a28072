"""Apply each wrong change of the list to a copy of the package and run its tests: ``make mutants``.

The checkout is never edited. The tests also run on an unchanged copy, where all of them must pass:
a test that fails anyway would notice everything. Every copy has a cache of its own, which begins
with what the unchanged one has derived and compiled: entries are known by the code that makes them.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from pathlib import Path

from tests.mutants.mutants import ROOT, Mutant, read_mutants

NEEDED = 0.95
"""Share of the whole list that must be noticed."""
PASSED, FAILED, ENDLESS = 0, 1, -1
"""Exit statuses of pytest: every test passed, or a test failed; or it had to be stopped."""
LIMIT = 120.0
"""Time, s, after which the tests of one mutant are stopped: they take seconds, unless its change
leaves a motion without an end."""


def run_tests(
    tests: Sequence[str], cache: Path, mutant: Mutant | None = None
) -> tuple[int, str, float]:
    """Run tests on a copy of the package, with the change of a mutant where one is given.

    Parameters
    ----------
    tests : sequence of str
    cache : Path
        The cache of the unchanged copy.
    mutant : Mutant, optional
        Its cache is a copy.

    Returns
    -------
    status : int
        Exit status of pytest, or `ENDLESS`.
    output : str
    seconds : float
    """
    started = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="painleve-mutant-") as folder:
        copy = Path(folder, "copy")
        # With what Python compiled of it: it knows a changed file by its date.
        for part in ("painleve_sym", "tests", "examples"):
            shutil.copytree(ROOT / part, copy / part)
        # Pages, without those that a build of the site made.
        generated = shutil.ignore_patterns("_generated", "gallery", "api", "json")
        shutil.copytree(ROOT / "docs", copy / "docs", ignore=generated)
        for file in ("pyproject.toml", "Makefile", *(p.name for p in ROOT.glob("*.md"))):
            shutil.copy2(ROOT / file, copy)
        if mutant is not None:
            mutant.apply(copy / "painleve_sym")
            cache = linked(cache, Path(folder, "cache"))
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
        own = {"PYTHONPATH": str(copy), "PAINLEVE_CACHE": str(cache)}
        try:
            done = subprocess.run(
                [*command, "-p", "no:xdist", *(f"tests/{test}" for test in tests)],
                cwd=copy,
                env={**os.environ, **own},
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                check=False,
                timeout=None if mutant is None else LIMIT,
            )
        except subprocess.TimeoutExpired:
            return ENDLESS, "", time.monotonic() - started
    return done.returncode, done.stdout, time.monotonic() - started


def linked(cache: Path, target: Path) -> Path:
    """Return a new folder with links to the entries of a cache, in which others may be made.

    A process never writes in an entry: it makes a file and gives it the name.
    """
    target.mkdir(mode=0o700)
    for entry in cache.glob("*.*"):
        with suppress(FileNotFoundError):
            if entry.is_file():
                os.link(entry, target / entry.name)
    return target


def verdict(mutant: Mutant, cache: Path) -> tuple[str, float]:
    """Return what became of a mutant, and the seconds it took."""
    if mutant.occurrences() != 1:
        return "does not apply", 0.0
    status, output, seconds = run_tests(mutant.tests, cache, mutant)
    if status in (FAILED, ENDLESS):
        return "noticed", seconds
    if status == PASSED:
        return "not noticed", seconds
    print(output, file=sys.stderr)
    return "tests do not run", seconds


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="mutants at the same time")
    parser.add_argument("--only", metavar="TEXT", help="mutants whose name or file contains TEXT")
    options = parser.parse_args(arguments)
    text = options.only or ""
    mutants = [m for m in read_mutants() if text in m.name or text in m.file]
    if not mutants:
        parser.error(f"--only: got {text!r}, which no mutant's name or file contains.")
    tests = sorted({test for m in mutants for test in m.tests})
    with (
        tempfile.TemporaryDirectory(prefix="painleve-mutants-") as folder,
        ThreadPoolExecutor(options.jobs) as pool,
    ):
        unchanged = pool.submit(run_tests, tests, Path(folder))
        running = {pool.submit(verdict, mutant, Path(folder)): mutant for mutant in mutants}
        counts: dict[str, int] = {}
        for done in as_completed(running):
            mutant, (word, seconds) = running[done], done.result()
            counts[word] = counts.get(word, 0) + 1
            print(f"{word:16s} {seconds:5.0f} s  {mutant.file:36s} {mutant.name}", flush=True)
        status, output, seconds = unchanged.result()
    if status != PASSED:
        print(f"The tests do not pass on the unchanged package:\n{output}")
    noticed = counts.get("noticed", 0)
    print(f"{noticed} of {len(mutants)} noticed; unchanged, the tests took {seconds:.0f} s.")
    applied = set(counts) <= {"noticed", "not noticed"}
    enough = noticed >= len(mutants) * (1 if options.only else NEEDED)
    return 0 if applied and enough and status == PASSED else 1


if __name__ == "__main__":
    sys.exit(main())
