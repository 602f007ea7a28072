"""Which of the four cases of the contact problem are the paper's Tables 1 to 4?

The rod (m = 1 kg, l = 1 m, mu = 1.4) slides left at 1 m/s; theta in rad, theta_dot in rad/s.
A solution is a point of the line a_n = A F_n + B on one of the two axes.
"""

from matplotlib.figure import Figure

import painleve_sym as ps

TABLES = {1: (0.5, 1.0), 2: (0.5, 5.0), 3: (1.0, 1.0), 4: (1.0, 5.0)}

figure = Figure(figsize=(6, 4.5), layout="constrained")
panels = figure.subplots(2, 2).ravel()
rod = ps.model("rod")
for number, (theta, theta_dot) in TABLES.items():
    contact = ps.classify(rod, {"theta": theta, "theta_dot": theta_dot, "x_A_dot": -1.0})
    forces = [f"{s.mode.value} {s.normal_force:.3f} N" for s in contact.solutions]
    answers = " or ".join(forces) or "no solution"
    case = contact.case.value
    print(f"Table {number}: A = {contact.A:8.5f}, B = {contact.B:8.4f}: {case}: {answers}")
    reach = 500.0 if number > 2 else 10.0
    axes = panels[number - 1]
    axes.axhline(0, color="0.6", linewidth=0.8)
    axes.plot([0, reach], [contact.B, contact.A * reach + contact.B])
    for solution in contact.solutions:
        axes.plot(solution.normal_force, solution.normal_acceleration, "o", color="C3")
    axes.set(title=f"Table {number}: {case}", xlabel="$F_n$ (N)", ylabel="$a_n$ (m/s²)")
