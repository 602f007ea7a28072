"""A frozen impact by SciPy's DOP853 with located events: knows nothing of the package."""

import numpy as np
from scipy.integrate import solve_ivp


def frozen_impact(c, rtol=1e-12):
    """Return ``end`` and (v_t, v_n, P_n, P_t, time, modes) of the case `c` with K, n, e."""
    W_nn, W_nt, W_tt, b_n, b_t = (c[k] for k in ("W_nn", "W_nt", "W_tt", "b_n", "b_t"))
    mu, K, n, e = c["mu"], c["K"], c["n"], c["e"]
    state = [c["compression"], c["compression_rate"], c["slip_velocity"], 0.0, 0.0]
    kappa, permanent, loading, elapsed, modes = K, 0.0, True, 0.0, []

    def force(delta):
        return kappa * max(delta - permanent, 0.0) ** n

    def departs(F):
        pull = W_nt * F + b_t
        return 0 if abs(pull) <= mu * W_tt * F else int(np.sign(pull))

    def rates(F):
        F_t = -mu * mode * F if mode else -(W_nt * F + b_t) / W_tt
        slip = W_nt * F + W_tt * F_t + b_t if mode else 0.0
        return W_nn * F + W_nt * F_t + b_n, slip, F_t

    def field(_, y):
        F = force(y[0])
        a_n, a_t, F_t = rates(F)
        return [y[1], -a_n, a_t, F, F_t]

    def turns(_, y):
        return y[1] if loading else -y[1]

    def opens(_, y):
        return 1.0 if loading else y[0] - permanent

    def changes(_, y):
        if mode:
            return mode * y[2]
        return mu * W_tt * force(y[0]) - abs(W_nt * force(y[0]) + b_t)

    guards = [turns, opens, changes]
    for guard in guards:
        guard.terminal, guard.direction = True, -1
    mode = int(np.sign(state[2])) if state[2] else departs(force(state[0]))
    if state[1] < 0 or (state[1] == 0 and rates(force(state[0]))[0] > 0):
        loading = False
    for _ in range(12):
        if not loading and permanent == 0 and e < 1:
            permanent, kappa = state[0] * (1 - e * e), K / e ** (2 * n)
        modes.append((mode, loading))
        length = max(state[0], (1 / (K * W_nn)) ** (1 / (n + 1)) * 1e-3)
        run = solve_ivp(
            field,
            (0, 1e3),
            state,
            method="DOP853",
            rtol=rtol,
            atol=[1e-14 * length, 1e-15, 1e-15, 1e-17, 1e-17],
            events=guards,
            first_step=1e-9,
        )
        hit = next((k for k, times in enumerate(run.t_events) if len(times)), None)
        state, elapsed = list(run.y[:, -1]), elapsed + run.t[-1]
        result = (state[2], -state[1], state[3], state[4], elapsed, modes)
        if hit is None:
            return "no end", result
        if hit == 1:
            return "separation", result
        if hit == 2:
            if mode:
                state[2], mode = 0.0, departs(force(state[0]))
            else:
                mode = int(np.sign(W_nt * force(state[0]) + b_t))
        elif not loading:
            return "stays", result
        else:
            state[1], loading = 0.0, False
            if mode == 0:
                mode = departs(force(state[0]))
    return "many", result
