"""Stand-alone C: one mechanism with one contact law as a folder that builds without the package."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from painleve_sym.c_export.files import ExampleCode, clashing_name, files
from painleve_sym.checks import StateLike, names_of
from painleve_sym.choices import EngineLike, EngineName
from painleve_sym.codegen.compile import Compiler, find_compiler
from painleve_sym.codegen.named_mechanisms import MechanismLike
from painleve_sym.engines.protocol import DEFAULT_RTOL, MAX_EVENTS, MAX_STEPS, RunSettings
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.escape import c_name
from painleve_sym.files import beside, file_path
from painleve_sym.laws.catalogue import LawsLike
from painleve_sym.motion.mechanism_with_laws import Start
from painleve_sym.motion.refusals import checked_force
from painleve_sym.motion.runs import simulator_of
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.study.scenario import Scenario
from painleve_sym.units import Value

T_END = {"compliant": 0.01, "rigid": 1.0}
"""End time of the example where none is given, s: an impact, or a few of them."""

_RESERVED = ("ps", "casadi", "generated")
"""Prefixes of names within the generated files."""


@dataclass(frozen=True)
class Export:
    """An export: the prefix of all C names, the folder, and the names of the files in it.

    The compiler is that of the expected output, the trajectory the example's motion, and the inputs
    are parameters that a caller gives for each piece of a motion.
    """

    name: str
    folder: Path
    files: tuple[str, ...]
    compiler: Compiler
    trajectory: Trajectory
    inputs: tuple[str, ...] = ()


def export_c(
    mechanism: MechanismLike,
    law: LawsLike,
    state: StateLike | None = None,
    *,
    folder: str | Path,
    name: str | None = None,
    t_end: Value | None = None,
    until: str | Sequence[str] = (),
    parameters: Mapping[str, Value] | None = None,
    law_parameters: Mapping[str, Value] | None = None,
    initial_force: Value | None = None,
    engine: EngineLike = EngineName.AUTO,
    watch: str | Sequence[str] = (),
    rtol: float = DEFAULT_RTOL,
    max_steps: int = MAX_STEPS,
    max_events: int = MAX_EVENTS,
    inputs: Sequence[str] = (),
) -> Export:
    """Write C code that runs a mechanism with its law: whole, or not at all.

    The folder builds without the package. Its example is the motion from `state`, with the numbers
    that the package computes for it.

    Parameters
    ----------
    mechanism, law, state
        As for `simulate`.
    folder : path
        Must be absent or empty.
    name : str, optional
        Prefix of all C names; that of the mechanism where none is given.
    t_end : float, optional
        End of the example; `T_END` where none is given; s.
    until, parameters, law_parameters, initial_force, rtol, max_steps, max_events
        Of the example, as for `simulate`.
    engine : EngineName or its text
        Not ``erk``, which is not C.
    watch : str or sequence of str
        Events that the code records besides those of the contacts, as for `simulate`.
    inputs : sequence of str
        Parameters, such as loads, that ``NAME_simulate_from`` takes as an array of their own,
        after those of each `Input` of the mechanism.

    Returns
    -------
    Export

    Raises
    ------
    InputError
        Input that `simulate` rejects; an invalid C name; a folder that holds something or cannot
        be written.
    CompilerMissing
        The expected numbers are computed in compiled code.

    Examples
    --------
    >>> import tempfile, painleve_sym as ps
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ps.export_c("rod", "hertz", folder=folder).name
    'rod'
    """
    target = empty_folder(file_path(folder, "export: folder"))
    given = Given(t_end, until, rtol, max_steps, max_events, initial_force, inputs)
    simulator = simulator_in_c(mechanism, law, engine, watch)
    start = started(simulator, (state, parameters, law_parameters), given, name)
    trajectory = simulator.follow(start.first, start.settings)
    case = ExampleCode(**start.code, engine_name=trajectory.engine, trajectory=trajectory)
    return _written(case, target, chosen=name is None)


_Values = Mapping[str, Value] | None
_At = tuple[StateLike | None, _Values, _Values]


class Given(NamedTuple):
    """Settings of an example or a unit, besides its start."""

    t_end: Value | None
    until: str | Sequence[str]
    rtol: float
    max_steps: int
    max_events: int
    initial_force: Value | None
    inputs: Sequence[str]


class Started(NamedTuple):
    """A checked start of a motion, its settings, and the fields of `StartedCode`."""

    first: Start
    settings: RunSettings
    code: dict[str, Any]


def simulator_in_c(
    mechanism: MechanismLike, law: LawsLike, engine: EngineLike, watch: str | Sequence[str]
) -> Simulator:
    """Return a simulator whose engine is in C."""
    if engine == EngineName.ERK:
        raise InputError("export: engine: got 'erk', need auto, taylor or compiled.")
    return simulator_of(mechanism, law, engine, watch)


def started(simulator: Simulator, at: _At, given: Given, name: str | None) -> Started:
    """Return a checked start; `at` are state, parameters and those of the laws."""
    own = simulator.mechanism.name
    prefix = _checked_name(c_name(own) if name is None else name, name is None)
    compiler = find_compiler()
    place = simulator.at(*at)
    bounds = {"max_steps": given.max_steps, "max_events": given.max_events}
    usual = T_END["rigid" if simulator.rigid else "compliant"]
    t_end = usual if given.t_end is None else given.t_end
    options = {"t_end": t_end, "until": given.until, "rtol": given.rtol, **bounds}
    settings = RunSettings.of(simulator.where, options)
    pressed = given.initial_force
    force = None if pressed is None else checked_force(simulator, pressed)
    first = simulator.start(place, force)
    until = given.until
    code = {
        "name": prefix,
        "simulator": simulator,
        "compiler": compiler,
        "inputs": input_names(simulator, given.inputs),
        "parameters": place.parameters,
        "motion": simulator.start(place).state[: len(place.state)],
        "t_end": settings.t_end,
        "rtol": given.rtol,
        "until": (until,) if isinstance(until, str) else tuple(until),
        "limits": {n: v for n, v in bounds.items() if v != getattr(RunSettings, n)},
        "initial_force": force,
    }
    return Started(first, settings, code)


def refuse_phases(scenario: Scenario) -> None:
    """Raise InputError where what happens at known times is a part of a scenario."""
    if scenario.phases or scenario.inputs:
        raise InputError(
            "export: got phases or inputs, and the code runs with the same parameters from start "
            "to end. Fix: leave them out, and continue in C from each of these times with others."
        )


def export_scenario(
    scenario: Scenario, folder: str | Path, name: str | None = None, inputs: Sequence[str] = ()
) -> Export:
    """Write the C code of a scenario; see `export_c`."""
    return export_c(**arguments_of(scenario), folder=folder, name=name, inputs=inputs)


def arguments_of(scenario: Scenario) -> dict[str, Any]:
    """Return the mechanism, the law, the start and the settings of a scenario for an export."""
    refuse_phases(scenario)
    return {
        "mechanism": scenario.mechanism(),
        "law": scenario.contact_law(),
        "state": scenario.start(),
        "parameters": scenario.parameters,
        "law_parameters": scenario.law_parameters,
        "initial_force": scenario.initial_force,
        "engine": scenario.engine,
        "watch": scenario.watch,
        **scenario.of_run,
    }


def input_names(simulator: Simulator, inputs: Sequence[str]) -> tuple[str, ...]:
    """Return the names of parameters that are inputs: those declared, then those given.

    InputError for names of none.
    """
    where = f"{simulator.where}: inputs"
    declared = tuple(p.name for p in simulator.declared.by_name.values() if p.input_of)
    names = declared + tuple(n for n in names_of(inputs, where, "F") if n not in declared)
    for name in names:
        refuse_unknown("parameter", name, simulator.declared.by_name, where)
    if len(set(names)) < len(names):
        raise InputError(f"{where}: got {', '.join(names)}, need each parameter once.")
    return names


def _written(case: ExampleCode, target: Path, *, chosen: bool) -> Export:
    """Write the files; a name that was `chosen` here gives way where the generated code has it."""
    texts = files(case)
    clash = clashing_name(case, texts)
    if clash and chosen:
        case = replace(case, name=f"model_{case.name}")
        texts = files(case)
        clash = clashing_name(case, texts)
    if clash:
        raise InputError(
            f"export: name: got {case.name!r}, but the generated code has a name {clash} of its "
            f"own. Fix: name it otherwise, such as model_{case.name}."
        )
    write_folder(target, texts)
    return Export(case.name, target, tuple(texts), case.compiler, case.trajectory, case.inputs)


def _checked_name(name: str, chosen: bool) -> str:
    if chosen and (name.lower() in _RESERVED or not name[:1].isalpha()):
        return f"model_{name}"
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or name.lower() in _RESERVED:
        raise InputError(
            f"export: name: got {name!r}, need a letter, then letters, digits and underscores, and "
            f"none of {', '.join(_RESERVED)}."
        )
    return name


# ---- the folder ----


def empty_folder(path: Path) -> Path:
    """Return the path of a folder that may be made, or that is empty; InputError if not."""
    target = Path(os.path.realpath(path))
    try:
        if os.path.lexists(target) and not target.is_dir():
            raise InputError(f"export: {path} is a file. Fix: name a new folder.")
        if target.is_dir() and any(target.iterdir()):
            raise InputError(f"export: folder {path} is not empty. Fix: name a new folder.")
    except OSError as error:
        raise _unwritable(path, error) from error
    return target


def write_folder(target: Path, texts: Mapping[str, str]) -> None:
    """Write files into a folder beside `target` and rename it; InputError leaves nothing behind."""
    work, new_folders = None, []
    try:
        new_folders = [p for p in (target.parent, *target.parent.parents) if not p.exists()]
        target.parent.mkdir(parents=True, exist_ok=True)
        work = beside(target)
        work.mkdir()
        for name, text in texts.items():
            (work / name).write_text(text, "utf-8")
        # Takes the place of an empty folder, and fails where something was put into it meanwhile.
        os.rename(work, target)
    except BaseException as error:
        if work is not None:
            shutil.rmtree(work, ignore_errors=True)
        for folder in new_folders:
            with suppress(OSError):
                folder.rmdir()
        if isinstance(error, OSError):
            raise _unwritable(target, error) from error
        raise


def _unwritable(path: Path, error: OSError) -> InputError:
    return InputError(
        f"export: folder {path} cannot be written: {error.strerror or error}. "
        "Fix: name a new folder in a place that is writable."
    )
