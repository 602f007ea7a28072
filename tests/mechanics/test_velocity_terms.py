"""The quick look at T: what it accepts is quadratic and positive; the rest it leaves alone."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.mechanics.velocity_terms import clearly_positive, velocity_terms

u, v = VELOCITIES = sp.symbols("u v", real=True)
x, m = sp.symbols("x m", real=True)
POINT = {x: sp.Rational(1, 3), m: sp.Integer(2)}


def test_terms_are_those_of_the_polynomial():
    terms = velocity_terms(m * (u + sp.sin(x) * v - 3) ** 2 / 2, VELOCITIES, POINT)
    s = float(sp.sin(sp.Rational(1, 3)))
    expected = {(): 9, (0,): -6, (1,): -6 * s, (0, 0): 1, (0, 1): 2 * s, (1, 1): s * s}
    assert terms == pytest.approx(expected)


@pytest.mark.parametrize(
    "expr", [u**3, u * v * u, sp.sqrt(u**2), sp.sin(u), 1 / u, u**x, sp.Abs(v), sp.sqrt(-m) * u**2]
)
def test_what_is_not_seen_to_be_quadratic_is_left_to_others(expr):
    assert velocity_terms(expr, VELOCITIES, POINT) is None


def test_unknown_symbol_and_infinite_value_are_left_to_others():
    assert velocity_terms(sp.Symbol("y") * u**2, VELOCITIES, POINT) is None
    assert velocity_terms(u**2 / (3 * x - 1), VELOCITIES, POINT) is None


@pytest.mark.parametrize("name", ["rod", "two-link-arm", "cart-pendulum", "eccentric-disc"])
def test_mass_matrix_of_a_model_is_the_derived_one(name):
    system = model(name).system
    rest = sorted(system.kinetic_energy.free_symbols - set(system.q_dot), key=str)
    point = {s: sp.Rational(3 + i, 5) for i, s in enumerate(rest)}
    terms = velocity_terms(system.kinetic_energy, system.q_dot, point)
    assert terms is not None and clearly_positive(terms, len(system.q))
    half = np.zeros((len(system.q),) * 2)
    for key, value in terms.items():
        if len(key) == 2:
            half[key] = value
    derived = np.array(sp.hessian(system.kinetic_energy, system.q_dot).xreplace(point).evalf())
    assert half + half.T == pytest.approx(derived.astype(float), rel=1e-12, abs=1e-14)


@settings(max_examples=50)
@given(st.lists(st.floats(-2, 2), min_size=9, max_size=9))
def test_accepted_forms_are_positive_definite(entries):
    root = np.array(entries).reshape(3, 3)
    for matrix in (root + root.T, root @ root.T, root[:, :2] @ root[:, :2].T):
        terms = {
            (i, j): matrix[i, j] * (1 if i < j else 0.5) for i in range(3) for j in range(i, 3)
        }
        least = np.linalg.eigvalsh(matrix)[0]
        if clearly_positive(terms, 3):
            assert least > 0
        if least > 1e-2 * np.linalg.norm(matrix):
            assert clearly_positive(terms, 3)
