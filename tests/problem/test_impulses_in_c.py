"""Impulses that the loop in C computes at once for contacts at rest, against the kernel."""

from __future__ import annotations

import functools
from collections import Counter

import numpy as np
import pytest

from painleve_sym.codegen.compile import load
from painleve_sym.engines.c_texts import engine_texts
from painleve_sym.engines.impacts import solve_simultaneous_impact
from tests.problem import problems, rational
from tests.problem.problems import verdict

_LIBRARY = """
#include <math.h>
#include <string.h>
#define PS_MIN(a, b) ((a) < (b) ? (a) : (b))
#define PS_MAX(a, b) ((a) > (b) ? (a) : (b))
#define PS_RIGID {}
{}
__attribute__((visibility("default"))) int at_once(const double *W, const double *b,
    const double *mu, const int *held, double *forces, double *rates) {{
  ps_path path;
  ps_step step;
  memset(&path, 0, sizeof path);
  path.n = PS_RIGID;
  path.held = held;
  memcpy(path.W, W, sizeof path.W);
  memcpy(path.mu, mu, sizeof path.mu);
  path.singular = is_singular(PS_RIGID, path.W);
  return impulses_at_once(&path, b, 0, forces, rates, &step);
}}
"""


@functools.cache
def at_once(n):
    parts = engine_texts("loop/rows", "loop/linear", "loop/problem", "loop/impulse")
    return load(_LIBRARY.format(n, "\n".join(parts))).at_once


def resting(rng, n):
    """Return a problem of contacts at rest, half of them with b in the range of W."""
    problem = problems.planar(rng, n)
    b = problem.W @ rng.integers(-2, 3, size=2 * n) if rng.random() < 0.5 else problem.b
    return problem._replace(b=b, slip=[[0]] * n)


def difference(problem):
    """Return in a word how C differs from the kernel; empty where it does not."""
    n = len(problem.mu)
    W, b, mu = (np.array(v, float) for v in (problem.W, problem.b, problem.mu))
    held, forces, rates = np.array(problem.closed, np.intc), np.zeros(2 * n), np.zeros(2 * n)
    given = at_once(n)(*(np.ctypeslib.as_ctypes(v.ravel()) for v in (W, b, mu, held)),
                       *map(np.ctypeslib.as_ctypes, (forces, rates)))  # fmt: skip
    answers = problem.answers()
    stated = verdict(answers)
    if bool(given) != (stated.case != "inconsistent"):
        kind = "existence"
    elif not given or near_one_of(rates, stated.motions, np.max(np.abs(b)) or np.max(W)):
        return ""
    elif answers.law.check(without_noise(forces / answers.law.unit).tolist()) is not None:
        return "" if any(answer.moves for answer in answers.all) else "other motion"
    else:
        kind = "not a solution"
    return f"{kind} on a border" if answers.borders else kind


def without_noise(forces):
    return np.where(np.abs(forces) > 1e-13 * np.max(np.abs(forces)), forces, 0.0)


def near_one_of(rates, motions, size):
    return any(np.allclose(rates, a, rtol=1e-7, atol=1e-8 * size) for a in motions)


def differences(seed, count, n):
    rng, counts = np.random.default_rng(seed), Counter()
    for _ in range(count):
        problem = resting(rng, n)
        counts[difference(problem)] += 1
        counts[difference(problems.in_units(rng, problem))] += 1
    return counts


@pytest.mark.parametrize(
    ("n", "count"),
    [
        (1, 100),
        (2, 60),
        (3, 5),
        pytest.param(1, 3000, marks=pytest.mark.slow),
        pytest.param(2, 2000, marks=pytest.mark.slow),
        pytest.param(3, 200, marks=pytest.mark.slow),
    ],
)
def test_impulses_at_once_are_solutions_of_the_kernel(n, count):
    counts = differences(n, count, n)
    border = sum(counts[word] for word in counts if word.endswith("border"))
    assert counts[""] + border == 2 * count and border <= count / 20


@pytest.mark.parametrize("count", [60, pytest.param(1500, marks=pytest.mark.slow)])
def test_impulses_at_once_are_alone_where_rational_arithmetic_says_so(count):
    """Motions count, not forces that rigidity leaves open."""
    rng, counts = np.random.default_rng(6), Counter()
    while counts.total() < count:
        W, _, mu, _, _ = problems.planar(rng, 2)
        v = W @ rng.integers(-2, 3, size=4)
        if v[0] < 0 and v[2] < 0:
            exact = rational.solutions_of(W.tolist(), v.tolist(), mu, [0, 0], [False, False])
            impact = solve_simultaneous_impact(
                *(np.array(a, float) for a in (W, mu, v)), "energetic", 0.0
            )
            step = impact.path.steps[0]
            alone = step.is_alone(impact.path.W, impact.path.mu, impact.path.bilateral)
            counts[exact.case, alone] += 1
    assert set(counts) == {("unique", True), ("hyperstatic", True), ("indeterminate", False)}
