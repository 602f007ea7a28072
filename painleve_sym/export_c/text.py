"""What the header of an export says about states, outputs, events and stops."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Sequence

STATES = {
    "gap": ("m", "gap of the contact"),
    "gap_dot": ("m/s", "its rate"),
    "slip_velocity": ("m/s", "slip velocity of the contact"),
    "friction_dissipation": ("J", "energy lost in friction so far"),
    "contact_dissipation": ("J", "energy lost in the contact law so far"),
    "force_dissipation": ("J", "energy lost to loads and drives so far"),
}
"""Unit and meaning of states that are no coordinates or velocities."""

MEMORY = {
    "delta_max": ("m", "compression at which unloading began"),
    "impact_budget": ("", "work (J) or impulse (N s) of the compression that restitution draws on"),
    "approach_velocity": ("m/s", "normal velocity at the start of the impact"),
    "normal_impulse": ("N s", "normal impulse of the impact so far"),
    "tangential_impulse": ("N s", "tangential impulse of the impact so far"),
}

OUTPUTS = {
    "normal_force": ("N", "F_n"),
    "tangential_force": ("N", "F_t"),
    "compression": ("m", "-gap"),
    "gap": ("m", "gap of the contact"),
    "gap_rate": ("m/s", "its rate"),
    "slip_velocity": ("m/s", "slip velocity of the contact"),
    "kinetic_energy": ("J", "of the mechanism"),
    "potential_energy": ("J", "of the mechanism"),
    "stored_energy": ("J", "in the contact"),
}


def comment(text: str) -> str:
    """Return text that can stand in a C comment: what came from a file must not end it."""
    plain = " ".join(text.split()).replace("\\", "/")
    return plain.replace("*/", "* /").replace("/*", "/ *")


def quoted(text: str) -> str:
    """Return a C string literal of ASCII text."""
    return '"' + re.sub(r'[^ -~]|["\\?]', "_", text) + '"'


def identifier(text: str) -> str:
    """Return text with everything but letters, digits and underscores replaced."""
    return re.sub(r"\W", "_", text, flags=re.ASCII)


def described(unit: str, meaning: str) -> str:
    """Return unit and meaning for a comment; the unit 1 is left out."""
    return "; ".join(part for part in (meaning, unit if unit != "1" else "") if part)


def enum(tag: str, prefix: str, rows: Iterable[tuple[str, str]], about: str) -> str:
    """Return a C enum of rows of name and comment, numbered from 0."""
    if not (rows := list(rows)):
        return f"/* {about}: there is none. */"
    entries = [(f"{prefix}_{identifier(name)}", comment(text)) for name, text in rows]
    width = max(len(name) for name, _ in entries)
    lines = [f"/* {about}. */", f"enum {tag} {{"]
    for i, (name, text) in enumerate(entries):
        number = f"  {name:{width}} = {i}" + ("," if i + 1 < len(entries) else "")
        lines.append(f"{number}  /* {text} */" if text else number)
    return "\n".join([*lines, "};"])


def prose(lines: Sequence[str], start: str = " * ") -> str:
    """Return paragraphs as lines of a C comment."""
    wrapped = [
        row for line in lines for row in textwrap.wrap(comment(line), 96, subsequent_indent="  ")
    ]
    return "\n".join(start + row for row in wrapped)
