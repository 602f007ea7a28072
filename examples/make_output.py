"""Write what the commands print with --json, for many mechanisms, into examples/output.

    python examples/make_output.py [MECHANISM ...]

One file per mechanism and command: examples/output/MECHANISM/COMMAND.json. The states are those in
`start` of each mechanism where nothing else is said. A new mechanism is one line in CASES.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
from pathlib import Path
from typing import Any

from painleve_sym.cli import main
from painleve_sym.codegen.named_mechanisms import model

HERE = Path(__file__).resolve().parent
OUTPUT = HERE / "output"
MAP_POINTS = "9"

# Mechanism: the two quantities of its map, their ranges, and the approach before its jump.
CASES: dict[str, tuple[str, str, dict[str, float]]] = {
    "rod": ("theta,theta_dot", "theta=0.2:1.4,theta_dot=-5:5", {}),
    "block": ("theta,theta_dot", "theta=0.1:1.4,theta_dot=-8:8", {"y_A_dot": -1.0}),
    "eccentric-disc": ("phi,phi_dot", "phi=-3:3,phi_dot=-8:8", {"y_dot": -1.0}),
    "cart-pendulum": ("phi,phi_dot", "phi=-3:3,phi_dot=-5:5", {"y_dot": -1.0}),
    "pr-robot": ("theta_dot,mu", "theta_dot=-4:4,mu=0.2:3", {"theta_dot": 1.0}),
    "strut": ("theta_dot,mu", "theta_dot=-4:4,mu=0.2:3", {"theta_dot": 1.0}),
    "two-link-arm": ("theta_1_dot,mu", "theta_1_dot=-4:4,mu=0.2:3", {"theta_1_dot": -1.0}),
    "block-two-feet": ("theta,theta_dot", "theta=-1:1,theta_dot=-8:8", {"y_A_dot": -1.0}),
    "painleve-klein": ("phi,mu", "phi=0.1:1.4,mu=0.1:3", {}),
    "mechanisms/wheel-on-slope.toml": ("phi,phi_dot", "phi=-3:3,phi_dot=-8:8", {"n_dot": -1.0}),
    "block-on-belt": ("x_dot,d", "x_dot=-1:1,d=0:5", {"y_dot": -1.0}),
    "mechanisms/belt-oscillator.toml": ("x_dot,mu", "x_dot=-1:1,mu=0.2:3", {"y_dot": -1.0}),
}


def commands(name: str) -> dict[str, list[str]]:
    """Return the command lines of a mechanism by the name of their file."""
    case = str(HERE / name) if name.endswith(".toml") else name
    start = dict(model(case).start)
    over, ranges, approach = CASES[name]
    axes = ["--over", over, "--range", ranges, "--points", MAP_POINTS]
    state = _state(start)
    held = _state({k: v for k, v in start.items() if k not in over.split(",")})
    falling = [*state, "--t-end", "0.004"]
    contacts = model(case).contacts
    # Of several contacts these commands take one.
    alone = ["--contact", contacts[0].name] if len(contacts) > 1 else []
    hit = [*_state({**start, **approach}), *alone]
    lines = {
        "derive": ["derive", case, "--format", "json"],
        "classify": ["classify", case, *state, "--json"],
        "simulate-rigid": ["simulate", case, *falling, "--law", "rigid", "--json"],
        "map": ["map", case, *axes, *held, *alone, "--json"],
    }
    if contacts[0].bilateral:
        return {**lines, "jump": ["jump", case, *hit, "--json"]}
    return {
        **lines,
        "jump": ["jump", case, *hit, "--restitution", "0.5", "--json"],
        "simulate-softened": ["simulate", case, *falling, *alone, "--law", "hertz", "--json"],
    }


def _state(values: dict[str, float]) -> list[str]:
    return ["--state", ",".join(f"{k}={v!r}" for k, v in values.items())] if values else []


def output(arguments: list[str]) -> dict[str, Any]:
    """Return the exit code of a command and what it printed, or its fault in words."""
    printed, faults = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(faults):
        code = main(arguments)
    shown = [word.removeprefix(f"{HERE}/") for word in arguments]
    report: dict[str, Any] = {"command": " ".join(["painleve", *shown]), "exit_code": code}
    if printed.getvalue():
        report["output"] = json.loads(printed.getvalue())
    if faults.getvalue():
        report["messages"] = faults.getvalue().replace(f"{HERE}/", "").splitlines()
    return report


def write(name: str, only: tuple[str, ...] = ()) -> None:
    """Write the files of one mechanism, or those of some commands."""
    folder = OUTPUT / Path(name).stem
    folder.mkdir(parents=True, exist_ok=True)
    for command, arguments in commands(name).items():
        if only and command not in only:
            continue
        text = json.dumps(output(arguments), indent=1, ensure_ascii=True)
        (folder / f"{command}.json").write_text(text + "\n", "ascii")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("mechanism", nargs="*", help=f"of {', '.join(CASES)}; by default all")
    names = parser.parse_args().mechanism or CASES
    for mechanism in names:
        if mechanism not in CASES:
            parser.error(f"unknown mechanism {mechanism!r}, need one of {', '.join(CASES)}")
    for mechanism in names:
        print(mechanism, flush=True)
        write(mechanism)
