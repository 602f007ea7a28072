"""Values within the tolerance of a run are 0, and events within it are counted, not listed."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.cli.run import _show_run
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.present.run_page import run_page
from painleve_sym.study.scenario import Scenario

DRAWER = """
name = "drawer"
[coordinates]
x = { unit = "m", meaning = "place along" }
y = { unit = "m", meaning = "place across" }
phi = { unit = "rad", meaning = "angle" }
[parameters]
m = { default = 4.0, unit = "kg", meaning = "mass", positive = true }
a = { default = 0.1, unit = "m", meaning = "half depth", positive = true }
b = { default = 0.3, unit = "m", meaning = "half width", positive = true }
d = { default = 0.002, unit = "m", meaning = "clearance", positive = true }
h = { default = 0.25, unit = "m", meaning = "place of the handle" }
F = { default = 20.0, unit = "N", meaning = "pull" }
mu = { default = 0.5, unit = "1", meaning = "friction coefficient" }
[[bodies]]
mass = "m"
inertia = "m*(a**2 + b**2)/3"
angle = "phi"
centre = ["x", "y"]
[[loads]]
point = ["x + a*cos(phi) + h*sin(phi)", "y + a*sin(phi) - h*cos(phi)"]
force = ["F", "0"]
[[contacts]]
name = "front"
point = ["x + a*cos(phi) - b*sin(phi)", "y + a*sin(phi) + b*cos(phi)"]
slope = "pi"
through = ["0", "b + d"]
friction = "mu"
[[contacts]]
name = "rear"
point = ["x - a*cos(phi) + b*sin(phi)", "y - a*sin(phi) - b*cos(phi)"]
through = ["0", "-b - d"]
friction = "mu"
[start]
x_dot = 0.1
"""
WEDGED = 0.035
"""By then the drawer is jammed; s."""
PRESS = """
name = "press"
[coordinates]
y = { unit = "m", meaning = "height" }
[parameters]
m = { default = 1.0, unit = "kg", meaning = "mass", positive = true }
mu = { default = 0.0, unit = "1", meaning = "friction coefficient" }
[[bodies]]
mass = "m"
centre = ["0", "y"]
[[loads]]
point = ["0", "y"]
force = ["0", "-9.81*m"]
[[contacts]]
name = "foot"
gap = "y"
slip_velocity = "0"
friction = "mu"
[start]
y_dot = -1.0
"""
"""A mass on a spring and dashpot: it swings about its rest as exp(−20 t/s)."""


@pytest.fixture(scope="module")
def drawer():
    return ps.simulate(mechanism_from_text(DRAWER), "hunt-crossley", t_end=0.1)


@pytest.fixture(scope="module")
def run():
    """Return a motion that is resolved, as if its tolerance were 1e-6."""
    law = ps.law("linear").with_parameters(k=1e4, c=40.0)
    resolved = ps.simulate(mechanism_from_text(PRESS), law, t_end=1.4)
    return dataclasses.replace(resolved, rtol=1e-6)


def test_events_of_a_body_that_comes_to_rest_are_counted_and_not_listed(run):
    """The speed falls below rtol of its scale, that of the energy, as exp(−20 t/s)."""
    shown, limit = run.events_above_tolerance, run.tolerance("gap_rate")
    assert shown == run.events[: len(shown)] and 20 <= len(shown) <= len(run.events) - 5
    last, first = shown[-1].time, run.events[len(shown)].time
    later = np.abs(run(np.linspace(last, 1.4, 500))[:, 1])
    assert later[1:].max() <= limit
    assert np.abs(run(np.linspace(run.events[len(shown) - 2].time, last, 50))[:, 1]).max() > limit
    assert 0.5 < last < first < 1.0


@pytest.mark.slow
def test_events_of_a_body_that_is_wedged_are_counted_and_not_listed(drawer):
    """After the drawer stands nothing moves by more than 1e-13 m/s."""
    late = [e for e in drawer.events if e.time > WEDGED]
    assert len(late) > 100
    assert np.abs(drawer(np.linspace(WEDGED, 0.1, 500))[:, 3:6]).max() < 1e-13
    shown = drawer.events_above_tolerance
    assert all(e.time < WEDGED for e in shown)
    assert [e.kind for e in shown[:3]] == ["touchdown", "touchdown", "slip_stop"]
    assert 6 <= len(shown) <= 10


def test_events_of_a_motion_that_is_resolved_are_all_listed():
    run = ps.simulate("rod", "bilinear-hertz", {"theta": 1.0, "y_A": 0.01}, t_end=0.1)
    assert len(run.events) >= 5 and run.events_above_tolerance == run.events
    bounces = ps.simulate("rod", "rigid", {"theta": 1.0, "y_A": 0.01}, t_end=0.1)
    assert bounces.events_above_tolerance == bounces.events


def test_a_value_within_the_tolerance_of_the_run_is_zero(run):
    largest = np.abs(run["y_dot"]).max()
    assert run.tolerance("y_dot") == pytest.approx(1e-6 * largest, rel=1e-9)
    assert run.above_tolerance("y_dot", 0.9e-6 * largest) == 0
    assert run.above_tolerance("y_dot", -1.1e-6 * largest) == -1.1e-6 * largest


@pytest.mark.slow
def test_rounding_is_drawn_flat_and_the_impact_magnified(drawer):
    """The velocity across stays within 1e-14 m/s: its axis must not be as small."""
    figure = drawer.plot(width=8.6 / 2.54)
    panels = {axes.get_ylabel(): axes for axes in figure.axes}
    (across,) = [axes for label, axes in panels.items() if r"\dot{y}" in label]
    low, high = across.get_ylim()
    assert low < -1e-6 and high > 1e-6
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    near = [axes for axes, title in zip(figure.axes, titles, strict=True) if "magnified" in title]
    start, end = near[0].get_xlim()
    assert 32 < start < 33.21 and 34 < end < 36


def test_report_figure_and_command_line_list_the_same_events(run, tmp_path, capsys):
    path = tmp_path / "press.toml"
    path.write_text(PRESS)
    scenario = Scenario(str(path), law="linear", law_parameters={"k": 1e4, "c": 40.0}, t_end=1.4)
    folded = len(run.events) - len(run.events_above_tolerance)
    page = run_page(scenario, run).html()
    table = page[page.index('aria-label="Events"') : page.index(f"And {folded} events below")]
    assert table.count("<tr") == 1 + len(run.events_above_tolerance)
    _show_run(run, scenario, {})
    text = capsys.readouterr().out
    assert f"and {folded} events below the tolerance" in text
    assert len(re.findall(r"^ *[01]\.?\d* +[a-z]", text, re.M)) == len(run.events_above_tolerance)
    assert re.search(r"^ *y_dot +0 +m/s", text, re.M)
    figure = run.plot(width=8.6 / 2.54)
    words = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert f"{folded} events below the tolerance" in words
