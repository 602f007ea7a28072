"""Orders of the jump rules against compliant impacts, and what a frozen configuration leaves."""

import numpy as np
import pytest

from painleve_sym.papers.impact_resolution.beyond import compute_corrected
from painleve_sym.papers.impact_resolution.runs import Workbench
from painleve_sym.papers.item import Verdict
from painleve_sym.study.comparisons.finite_stiffness import (
    RULES,
    compare_corrected,
    drift_of_the_rule,
)

STIFF = tuple(20.9 * 10.0**p for p in (19, 20, 21))


@pytest.fixture(scope="module")
def bench():
    return Workbench()


@pytest.fixture(scope="module")
def comparison(bench):
    return compare_corrected(bench.simulator(), bench.state(3), STIFF)


def test_carried_rule_falls_faster_than_the_classical_one_ever_does(comparison):
    spin = {rule: comparison.orders(rule, "theta_dot") for rule in RULES}
    # The limit −1/(2n) is approached like E^(−(n−1)/(2n(n+1))): 0.84 a decade.
    assert np.all(np.abs(spin["classical"] - comparison.classical_order) < 0.03)
    assert np.all(spin["classical"] > comparison.classical_order)
    # With the drift gone the next term is E^(−1/(n+1)), −0.362, and then E^(−1/n).
    assert np.all(spin["carried"] < -1 / (comparison.exponent + 1))
    rebound = {rule: np.abs(comparison.error(rule, "y_A_dot")) for rule in RULES}
    assert np.all(rebound["carried"] < 0.05 * rebound["frozen"])
    assert np.all(rebound["frozen"] < 0.02 * rebound["classical"])


def test_frozen_rule_leaves_the_drift_of_the_classical_one(bench, comparison):
    for velocity in ("y_A_dot", "theta_dot"):
        n = comparison.exponent
        eta = comparison.stiffness ** (-(n - 1) / (2 * n * (n + 1)))
        left = -comparison.error("frozen", velocity) / comparison.slip_times
        limit = np.polyfit(eta / eta[-1], left, 2)[-1]
        # Three terms of a series in η; the fourth is a few per cent here.
        drift = drift_of_the_rule(bench.simulator(), bench.state(3), velocity)
        assert limit == pytest.approx(drift, rel=0.1)


@pytest.mark.slow
def test_item_beyond_the_paper_holds(bench):
    outcome = compute_corrected(bench)
    assert outcome.verdict is Verdict.REPRODUCED
    assert all(outcome.data["checks"].values())
