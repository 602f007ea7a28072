"""Commands of a named mechanism that ran before: nothing heavy is imported, no bit differs."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

HEAVY = ("casadi", "matplotlib", "scipy", "sympy")
ROD = ("rod", "--state", "theta=1,theta_dot=1,x_A_dot=-1")
FEET = ("block-two-feet", "--state", "x_A_dot=-1")
COMMANDS = {
    "version": ("--version",),
    "help": ("--help",),
    "models": ("models", "--json"),
    "laws": ("laws", "--json"),
    "classify": ("classify", *ROD, "--json"),
    "jump": ("jump", *ROD, "--json"),
    "compliant": ("simulate", *ROD, "--law", "bilinear-hertz", "--t-end", "0.002", "--json"),
    "rigid": ("simulate", *ROD, "--law", "rigid", "--t-end", "0.1", "--json"),
    "two contacts": ("simulate", *FEET, "--law", "rigid", "--t-end", "0.1", "--json"),
}
PROGRAM = """
import json, sys
from painleve_sym.cli import main
code = main(sys.argv[2:])
sys.stdout.flush()
imported = [name for name in json.loads(sys.argv[1]) if name in sys.modules]
print(json.dumps(imported), file=sys.stderr)
raise SystemExit(code)
"""


def run(command, cache):
    """Return what a command in a process of its own prints, and which heavy packages it imports."""
    environment = {
        **os.environ,
        "PAINLEVE_CACHE": str(cache),
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
    }
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, json.dumps(HEAVY), *command],
        env=environment,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout, json.loads(done.stderr.splitlines()[-1])


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_second_time_a_command_imports_nothing_heavy_and_prints_the_same(command, tmp_path):
    cold, _ = run(command, tmp_path / "cache")
    warm, imported = run(command, tmp_path / "cache")
    assert imported == []
    assert warm == cold
