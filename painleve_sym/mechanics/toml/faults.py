"""Faults of a file: every one with its line, raised together."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from painleve_sym.errors import MAX_NAME, InputError, ModelError, refuse_faulty, shortened
from painleve_sym.mechanics.toml.lines import Path, TomlLines

MAX_FAULTS_READ = 200
"""Faults after which reading stops: more would not be read, and a file of faults takes long."""


def shown(path: Path) -> str:
    """Return a path as a reader of the file would say it: ``contacts[1].point``."""
    text = ""
    for key in path:
        if isinstance(key, int):
            text += f"[{key + 1}]"
        else:
            text += f"{'.' if text else ''}{shortened(key, MAX_NAME)}"
    return text


class Faults:
    """The faults of a text while it is read.

    `where` is the name of the text. Without its `lines`, as of data that stand in no file, faults
    are named by their place alone.
    """

    def __init__(self, where: str, lines: TomlLines | None) -> None:
        self.where, self.lines = where, lines
        self.faults: list[tuple[int, str]] = []

    def fault(self, path: Path, message: str, line: int | None = None) -> None:
        """Note a fault of an entry; one of the same line and text only once."""
        number = self.lines.of(path) if line is None and self.lines else line or 0
        name = shown(path)
        # A message may begin with the place, or with one inside it.
        names_it = bool(name) and message.startswith((f"{name}:", f"{name}.", f"{name}["))
        place = [f"line {number}"] * bool(number) + [name] * (bool(name) and not names_it)
        separator = ", " if names_it else ": "
        entry = (number, f"{', '.join(place)}{separator}{message}" if place else message)
        if entry in self.faults:
            return
        self.faults.append(entry)
        if len(self.faults) == MAX_FAULTS_READ:
            stopped = f"Reading stopped after {MAX_FAULTS_READ} faults."
            raise ModelError(self.where, [*self.in_order, stopped])

    @property
    def in_order(self) -> list[str]:
        """The faults in the order of the file."""
        return [text for _, text in sorted(self.faults)]

    @contextmanager
    def at(self, *path: str | int) -> Iterator[None]:
        """Record errors inside as faults of this entry, and continue after it."""
        try:
            yield
        except InputError as error:
            self.fault(path, str(error).removeprefix(f"{self.where}: "))

    def raise_if_faulty(self) -> None:
        """Raise ModelError with all faults in the order of the file."""
        refuse_faulty(self.where, self.in_order)
