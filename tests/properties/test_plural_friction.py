"""Friction of contacts at rest with given normal forces is a convex problem with one solution.

With W_tt = J_t M^-1 J_t' and b_t the accelerations without friction, F_t minimises
F' W_tt F / 2 + b_t' F over |F_i| <= mu_i N_i: accelerations exist and are unique, also where W_tt
is singular and the forces are not.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from tests.oracles.feet_scipy import Block, Foot, Law
from tests.scenes import FEET, simulator


def _expected(block, state, N):
    """Return slip accelerations of the bounded least-squares problem, and its forces."""
    y = block.start(**state)
    r = block.arms(state["theta"])
    W = 1 / block.m + np.outer(r[:, 1], r[:, 1]) / block.J
    centre, alpha = block.free(y, N)
    b = np.array([block.point(r[i], y, centre, alpha)[0] for i in (0, 1)])
    root = np.linalg.cholesky(W + 1e-14 * np.eye(2)).T
    room = np.array(block.mu) * N
    least = lsq_linear(
        root, np.linalg.solve(root.T, -b), (-room - 1e-300, room + 1e-300), "bvls", tol=1e-15
    )
    return W @ least.x + b, least.x, room


@pytest.mark.slow
@settings(max_examples=150)
@given(
    theta=st.one_of(st.just(0.0), st.floats(1e-3, 0.3), st.floats(-0.3, -1e-3)),
    depth=st.floats(1e-4, 1e-2),
    forces=st.tuples(st.floats(0.1, 50.0), st.floats(0.1, 50.0)),
    mu=st.tuples(st.floats(0.01, 1.5), st.floats(0.01, 1.5)),
    beta=st.floats(-1.0, 1.0),
    height=st.floats(0.0, 0.5),
)
def test_accelerations_of_feet_at_rest_solve_the_convex_problem(
    theta, depth, forces, mu, beta, height
):
    feet = simulator(FEET, "A=linear,B=linear")
    # Both feet are pressed, each with the stiffness that gives its force.
    y_A = -depth - max(0.0, 0.2 * np.sin(theta))
    depths = np.array([-y_A, -y_A - 0.2 * np.sin(theta)])
    N = np.array(forces)
    stiffness = N / depths
    parameters = {"k_A": stiffness[0], "k_B": stiffness[1], "mu_A": mu[0], "mu_B": mu[1]}
    parameters |= {"beta": beta, "h": height}
    state = {"y_A": y_A, "theta": theta}
    run = feet.run(state, parameters=parameters, t_end=1e-9)
    start, memory = run.step_rows[0, 0], run.step_memory[0]
    motion = [m.name for m in feet.outline.modes].index("motion")
    rates = feet.integrator.field(motion, start, memory, run.constants)
    outputs = feet.integrator.outputs(np.array([motion]), start[None], memory[None], run.constants)[
        0
    ]
    at = dict(zip(run.output_names, outputs, strict=True))
    assert [at["normal_force_A"], at["normal_force_B"]] == pytest.approx(forces, rel=1e-9)
    closed = (Foot("compression"), Foot("compression"))
    laws = tuple(Law(k) for k in stiffness)
    block = Block(laws, h=height, beta=beta, mu=mu, feet=closed)
    slip, friction, room = _expected(block, state, N)
    # Rigid body: the slip accelerations of both feet from those of the coordinates.
    by_name = dict(zip(run.state_names, rates, strict=True))
    own = by_name["x_A_dot"] + np.array([0.0, -0.2 * np.sin(theta) * by_name["theta_dot"]])
    size = 9.8 + np.abs(N).sum()
    assert own == pytest.approx(slip, abs=1e-7 * size)
    mine = np.array([at["tangential_force_A"], at["tangential_force_B"]])
    assert np.all(np.abs(mine) <= room * (1 + 1e-6) + 1e-7 * size)
    if abs(theta) > 0.01:
        assert mine == pytest.approx(friction, abs=1e-6 * size)
