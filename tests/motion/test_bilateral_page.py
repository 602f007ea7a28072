"""The formulas and numbers of docs/bilateral.md."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from painleve_sym.at.tangential import tangential_impact
from painleve_sym.codegen.named_mechanisms import model
from tests.oracles.bead_scipy import yielding, yielding_stop

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "bilateral.md").read_text("utf-8")


def _row(name):
    line = re.search(rf"(?m)^\| {re.escape(name)} \|(.*)\|$", PAGE).group(1)
    return [float(cell.replace("−", "-")) for cell in line.split("|")]


def test_a_yielding_guide_stops_the_slip_in_the_time_of_the_page():
    bead = model(str(ROOT / "examples" / "mechanisms" / "bead-in-groove.toml"))
    own = {s.name: 0.0 for s in (*bead.system.q, *bead.system.q_dot)}
    own |= {p.name: p.default for p in bead.system.parameters}
    own |= {"phi": 0.4, "phi_dot": 9.0, "x_dot": 1.0, "mu": 1.5, "b": 0.0}
    c = bead.coefficients

    def number(expr):
        return float(expr.subs({s: own[s.name] for s in expr.free_symbols}))

    W_nn, W_nt, W_tt, B = map(number, (c.W_nn, c.W_nt, c.W_tt, c.B))
    A, C = W_nn - 1.5 * abs(W_nt), abs(W_nt) - 1.5 * W_tt
    assert A < 0 and C < 0
    stiffnesses = np.array([1e6, 1e8, 1e10, 1e12])
    times = np.array([yielding_stop((0.0, 0.4, 1.0, 9.0), K, 1.5) for K in stiffnesses])
    rates = np.sqrt(-A * stiffnesses)
    excess = rates * times - np.log(rates)
    assert _row("time t [s]") == pytest.approx(times, rel=5e-3)
    assert _row("λ t − ln λ") == pytest.approx(excess, abs=5e-3)
    limit = math.log(2 * abs(A / (B * C)))
    assert limit == pytest.approx(-4.891, abs=6e-4)
    own["b"] = 0.05
    assert math.log(2 * abs(A / (number(c.B) * C))) == pytest.approx(-4.848, abs=6e-4)
    assert excess[-1] == pytest.approx(limit, abs=3e-3)
    # Times like the square root of the compliance alone would not grow in t √K.
    assert np.all(np.diff(times * np.sqrt(stiffnesses)) > 2)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")  # of SciPy's Radau
@pytest.mark.parametrize("damping_ratio", [0.2, 3.0])
def test_a_yielding_guide_of_any_damping_leads_to_the_tangential_impact(damping_ratio):
    bead = model(str(ROOT / "examples" / "mechanisms" / "bead-in-groove.toml"))
    state = {"phi": 0.4, "phi_dot": 9.0, "x_dot": 1.0}
    jump = tangential_impact(bead, state, parameters={"mu": 1.5})
    limit = [0.0, 0.0, jump.velocity["phi_dot"]]
    options = {"damping_ratio": damping_ratio, "cycles": 40 * max(1.0, damping_ratio)}
    errors = [
        np.max(np.abs(yielding((0.0, 0.4, 1.0, 9.0), K, 1.5, 0.05, **options) - limit))
        for K in (1e8, 1e10)
    ]
    assert errors[1] < errors[0] / 5
    assert errors[1] < 0.01
