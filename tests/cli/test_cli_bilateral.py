"""The commands with a contact that is held from both sides."""

from __future__ import annotations

import math

import pytest

from tests.cli.cli_helpers import ROOT, rejected, run, run_json

BEAD = ROOT / "examples" / "mechanisms" / "bead-in-groove.toml"
RIGHT, LEFT = "phi=1.2,x_dot=1", "phi=1.2,x_dot=-1"


def test_derive_prints_both_forces_and_the_condition(capsys):
    data = run_json(capsys, "derive", "painleve-klein")["formulas"]
    values = {"math": math, "m_1": 1.0, "m_2": 1.0, "phi": 1.2, "mu": 0.9, "v_t": -1.0}
    number = lambda name: eval(data[name]["python"], values)  # noqa: E731
    assert number("excess") == pytest.approx(0.03655266678370017, rel=1e-12)
    assert number("mu_critical") == pytest.approx(2 / math.tan(1.2), rel=1e-12)
    # By hand: both blocks stop, and the rod turns the impulse of the upper one.
    assert number("P_t") == pytest.approx(2.0, rel=1e-12)
    assert number("P_n") == pytest.approx(math.tan(1.2), rel=1e-12)
    assert {"F_n_neg_push", "F_n_neg_pull", "F_n_pos_push", "F_n_pos_pull"} <= set(data)
    assert not any(name.startswith("rebound") for name in data)


def test_classify_shows_two_solutions_and_none(capsys):
    code, out, err = run(capsys, "classify", "painleve-klein", "--state", RIGHT)
    assert (code, err) == (0, "")
    assert "case: indeterminate" in out and "slip_pos/pull_unstable" in out
    assert all(len(line) <= 80 for line in out.splitlines())
    code, out, _ = run(capsys, "classify", "painleve-klein", "--state", LEFT)
    assert code == 0 and "case: inconsistent" in out and "command jump" in out


def test_jump_gives_the_tangential_impact(capsys):
    data = run_json(capsys, "jump", "painleve-klein", "--state", LEFT)
    assert data["final"]["velocity"] == {"x_dot": 0.0, "phi_dot": 0.0}
    assert data["energy_change"] == pytest.approx(-1.0, rel=1e-12)
    code, out, _ = run(capsys, "jump", "painleve-klein", "--state", LEFT)
    assert code == 0 and "2.57215" in out


def test_simulate_tells_events_and_keeps_the_energy(capsys):
    given = ("--state", LEFT, "--law", "rigid", "--t-end", "0.1")
    data = run_json(capsys, "simulate", "painleve-klein", *given)
    kinds = [e["kind"] for e in data["events"]]
    assert kinds == ["contact", "tangential_impact", "contact"]
    assert data["energy_residual"] < 1e-9
    assert data["choices"] == {"policy": "liftoff"}
    code, out, _ = run(capsys, "simulate", "painleve-klein", *given)
    assert code == 0 and "law rigid (policy liftoff)\n" in out


@pytest.mark.slow
def test_map_names_the_number_of_solutions(capsys, tmp_path):
    picture = tmp_path / "bead.png"
    given = ("--over", "phi,phi_dot", "--set", "mu=1.5", "--points", "60", "--out", picture)
    code, out, err = run(capsys, "map", BEAD, *given)
    assert (code, err) == (0, "")
    assert "indeterminate" in out and "lift" not in out
    assert picture.stat().st_size > 10_000


@pytest.mark.parametrize(
    "command, words",
    [
        (("simulate", "--law", "hertz", "--t-end", "1"), "use the law rigid"),
        (("simulate", "--law", "rigid", "--law-set", "e_energetic=0.3", "--t-end", "1"), "e_energ"),
        (("contrast",), "bilateral"),
        (("jump", "--restitution", "0.5"), "does not separate"),
        (("jump", "--set", "mu=0.3"), "finite forces"),
    ],
)
def test_what_does_not_apply_is_refused_in_one_line(capsys, command, words):
    name, *rest = command
    assert words in rejected(capsys, name, "painleve-klein", "--state", RIGHT, *rest)
