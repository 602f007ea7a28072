"""Exports in tests: a mechanism with awkward words, programs and libraries of exported C."""

from __future__ import annotations

import ctypes
import json
import shutil
import subprocess

import pytest

from painleve_sym.codegen.compile import find_compiler
from tests.languages import HOSTILE

_WORDS = json.dumps(" ".join(("a mass point */ int", *HOSTILE)))
# Its gap is not a coordinate, and its words try to leave their comments.
SLEDGE = (
    f"title = {_WORDS}\nsource = {_WORDS}"
    + """
name = "sledge"

[coordinates]
x = { unit = "m */ int y; /*", meaning = "place */ int y; /*" }
h = { unit = "m", meaning = "height" }

[parameters]
m = { default = 2.0, unit = "kg", meaning = "mass", positive = true }
g = { default = 9.8, unit = "m/s^2", meaning = "gravity", lower = 0 }
mu = { default = 0.3, unit = "1", meaning = "friction coefficient" }

[energy]
kinetic = "m*(x_dot**2 + h_dot**2)/2"
potential = "m*g*(h + x/10)"

[[contacts]]
name = "foot"
gap = "h + x/10"
slip_velocity = "x_dot"
friction = "mu"

[start]
x_dot = 1.0
h = 0.01
"""
)


def run(*command, cwd):
    """Return the standard output of a command that must succeed."""
    done = subprocess.run(
        [str(c) for c in command], cwd=cwd, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def needs_cmake():
    if shutil.which("cmake") is None:
        pytest.skip("cmake is not installed")


def built_by_cmake(done):
    """Return what the example prints, built as the export's own page says."""
    run("cmake", "-B", "build", cwd=done.folder)
    run("cmake", "--build", "build", cwd=done.folder)
    run("ctest", cwd=done.folder / "build")
    return run(f"build/{done.name}_example", cwd=done.folder)


def built_by_compiler(done, *flags):
    """Return what the example prints, built by one call of the compiler."""
    sources = ("main.c", *sorted(done.folder.glob(f"{done.name}_*.c")))
    run(*find_compiler().command, *flags, "-o", "example", *sources, "-lm", cwd=done.folder)
    return run("./example", cwd=done.folder)


def library(done):
    """Return the export as a shared library."""
    sources = sorted(done.folder.glob(f"{done.name}_*.c"))
    run(
        *find_compiler().command,
        "-O0",
        "-fPIC",
        "-shared",
        "-o",
        "export.so",
        *sources,
        "-lm",
        cwd=done.folder,
    )
    return ctypes.CDLL(str(done.folder / "export.so"))


def address(array):
    return ctypes.c_void_p(array.ctypes.data)
