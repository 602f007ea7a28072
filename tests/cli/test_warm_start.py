"""Commands of a named mechanism that ran before: nothing heavy is imported, no bit differs."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

HEAVY = ("casadi", "matplotlib", "scipy", "sympy")
ROD = ("rod", "--state", "theta=1,theta_dot=1,x_A_dot=-1")
SLIDING = ("rod", "--state", "theta=1,theta_dot=5,x_A_dot=-1")
FEET = ("block-two-feet", "--state", "x_A_dot=-1")
COMMANDS = {
    "version": ("--version",),
    "help": ("--help",),
    "derive": ("derive", "rod"),
    "derive as data": ("derive", "block", "--json"),
    "models": ("models", "--json"),
    "laws": ("laws", "--json"),
    "classify": ("classify", *ROD, "--json"),
    "jump": ("jump", *ROD, "--json"),
    "jump by a law": ("jump", *ROD, "--law", "hertz", "--configuration", "carried", "--json"),
    "critical": ("critical", *SLIDING, "--law-set", "E=209e9", "--gradient", "mu", "--json"),
    "compliant": ("simulate", *ROD, "--law", "bilinear-hertz", "--t-end", "0.002", "--json"),
    "rigid": ("simulate", *ROD, "--law", "rigid", "--t-end", "0.1", "--json"),
    "two contacts": ("simulate", *FEET, "--law", "rigid", "--t-end", "0.1", "--json"),
}
NEEDED = {"critical": ["casadi"]}
"""What a command cannot do without: CasADi evaluates long formulas that are not compiled."""
WARM = """
import json, sys
from painleve_sym.cli import main
code = main(sys.argv[2:])
sys.stdout.flush()
imported = [name for name in json.loads(sys.argv[1]) if name in sys.modules]
print(json.dumps(imported), file=sys.stderr)
raise SystemExit(code)
"""
COLD = """
import json, os, sys
import casadi, scipy, sympy
from painleve_sym.cli import main
folder, commands = sys.argv[1], json.loads(sys.argv[2])
for name, command in commands.items():
    if (child := os.fork()) == 0:
        os.environ["PAINLEVE_CACHE"] = os.path.join(folder, name)
        file = os.open(os.path.join(folder, f"{name}.txt"), os.O_WRONLY | os.O_CREAT)
        os.dup2(file, 1)
        code = main(command)
        sys.stdout.flush()
        os._exit(code)
    assert os.waitpid(child, 0)[1] == 0, name
"""


def process(*arguments, **variables):
    done = subprocess.run(
        [sys.executable, "-c", *arguments],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))} | variables,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr.decode()
    return done


@pytest.fixture(scope="module")
def cold(tmp_path_factory):
    """Run each command with an empty cache of its own; return the folder of caches and outputs.

    Their processes come from one that has imported what all of them need.
    """
    folder = tmp_path_factory.mktemp("cold")
    process(COLD, str(folder), json.dumps(COMMANDS))
    return folder


def test_modules_of_commands_that_the_cache_serves_do_not_load_sympy():
    commands = ("classify", "critical", "derive", "explore", "export", "map", "run", "sweep")
    modules = [f"painleve_sym.cli.{name}" for name in commands]
    modules += [f"painleve_sym.explorer.{name}" for name in ("exact_start", "source", "wasm")]
    process(
        "import sys, " + ", ".join(modules) + "; assert not {'sympy', 'scipy'} & {*sys.modules}"
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_second_time_a_command_imports_nothing_heavy_and_prints_the_same(name, cold):
    command = (json.dumps(HEAVY), *COMMANDS[name])
    warm = process(WARM, *command, PAINLEVE_CACHE=str(cold / name))
    assert json.loads(warm.stderr.splitlines()[-1]) == NEEDED.get(name, [])
    assert warm.stdout == (cold / f"{name}.txt").read_bytes() != b""
