"""Events that a caller asks for, and that change nothing: apexes, peaks, sections, strobes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from painleve_sym.checks import names_of, split_outside_brackets
from painleve_sym.errors import EventKind, InputError, refuse_unknown, repeated

WATCHED = {
    EventKind.APEX: "apex, or apex(y) of a coordinate",
    EventKind.PEAK: "peak(normal_force) of a state or output",
    EventKind.SECTION: "section(theta - 0.3), where a formula falls through 0",
    EventKind.STROBE: "strobe(0.1) with a period in s, or strobe(2*pi/omega, 0.05) with an offset",
}
"""Kinds of events that are watched, with how each is asked for."""
_COUNTS = {
    EventKind.APEX: (0, 1),
    EventKind.PEAK: (1,),
    EventKind.SECTION: (1,),
    EventKind.STROBE: (1, 2),
}
"""How many arguments each kind has."""


MEMORY_END = " watched"
"""End of the names of the memories of watches."""


class Watch(NamedTuple):
    """An event to look for: its kind, its arguments, and the contact whose gap has an apex."""

    kind: EventKind
    arguments: tuple[str, ...] = ()
    contact: str = ""

    @property
    def label(self) -> str:
        """Label of its transitions, such as ``peak(normal_force)`` or ``apex:A``."""
        arguments = f"({', '.join(self.arguments)})" if self.arguments else ""
        return f"{self.kind}{arguments}{':' * bool(self.contact)}{self.contact}"

    @property
    def memory(self) -> str:
        """Name of its memory."""
        return f"{self.label}{MEMORY_END}"

    @property
    def text(self) -> str:
        """Its text, which `read_watch` reads."""
        return self.label.partition(":")[0] if self.contact else self.label


def watch_texts(given: Any) -> tuple[str, ...]:
    """Return the texts of what to watch, one each; InputError for anything but texts."""
    texts = split_outside_brackets(given) if isinstance(given, str) else given
    return () if texts == ("",) else names_of(texts, "watch", "apex")


def read_watch(given: Any, contacts: Sequence[str], where: str) -> tuple[Watch, ...]:
    """Return what a text, or several, ask to look for; `contacts` are the names of all.

    Raises
    ------
    InputError
        An unknown kind, a wrong number of arguments, or a repetition.
    """
    place = f"{where}: watch"
    read = [_read(text, place) for text in watch_texts(given)]
    every = [
        own
        for watch in read
        for own in ([watch._replace(contact=c) for c in contacts] if _of_gap(watch) else [watch])
    ]
    for label in repeated(watch.label for watch in every):
        raise InputError(f"{place}: got {label!r} twice. Fix: leave one out.")
    return tuple(every)


def _of_gap(watch: Watch) -> bool:
    """Whether a watch is that of the gaps of all contacts."""
    return watch.kind is EventKind.APEX and not watch.arguments


def _read(text: str, place: str) -> Watch:
    name, bracket, rest = text.strip().partition("(")
    refuse_unknown("event", name.strip(), WATCHED, place)
    kind = EventKind(name.strip())
    if bracket and not rest.endswith(")"):
        raise InputError(f"{place}: got {text!r}, need {WATCHED[kind]}. Fix: close the bracket.")
    arguments = split_outside_brackets(rest[:-1]) if bracket else ()
    if len(arguments) not in _COUNTS[kind] or not all(arguments):
        raise InputError(f"{place}: got {text!r}, need {WATCHED[kind]}.")
    return Watch(kind, arguments)
