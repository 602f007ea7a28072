"""Constraints with balls of friction beyond contacts: brakes, rolling, loops; closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import painleve_sym as ps

G = 9.8


@pytest.mark.parametrize(
    ("torque", "speed", "friction", "acceleration"),
    [
        (3.0, 0.0, -1.0, 4.0),
        (-3.0, 0.0, 1.0, -4.0),
        (0.75, 0.0, -0.75, 0.0),
        (0.75, 2.0, -1.0, -0.5),
        (0.75, -2.0, 1.0, 3.5),
    ],
)
def test_a_pin_with_dry_friction(torque, speed, friction, acceleration):
    """An inertia of ½ kg m² under a torque, in a pin that takes at most 1 N m."""
    problem = ps.ContactProblem([[2.0]], [2 * torque], [ps.Brake(1.0)], [speed])
    (solution,) = problem.solutions()
    assert solution.tangential_force == pytest.approx(friction)
    assert solution.tangential_acceleration == pytest.approx(acceleration)
    assert problem.complete and problem.case in ("slip", "stick")
    assert problem.residual(solution.forces) < 1e-15


def test_a_brake_holds_beside_a_contact_that_opens():
    W = np.eye(3)
    problem = ps.ContactProblem(W, [1.0, 0.3, 0.4], [ps.Interval(0.5), ps.Brake(1.0)], [0.0, 0.0])
    (solution,) = problem.solutions()
    assert [mode.value for mode in solution.modes] == ["liftoff", "stick"]
    assert solution.forces == pytest.approx([0, 0, -0.4])


def ball(in_space, m=2.0, r=0.5):
    """Return the Jacobian of n, t (t1, t2) and rolling, and the inverse masses of a solid ball."""
    J = 0.4 * m * r * r
    if not in_space:  # velocities n, x, ω
        return np.array([[1, 0, 0], [0, 1, -r], [0, 0, 1.0]]), np.diag([1 / m, 1 / m, 1 / J])
    rows = np.zeros((5, 5))  # velocities n, x, y, ω about y, −ω about x
    rows[0, 0] = rows[1, 1] = rows[2, 2] = rows[3, 3] = rows[4, 4] = 1.0
    rows[1, 3] = rows[2, 4] = -r
    return rows, np.diag([1 / m] * 3 + [1 / J] * 2)


@pytest.mark.parametrize(
    ("slope", "mu", "c", "case"),
    [(0.03, 0.6, 0.02, "rests"), (0.1, 0.6, 0.02, "rolls"), (0.6, 0.05, 0.02, "slides")],
)
@pytest.mark.parametrize("turn", [None, 0.0, 0.7])
def test_a_ball_on_a_slope_with_rolling_resistance(slope, mu, c, case, turn):
    """It rests up to tan α = c/r, rolls with g (sin α − c/r cos α)/1.4, and slides beyond."""
    m, r = 2.0, 0.5
    rows, inverse = ball(turn is not None, m, r)
    free = np.zeros(len(rows))
    free[0] = -G * math.cos(slope)
    down = [1.0] if turn is None else [math.cos(turn), math.sin(turn)]
    free[1 : 1 + len(down)] = G * math.sin(slope) * np.array(down)
    kind = ps.Interval if turn is None else ps.Disc
    W = rows @ inverse @ rows.T
    problem = ps.ContactProblem(W, rows @ free, [(kind(mu), kind(c))], np.zeros(2 * len(down)))
    (solution,) = problem.solutions()
    N = m * G * math.cos(slope)
    motion = free + inverse @ rows.T @ solution.forces
    speeding = float(motion[1 : 1 + len(down)] @ down)
    assert solution.normal_force == pytest.approx(N)
    expected = {
        "rests": 0.0,
        "rolls": G * (math.sin(slope) - c / r * math.cos(slope)) / 1.4,
        "slides": G * (math.sin(slope) - mu * math.cos(slope)),
    }
    assert speeding == pytest.approx(expected[case], abs=1e-9)
    rolling = solution.forces[1 + len(down) :]
    assert np.linalg.norm(rolling) == pytest.approx(
        {"rests": m * G * math.sin(slope) * r}.get(case, c * N)
    )
    # Two discs of one contact may both begin to slip: then one solution is known.
    assert problem.complete is (turn is None)


def test_a_contact_without_friction():
    problem = ps.ContactProblem([[0.5]], [-3.0], [()], [])
    (solution,) = problem.solutions()
    assert solution.mode == "pressed" and solution.forces.tolist() == [6.0]
    assert problem.case == "unique"
    assert ps.ContactProblem([[0.5]], [3.0], [()], []).case == "liftoff"


# ---- closed chains ----


def four_bar(lengths, angles, rates, foot, mu):
    """Return the problem of three bars as bodies, with their pins as closed rows, and a contact.

    Bars of 1 kg/m turn about the ground at the first and last pin. The contact is that of a point
    of the coupler, `foot` along it, with horizontal ground.
    """
    ends = [np.zeros(2)]
    for length, angle in zip(lengths, angles, strict=True):
        ends.append(ends[-1] + length * np.array([math.cos(angle), math.sin(angle)]))
    inverse, free, centres = [], [], []
    for i, length in enumerate(lengths):
        m, J = length, length**3 / 12
        inverse += [1 / m, 1 / m, 1 / J]
        free += [0.0, -G, 0.0]
        centres.append((ends[i] + ends[i + 1]) / 2)

    def at(body, point):
        """Return the rows of the velocity of a point of a body, and its bias."""
        rows = np.zeros((2, 9))
        arm = point - centres[body]
        rows[:, 3 * body : 3 * body + 3] = [[1, 0, -arm[1]], [0, 1, arm[0]]]
        return rows, -(rates[body] ** 2) * arm

    pins = [(None, 0, ends[0]), (0, 1, ends[1]), (1, 2, ends[2]), (2, None, ends[3])]
    rows, biases = [], []
    for first, second, point in pins:
        pair = [at(body, point) for body in (first, second) if body is not None]
        sign = -1 if first is not None and second is not None else 1
        J, bias = pair[0]
        if len(pair) > 1:
            J, bias = J + sign * pair[1][0], bias + sign * pair[1][1]
        rows += list(J)
        biases += list(bias)
    point = ends[1] + foot * (ends[2] - ends[1])
    J, bias = at(1, point)
    rows += [J[1], J[0]]
    biases += [bias[1], bias[0]]
    J, inverse = np.array(rows), np.diag(inverse)
    b = J @ free + biases
    friction = [() for _ in range(8)] + [ps.Interval(mu)]
    speed = float(sum_of_speed(lengths, angles, rates, foot))
    closed = [True] * 8 + [False]
    problem = ps.ContactProblem(J @ inverse @ J.T, b, friction, [speed], closed)
    return problem, J, inverse, np.array(free), b


def sum_of_speed(lengths, angles, rates, foot):
    """Return the horizontal velocity of the foot."""
    return (
        -lengths[0] * math.sin(angles[0]) * rates[0]
        - foot * lengths[1] * math.sin(angles[1]) * rates[1]
    )


@given(
    st.floats(0.3, 1.2),
    st.floats(-0.4, 0.4),
    st.floats(-2.0, -0.6),
    st.sampled_from([0.0, 1.5, -2.0]),
    st.floats(0.1, 1.5),
)
def test_a_four_bar_as_bodies_is_that_of_one_coordinate(first, second, third, speed, mu):
    """The velocity along the one freedom solves the loop; the contact alone is asked there."""
    lengths, angles = [1.0, 1.4, 0.8], [first, second, third]
    loop = np.array([-np.sin(angles), np.cos(angles)]) * lengths
    if abs(np.linalg.det(loop[:, 1:])) < 0.2:
        return
    one = np.array([1.0, *np.linalg.solve(loop[:, 1:], -loop[:, 0])])
    rates = speed * one
    problem, J, inverse, free, b = four_bar(lengths, angles, rates, 0.4, mu)
    # One coordinate: motions that keep the pins, a direction each of velocity and bias.
    pins, contact = J[:8], J[8:]
    motion = np.linalg.svd(pins)[2][8:].T
    assert motion.shape == (9, 1)
    M = np.linalg.inv(inverse)
    reduced = motion.T @ M @ motion
    particular = np.linalg.lstsq(pins, pins @ free - b[:8], rcond=None)[0]
    start = particular + motion @ np.linalg.solve(reduced, motion.T @ M @ (free - particular))
    W = contact @ motion @ np.linalg.solve(reduced, motion.T @ contact.T)
    own = contact @ (start - free) + b[8:]
    slip = sum_of_speed(lengths, angles, rates, 0.4)
    single = ps.ContactProblem((W + W.T) / 2, own, [mu], [slip])
    known = {"slip": "unique", "liftoff": "unique", "stick": "unique"}
    if single.borders or problem.borders:
        return
    assert problem.case == known.get(single.case, single.case)
    motions = sorted(s.accelerations[-2:].round(6).tolist() for s in problem.solutions())
    expected = sorted(s.accelerations.round(6).tolist() for s in single.solutions())
    assert np.allclose(motions, expected, atol=1e-5)
