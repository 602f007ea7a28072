"""In which line of a TOML text each entry stands: `tomllib` gives the values without places."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Path = tuple[str | int, ...]
"""Keys from the top of the file; numbers count the tables of an array, or its elements, from 0."""

_BARE_ENDS = frozenset(" \t\r\n=.]")
_VALUE_ENDS = frozenset(",]}#\r\n")


@dataclass(frozen=True)
class TomlLines:
    """Lines of the entries of a TOML text, counted from 1.

    Attributes
    ----------
    keys : mapping of path to int
        Where the key, the header of the table or the element of the array stands.
    texts : mapping of path to int
        Where the value begins; for text of several lines, its first line.
    """

    keys: Mapping[Path, int]
    texts: Mapping[Path, int]

    def of(self, path: Path) -> int:
        """Return the line of an entry, or of the nearest table that holds it."""
        while path and path not in self.keys:
            path = path[:-1]
        return self.keys.get(path, 1)

    def of_text(self, path: Path, line: int = 0) -> int:
        """Return the line of the file in which line `line` (from 0) of a text entry stands."""
        return self.texts[path] + line if path in self.texts else self.of(path)


def toml_lines(text: str) -> TomlLines:
    """Return the lines of a text that `tomllib` has accepted."""
    return _Scanner(text.replace("\r\n", "\n")).scan()


@dataclass
class _Scanner:
    text: str
    at: int = 0
    line: int = 1
    keys: dict[Path, int] = field(default_factory=dict)
    texts: dict[Path, int] = field(default_factory=dict)
    counts: dict[Path, int] = field(default_factory=dict)

    def scan(self) -> TomlLines:
        table: Path = ()
        while self.skip_blank(lines=True):
            if self.text[self.at] == "[":
                table = self.header()
            else:
                self.pair(table)
        return TomlLines(self.keys, self.texts)

    def skip_blank(self, lines: bool = False) -> bool:
        """Move to the next character that says something; False at the end of the text."""
        blank = " \t\n" if lines else " \t"
        while self.at < len(self.text):
            char = self.text[self.at]
            if char == "#" and lines:
                end = self.text.find("\n", self.at)
                self.at = len(self.text) if end < 0 else end
            elif char in blank:
                self.advance(1)
            else:
                return True
        return False

    def advance(self, count: int) -> None:
        self.line += self.text.count("\n", self.at, self.at + count)
        self.at += count

    def header(self) -> Path:
        many = self.text.startswith("[[", self.at)
        self.advance(2 if many else 1)
        line = self.line
        names = self.names("]")
        self.advance(2 if many else 1)
        path = (*self.in_last(names[:-1]), names[-1])
        for length in range(1, len(path)):
            self.keys.setdefault(path[:length], line)
        if many:
            number = self.counts.get(path, -1) + 1
            self.counts[path] = number
            self.keys.setdefault(path, line)
            path = (*path, number)
        self.keys.setdefault(path, line)
        return path

    def in_last(self, names: Path) -> Path:
        """Return the path with the number of the last table wherever it goes through an array."""
        path: Path = ()
        for name in names:
            path = (*path, name)
            if path in self.counts:
                path = (*path, self.counts[path])
        return path

    def names(self, end: str) -> tuple[str, ...]:
        """Read a dotted key up to `end`, which is left to be read."""
        found = []
        while True:
            self.skip_blank()
            char = self.text[self.at]
            if char in "\"'":
                found.append(self.string())
            else:
                start = self.at
                while self.text[self.at] not in _BARE_ENDS:
                    self.at += 1
                found.append(self.text[start : self.at])
            self.skip_blank()
            if self.text[self.at] == end:
                return tuple(found)
            self.advance(1)

    def pair(self, table: Path) -> None:
        line = self.line
        path = (*table, *self.names("="))
        for length in range(len(table) + 1, len(path) + 1):
            self.keys.setdefault(path[:length], line)
        self.advance(1)
        self.value(path)

    def value(self, path: Path) -> None:
        self.skip_blank(lines=True)
        char = self.text[self.at]
        self.texts[path] = self.line
        if char in "\"'":
            # A line end right after the opening quotes is no part of the text.
            opens = self.text[self.at : self.at + 3] in ('"""', "'''")
            if opens and self.text[self.at + 3 : self.at + 4] == "\n":
                self.texts[path] += 1
            self.string()
        elif char == "[":
            self.sequence(path, "]")
        elif char == "{":
            self.sequence(path, "}")
        else:
            while self.at < len(self.text) and self.text[self.at] not in _VALUE_ENDS:
                self.at += 1

    def sequence(self, path: Path, end: str) -> None:
        self.advance(1)
        number = 0
        while True:
            self.skip_blank(lines=True)
            char = self.text[self.at]
            if char == end:
                self.advance(1)
                return
            if char == ",":
                self.advance(1)
            elif end == "}":
                self.pair(path)
            else:
                self.keys[(*path, number)] = self.line
                self.value((*path, number))
                number += 1

    def string(self) -> str:
        """Read a string of any kind and return its raw inside."""
        quote = self.text[self.at]
        triple = quote * 3
        closing = triple if self.text.startswith(triple, self.at) else quote
        begin = place = self.at + len(closing)
        while not self.text.startswith(closing, place):
            place += 2 if quote == '"' and self.text[place] == "\\" else 1
        # Up to two quotes may stand right before the closing ones.
        while closing == triple and self.text.startswith(quote, place + 3):
            place += 1
        inside = self.text[begin:place]
        self.advance(place + len(closing) - self.at)
        return inside
