"""Stand-alone C: one mechanism with one contact law as a folder that builds without the package."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from painleve_sym.c_export.files import Case, clashing_name, files
from painleve_sym.c_export.text import identifier
from painleve_sym.codegen.compile import Compiler, find_compiler
from painleve_sym.errors import InputError
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.study.scenario import Scenario

T_END = {"softened": 0.01, "rigid": 1.0}
"""End time of the example where none is given, s: an impact, or a few of them."""

_RESERVED = ("ps", "casadi", "generated")
"""Prefixes of names within the generated files."""


@dataclass(frozen=True)
class Export:
    """Name, folder and files of an export.

    Attributes
    ----------
    name : str
        Prefix of all C names.
    folder : Path
    files : tuple of str
        Names of the files in it.
    compiler : Compiler
        That of the expected output.
    trajectory : Trajectory
        The example's motion.
    """

    name: str
    folder: Path
    files: tuple[str, ...]
    compiler: Compiler
    trajectory: Trajectory


def export_c(scenario: Scenario, folder: str | Path, name: str | None = None) -> Export:
    """Write C code that runs the scenario's mechanism with its law: whole, or not at all.

    The example is the scenario's motion; where it names no state the mechanism's own start, where
    it names no end time `T_END`.

    Parameters
    ----------
    scenario : Scenario
    folder : path
        Must be absent or empty.
    name : str, optional
        Prefix of all C names; that of the mechanism when left out.

    Returns
    -------
    Export

    Raises
    ------
    InputError
        Input that `Scenario.simulate` rejects; an invalid C name; a folder that holds
        something or cannot be written.
    CompilerMissing

    Examples
    --------
    >>> import tempfile
    >>> from painleve_sym.study.scenario import Scenario
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     export_c(Scenario("rod", law="hertz"), folder).name
    'rod'
    """
    target = empty_folder(Path(folder))
    mechanism, law = scenario.mechanism(), scenario.contact_law()
    prefix = _checked_name(identifier(mechanism.name) if name is None else name, name is None)
    laws = law.values() if isinstance(law, Mapping) else (law,)
    rigid = not all(one.is_compliant for one in laws)
    if scenario.engine == "erk":
        raise InputError("export: engine: got 'erk', need auto, taylor or compiled.")
    given: dict[str, Any] = {}
    if scenario.state is None:
        given["state"] = dict(mechanism.start)
    if scenario.t_end is None:
        given["t_end"] = T_END["rigid" if rigid else "softened"]
    case = _case(scenario.updated(given), prefix)
    texts = files(case)
    clash = clashing_name(case, texts)
    if clash and name is None:
        case = replace(case, name=f"model_{prefix}")
        texts = files(case)
        clash = clashing_name(case, texts)
    if clash:
        raise InputError(
            f"export: name: got {prefix!r}, but the generated code has a name {clash} of its own. "
            f"Fix: name it otherwise, such as model_{prefix}."
        )
    write_folder(target, texts)
    return Export(case.name, target, tuple(texts), case.compiler, case.trajectory)


def _case(scenario: Scenario, name: str) -> Case:
    compiler, trajectory = find_compiler(), scenario.simulate()
    mechanism, law = scenario.mechanism(), scenario.contact_law()
    simulator = Simulator(mechanism, law, scenario.engine)
    start = simulator.start(scenario.start(), trajectory.parameters)
    limits = {"max_steps": scenario.max_steps, "max_events": scenario.max_events}
    return Case(
        name=name,
        simulator=simulator,
        trajectory=trajectory,
        motion=start.state[: len(mechanism.state_names)],
        t_end=float(scenario.t_end or 0.0),
        rtol=scenario.rtol,
        until=scenario.until,
        limits={k: v for k, v in limits.items() if v is not None},
        initial_force=scenario.initial_force,
        compiler=compiler,
    )


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
        work = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name[:100]}."))
        for name, text in texts.items():
            (work / name).write_text(text, "utf-8")
        work.chmod(0o755)
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
