"""A convex step of a sliding contact: its closed form, kept steps of two programs, MuJoCo again."""

from __future__ import annotations

import importlib
import json
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls

import painleve_sym as ps
from derivations.generated import cone_dual_step as formulas
from tests.benchmarks import contact_solvers_page as page
from tools.tables import written

FOLDER = page.RESULTS.parent
DATA = json.loads(page.RESULTS.read_text("utf-8"))


@st.composite
def contacts(draw):
    """A definite mobility, friction, and a slip to the left."""
    w_nn, w_tt, mu, speed = (draw(st.floats(0.1, 10)) for _ in range(4))
    share = draw(st.floats(-0.99, 0.99))
    w_nt = share * math.sqrt(w_nn * w_tt)
    return np.array([[w_nn, w_nt], [w_nt, w_tt]]), mu, speed


def convex_minimum(W, mu, velocity):
    """Return the minimum over the cone by SciPy, with its two edges as coordinates."""
    edges = np.array([[1.0, 1.0], [mu, -mu]])
    root = np.linalg.cholesky(W)
    shares, _ = nnls(root.T @ edges, -np.linalg.solve(root, velocity))
    return edges @ shares


@given(contacts())
def test_closed_form_is_the_minimum_over_the_cone(contact):
    W, mu, speed = contact
    velocity = np.array([0.0, -speed])
    impulse, after = page.cone_dual_step(W, mu, velocity)
    other = convex_minimum(W, mu, velocity)
    gain = other - impulse
    assert gain @ W @ gain <= 1e-8 * (impulse @ W @ impulse)
    assert abs(impulse[1]) <= mu * impulse[0] * (1 + 1e-9)
    assert after[0] >= mu * abs(after[1]) - 1e-9 * speed
    assert abs(impulse @ after) <= 1e-9 * impulse[0] * speed


@given(contacts())
def test_the_sign_of_A_decides_between_throwing_and_stopping(contact):
    W, mu, speed = contact
    values = {"mu": mu, "W_nn": W[0, 0], "W_nt": W[0, 1], "W_tt": W[1, 1]}
    impulse, after = page.cone_dual_step(W, mu, np.array([0.0, -speed]))
    A = page.sliding_coefficient(W, mu)
    if abs(A) < 1e-9:
        return
    if A < 0:
        assert np.allclose(after, 0)
        stick = formulas.P_stick(**{k: values[k] for k in values if k != "mu"}, v_t=-speed)
        assert impulse[0] == pytest.approx(stick, rel=1e-9)
        return
    edge = formulas.P(**values, v_n=0.0, v_t=-speed)
    assert impulse[0] == pytest.approx(edge, rel=1e-9)
    assert edge == pytest.approx(mu * speed / formulas.D(**values), rel=1e-12)
    assert after[0] == pytest.approx(A * edge, rel=1e-6, abs=1e-9 * speed)
    energy = formulas.Delta_T(**values, v_n=0.0, v_t=-speed)
    change = impulse @ (np.array([0.0, -speed]) + after) / 2
    assert energy < 0 and change == pytest.approx(energy, rel=1e-6)


def test_where_A_is_negative_the_step_is_the_plastic_impact_of_the_package():
    W, mu = page.mobility(1.0), 1.4
    impact = ps.solve_impact(W, mu, [0.0, -1.0], "energetic", 0.0)
    impulse, after = page.cone_dual_step(W, mu, np.array([0.0, -1.0]))
    assert np.asarray(impact.velocity) == pytest.approx(after, abs=1e-12)
    assert impact.normal_impulse == pytest.approx(impulse[0], rel=1e-9)
    # Where A is positive the package slides, and the convex step does not.
    regular = ps.ContactProblem(page.mobility(0.5), [-9.3, 0.9], [mu], slip_velocity=[-1.0])
    assert len(regular.solutions()) == 1
    assert page.cone_dual_step(page.mobility(0.5), mu, np.array([0.0, -1.0]))[1][0] > 0.69


def test_tables_of_page_and_manuscript_are_the_kept_steps():
    for path in page.PAGES:
        text = path.read_text("utf-8")
        assert written(text, page.tables(DATA)) == text, "Fix: run make paper."


def test_kept_steps_agree_with_the_closed_form():
    for row in DATA["rows"]:
        impulse, normal = page.predicted(row["program"], row["theta"], row["mu"], DATA["step"])
        assert row["impulse"] == pytest.approx(impulse, rel=1e-3), row
        assert row["normal"] == pytest.approx(normal, abs=5e-4), row
    both = {(row["theta"], row["mu"]) for row in DATA["rows"]}
    signs = {page.sliding_coefficient(page.mobility(theta), mu) > 0 for theta, mu in both}
    assert signs == {True, False} and len(DATA["rows"]) == 2 * len(both)


def test_opening_has_the_largest_differences_of_the_table():
    text = " ".join(page.PAGES[0].read_text("utf-8").split())
    assert page.PAGES[0].parent.name == "docs"
    table = page.tables(DATA)["agreement"].splitlines()[2:]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in table]
    plain, regularized = (max(float(row[i]) for row in cells) for i in (3, 4))
    assert f"in {sum(int(row[2]) for row in cells)} states: to {100 * plain:.1f} % as it" in text
    assert regularized < 7e-4 and "to 7·10⁻⁴ with the regularization" in text


def test_versions_are_those_of_the_requirements():
    pinned = dict(re.findall(r"(?m)^(\w+)==([\d.]+)", (FOLDER / "requirements.txt").read_text()))
    assert DATA["versions"] == {"MuJoCo": pinned["mujoco"], "Drake, SAP": pinned["drake"]}


@pytest.mark.parametrize(("theta", "mu"), [(0.5, 1.4), (1.0, 1.4), (1.1, 0.5), (0.9, 2.0)])
def test_mujoco_takes_the_step_of_the_closed_form(theta, mu, monkeypatch):
    mujoco = pytest.importorskip(
        "mujoco", reason="MuJoCo is not installed. Fix: pip install --group peers"
    )
    monkeypatch.syspath_prepend(str(FOLDER))
    rod, script = importlib.import_module("rod"), importlib.import_module("mujoco_rod")
    q, u = rod.start(theta, 1.0, -1.0)
    text = script.xml(1e-4, q, script.STIFF, script.stiff_contact, mu)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = q, u
    mujoco.mj_forward(model, data)
    # Normal and slip of the rod's plane, with the regularization and reference of the program.
    rows = data.efc_J.reshape(-1, model.nv)[[0, 2]]
    sign = np.array([1.0, -np.sign(rows[1] @ u)])
    W = rows @ np.diag([1 / rod.M, 1 / rod.M, 1 / rod.J]) @ rows.T * np.outer(sign, sign)
    free = (rows @ data.qacc_smooth - data.efc_aref[[0, 2]]) * sign
    force, _ = page.cone_dual_step(W + np.diag(data.efc_R[[0, 2]]), mu, free)
    assert data.efc_force[[0, 2]] * sign == pytest.approx(force, rel=1e-5)
