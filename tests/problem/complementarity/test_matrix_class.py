"""P-matrices and copositive matrices, against known matrices and a closed form."""

import numpy as np
import pytest
from hypothesis import given

from painleve_sym.errors import InputError
from painleve_sym.problem.complementarity import is_copositive, is_p_matrix
from painleve_sym.problem.complementarity.lcp import ENUMERATION_LIMIT
from tests.problem.complementarity.rational import entries

HORN = np.array(
    [[1, -1, 1, 1, -1], [-1, 1, -1, 1, 1], [1, -1, 1, -1, 1], [1, 1, -1, 1, -1], [-1, 1, 1, -1, 1]]
)


@pytest.mark.parametrize(
    ("matrix", "expected"),
    [
        (np.eye(3), True),
        ([[1, 5], [0, 1]], True),
        ([[1, 2], [2, 1]], False),
        ([[0]], False),
        ([[1, 1], [1, 1]], False),
        ([[1e-8, 0], [0, 1e8]], True),
    ],
)
def test_is_p_matrix_decides_for_known_matrices(matrix, expected):
    assert is_p_matrix(matrix) is expected


@pytest.mark.parametrize(
    ("matrix", "plain", "strict"),
    [
        ([[0]], True, False),
        ([[-1]], False, False),
        (np.eye(2), True, True),
        ([[1, -1], [-1, 1]], True, False),
        ([[1, -1.01], [-1.01, 1]], False, False),
        ([[0, 1], [1, 0]], True, False),
        ([[0, 3], [-1, 0]], True, False),  # only the symmetric part counts
        (HORN, True, False),
        (HORN + 1e-6 * np.eye(5), True, True),
        (HORN - 1e-6 * np.eye(5), False, False),
    ],
)
def test_is_copositive_decides_for_known_matrices(matrix, plain, strict):
    assert is_copositive(matrix) is plain
    assert is_copositive(matrix, strict=True) is strict


@given(entries(6))
def test_is_copositive_agrees_with_the_closed_form_for_three_rows(values):
    a, b, c, d, e, f = values
    matrix = [[a, d, e], [d, b, f], [e, f, c]]
    # Hadeler (1983), theorem 4: order 3 in closed form.
    closed = min(a, b, c) >= 0
    if closed:
        p, q, r = d + np.sqrt(a * b), e + np.sqrt(a * c), f + np.sqrt(b * c)
        left = np.sqrt(a * b * c) + d * np.sqrt(c) + e * np.sqrt(b) + f * np.sqrt(a)
        closed = min(p, q, r) >= -1e-12 and left + np.sqrt(max(2 * p * q * r, 0)) >= -1e-9
    assert is_copositive(matrix) is bool(closed)


@pytest.mark.parametrize("check", [is_p_matrix, is_copositive])
def test_matrix_classes_refuse_large_or_oblong_matrices(check):
    with pytest.raises(InputError, match="Fix: test a smaller block"):
        check(np.eye(ENUMERATION_LIMIT + 1))
    with pytest.raises(InputError, match="need \\(n, n\\)"):
        check(np.ones((2, 3)))
