"""The command explore: a mechanism as a page that computes in the browser."""

from __future__ import annotations

import argparse

from painleve_sym.cli.case import read_case
from painleve_sym.cli.options import output_file
from painleve_sym.cli.output import print_json, show
from painleve_sym.errors import InputError
from painleve_sym.explorer.page import explore as explorer_page
from painleve_sym.plain_data import plain_fields


def explore(arguments: argparse.Namespace) -> int:
    """Write the page and print its size."""
    path = output_file("--out", arguments.out, (".html",))
    scenario = read_case(arguments)
    if scenario.phases or scenario.inputs:
        raise InputError(
            "explore: got phases or inputs, and a page computes motions with the same parameters "
            "from start to end. Fix: leave them out."
        )
    page = explorer_page(
        scenario.mechanism(),
        scenario.contact_law() if scenario.law is not None else None,
        scenario.start(),
        parameters=scenario.parameters,
        law_parameters=scenario.law_parameters,
        initial_force=scenario.initial_force,
        t_end=scenario.t_end,
        docs=arguments.docs,
        out=path,
    )
    size = len(page.html.encode())
    if arguments.json:
        print_json(
            {
                "file": str(path),
                "bytes": size,
                **plain_fields(page, "mechanism", "law", "engines", "prebuilt", "module_bytes"),
            }
        )
        return 0
    origin = "part of the package" if page.prebuilt else "compiled, and kept in the cache"
    show(f"{path}: {size / 1000:.0f} kB, law {page.law}, engine {page.engines[0]} ({origin})")
    show("Open it in a browser; it needs no network.")
    return 0
