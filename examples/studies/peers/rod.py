"""The rod at four states, for any program that takes steps of one length.

A rod of length 2 l, mass m and moment m l²/3 touches the ground y = 0 with its end A at
(x - l cos(theta), y - l sin(theta)); the friction coefficient is 1.4. A script of another program
gives `stepper`, a function that makes `(step, state)` into a stepping function, and calls `report`.
"""

import json
import math

M, L, MU, G = 1.0, 1.0, 1.4, 9.8
J = M * L * L / 3
GAP = -1e-9
"""Gap at the start, m: some programs see a contact only where bodies overlap."""
STATES = {
    "one force (Table 1)": (0.5, 1.0, -1.0),
    "lift-off (Table 2)": (0.5, 5.0, -1.0),
    "no solution (Table 3)": (1.0, 1.0, -1.0),
    "two solutions (Table 4)": (1.0, 5.0, -1.0),
}
"""theta (rad), theta_dot (rad/s), velocity of A along the ground (m/s); A does not approach."""
STEPS = (1e-3, 1e-4, 1e-5)
T_END = 1e-2


def start(theta, theta_dot, slip):
    """Return position of the centre, angle, and their rates."""
    s, c = math.sin(theta), math.cos(theta)
    q = [L * c, L * s + GAP, theta]
    return q, [slip - L * theta_dot * s, L * theta_dot * c, theta_dot]


def end_velocity(q, u):
    """Return the velocity of A along the ground and away from it."""
    s, c = math.sin(q[2]), math.cos(q[2])
    return u[0] + L * u[2] * s, u[1] - L * u[2] * c


def rounded(value):
    """Return a number or numbers with six digits after the point; more is not compared."""
    return [rounded(v) for v in value] if isinstance(value, list) else round(value, 6) + 0.0


def measured(make, state, steps):
    """Return what a program computes from a state, for each length of the step.

    `force` is the mean normal force of the first step, from the momentum: m (change of the centre's
    velocity + g h)/h. `first` and `end` are the velocities after the first step and at 0.01 s:
    of A along the ground and away from it (m/s), and of the angle (rad/s). `failed` counts the
    steps that a program itself reports as not converged.
    """
    rows = []
    for h in steps:
        q, u = start(*STATES[state])
        step = make(h, q, u)
        before = u[1]
        q, u = step()
        force = M * ((u[1] - before) / h + G)
        first = [*end_velocity(q, u), u[2]]
        impulse = force * h
        for _ in range(round(T_END / h) - 1):
            before = u[1]
            q, u = step()
            impulse += M * (u[1] - before + G * h)
        end = [*end_velocity(q, u), u[2]]
        row = {"step": h, "force": force, "impulse": impulse, "first": first, "end": end}
        rows.append(
            {n: rounded(v) for n, v in row.items()} | {"failed": getattr(step, "failed", 0)}
        )
    return rows


def report(program, version, settings, steps=STEPS):
    """Print the measurements of every setting as JSON.

    Parameters
    ----------
    program, version : str
    settings : dict of str to function
        Text of the setting → function of (h, q, u) that returns a stepping function; that one
        returns q and u after a step.
    """
    rows = {
        text: {state: measured(make, state, steps) for state in STATES}
        for text, make in settings.items()
    }
    print(json.dumps({"program": program, "version": version, "settings": rows}))
