"""Run the rod in every program that is installed, and write results.json.

    python -m venv /tmp/peers && /tmp/peers/bin/pip install -r requirements.txt
    python run_all.py --peers /tmp/peers/bin/python --siconos /usr/bin/python3

This Python needs the package alone. A program that is missing becomes a line that says so. nosnoc
takes minutes, all others seconds.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results.json"
PROGRAMS = {
    "painleve-sym": "painleve_rod.py",
    "Siconos": "siconos_rod.py",
    "Drake": "drake_rod.py",
    "MuJoCo": "mujoco_rod.py",
    "Bullet (pybullet)": "pybullet_rod.py",
    "nosnoc": "nosnoc_rod.py",
}
ABSENT = {"Chrono": "not installed: its Python package comes through conda only"}
"""Programs without a script here, and the reason."""


def run(program, python):
    """Return what the script of a program prints last, or why it does not run."""
    command = [python, str(HERE / PROGRAMS[program])]
    done = subprocess.run(command, capture_output=True, text=True, cwd=HERE)
    lines = done.stdout.splitlines()
    if done.returncode == 0 and lines:
        return json.loads(lines[-1])
    last = (done.stderr.strip().splitlines() or ["no message"])[-1]
    absent = "ModuleNotFoundError" in last
    return {"program": program, "missing": f"{'not installed' if absent else 'failed'}: {last}"}


def main():
    """Run all of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--peers", default=sys.executable, help="Python with requirements.txt")
    parser.add_argument("--siconos", default=sys.executable, help="Python with Siconos")
    parser.add_argument("--out", type=Path, default=RESULTS)
    o = parser.parse_args()
    pythons = {"painleve-sym": sys.executable, "Siconos": o.siconos}
    results = []
    for program in PROGRAMS:
        results.append(run(program, pythons.get(program, o.peers)))
        print(program, results[-1].get("version", results[-1].get("missing")), flush=True)
    results += [{"program": name, "missing": reason} for name, reason in ABSENT.items()]
    o.out.write_text(json.dumps(results, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
