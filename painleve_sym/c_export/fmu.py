"""Functional mock-up units: a mechanism with its contact laws for tools of co-simulation."""

from __future__ import annotations

import hashlib
import platform
import sys
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from painleve_sym.c_export.export import Given, arguments_of, simulator_in_c, started
from painleve_sym.c_export.files import StartedCode, clashing_name, code_files, filled
from painleve_sym.c_export.fmi_description import VERSIONS, build_description, description
from painleve_sym.c_export.fmi_variables import Variable, instants, variables
from painleve_sym.checks import LARGEST, SMALLEST, StateLike
from painleve_sym.choices import EngineLike, EngineName
from painleve_sym.codegen.compile import Compiler, portable_library
from painleve_sym.codegen.named_mechanisms import MechanismLike
from painleve_sym.engines.c_texts import initializer, number_text
from painleve_sym.engines.protocol import DEFAULT_RTOL, ENGINE_REASONS, MAX_EVENTS, MAX_STEPS
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.escape import c_string
from painleve_sym.files import file_path, write_beside
from painleve_sym.laws.catalogue import LawsLike
from painleve_sym.mechanics.declarations import TIME_NAME, Parameter
from painleve_sym.motion.refusals import refuse_plastic
from painleve_sym.study.scenario import Scenario
from painleve_sym.units import Value

FmiVersion = Literal["3.0", "2.0"]

_SYSTEMS = {"linux": ("linux", ".so"), "darwin": ("darwin", ".dylib"), "win32": ("windows", ".dll")}
_MACHINES = {"amd64": "x86_64", "arm64": "aarch64"}
_PLATFORMS_OF_2 = {
    "x86_64-linux": "linux64",
    "x86_64-darwin": "darwin64",
    "x86_64-windows": "win64",
}


@dataclass(frozen=True)
class Fmu:
    """A functional mock-up unit: its model, file and version of FMI, and its variables.

    `inputs` are those among the variables that a tool gives for each step; the compiler is that of
    the binary.
    """

    name: str
    file: Path
    fmi_version: str
    variables: tuple[str, ...]
    inputs: tuple[str, ...]
    platform: str
    compiler: Compiler


def export_fmu(
    mechanism: MechanismLike,
    law: LawsLike,
    state: StateLike | None = None,
    *,
    file: str | Path,
    fmi_version: FmiVersion = "3.0",
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
) -> Fmu:
    """Write a functional mock-up unit (FMI) for co-simulation.

    Events are located inside a communication step, however long it is. A tool may set parameters,
    and coordinates and velocities at the start; outputs are coordinates, velocities, gaps, slip
    velocities, contact forces and modes. The unit has a binary for this kind of machine and its
    sources. The same compiler makes the same file.

    Parameters
    ----------
    mechanism, law, state, parameters, law_parameters, initial_force
        As for `simulate`: start values.
    file : path
        Its name ends in ``.fmu``; a file that is there is replaced.
    fmi_version : {"3.0", "2.0"}
    name : str, optional
        Name of the model; that of the mechanism where none is given.
    t_end : float, optional
        End that the unit proposes, as for `export_c`; s.
    until, rtol, max_steps, max_events
        As for `simulate`; the limits are those of one communication step.
    engine : EngineName or its text
        Not ``erk``, which is not C.
    watch : str or sequence of str
        Events that are counted besides those of the contacts, as for `simulate`.
    inputs : sequence of str
        Parameters, such as loads, that are inputs of the unit, after each `Input` of the mechanism;
        they are held over a communication step.

    Returns
    -------
    Fmu

    Raises
    ------
    InputError
        Input that `simulate` rejects; an invalid name; a file that cannot be written.
    CompilerMissing
        There is no C compiler.

    Examples
    --------
    >>> import tempfile
    >>> from painleve_sym.c_export import export_fmu
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     export_fmu("rod", "hertz", file=f"{folder}/rod.fmu", inputs=["mu"]).inputs
    ('mu',)
    """
    path = file_path(file, "export: file")
    if path.suffix.lower() != ".fmu":
        raise InputError(f"export: file: got {path}, need a name that ends in .fmu.")
    refuse_unknown("version of FMI", fmi_version, VERSIONS, "export")
    given = Given(t_end, until, rtol, max_steps, max_events, initial_force, inputs)
    simulator = simulator_in_c(mechanism, law, engine, watch)
    start = started(simulator, (state, parameters, law_parameters), given, name)
    options = simulator.options(start.first.scale, start.settings)
    if not options.until:
        refuse_plastic(simulator, start.first.place.parameters)
    case = StartedCode(**start.code, engine_name=simulator.integrator.name)
    texts = code_files(case)
    if clashing_name(case, texts):
        case = replace(case, name=f"model_{case.name}")
    return _written(case, path, fmi_version)


def export_fmu_of_scenario(
    scenario: Scenario,
    file: str | Path,
    fmi_version: Any = "3.0",
    name: str | None = None,
    inputs: Sequence[str] = (),
) -> Fmu:
    """Write the unit of a scenario; see `export_fmu`."""
    given = arguments_of(scenario)
    return export_fmu(**given, file=file, fmi_version=fmi_version, name=name, inputs=inputs)


def _written(case: StartedCode, path: Path, version: str) -> Fmu:
    every = variables(case)
    texts = code_files(case)
    del texts[f"{case.name}_contact.c"]
    unit = f"{case.name}_fmu.c"
    token = _token(case, version, every, [*texts.values(), fmu_text(case, version, every, "")])
    texts[unit] = fmu_text(case, version, every, token)
    place, suffix = _platform(version)
    members = {
        "modelDescription.xml": description(case, version, every, token, [unit]),
        **{f"sources/{name}": text.encode() for name, text in texts.items()},
        f"binaries/{place}/{case.name}{suffix}": portable_library(texts, unit),
    }
    if version == "3.0":
        members["sources/buildDescription.xml"] = build_description(case.name, [unit])
    write_beside(path, lambda stream: _zipped(stream, members))
    shown = [v for v in every if version == "3.0" or v.causality != "independent"]
    return Fmu(
        name=case.name,
        file=path,
        fmi_version=version,
        variables=tuple(v.name for v in shown),
        inputs=tuple(v.name for v in shown if v.causality == "input"),
        platform=place,
        compiler=case.compiler,
    )


def _token(case: StartedCode, version: str, every: Sequence[Variable], texts: Sequence[str]) -> str:
    """Return the token of a unit: a hash of its code and its description."""
    whole = "\n".join([*texts, repr(every), case.subject, version])
    return hashlib.sha256(whole.encode()).hexdigest()[:32]


def _platform(version: str) -> tuple[str, str]:
    """Return the name of this kind of machine in FMI, and the suffix of its libraries."""
    system, suffix = _SYSTEMS.get(sys.platform, (sys.platform, ".so"))
    machine = platform.machine().lower()
    place = f"{_MACHINES.get(machine, machine)}-{system}"
    return (_PLATFORMS_OF_2.get(place, place) if version == "2.0" else place), suffix


def _zipped(stream: Any, members: Mapping[str, bytes]) -> None:
    """Write an archive that depends on its members alone."""
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content in members.items():
            info = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            info.create_system, info.compress_type = 3, zipfile.ZIP_DEFLATED
            info.external_attr = (0o755 if name.startswith("binaries") else 0o644) << 16
            archive.writestr(info, content)


def fmu_text(case: StartedCode, version: str, every: Sequence[Variable], token: str) -> str:
    """Return the C of the unit above that of the motion."""
    names = case.outline.parameter_names
    ranges = [_c_range(case.declared[name]) for name in names]
    moments, states = instants(case), case.outline.state_names
    force = -1.0 if case.initial_force is None else case.initial_force
    values = {
        "fmi_version": version,
        "token": token,
        "variables_count": len(every),
        "variables": ", ".join(f"{{FMU_{v.kind}, {v.index}}}" for v in every),
        "variable_names": ", ".join(c_string(v.name) for v in every),
        "ranges": initializer(ranges),
        "parameter_values": initializer(number_text(case.parameters[n]) for n in names),
        "start_values": initializer(map(number_text, case.motion.tolist())),
        "force": number_text(force),
        "instants_count": len(moments),
        "instants": initializer([*moments, -1]),
        "clock": states.index(TIME_NAME) if moments else 0,
        "stop_sentences": initializer(c_string(r.sentence) for r in ENGINE_REASONS),
        "rtol": repr(case.rtol),
        "t_end": repr(case.t_end),
        "options": "".join(f"{line.replace('.', '->', 1)}\n" for line in case.option_lines),
        "largest": repr(LARGEST),
        "smallest": repr(SMALLEST),
        "mode": "(long)m->z[FMU_VARIABLE[reference].index]" if case.outline.parts else "m->mode",
    }
    shared = filled("fmu.c", case.shared | values)
    return shared + filled(f"fmi{version[0]}.c", case.shared)


def _c_range(own: Parameter) -> str:
    """Return ends of a range, whether they belong to it, subject and range in words."""
    ends = number_text(own.lower), number_text(own.upper)
    closed = int(own.lower_closed), int(own.upper_closed)
    words = c_string(f"parameter {own.name}"), c_string(own.range_text)
    return initializer([*ends, *closed, *words])
