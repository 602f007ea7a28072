"""What does a contact of steel do in a state that has no rigid solution?

The rod of Table 3 (theta = 1 rad, theta_dot = 1 rad/s, sliding left at 1 m/s) on an elasto-plastic
contact of steel: nothing collides, yet there is an impact. SI units.
"""

import painleve_sym as ps

law = ps.laws.bilinear_hertz(E=209e9)
start = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
run = ps.simulate(ps.models.rod(), law, start, t_end=1e-2)
for event in run.events:
    print(f"{event.time * 1e3:8.4f} ms  {event.kind:16s} {event.normal_force:9.2f} N")
figure = run.plot()
