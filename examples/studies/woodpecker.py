"""The woodpecker toy hacks down its pole: which limit cycle has each reading of an impact?

The sleeve clamps and slides on the pole, and the beak hits it. Only the beak rebounds: three rigid
contacts with the coefficients of restitution 0.5, 0, 0. The beak slides down the pole when it hits
and up when it leaves, so that the two readings of Newton's law differ: friction against the slip
of each moment (Routh), or against the slip after the impact (Moreau).

`... woodpecker.py STEM` draws the cycles to STEM.png and STEM.svg, and keeps the table in
STEM.json. SI units.
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

import painleve_sym as ps
from painleve_sym.present.style import DASHES, PAGE, PALETTE, STYLE, save

RESTITUTION = {"beak": 0.5, "low": 0.0, "up": 0.0}
READINGS = {"path": "along the path", "final_slip": "by the final slip"}
T_END, CYCLES = 4.0, 10


def fall(reading: str) -> ps.Trajectory:
    """Return the motion from the mechanism's own start."""
    laws = {
        name: ps.RigidLaw("newton", e=e, impact_friction=reading) for name, e in RESTITUTION.items()
    }
    return ps.simulate("woodpecker", laws, t_end=T_END)


def beak_hits(run: ps.Trajectory) -> list[Any]:
    """Return the impacts in which the beak has a normal impulse."""
    return [event for event in run.events_of("impact") if event.impulses[0] > 0]


def cycle(run: ps.Trajectory) -> dict[str, float]:
    """Return means of the last cycles, and the sleeve's rate after the first hit of the beak."""
    hits = beak_hits(run)
    last = hits[-CYCLES - 1 :]
    return {
        "period": (last[-1].time - last[0].time) / CYCLES,
        "fall": (last[0].state["y"] - last[-1].state["y"]) / CYCLES,
        "sleeve_after_first_hit": hits[0].state["a_dot"],
    }


def figure(runs: dict[str, ps.Trajectory]) -> Figure:
    """Return the phase plane of the bird and the angle of the sleeve over one cycle."""
    with rc_context(STYLE):
        drawn = Figure(figsize=(PAGE, 0.45 * PAGE), layout="constrained")
        plane, angle = drawn.subplots(1, 2)
        for i, (reading, run) in enumerate(runs.items()):
            begin, end = (event.time for event in beak_hits(run)[-2:])
            t = np.linspace(begin, end, 4000)
            b, b_dot, a = (run.values(name, t) for name in ("b", "b_dot", "a"))
            style = {"color": PALETTE[i + 1], "linestyle": DASHES[i]}
            plane.plot(b, b_dot, label=READINGS[reading], **style)
            angle.plot(1e3 * (t - begin), a, **style)
        plane.set(xlabel=r"$\beta$, bird (rad)", ylabel=r"$\dot\beta$ (rad/s)")
        plane.set_title("(a) limit cycle of the bird")
        plane.legend(loc="center")
        angle.set(xlabel="$t$ after a hit of the beak (ms)", ylabel=r"$\alpha$, sleeve (rad)")
        angle.set_title("(b) the sleeve clamps at both edges")
    return drawn


RUNS = {reading: fall(reading) for reading in READINGS}
KEPT = {reading: cycle(run) for reading, run in RUNS.items()}
print("reading            period [s]  fall [mm]  sleeve after the first hit [rad/s]")
for reading, row in KEPT.items():
    print(
        f"{READINGS[reading]:17s}  {row['period']:.6f}    {1e3 * row['fall']:.3f}"
        f"     {row['sleeve_after_first_hit']:.3f}"
    )
if len(sys.argv) > 1:
    save(figure(RUNS), Path(sys.argv[1]))
    computed = {"version": ps.__version__, "law": "rigid, newton, e = 0.5, 0, 0"}
    text = json.dumps({"computed": computed, "cycles": KEPT}, indent=1) + "\n"
    Path(sys.argv[1]).with_suffix(".json").write_text(text, "utf-8")
