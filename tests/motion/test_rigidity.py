"""Contact durations against natural periods: the periods, the durations, the sentences."""

from __future__ import annotations

import json
import math
import pickle
import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import painleve_sym as ps
from painleve_sym.errors import ModelError
from painleve_sym.mechanics.materials import material
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion import EventRecord
from painleve_sym.motion.rigidity import (
    RIGID_PERIODS,
    BodyPeriod,
    body_periods,
    contact_durations,
    rigidity_notices,
)
from tests.cli.cli_helpers import TABLE_3, run, run_json

START = {"theta": 1.0, "x_A_dot": -1.0, "theta_dot": 1.0}
SLIDER = """\
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
m = { default = 1.0, unit = "kg", positive = true }
g = { default = 9.8, unit = "m/s^2", lower = 0 }
T_1 = { default = 0.02, unit = "s", positive = true }
mu = { default = 0.5, unit = "1" }
[[bodies]]
name = "slider"
mass = "m"
centre = ["x", "y"]
lowest_period = "T_1"
[[contacts]]
name = "A"
friction = "mu"
point = ["x", "y"]
"""


def test_first_bending_period_of_the_rod_is_that_of_a_free_bar():
    """f = β² r/(4 π L²) √(Y/ρ) with β = 4.730: Blevins, table 8-1; radius r of the section."""
    rod, steel = ps.model("rod"), material("steel")
    (period,) = body_periods(rod, {**rod.parameters, "m": 2.0, "l": 0.5}, steel)
    radius = math.sqrt(2.0 / (math.pi * steel.density * 1.0))
    speed = math.sqrt(steel.young_modulus / steel.density)
    frequency = 4.730040744862704**2 * radius / 2 * speed / (2 * math.pi)
    assert period.period == pytest.approx(1 / frequency, rel=1e-13)
    assert (period.body, period.modelled, period.material) == ("rod", False, "steel")
    assert body_periods(rod, rod.parameters) == ()
    assert body_periods(ps.model("rod-inertia"), {}, steel) == ()


def test_modes_of_the_elastic_rod_have_their_shortest_period_of_each_kind():
    elastic = ps.model("rod-bending:2,1")
    bending, axial = body_periods(elastic, elastic.parameters)
    first, second = 4.730040744862704, 7.853204624095838
    rigid = body_periods(ps.model("rod"), {"m": 1.0, "l": 1.0, "g": 9.8, "mu": 1.4},
                         material("steel"))[0]  # fmt: skip
    steel = material("steel")
    scale = math.sqrt(steel.young_modulus / 2.09e11) * 7850 / steel.density
    assert bending.period == pytest.approx(rigid.period * (first / second) ** 2 * scale, rel=1e-12)
    assert axial.period == pytest.approx(4 * math.sqrt(7850 / 2.09e11), rel=1e-12)
    assert bending.modelled and axial.modelled


def test_what_a_pulse_of_ten_periods_leaves_in_vibration_is_a_tenth():
    def vibration(periods):
        def rate(t, y):
            return [y[1], math.sin(math.pi * t / periods) - (2 * math.pi) ** 2 * y[0]]

        end = solve_ivp(rate, (0, periods), [0.0, 0.0], rtol=1e-10, atol=1e-13).y[:, -1]
        return math.hypot((2 * math.pi) ** 2 * end[0], 2 * math.pi * end[1])

    lengths = np.linspace(RIGID_PERIODS, RIGID_PERIODS + 1, 9)
    left = max(map(vibration, lengths))
    assert 0.09 < left < 0.101
    assert max(map(vibration, np.linspace(0.5, 2, 7))) > 0.5


def test_contact_of_a_start_on_the_ground_and_of_a_bounce_are_measured():
    compliant = ps.simulate("rod", "bilinear-hertz", START, t_end=0.01, material="steel")
    separation = compliant.events_of("separation")[0].time
    assert contact_durations(compliant.events) == {"A": separation}
    falls = {"theta": 1.5, "y_A": 1e-3, "y_A_dot": -1.0}
    bounce = ps.simulate("rod", "hertz", falls, t_end=0.01)
    down, up = (bounce.events_of(kind)[0].time for kind in ("touchdown", "separation"))
    assert contact_durations(bounce.events) == {"A": up - down}
    rigid = ps.simulate("rod", "rigid", falls, t_end=0.01)
    assert contact_durations(rigid.events) == {}


def test_of_several_contacts_the_shortest_counts():
    """A lies on the ground at first, and bounces; B touches down once, and lasts to the end."""
    touch, part = ps.EventKind("touchdown"), ps.EventKind("separation")
    course = [(part, "A", 3.0), (touch, "A", 4.0), (touch, "B", 4.5), (part, "A", 4.8)]
    course += [(part, "B", 7.0), (touch, "A", 8.0), (part, "A", 9.5), (touch, "B", 9.7)]
    events = [
        EventRecord(time, kind, "", "", {}, 0.0, 0.0, 0.0, contact=contact)
        for kind, contact, time in course
    ]
    durations = contact_durations(events)
    assert durations == pytest.approx({"A": 0.8, "B": 2.5})
    (notice,) = rigidity_notices(durations, [BodyPeriod("rod", "bending", 1.0, False)])
    assert notice.startswith("The contact A lasts 0.8 s")


def test_a_run_says_that_its_rod_is_not_rigid_and_keeps_it_in_a_file(tmp_path):
    motion = ps.simulate("rod", "bilinear-hertz", START, t_end=0.01, material="steel")
    (notice,) = motion.notices
    assert notice.startswith(
        "The contact A lasts 0.0019 s; the period of the first bending mode of a steel bar of this "
        "mass and length is 0.099 s: rod is not rigid in this impact."
    )
    motion.save(tmp_path / "run.npz")
    assert ps.Trajectory.load(tmp_path / "run.npz").notices == motion.notices
    assert pickle.loads(pickle.dumps(motion)).notices == motion.notices
    assert ps.simulate("rod", "bilinear-hertz", START, t_end=0.01).notices == ()


def test_period_of_a_file_is_compared_and_a_soft_contact_is_long_enough():
    slider = mechanism_from_text(SLIDER)
    fall = {"y": 0.001, "y_dot": -0.1, "x_dot": 1.0}
    notices = {}
    for stiffness in (1e7, 1e4, 100.0):
        motion = ps.simulate(slider, "linear", fall, t_end=2.0, law_parameters={"k": stiffness},
                             parameters={"g": 0.0})  # fmt: skip
        duration = math.pi / math.sqrt(stiffness)
        assert contact_durations(motion.events)["A"] == pytest.approx(duration, rel=1e-6)
        notices[stiffness] = motion.notices
    assert (
        "lasts 0.00099 s; the period of the lowest mode is 0.02 s: slider is not rigid"
        in (notices[1e7][0])
    )
    assert "the vibration of slider that is left out is more than a tenth" in notices[1e4][0]
    assert notices[100.0] == ()


def test_modes_that_are_all_slower_than_the_contact_ask_for_more():
    slow = BodyPeriod("rod", "bending modes", 0.02, True)
    (notice,) = rigidity_notices({"A": 1e-3}, [slow])
    assert "the bending modes of rod in this mechanism have periods down to 0.02 s" in notice
    assert rigidity_notices({"A": 3e-2}, [slow]) == rigidity_notices({}, [slow]) == ()


@pytest.mark.slow
def test_commands_and_report_say_it(capsys, tmp_path):
    case = ("rod", "--state", TABLE_3, "--law", "bilinear-hertz", "--material", "steel")
    data = run_json(capsys, "jump", *case)
    assert [n for n in data["notices"] if "rod is not rigid in this impact" in n]
    page = tmp_path / "page.html"
    code, out, _ = run(capsys, "simulate", *case, "--t-end", "0.01", "--report", page)
    assert code == 0 and "rod is not rigid in this impact" in " ".join(out.split())
    text = page.read_text("utf-8")
    assert "rod is not rigid in this impact" in text and "--material steel" in text
    data = run_json(capsys, "simulate", "rod", "--state", TABLE_3, "--law", "linear",
                    "--material", "steel", "--t-end", "0.01")  # fmt: skip
    assert data["body_periods"][0]["material"] == "steel" and len(data["notices"]) == 1
    assert json.dumps(data)


@pytest.mark.parametrize(
    ("entry", "fault"),
    [
        ("0", "slider: lowest_period is 0, need > 0."),
        ('"-T_1"', "slider: lowest_period is -T_1, need > 0."),
        ('"T_1*x"', "slider: lowest_period is T_1*x, need a formula of parameters alone."),
    ],
)
def test_periods_that_cannot_be_are_errors(entry, fault):
    with pytest.raises(ModelError, match=re.escape(fault)):
        mechanism_from_text(SLIDER.replace('"T_1"', entry))


@pytest.mark.parametrize(
    ("periods", "said"), [(0.9, True), (9.5, True), (10.1, False), (40, False)]
)
def test_a_body_is_rigid_where_at_most_a_tenth_of_its_deflection_stays_in_vibration(periods, said):
    r = 1 / (2 * periods)
    left = abs(2 * r / (1 - r**2))
    assert (left > 0.1) == said
    notices = rigidity_notices({"A": periods * 0.02}, [BodyPeriod("rod", "bending", 0.02, False)])
    assert bool(notices) == said
    for notice in notices:
        assert f"lasts {periods * 0.02:.2g} s" in notice and "is 0.02 s" in notice
        assert ("is not rigid" in notice) == (periods < 1)
