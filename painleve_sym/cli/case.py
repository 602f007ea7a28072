"""From the options of classify, simulate and jump, and a scenario file, to one scenario."""

from __future__ import annotations

import argparse
import os
from collections.abc import Collection, Mapping
from typing import Any

from painleve_sym.cli.commands import IN_SPACE, OF_ROBOTS
from painleve_sym.cli.options import given_options, read_assignments, read_quantities
from painleve_sym.cli.robot_options import read_robot_options
from painleve_sym.codegen.named_mechanisms import is_robot_file, model
from painleve_sym.errors import InputError, refuse_unknown, unknown_name
from painleve_sym.files import parse_toml, read_text
from painleve_sym.laws.catalogue import Law, LawsByContact, all_choices, law
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import NAMED
from painleve_sym.study.scenario import MAX_FILE, Scenario
from painleve_sym.study.settings import SETTINGS

_OPTIONS = tuple(n for n, of in SETTINGS.items() if of.group and of.type != "Mapping[str, float]")
"""Options that give a field of the scenario."""


def read_case(arguments: argparse.Namespace) -> Scenario:
    """Return the scenario of the command line: the file, if one is named, under the options."""
    given = given_options(arguments, *_OPTIONS)
    if of_robot := read_robot_options(arguments):
        given["robot"] = of_robot
    base = _base(arguments.case, arguments.command).updated(given)
    if arguments.command not in IN_SPACE:
        base.mechanism().require_planar()
    given = {}

    def units() -> Mapping[str, str]:
        return base.mechanism().units

    if arguments.state is not None:
        given["state"] = read_quantities("--state", arguments.state, units)
    if arguments.set is not None:
        given["parameters"] = read_quantities("--set", arguments.set, units)
    if getattr(arguments, "law_set", None) is not None:
        given |= read_law_settings(base.law, arguments.law_set, base.named_parameters)
    return base.updated(given).with_owned_parameters().from_material()


def chosen_mechanism(name: str, contact: str | None) -> Mechanism:
    """Return the mechanism, with the contact of ``--contact`` alone where one is named."""
    whole = model(name)
    return whole if contact is None else whole.only(contact)


def _describes_mechanism(path: str) -> bool:
    """Whether a TOML file holds a mechanism rather than a scenario; a broken one does not."""
    try:
        return "coordinates" in parse_toml(read_text(path, path, MAX_FILE), path)
    except InputError:
        return False


def _base(case: str, command: str) -> Scenario:
    if case.endswith(".toml") and _describes_mechanism(case):
        return Scenario(model=case, where=f"{command} {case}")
    if is_robot_file(case):
        if command not in OF_ROBOTS:
            model(case)  # says that a robot has no formulas
        return Scenario(model=case, where=f"{command} {case}")
    named = case.partition(":")[0] in NAMED
    if case.endswith(".toml") or "/" in case or (not named and os.path.isfile(case)):
        return Scenario.read(case)
    if not named:
        raise InputError(
            f"{command}: {unknown_name('model', case, NAMED)} "
            "Fix: name one of these, or a mechanism or scenario file ending in .toml, or for "
            f"{', '.join(OF_ROBOTS)} the file of a robot."
        )
    return Scenario(model=case, where=f"{command} {case}")


def read_law_settings(
    name: str | None, texts: Collection[str] | None, of_mechanism: Collection[str] = ()
) -> dict[str, Any]:
    """Return law parameters and choices of ``--law-set``; InputError where there is no law.

    `of_mechanism` are the parameters of the mechanism, which a message tells from those of the law.
    """
    if name is None:
        raise InputError("--law-set: no law to set. Fix: name one with --law.")
    pairs = read_assignments("--law-set", texts)
    # A rigid law has no friction law, and says so.
    known_choices = {*all_choices(law(name)), "friction"}
    choices = {k: v for k, v in pairs.items() if k in known_choices}
    chosen = law(name, **choices)
    known = [*(p.name for p in chosen.parameters), *all_choices(chosen)]
    for key in pairs:
        if key not in known and key in of_mechanism:
            raise InputError(
                f"--law-set: parameter {key} belongs to the mechanism. Fix: give it with --set."
            )
        refuse_unknown("parameter", key, known, f"--law-set of {name!r}")
    units = {p.name: p.unit for p in chosen.parameters}
    entries = [f"{k}={v}" for k, v in pairs.items() if k not in choices]
    numbers = read_quantities("--law-set", entries, lambda: units)
    return {"law_parameters": numbers, "law_choices": choices}


def chosen_law(name: str | None, texts: list[str] | None) -> Law | LawsByContact:
    """Return the law of ``--law`` with the choices of ``--law-set``."""
    if name is None:
        raise InputError("--law: missing. Fix: name one, such as --law bilinear-hertz.")
    return law(name, **read_law_settings(name, texts)["law_choices"])
