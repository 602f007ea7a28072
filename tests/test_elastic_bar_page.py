"""The manuscript on the elastic bar: its tables, its two theorems, and a landing by SciPy."""

from __future__ import annotations

import importlib
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from tests.benchmarks import elastic_bar_page as page
from tools.tables import written

DATA = json.loads(page.RESULTS.read_text("utf-8"))
K = DATA["constant"]


@pytest.fixture(scope="module")
def study():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(page.STUDY))
        patch.syspath_prepend(str(page.STUDY.parent / "rigid_rod"))
        return importlib.import_module("elastic_bar")


def test_tables_and_numbers_of_the_manuscript_are_the_kept_ones():
    text = page.PAGE.read_text("utf-8")
    assert written(text, page.tables(DATA)) == text, "Fix: run make paper."
    first, last = DATA["thresholds"][0], DATA["thresholds"][-1]
    abstract = " ".join(text.split())
    assert f"μ = {first['landing']:.3f} where a rigid rod needs {first['rigid_landing']:.3f}" in (
        abstract
    )
    assert f"at 1.4 rad {last['landing']:.3f} instead of {last['rigid_landing']:.3f}" in abstract


def test_order_of_the_thresholds_and_the_limit_of_fast_slip():
    for row in DATA["thresholds"]:
        names = ("cot", "coupling", "landing", "rigid_contact", "rigid_landing", "rigid_rod")
        values = [row[name] for name in names]
        assert values == sorted(values) and row["rigid_contact"] < row["divergence"]
    landed = np.array([row["landing"] for row in DATA["speeds"]])
    assert np.all(np.diff(landed, axis=0) > 0)
    distance = np.array(DATA["limit"]) - landed
    assert np.all(np.abs(distance[-1]) < 2e-3) and np.all(distance[-1] < distance[0] / 4)


def test_kept_thresholds_are_those_of_a_code_of_another_author():
    """Modes and eigenvalues, and a motion in C, that share nothing with the study."""
    first, last = DATA["thresholds"][0], DATA["thresholds"][-1]
    assert first["landing"] == pytest.approx(0.7051, abs=2e-4)
    assert first["rigid_landing"] == pytest.approx(1.264, abs=5e-4)
    assert (first["rigid_contact"], last["rigid_contact"]) == pytest.approx(
        (0.7127, 0.3640), abs=1e-4
    )
    assert (first["divergence"], last["divergence"]) == pytest.approx((0.7291, 0.4086), abs=1e-4)
    others = [0.7053, 0.7090, 0.7112, 0.7123, 0.7129]
    assert [row["landing"][0] for row in DATA["speeds"]] == pytest.approx(others, abs=2e-4)


def oscillators(study, theta, mu, counts=(8, 2)):
    """Return rates, normal, tangent, push and weight of the modes, with m = 1 kg."""
    modes = study.Modes.of(study.Bar(), *counts)
    sin, cos = math.sin(theta), math.cos(theta)
    normal, tangent = modes.along(cos, sin), modes.along(-sin, cos)
    load = -study.G * modes.weight * np.where(modes.across, cos, sin)
    return modes, normal, tangent, normal + mu * tangent, load


def motion(study, theta, mu, place, rate, t_end, events=()):
    """Return the motion of a bar that slides to the left, by SciPy."""
    modes, normal, _, push, load = oscillators(study, theta, mu)
    n = len(normal)

    def field(_, y):
        force = K * max(-normal @ y[:n], 0.0) ** 1.5
        return np.concatenate([y[n:], push * force - modes.rates**2 * y[:n] + load])

    return solve_ivp(
        field, (0, t_end), np.concatenate([place, rate]), method="DOP853", rtol=1e-11, atol=1e-15,
        events=events, max_step=2e-5,
    )  # fmt: skip


@pytest.mark.parametrize(("theta", "mu", "approach"), [(1.0, 0.5, 0.05), (1.3, 0.25, 0.2)])
def test_invariant_is_constant_through_bounces(study, theta, mu, approach):
    modes, normal, _, push, load = oscillators(study, theta, mu)
    n = len(normal)
    # Uniform sliding: no normal acceleration, and modes at rest under F*.
    force = -(normal @ (load * (modes.rates == 0))) / (normal @ (push * (modes.rates == 0)))
    bent = np.divide(push * force, modes.rates**2, out=np.zeros(n), where=modes.rates > 0)
    depth = (force / K) ** (2 / 3)
    drift = (push * force + load) * (modes.rates == 0)
    # δ* of the whole: the rigid part makes up for what the modes move the end.
    shift = np.zeros(n)
    shift[0] = (-depth - normal @ bent) / normal[0]
    down = -approach * np.where(modes.across, math.cos(theta), math.sin(theta)) * modes.weight
    run = motion(study, theta, mu, np.zeros(n), down, 4e-3)
    quotient = push / normal
    assert np.all(quotient > 0)
    values = []
    for t, y in zip(run.t, run.y.T, strict=True):
        eta = y[:n] - (bent + shift + drift * t**2 / 2)
        rate = y[n:] - drift * t
        now = -normal @ y[:n]
        stored = K * (max(now, 0.0) ** 2.5 - depth**2.5) / 2.5 - force * (now - depth)
        values.append(((rate**2 + modes.rates**2 * eta**2) / (2 * quotient)).sum() + stored)
    contact = run.y[:n].T @ normal < 0
    assert contact.any() and np.count_nonzero(np.diff(contact[1:].astype(int))) >= 1
    assert min(values) > 0
    assert values == pytest.approx([values[0]] * len(values), rel=1e-8)


@given(st.floats(0.3, 1.5), st.floats(0.1, 1e3), st.floats(0.01, 0.9), st.floats(0.01, 10))
def test_theorem_on_rigidity_has_no_angle(theta, across, share, compliance):
    """1/k + c²G_b + s²G_a < μ_r s c (G_b - G_a) is 3/k < G_b - 4 G_a."""
    along = across * share
    c, s = math.cos(theta), math.sin(theta)
    rigid = (4 * c * c + s * s) / (3 * s * c)
    left = compliance + c * c * across + s * s * along - rigid * s * c * (across - along)
    assert 3 * left == pytest.approx(3 * compliance - (across - 4 * along), abs=1e-9 * across)


@pytest.mark.parametrize("lands", [True, False])
def test_a_landing_by_scipy_is_that_of_the_study(study, lands):
    threshold = DATA["modes"][0]["landing"][0]
    assert (DATA["modes"][0]["bending"], DATA["modes"][0]["axial"]) == (8, 2)
    mu = threshold + (2e-3 if lands else -2e-3)
    modes, normal, tangent, _, _ = oscillators(study, 1.0, mu)
    n = len(normal)
    rate = modes.weight * np.where(modes.across, math.sin(1.0), -math.cos(1.0))

    def slip(_, y):
        return tangent @ y[n:]

    def gap(t, y):
        return normal @ y[:n] if t > 1e-5 else -1.0

    for event in (slip, gap):
        event.terminal, event.direction = True, 1
    assert tangent @ rate == pytest.approx(-1.0) and normal @ rate == pytest.approx(0, abs=1e-15)
    run = motion(study, 1.0, mu, np.zeros(n), rate, study.WINDOW, (slip, gap))
    assert bool(len(run.t_events[0])) == lands
    assert study.landings(study.Bar(), modes, K, [1.0], [mu], 1.0)[0] == lands
