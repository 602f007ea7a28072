"""Which pulses of the ground overturn a slender block?

A table gives the block one push, a period of a sine. The push is a formula of time with known
edges, at which steps end. Corners are rigid and do not bounce; friction keeps them in place. A weak
push does nothing, a stronger one lets the block rock until it has come to rest. From some push on
it falls back over the other corner; a still stronger one leaves it standing, since the way back
takes longer than the push, and then it falls at once. SI units.
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import painleve_sym as ps

FILE = Path("examples", "mechanisms", "block-under-a-pulse.toml")
HERE = Path.cwd()  # a folder of the repository, from where the file is looked for
BLOCK = ps.load_mechanism(next(p / FILE for p in (HERE, *HERE.parents) if (p / FILE).exists()))
SIMULATOR = ps.Simulator(BLOCK, ps.laws.rigid(e=0.0))
PUSHES = np.array([1.5, 2.5, 4.5, 6.5, 7.5, 8.5])  # largest acceleration, m/s^2
LYING = math.pi / 2

drawn = Figure(layout="constrained")
axes = drawn.subplots()
print("a [m/s^2]  impacts  largest angle [rad]  the block")
for a in PUSHES:
    run = SIMULATOR.run({}, t_end=3.0, parameters={"a": a})
    times = run.sample(400)
    angle = run.values("phi", times)
    down = np.argmax(np.abs(angle) > LYING) or len(times)
    largest = float(np.max(np.abs(angle[:down])))
    impacts = [e for e in run.events_of("impact") if e.time < times[down - 1]]
    rocks = "stands still" if largest < 1e-9 else "rocks"
    verdict = "overturns" if down < len(times) else rocks
    print(f"{a:9.1f}  {len(impacts):7d}  {largest:19.6f}  {verdict}")
    axes.plot(times[:down], angle[:down], label=f"a = {a:g} m/s²")
axes.set(xlabel="$t$ (s)", ylabel=r"$\varphi$ (rad)")
axes.legend()
