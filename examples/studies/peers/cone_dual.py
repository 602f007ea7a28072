"""The first step of MuJoCo and of Drake's SAP from a sliding rod, over angle and friction.

    /tmp/peers/bin/python cone_dual.py

writes cone-dual.json; needs the programs of requirements.txt. Contacts are as stiff as the programs
allow. `python -m tests.benchmarks.peers_page` compares the numbers with the closed form of
docs/contact-solvers.md, which this script does not know.
"""

import json
from importlib.metadata import version
from pathlib import Path

import drake_rod
import mujoco_rod
from pydrake.multibody.plant import DiscreteContactApproximation
from rod import G, M, end_velocity, rounded, start

ANGLES = (0.3, 0.5, 0.7, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4)
FRICTIONS = (0.5, 1.0, 1.4, 2.0)
STEP = 1e-4
OUT = Path(__file__).resolve().parent / "cone-dual.json"
MAKERS = {
    "MuJoCo": lambda mu: mujoco_rod.maker(mujoco_rod.STIFF, mujoco_rod.stiff_contact, mu),
    "Drake, SAP": lambda mu: drake_rod.maker(DiscreteContactApproximation.kSap, 1e10, mu),
}
VERSIONS = {"MuJoCo": version("mujoco"), "Drake, SAP": version("drake")}


def first_step(program, theta, mu):
    """Return the normal impulse of the first step, and slip and normal velocity after it."""
    q, u = start(theta, 1.0, -1.0)
    _, after = MAKERS[program](mu)(STEP, q, u)()
    slip, normal = end_velocity(q, after)
    return {"impulse": M * (after[1] - u[1] + G * STEP), "slip": slip, "normal": normal}


def main():
    """Measure every state in both programs."""
    rows = [
        {"program": program, "theta": theta, "mu": mu}
        | {name: rounded(value) for name, value in first_step(program, theta, mu).items()}
        for program in MAKERS
        for mu in FRICTIONS
        for theta in ANGLES
    ]
    data = {"step": STEP, "versions": VERSIONS, "rows": rows}
    OUT.write_text(json.dumps(data, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
