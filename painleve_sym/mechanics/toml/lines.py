"""In which line of a TOML text each entry stands: `tomllib` gives the values without places."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

Path = tuple[str | int, ...]
"""Keys from the top of the file; numbers count the tables of an array, or its elements, from 0."""

# Texts first, those in three quotes before those in one; up to two quotes may stand right before
# three closing ones. What matches nothing here is blank.
_TOKENS = re.compile(
    r'''"""(?:\\.|[^\\])*?"{3,5}'''
    r"""|'''.*?'{3,5}"""
    r'''|"(?:\\.|[^"\\])*"'''
    r"""|'[^']*'"""
    r"""|\#[^\n]*"""
    r"""|[\n\[\]{}=,.]"""
    r"""|[^\s\[\]{}=,.\#"']+""",
    re.DOTALL,
)
_VALUE_ENDS = ("\n", ",", "]", "}")


@dataclass(frozen=True)
class TomlLines:
    """Lines of the entries of a TOML text, counted from 1.

    `keys`: where the key, the header of the table or the element of the array stands. `texts`:
    where the value begins; for text of several lines, its first line.
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
    tokens, line = [], 1
    text = text.replace("\r\n", "\n")
    for match in _TOKENS.finditer(text):
        if not match[0].startswith("#"):
            tokens.append((match[0], line))
        line += match[0].count("\n")
    return _Scanner([*tokens, ("\n", line)]).scan()


@dataclass
class _Scanner:
    """Follows the tokens, each with its line; a line end is the last one."""

    tokens: list[tuple[str, int]]
    at: int = 0
    keys: dict[Path, int] = field(default_factory=dict)
    texts: dict[Path, int] = field(default_factory=dict)
    counts: dict[Path, int] = field(default_factory=dict)

    def scan(self) -> TomlLines:
        table: Path = ()
        while self.at < len(self.tokens):
            if self.token == "\n":
                self.at += 1
            elif self.token == "[":
                table = self.header()
            else:
                self.pair(table)
        return TomlLines(self.keys, self.texts)

    @property
    def token(self) -> str:
        return self.tokens[self.at][0]

    @property
    def line(self) -> int:
        return self.tokens[self.at][1]

    def header(self) -> Path:
        line, brackets = self.line, 2 if self.tokens[self.at + 1][0] == "[" else 1
        self.at += brackets
        names = self.names("]")
        self.at += brackets - 1
        path = (*self.in_last(names[:-1]), names[-1])
        for length in range(1, len(path)):
            self.keys.setdefault(path[:length], line)
        if brackets == 2:
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
        """Read a dotted key and the token `end` after it."""
        names = []
        while self.token != end:
            if self.token != ".":
                names.append(self.token[1:-1] if self.token[0] in "\"'" else self.token)
            self.at += 1
        self.at += 1
        return tuple(names)

    def pair(self, table: Path) -> None:
        line = self.line
        path = (*table, *self.names("="))
        for length in range(len(table) + 1, len(path) + 1):
            self.keys.setdefault(path[:length], line)
        self.value(path)

    def value(self, path: Path) -> None:
        # A line end right after the opening quotes is not part of the text.
        self.texts[path] = self.line + self.token.startswith(('"""\n', "'''\n"))
        if self.token in ("[", "{"):
            self.sequence(path, "]" if self.token == "[" else "}")
        else:
            while self.token not in _VALUE_ENDS:
                self.at += 1

    def sequence(self, path: Path, end: str) -> None:
        self.at += 1
        number = 0
        while self.token != end:
            if self.token in ("\n", ","):
                self.at += 1
            elif end == "}":
                self.pair(path)
            else:
                self.keys[(*path, number)] = self.line
                self.value((*path, number))
                number += 1
        self.at += 1
