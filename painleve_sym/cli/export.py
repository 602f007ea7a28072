"""The command export: a mechanism with a contact law as C code that stands alone, or as an FMU."""

from __future__ import annotations

import argparse

from painleve_sym.c_export.export import export_scenario
from painleve_sym.c_export.files import NUMERIC_FLAGS
from painleve_sym.c_export.fmi_description import VERSIONS
from painleve_sym.c_export.fmu import export_fmu_of_scenario
from painleve_sym.cli.case import read_case
from painleve_sym.cli.options import output_file, output_folder
from painleve_sym.cli.output import print_json, show
from painleve_sym.cli.run import ending
from painleve_sym.errors import InputError
from painleve_sym.plain_data import plain_fields
from painleve_sym.quantities import counted


def export(arguments: argparse.Namespace) -> int:
    """Write the C code and print how to build it, or write an FMU."""
    if arguments.fmu:
        return _export_fmu(arguments)
    if arguments.fmi:
        raise InputError("--fmi: needs --fmu. Fix: add --fmu.")
    folder = output_folder("--out", arguments.out)
    inputs = arguments.steps_inputs or ()
    done = export_scenario(read_case(arguments), folder, arguments.name, inputs)
    if arguments.json:
        print_json(
            {
                **plain_fields(done, "name", "folder", "files", "inputs"),
                "compiler": done.compiler.version,
                "flags": list(NUMERIC_FLAGS),
                "engine": done.trajectory.engine,
                "events": len(done.trajectory.events),
                "final_time": done.trajectory.final_time,
                "stop_reason": done.trajectory.stop_reason.label,
            }
        )
        return 0
    show(f"{done.folder}: {', '.join(done.files)}")
    events = counted(len(done.trajectory.events), "event")
    show(f"The example {ending(done.trajectory)}, with {events}.")
    show()
    show("build and compare, in that folder:")
    show("  cmake -B build && cmake --build build && (cd build && ctest)")
    return 0


def _export_fmu(arguments: argparse.Namespace) -> int:
    file = output_file("--out", arguments.out, (".fmu",))
    version = arguments.fmi or VERSIONS[0]
    given = version, arguments.name, arguments.steps_inputs or ()
    done = export_fmu_of_scenario(read_case(arguments), file, *given)
    if arguments.json:
        names = "name", "file", "fmi_version", "platform", "inputs", "variables"
        print_json({**plain_fields(done, *names), "compiler": done.compiler.version})
        return 0
    variables = counted(len(done.variables), "variable")
    show(f"{done.file}: FMI {done.fmi_version}, {done.platform}, {variables}")
    show(f"inputs: {', '.join(done.inputs) or 'none'}")
    return 0
