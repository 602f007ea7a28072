"""Proofs for contacts of robots over boxes of poses: against other formulas, forged, refuted."""

from __future__ import annotations

import copy
import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.certify.checker import Rejected, check, digest
from painleve_sym.problem.risk import friction_threshold
from tests.cli.cli_helpers import rejected, run, run_json

ROOT = Path(__file__).parents[2]
FILES = ROOT / "tests" / "robots" / "files"
DOG = str(ROOT / "examples" / "robots" / "quadruped.urdf")
ARM = str(FILES / "two_link.urdf")
LEG = {"LF_HAA": (-0.15, -0.05), "LF_HFE": (0.65, 0.75), "LF_KFE": (-1.45, -1.35)}
OVER = ",".join(f"{name}={low}:{high}" for name, (low, high) in LEG.items())
COMMAND = ("robot", DOG, "--contact", "LF_foot", "--pose", "standing", "--certify")


def proof(contact, over, mu=None, **options):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    from painleve_sym.certify.proof import prove_positive

    function, conditions, _ = contact.positive_function(over, mu)
    return prove_positive(function, conditions, over, "test", **options)


def grid(over, points):
    """Return values of each quantity at the nodes of a grid on a box."""
    sides = [np.linspace(low, high, points) for low, high in over.values()]
    return dict(zip(over, (a.ravel() for a in np.meshgrid(*sides)), strict=True))


@pytest.fixture(scope="module")
def foot():
    return ps.robot(DOG).contact("LF_foot", pose="standing")


@pytest.fixture(scope="module")
def certificate(foot):
    return proof(foot, LEG, 1.4).certificate


def test_arm_is_proved_below_the_threshold_of_its_formula():
    over = {"theta_1": (-0.9, -0.3), "theta_2": (-1.6, -1.0)}
    tip = ps.robot(ARM).contact("tip")
    # Two uniform rods of mass and length 1 at the angles a and b from +x.
    poses = grid(over, 41)
    a, b = poses["theta_1"], poses["theta_1"] + poses["theta_2"]
    M = np.array([[4 / 3 + 0 * a, np.cos(a - b) / 2], [np.cos(a - b) / 2, 1 / 3 + 0 * a]])
    J = np.array([[np.cos(a), np.cos(b)], [-np.sin(a), -np.sin(b)]])
    M, J = np.moveaxis(M, 2, 0), np.moveaxis(J, 2, 0)
    W = J @ np.linalg.solve(M, np.swapaxes(J, 1, 2))
    least = float(np.min(W[:, 0, 0] / np.abs(W[:, 1, 0])))
    below = proof(tip, over, 0.98 * least)
    assert below.verdict == "proved"
    assert check(below.certificate) == below.pieces
    assert proof(tip, over, 1.02 * least).verdict == "refuted"


def test_floating_leg_is_proved_below_the_least_threshold_of_a_grid(foot):
    thresholds = foot.thresholds(grid(LEG, 15))
    least = float(thresholds.min())
    below = proof(foot, LEG, 0.9 * least)
    assert below.verdict == "proved" and check(below.certificate) == below.pieces
    above = proof(foot, LEG, 1.1 * least)
    assert above.verdict == "refuted"
    middle = {name: (low + high) / 2 for name, (low, high) in above.piece.items()}
    there = replace(foot, values={**foot.values, **middle})
    assert float(friction_threshold(there.mobility())) < 1.1 * least


def test_few_pieces_suffice(certificate):
    # Intervals with derivatives need more than a thousand for a box of a fifth of this width.
    assert check(certificate) <= 4


@pytest.mark.slow
def test_piece_that_only_balls_prove_is_halved(foot):
    # The checker has no positive bound of half of what balls prove on one of its pieces.
    leg = {name: (foot.values[name] - 0.2, foot.values[name] + 0.2) for name in LEG}
    wide = proof(foot, leg, 0.8)
    assert wide.verdict == "proved" and check(wide.certificate) == wide.pieces


def test_friction_and_tilt_of_the_base_may_vary(foot):
    tilted = {"base_roll": (-0.1, 0.1), "base_pitch": (-0.1, 0.1)}
    assert proof(foot, tilted, 1.0).verdict == "proved"
    # W has no gimbal lock, although the velocities of these angles have one.
    assert proof(foot, {"base_pitch": (1.55, 1.59)}, 0.1).verdict == "proved"
    worst = float(friction_threshold(foot.mobility()))
    assert proof(foot, {"mu": (0.0, 0.999 * worst)}).verdict == "proved"
    assert proof(foot, {"mu": (0.5, 1.01 * worst)}).verdict == "refuted"


def test_function_is_positive_where_friction_is_below_the_threshold(foot):
    random = np.random.default_rng(3)
    stuck = ps.robot(DOG).contact("LF_foot,RH_foot", pose="standing", others="stuck")
    over = {"LF_HAA": (-0.3, 0.3), "LF_KFE": (-1.9, -0.4), "mu": (0.2, 3.0)}
    for contact in (foot, stuck):
        function, conditions, fixed = contact.positive_function(over)
        assert fixed["LF_HFE"] == 0.7 and not set(fixed) & set(over)
        for _ in range(20):
            haa, kfe, mu = (random.uniform(*ends) for ends in over.values())
            W = replace(contact, values={**contact.values, "LF_HAA": haa, "LF_KFE": kfe}).mobility()
            value = W[0, 0] ** 2 - mu**2 * (W[1, 0] ** 2 + W[2, 0] ** 2)
            *pivots, last = np.array(function([haa, kfe, mu])).ravel()
            assert last == pytest.approx(value, rel=1e-9) and min(pivots) > 0
            assert len(conditions) == len(pivots) + 1 == 19
            assert (value > 0) == (mu < friction_threshold(W))


def test_box_that_takes_too_long_stays_undecided(foot):
    wide = {name: (joint.lower, joint.upper) for name, joint in list(foot.joints.items())[:3]}
    for limit in ({"max_pieces": 3}, {"max_seconds": 0.2}):
        late = proof(foot, wide, 0.3, **limit)
        assert late.verdict == "undecided" and late.certificate is None
        for name, (low, high) in late.piece.items():
            assert wide[name][0] <= low < high <= wide[name][1]


CHANGES = {
    "wider": lambda c: c["over"][2].__setitem__(2, -0.9),
    "bound": lambda c: c["tree"][-1].__setitem__(-1, (50.0).hex()),
    "bound of the mass matrix": lambda c: c["tree"][-1].__setitem__(0, (50.0).hex()),
    "piece": lambda c: c["tree"].pop(),
}


@pytest.mark.parametrize("name", CHANGES)
def test_forged_certificate_is_rejected(certificate, name):
    forged = copy.deepcopy(certificate)
    CHANGES[name](forged)
    with pytest.raises(Rejected, match="hash"):
        check(forged)
    with pytest.raises(Rejected):
        check(forged | {"sha256": digest(forged)})


@pytest.mark.slow
def test_command_proves_and_verifies_without_flint(capsys, tmp_path, monkeypatch):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    file = tmp_path / "dog.json"
    proved = (*COMMAND, "--over", OVER, "--mu", "1.4")
    data = run_json(capsys, *proved, "--out", str(file))
    assert (data["robot"], data["contact"]) == ("quadruped", "LF_foot")
    assert data["verdict"] == "proved" and data["piece"] is None
    assert any("rigid" in notice for notice in data["notices"])
    code, out, _ = run(capsys, *COMMAND, "--over", OVER, "--mu", "1.7")
    assert code == 1 and "refuted: need A > 0 for every direction" in " ".join(out.split())
    monkeypatch.setitem(sys.modules, "flint", None)
    checked = run_json(capsys, *proved, "--check", str(file))
    assert (checked["verdict"], checked["pieces"]) == ("verified", data["pieces"])
    code, out, _ = run(capsys, *COMMAND, "--over", OVER, "--mu", "1.3", "--check", str(file))
    assert code == 1 and out.startswith("rejected: its claim is not")
    content = json.loads(file.read_text())
    content["tree"][-1][-1] = (9.0).hex()
    content |= {"sha256": digest(content)}
    file.write_text(json.dumps(content))
    code, out, _ = run(capsys, *proved, "--check", str(file))
    assert code == 1 and out.startswith("rejected: a bound is not confirmed")
    # A certificate of another formula, however valid by itself.
    del content["program"][100]
    file.write_text(json.dumps(content | {"sha256": digest(content)}))
    code, out, _ = run(capsys, *proved, "--check", str(file))
    assert code == 1 and out.startswith("rejected: its program is not")
    monkeypatch.delitem(sys.modules, "painleve_sym.certify.ball_polynomials", raising=False)
    assert "needs python-flint" in rejected(capsys, *proved)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--mu", "1"), "--certify: needs --over"),
        (("--over", OVER), "got no friction coefficient"),
        (("--over", "mu=0:1", "--mu", "1"), "got mu both varied and set"),
        (("--over", "LF_KFEE=0:1", "--mu", "1"), "Did you mean 'LF_KFE'?"),
        (("--over", "LF_KFE=-1:-2", "--mu", "1"), "need ends that grow"),
        (("--over", "LF_KFE=-1:3", "--mu", "1"), "need a range within its limits -2.4 and 2.4"),
        (("--over", "base_x=0:1", "--mu", "1"), "unknown quantity 'base_x'"),
        (("--over", "mu=-1:1"), "need a range within its limits 0 and inf"),
        (("--over", OVER, "--mu", "1", "--joints", "LF_HAA=0"), "got LF_HAA in --joints as well"),
        (("--over", OVER, "--mu", "1", "--poses", "3"), "--poses: --certify only gives a proof"),
        (("--over", OVER, "--mu", "1", "--out", "a.svg"), "need one of .json"),
        (("--over", OVER, "--mu", "1", "--check", "absent.json"), "No such file"),
    ],
)
def test_bad_input_is_one_sentence(capsys, arguments, expected):
    err = rejected(capsys, *COMMAND, *arguments)
    assert expected in " ".join(err.split())


def test_options_of_a_proof_need_a_proof(capsys):
    for option in (("--over", OVER), ("--check", "a.json")):
        assert "belongs to --certify" in rejected(capsys, *COMMAND[:-1], *option)
