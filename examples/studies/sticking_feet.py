"""A block slides to rest on two soft feet: when does each foot stick, and does it stay stuck?

Rigid feet stop together at v/(mu g) and stick for good, with tangential forces that rigid-body
mechanics leaves open. On linear springs with dashpots, the end of friction's steady pull lets the
block rock: the load moves from foot to foot, and each foot sticks and slips in turn until the
rocking has died out. The first stop tends to the rigid one as the feet stiffen.

`... sticking_feet.py STEM` draws the motion at k = 2000 N/m to STEM.png and STEM.svg, and keeps
the table in STEM.json. SI units.
"""

import json
import sys
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

import painleve_sym as ps
from painleve_sym.present.style import DASHES, PAGE, PALETTE, REFERENCE, STYLE, save

MU, SPEED, T_END = 0.3, 0.5, 0.4
FEET = {2e3: 10.0, 2e4: 30.0, 2e5: 100.0}  # stiffness k in N/m: damping c in N s/m
LEVEL = {"beta": 0.0, "mu_A": MU, "mu_B": MU}

BLOCK = ps.model("block-two-feet")
SOFT = ps.Simulator(BLOCK, ps.law("linear"))
GIVEN = {p.name: p.default for p in BLOCK.system.parameters}


def rigid_forces() -> list[float]:
    """Return the normal forces of rigid feet while the block slides, and where it stops."""
    state = {"x_A_dot": -SPEED}
    (solution,) = ps.classify(BLOCK, state, parameters=LEVEL).solutions
    return [float(force) for force in solution.normal_forces]


def slide(k: float, t_end: float = T_END) -> ps.Trajectory:
    """Return the motion from steady sliding: each foot compressed by its rigid force."""
    deep_A, deep_B = (force / k for force in rigid_forces())
    tilt = np.arcsin((deep_A - deep_B) / (2 * GIVEN["a"]))
    state = {"x_A_dot": -SPEED, "y_A": -deep_A, "theta": tilt}
    return SOFT.run(state, t_end=t_end, parameters=LEVEL | {"k": k, "c": FEET[k]})


def sticking(run: ps.Trajectory, foot: int) -> list[tuple[float, float]]:
    """Return the intervals in which a foot sticks; s."""
    intervals: list[tuple[float, float]] = []
    for segment in run.segments:
        if not segment.mode.split(" + ")[foot].startswith("stick"):
            continue
        if intervals and intervals[-1][1] == segment.t_start:
            intervals[-1] = (intervals[-1][0], segment.t_end)
        else:
            intervals.append((segment.t_start, segment.t_end))
    return intervals


def figure(run: ps.Trajectory, stop: float) -> Figure:
    """Return normal forces, and friction as a part of its limit, over time."""
    times = np.linspace(0.1, run.final_time, 2000)
    with rc_context(STYLE):
        drawn = Figure(figsize=(PAGE, 0.62 * PAGE), layout="constrained")
        forces, parts = drawn.subplots(2, 1, sharex=True)
        outputs = run.outputs(times)
        for i, foot in enumerate("AB"):
            normal, friction = outputs[f"normal_force_{foot}"], outputs[f"tangential_force_{foot}"]
            style = {"color": PALETTE[i + 1], "linestyle": DASHES[i]}
            forces.plot(times, normal, label=f"foot {foot}", **style)
            forces.axhline(rigid_forces()[i], color=REFERENCE, linestyle=DASHES[3], linewidth=0.8)
            parts.plot(times, friction / (MU * normal), **style)
            for start, end in sticking(run, i):
                parts.plot([start, end], [-1.18 - 0.13 * i] * 2, color=PALETTE[i + 1], linewidth=3)
        for axes in (forces, parts):
            axes.axvline(stop, color=REFERENCE, linewidth=0.8)
        forces.set(ylabel="$F_n$ (N)", ylim=(0, None))
        forces.legend(loc="center left")
        forces.set_title("(a) normal forces; dotted: rigid feet in slip; line: rigid feet stop")
        parts.set(xlabel="$t$ (s)", ylabel=r"$F_t/(\mu F_n)$", ylim=(-1.45, 1.1))
        parts.set_title("(b) friction as a part of its limit; bars: the foot sticks")
    return drawn


STOP = SPEED / (MU * GIVEN["g"])
KEPT = []
print(f"rigid feet stop together at {STOP:.6f} s")
print("  k [N/m]  foot  first stop [s]  sticks  last stick from [s]  stick time [s]")
for k in FEET:
    run = slide(k)
    for i, foot in enumerate("AB"):
        stuck = sticking(run, i)
        total = sum(end - start for start, end in stuck)
        KEPT.append([k, foot, stuck[0][0], len(stuck), stuck[-1][0], total])
        print(
            f"{k:9.0e}  {foot:>4}  {stuck[0][0]:14.6f}  {len(stuck):6d}"
            f"  {stuck[-1][0]:19.6f}  {total:14.6f}"
        )
if len(sys.argv) > 1:
    save(figure(slide(2e3), STOP), Path(sys.argv[1]))
    computed = {"version": ps.__version__, "law": SOFT.law.name, "n": 1}
    text = json.dumps({"computed": computed, "stop": STOP, "rows": KEPT}, indent=1) + "\n"
    Path(sys.argv[1]).with_suffix(".json").write_text(text, "utf-8")
