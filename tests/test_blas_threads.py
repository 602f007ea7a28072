"""Small problems use one thread of the linear algebra, and leave the setting as it was."""

import os
import subprocess
import sys

import pytest

from painleve_sym import blas_threads

COUNT = """
import os, threading, numpy as np, painleve_sym as ps
from painleve_sym.blas_threads import _library
ask, tell = _library("numpy")
tell(2)
W = np.eye(80) * 3 + 0.01
problem = ps.ContactProblem(W, np.full(80, -1.0), np.full(40, 0.5), np.full(40, -1.0))
seen = []
real = np.linalg.lstsq
np.linalg.lstsq = lambda *a, **k: (seen.append(ask()), real(*a, **k))[1]
assert problem.solve_lemke().solution is not None
assert seen and set(seen) == {1}, seen
assert ask() == 2
"""


@pytest.fixture
def numbers(monkeypatch):
    threads = {"numpy": 4, "scipy": 3}
    functions = {
        name: (lambda name=name: threads[name], lambda k, name=name: threads.update({name: k}))
        for name in threads
    }
    monkeypatch.setattr(blas_threads, "_library", functions.get)
    for name in threads:
        monkeypatch.setitem(sys.modules, name, sys)
    return threads


def test_one_thread_within_also_of_contexts_in_each_other(numbers):
    with blas_threads.one_blas_thread():
        assert numbers == {"numpy": 1, "scipy": 1}
        with blas_threads.one_blas_thread():
            pass
        assert numbers == {"numpy": 1, "scipy": 1}
    assert numbers == {"numpy": 4, "scipy": 3}


def test_an_error_leaves_what_was_set_before(numbers):
    with pytest.raises(ZeroDivisionError), blas_threads.one_blas_thread():
        raise ZeroDivisionError
    assert numbers == {"numpy": 4, "scipy": 3}


def test_forces_of_many_contacts_are_computed_by_one_thread():
    """In a process of its own, where two threads are allowed."""
    if blas_threads._library("numpy") is None:
        pytest.skip("NumPy has no OpenBLAS of its own here")
    environment = {k: v for k, v in os.environ.items() if not k.endswith("NUM_THREADS")}
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
    subprocess.run([sys.executable, "-c", COUNT], env=environment, check=True)
