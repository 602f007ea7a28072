"""The outputs in examples/output are what the commands print today."""

from __future__ import annotations

import json
import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
SCRIPT = runpy.run_path(str(EXAMPLES / "make_output.py"))
FAST = [("rod", "classify"), ("rod", "jump"), ("strut", "classify")]
# The steps of a solver depend on the machine, its results do not.
COUNTED = {"counters", "energy_residual", "wall_time"}
FILES = sorted(
    (name, path.stem)
    for name in SCRIPT["CASES"]
    for path in (EXAMPLES / "output" / Path(name).stem).glob("*.json")
)


def _same(actual, kept, where=""):
    if isinstance(kept, dict):
        assert set(actual) == set(kept), where
        for key in kept:
            if key not in COUNTED:
                _same(actual[key], kept[key], f"{where}/{key}")
    elif isinstance(kept, list):
        assert len(actual) == len(kept), where
        for i, pair in enumerate(zip(actual, kept, strict=True)):
            _same(*pair, f"{where}/{i}")
    elif isinstance(kept, float):
        assert actual == pytest.approx(kept, rel=1e-9, abs=1e-11), where
    else:
        assert actual == kept, where


def _check(name, command):
    text = (EXAMPLES / "output" / Path(name).stem / f"{command}.json").read_text("ascii")
    output = SCRIPT["output"](SCRIPT["commands"](name)[command])
    _same(json.loads(json.dumps(output)), json.loads(text))


def test_at_least_six_mechanisms_have_outputs():
    assert len({name for name, _ in FILES}) >= 6


@pytest.mark.parametrize(("name", "command"), FAST)
def test_kept_output_is_what_the_command_prints(name, command):
    _check(name, command)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "command"), [f for f in FILES if f not in FAST])
def test_every_kept_output_is_what_the_command_prints(name, command):
    _check(name, command)
