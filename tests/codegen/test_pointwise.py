"""Formulas over arrays: the C loop and CasADi's map give what the formulas say."""

from __future__ import annotations

import time

import numpy as np
import pytest
import sympy as sp

from painleve_sym.codegen import evaluate
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.codegen.pointwise import Pointwise
from painleve_sym.errors import CompilerMissing, InputError, PainleveWarning, TranslationError

X, Y, P = sp.symbols("x y p", real=True)
FORMULAS = (X * sp.sin(Y) + P, sp.sqrt(X**2 + P) / (1 + Y**2), sp.Integer(3), P**2)


def expected(x, y, p):
    x, y = np.broadcast_arrays(x, y)
    return np.stack(
        [x * np.sin(y) + p, np.sqrt(x**2 + p) / (1 + y**2), np.full(x.shape, 3.0), p**2 + 0 * x]
    )


@pytest.fixture(params=["compiled", "casadi"])
def engine(request):
    return request.param


def test_pointwise_equals_numpy_over_a_grid_of_broadcast_arrays(engine):
    f = Pointwise(FORMULAS, (X, Y, P), engine=engine)
    x, y = np.linspace(-2, 2, 71)[:, None], np.linspace(-3, 3, 83)[None, :]
    computed = f({X: x, Y: y, P: 1.5})
    assert f.engine == engine
    assert computed.shape == (4, 71, 83)
    np.testing.assert_allclose(computed, expected(x, y, 1.5), rtol=4e-15, atol=4e-15)


def test_pointwise_takes_strided_integer_and_single_values(engine):
    f = Pointwise(FORMULAS, (X, Y, P), engine=engine)
    x = np.arange(24).reshape(4, 6).T[::2]
    np.testing.assert_allclose(f({X: x, Y: 0.5, P: 2}), expected(x, 0.5, 2.0), rtol=4e-15)
    np.testing.assert_allclose(f({X: 1, Y: 0.5, P: 2}), expected(1.0, 0.5, 2.0), rtol=4e-15)


def test_pointwise_of_no_points_is_empty(engine):
    f = Pointwise(FORMULAS, (X, Y, P), engine=engine)
    assert f({X: np.empty(0), Y: 1.0, P: 1.0}).shape == (4, 0)


def test_pointwise_blocks_of_the_virtual_machine_join(monkeypatch):
    monkeypatch.setattr(evaluate, "BLOCK", 7)
    f = Pointwise(FORMULAS, (X, Y, P), engine="casadi")
    x = np.linspace(0, 1, 50)
    np.testing.assert_allclose(f({X: x, Y: 2 * x, P: 1.0}), expected(x, 2 * x, 1.0), rtol=4e-15)


def test_pointwise_derivatives_follow_the_expressions(engine):
    formulas = (X**2 * Y, sp.sin(X) + P * Y)
    f = Pointwise(formulas, (X, Y, P), derivatives=(X, Y), engine=engine)
    x, y = np.array([0.3, -1.2]), np.array([2.0, 0.7])
    want = [x**2 * y, np.sin(x) + 3 * y, 2 * x * y, x**2, np.cos(x), 3 + 0 * x]
    np.testing.assert_allclose(f({X: x, Y: y, P: 3.0}), want, rtol=4e-15)


def test_pointwise_outside_the_reals_is_nan_without_a_warning(engine):
    f = Pointwise((sp.sqrt(X), sp.log(X)), (X,), engine=engine)
    computed = f({X: np.array([-1.0, 1.0])})
    assert np.isnan(computed[:, 0]).all()
    assert computed[:, 1].tolist() == [1.0, 0.0]


def test_pointwise_without_compiler_says_so_and_gives_the_same(monkeypatch, tmp_path):
    monkeypatch.setenv("CC", str(tmp_path / "none"))
    with pytest.warns(PainleveWarning, match="slower engine 'casadi'"):
        f = Pointwise(FORMULAS, (X, Y, P))
    assert f.engine == "casadi"
    with pytest.raises(CompilerMissing):
        Pointwise(FORMULAS, (X, Y, P), engine="compiled")


def test_pointwise_keeps_one_library_for_all_values(cache):
    for value in (1.0, 2.0):
        Pointwise(FORMULAS, (X, Y, P))({X: 1.0, Y: 1.0, P: value})
    assert len(list(cache.glob("*.so"))) == 1


def test_pointwise_refuses_what_it_cannot_use():
    with pytest.raises(InputError, match="Did you mean 'compiled'"):
        Pointwise((X,), (X,), engine="compild")
    with pytest.raises(InputError, match="no expressions"):
        Pointwise((), (X,))
    with pytest.raises(TranslationError, match="symbol y"):
        Pointwise((X + Y,), (X,))
    f = Pointwise((X + Y,), (X, Y), engine="casadi")
    with pytest.raises(InputError, match="no value of y"):
        f({X: 1.0})
    with pytest.raises(InputError, match="one shape"):
        f({X: np.zeros(3), Y: np.zeros(4)})


def test_pointwise_million_points_beside_numpy():
    c = model("rod").coefficients
    formulas = [c.W_nn, c.W_nt, c.W_tt, c.b_n, c.b_t, c.A_stick, c.B_stick]
    symbols = sorted(set().union(*(e.free_symbols for e in formulas)), key=str)
    rng = np.random.default_rng(1)
    values = {s: rng.uniform(0.5, 2.0, 1_000_000) for s in symbols}
    compiled = Pointwise(formulas, symbols)
    plain = sp.lambdify(symbols, formulas, cse=True)
    computed, compiled_time = _best(lambda: compiled(values))
    other, numpy_time = _best(lambda: plain(*values.values()))
    np.testing.assert_allclose(computed, other, rtol=1e-12, atol=1e-12)
    print(f"10^6 points: {compiled_time:.3f} s compiled, {numpy_time:.3f} s numpy")


def _best(call):
    times = []
    for _ in range(3):
        start = time.perf_counter()
        result = call()
        times.append(time.perf_counter() - start)
    return result, min(times)
