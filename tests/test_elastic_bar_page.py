"""The manuscript on the elastic bar: its tables and numbers, and those of another code."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.benchmarks import elastic_bar_page as page
from tools.tables import written

DATA = json.loads(page.RESULTS.read_text("utf-8"))
ROWS = {row["theta"]: row for row in DATA["angles"]}


def test_tables_and_numbers_of_the_manuscript_are_the_kept_ones():
    text = page.PAGE.read_text("utf-8")
    assert written(text, page.tables(DATA)) == text, "Fix: run make paper."
    first, last = ((ROWS[x]["landing 48,24"], ROWS[x]["landing of the rigid rod"])
                   for x in (1.0, 1.4))  # fmt: skip
    words = " ".join(text.split())
    assert "μ = {:.3f} where a rigid rod needs {:.3f}".format(*first) in words
    assert "at 1.4 rad {:.3f} instead of {:.3f}".format(*last) in words
    ball = next(r["ball 48,24"] for r in DATA["round ends"] if r["theta"] == 1.0)
    assert f"it needs {ball:.3f} in place of {first[0]:.3f}" in words
    (leaning,) = (r for r in DATA["belt"] if r["theta"] == 1.2)
    assert leaning["heavy tip 48,24"] > 4 / 3 * leaning["hard tip 48,24"]
    assert "raises the landing by more than a third" in words
    # The words on fast slip.
    excess = {r["modes"]: r["landing"][-1] - r["divergence"] for r in DATA["fast"]
              if r["factor"] == 1 and r["theta"] == 1}  # fmt: skip
    assert f"{excess.pop('8,4'):.4f}".replace("-", "−") + " with 8,4 modes" in words
    assert {f"{x:.4f}" for x in excess.values()} == {"0.0007"}
    assert "0.0007 from 24,12 on" in words
    (soft,) = (r for r in DATA["fast"] if r["factor"] == 0.01)
    assert soft["landing"][-1] / soft["divergence"] - 1 == pytest.approx(0.05, abs=0.005)


def test_order_of_the_thresholds_of_this_bar_and_the_speed_of_slip():
    for row in DATA["angles"]:
        names = ("cot", "coupling", "landing 48,24", "divergence", "landing of the rigid rod")
        values = [row[name] for name in (*names, "rigid rod")]
        assert values == sorted(values) and row["divergence"] < row["divergence at 9.8 N"]
    for theta in (1.0, 1.2, 1.4):
        rows = [r for r in DATA["speeds"] if r["theta"] == theta]
        landed = np.array([r["landing"] for r in rows])
        assert np.all(np.diff(landed) > 0)
        (fast,) = (r for r in rows if r["speed"] == 100)
        assert abs(fast["landing"] / fast["divergence"] - 1) < 0.0051


def test_kept_thresholds_are_those_of_a_code_of_another_author():
    """Modes and eigenvalues, and a motion in C, that share nothing with the study."""
    first, last = ROWS[1.0], ROWS[1.4]
    assert first["landing 48,24"] == pytest.approx(0.7051, abs=2e-4)
    assert first["rigid rod, 6 ms"] == pytest.approx(1.264, abs=5e-4)
    assert (first["divergence"], last["divergence"]) == pytest.approx((0.7127, 0.3640), abs=1e-4)
    at_weight = (first["divergence at 9.8 N"], last["divergence at 9.8 N"])
    assert at_weight == pytest.approx((0.7291, 0.4086), abs=1e-4)
    others = {1.0: 0.7053, 3.0: 0.7090, 10.0: 0.7112, 30.0: 0.7123, 100.0: 0.7129}
    rows = {r["speed"]: r["landing"] for r in DATA["speeds"] if r["theta"] == 1.0}
    assert {v: rows[v] for v in others} == pytest.approx(others, abs=2e-4)


@given(st.floats(0.3, 1.5), st.floats(0.1, 1e3), st.floats(0.01, 0.9), st.floats(0.01, 10))
def test_theorem_on_rigidity_has_no_angle(theta, across, share, compliance):
    """1/k + c²G_b + s²G_a < μ_r s c (G_b - G_a) is 3/k < G_b - 4 G_a."""
    along = across * share
    c, s = math.cos(theta), math.sin(theta)
    rigid = (4 * c * c + s * s) / (3 * s * c)
    left = compliance + c * c * across + s * s * along - rigid * s * c * (across - along)
    assert 3 * left == pytest.approx(3 * compliance - (across - 4 * along), abs=1e-9 * across)
