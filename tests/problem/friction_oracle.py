"""Several frictional contacts over the rationals, and strategies that draw small ones."""

import itertools
import math
from fractions import Fraction
from itertools import islice

import numpy as np
from hypothesis import strategies as st

from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.modes import ContactMode
from tests.problem.complementarity.rational import unique_solution
from tests.support.drawn import integers

LIFT, RIGHT, LEFT, STICK = (
    ContactMode.LIFTOFF,
    ContactMode.SLIP_POS,
    ContactMode.SLIP_NEG,
    ContactMode.STICK,
)
SWAPPED = {LIFT: LIFT, RIGHT: LEFT, LEFT: RIGHT, STICK: STICK}

EIGHTHS = range(-24, 25)
one_or_two = st.integers(1, 2)


@st.composite
def contact_sets(draw, sizes=one_or_two, slip=(0, 0, -1, 1), definite=False, more=()):
    """Draw W = L L' with integer L, so that singular mobilities are frequent, and the rest of it.

    Returns W, b, mu (lists of fractions), the slip directions, and for each of `more` ranges the
    numbers of the contacts.
    """
    n = draw(sizes)
    m = 2 * n
    parts = (1, range(m)), (m**2, range(-3, 4)), (m, range(3)), (m, EIGHTHS), (n, range(9))
    parts += (n, range(len(slip))), *((n, numbers) for numbers in more)
    drawn = iter(draw(integers([numbers for count, numbers in parts for _ in range(count)])))
    (rank,), L, diagonal, b, mu, way, *rest = ([*islice(drawn, count)] for count, _ in parts)
    L = np.reshape(L, (m, m))
    L = np.tril(L, -1) + np.diag(np.add(diagonal, 1)) if definite else L[:, : rank + 1]
    W = [[Fraction(entry) for entry in line] for line in (L @ L.T).tolist()]
    b, mu = [Fraction(k, 8) for k in b], [Fraction(k, 4) for k in mu]
    return W, b, mu, [slip[k] for k in way], *rest


def built(data):
    """Return the problem in floating point."""
    W, b, mu, slip = data
    return ContactProblem(np.array(W, float), np.array(b, float), np.array(mu, float), slip)


def one_mode(mode, mu, s):
    """Return (directions of F, vanishing entries of a) of one contact's mode, or None."""
    if mode is LIFT:
        return [], []
    if mode is STICK:
        return None if s else ([(1, 0), (0, 1)], [0, 1])
    way = 1 if mode is RIGHT else -1
    return None if s and s != way else ([(1, -mu * way)], [0])


def obeys(mode, mu, s, F, a):
    """Return whether exact forces and accelerations obey one contact's mode, borders included."""
    if mode is LIFT:
        return a[0] >= 0
    if mode is STICK:
        return F[0] >= 0 and abs(F[1]) <= mu * F[0]
    way = 1 if mode is RIGHT else -1
    return F[0] >= 0 and (s != 0 or mu == 0 or way * a[1] >= 0)


def exact_solutions(W, b, mu, slip):
    """Return the set of exact forces of all regular choices of modes, and whether all are."""
    n = len(mu)
    solutions, complete = set(), True
    for modes in itertools.product((LIFT, RIGHT, LEFT, STICK), repeat=n):
        parts = [one_mode(mode, mu[i], slip[i]) for i, mode in enumerate(modes)]
        if any(part is None for part in parts):
            continue
        ways, rows = [], []
        for i, (directions, vanishing) in enumerate(parts):
            for way in directions:
                column = [Fraction(0)] * (2 * n)
                column[2 * i : 2 * i + 2] = way
                ways.append(column)
            rows += [2 * i + entry for entry in vanishing]
        block = [[sum(W[r][k] * way[k] for k in range(2 * n)) for way in ways] for r in rows]
        x = unique_solution(block, [-b[r] for r in rows]) if rows else []
        if x is None:
            # An unsolvable choice is complete, too; a continuum is not what this oracle lists.
            complete = False
            continue
        F = [sum(x[j] * way[k] for j, way in enumerate(ways)) for k in range(2 * n)]
        a = [sum(W[r][k] * F[k] for k in range(2 * n)) + b[r] for r in range(2 * n)]
        pairs = [slice(2 * i, 2 * i + 2) for i in range(n)]
        if all(
            obeys(mode, mu[i], slip[i], F[pair], a[pair])
            for i, (mode, pair) in enumerate(zip(modes, pairs, strict=True))
        ):
            solutions.add(tuple(F))
    return solutions, complete


def violates_coulomb(problem, s):
    """Return the first law of the contacts that a solution breaks, or None."""
    F, a = s.forces, s.accelerations
    scale = 1e-8 * (1 + np.max(np.abs(F))) * (1 + np.max(problem.mu)) * (1 + np.max(problem.W))
    scale *= 1 + np.max(np.abs(problem.b))
    if np.max(np.abs(problem.W @ F + problem.b - a)) > scale:
        return "dynamics"
    for i in range(problem.size):
        F_n, F_t, a_n, a_t = *F[2 * i : 2 * i + 2], *a[2 * i : 2 * i + 2]
        mu, sliding = problem.mu[i], problem.slip_velocity[i] or a_t
        if F_n < 0 or a_n < -scale or F_n * a_n != 0:
            return "unilateral contact"
        if abs(F_t) > mu * F_n + scale:
            return "friction cone"
        if sliding and abs(F_t + math.copysign(mu * F_n, sliding)) > scale:
            return "friction direction"
    return None


def same_sets(first, second):
    """Return whether two collections of force vectors agree, in any order."""
    first, second = ([np.array(v, float) for v in vs] for vs in (first, second))
    near = [[np.allclose(v, w, rtol=1e-8, atol=1e-10) for w in second] for v in first]
    return len(first) == len(second) and all(map(any, near))
