"""Log a motion of MuJoCo for `painleve robot --trajectory`.

    python examples/studies/peers/log_motion.py [MODEL.xml] [FILE.csv]

The joints follow sines by computed torques; any other controller may take its place. The file has
the time, joint values, velocities and torques, by name. It needs MuJoCo: pip install mujoco.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import mujoco
import numpy as np

MODEL = Path(__file__).parents[2] / "robots" / "desk_arm.xml"


def main() -> None:
    """Simulate a thousand steps and write every tenth."""
    words = dict(enumerate(sys.argv[1:]))
    model = mujoco.MjModel.from_xml_path(words.get(0, str(MODEL)))
    data = mujoco.MjData(model)
    joints = [k for k in range(model.njnt) if model.jnt_type[k] != mujoco.mjtJoint.mjJNT_FREE]
    names = [model.joint(k).name for k in joints]
    q, v = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
    with open(words.get(1, "motion.csv"), "w", newline="", encoding="utf-8") as file:
        log = csv.writer(file)
        log.writerow(["t", *names, *(f"{n}_dot" for n in names), *(f"torque_{n}" for n in names)])
        mass = np.zeros((model.nv, model.nv))
        for step in range(1000):
            mujoco.mj_forward(model, data)
            mujoco.mj_fullM(model, data, mass)
            target = 0.8 * np.sin(2 * data.time + np.arange(len(joints)))
            wanted = 100 * (target - data.qpos[q]) - 20 * data.qvel[v]
            torque = mass[np.ix_(v, v)] @ wanted + data.qfrc_bias[v]
            if step % 10 == 0:
                log.writerow([data.time, *data.qpos[q], *data.qvel[v], *torque])
            data.qfrc_applied[v] = torque
            mujoco.mj_step(model, data)


if __name__ == "__main__":
    main()
