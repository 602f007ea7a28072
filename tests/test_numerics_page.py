"""The page of the numerics: its tables are those of the kept numbers, and these can be computed."""

from __future__ import annotations

import json
import math

import pytest

from painleve_sym.codegen.compile import find_compiler
from painleve_sym.errors import CompilerMissing
from tests.benchmarks import accuracy, numerics_page
from tests.benchmarks.cases import BELT, CASES, N
from tests.benchmarks.package_peer import PackagePeer
from tools.tables import written


@pytest.fixture(scope="module")
def numbers():
    return json.loads(numerics_page.NUMBERS.read_text("utf-8"))


@pytest.fixture
def compiler():
    try:
        find_compiler()
    except CompilerMissing:
        pytest.skip("no C compiler")


def test_tables_of_the_page_are_those_of_the_numbers(numbers):
    page = numerics_page.PAGE_FILE.read_text("utf-8")
    assert written(page, numerics_page.tables(numbers)) == page
    for name in numerics_page.DRAWN:
        assert f"figures/{name}.png" in page
        assert (numerics_page.FIGURES / f"{name}.png").is_file()


def test_a_table_without_its_place_is_an_error():
    with pytest.raises(ValueError, match="got 0 places for the table 'setup', need one"):
        written("", {"setup": ""})


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_the_package_computes_the_cases_of_the_peers(compiler, case):
    peer = PackagePeer(case)
    peer.prepare()
    assert case.end_error(peer.run(1e-12), reverse_slip=True) < 1e-12


def test_steps_of_one_length_have_the_order_of_the_start(compiler, numbers):
    measured = accuracy.fixed_steps()["starts"]
    for start, order in (("at rest on the ground", 2 * N + 1), ("approach at 0.1 m/s", N + 1)):
        local = [p for p in measured[start]["orders"] if p is not None]
        assert local[-1] == pytest.approx(order, abs=0.06)
        kept = numbers["accuracy"]["fixed_steps"]["starts"][start]["errors"]
        for error, old in zip(measured[start]["errors"], kept, strict=True):
            assert abs(error - old) < 1e-3 * old + 1e-13


def test_taylor_steps_of_one_length_have_their_own_order(compiler):
    for order, line in accuracy.taylor_orders()["orders"].items():
        local = [p for p in line["orders"] if p is not None]
        assert local[-1] == pytest.approx(int(order), abs=0.7)


def test_errors_of_a_grazing_touchdown_grow_with_its_inverse_speed(compiler):
    measured = accuracy.grazing()
    for engine in accuracy.ENGINES:
        for row in measured["rows"]:
            error = row[engine]
            if row["speed"] ** 2 / 2 > 1e-11:
                assert error is not None, row
                assert error * row["speed"] < measured["rtol"], row
        assert not any(row[engine] for row in measured["misses"])


def test_errors_of_a_soft_touch_do_not_depend_on_its_speed(compiler):
    measured = accuracy.soft_touch()
    for engine in accuracy.ENGINES:
        for row in measured["rows"]:
            assert max(row[engine].values()) < 10 * measured["rtol"], (engine, row)


@pytest.mark.parametrize("engine", ["taylor", "compiled"])
def test_the_belt_agrees_with_the_equations_by_hand(compiler, engine):
    own = PackagePeer(BELT, engine)
    own.prepare()
    assert BELT.end_error(own.run(1e-12), reverse_slip=True) < 1e-11
    assert len(own.event_times(1e-12)) == len(BELT.phases(True)) - 1 == 21


def test_exponent_and_orders_of_known_errors():
    steps = [1.0, 0.5, 0.25]
    errors = [3 * h**2 for h in steps]
    assert accuracy.slope(steps, errors) == pytest.approx(2.0)
    assert accuracy.orders(steps, errors) == [None, pytest.approx(2.0), pytest.approx(2.0)]
    assert math.isnan(accuracy.slope(steps, [1e-16] * 3))
    assert accuracy.orders(steps, [1e-9, 1e-15, 1e-15]) == [None, None, None]
