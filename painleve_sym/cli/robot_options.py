"""The options that say which contact of a robot is meant, of `robot` and of cases."""

from __future__ import annotations

import argparse
from typing import Any

from painleve_sym.cli.options import given_options, read_number, read_quantities
from painleve_sym.errors import InputError, refuse_unknown

_BASES = {"fixed": False, "floating": True}


def read_robot_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return arguments of `robot` and `Robot.contact` by name: those that are given."""
    return file_options(arguments) | place_options(arguments)


def file_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the arguments of `robot` that are given."""
    texts = given_options(arguments, "base", "armature")
    given: dict[str, Any] = {}
    if (base := texts.get("base")) is not None:
        refuse_unknown("base", base, _BASES, "--base")
        given["floating"] = _BASES[base]
    if (text := texts.get("armature")) is not None:
        by_name = read_quantities("--armature", [text], dict) if "=" in text else {}
        given["armature"] = by_name or read_number("--armature", text)
    return given | given_options(arguments, "srdf")


def place_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the arguments of `Robot.contact` that are given, but for joint values."""
    given = given_options(arguments, "pose", "others", "radius", "locked")
    for name, text in given_options(arguments, "point", "normal").items():
        given[name] = _three(f"--{name}", text)
    return given


def _three(where: str, text: str) -> list[float]:
    values = [read_number(where, entry) for entry in text.split(",")]
    if len(values) != 3:
        raise InputError(f"{where}: got {text!r}, need three numbers x,y,z.")
    return values
