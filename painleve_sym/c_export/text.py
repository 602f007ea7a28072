"""Comments in the header of an export: states, outputs, events and stop reasons."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Sequence

from painleve_sym.escape import c_comment, c_name
from painleve_sym.quantities import quantity


def identifiers(code: str) -> set[str]:
    """Return the names in C code: neither those in comments and strings, nor tags of enums."""
    return set(re.findall(r"\b[A-Za-z_]\w*", _NO_CODE.sub(" ", code)))


_NO_CODE = re.compile(r'/\*.*?\*/|"(?:[^"\\\n]|\\.)*"|\benum \w+', re.S)


def described(name: str) -> str:
    """Return meaning and unit of a registered quantity for a comment, else empty text."""
    known = quantity(name)
    return meaning_and_unit(known.unit, known.meaning) if known else ""


def meaning_and_unit(unit: str, meaning: str) -> str:
    """Return unit and meaning for a comment; the unit 1 is left out."""
    return "; ".join(part for part in (meaning, unit if unit != "1" else "") if part)


def enum(tag: str, prefix: str, rows: Iterable[tuple[str, str]], about: str) -> str:
    """Return a C enum of rows of name and comment, numbered from 0."""
    if not (rows := list(rows)):
        return f"/* {about}: there is none. */"
    # The array of their names has the name that one of them might have.
    fits = [f"{c_name(name)}{'_' * (name == 'names')}" for name, _ in rows]
    entries = [(f"{prefix}_{n}", c_comment(text)) for n, (_, text) in zip(fits, rows, strict=True)]
    width = max(len(name) for name, _ in entries)
    lines = [f"/* {about}. */", f"enum {tag} {{"]
    for i, (name, text) in enumerate(entries):
        number = f"  {name:{width}} = {i}" + ("," if i + 1 < len(entries) else "")
        lines.append(f"{number}  /* {text} */" if text else number)
    return "\n".join([*lines, "};"])


def prose(lines: Sequence[str], start: str = " * ") -> str:
    """Return paragraphs as lines of a C comment."""
    wrapped = [
        row for line in lines for row in textwrap.wrap(c_comment(line), 96, subsequent_indent="  ")
    ]
    return "\n".join(start + row for row in wrapped)
