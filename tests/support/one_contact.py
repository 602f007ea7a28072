"""Contact problems of one contact over the rationals, with one mode after another as oracle."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import strategies as st

from painleve_sym.contacts.local_mode import ContactMode
from painleve_sym.contacts.problem import ContactProblem


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


eighths = st.integers(-24, 24).map(lambda k: Fraction(k, 8))
slips = st.sampled_from([-2, -1, 0, 0, 1])


@st.composite
def contacts(draw, slip=slips, definite=False):
    """W = L L' with a lower triangular L, so that singular mobilities are frequent."""
    diagonal = st.integers(1 if definite else 0, 6)
    a, b, c = draw(diagonal), draw(st.integers(-9, 9)), draw(diagonal)
    mu = draw(st.integers(0, 16).map(lambda k: Fraction(k, 4)))
    return (
        Fraction(a * a),
        Fraction(a * b),
        Fraction(b * b + c * c),
        *(
            draw(eighths),
            draw(eighths),
            mu,
            draw(slip),
        ),
    )


def built(data):
    return ContactProblem.single(*map(float, data))
