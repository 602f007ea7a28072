"""Phases and inputs as one text, as options of commands have them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from painleve_sym.errors import InputError

PHASES = "TIME:NAME=VALUE,...;..."
INPUTS = "NAME=FILE,..."
_EXAMPLE = "0.5:mu=0.2,g=0;0.8:law=hertz;1:contacts=A+B"


def read_phases(where: str, text: str) -> tuple[dict[str, Any], ...]:
    """Return the phases of a text such as ``0.5:mu=0.2;0.8:law=hertz``."""
    parts = [part for part in text.split(";") if part.strip()]
    if not parts:
        raise InputError(f"{where}: got {text!r}, need phases such as {_EXAMPLE}.")
    return tuple(_phase(where, part) for part in parts)


def _phase(where: str, text: str) -> dict[str, Any]:
    time, colon, changes = text.partition(":")
    phase: dict[str, Any] = {"time": _number(time)}
    for entry in changes.split(","):
        name, equals, value = (part.strip() for part in entry.partition("="))
        if not (colon and equals and name and value):
            raise InputError(f"{where}: got {text.strip()!r}, need phases such as {_EXAMPLE}.")
        if name == "law":
            phase["law"] = value
        elif name == "contacts":
            phase["contacts"] = value.split("+")
        else:
            phase.setdefault("parameters", {})[name] = _number(value)
    return phase


def _number(text: str) -> float | str:
    """Return a number, or the text of one with a unit."""
    try:
        return float(text)
    except ValueError:
        return text.strip()


def phases_text(phases: Sequence[Mapping[str, Any]]) -> str:
    """Return the text that `read_phases` reads."""
    return ";".join(f"{phase['time']}:{','.join(_changes(phase))}" for phase in phases)


def _changes(phase: Mapping[str, Any]) -> list[str]:
    values = {**phase.get("parameters", {}), **phase.get("law_parameters", {})}
    changes = [f"{name}={value}" for name, value in values.items()]
    changes += [f"law={phase['law']}"] if "law" in phase else []
    return changes + ([f"contacts={'+'.join(phase['contacts'])}"] if "contacts" in phase else [])


def read_inputs(where: str, text: str) -> dict[str, Any]:
    """Return the inputs of a text such as ``F=record.csv:linear``."""
    inputs: dict[str, Any] = {}
    for entry in text.split(","):
        name, equals, file = (part.strip() for part in entry.partition("="))
        if not (equals and name and file):
            raise InputError(f"{where}: got {entry.strip()!r}, need NAME=FILE or NAME=FILE:linear.")
        file, colon, interpolation = file.rpartition(":")
        inputs[name] = (
            {"file": file, "interpolation": interpolation} if colon else {"file": interpolation}
        )
    return inputs


def inputs_text(inputs: Mapping[str, Any]) -> str:
    """Return the text that `read_inputs` reads; of values in a scenario file, their names alone."""
    parts = []
    for name, given in inputs.items():
        values = {"file": given} if isinstance(given, str) else given
        kind = f":{values['interpolation']}" if "interpolation" in values else ""
        parts.append(f"{name}={values.get('file', '...')}{kind}")
    return ",".join(parts)
