"""The command map: its output, files and errors."""

from __future__ import annotations

import json
import math
import os

import numpy as np
import pytest

from painleve_sym.cli import map as map_command
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.present.figure_of_map import map_figure
from painleve_sym.present.style import write_figure
from painleve_sym.study.maps.region_map import RegionMap, region_map
from tests.cli.cli_helpers import rejected, run, run_json

ROD = ("map", "rod", "--over", "theta,theta_dot", "--range", "theta=0.1:1.5,theta_dot=-5:5")
SMALL = ("--points", "40")


def test_map_json_holds_axes_counts_crossings_and_thresholds(capsys):
    data = run_json(capsys, *ROD, *SMALL, "--set", "mu=1.5")
    assert data["mechanism"] == "rod" and data["slip"] == -1
    first = {"name": "theta", "unit": "rad", "from": 0.1, "to": 1.5, "points": 40}
    assert data["axes"][0] == first
    assert sum(data["counts"].values()) == 1600
    root = math.sqrt(9 * 1.5**2 - 16)
    theta = math.atan((3 * 1.5 - root) / 2)
    nearest = data["crossings"][1]
    assert nearest["theta"] == pytest.approx(theta, abs=1e-12)
    assert nearest["theta_dot"] == pytest.approx(math.sqrt(9.8 / math.sin(theta)), abs=1e-12)
    assert data["thresholds"]["mu_P"] == pytest.approx(4 / 3)
    assert data["thresholds"]["least_over_normals"] == pytest.approx(4 / 3)
    assert data["parameters"]["mu"] == 1.5


def test_map_text_names_cases_and_crossings(capsys):
    code, out, err = run(capsys, *ROD, *SMALL)
    assert (code, err) == (0, "")
    assert "inconsistent" in out and "0.970155415988" in out
    assert "mu_C = 2/sqrt(3) mu_P = 1.53960072" in out
    assert "outside" not in out
    assert all(len(line) <= 80 for line in out.splitlines())


def test_map_over_a_parameter_with_the_other_slip(capsys):
    options = ("--slip", "1", "--state", "theta_dot=3.4", *SMALL)
    data = run_json(capsys, "map", "rod", "--over", "theta,mu", *options)
    theta = math.pi - math.asin(9.8 / 3.4**2)
    assert [c["theta"] for c in data["crossings"]] == pytest.approx([theta], abs=1e-12)
    assert data["state"]["theta_dot"] == 3.4


@pytest.mark.slow
def test_map_writes_every_kind_of_file(capsys, tmp_path):
    names = ("a.png", "a.svg", "a.pdf", "a.npz", "a.json")
    outs = [word for name in names for word in ("--out", str(tmp_path / name))]
    data = run_json(capsys, *ROD, *SMALL, *outs)
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(names)
    assert [os.path.basename(f) for f in data["files"]] == list(names)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    whole = json.loads((tmp_path / "a.json").read_text("ascii"))
    back = RegionMap.load(tmp_path / "a.npz")
    np.testing.assert_array_equal(whole["case"], back.case)
    assert whole["flow"][0][20][39] is None
    write_figure(map_figure(back), tmp_path / "b.png")
    assert (tmp_path / "b.png").read_bytes() == (tmp_path / "a.png").read_bytes()


def test_map_figure_of_parameters_marks_the_thresholds(capsys, tmp_path):
    path = tmp_path / "a.npz"
    over = ("--over", "mu,theta", "--range", "theta=-0.5:1.5")
    run(capsys, "map", "rod", *over, "--state", "theta_dot=3.4", *SMALL, "--out", path)
    texts = {t.get_text() for t in map_figure(RegionMap.load(path)).axes[0].texts}
    assert {r"$\mu_P$", r"$\mu_C$", "$A = 0$", "$B = 0$"} <= texts
    assert not any("normals" in text for text in texts)


@pytest.mark.parametrize(
    "over",
    [
        *("theta,theta_dot", "x_A,y_A"),
        *(pytest.param(over, marks=pytest.mark.slow) for over in ("x_A,y_A_dot", "g,l")),
    ],
)
@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
def test_map_figure_of_few_points_is_drawn(over, tmp_path):
    state = {} if "theta" in over else {"theta": 1.0}
    regions = region_map(model("rod"), over.split(","), points=5, state=state)
    write_figure(map_figure(regions), tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 5000


BAD = [
    (("map",), "MODEL"),
    (("map", "rod"), "--over"),
    (("map", "rdo", "--over", "theta,mu"), "Did you mean 'rod'?"),
    (("map", "rod", "--over", "theta,theta_dt"), "Did you mean 'theta_dot'?"),
    (("map", "rod", "--over", "theta"), "two different names"),
    (("map", "rod", "--over", "theta,theta"), "two different names"),
    (("map", "rod", "--over", "theta,mu", "--range", "theta=1"), "need FROM:TO"),
    (("map", "rod", "--over", "theta,mu", "--range", "theta=:1"), "need FROM:TO"),
    (("map", "rod", "--over", "theta,mu", "--range", "theta=nan:1"), "finite"),
    (("map", "rod", "--over", "theta,mu", "--range", "theta=2:1"), "Fix: give 1:2"),
    (("map", "rod", "--over", "theta,mu", "--range", "thta=0:1"), "Did you mean 'theta'?"),
    (("map", "rod", "--over", "theta,mu", "--range", "mu=-1:1"), "mu"),
    ((*ROD, "--points", "3"), "5 to 2000"),
    ((*ROD, "--points", "1e6"), "5 to 2000"),
    ((*ROD, "--points", "40.5"), "whole number"),
    ((*ROD, "--slip", "0"), "-1 or 1"),
    ((*ROD, "--set", "mass=1"), "unknown parameter 'mass'"),
    ((*ROD, "--state", "theta=1"), "is an axis"),
    ((*ROD, "--out", "a.gif"), ".json"),
    ((*ROD, "--out", "no/such/folder/a.png"), "no such folder"),
    (("map", "rod", "--over", "theta_dot,mu", "--state", "x_A_dot=-1"), "inside the domain"),
]


@pytest.mark.parametrize(("arguments", "words"), BAD)
def test_map_bad_input_is_one_sentence_and_writes_nothing(
    capsys, tmp_path, monkeypatch, arguments, words
):
    monkeypatch.chdir(tmp_path)
    err = rejected(capsys, *arguments)
    assert words in err and list(tmp_path.iterdir()) == []


def test_map_checks_its_output_before_it_computes(capsys, tmp_path, monkeypatch):
    def forbidden(*_arguments, **_options):
        raise AssertionError("computed")

    monkeypatch.setattr("painleve_sym.cli.map.region_map", forbidden)
    assert "is a folder" in rejected(capsys, *ROD, "--out", tmp_path)


@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
def test_zeros_that_A_and_B_share_are_said_once(capsys):
    place = ("map", "strut", "--over", "theta,mu", "--range", "theta=0.1:3.04,mu=0:2")
    _, out, _ = run(capsys, *place, "--points", "101")
    zeros = out.split("A and B vanish")[1].splitlines()
    assert zeros[0] == " together along theta = pi/2"
    assert zeros[1] == "A = 0 and B = 0 cross at" and len(zeros) == 5
    assert zeros[4] == "least mu_P of all normals of the surface: 0"
    data = json.loads(run(capsys, *place, "--points", "101", "--json")[1])
    assert data["shared_zeros"] == [{"theta": pytest.approx(math.pi / 2)}]
    assert len(data["crossings"]) == 1


def test_of_many_crossings_some_are_printed(capsys, monkeypatch):
    monkeypatch.setattr(map_command, "SHOWN_CROSSINGS", 1)
    _, out, _ = run(capsys, *ROD, *SMALL)
    assert out.count("0.970155415988") == 1 and "and at 3 more, which --json lists" in out


def test_the_title_says_what_closes_the_contact():
    regions = region_map("pr-robot", ("h", "tau"), points=10, close="theta,theta_dot")
    title = map_figure(regions).axes[0].get_title(loc="left")
    assert title.endswith(r"$\theta$ and $\dot{\theta}$ close the contact")
    assert "0.927" not in title and "theta =" not in title
    held = region_map("rod", ("theta", "mu"), points=10, state={"theta_dot": 3.4})
    held_title = map_figure(held).axes[0].get_title(loc="left")
    assert held_title == r"rod, $v_t < 0$, $\dot{\theta} = 3.4$ rad/s"


def test_ranges_may_have_units(capsys):
    data = run_json(capsys, *ROD[:4], *SMALL, "--range", "theta=45deg:90deg,theta_dot=-60rpm:2")
    ends = [axis[key] for axis in data["axes"] for key in ("from", "to")]
    assert ends == pytest.approx([math.pi / 4, math.pi / 2, -2 * math.pi, 2.0], rel=1e-14)
