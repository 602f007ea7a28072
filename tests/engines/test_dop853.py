"""The coefficient tables satisfy the identities that define the method."""

from __future__ import annotations

import numpy as np
import pytest

from painleve_sym.engines.runge_kutta.coefficients import DENSE_STAGES, dop853


def matrix():
    a = np.zeros((DENSE_STAGES, DENSE_STAGES))
    for i, row in enumerate(dop853().stage_weights):
        for j, w in row.items():
            a[i, j] = w
    return a


def test_nodes_are_row_sums():
    np.testing.assert_allclose(matrix().sum(axis=1), dop853().nodes, atol=4e-15)


def test_stages_are_explicit():
    assert np.all(np.triu(matrix()) == 0)


@pytest.mark.parametrize("order", range(1, 9))
def test_weights_integrate_powers_up_to_order_8(order):
    b, c = matrix()[12], np.array(dop853().nodes)
    assert b @ c ** (order - 1) == pytest.approx(1 / order, abs=1e-14)


def test_weights_satisfy_the_tree_conditions_of_order_5():
    a, b, c = matrix(), matrix()[12], np.array(dop853().nodes)
    assert b @ a @ c == pytest.approx(1 / 6, abs=1e-14)
    assert b @ a @ c**2 == pytest.approx(1 / 12, abs=1e-14)
    assert b @ a @ a @ c == pytest.approx(1 / 24, abs=1e-14)
    assert (b * c) @ a @ c == pytest.approx(1 / 8, abs=1e-14)
    assert b @ a @ a @ a @ c == pytest.approx(1 / 120, abs=1e-14)
    assert (b * c) @ a @ a @ c == pytest.approx(1 / 30, abs=1e-14)


@pytest.mark.parametrize("row", [dop853().error_5, dop853().error_3])
def test_error_weights_sum_to_zero(row):
    assert sum(row.values()) == pytest.approx(0, abs=1e-14)


def test_dense_weights_sum_to_zero():
    # A constant field moves on a line: the higher rows of the polynomial must vanish for it.
    for row in dop853().dense_weights:
        assert sum(row.values()) == pytest.approx(0, abs=2e-13)
