"""The command export: a mechanism with a contact law as C code that stands alone."""

from __future__ import annotations

import argparse

from painleve_sym.c_export.export import export_scenario
from painleve_sym.c_export.files import NUMERIC_FLAGS
from painleve_sym.cli.case import read_case
from painleve_sym.cli.options import output_folder
from painleve_sym.cli.output import print_json, show
from painleve_sym.cli.run import ending
from painleve_sym.plain_data import plain_fields
from painleve_sym.quantities import counted


def export(arguments: argparse.Namespace) -> int:
    """Write the C code and print how to build it."""
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
