"""How long from nothing, and from the cache, to the first trajectory of a mechanism?

``python -m tests.benchmarks.bench_start`` starts a process with an empty cache and two with a full
one, and prints what each stage took in the first and in the last: loading the modules, building
the mechanism, and from there to the first trajectory (derivation, compilation, run). CPU time of
the process and of its compiler stands beside the clock, which other work on the machine disturbs.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from typing import Any

CASES = (("rod", "bilinear-hertz"), ("rod", "rigid"))
CASES += (("two-link-arm", "bilinear-hertz"), ("two-link-arm", "rigid"))

CHILD = """
import json, os, sys, time
def now():
    t = os.times()
    return time.perf_counter(), t.user + t.system + t.children_user + t.children_system
stages = [now()]
import sympy.tensor.tensor  # SymPy loads it at the first sum of expressions
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym import Simulator, Simulator, law, model
stages.append(now())
mechanism = model(sys.argv[1])
stages.append(now())
rigid = sys.argv[2] == "rigid"
made = Simulator(mechanism, RigidLaw()) if rigid else Simulator(mechanism, law(sys.argv[2]))
trajectory = made.run(mechanism.start, t_end=1e-3)
stages.append(now())
again = made.run(mechanism.start, t_end=1e-3)
stages.append(now())
end = [v.hex() for v in trajectory.final_state]
print(json.dumps({"stages": stages, "end": end}))
"""
STAGES = ("import", "mechanism", "first run", "next run")


def start(model: str, law: str, cache: str) -> dict[str, Any]:
    """Return the end state and, per stage, seconds by the clock and of the processor."""
    environment = {**os.environ, "PAINLEVE_CACHE": cache}
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
    command = [sys.executable, "-c", CHILD, model, law]
    answer = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    result = json.loads(answer.stdout)
    pairs = zip(result["stages"], result["stages"][1:], strict=False)
    seconds = [(b[0] - a[0], b[1] - a[1]) for a, b in pairs]
    return {"end": result["end"], **dict(zip(STAGES, seconds, strict=True))}


def measure(model: str, law: str) -> dict[str, dict[str, float]]:
    """Print and return seconds by the clock; `total` is from the mechanism to the first run."""
    with tempfile.TemporaryDirectory() as cache:
        cold = start(model, law, cache)
        start(model, law, cache)
        warm = start(model, law, cache)
    seconds = {}
    for name, times in (("from nothing", cold), ("from the cache", warm)):
        cells = [f"{s} {times[s][0]:8.4f} ({times[s][1]:6.2f})" for s in STAGES]
        print(f"{model:14} {law:15} {name:15} {'  '.join(cells)} s", flush=True)
        seconds[name] = {s: times[s][0] for s in STAGES}
        seconds[name]["total"] = seconds[name]["mechanism"] + seconds[name]["first run"]
    assert warm["end"] == cold["end"]
    return seconds


if __name__ == "__main__":
    for case in CASES:
        measure(*case)
