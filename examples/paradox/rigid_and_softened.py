"""How close is rigid theory, impact included, to a very stiff contact over a whole fall?

The rod starts in the inconsistent state of Table 3 (theta = 1 rad, theta_dot = 1 rad/s, sliding
left at 1 m/s) and ends lying flat at theta = pi. Times in s.
"""

import painleve_sym as ps

rod = ps.model("rod")
state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
rigid = ps.simulate(rod, "rigid", state, t_end=5.0)
print(f"rigid:          flat at {rigid.final_time:.6f} s after {len(rigid.events)} events")
simulator = ps.Simulator(rod, ps.law("bilinear-hertz"))
for E in (20.9e12, 20.9e14, 20.9e16):
    run = simulator.run(state, t_end=5.0, parameters={"E": E})
    print(f"E = {E:8.2e} Pa: flat at {run.final_time:.6f} s after {len(run.events)} events")
