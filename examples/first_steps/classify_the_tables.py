"""Which of the four cases of the contact problem are the paper's Tables 1 to 4?

The rod (m = 1 kg, l = 1 m, mu = 1.4) slides left at 1 m/s; theta in rad, theta_dot in rad/s.
"""

import painleve_sym as ps

TABLES = {1: (0.5, 1.0), 2: (0.5, 5.0), 3: (1.0, 1.0), 4: (1.0, 5.0)}

rod = ps.model("rod")
for number, (theta, theta_dot) in TABLES.items():
    contact = ps.classify(rod, {"theta": theta, "theta_dot": theta_dot, "x_A_dot": -1.0})
    forces = [f"{s.mode.value} {s.normal_force:.3f} N" for s in contact.solutions]
    answers = " or ".join(forces) or "no solution"
    case = contact.case.value
    print(f"Table {number}: A = {contact.A:8.5f}, B = {contact.B:8.4f}: {case}: {answers}")
