"""The rod in MuJoCo: two slides and a hinge, a small sphere at the end, a plane."""

import math

import mujoco
from rod import MU, G, J, L, M, report

RADIUS = 1e-3


def maker(option, contact):
    """Return a function that makes the model with options, and contact attributes of the step."""

    def make(h, q, u):
        x, z = -L + RADIUS * math.sin(q[2]), RADIUS * math.cos(q[2])
        xml = f"""<mujoco><option timestep="{h!r}" gravity="0 0 -{G}" {option}/><worldbody>
          <geom type="plane" size="9 9 1" friction="{MU} 0 0" {contact(h)}/>
          <body><inertial pos="0 0 0" mass="{M}" diaginertia="{J!r} {J!r} {J!r}"/>
            <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
            <joint type="hinge" axis="0 -1 0"/>
            <geom type="sphere" size="{RADIUS}" pos="{x!r} 0 {z!r}" friction="{MU} 0 0"
              {contact(h)}/></body></worldbody></mujoco>"""
        model = mujoco.MjModel.from_xml_string(xml)
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = q, u

        def step():
            mujoco.mj_step(model, data)
            return data.qpos.tolist(), data.qvel.tolist()

        return step

    return make


if __name__ == "__main__":
    stiff = 'solimp="0.9999 0.9999 0.001"'
    settings = {
        "defaults": maker("", lambda h: 'condim="3"'),
        "elliptic cone, solref = 2h": maker(
            'cone="elliptic" tolerance="0" iterations="1000"',
            lambda h: f'condim="3" solref="{2 * h!r} 1" {stiff}',
        ),
    }
    report("MuJoCo", mujoco.__version__, settings)
