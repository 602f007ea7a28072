"""Impacts of several contacts in C against the same path in NumPy."""

from __future__ import annotations

import ctypes
from functools import cache

import numpy as np
import pytest

from painleve_sym.codegen.compile import load
from painleve_sym.contacts.impact.one_contact import ImpactEnd
from painleve_sym.contacts.impact.simultaneous import solve_simultaneous_impact
from painleve_sym.engines.source import engine_texts

LAWS = ("energetic", "poisson", "newton")
_FRAME = """
#include <math.h>
#include <string.h>
#define PS_MIN(a, b) ((a) < (b) ? (a) : (b))
#define PS_MAX(a, b) ((a) > (b) ? (a) : (b))
#define PS_RIGID 3
{}
__attribute__((visibility("default"))) int impact(
    int n, const double *W, const double *mu, const double *v, const double *pressing, int law,
    double e, double *velocity, double *impulse, double *work) {{
  return follow_impact(n, W, mu, v, pressing, law, e, velocity, impulse, work);
}}
"""


@cache
def library():
    found = load(_FRAME.format(*engine_texts("loop/impulse")))
    found.impact.argtypes = (
        ctypes.c_int,
        *[ctypes.c_void_p] * 4,
        ctypes.c_int,
        ctypes.c_double,
        *[ctypes.c_void_p] * 3,
    )
    return found


def in_c(W, mu, v, law, e, load_):
    """Return whether it ends, velocities, impulses and works."""
    results = np.zeros((3, len(v)))
    arrays = [np.ascontiguousarray(a, dtype=float) for a in (W, mu, v, load_[::2])]
    ended = library().impact(
        len(mu), *(a.ctypes.data for a in arrays), LAWS.index(law), e, *(r.ctypes.data for r in results)
    )
    return bool(ended), *results


def scene(rng, n, kind):
    """Return W, μ and the velocity of n contacts that hit, or rest without collision."""
    points = rng.uniform(-1, 1, (n, 2))
    while n > 1 and min(np.linalg.norm(points[i] - points[j]) for i in range(n) for j in range(i)) < 0.2:
        points = rng.uniform(-1, 1, (n, 2))
    walls = rng.random(n) < 0.4
    if kind == "level":
        points[:, 1], walls[:] = -0.3, False
    rows = []
    for (x, y), wall in zip(points, walls, strict=True):
        along = np.array([1.0, 0.0, -y]), np.array([0.0, 1.0, x])
        rows += along if wall else along[::-1]
    J = np.array(rows)
    if kind == "bodies":  # one body for each contact, coupled to the next: W is regular
        J = rng.normal(size=(2 * n, 2 * n + 1))
    mass = 10 ** rng.uniform(-1, 1, J.shape[1])
    W = J @ np.diag(1 / mass) @ J.T
    mu = np.where(rng.random(n) < 0.15, 0.0, 10 ** rng.uniform(-2, 0.5, n))
    v = J @ rng.normal(size=J.shape[1])
    v[::2] = -np.abs(v[::2])
    v[1::2] *= rng.random(n) < 0.8
    v[::2] *= rng.random(n) < 0.9
    return W, mu, v * 10 ** rng.uniform(-3, 3)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("n", "count"), [(1, 1500), (2, 600), (3, 60)])
def test_c_follows_the_path_of_numpy(law, n, count):
    rng = np.random.default_rng(n + 10 * LAWS.index(law))
    jams = 0
    for k in range(count):
        W, mu, v = scene(rng, n, ("body", "level", "bodies")[k % 3])
        e = [0.0, 1.0, rng.uniform()][rng.integers(3)]
        b = rng.normal(size=2 * n)
        want = solve_simultaneous_impact(W, mu, v, law, e, load=b)
        ended, velocity, impulse, work = in_c(W, mu, v, law, e, b)
        assert ended is (want.end is not ImpactEnd.JAM), (k, W, mu, v, e)
        if not ended:
            jams += 1
            continue
        speed = np.max(np.abs(v)) + np.max(np.abs(W) @ np.abs(want.impulses))
        size = np.max(np.abs(want.impulses), initial=0.0) + speed / np.max(W)
        assert np.max(np.abs(velocity - want.velocities)) <= 1e-12 * speed, (k, W, mu, v, e)
        assert np.max(np.abs(impulse - want.impulses)) <= 1e-12 * size, (k, W, mu, v, e)
        assert np.max(np.abs(work - want.works)) <= 1e-12 * size * speed, (k, W, mu, v, e)
    assert jams < count / 2
