"""A compliant contact in space with frozen coefficients: against impacts, the plane and SciPy."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from painleve_sym import laws
from painleve_sym.automata import frozen_in_space
from painleve_sym.automata.frozen_in_space import COEFFICIENTS
from painleve_sym.errors import EventKind, InputError, StopReason
from painleve_sym.motion.frozen_impact import FrozenImpactSolver
from painleve_sym.motion.frozen_in_space import FrozenSpatialSolver
from painleve_sym.problem import ContactMode, ContactProblem, Disc
from painleve_sym.problem.impact.one_contact import solve_impact
from painleve_sym.problem.risk import holding_forces
from tests.problem.problems import spatial

E, NU, R, N = 20.9e14, 0.3, 0.00645, 1.5
LAW = laws.bilinear_hertz(E=E)
K = 4 / 3 * E / (2 * (1 - NU**2)) * math.sqrt(R)
"""Of Hertz's law for two bodies of one material; N/m^1.5."""
TURNS = np.array([[1.0, -1.0, 0.0], [-1.0, 6.0, 2.0], [0.0, 2.0, 1.0]])


@pytest.fixture(scope="module")
def solver():
    return FrozenSpatialSolver(LAW)


def _kinds(motion):
    return [kind for _, kind in motion.events]


def test_without_accelerations_the_impulse_is_that_of_the_energetic_impact(solver):
    """The path over the impulse does not depend on the law, whatever the slip does."""
    rng, courses = np.random.default_rng(5), set()
    for _ in range(150):
        A = rng.normal(size=(3, 3)) * np.exp(rng.normal(size=(3, 1)))
        W = A @ A.T + 10 ** rng.uniform(-2, 0) * np.eye(3)
        v = rng.normal(size=3)
        v[0] = -abs(v[0])
        v[1:] *= rng.random() > 0.2
        mu, e = math.exp(rng.normal()), rng.uniform(0.2, 1)
        impact = solve_impact(W.tolist(), mu, tuple(v), "energetic", e)
        courses.add(impact.case.name)
        motion = solver(W, np.zeros(3), mu, v, {"e_energetic": e}, t_end=1.0)
        assert motion.stop_reason is StopReason.UNTIL
        impulse = np.sum([p.impulse for p in impact.phases], axis=0)
        assert motion.impulse == pytest.approx(impulse, rel=1e-8, abs=1e-8 * abs(impulse).max())
    assert courses >= {"SLIDING", "C_STICKING", "R_STICKING", "C_REVERSED"}


def test_friction_holds_a_pressed_contact_where_its_contact_problem_sticks():
    """Its normal row stands by itself, with b_n = −F_n and W_nn = 1, so that F_n is given."""
    rng, seen = np.random.default_rng(6), set()
    names = (*COEFFICIENTS, "F")
    beyond = sp.lambdify(names, frozen_in_space._beyond(sp.Symbol("F", real=True)), "math")
    for _ in range(400):
        made_up = spatial(rng, 1)
        W, b, mu, force = made_up.W, made_up.b, float(made_up.mu[0]), float(rng.integers(1, 4))
        gain, free = holding_forces(W, b, 1)
        pressed = np.zeros((3, 3))
        pressed[0, 0], pressed[1:, 1:] = 1.0, W[1:, 1:]
        along = force * W[1:, 0] + b[1:]
        if not np.allclose(W[1:, 1:] @ (force * gain[:, 0] + free), along):
            continue  # W_tt moves nothing in a direction in which the contact accelerates
        problem = ContactProblem(pressed, [-force, *along], [Disc(mu)], [(0.0, 0.0)])
        (solution,) = problem.solutions()
        if "edge" in problem.borders or not mu:
            continue
        given = (*W[np.triu_indices(3)], *gain[:, 0], *free, *b, mu, 0.0, 0.0, force)
        sticks = beyond(*given) <= 0
        assert sticks == (solution.mode is ContactMode.STICK)
        seen.add(sticks)
    assert seen == {True, False}


def test_momentum_and_energy_balance_close(solver):
    v = np.array([-0.1, -0.5, 0.9])
    motion = solver(TURNS, np.zeros(3), 2.4, v, t_end=1.0)
    assert _kinds(motion) == ["max_compression", "slip_stop", "separation"]
    assert motion.velocity == pytest.approx(v + TURNS @ motion.impulse, abs=1e-13)
    inertia = np.linalg.inv(TURNS)
    gained = (motion.velocity @ inertia @ motion.velocity - v @ inertia @ v) / 2
    lost = motion.friction_loss + motion.contact_loss
    assert gained == pytest.approx(-lost, rel=1e-11)
    assert motion.stored_energy == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize("angle", [0.7, 2.5, -1.9])
def test_other_tangents_change_nothing(solver, angle):
    b, v = np.array([-9.8, 40.0, 20.0]), np.array([-0.01, -0.5, 0.9])
    c, s = math.cos(angle), math.sin(angle)
    Q = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    one = solver(TURNS, b, 2.4, v, t_end=1.0)
    other = solver(Q @ TURNS @ Q.T, Q @ b, 2.4, Q @ v, t_end=1.0)
    assert _kinds(other) == _kinds(one)
    assert other.duration == pytest.approx(one.duration, rel=1e-10)
    assert Q.T @ other.impulse == pytest.approx(one.impulse, abs=1e-10)


PLANE = {"W_nn": 1.9, "W_nt": -1.3, "W_tt": 3.1, "b_n": -9.8, "b_t": 60.0, "mu": 1.1}


@pytest.mark.parametrize("across", [2.0, 0.0])
@pytest.mark.parametrize("v_n", [0.0, -0.2])
def test_slip_in_a_plane_is_that_of_a_planar_contact(solver, across, v_n):
    """Also where W_tt has rank one: where nothing moves the contact across that plane."""
    p = PLANE | {"mu": 1.9}
    planar = FrozenImpactSolver(LAW)(p, {"slip_velocity": -1.0, "compression_rate": -v_n})
    c, s = math.cos(0.6), math.sin(0.6)
    W = np.array([[p["W_nn"], p["W_nt"], 0], [p["W_nt"], p["W_tt"], 0], [0, 0, across]])
    Q = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    b, v = Q @ [p["b_n"], p["b_t"], 0], Q @ [v_n, -1.0, 0]
    motion = solver(Q @ W @ Q.T, b, p["mu"], v, t_end=1.0)
    head = planar.head
    impulse = [head["normal_impulse"], head["tangential_impulse"], 0]
    assert motion.duration == pytest.approx(float(head["duration"]), rel=1e-9)
    assert Q.T @ motion.impulse == pytest.approx(np.array(impulse, float), abs=1e-10)
    assert motion.velocity[0] == pytest.approx(float(head["normal_velocity"]), rel=1e-9)


SLIDES = ["max_compression", "separation"]


def _scipy(W, b, mu, v, e, k=K):
    """Return the time, impulse and kinds of an impact in which slip does not begin again."""
    w, T = W[1:, 0], W[1:, 1:]
    end = {"largest": 0.0, "sticks": False}

    def force(depth):
        if not end["largest"]:
            return k * max(depth, 0.0) ** N
        return k * max((depth - end["largest"] * (1 - e**2)) / e**2, 0.0) ** N

    def rates(_, y):
        F = force(-y[0])
        if end["sticks"]:
            friction = -np.linalg.solve(T, w * F + b[1:])
        else:
            friction = -mu * F * y[2:4] / math.hypot(*y[2:4])
        P = np.array([F, *friction])
        a = W @ P + b
        a[1:] *= not end["sticks"]
        return np.concatenate([[y[1]], a, P])

    def turns(_, y):
        return y[1] if not end["largest"] else 1.0

    def opens(_, y):
        return -y[0] - end["largest"] * (1 - e**2) if end["largest"] else 1.0

    def stops(_, y):
        return 1.0 if end["sticks"] else math.hypot(*y[2:4]) - 1e-9

    events = (turns, stops, opens)
    for event in events:
        event.terminal = True
    turns.direction, stops.direction, opens.direction = 1, -1, -1
    t, y, kinds = 0.0, np.array([0.0, *v, 0, 0, 0]), []
    while "separation" not in kinds:
        run = solve_ivp(
            rates, (t, 1.0), y, "DOP853", events=events, rtol=1e-12, atol=1e-15, max_step=1e-4
        )
        t, y = run.t[-1], run.y[:, -1]
        which = next(i for i, times in enumerate(run.t_events) if len(times))
        kinds.append(("max_compression", "slip_stop", "separation")[which])
        if which == 0:
            end["largest"], y[1] = -y[0], 0.0
        elif which == 1:
            end["sticks"], y[2:4] = True, 0.0
    return t, y[4:], kinds


@pytest.mark.parametrize(
    ("v", "b", "mu", "kinds"),
    [
        ((0.0, -0.5, 0.9), (-9.8, 1.0, 2.0), 2.4, SLIDES),
        ((-0.3, 0.3, 0.1), (-9.8, 30.0, -20.0), 2.4, ["slip_stop", *SLIDES]),
        ((-0.2, 0.1, -0.1), (-9.8, 30.0, -20.0), 2.4, [SLIDES[0], "slip_stop", SLIDES[1]]),
    ],
    ids=["without collision", "sticks in compression", "sticks in restitution"],
)
def test_motion_is_that_of_scipy(solver, v, b, mu, kinds):
    b, v = np.array(b), np.array(v)
    motion = solver(TURNS, b, mu, v, t_end=1.0)
    time, impulse, course = _scipy(TURNS, b, mu, v, 0.75)
    # Friction falls to what b needs just before the force ends. SciPy's contact sticks to the end.
    known = [kind for kind in _kinds(motion) if kind != "slip_start"]
    assert known == course == kinds
    assert motion.duration == pytest.approx(time, rel=1e-7)
    late = np.zeros(3)
    if "slip_stop" in kinds:
        late[1:] = np.linalg.solve(TURNS[1:, 1:], motion.velocity[1:])
        assert 0 < abs(late).max() < 3e-6
    assert motion.impulse - late == pytest.approx(impulse, rel=2e-7)


def test_slip_that_begins_in_a_soft_contact_is_that_of_smooth_friction(solver):
    """Friction with a steep smooth law near v = 0 tends to Coulomb's with its steepness."""
    b, v, mu, e = np.array([-9.8, 5.0, 2.0]), np.array([-0.3, 0.3, 0.2]), 2.2, 0.9
    soft = {"E": 2e3, "e_energetic": e}
    motion = solver(TURNS, b, mu, v, soft, t_end=5.0)
    assert _kinds(motion) == ["slip_stop", "max_compression", "slip_start", "separation"]
    k, largest = K * 2e3 / E, 0.0

    def rates(_, y):
        depth = -y[0]
        base = max((depth - largest * (1 - e**2)) / e**2 if largest else depth, 0.0)
        F = k * base**N
        P = np.array([F, *(-mu * F * y[2:] / np.sqrt(y[2] ** 2 + y[3] ** 2 + 1e-12))])
        return np.concatenate([[y[1]], W @ P + b])

    W, y, t = TURNS, np.array([0.0, *v]), 0.0

    def turns(_, y):
        return y[1] if not largest else -y[0] - largest * (1 - e**2)

    turns.terminal = True
    for turns.direction in (1, -1):
        run = solve_ivp(rates, (t, 5.0), y, "Radau", events=turns, rtol=1e-8, atol=1e-11)
        t, y = run.t[-1], run.y[:, -1]
        largest = largest or -y[0]
    assert motion.duration == pytest.approx(t, rel=1e-5)
    assert motion.velocity == pytest.approx(y[1:], abs=1e-4)


@pytest.mark.parametrize("engine", ["compiled", "erk"])
def test_engines_agree(solver, engine):
    b, v = [-9.8, 1.0, 2.0], [0.0, -0.5, 0.9]
    taylor = solver(TURNS, b, 2.4, v, t_end=1.0)
    other = FrozenSpatialSolver(LAW, engine)(TURNS, b, 2.4, v, t_end=1.0)
    assert _kinds(other) == _kinds(taylor)
    assert other.impulse == pytest.approx(taylor.impulse, rel=1e-10)
    assert other.peak_force == pytest.approx(taylor.peak_force, rel=1e-9)


def test_contact_that_nothing_presses_opens(solver):
    motion = solver(TURNS, [9.8, 0, 0], 2.4, [0, -0.5, 0.9], t_end=1e-2)
    assert motion.stop_reason is StopReason.T_END
    assert motion.velocity == pytest.approx([0.098, -0.5, 0.9])
    assert not motion.impulse.any() and motion.peak_force == 0


def test_contact_that_is_held_oscillates(solver):
    """Its mean force is that of the rigid contact: F_n = −B/A of the slip."""
    v = np.array([0, -1.0, 0.0])
    W = np.diag([1.0, 2.0, 2.0])
    motion = solver(W, [-9.8, 0, 0], 0.2, v, t_end=1.0)
    assert motion.stop_reason is StopReason.EVENT_LIMIT
    assert motion.impulse[0] / motion.duration == pytest.approx(9.8, rel=0.02)


def test_no_restitution_ends_with_the_compression(solver):
    v = np.array([-0.1, -0.5, 0.9])
    until = (EventKind.MAX_COMPRESSION,)
    motion = solver(TURNS, np.zeros(3), 2.4, v, {"e_energetic": 0}, t_end=1.0, until=until)
    plastic = solve_impact(TURNS.tolist(), 2.4, tuple(v), "energetic", 0.0)
    assert motion.velocity == pytest.approx(plastic.phases[-1].velocity, abs=1e-10)


def test_other_friction_is_refused():
    with pytest.raises(InputError, match=r"got 'spring', need 'coulomb'. Fix"):
        FrozenSpatialSolver(LAW.with_friction("spring"))
