"""Numbers that the commands print for people are those of their results."""

from __future__ import annotations

import re
from argparse import Namespace

import numpy as np
import pytest

from painleve_sym.cli.options import read_look
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.maps.region_map import LEGEND, region_map
from tests.cli.cli_helpers import LAW, STIFF, TABLE_3, TABLE_4, only_contact, run, run_json
from tests.study.sweep_cases import SMALL


def rows_under(text, first, last=None):
    """Return the cells of the lines below the one that begins with `first`, up to an empty one."""
    lines = text.splitlines()
    start = next(i for i, line in enumerate(lines) if line.strip().startswith(first))
    rows = []
    for line in lines[start + 1 :]:
        if not line.strip() or (last and line.strip().startswith(last)):
            break
        rows.append(re.split(r"\s{2,}", line.strip()))
    return rows


def numbers_of(cells):
    return [float(cell) for cell in cells]


def test_events_and_end_of_a_motion(capsys):
    command = ("simulate", "rod", "--state", TABLE_3, *LAW, "--t-end", "0.01")
    _, out, _ = run(capsys, *command)
    data = run_json(capsys, *command)
    rows = rows_under(out, "time [s]")
    assert len(rows) == len(data["events"])
    for (time, kind, mode, force, depth), event in zip(rows, data["events"], strict=True):
        assert (kind, mode) == (event["kind"], event["mode_after"])
        assert float(time) == pytest.approx(event["time"], rel=1e-8)
        assert float(force) == pytest.approx(event["normal_force"], rel=1e-5, abs=1e-10)
        assert float(depth) == pytest.approx(event["compression"], rel=1e-5, abs=1e-15)
    end = {name: (float(value), unit) for name, value, unit in rows_under(out, "state", "21")}
    final = {**data["final"]["state"], "normal_force": data["final"]["normal_force"]}
    units = model("rod").state_units | {"normal_force": "N"}
    for name, unit in units.items():
        assert end[name] == (pytest.approx(final[name], rel=1e-8, abs=1e-12), unit)


def test_solutions_of_a_contact_problem(capsys):
    command = ("classify", "rod", "--state", TABLE_4)
    _, out, _ = run(capsys, *command)
    _, solutions = only_contact(run_json(capsys, *command))
    rows = rows_under(out, "solution")[: len(solutions)]
    for (mode, *cells), solution in zip(rows, solutions, strict=True):
        assert mode == solution["name"]
        expected = [solution["normal_force"], *solution["tangential_force"]]
        expected += [solution["normal_acceleration"], *solution["tangential_acceleration"]]
        assert numbers_of(cells) == pytest.approx(expected, rel=1e-5, abs=1e-12)


def test_phases_and_velocities_of_a_jump(capsys):
    command = ("jump", "rod", "--state", TABLE_3)
    _, out, _ = run(capsys, *command)
    data = run_json(capsys, *command)
    for (name, *cells), phase in zip(rows_under(out, "phase"), data["phases"], strict=True):
        assert name == phase["name"]
        impulse = phase["normal_impulse"], *phase["tangential_impulse"]
        assert numbers_of(cells) == pytest.approx([*impulse, phase["stored_energy"]], rel=1e-5)
    _, (before, *start), *courses = rows_under(out, "velocities at the end")
    assert (before, numbers_of(start)) == ("before", [-1.0, 0.0, 1.0])
    for (_, *cells), phase in zip(courses, data["phases"], strict=True):
        expected = list(phase["velocity"].values())
        assert numbers_of(cells) == pytest.approx(expected, rel=1e-5, abs=1e-12)
    energy = re.search(r"energy change (\S+) J", out)
    assert float(energy[1]) == pytest.approx(data["energy_change"], rel=1e-5)


def test_shares_of_a_map_are_those_of_its_points(capsys):
    regions = region_map("rod", ("theta", "theta_dot"), points=40)
    _, out, _ = run(capsys, "map", "rod", "--over", "theta,theta_dot", "--points", "40")
    shares = {row[0]: row[1] for row in rows_under(out, "case", "a contact")}
    for name, count in regions.counts.items():
        if name in shares:
            assert shares[name] == f"{100 * count / 1600:.2f} %"
    assert {n for n in LEGEND if n != "outside"} <= set(shares)
    stick = re.search(r"could stick at (\S+) %", out)
    assert stick[1] == f"{100 * np.mean(regions.stick_feasible):.2f}"


@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
def test_a_contact_whose_force_moves_nothing_cannot_stick():
    # A straight arm has a singular mobility: A' is 0 but for rounding of either sign.
    regions = region_map("two-link-arm", ("theta_1", "theta_2"), points=60)
    singular = regions.A_stick <= 1e-13
    assert (regions.A_stick < 0).any() and singular.sum() > 20
    assert not regions.stick_feasible[singular].any() and regions.stick_feasible.any()


def test_ranges_of_a_sweep_are_those_of_all_its_points(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SMALL)
    code, out, _ = run(capsys, "sweep", "small.toml", "--out", "small.npz")
    assert code == 0
    rows = {name: rest for name, *rest in rows_under(out, "quantity", "written")}
    with np.load("small.npz") as data:
        assert len(rows) > 3
        for name, (low, high, *_) in rows.items():
            number, _, unit = high.partition(" ")
            ends = [float(low), float(number)]
            assert ends == pytest.approx([data[name].min(), data[name].max()], rel=1e-5)
            assert unit == {"max_normal_force": "N", "integral_normal_force": "N s"}.get(name, unit)


@pytest.mark.slow
def test_estimates_and_intervals_of_a_fit(capsys):
    command = ("fit", "examples/studies/fit/impacts.csv", "rod", *LAW, "--level", "0.9",
               "--estimate", "e_energetic,mu,E")  # fmt: skip
    _, out, _ = run(capsys, *command)
    data = run_json(capsys, *command)
    assert "90 % interval" in out
    known = {own["name"]: own for own in data["estimates"]}
    for name, start, estimate, error, interval, *unit in rows_under(out, "start"):
        own = known[name]
        assert float(start) == pytest.approx(own["start"])
        assert float(estimate) == pytest.approx(own["estimate"], rel=1e-6)
        assert float(error) == pytest.approx(own["standard_error"], rel=5e-3)
        assert numbers_of(interval.split(" to ")) == pytest.approx(own["interval"], rel=1e-6)
        assert unit == (["Pa"] if name == "E" else [])
    correlation = np.abs(np.array(data["correlation"]) - np.eye(3))
    i, j = np.unravel_index(correlation.argmax(), (3, 3))
    names = list(known)
    said = re.search(r"largest correlation: (\w+) with (\w+), (\S+)", out)
    assert {said[1], said[2]} == {names[i], names[j]}
    assert abs(float(said[3])) == pytest.approx(correlation.max(), rel=5e-3)


def test_critical_forces_and_their_derivatives(capsys):
    command = ("critical", "rod", "--state", TABLE_4, *STIFF, "--gradient", "mu,E")
    _, out, _ = run(capsys, *command)
    data = run_json(capsys, *command)
    values = [float(row[0]) for row in rows_under(out, "critical force", "expansion")]
    assert values == pytest.approx([f["value"] for f in data["critical"].values()], rel=1e-14)
    rows = rows_under(out, "derivative by")
    assert [(name, unit) for name, *_, unit in rows] == [("mu", "N"), ("E", "N per Pa")]
    for name, value, *_ in rows:
        assert float(value) == pytest.approx(data["gradient"][name]["value"], rel=1e-8)


@pytest.mark.parametrize(("text", "inches"), [("12", 12 / 2.54), ("85mm", 8.5 / 2.54), ("page", 7)])
def test_the_width_of_a_figure_is_in_cm(text, inches):
    look = read_look(Namespace(width=text, title=None, format=None))
    assert look == {"width": pytest.approx(inches, rel=1e-14)}


def test_samples_of_a_motion_are_its_values(capsys):
    command = ("simulate", "rod", "--state", TABLE_3, *LAW, "--t-end", "0.01", "--samples", "5")
    _, out, _ = run(capsys, *command)
    start = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    motion = Simulator(model("rod"), _law()).run(start, t_end=0.01)
    rows = np.array([numbers_of(row) for row in rows_under(out.split("\n\n", 2)[2], "time [s]")])
    names = ("gap", "slip_velocity", "gap_rate", "normal_force", "tangential_force")
    for column, name in enumerate(names, 1):
        expected = motion.values(name, np.linspace(0, 0.01, 5))
        np.testing.assert_allclose(rows[:, column], expected, rtol=1e-5, atol=1e-12)


def _law():
    from painleve_sym.laws.catalogue import law

    return law(LAW[1])
