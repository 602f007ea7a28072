"""Scenario files: the same as options, overridden by options, and rejected where wrong."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from painleve_sym.study.scenario import Scenario
from tests.cli.cli_helpers import STIFF, TABLE_3, rejected, run, run_json

TEXT = """\
title = "Table 3, stiff"
model = "rod"
t_end = 0.01
until = ["separation"]
state = { theta = 1, theta_dot = 1.0, x_A_dot = -1.0 }
restitution = 0.75

[parameters]
mu = 1.4

[law]
name = "bilinear-hertz"
reload = "virgin"
parameters = { E = 20.9e14, n = 1.764, e_energetic = 0.75 }
"""
OPTIONS = ("rod", "--state", TABLE_3, "--set", "mu=1.4")


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(TEXT, "utf-8")
    return path


def test_simulate_scenario_equals_options(capsys, file):
    more = (*STIFF, "--t-end", "0.01", "--until", "separation")
    assert run_json(capsys, "simulate", file) == run_json(capsys, "simulate", *OPTIONS, *more)


def test_classify_scenario_equals_options(capsys, file):
    assert run_json(capsys, "classify", file) == run_json(capsys, "classify", *OPTIONS)


def test_jump_scenario_equals_options(capsys, file):
    more = ("--restitution", "0.75", *STIFF)
    assert run_json(capsys, "jump", file) == run_json(capsys, "jump", *OPTIONS, *more)


def test_options_override_the_file_entry_by_entry(capsys, file):
    change = ("--state", "theta=0.9", "--set", "mu=1.5", "--law-set", "E=20.9e10")
    data = run_json(capsys, "simulate", file, *change, "--t-end", "1e-3")
    assert data["parameters"]["mu"] == 1.5
    assert data["parameters"]["E"] == 20.9e10
    assert data["parameters"]["e_energetic"] == 0.75
    assert data["choices"] == {"reload": "virgin"}
    assert data["final"]["time"] == 1e-3
    state = run_json(capsys, "classify", file, "--state", "theta=0.9")["state"]
    assert (state["theta"], state["x_A_dot"]) == (0.9, -1.0)


def test_another_law_drops_the_law_parameters_of_the_file(capsys, file):
    data = run_json(capsys, "simulate", file, "--law", "hertz", "--t-end", "1e-4")
    assert data["law"] == "hertz"
    assert data["parameters"]["E"] == 20.9e10


def test_title_is_shown(capsys, file):
    _, out, _ = run(capsys, "classify", file)
    assert out.startswith("Table 3, stiff\n")


def test_model_and_law_may_be_tables_or_names(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text('law = "hertz"\nuntil = "separation"\n[model]\nname = "rod"\n', "utf-8")
    scenario = Scenario.read(path)
    assert (scenario.model, scenario.law, scenario.until) == ("rod", "hertz", ("separation",))


WRONG = [
    ('model = "rod', "not valid TOML"),
    ('model = "rod"\nmodel = "rod"', "not valid TOML"),
    ("t_end = 1", "no model"),
    ('model = "rod"\ntend = 1', "Did you mean 't_end'?"),
    ('model = "rdo"\nstate = { theta = 1 }', "Did you mean 'rod'?"),
    ("model = 1", "name of a mechanism"),
    ('[model]\nname = "rod"\nmas = 1', "unknown key 'mas'"),
    ('model = "rod"\nt_end = "1"', "t_end: got '1', need a number"),
    ('model = "rod"\nt_end = true', "t_end: got True, need a number"),
    ('model = "rod"\nt_end = 1' + "0" * 400, "a whole number has more than"),
    ('model = "rod"\nstate = 1', "a table of numbers"),
    ('model = "rod"\nstate = { theta = "1" }', "state.theta: got '1'"),
    ('model = "rod"\nstate = { theta = nan }', "need a finite number"),
    ('model = "rod"\nstate = { thta = 1 }', "Did you mean 'theta'?"),
    ('model = "rod"\nstate = { theta = 1 }\nparameters = { m = 0 }', "0 < m"),
    ('model = "rod"\nmax_steps = 1.5', "whole number"),
    ('model = "rod"\nmax_steps = 0', "whole number"),
    ('model = "rod"\nuntil = [1]', "kind of an event"),
    ('model = "rod"\nengine = 1', "text in quotes"),
    ('model = "rod"\nlaw = 1', "a table [law]"),
    ('model = "rod"\n[law]\nname = "hrtz"', "Did you mean 'hertz'?"),
    ('model = "rod"\n[law]\nname = "hertz"\nE = 1e9', "[law.parameters]"),
    ('model = "rod"\n[law]\nname = "bilinear-hertz"\nrelod = "virgin"', "Did you mean 'reload'?"),
    ('model = "rod"\n[law]\nname = "bilinear-hertz"\nreload = 1', "text in quotes"),
    ('model = "rod"\nlaw = "hertz"\nparameters = { E = 1 }', "belongs to the law"),
]


@pytest.mark.parametrize(("text", "words"), WRONG)
def test_wrong_scenario_is_one_line_and_exit_code_2(capsys, tmp_path, text, words):
    path = tmp_path / "case.toml"
    path.write_text(text, "utf-8")
    assert words in rejected(capsys, "classify", path)


SEVERAL = """\
model = "rod"
t_ende = 0.01
until = ["seperation"]
state = { theta = "30 deg", thta = 1.0, x_A_dot = "fast" }
rtol = "small"

[parameters]
m = -1.0
E = 1e9

[law]
name = "hertz"
relod = "virgin"
parameters = { E = "209 GPa", nuu = 0.3 }
"""


def test_every_mistake_of_a_file_is_named_with_its_line(capsys, tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(SEVERAL, "utf-8")
    code, out, err = run(capsys, "simulate", path)
    assert (code, out) == (2, "")
    places = re.findall(r"line (\d+), ([\w.]+):", err)
    assert places == [
        *(("2", "t_ende"), ("3", "until"), ("4", "state.thta"), ("4", "state.x_A_dot")),
        *(("5", "rtol"), ("8", "parameters.m"), ("9", "parameters.E")),
        *(("13", "law.relod"), ("14", "law.parameters.nuu")),
    ]
    for near in ("'t_end'", "'separation'", "'theta'", "'nu'"):
        assert f"Did you mean {near}?" in err
    assert "belongs to the law" in err and "0 < m" in err


def test_numbers_of_a_file_may_have_units(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(
        'model = "rod"\nt_end = "2 ms"\ninitial_force = "1 kN"\n'
        'state = { theta = "45 deg" }\nparameters = { m = "200 g" }\n'
        '[law]\nname = "hertz"\nparameters = { E = "209 GPa" }\n',
        "utf-8",
    )
    scenario = Scenario.read(path)
    assert (scenario.t_end, scenario.initial_force) == (0.002, 1000.0)
    assert scenario.state == {"theta": pytest.approx(math.pi / 4, rel=1e-15)}
    assert (scenario.parameters, scenario.law_parameters) == ({"m": 0.2}, {"E": 209e9})


@pytest.mark.parametrize("name", ["missing.toml", "folder.toml", "bytes.toml", "sub/none"])
def test_scenario_file_that_cannot_be_read(capsys, tmp_path, name):
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    assert "scenario file" in rejected(capsys, "simulate", tmp_path / name)


def test_scenario_file_that_never_ends_is_refused(capsys):
    if not Path("/dev/zero").exists():
        pytest.skip("this system has no /dev/zero")
    assert "got more than" in rejected(capsys, "simulate", "/dev/zero")


def test_scenario_without_toml_suffix_is_found(capsys, file, monkeypatch):
    monkeypatch.chdir(file.parent)
    file.rename(file.parent / "case")
    assert run_json(capsys, "classify", "case")["case"] == "inconsistent"


def test_scenario_can_be_used_from_python(file):
    scenario = Scenario.read(file)
    assert scenario.classify().case.value == "inconsistent"
    assert scenario.simulate().events[-1].kind == "separation"
    assert scenario.jump().velocity["x_A_dot"] == 0


def test_an_absent_file_is_called_a_file_with_the_nearest_name(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hammer.toml").write_text("")
    code, out, err = run(capsys, "simulate", "hammr.toml", "--law", "hertz")
    assert (code, out) == (2, "")
    assert err == (
        "painleve: error: mechanism or scenario file hammr.toml: No such file or directory. "
        "Did you mean 'hammer.toml'? Fix: name a readable TOML file.\n"
    )
    assert "Did you mean" not in rejected(capsys, "simulate", "another.toml", "--law", "hertz")
