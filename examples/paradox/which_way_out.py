"""The indeterminate state has two rigid solutions: which one does a compliant contact take?

Table 4 of the paper (theta = 1 rad, theta_dot = 5 rad/s, sliding left at 1 m/s), started with
different contact forces in N on steel, E = 209e9 Pa. The rigid theory says: 0 N, or 332.99 N.
"""

from matplotlib.figure import Figure

import painleve_sym as ps

rod = ps.model("rod")
simulator = ps.Simulator(rod, ps.law("bilinear-hertz"))
state = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
figure = Figure(figsize=(5, 3), layout="constrained")
axes = figure.subplots()
axes.set(xlabel="time (ms)", ylabel="normal force (N)", xlim=(0, 3), ylim=(0, 1000))
for force in (0.0, 150.0, 300.0, 306.1, 306.3, 350.0, 384.5, 500.0):
    run = simulator.run(state, t_end=5e-3, parameters={"E": 209e9}, initial_force=force)
    outcome = "impact" if run.events_of("slip_stop") else "lifts off"
    times = run.fine_times()
    forces = run.values("normal_force", times)
    peak = forces.max()
    print(f"start with {force:7.2f} N: {outcome:9s}  peak {peak:9.1f} N")
    axes.plot(times * 1e3, forces, color="C3" if outcome == "impact" else "C0")
