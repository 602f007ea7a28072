"""The numbers and statements of docs/corrected-jump.md, computed again."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from scipy.special import lambertw

from painleve_sym.at.jump import evaluate_jump
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.finite_stiffness import CorrectedJumpRule
from painleve_sym.motion.frozen_impact import FrozenImpactSolver
from painleve_sym.motion.simulator import Simulator
from tests.support.paper_law import paper_law

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "corrected-jump.md").read_text("utf-8")
TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
STEEL, LIMIT_STUDY, N = 209e9, 20.9e14, 1.764
VELOCITIES = ("y_A_dot", "theta_dot")


def table(beginning):
    """Return the rows of numbers of the table of the page whose first cell begins so."""
    start = PAGE.index(f"| {beginning}")
    lines = PAGE[start:].split("\n\n")[0].splitlines()[2:]
    number = r"[−+]?\d+\.?\d*(?:e\d+)?"
    rows = [re.findall(number, line.split("|", 2)[2]) for line in lines]
    return [[float(x.replace("−", "-")) for x in row] for row in rows]


@pytest.fixture(scope="module")
def rules():
    """Return rebounds (velocities by rule) as a function of the modulus.

    Steel has Hertz's exponent, every other modulus the paper's.
    """
    rod = model("rod")
    classical = evaluate_jump(rod, "energetic", TABLE_3).velocity

    hertz, paper = (
        (contact, CorrectedJumpRule(rod, contact), Simulator(rod, contact))
        for contact in (law("bilinear-hertz"), paper_law())
    )

    def at(modulus):
        contact, rule, simulator = hertz if modulus == STEEL else paper
        values = {p.name: p.default for p in (*rod.system.parameters, *contact.parameters)}
        values["E"] = modulus
        run = simulator.run(
            TABLE_3, t_end=1.0, parameters={"E": modulus}, until="separation", rtol=1e-13
        )
        frozen, carried = (
            rule(TABLE_3, values, configuration=c).velocity for c in ("frozen", "carried")
        )
        every = {"classical": classical, "frozen": frozen, "carried": carried}
        compliant = {v: float(run.final[v]) for v in VELOCITIES}
        return {r: {v: float(x[v]) for v in VELOCITIES} for r, x in every.items()}, compliant

    return at


@pytest.mark.slow
def test_first_table_has_the_rebounds_of_steel_and_of_the_limit_study(rules):
    rows = table("Table 3, ẏ_A")
    for column, modulus in ((0, STEEL), (2, LIMIT_STUDY)):
        every, compliant = rules(modulus)
        expected = compliant["y_A_dot"]
        assert rows[3][column // 2] == pytest.approx(expected, abs=5.1e-7)
        for row, values in zip(rows, every.values(), strict=False):
            assert row[column] == pytest.approx(values["y_A_dot"], abs=5.1e-7)
            off = 100 * (values["y_A_dot"] / expected - 1)
            assert row[column + 1] == pytest.approx(off, rel=0.03, abs=0.0005)


def test_headlines_of_the_page_hold_for_steel(rules):
    every, compliant = rules(STEEL)
    off = {r: v["y_A_dot"] / compliant["y_A_dot"] - 1 for r, v in every.items()}
    assert f"{-100 * off['classical']:.0f}" == "45"
    assert max(abs(off["frozen"]), abs(off["carried"])) < 0.0002
    words = " ".join(PAGE.split())
    assert "45 %" in words and "within 0.02 %" in words and "209 GPa" in words


def test_orders_of_the_table_are_those_of_runs(rules):
    rows = table("from E (Pa)")[:-1]
    before = None
    for i in range(len(rows) + 1):
        every, compliant = rules(LIMIT_STUDY * 100.0**i)
        errors = [every[r][v] - compliant[v] for v in VELOCITIES for r in ("frozen", "carried")]
        if before is not None:
            orders = np.log(np.abs(np.divide(errors, before))) / math.log(100.0)
            assert rows[i - 1] == pytest.approx(orders, abs=2e-3)
        before = errors


def test_limits_in_the_table_of_orders():
    first, second = round(-1 / (2 * N), 3), round(-1 / (N + 1), 3)
    assert table("from E (Pa)")[-1] == [first, second, first, second]


def test_drift_is_a_sixtieth_of_the_first_term():
    drift = float(re.search(r"\| \(compliant − frozen\)/t₁ of ẏ_A\(t₃\) \| ([\d.]+)", PAGE)[1])
    whole = float(re.search(r"leaves ([\d.]+) m/s² · t₁", PAGE)[1])
    assert f"drift is\n{100 * drift / whole:.1f} % of the whole first term" in PAGE


def test_reverse_slip_of_the_limit_study_has_the_printed_durations(rules):
    rod, contact = model("rod"), paper_law()
    run = Simulator(rod, contact).run(
        TABLE_3, t_end=1.0, parameters={"E": LIMIT_STUDY}, until="separation"
    )
    times = {event.kind: event.time for event in run.events}
    rule = CorrectedJumpRule(rod, contact)
    values = {p.name: p.default for p in (*rod.system.parameters, *contact.parameters)}
    values["E"] = LIMIT_STUDY
    last = {}
    for configuration in ("frozen", "carried"):
        durations = rule(TABLE_3, values, configuration=configuration).impacts.phase["duration"]
        durations = np.ravel(durations)
        last[configuration] = durations[~np.isnan(durations)][-1]
    assert times["separation"] - times["slip_start"] == pytest.approx(3.95e-8, abs=6e-11)
    assert last["carried"] == pytest.approx(3.97e-8, abs=6e-11)
    assert last["frozen"] == pytest.approx(2.31e-8, abs=6e-11)
    words = "takes 3.95e-8 s in the compliant run, 3.97e-8 s by the carried rule and 2.31e-8 s"
    assert words in " ".join(PAGE.split())


def test_hunt_crossley_has_the_first_integral():
    A, K, n, c, depth, u = sp.symbols("A K n c delta u", positive=True)
    integral = (u - sp.log(1 + c * u) / c) / c + A * K * depth ** (n + 1) / (n + 1)
    acceleration = -A * K * depth**n * (1 + c * u)
    rate = integral.diff(u) * acceleration + integral.diff(depth) * u
    assert sp.simplify(rate) == 0


@pytest.mark.parametrize("v_t", [-0.3, -1e6])
def test_hunt_crossley_impacts_keep_the_first_integral(v_t):
    W_nn, W_nt, W_tt, mu, c, n = 1.9, -1.2, 3.1, 1.4, 0.7, 1.5
    A, K, speed = W_nn + mu * W_nt, 1e9, 0.8
    contact = {"W_nn": W_nn, "W_nt": W_nt, "W_tt": W_tt, "b_n": 0.0, "b_t": 0.0, "mu": mu}
    hunt = law("hunt-crossley")
    defaults = {p.name: p.default for p in hunt.parameters}
    stiffness = float(
        sp.sympify(hunt.stiffness)
        .subs(hunt.definitions)
        .subs({p.symbol: p.default for p in hunt.parameters})
    )
    E = K / stiffness * defaults["E"]
    start = {"slip_velocity": v_t, "compression_rate": speed}
    impact = FrozenImpactSolver(hunt)(contact, start, {**defaults, "E": E, "c": c, "n": n})
    depth = float(impact.phase["compression"][0])
    rate = float(impact.phase["compression_rate"][0])
    work = A * K * depth ** (n + 1) / (n + 1)
    h = (speed - math.log1p(c * speed) / c) / c
    assert (rate - math.log1p(c * rate) / c) / c + work == pytest.approx(h, rel=1e-9)
    # Lambert's W gives the rate of the compression.
    y = -lambertw(-math.exp(-1 - c**2 * (h - work)), 0 if rate < 0 else -1).real
    assert (y - 1) / c == pytest.approx(rate, rel=1e-6, abs=1e-6)
