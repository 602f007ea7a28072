"""Pages of classes: a result begins with its example and has no constructor."""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from typing import Any, is_typeddict

from painleve_sym.doors import public_names

_SECTION = re.compile(r"^(\w[\w ]*)$")


def is_made_by_users(public: type) -> bool:
    """Whether the docstring of a class says how it is made: by its parameters, or an example."""
    text = inspect.getdoc(public) or ""
    of_parameters = re.search(r"^Parameters\n-{3,}$", text, re.MULTILINE)
    return bool(of_parameters or re.search(rf"^(?:>>>|\.\.\.).*\b{public.__name__}\(", text, re.M))


def example_first(lines: list[str]) -> list[str]:
    """Return a docstring in numpydoc's notation whose examples stand behind its first paragraph.

    Numpydoc itself puts them last.
    """
    starts = [
        i
        for i, line in enumerate(lines[:-1])
        if _SECTION.match(line) and lines[i + 1] == "-" * len(line)
    ]
    place = next((i for i in starts if lines[i] == "Examples"), None)
    if place is None:
        return lines
    end = next((i for i in starts if i > place), len(lines))
    examples = lines[place + 2 : end]
    summary = next((i for i, line in enumerate(lines) if not line.strip()), len(lines))
    rest = lines[:place] + lines[end:]
    return [*rest[:summary], "", *examples, "", *rest[summary:]]


def begin_with_example(
    _app: Any, kind: str, _name: str, public: Any, _options: Any, lines: list[str]
) -> None:
    """Let the page of a result begin with its example; before numpydoc reads the lines."""
    if kind == "class" and inspect.isclass(public) and not is_made_by_users(public):
        lines[:] = example_first(lines)


def hide_constructor(
    _app: Any, kind: str, _name: str, public: Any, *_: Any
) -> tuple[str, str] | None:
    """Return no signature for a class that functions return."""
    return ("", "") if kind == "class" and not is_made_by_users(public) else None


def sign_typed_dicts(*_: Any) -> None:
    """Give dictionaries with typed keys an empty signature: autodoc fails at that of `dict`."""
    for name, door in public_names().items():
        public = getattr(import_module(door), name)
        if is_typeddict(public):
            public.__signature__ = inspect.Signature()
