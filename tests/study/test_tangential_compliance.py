"""Study of the tangential spring: closed forms, limits, and the numbers of its page."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.study.study_scripts import study_script

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "tangential-compliance.md").read_text("utf-8")
DATA = json.loads((ROOT / "docs" / "figures" / "tangential-compliance.json").read_text("utf-8"))

study = study_script("tangential_compliance.py")


@settings(max_examples=20)
@given(mu=st.floats(1.4, 3.0), log_ratio=st.floats(-3.0, 3.0))
def test_growing_slip_stops_where_the_closed_form_says(mu, log_ratio):
    ratio, W = 10**log_ratio, study.mobility()
    A, C = W[0, 0] + mu * W[0, 1], W[0, 1] + mu * W[1, 1]
    closed = -1 / (1 + ratio * abs(C) / (mu * abs(A)))
    assert study.impact(mu, ratio)["slip_velocity_at_stop"] == pytest.approx(closed, rel=1e-6)


@settings(max_examples=10)
@given(mu=st.floats(1.4, 3.0), log_ratio=st.floats(-4.0, 3.0))
def test_impact_without_collision_happens_for_every_spring_and_creates_no_energy(mu, log_ratio):
    impact = study.impact(mu, 10**log_ratio)
    assert impact["normal_velocity"] > 0
    assert 0 < impact["energy_kept"] < 1


def test_soft_spring_sends_the_contact_back():
    impact = study.impact(1.4, 1e-6)
    assert impact["tangential_velocity"] == pytest.approx(1.0, abs=1e-4)
    assert impact["normal_velocity"] == pytest.approx(0.0, abs=1e-5)


def test_least_approach_does_not_depend_on_the_spring_and_the_largest_does():
    # With k finite the rod moves while it slides: B/sqrt(|A| k) is the limit.
    critical = study.border(math.inf, 1e-5, 1e-3)
    W = study.mobility()
    A = W[0, 0] + 1.4 * W[0, 1]
    B = 25 * math.sin(1.0) - 9.8
    assert critical == pytest.approx(B / math.sqrt(-A * study.STIFF), rel=2e-3)
    assert study.border(1e-3, 0.9 * critical, 1.1 * critical) == pytest.approx(critical, rel=1e-8)
    assert not study.impacts(6e-5, 1.5 * critical)
    assert study.impacts(1e-3, 20 * critical) and not study.impacts(1e-3, 40 * critical)


def _row(rows, ratio):
    return next(r for r in rows if r["ratio"] == pytest.approx(ratio, rel=1e-3))


def test_page_states_the_numbers_of_the_study():
    lines = [line for line in PAGE.splitlines() if line.startswith("| ")]
    for ratio, label in (
        (1e-4, "1e-4"),
        (0.01, "0.01"),
        (0.1, "0.1"),
        (0.8235, "0.8235"),
        (10, "10"),
    ):
        (line,) = [s for s in lines if s.startswith(f"| {label} ") and s.count("|") == 8]
        for mu in ("1.4", "2.0"):
            own = _row([r for r in DATA["impact"][mu] if r["ratio"] is not None], ratio)
            assert f"{own['normal_velocity']:.6f}" in line
            assert f"{abs(own['tangential_velocity']):.6f}" in line
            assert f"{own['energy_kept']:.4f}" in line
    for ratio, label in ((0.01, "0.01"), (0.8235, "0.8235"), (10, "10")):
        (line,) = [s for s in lines if s.startswith(f"| {label} ") and s.count("|") == 6]
        own = _row([r for r in DATA["table_3"] if r["ratio"] is not None], ratio)
        assert f"{own['y_A_dot']:.6f}" in line and f"{own['x_A_dot']:.6f}" in line
        assert f"{own['slip_stop'] * 1e3:.4f}" in line and f"{own['largest_force']:.1f}" in line


def test_kept_numbers_are_computed_again():
    for mu in (1.4, 2.0):
        kept = _row([r for r in DATA["impact"][str(mu)] if r["ratio"] is not None], study.STEEL)
        assert study.impact(mu, study.STEEL) == pytest.approx(kept, rel=1e-9)
    kept = _row([r for r in DATA["table_3"] if r["ratio"] is not None], study.STEEL)
    assert study.table_3(study.STEEL) == pytest.approx(kept, rel=1e-9)
    rigid = DATA["table_3"][-1]
    assert kept["y_A_dot"] / rigid["y_A_dot"] == pytest.approx(1.43, abs=0.005)
