"""Contact problems of one contact over the rationals, with one mode after another as oracle."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import strategies as st

from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.modes import ContactMode
from tests.support.drawn import integers


def mode_analysis(W_nn, W_nt, W_tt, b_n, b_t, mu, v):
    """Return {(mode, F_n, F_t)} of all isolated modes, or None where one mode has many forces."""
    solutions = set()
    if b_n >= 0:
        solutions.add((ContactMode.LIFTOFF, Fraction(0), Fraction(0)))
    for s, mode in ((1, ContactMode.SLIP_POS), (-1, ContactMode.SLIP_NEG)):
        if v * s < 0:
            continue
        A = W_nn - mu * s * W_nt
        if A == 0:
            if b_n == 0:
                return None
            continue
        force = -b_n / A
        if force > 0 and (v != 0 or s * ((W_nt - mu * s * W_tt) * force + b_t) > 0):
            solutions.add((mode, force, -mu * s * force))
    if v == 0:
        det = W_nn * W_tt - W_nt**2
        if det == 0:
            return None
        force = (W_nt * b_t - W_tt * b_n) / det
        friction = (W_nt * b_n - W_nn * b_t) / det
        if force > 0 and abs(friction) <= mu * force:
            solutions.add((ContactMode.STICK, force, friction))
    return solutions


slips = st.sampled_from([-2, -1, 0, 0, 1])


@st.composite
def contacts(draw, slip=slips, definite=False):
    """W = L L' with a lower triangular L, so that singular mobilities are frequent."""
    least, eighths = int(definite), range(-24, 25)
    diagonal = range(7 - least)
    a, c, b, b_n, b_t, mu = draw(
        integers([diagonal, diagonal, range(-9, 10), eighths, eighths, range(17)])
    )
    a, c = a + least, c + least
    W = map(Fraction, (a * a, a * b, b * b + c * c))
    return *W, Fraction(b_n, 8), Fraction(b_t, 8), Fraction(mu, 4), draw(slip)


def built(data):
    return ContactProblem.single(*map(float, data))
