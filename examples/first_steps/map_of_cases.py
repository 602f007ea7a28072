"""For which angles and angular velocities does the sliding rod have no solution, or two?

The rod of the paper, mu = 1.4, sliding left. The map shows the case of the contact problem; the
lines are A = 0 and B = 0, the arrows the motion of the sliding rod.
"""

import painleve_sym as ps
from painleve_sym.present.figure_of_map import map_figure

ranges = {"theta": (0.1, 1.5), "theta_dot": (-6.0, 6.0)}
regions = ps.region_map("rod", ("theta", "theta_dot"), ranges=ranges, points=200)
points = sum(regions.counts.values())
for case, count in regions.counts.items():
    print(f"{case:14s} {100 * count / points:6.2f} %")
figure = map_figure(regions)
