"""A mechanism file goes wherever a model name goes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from painleve_sym.cli import main

FILES = Path(__file__).parents[2] / "examples" / "mechanisms"
STATE = ("--state", "theta=1,theta_dot=1,x_A_dot=-1")


def output(capsys, *arguments):
    assert main([*map(str, arguments), "--json"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    "arguments",
    [
        ("classify", *STATE),
        ("simulate", *STATE, "--law", "bilinear-hertz", "--t-end", "0.004"),
        ("simulate", *STATE, "--law", "rigid", "--t-end", "0.004"),
        ("jump", *STATE, "--restitution", "0.5"),
    ],
    ids=["classify", "softened", "rigid", "jump"],
)
def test_the_rod_as_a_file_gives_the_numbers_of_the_named_rod(capsys, arguments):
    command, *rest = arguments
    named = output(capsys, command, "rod", *rest)
    filed = output(capsys, command, FILES / "rod.toml", *rest)
    for key in ("A", "B", "case", "final", "phases"):
        if key in named:
            assert _close(filed[key], named[key]), key


def _close(a, b):
    if isinstance(a, dict):
        return set(a) >= set(b) and all(_close(a[k], b[k]) for k in b)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(_close, a, b))
    return a == pytest.approx(b, rel=1e-9, abs=1e-12) if isinstance(a, float) else a == b


@pytest.mark.slow
def test_derive_of_a_file_has_its_words_and_its_default_parameters(capsys, tmp_path):
    text, path = (FILES / "wheel-on-slope.toml").read_text("utf-8"), tmp_path / "wheel.toml"
    pages = []
    for title, distance in [("driven", "0.1"), ("driven", "0.2"), ("drawn", "0.2")]:
        changed = text.replace("driven eccentric", f"{title} eccentric")
        path.write_text(changed.replace("default = 0.1, ", f"default = {distance}, "), "utf-8")
        assert main(["derive", str(path)]) == 0
        pages.append(capsys.readouterr().out)
    first, second, third = pages
    assert "finds 1.07029, at phi = 0.765487." in first
    assert "finds" in second and "1.07029" not in second
    assert third == second.replace("driven eccentric", "drawn eccentric")


def test_a_file_that_is_no_mechanism_and_no_scenario_is_one_sentence(capsys, tmp_path):
    path = tmp_path / "broken.toml"
    path.write_text("[coordinates\n")
    assert main(["classify", str(path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
