"""What is the least effort that brings a sliding block back to where it was?

A force u pushes a block along rough ground. The block slides away at first, must be back at rest at
a given time, and the integral of u^2 is to be least. The best way slips, sticks and slips back:
friction brakes for nothing, and while the block sticks no force is needed. CasADi and IPOPT
minimise over the equations of these modes, which `simulator.casadi` exports, with free times of
switching; `simulate` then runs the motion under this force. Pontryagin's principle gives the answer
but for the root of one equation.

`... optimal_control.py STEM` draws force and velocity to STEM.png and STEM.svg. SI units.
"""

import math
import sys
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from scipy.optimize import brentq

import painleve_sym as ps
from painleve_sym.present.style import PAGE, PALETTE, REFERENCE, STYLE, save

BLOCK = ps.load_mechanism(Path(__file__).parents[1] / "mechanisms" / "pushed-block.toml")
SIMULATOR = ps.Simulator(BLOCK, "rigid")
SPEED, END = 2.0, 4.0
SEQUENCE = ("slip_pos", "stick", "slip_neg")
NODES = 8
"""Intervals of each mode: the force is linear in each, and jumps between modes alone."""


def minimised() -> tuple[np.ndarray, list[np.ndarray], float]:
    """Return how long each mode lasts, the forces at its nodes, and the integral of u^2."""
    start = SIMULATOR.begin({"x_dot": SPEED})
    opti, effort = ca.Opti(), ca.MX(0)
    lengths, forces = opti.variable(len(SEQUENCE)), []
    state: Any = ca.DM(start.state)
    for k, name in enumerate(SEQUENCE):
        mode = SIMULATOR.casadi(name)
        z, place = np.zeros(len(mode.memory)), mode.parameters.index("u")

        def at(function: Any, x: Any, u: Any, z: Any = z, place: int = place) -> Any:
            p = ca.MX(ca.DM(start.parameters))
            p[place] = u
            return function(x, z, p)

        force, h = opti.variable(NODES + 1), lengths[k] / NODES
        forces.append(force)
        for i in range(NODES):
            u, w = force[i], force[i + 1]
            k1 = at(mode.field, state, u)
            k2 = at(mode.field, state + h / 2 * k1, (u + w) / 2)
            k3 = at(mode.field, state + h / 2 * k2, (u + w) / 2)
            k4 = at(mode.field, state + h * k3, w)
            after = opti.variable(len(start.state))
            opti.subject_to(after == state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
            effort += h / 3 * (u**2 + u * w + w**2)  # of a linear force
            if i or name == "stick":
                guards = at(mode.guards, state, u)
                opti.subject_to(guards[: 2 if name == "stick" else 1] >= 0)
            state = after
        if name != "stick":
            guards = at(mode.guards, state, force[NODES])
            opti.subject_to(guards[mode.guard_labels.index("slip_stop")] == 0)
    opti.subject_to(lengths >= 0)
    opti.subject_to(ca.sum1(lengths) == END)
    opti.subject_to(state[mode.states.index("x")] == 0)
    opti.set_initial(lengths, END / len(SEQUENCE))
    opti.minimize(effort)
    opti.solver("ipopt", {"print_time": False}, {"print_level": 0, "sb": "yes", "tol": 1e-12})
    solution = opti.solve()
    values = [np.array(solution.value(force)) for force in forces]
    return np.array(solution.value(lengths)), values, float(solution.value(effort))


def principle() -> tuple[np.ndarray, float]:
    """Return how long each mode lasts, and the integral, by Pontryagin's principle.

    With f = mu m g the way back over d from rest to rest takes tau = sqrt(6 m d/f) under a force
    that grows from -2 f to 0 in a line, and costs 4/3 f^2 tau; this is free to begin later. On the
    way out the force is -c s at the time s before the block stops, where 2 m c is the slope of that
    cost in d.
    """
    m, g, mu = (BLOCK.parameters[name] for name in ("m", "g", "mu"))
    f = mu * m * g

    def way_out(c: float) -> tuple[float, float]:
        """Return the time to stop from SPEED, and the way."""
        time = (math.sqrt(f**2 + 2 * c * m * SPEED) - f) / c
        return time, (f * time**2 / 2 + c * time**3 / 6) / m

    def difference(c: float) -> float:
        d = way_out(c)[1]
        return 2 * m * c - 2 / 3 * f**2 * math.sqrt(6 * m / (f * d))

    c = float(brentq(difference, 1e-9, 100 * f, xtol=1e-15))
    time, d = way_out(c)
    back = math.sqrt(6 * m * d / f)
    effort = c**2 * time**3 / 3 + 4 / 3 * f**2 * back
    return np.array([time, END - time - back, back]), effort


def simulated(lengths: np.ndarray, forces: list[np.ndarray]) -> tuple[ps.Trajectory, ...]:
    """Return the motion under the force up to the slip back, and from there on."""
    ends = np.cumsum(lengths)
    out = np.linspace(0.0, ends[0], NODES + 1)
    pushed = {"times": [*out, END], "values": [*forces[0], 0.0], "interpolation": "linear"}
    first = SIMULATOR.run({"x_dot": SPEED}, t_end=ends[1], inputs={"u": pushed})
    back = np.linspace(ends[1], END, NODES + 1)
    back[-1] = END
    pulled = {"times": back, "values": forces[2], "interpolation": "linear"}
    return first, first.continued(END, inputs={"u": pulled})


def figure(
    lengths: np.ndarray, forces: list[np.ndarray], runs: tuple[ps.Trajectory, ...]
) -> Figure:
    """Return force and velocity over time, with the modes."""
    ends = np.cumsum(lengths)
    with rc_context(STYLE):
        drawn = Figure(figsize=(PAGE, 0.5 * PAGE), layout="constrained")
        upper, lower = drawn.subplots(2, sharex=True)
        for k, (end, values) in enumerate(zip(ends, forces, strict=True)):
            begin = end - lengths[k]
            times = np.linspace(begin, end, NODES + 1)
            upper.plot(times, values, "o-", color=PALETTE[k], markersize=3)
            upper.text((begin + end) / 2, 0.6, SEQUENCE[k].replace("_", " "), ha="center")
        for run in runs:
            run.plot("x_dot", ax=lower, color=PALETTE[0])
        for axes in (upper, lower):
            for end in ends[:-1]:
                axes.axvline(end, color=REFERENCE, linewidth=0.6)
        upper.set(ylabel="$u$ (N)", ylim=(-4.4, 1.4))
    return drawn


if __name__ == "__main__":
    lengths, forces, effort = minimised()
    by_hand, least = principle()
    print("                    IPOPT           Pontryagin")
    for name, own, known in zip(SEQUENCE, lengths, by_hand, strict=True):
        print(f"{name:8s} lasts   {own:.10f}    {known:.10f} s")
    print(f"integral of u^2  {effort:.10f}    {least:.10f} N^2 s")
    first, rest = simulated(lengths, forces)
    stops = [e for run in (first, rest) for e in run.events_of("slip_stop")]
    starts = [e for run in (first, rest) for e in run.events_of("slip_start")]
    print(f"simulate: stops at {stops[0].time:.9f} s, slips back at {starts[-1].time:.9f} s")
    print(f"at the end x = {rest.final['x']:.1e} m, v = {rest.final['x_dot']:.1e} m/s")
    if len(sys.argv) > 1:
        save(figure(lengths, forces, (first, rest)), Path(sys.argv[1]))
