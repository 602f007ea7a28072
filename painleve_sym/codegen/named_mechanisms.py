"""Mechanisms by name, described from the cache: their formulas are made when first asked for."""

from __future__ import annotations

from painleve_sym.codegen.derivation_cache import entry_key, read_entry, write_entry
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import MODELS
from painleve_sym.mechanics.outline import MechanismOutline

_TEXTS = ("name", "title", "source", "sketch", "start", "definition", "locked")


def model(name: str) -> Mechanism:
    """Return the named mechanism, or the one a mechanism file ending in .toml describes.

    What a named one is called, its parameters and its contacts come from the cache after the first
    time; it is built when a formula is asked for.

    Raises
    ------
    InputError
        Suggests the nearest name; for a file, what is wrong and in which line.
    """
    if name.endswith(".toml"):
        from painleve_sym.mechanics.toml.mechanism_file import load_mechanism

        return load_mechanism(name)
    if name not in MODELS:
        raise InputError(unknown_name("model", name, MODELS))
    key = entry_key(f"mechanism {name}")
    entry = read_entry(key) if key else None
    if entry is not None:
        outline = MechanismOutline.of_data(entry["outline"])
        return Mechanism.deferred(
            MODELS[name], outline=outline, **{text: entry[text] for text in _TEXTS}
        )
    mechanism = MODELS[name]()
    texts = {text: getattr(mechanism, text) for text in _TEXTS}
    if key:
        write_entry(key, {"outline": mechanism.outline.to_data(), **texts})
    return mechanism
