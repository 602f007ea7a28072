"""The rod in nosnoc: slip to either side and flight as modes of a Filippov system.

nosnoc finds the switches of the friction force exactly; its force of contact must be given, here
k times the compression. A step is one call of its solver with two finite elements of Radau IIA.
"""

import contextlib
import os
from importlib.metadata import version

import casadi as ca
import nosnoc
import numpy as np
from rod import MU, G, J, L, M, report

STIFFNESS = 1e8
UNIT = 1e-6
"""Of the gap in the switching functions, m."""


def model(q, u):
    """Return the Filippov system: gap and slip velocity decide."""
    x = ca.SX.sym("x", 6)
    s, c = ca.sin(x[2]), ca.cos(x[2])
    gap, slip = x[1] - L * s, x[3] + L * x[5] * s
    normal = -STIFFNESS * gap

    def field(force, friction):
        turn = L * (s * friction - c * force) / J
        return ca.vertcat(x[3], x[4], x[5], friction / M, force / M - G, turn)

    free = field(0.0, 0.0)
    fields = [free, free, field(normal, -MU * normal), field(normal, MU * normal)]
    return nosnoc.NosnocModel(
        x=x,
        x0=np.array([*q, *u]),
        F=[ca.horzcat(*fields)],
        c=[ca.vertcat(gap / UNIT, slip)],
        S=[np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])],
    )


def make(h, q, u):
    """Return the stepping function."""
    options = nosnoc.NosnocOpts()
    options.terminal_time = h
    options.N_finite_elements = 2
    options.n_s = 2
    options.comp_tol = 1e-9
    options.sigma_N = 1e-9
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
        solver = nosnoc.NosnocSolver(options, model(q, u))
    state = np.array([*q, *u])

    def step():
        nonlocal state
        solver.set("x0", state)
        with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
            result = solver.solve()
        step.failed += result["status"] != nosnoc.nosnoc_types.Status.SUCCESS
        state = np.array(result["x_list"][-1]).ravel()
        return state[:3].tolist(), state[3:].tolist()

    step.failed = 0
    return step


if __name__ == "__main__":
    settings = {f"FESD, Radau IIA, linear contact {STIFFNESS:.0e} N/m": make}
    report("nosnoc", version("nosnoc"), settings, steps=(1e-3, 1e-4))
