"""States of published tables as presets of a page, read from the data of the paper."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib import resources
from typing import Any


def presets(description: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the presets of a page: name, the sentence on what to look at, and settings.

    The numbers are those of ``claims.toml`` of the paper; a preset that needs a parameter which
    `ModuleSource.description` does not have is left out.
    """
    known = {q["name"] for q in (*description["states"], *description["parameters"])}
    rows = []
    for entry in _entries(description["mechanism"]["name"]):
        settings = _settings(entry)
        if settings["values"].keys() <= known:
            rows.append({"name": entry["name"], "look": entry["look"], "settings": settings})
    return rows


def has_presets(name: str) -> bool:
    """Return whether a paper has states of the named mechanism."""
    return bool(_entries(name))


def _entries(name: str) -> list[dict[str, Any]]:
    own = resources.files(__package__).joinpath("presets.toml")
    entries = tomllib.loads(own.read_text("utf-8"))["presets"]
    return [entry for entry in entries if name in entry["models"]]


def _settings(entry: Mapping[str, Any]) -> dict[str, Any]:
    paper = resources.files("painleve_sym.papers").joinpath(entry["paper"], "claims.toml")
    claims = tomllib.loads(paper.read_text("utf-8"))
    inputs = claims["inputs"]
    values = inputs["parameters"] | {"E": inputs["moduli"][entry["modulus"]]}
    settings: dict[str, Any] = {
        "values": values | claims["tables"][entry["table"]]["state"],
        "end": entry["t_end"],
        "reload": entry["reload"],
    }
    if "row" in entry:
        row = claims["initial_forces"]["rows"][entry["row"]]
        settings["force"] = float(row["force"])
    return settings
