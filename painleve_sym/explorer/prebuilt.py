"""The laws of a page's motions, and the one module that is part of the package: the rod's."""

from __future__ import annotations

import json
from importlib import resources
from typing import Any

from painleve_sym.choices import Reload
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.explorer.presets import has_presets
from painleve_sym.laws.catalogue import Law, LawsByContact, compliant_law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.mechanism import Mechanism

Laws = Law | LawsByContact

STORED = "rod"
"""The named mechanism whose module with `default_law` is part of the package."""

_DATA = resources.files(__package__).joinpath("data")


def default_law(mechanism: Mechanism) -> Law:
    """Return the law of a page where none is named: bilinear Hertz; rigid where a guide holds."""
    if any(mechanism.outline.bilateral):
        return RigidLaw()
    return compliant_law("bilinear-hertz")


def alternatives(mechanism: Mechanism, law: Laws) -> tuple[Laws, ...]:
    """Return the laws that a reader chooses from: the given one, or that law by each reload rule.

    The rule ``virgin`` creates energy. Only mechanisms with presets of a paper offer it, whose
    curves need it.
    """
    plain = law.name == default_law(mechanism).name and set(law.choices) == {"reload"}
    if not (plain and has_presets(mechanism.name)):
        return (law,)
    return tuple(compliant_law(law.name, reload=str(rule)) for rule in Reload)


def stored_module(mechanism: Mechanism, law: Laws) -> tuple[bytes, dict[str, Any]] | None:
    """Return the gzip file of a module and its description, or None where it is not stored.

    It serves the whole mechanism with each of the laws that `alternatives` to `default_law` are.
    """
    if mechanism.name != STORED or not _is_named(mechanism, model(STORED)):
        return None
    known = alternatives(mechanism, default_law(mechanism))
    if (law.name, dict(law.choices)) not in [(own.name, dict(own.choices)) for own in known]:
        return None
    description = json.loads(_DATA.joinpath(f"{STORED}.json").read_text("utf-8"))
    del description["digest"]
    return _DATA.joinpath(f"{STORED}.wasm.gz").read_bytes(), description


def _is_named(mechanism: Mechanism, named: Mechanism) -> bool:
    """Return whether a mechanism is a named one: formulas, texts, shapes; defaults may differ."""
    if mechanism.definition != named.definition:
        return False
    # What is not made yet comes from the named mechanism: nothing is derived to compare it.
    shapes = ("shapes",) if "shapes" in vars(mechanism) else ()
    others = ("title", "source", "sketch", *shapes)
    same = all(getattr(mechanism, name) == getattr(named, name) for name in others)
    return same and mechanism.with_parameters(**named.parameters).outline == named.outline


def stored_digest() -> str | None:
    """Return the digest of the C of the stored module, None where there is none."""
    try:
        text = _DATA.joinpath(f"{STORED}.json").read_text("utf-8")
    except OSError:
        return None
    digest: str = json.loads(text)["digest"]
    return digest
