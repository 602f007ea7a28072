"""Exceptions: a pickle keeps all their data, and their messages have a limited length."""

from __future__ import annotations

import importlib
import multiprocessing
import pickle
import pkgutil

import pytest

import painleve_sym
from painleve_sym import errors
from painleve_sym.errors import (
    MAX_FAULTS,
    MAX_LISTED,
    MAX_MESSAGE,
    InputError,
    ModelError,
    PainleveError,
    PainleveWarning,
    shortened,
    unknown_name,
)

FAULTS = ("line 3: mass is missing.", "line 4: got 'x', need a number.")


def exception_classes():
    """Every exception class that a module of the package defines."""
    for module in pkgutil.walk_packages(painleve_sym.__path__, "painleve_sym."):
        if module.name.endswith("__main__"):
            continue
        try:
            home = importlib.import_module(module.name)
        except ModuleNotFoundError as error:
            # What an extra brings may be absent: `explorer.notebook` needs anywidget.
            assert error.name == "anywidget", error
            continue
        for value in vars(home).values():
            if isinstance(value, type) and issubclass(value, BaseException):
                yield value


CLASSES = sorted(
    {c for c in exception_classes() if c.__module__.startswith("painleve_sym.")},
    key=lambda c: c.__qualname__,
)


def example_of(kind):
    return kind("file a.toml", FAULTS) if issubclass(kind, ModelError) else kind("what failed.")


def test_the_walk_meets_every_public_exception():
    public = {v for v in vars(errors).values() if isinstance(v, type)}
    assert {v for v in public if issubclass(v, BaseException)} <= set(CLASSES)


@pytest.mark.parametrize("kind", CLASSES, ids=lambda c: c.__qualname__)
def test_an_exception_is_the_same_after_a_pickle(kind):
    error = example_of(kind)
    error.seen = "by a test"
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        copy = pickle.loads(pickle.dumps(error, protocol))
        assert type(copy) is kind
        assert str(copy) == str(error) and copy.args == error.args
        assert vars(copy) == vars(error)


def fail(kind):
    raise example_of(kind)


@pytest.mark.slow
def test_a_pool_hands_a_model_error_on():
    """It stalled: the parent could not unpickle what the worker raised."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        answer = pool.apply_async(fail, (ModelError,))
        with pytest.raises(ModelError) as caught:
            answer.get(timeout=60)
    assert (caught.value.where, caught.value.faults) == ("file a.toml", FAULTS)


@pytest.mark.parametrize("kind", [PainleveError, InputError, PainleveWarning])
def test_a_long_quotation_is_cut_and_the_rest_stays(kind):
    message = str(kind(f"file a.toml, key: got {'x' * 300_000!r}, need a number."))
    assert len(message) < MAX_MESSAGE + 100
    assert message.startswith("file a.toml, key: got 'xxx")
    assert message.endswith("xxx', need a number.")
    assert "characters left out" in message


def test_a_usual_message_is_not_cut():
    assert shortened("x" * MAX_MESSAGE) == "x" * MAX_MESSAGE


def test_many_faults_are_counted():
    faults = [f"line {i}: got {'y' * 10_000!r}, need a number." for i in range(1000)]
    error = ModelError("file", faults)
    assert error.faults == tuple(faults)
    listed = str(error).count("need a number.")
    assert 5 < listed < MAX_FAULTS and str(error).endswith(f"And {1000 - listed} more.")
    assert len(str(error)) < MAX_LISTED + 100
    short = str(ModelError("file", [f"line {i}: wrong." for i in range(1000)]))
    assert short.endswith(f"And {1000 - MAX_FAULTS} more.")


def test_long_names_are_not_compared():
    long, names = "a" * 100_000, ["b" * 100_000, "mass"]
    message = unknown_name("name", long, names)
    assert "Did you mean" not in message and len(message) < 2 * MAX_MESSAGE
    assert "Did you mean 'mass'" in unknown_name("name", "mas", names)


@pytest.mark.parametrize(
    ("name", "known"), [("t_eval", ["material"]), ("method", ["record"]), ("E", ["e", "mu"])]
)
def test_no_name_is_suggested_that_is_far(name, known):
    assert "Did you mean" not in unknown_name("argument", name, known)


@pytest.mark.parametrize(
    ("build", "word"),
    [
        (lambda s, m: {"kinetic_energy": m * s["x_dot"] ** 2 / 2}, "kinetic energy"),
        (lambda s, m: {"potential_energy": m * s["x"]}, "potential energy"),
        (lambda s, m: {"generalized_forces": {"x": -m * s["x"]}}, "generalized force"),
    ],
)
def test_a_symbol_of_other_assumptions_is_said_to_be_another(build, word):
    import sympy as sp

    import painleve_sym as ps

    x, m = ps.Coordinate("x", "place", "m"), ps.Parameter("m", 1.0, "kg", "mass")
    symbols = {"x": x.symbol, "x_dot": x.velocity.symbol}
    given = {
        "kinetic_energy": m.symbol * x.velocity.symbol**2 / 2,
        "potential_energy": sp.S.Zero,
        "generalized_forces": {},
    }
    ps.LagrangianSystem("block", (x,), (m,), **(given | build(symbols, m.symbol)))
    with pytest.raises(InputError) as raised:
        ps.LagrangianSystem("block", (x,), (m,), **(given | build(symbols, sp.Symbol("m"))))
    text = str(raised.value)
    assert word in text and "assumptions differ" in text and "real=True" in text
    assert "Did you mean" not in text
