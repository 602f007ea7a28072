"""Modules that are part of the package: named mechanisms with their default law."""

from __future__ import annotations

import gzip
import json
from importlib import resources
from pathlib import Path
from typing import Any

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.explorer.source import Laws, ModuleSource, default_law
from painleve_sym.explorer.wasm import module
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import MODELS

_DATA = resources.files(__package__).joinpath("data")


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
    """Return the digest of the C from which the stored module was made."""
    try:
        text = _DATA.joinpath(f"{name}.json").read_text("utf-8")
    except OSError:
        return None
    digest: str = json.loads(text)["digest"]
    return digest


def build(name: str, folder: Path) -> int:
    """Write module and description of a named mechanism; return the size of the module."""
    mechanism = model(name)
    source = ModuleSource(mechanism, default_law(mechanism))
    code = module(source)
    data = {"digest": source.digest, **source.description}
    text = json.dumps(data, ensure_ascii=False, indent=1)
    (folder / f"{name}.json").write_text(f"{text}\n", "utf-8")
    (folder / f"{name}.wasm.gz").write_bytes(gzip.compress(code, 9, mtime=0))
    return len(code)
