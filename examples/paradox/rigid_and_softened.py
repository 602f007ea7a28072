"""How close is rigid theory, impact included, to a very stiff contact over a whole fall?

The rod starts in the inconsistent state of Table 3 (theta = 1 rad, theta_dot = 1 rad/s, sliding
left at 1 m/s) and ends lying flat at theta = pi. Times in s; the figure shows the distance of the
angles in rad.
"""

import numpy as np
from matplotlib.figure import Figure

import painleve_sym as ps

rod = ps.model("rod")
state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
rigid = ps.simulate(rod, "rigid", state, t_end=5.0)
print(f"rigid:          flat at {rigid.final_time:.6f} s after {len(rigid.events)} events")
simulator = ps.Simulator(rod, ps.law("bilinear-hertz"))
figure = Figure(figsize=(5, 3), layout="constrained")
axes = figure.subplots()
axes.set(xlabel="time (s)", ylabel="distance from the rigid rod (rad)", yscale="log")
for power, style in ((13, ":"), (15, "--"), (17, "-")):
    E = float(f"2.09e{power}")
    run = simulator.run(state, t_end=5.0, parameters={"E": E})
    print(f"E = {E:8.2e} Pa: flat at {run.final_time:.6f} s after {len(run.events)} events")
    times = np.linspace(0.0, min(run.final_time, rigid.final_time), 500)[1:]
    distance = abs(run.values("theta", times) - rigid.values("theta", times))
    axes.plot(times, distance, style, label=rf"$E = 2.09\times 10^{{{power}}}$ Pa")
axes.legend()
