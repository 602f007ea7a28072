"""The jump rule against compliant impacts."""

import numpy as np
import pytest

from painleve_sym.errors import InputError
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.motion.simulator import Simulator
from painleve_sym.papers.impact_resolution.jump import extrapolated
from painleve_sym.study.comparisons.jump_convergence import compare_jump
from tests.support.paper_law import paper_law

TABLE_3 = {"x_A_dot": -1.0, "theta": 1.0, "theta_dot": 1.0}
TABLE_4 = {"x_A_dot": -1.0, "theta": 1.0, "theta_dot": 5.0}
MODULI = [20.9e12, 20.9e14, 20.9e16, 20.9e18]


@pytest.fixture(scope="module")
def simulator():
    return Simulator(rod(), paper_law(reload="virgin"))


@pytest.fixture(scope="module")
def comparison(simulator):
    return compare_jump(simulator, TABLE_3, MODULI)


def test_compare_jump_has_one_row_per_stiffness_and_phase(comparison):
    assert comparison.softened.shape == (4, 3, 3)
    assert comparison.rule.shape == (3, 3)
    assert comparison.times.shape == (4, 3)
    assert np.all(np.diff(comparison.times, axis=1) > 0)


def test_compare_jump_slip_is_zero_after_the_first_phase(comparison):
    _, slip, _ = comparison.column(1, "x_A_dot")
    assert np.all(slip == 0)


@pytest.mark.parametrize("phase", [1, 2, 3])
def test_compare_jump_error_falls_with_an_order_below_its_limit(comparison, phase):
    name = "theta_dot" if phase == 2 else "y_A_dot"
    orders = comparison.orders(phase, name)
    assert np.all(np.diff(orders) < 0)
    assert comparison.expected_order == pytest.approx(-1 / (2 * 1.764))
    assert comparison.expected_order < orders[-1] < comparison.expected_order + 0.04


def test_compare_jump_order_follows_the_exponent_of_the_law(simulator):
    comparison = compare_jump(simulator, TABLE_3, MODULI, parameters={"n": 1.5})
    assert comparison.expected_order == pytest.approx(-1 / 3)
    assert comparison.orders(1, "y_A_dot")[-1] == pytest.approx(-1 / 3, abs=0.04)


def test_compare_jump_error_is_the_impulse_of_the_finite_forces(comparison):
    # Rate of y_A_dot under gravity and centrifugal force while F_n follows the slip: B - A b_t/C.
    s, c, mu = np.sin(1.0), np.cos(1.0), 1.4
    A, C = 1 + 3 * c * (c - mu * s), mu * (1 + 3 * s**2) - 3 * s * c
    rate = s - 9.8 - A / C * c
    _, _, errors = comparison.column(1, "y_A_dot")
    assert errors == pytest.approx(rate * comparison.times[:, 0], rel=0.03)


def test_compare_jump_rebound_error_at_the_paper_s_stiffness(comparison):
    rule, softened, _ = comparison.column(3, "y_A_dot")
    assert rule == pytest.approx(0.05247, abs=5e-6)
    assert softened[1] == pytest.approx(0.06561, abs=5e-6)


def test_compare_jump_needs_an_impact(simulator):
    # A < 0 and B > 0: the rule gives a jump, but without surface energy the rod lifts off.
    with pytest.raises(InputError, match=r"no event 'slip_stop'.*Fix"):
        compare_jump(simulator, TABLE_4, [20.9e14], t_end=0.01)


def test_extrapolated_finds_the_constant_of_its_series():
    n, stiffness = 1.764, 10.0 ** np.arange(10, 15)
    eps = stiffness ** (-1 / (2 * n))
    eta = stiffness ** (-(n - 1) / (2 * n * (n + 1)))
    errors = 0.125 + eps * (3 - 2 * eta + eta**2)
    assert extrapolated(errors, stiffness, n) == pytest.approx(0.125, rel=1e-9)
