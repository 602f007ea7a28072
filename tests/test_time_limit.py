"""The time limit of derivations: it ends long ones, in any thread, and nothing else."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
import threading
import time

import pytest
import sympy as sp

from painleve_sym.errors import DerivationTimeout, InputError
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.time_limit import VARIABLE, within_time
from tests.cli.cli_helpers import run


def forever():
    """Work that also continues after an ordinary exception."""
    while True:
        try:
            sum(range(1000))
        except Exception:
            continue


def ended(seconds, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(seconds))
    with pytest.raises(DerivationTimeout, match=f"the work: .* {seconds:g} s of.*{VARIABLE}"):
        within_time("the work", forever)


def test_work_without_end_is_ended(monkeypatch):
    ended(0.05, monkeypatch)


def test_work_without_end_is_ended_in_another_thread_too(monkeypatch):
    """Signals of an alarm do not arrive there."""
    monkeypatch.setenv(VARIABLE, "0.05")
    raised = []

    def work():
        try:
            within_time("the work", forever)
        except DerivationTimeout as error:
            raised.append(error)

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60)
    assert len(raised) == 3


def test_work_in_time_is_returned_and_not_interrupted_later(monkeypatch):
    monkeypatch.setenv(VARIABLE, "0.2")
    for i in range(20):
        assert within_time("the work", lambda: i) == i  # noqa: B023
    time.sleep(0.4)
    assert within_time("the work", lambda: "whole") == "whole"


@pytest.mark.parametrize("seconds", ["10", "0.05"])
def test_a_profiler_works_after_a_derivation(seconds):
    """On CPython 3.11 a cancelled interruption lets the next profiler wait without end."""
    lines = [
        "import sys",
        "from painleve_sym.errors import DerivationTimeout",
        "from painleve_sym.time_limit import within_time",
        inspect.getsource(forever),
        "try:",
        f"    within_time('work', forever if {seconds} < 1 else int)",
        "except DerivationTimeout:",
        "    print('over')",
        "sys.setprofile(lambda *_: None)",
        "int('1', base=(lambda: 10)())",
        "sys.setprofile(None)",
    ]
    answer = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)],
        env={**os.environ, VARIABLE: seconds, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert answer.stdout == ("over\n" if float(seconds) < 1 else "")


def test_inner_work_counts_for_the_outer(monkeypatch):
    monkeypatch.setenv(VARIABLE, "0.2")

    def outer():
        for _ in range(10_000):
            within_time("inner work", lambda: sum(range(10_000)))

    with pytest.raises(DerivationTimeout, match="outer work"):
        within_time("outer work", outer)


def test_an_exception_of_the_work_is_its_own():
    with pytest.raises(ZeroDivisionError):
        within_time("the work", lambda: 1 // 0)


@pytest.mark.parametrize("text", ["soon", "0", "-1", "nan", "inf"])
def test_a_limit_that_is_no_time_is_refused(monkeypatch, text):
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(InputError, match=f"{VARIABLE}: got '{text}', need seconds"):
        within_time("the work", lambda: None)


MECHANISM = """
gravity = "9.8"
[coordinates]
x = {{ unit = "m" }}
y = {{ unit = "m" }}
theta = {{ unit = "rad" }}
[parameters]
l = {{ default = 0.5, unit = "m", positive = true }}
m = {{ default = 2.0, unit = "kg", positive = true }}
mu = {{ default = 0.5, unit = "1" }}
[[bodies]]
mass = "m"
centre = ["{x}", "{y}"]
inertia = "m*l**2/3"
angle = "theta"
[[contacts]]
name = "A"
point = ["x - l*cos(theta)", "y - l*sin(theta)"]
friction = "mu"
"""


@pytest.fixture
def slow_derivative(monkeypatch):
    monkeypatch.setattr(sp, "diff", lambda *_: forever())


def test_a_mechanism_that_takes_too_long_is_named(monkeypatch, slow_derivative):
    monkeypatch.setenv(VARIABLE, "0.1")
    with pytest.raises(DerivationTimeout, match=r"table\.toml: deriving its closed forms"):
        mechanism_from_text(MECHANISM.format(x="x**2", y="y"), "table.toml")


def test_a_command_that_takes_too_long_ends_with_1(capsys, monkeypatch, tmp_path, slow_derivative):
    monkeypatch.setenv(VARIABLE, "0.1")
    path = tmp_path / "table.toml"
    path.write_text(MECHANISM.format(x="x**2", y="y"), "utf-8")
    code, out, err = run(capsys, "classify", path, "--state", "x=1")
    assert (code, out) == (1, "")
    assert err.count("\n") == 1 and "table.toml: deriving its closed forms was not done" in err


@pytest.mark.parametrize(
    ("x", "y"),
    [
        ("x**0.333", "y"),
        ("x**0.333 + l*cos(theta)", "y"),
        pytest.param("x**2.71828", "y + x**1.41421", marks=pytest.mark.slow),
        pytest.param("exp(1000*x)", "y + exp(0.333*x)", marks=pytest.mark.slow),
    ],
)
def test_powers_of_high_degree_do_not_take_long(x, y):
    """Each took minutes: x**0.333 is the 333rd power of x**(1/1000)."""
    start = time.process_time()
    c = mechanism_from_text(MECHANISM.format(x=x, y=y)).coefficients
    symbols = sorted(c.A_stick.free_symbols | c.W_nt.free_symbols, key=str)
    at = {s: sp.Rational(3 + i, 7) for i, s in enumerate(symbols)}
    assert sp.N(c.A_stick.subs(at) + c.W_nt.subs(at) ** 2 / c.W_tt.subs(at)) == pytest.approx(
        float(sp.N(c.W_nn.subs(at))), rel=1e-12
    )
    assert time.process_time() - start < 20
