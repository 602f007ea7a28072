"""The bead in a groove with its pendulum, written by hand and integrated by SciPy.

    (M + m) x'' + m L (p'' cos p - p'^2 sin p) = F_t
    (M + m) y'' + m L (p'' sin p + p'^2 cos p) = N - (M + m) g
    m L (x'' cos p + y'' sin p) + m L^2 p'' = -m g L sin p - b p'

with N of either sign and F_t = -mu s |N|. In the groove y = 0; `yielding` lets the groove give way.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

M, m, L, g = 0.2, 1.0, 0.5, 9.8


def slip_force(s, side, p, w, mu, b):
    """Return N in slip along s, if N has the sign `side`."""
    sin, cos = math.sin(p), math.cos(p)
    # N = a0 + a1 p'',  F_t = -mu s side N; eliminate x'' between the first and the third.
    a0, a1 = (M + m) * g + m * L * w**2 * cos, m * L * sin
    f0, f1 = -mu * s * side * a0, -mu * s * side * a1
    left = m * L**2 - (m * L * cos) * (m * L * cos - f1) / (M + m)
    right = -m * g * L * sin - b * w - m * L * cos * (f0 + m * L * w**2 * sin) / (M + m)
    return a0 + a1 * right / left


def slip_forces(s, p, w, mu, b):
    """Return every N that slip along s allows, by increasing value."""
    forces = [side * slip_force(s, side, p, w, mu, b) for side in (-1, 1)]
    return [side * size for side, size in zip((-1, 1), forces, strict=True) if size > 0]


def accelerations(p, w, normal, friction, b):
    """Return x'' and p'' with y = 0."""
    matrix = [[M + m, m * L * math.cos(p)], [m * L * math.cos(p), m * L**2]]
    right = [friction + m * L * w**2 * math.sin(p), -m * g * L * math.sin(p) - b * w]
    return np.linalg.solve(matrix, right)


def held(p, w, b):
    """Return p'', N and F_t in sticking."""
    turn = (-m * g * L * math.sin(p) - b * w) / (m * L**2)
    normal = (M + m) * g + m * L * (turn * math.sin(p) + w**2 * math.cos(p))
    return turn, normal, m * L * (turn * math.cos(p) - w**2 * math.sin(p))


def motion(state, t_end, mu, b):
    """Return final (x, p, x', p') and the events, where one force at a time is possible."""
    t, z, s, events = 0.0, np.array(state, float), int(np.sign(state[2])), []
    side = int(np.sign(slip_forces(s, z[1], z[3], mu, b)[0])) if s else 0
    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}

    def slipping(_, z):
        normal = slip_force(s, side, z[1], z[3], mu, b)
        return [z[2], z[3], *accelerations(z[1], z[3], normal, -mu * s * side * normal, b)]

    def sticking(_, z):
        return [0.0, z[3], 0.0, held(z[1], z[3], b)[0]]

    def stops(_, z):
        return s * z[2]

    def margin(_, z):
        _, normal, friction = held(z[1], z[3], b)
        return mu * abs(normal) - abs(friction)

    def turns(_, z):
        return side * slip_force(s, side, z[1], z[3], mu, b)

    for watched in (stops, margin, turns):
        watched.terminal, watched.direction = True, -1
    while True:
        watch = [stops, turns] if s else [margin]
        run = solve_ivp(slipping if s else sticking, (t, t_end), z, events=watch, **options)
        t, z = run.t[-1], run.y[:, -1].copy()
        if run.status == 0:
            return z, events
        if s and len(run.t_events[1]):
            events.append((t, "force_reversal"))
            side = -side
            continue
        events.append((t, "slip_stop" if s else "slip_start"))
        z[2] = 0.0
        _, normal, friction = held(z[1], z[3], b)
        side, s = int(np.sign(normal)), 0 if s and margin(t, z) > 0 else -int(np.sign(friction))
        z[2] = s * 1e-14


def yielding(state, stiffness, mu, b, *, damping_ratio=1.0, cycles=40.0):
    """Return (x', y', p') after the groove, a spring with a dashpot, has come to rest."""
    effective = M * (M + m) / (M + m * math.sin(state[1]) ** 2)
    rate = math.sqrt(stiffness / effective)
    c, threshold = 2 * damping_ratio * math.sqrt(stiffness * effective), 1e-6

    def field(_, z):
        p, vx, vy, w = z[2], z[3], z[4], z[5]
        normal = -stiffness * z[1] - c * vy
        friction = -mu * math.tanh(vx / threshold) * abs(normal)
        sin, cos = math.sin(p), math.cos(p)
        matrix = [
            [M + m, 0, m * L * cos],
            [0, M + m, m * L * sin],
            [m * L * cos, m * L * sin, m * L**2],
        ]
        right = [
            friction + m * L * w**2 * sin,
            normal - (M + m) * g - m * L * w**2 * cos,
            -m * g * L * sin - b * w,
        ]
        return [vx, vy, w, *np.linalg.solve(matrix, right)]

    x, p, vx, w = state
    start = [x, 0.0, p, vx, 0.0, w]
    run = solve_ivp(field, (0, cycles / rate), start, method="Radau", rtol=1e-6, atol=1e-11)
    assert run.status == 0
    return run.y[3:, -1]


def yielding_stop(state, stiffness, mu):
    """Return the time at which the slip to the right stops in a groove that is a spring alone."""
    p, w = state[1], state[3]

    def field(_, z):
        y, _, vy, w, p = z
        normal, sin, cos = -stiffness * y, math.sin(p), math.cos(p)
        matrix = [
            [M + m, 0, m * L * cos],
            [0, M + m, m * L * sin],
            [m * L * cos, m * L * sin, m * L**2],
        ]
        right = [
            -mu * abs(normal) + m * L * w**2 * sin,
            normal - (M + m) * g - m * L * w**2 * cos,
            -m * g * L * sin,
        ]
        ax, ay, turn = np.linalg.solve(matrix, right)
        return [vy, ax, ay, turn, w]

    def stops(_, z):
        return z[1]

    stops.terminal = True
    scale = [1e-14 / math.sqrt(stiffness), 1e-10, 1e-12, 1e-10, 1e-12]
    start = [0.0, state[2], 0.0, w, p]
    run = solve_ivp(field, (0, 1), start, method="DOP853", rtol=1e-10, atol=scale, events=stops)
    assert run.status == 1
    return run.t[-1]
