"""Names of derived functions and signatures of automata in the cache."""

from __future__ import annotations

from typing import Any

from painleve_sym.cache import entry_name

MECHANISM = ("mechanics", "codegen")
"""Folders that derive a mechanism."""
FORMULAS = (*MECHANISM, "laws", "automata", "at")
"""Folders that derive an automaton and other formulas of contacts."""
ENGINE = (*FORMULAS, "engines")
"""Folders that write the C of an engine."""


def entry_key(title: str, *objects: Any, by: tuple[str, ...] = FORMULAS) -> str | None:
    """Return the name of an entry, or None where an object has no definition to go by.

    The title says what the entry holds, and all else that it depends on; the objects are what it is
    derived from: texts, or what has a `definition` or a `definition_text`. An entry is made again
    where code changes in one of the folders of the package that it is derived `by`.
    """
    try:
        texts = [_definition(source) for source in objects]
    except TypeError:
        return None
    return entry_name(title, *texts, by=by)


def _definition(source: Any) -> str:
    known = source if isinstance(source, str) else getattr(source, "definition", None)
    if isinstance(known, str):
        return known
    from painleve_sym.mechanics.definition import definition_text

    return definition_text(source)
