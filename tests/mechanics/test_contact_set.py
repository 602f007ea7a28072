"""All contacts of a mechanism together: in turn the rows that each one's coefficients have."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.mechanics.contact_set import ContactSet
from painleve_sym.mechanics.system import sample_values

FEET = model("block-two-feet")
SET = ContactSet(FEET)


def _numbers(matrix):
    symbols = sorted(matrix.free_symbols, key=str)
    return np.array(matrix.xreplace(sample_values(symbols, 1)).evalf(20), dtype=float)


def _equal(left, right):
    difference = left - right
    values = sample_values(sorted(left.free_symbols | right.free_symbols, key=str), 1)
    return np.allclose(np.array(difference.xreplace(values).evalf(20), dtype=float), 0, atol=1e-13)


@pytest.mark.parametrize("i", [0, 1])
def test_rows_of_a_contact_are_normal_then_tangential(i):
    own, c = slice(2 * i, 2 * i + 2), FEET.all_coefficients[i]
    block = sp.Matrix([[c.W_nn, c.W_nt], [c.W_nt, c.W_tt]])
    assert _equal(SET.W[own, own], block)
    assert _equal(SET.b[own, 0], sp.Matrix([c.b_n, c.b_t]))
    assert _equal(SET.directions[:, own], sp.Matrix.hstack(*c.force_directions))


def test_coupling_of_two_contacts_is_symmetric():
    W = _numbers(SET.W)
    assert np.allclose(W, W.T, rtol=1e-12)
    assert np.linalg.matrix_rank(W) == 3  # two feet of one body have three ways to move
