"""Helpers shared by the tests of the command line."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

from painleve_sym.cli import main

ROOT = Path(__file__).resolve().parents[2]
# Starts of the paper's tables.
TABLE_1 = "theta=0.5,theta_dot=1,x_A_dot=-1"
TABLE_2 = "theta=0.5,theta_dot=5,x_A_dot=-1"
TABLE_3 = "theta=1,theta_dot=1,x_A_dot=-1"
TABLE_4 = "theta=1,theta_dot=5,x_A_dot=-1"
LAW = ("--law", "bilinear-hertz")
STIFF = (*LAW, "--law-set", "E=20.9e14,n=1.764,e_energetic=0.75,reload=virgin")


def run(capsys, *arguments):
    """Return exit code, standard output and standard error of one call."""
    code = main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    return code, out, err


def rejected(capsys, *arguments):
    """Return the one line that a rejected call writes, with exit code 2."""
    code, out, err = run(capsys, *arguments)
    assert (code, out) == (2, "") and err.startswith("painleve: error: ")
    assert err.count("\n") == 1 and "Traceback" not in err
    return err


def run_json(capsys, *arguments, code=0):
    """Return the parsed output of a call with --json, whose errors must be empty."""
    returned, out, err = run(capsys, *arguments, "--json")
    assert returned == code, err
    assert err == ""
    assert out.endswith("}\n")
    return json.loads(out, parse_constant=no_constant)


def no_constant(name):
    raise AssertionError(f"{name} is not JSON")


def process(*arguments, **options):
    """Run the command in a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **options.pop("env", {})}
    return subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        env=environment,
        timeout=120,
        check=False,
        **options,
    )


def only_contact(data):
    """Return what the JSON of classify says of the only contact: its numbers, and its solutions."""
    ((name, own),) = data["contacts"].items()
    return own, [s["contacts"][name] for s in data["solutions"]]
