"""Modules that are part of the package: named mechanisms with their default law."""

from __future__ import annotations

import json
from importlib import resources
from typing import Any

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.laws.catalogue import Law, LawsByContact, compliant_law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import MODELS

Laws = Law | LawsByContact

_DATA = resources.files(__package__).joinpath("data")


def default_law(mechanism: Mechanism) -> Law:
    """Return the law of a page where none is named.

    Bilinear Hertz with the reloading rule that the paper's curves need; rigid for contacts that
    hold from both sides.
    """
    if any(c.bilateral for c in mechanism.outline.contacts):
        return RigidLaw()
    return compliant_law("bilinear-hertz", reload="virgin")


def stored_module(mechanism: Mechanism, law: Laws) -> tuple[bytes, dict[str, Any]] | None:
    """Return the gzip file of a module and its description, or None where it is not stored.

    Stored ones are those of a named mechanism, whole, with `default_law`.
    """
    name = mechanism.name
    if name not in MODELS or mechanism.definition != model(name).definition:
        return None
    own = default_law(mechanism)
    if (law.name, dict(law.choices)) != (own.name, dict(own.choices)):
        return None
    try:
        description = json.loads(_DATA.joinpath(f"{name}.json").read_text("utf-8"))
        packed = _DATA.joinpath(f"{name}.wasm.gz").read_bytes()
    except OSError:
        return None
    del description["digest"]
    return packed, description


def stored_digest(name: str) -> str | None:
    """Return the digest of the C from which a stored module was made, None where there is none."""
    try:
        text = _DATA.joinpath(f"{name}.json").read_text("utf-8")
    except OSError:
        return None
    digest: str = json.loads(text)["digest"]
    return digest
