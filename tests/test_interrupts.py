"""Ctrl-C ends what runs, where a library swallows it too."""

from __future__ import annotations

import contextlib
import os
import signal
import threading

import numpy as np
import pytest

from painleve_sym.cli import main
from painleve_sym.complementarity.lcp import LCP
from painleve_sym.complementarity.mpcc import solve_mpcc_all
from painleve_sym.interrupts import noted_interrupts
from painleve_sym.papers.impact_resolution import items
from painleve_sym.papers.registry import reproduce


@pytest.fixture(autouse=True)
def interrupts():
    """Ctrl-C interrupts, also where a shell runs the tests in the background and ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_interrupt_that_an_item_swallows_ends_the_reproduction(monkeypatch):
    """CasADi's solvers return, or raise an ordinary error, where Ctrl-C is pressed within them."""
    computed = []

    def swallow(workbench):
        with contextlib.suppress(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        raise RuntimeError("the solver stopped")

    monkeypatch.setitem(items.COMPUTE, "eq-2", swallow)
    monkeypatch.setitem(items.COMPUTE, "eq-3", computed.append)
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        reproduce(["eq-2", "eq-3"])
    assert computed == [] and signal.getsignal(signal.SIGINT) is before


def test_interrupt_within_a_solver_is_not_lost():
    """The real thing: Ctrl-C arrives while Ipopt solves a complementarity problem."""
    lcp = LCP(np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-1.0, -1.0]))
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    with pytest.raises(KeyboardInterrupt), noted_interrupts() as check:
        timer.start()
        for _ in range(10_000):
            with contextlib.suppress(Exception):
                solve_mpcc_all(lcp)
            check()


def test_command_whose_interrupt_was_swallowed_says_so(monkeypatch, capsys):
    def swallow(arguments):
        with contextlib.suppress(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        return 0

    monkeypatch.setattr("painleve_sym.cli.run_command", swallow)
    assert main(["models"]) == 130
    assert capsys.readouterr().err == "painleve: interrupted.\n"
