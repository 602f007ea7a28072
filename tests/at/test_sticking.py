"""A′ and B′ of a sticking contact: the same in every place that has them, at every rank of W_tt."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
import sympy as sp

import painleve_sym as ps
from painleve_sym.at.sticking import sticking_expressions, sticking_formulas
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.risk import schur_complement

ARM = Path(__file__).parents[1] / "robots" / "files" / "turning_arm.urdf"


def by_formulas(W, b):
    """Return A′ and B′ by the formulas of CasADi."""
    symbols = ca.SX.sym("W", 3, 3), ca.SX.sym("b", 3)
    function = ca.Function("sticking", [*symbols], [*sticking_formulas(*symbols)])
    return tuple(float(number) for number in function(W, b))


def by_expressions(W, b):
    """Return A′ and B′ of a planar contact by the expressions of SymPy."""
    nn, nt, tt, n, t = sp.symbols("W_nn W_nt W_tt b_n b_t", real=True)
    own = {"A_stick": nn - nt**2 / tt, "B_stick": n - nt * t / tt, "W_nn": nn, "W_tt": tt, "b_n": n}
    function = sp.lambdify((nn, nt, tt, n, t), sticking_expressions(SimpleNamespace(**own)))
    with np.errstate(all="ignore"):
        return tuple(map(float, function(*map(np.float64, (W[0][0], W[0][1], W[1][1], *b)))))


PLANAR = [
    ([[2.0, 1.0], [1.0, 1.0]], (1.0, -7.0)),
    ([[4.0, -2.0], [-2.0, 1.0]], (0.0, 5.0)),
    ([[1.0, 0.0], [0.0, 0.0]], (1.0, -3.0)),
    ([[0.0, 0.0], [0.0, 2.0]], (0.0, -3.0)),
    ([[0.0, 0.0], [0.0, 0.0]], (0.0, -3.0)),
]


@pytest.mark.parametrize(("W", "sticks"), PLANAR)
def test_every_place_gives_the_same_sticking_in_the_plane(W, sticks):
    b = (-3.0, 4.0)
    problem = ContactProblem(W, b, 0.5, 0.0)
    assert (problem.A_stick, problem.B_stick) == pytest.approx(sticks, abs=1e-14)
    assert by_expressions(W, b) == pytest.approx(sticks, abs=1e-14)
    # A second tangent that nothing couples, at every angle to the first.
    for across, angle in ((0.0, 0.0), (3.0, 0.0), (0.0, 0.7), (3.0, 0.7)):
        c, s = math.cos(angle), math.sin(angle)
        turn = np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])
        space = np.zeros((3, 3))
        space[:2, :2], space[2, 2] = W, across
        space, free = turn @ space @ turn.T, turn @ [*b, 0.0]
        assert by_formulas(space, free) == pytest.approx(sticks, abs=1e-14)
        A, B = schur_complement(space, free, 1)
        assert (A.item(), B.item()) == pytest.approx(sticks, abs=1e-14)


def test_sticking_holds_both_tangents_in_space():
    rng = np.random.default_rng(3)
    for _ in range(20):
        J, b = rng.normal(size=(3, 3)), rng.normal(size=3)
        W = J @ J.T
        force = np.linalg.solve(W[1:, 1:], -np.column_stack([W[1:, 0], b[1:]]))
        sticks = W[0, 0] + W[0, 1:] @ force[:, 0], b[0] + W[0, 1:] @ force[:, 1]
        assert by_formulas(W, b) == pytest.approx(sticks, rel=1e-9, abs=1e-12)
        A, B = schur_complement(W, b, 1)
        assert (A.item(), B.item()) == pytest.approx(sticks, rel=1e-9, abs=1e-12)


def test_arm_that_moves_in_one_plane_has_the_sticking_of_the_plane():
    robot = ps.robot(ARM)
    for locked, A_is_zero in (("elbow,psi", True), ("psi", False)):
        tip = robot.contact("tip", joints={"shoulder": -0.5, "elbow": 0.4}, locked=locked)
        numbers = tip.numbers()
        (nn, nt, _), (_, tt, _), (_, _, across) = numbers.W.tolist()
        assert across == pytest.approx(0.0, abs=1e-15) and tt > 0.1
        assert numbers.A_stick.item() == pytest.approx(nn - nt**2 / tt, abs=1e-12)
        expected = numbers.b[0] - nt * numbers.b[1] / tt
        assert numbers.B_stick.item() == pytest.approx(expected, abs=1e-9)
        assert (numbers.A_stick.item() < 1e-12) == A_is_zero


@pytest.mark.parametrize("unit", [1e-170, 1.0, 1e170])
@pytest.mark.parametrize("rank", [1, 2])
def test_sticking_is_the_same_in_every_unit(unit, rank):
    """A′ = W_nn − wᵀ T⁺ w: 2 − 1 at rank one, with w along it, and else 2 − 2/3."""
    w, T = ([1.0, 1.0], np.ones((2, 2))) if rank == 1 else ([1.0, 0.0], np.diag([1.5, 3.0]))
    W = np.block([[np.array([[2.0]]), np.array([w])], [np.array([w]).T, T]]) * unit
    b = np.array([-3.0, *w])
    expected = {1: (1.0, -4.0), 2: (4 / 3, -11 / 3)}[rank]
    for A, B in (by_formulas(W, b), schur_complement(W, b, 1)):
        assert (np.squeeze(A) / unit, np.squeeze(B)) == pytest.approx(expected, rel=1e-14)
