"""The rod in the package: time stepping by its solvers, and event-driven compliant motion."""

import math

from rod import GAP, MU, T_END, L, end_velocity, report

import painleve_sym as ps
from painleve_sym.motion.time_stepping.stepping import TimeStepper

ROD = ps.model("rod")


def start(q, u, gap):
    """Return the start in the package's coordinates: those of A, and the angle."""
    slip, _ = end_velocity(q, u)
    return {"theta": q[2], "theta_dot": u[2], "x_A_dot": slip, "y_A": gap}


def played(states):
    """Return a function that steps through states of A, and returns those of the centre."""
    rest = iter(states)

    def step():
        x, y, theta, x_dot, y_dot, turn = next(rest)
        s, c = math.sin(theta), math.cos(theta)
        velocity = [x_dot - L * turn * s, y_dot + L * turn * c, turn]
        return [x + L * c, y + L * s, theta], velocity

    return step


NAMES = ("x_A", "y_A", "theta", "x_A_dot", "y_A_dot", "theta_dot")


def stepping(solver):
    """Return a function that makes Moreau-Jean steps with a solver; e = 0."""

    def make(h, q, u):
        stepper = TimeStepper(ROD)
        # A rigid contact has no overlap.
        state = start(q, u, 0.0)
        run = stepper.run(state, step=h, t_end=T_END, solver=solver, parameters={"mu": MU})
        order = [run.state_names.index(n) for n in NAMES]
        return played(run.states[1:, order].tolist())

    return make


def compliant(law, values):
    """Return a function that reads an event-driven motion at multiples of h."""

    def make(h, q, u):
        run = ps.simulate(ROD, law, start(q, u, GAP), t_end=T_END, parameters={"mu": MU} | values)
        times = [min((i + 1) * h, T_END) for i in range(round(T_END / h))]
        return played([run.state(t)[n] for n in NAMES] for t in times)

    return make


if __name__ == "__main__":
    settings = {
        f"Moreau-Jean, {solver}": stepping(solver)
        for solver in ("least-impulse", "largest-impulse", "lemke")
    }
    settings["linear contact 1e+08 N/m, event-driven"] = compliant("linear", {"k": 1e8, "c": 0.0})
    settings["Hertz's law, E = 209 GPa, event-driven"] = compliant(
        "bilinear-hertz", {"E": 209e9, "n": 1.5}
    )
    report("painleve-sym", ps.__version__, settings)
