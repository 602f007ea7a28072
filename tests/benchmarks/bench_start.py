"""How long from nothing, and from the cache, to the first trajectory of a mechanism?

``python -m tests.benchmarks.bench_start`` starts a process with an empty cache and two with a full
one, and prints what each stage took in the first and in the last: loading the modules, building
the mechanism, and from there to the first trajectory (derivation, compilation, run). CPU time of
the process and of its compiler stands beside the clock, which other work on the machine disturbs.
Then come whole commands with a full cache, beside ``python -c "import numpy"``.
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
TABLE_3 = ("--state", "theta=1,theta_dot=1,x_A_dot=-1")
COMMANDS = {
    "models": ("models",),
    "laws": ("laws",),
    "classify": ("classify", "rod", *TABLE_3),
    "jump": ("jump", "rod", *TABLE_3),
    "simulate": ("simulate", "rod", *TABLE_3, "--law", "bilinear-hertz", "--t-end", "0.01"),
}
COMMAND_RATIO = 4.0
"""Most that a command may take, in parts of the time that importing NumPy takes."""

STAGES = ("import", "mechanism", "first run", "next run")


def _python(cache: str, *arguments: str, **variables: str) -> str:
    """Return what a Python process with that cache and environment prints."""
    environment = {**os.environ, "PAINLEVE_CACHE": cache, **variables}
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
    command = [sys.executable, *arguments]
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, check=True
    ).stdout


def _modules(folder: str) -> dict[str, str]:
    """Return variables with which modules are compiled once, as after an installation."""
    return {"PYTHONPYCACHEPREFIX": f"{folder}/modules", "PYTHONDONTWRITEBYTECODE": ""}


def commands(repeats: int = 5) -> dict[str, dict[str, float]]:
    """Print and return the least processor time of each command with a full cache, s.

    With its ratio to that of importing NumPy; they take turns.
    """
    calls = {"import numpy": ("-c", "import numpy")}
    calls |= {name: ("-m", "painleve_sym", *words) for name, words in COMMANDS.items()}
    least = dict.fromkeys(calls, float("inf"))
    with tempfile.TemporaryDirectory() as folder:
        modules = _modules(folder)
        for repeat in range(repeats + 1):
            for name, arguments in calls.items():
                before = os.times()
                _python(f"{folder}/cache", *arguments, **modules)
                after = os.times()
                took = sum(after[2:4]) - sum(before[2:4])
                if repeat:  # the first fills the cache
                    least[name] = min(least[name], took)
    lines = {n: {"seconds": s, "ratio": s / least["import numpy"]} for n, s in least.items()}
    for name, line in lines.items():
        print(f"{name:14} {line['seconds']:6.3f} s, {line['ratio']:4.1f} times NumPy", flush=True)
    return lines


def test_commands_take_a_few_times_as_long_as_numpy():
    lines = commands()
    assert all(line["ratio"] < COMMAND_RATIO for line in lines.values())


def start(model: str, law: str, cache: str, modules: dict[str, str]) -> dict[str, Any]:
    """Return the end state and, per stage, seconds by the clock and of the processor."""
    result = json.loads(_python(cache, "-c", CHILD, model, law, **modules))
    pairs = zip(result["stages"], result["stages"][1:], strict=False)
    seconds = [(b[0] - a[0], b[1] - a[1]) for a, b in pairs]
    return {"end": result["end"], **dict(zip(STAGES, seconds, strict=True))}


def measure(model: str, law: str) -> dict[str, dict[str, float]]:
    """Print and return seconds by the clock; `total` is from the mechanism to the first run."""
    with tempfile.TemporaryDirectory() as folder:
        modules = _modules(folder)
        start(model, law, f"{folder}/first", modules)
        cold, _, warm = (start(model, law, f"{folder}/cache", modules) for _ in range(3))
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
    commands()
