"""The command critical: its output, files and errors."""

from __future__ import annotations

import json
import os

import numpy as np
import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.motion.simulator import Simulator
from painleve_sym.present.figure_of_outcome import outcome_figure
from painleve_sym.present.style import write_figure
from painleve_sym.study.critical.bisection import CriticalForceFinder
from painleve_sym.study.critical.outcome_map import LEGEND, OutcomeMap, outcome_map
from tests.cli.cli_helpers import STIFF, TABLE_3, TABLE_4, rejected, run, run_json
from tests.support.paper_law import paper_law

ROD = ("critical", "rod", "--state", TABLE_4)
STATE = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}


def test_critical_json_holds_both_forces_expansion_and_gradient(capsys):
    data = run_json(capsys, *ROD, *STIFF, "--gradient", "theta_dot,E")
    forces = {k: v["value"] for k, v in data["critical"].items()}
    assert forces["slip_stop"] == pytest.approx(346.8785, abs=5e-5)
    assert forces["compression"] == pytest.approx(346.9994, abs=5e-5)
    low, high = data["critical"]["slip_stop"]["bracket"]
    assert np.nextafter(low, np.inf) == high == forces["slip_stop"]
    assert data["sliding"]["force"] == data["expansion"]["limit"]
    assert data["expansion"]["limit"] == pytest.approx(332.992, abs=5e-4)
    assert sum(data["expansion"].values()) == pytest.approx(346.97, abs=0.005)
    assert data["gradient"]["theta_dot"]["value"] == pytest.approx(259.7685, abs=1e-3)
    assert data["parameters"]["E"] == 20.9e14


def test_critical_text_names_both_borders(capsys):
    code, out, err = run(capsys, *ROD, *STIFF, "--gradient", "mu")
    assert (code, err) == (0, "")
    assert "346.8784715" in out and "346.9994403" in out
    assert "impact, not lift-off" in out and "before the maximum compression" in out
    assert "derivative by" in out and "N per" not in out
    assert all(len(line) <= 80 for line in out.splitlines())


def test_critical_text_tells_the_closed_form_with_an_approach(capsys):
    state = TABLE_4 + ",y_A_dot=-1e-3"
    code, out, _ = run(capsys, "critical", "rod", "--state", state, *STIFF)
    assert code == 0 and "approach included: 123.9" in out and "expansion" not in out


@pytest.mark.slow
def test_critical_map_over_the_stiffness(capsys, tmp_path):
    names = ("a.png", "a.svg", "a.pdf", "a.npz", "a.json")
    outs = [word for name in names for word in ("--out", str(tmp_path / name))]
    options = ("--over", "E=20.9e13:20.9e15", "--points", "9", "--forces", "330:370")
    data = run_json(capsys, *ROD, *options, *outs)
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(names)
    assert [os.path.basename(f) for f in data["files"]] == list(names)
    assert sum(data["counts"].values()) == 81 and data["counts"]["undecided"] == 0
    whole = json.loads((tmp_path / "a.json").read_text("ascii"))
    back = OutcomeMap.load(tmp_path / "a.npz")
    np.testing.assert_array_equal(whole["outcome"], back.outcome)
    assert back.logarithmic and back.unit == "Pa" and "E" not in back.parameters
    # Every run lies on the side of the critical forces that its outcome says.
    lifts = back.outcome == LEGEND["lifts_off"]
    impacts = back.outcome == LEGEND["stops_in_compression"]
    np.testing.assert_array_equal(lifts, back.forces[:, None] < back.slip_stop)
    np.testing.assert_array_equal(impacts, back.forces[:, None] >= back.compression)
    write_figure(outcome_figure(back), tmp_path / "b.png")
    assert (tmp_path / "b.png").read_bytes() == (tmp_path / "a.png").read_bytes()


def test_critical_map_over_the_approach_as_text(capsys):
    options = (*STIFF, "--over", "y_A_dot=-3e-3:1e-3", "--points", "7")
    code, out, err = run(capsys, *ROD, *options)
    assert (code, err) == (0, "")
    assert "y_A_dot [m/s]" in out and "none" in out
    assert all(len(line) <= 80 for line in out.splitlines())


def test_outcome_map_leaves_out_what_is_not_indeterminate(tmp_path):
    finder = CriticalForceFinder(Simulator(model("rod"), paper_law()))
    outcomes = outcome_map(
        finder,
        STATE,
        "theta",
        (0.9, 1.3),
        points=5,
        parameters={"E": 20.9e16},
    )
    inside = np.isfinite(outcomes.limit)
    assert inside.tolist() == [False, True, True, True, False]
    assert np.all(outcomes.outcome[:, ~inside] == LEGEND["undecided"])
    assert not np.any(outcomes.outcome[:, inside] == LEGEND["undecided"])
    texts = [t.get_text() for t in outcome_figure(outcomes).legends[0].get_texts()]
    assert "not indeterminate, or undecided" in texts
    with pytest.raises(InputError, match=r"need one of \.png"):
        write_figure(outcome_figure(outcomes), tmp_path / "a.txt")
    (tmp_path / "no.npz").write_bytes(b"nothing")
    with pytest.raises(InputError, match="written by save"):
        OutcomeMap.load(tmp_path / "no.npz")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("critical", "rod", "--state", TABLE_3), "need A < 0 and B > 0"),
        (("critical", "rod"), "need A < 0 and B > 0"),
        ((*ROD, "--law", "rigid"), "a rigid contact has no initial force"),
        (("critical", "block-two-feet", "--law", "A=hertz,B=hertz"), "that of one contact"),
        ((*ROD, "--out", "a.png"), "--out: needs --over"),
        ((*ROD, "--points", "5"), "--points: needs --over"),
        ((*ROD, "--gradient", "gamma"), "unknown quantity 'gamma'"),
        ((*ROD, "--over", "E"), "need one quantity with its ends"),
        ((*ROD, "--over", "E=1"), "need FROM:TO"),
        ((*ROD, "--over", "E=2e14:1e14"), "need from < to"),
        ((*ROD, "--over", "gap=0:1"), "unknown quantity 'gap'"),
        ((*ROD, "--over", "E=1e14:1e15", "--points", "1"), "need 2 to 400"),
        ((*ROD, "--over", "E=1e14:1e15", "--forces=-1:5"), "need >= 0"),
        ((*ROD, "--over", "E=1e14:1e15,mu=1:2"), "need one quantity with its ends"),
        ((*ROD, "--over", "E=1e14:1e15", "--gradient", "mu"), "goes without --over"),
        ((*ROD, "--over", "theta=0.2:0.4", "--points", "3"), "need A < 0 and B > 0"),
    ],
)
def test_critical_refuses(capsys, words, message):
    err = rejected(capsys, *words)
    assert any(part in err for part in message.split("|")), err
