"""Cache entries depend neither on the order of sets, which processes differ in, nor on time."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

SCRIPT = """
import sys
from painleve_sym.cli import main
for command in sys.argv[1:]:
    if main(command.split()):
        sys.exit(command)
"""
SEEDS = ("1", "2", "3")


def start(seed, folder, commands):
    """Start a process that runs commands with a cache of its own."""
    folder.mkdir(mode=0o700)
    own = {"PYTHONHASHSEED": seed, "PAINLEVE_CACHE": str(folder)}
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT, *commands],
        env={**os.environ, **own},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def entries(folder):
    """Return the content of each entry by its name; of a library the name alone."""
    return {
        path.name: "" if path.suffix == ".so" else path.read_text("utf-8")
        for path in folder.glob("painleve-*")
        if path.is_file()
    }


def check(commands, seeds, tmp_path):
    started = [start(seed, tmp_path / seed, commands) for seed in seeds]
    printed = [process.communicate(timeout=300) for process in started]
    assert [process.returncode for process in started] == [0] * len(seeds), printed
    kept = [entries(tmp_path / seed) for seed in seeds]
    assert len(kept[0]) > len(commands)
    for own, (out, _) in zip(kept[1:], printed[1:], strict=True):
        assert sorted(own) == sorted(kept[0])
        assert own == kept[0]
        assert out == printed[0][0]


def test_entries_of_a_derivation_are_the_same_for_every_order_of_sets(tmp_path):
    check(
        ["classify rod --state theta=1,x_A_dot=-1 --json", "automaton rod --law rigid --json"],
        SEEDS[:2],
        tmp_path,
    )


@pytest.mark.slow
def test_entries_of_motions_and_formulas_are_the_same_for_every_order_of_sets(tmp_path):
    commands = [
        "simulate rod --law bilinear-hertz --state theta=1,y_A=0.01 --t-end 0.01 --json",
        "simulate block-two-feet --law rigid --t-end 0.001 --json",
        "derive block-two-feet --json",
        "automaton rod --law rigid --json",
        "classify slider-3d --json",
        "map strut --over theta,mu --points 5 --json",
    ]
    check(commands, SEEDS, tmp_path)
