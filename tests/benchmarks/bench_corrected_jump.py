"""What does one jump at finite stiffness cost, over arrays of cases?

CPU time of the best of many passes in one run: other work on the machine
adds to every other measure.
"""

import time

import numpy as np

from painleve_sym.motion.frozen_impact import FrozenImpactSolver
from tests.support.frozen_impacts import LOADED, OBLIQUE, ROD, inputs
from tests.support.paper_law import paper_law

CASES = 1000
LIMIT = 1e-4
"""One impact of Table 3 of the paper; s."""


def cpu_seconds(case, passes=20):
    """Return CPU time per case of the best pass."""
    solver = FrozenImpactSolver(paper_law())
    arrays = inputs({**case, "slip_velocity": np.linspace(-1, -0.5, CASES)})
    best = np.inf
    for _ in range(passes):
        start = time.process_time()
        solver(*arrays)
        best = min(best, time.process_time() - start)
    return best / CASES


def measure():
    """Print and return CPU time of one evaluation by the kind of start; s."""
    seconds = {}
    for name, case in {"from rest": ROD, "oblique": OBLIQUE, "loaded": LOADED}.items():
        seconds[name] = cpu_seconds(case)
        print(f"{name:10s} {1e6 * seconds[name]:6.2f} us")
    return seconds


if __name__ == "__main__":
    measure()
