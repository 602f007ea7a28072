"""Small wrong changes of the package, each with the tests that must notice it."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIST = Path(__file__).with_name("mutants.toml")


@dataclass(frozen=True)
class Mutant:
    """A wrong change: `old`, which occurs once in `file`, becomes `new`.

    Attributes
    ----------
    name : str
        What is wrong, in a few words.
    file : str
        Path from the package's folder; pages are outside of it, such as ``../README.md``.
    old, new : str
    tests : tuple of str
        Node ids of pytest, from the folder of tests: one of them must fail.
    """

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    def occurrences(self) -> int:
        """Return how often `old` occurs in the file."""
        return (ROOT / "painleve_sym" / self.file).read_text("utf-8").count(self.old)

    def apply(self, package: Path) -> None:
        """Change a copy of the package."""
        path = package / self.file
        path.write_text(path.read_text("utf-8").replace(self.old, self.new), "utf-8")


def read_mutants() -> list[Mutant]:
    """Return the mutants of the list, in its order."""
    entries = tomllib.loads(LIST.read_text("utf-8"))["mutant"]
    return [Mutant(**(entry | {"tests": tuple(entry["tests"])})) for entry in entries]
