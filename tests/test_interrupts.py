"""Ctrl-C ends what runs, where a library swallows it too."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from painleve_sym.cli import main
from painleve_sym.interrupts import ended_by_interrupts, noted_interrupts
from painleve_sym.motion.time_stepping.mpcc import solve_mpcc_all
from painleve_sym.papers.impact_resolution import items
from painleve_sym.papers.registry import reproduce
from painleve_sym.problem.complementarity.lcp import LCP


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


INTERRUPTED = """
import ctypes, os, signal, sys, threading, time
from painleve_sym.interrupts import ended_by_interrupts
from painleve_sym.time_limit import is_deriving, within_time

signal.signal(signal.SIGINT, signal.default_int_handler)
threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()

def deaf():
    # A library that waits in C, without the lock of the interpreter, whatever a signal does.
    end = time.monotonic() + 30
    while time.monotonic() < end:
        try:
            ctypes.CDLL(None).usleep(900_000 if len(sys.argv) > 1 else 25_000_000)
        except KeyboardInterrupt:
            pass

with ended_by_interrupts(130, lambda: print("ended", flush=True), is_deriving):
    within_time("a test", deaf)
print("computed to the end")
"""


@pytest.mark.parametrize("words", [(), ("dropped",)])
def test_interrupt_within_a_library_ends_a_command(words):
    """Once the main thread does not notice it, once it drops what the handler raises."""
    program = [sys.executable, "-c", INTERRUPTED, *words]
    begun = time.monotonic()
    answer = subprocess.run(program, capture_output=True, text=True, timeout=20)
    assert (answer.returncode, answer.stdout) == (130, "ended\n"), answer.stderr
    assert time.monotonic() - begun < 6


def test_interrupt_that_python_notices_is_an_exception():
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), ended_by_interrupts(130, pytest.fail, bool):
        signal.raise_signal(signal.SIGINT)
        threading.Event().wait(5)
    assert signal.getsignal(signal.SIGINT) is before
    assert signal.set_wakeup_fd(-1) == -1


def test_too_small_a_limit_of_memory_is_one_sentence():
    resource = pytest.importorskip("resource")

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (300_000 * 1024,) * 2)

    program = [sys.executable, "-m", "painleve_sym", "robot", "robot.urdf", "--contact", "foot"]
    answer = subprocess.run(program, capture_output=True, text=True, timeout=20, preexec_fn=limit)
    assert answer.returncode == 1 and answer.stderr.count("\n") == 1
    assert "the limit of the address space (ulimit -v) is 300000 kB" in answer.stderr
