"""The formulas and numbers of docs/paradox-in-space.md."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from tests.site_pages import Page
from tests.study.study_scripts import study_script

ROOT = Path(__file__).parents[2]


def test_command_of_the_page_prints_what_it_shows(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = Page(ROOT / "docs" / "paradox-in-space.md", tmp_path)
    page.run()
    assert page.commands > 1


def test_numbers_of_the_page_are_those_of_the_study():
    text = (ROOT / "docs" / "paradox-in-space.md").read_text("utf-8")
    kept = ROOT / "examples" / "studies" / "paradox_in_space" / "paradox-in-space.json"
    data = json.loads(kept.read_text("utf-8"))
    for theta, rate in data["turning"]["crossings"]:
        assert f"({theta:.6f}, {rate:.6f})" in text
    # The command of the page makes the map of the study.
    line = re.search(r"painleve map rod-3d --over theta,psi_dot (.*) --points (\d+) --out", text)
    options = line[1].split()
    given = dict(zip(options[::2], options[1::2], strict=True))
    assert int(line[2]) == data["computed"]["points"]
    study = study_script("paradox_in_space/paradox_in_space.py")
    parameters, state = (
        {k: float(v) for k, v in (pair.split("=") for pair in given[name].split(","))}
        for name in ("--set", "--state")
    )
    assert parameters == {"mu": 1.6, "J_3": 1e-9}
    assert state == {"theta_dot": study.RATE, "x_A_dot": -1.0}
    low, high = study.ELEVATION
    assert given["--range"] == f"theta={low:.6f}:{high:.6f},psi_dot=0:12"
    again = study.turning(40)["crossings"]
    assert again == pytest.approx(np.array(data["turning"]["crossings"]), abs=1e-9)
    counts = {n: f"{count:,}".replace(",", " ") for n, count in data["at_rest"].items()}
    assert set(counts) == {"1", "3"}
    assert f"{counts['1']} have one solution and {counts['3']} have three" in text
    assert max(row["error"] for row in data["sectors"]) < 2e-15
    widest = {row["mu"]: max(abs(p[1] - 3.141592653589793) for e in row["pieces"] for p in e)
              for row in data["sectors"]}  # fmt: skip
    shown = re.search(r"± ([\d.]+)° at μ = 1\.4, ± ([\d.]+)° at\s+μ = 2", text).groups()
    assert [f"{widest[mu] * 57.29577951308232:.1f}" for mu in (1.4, 2.0)] == list(shown)


def test_third_derivative_of_the_proof():
    s, p1, p2, c1, c2 = sp.symbols("s p_1 p_2 c_1 c_2", positive=True)
    q = sp.expand(c1**2 * (p2 + s) ** 2 + c2**2 * (p1 + s) ** 2)
    alpha, beta, gamma = q.coeff(s, 2), q.coeff(s, 1) / 2, q.coeff(s, 0)
    assert sp.expand(alpha * gamma - beta**2 - c1**2 * c2**2 * (p1 - p2) ** 2) == 0
    third = sp.diff(s * sp.sqrt(q), s, 3) * q ** sp.Rational(5, 2)
    assert sp.simplify(third - 3 * (alpha * gamma - beta**2) * (beta * s + gamma)) == 0
