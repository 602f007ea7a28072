"""Settings of a case, each said once: a file and the command line give the same."""

import shlex

import pytest

from painleve_sym.cli.case import read_case
from painleve_sym.cli.commands import COMMANDS
from painleve_sym.cli.parser import read_arguments
from painleve_sym.engines.protocol import RunSettings
from painleve_sym.present.run_page import scenario_command
from painleve_sym.study.scenario import Scenario
from painleve_sym.study.settings import SETTINGS

GIVEN = {
    "state": {"theta": 1.0},
    "parameters": {"mu": 1.5},
    "material": "steel",
    "contact": "A",
    "close": "y_A",
    "law": "hertz",
    "t_end": 0.5,
    "until": ["separation", "liftoff"],
    "watch": ["apex", "strobe(0.1, 0.2)"],
    "initial_force": 3.0,
    "phases": [{"time": 0.5, "parameters": {"mu": 0.2, "g": 5.0}}, {"time": 0.7, "law": "hertz"}],
    "inputs": {"mu": {"file": "record.csv"}, "g": {"file": "g.csv", "interpolation": "held"}},
    "rtol": 1e-9,
    "max_steps": 7,
    "max_events": 5,
    "engine": "compiled",
    "samples": 4,
    "contact_velocity": [-1.0, 2.0],
    "restitution": 0.5,
    "rule": "poisson",
    "impact_friction": "final_slip",
}
OF_RUNS = [n for n in GIVEN if SETTINGS[n].group in ("case", "law", "motion", "run")]


def option_text(value, name=""):
    if name == "phases":
        return "0.5:mu=0.2,g=5.0;0.7:law=hertz"
    if name == "inputs":
        return "mu=record.csv,g=g.csv:held"
    if isinstance(value, dict):
        return ",".join(f"{n}={v}" for n, v in value.items())
    return ",".join(map(str, value)) if isinstance(value, list) else str(value)


def of_command_line(command, name):
    words = [command, "rod", SETTINGS[name].option, option_text(GIVEN[name], name)]
    extra = ["--law", "hertz"] if name == "material" else []
    return read_case(read_arguments([*words, *extra]))


def test_every_option_of_a_setting_is_tried():
    assert set(GIVEN) | {"law_parameters"} == {n for n, of in SETTINGS.items() if of.group}


@pytest.mark.parametrize("name", GIVEN)
def test_file_and_option_give_the_same_field(name):
    command = "simulate" if name in OF_RUNS else "jump"
    data = {"model": "rod", name: GIVEN[name]} | ({"law": "hertz"} if name == "material" else {})
    of_file = Scenario.from_data(data)
    assert getattr(of_command_line(command, name), name) == getattr(of_file, name)
    assert getattr(of_file, name) != getattr(Scenario("rod"), name)


@pytest.mark.parametrize("name", OF_RUNS)
def test_the_command_of_a_scenario_says_each_setting_that_is_given(name):
    scenario = Scenario.from_data({"model": "rod", name: GIVEN[name]})
    words = shlex.split(scenario_command(scenario))
    text = option_text(GIVEN[name], name)
    assert words == ["painleve", "simulate", "rod", SETTINGS[name].option, text]


def test_settings_of_a_motion_that_are_given_go_to_the_run():
    given = {n: GIVEN[n] for n in ("t_end", "rtol", "max_steps", "max_events", "until")}
    scenario = Scenario.from_data({"model": "rod", **given})
    assert scenario.of_run == given | {"until": tuple(given["until"])}
    assert scenario.settings == RunSettings(**scenario.of_run)


def test_a_command_may_describe_an_option_otherwise():
    shown = {c: {o.name: o.settings["help"] for o in COMMANDS[c].options} for c in COMMANDS}
    assert shown["simulate"]["--t-end"] == SETTINGS["t_end"].help
    assert shown["fit"]["--t-end"] != SETTINGS["t_end"].help
