"""The rod in MuJoCo: two slides and a hinge, a small sphere at the end, a plane."""

import math

import mujoco
from rod import MU, G, J, L, M, report

RADIUS = 1e-3


def xml(h, q, option, contact, mu):
    """Return the text of the model at a position of the rod."""
    x, z = -L + RADIUS * math.sin(q[2]), RADIUS * math.cos(q[2])
    return f"""<mujoco><option timestep="{h!r}" gravity="0 0 -{G}" {option}/><worldbody>
      <geom type="plane" size="9 9 1" friction="{mu} 0 0" {contact(h)}/>
      <body><inertial pos="0 0 0" mass="{M}" diaginertia="{J!r} {J!r} {J!r}"/>
        <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
        <joint type="hinge" axis="0 -1 0"/>
        <geom type="sphere" size="{RADIUS}" pos="{x!r} 0 {z!r}" friction="{mu} 0 0"
          {contact(h)}/></body></worldbody></mujoco>"""


def maker(option, contact, mu=MU):
    """Return a function that makes the model with options, attributes of contacts, and friction."""

    def make(h, q, u):
        model = mujoco.MjModel.from_xml_string(xml(h, q, option, contact, mu))
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = q, u

        def step():
            mujoco.mj_step(model, data)
            return data.qpos.tolist(), data.qvel.tolist()

        return step

    return make


STIFF = 'cone="elliptic" tolerance="0" iterations="1000"'
"""Options of the model whose contacts are as stiff as the step allows."""


def stiff_contact(h):
    """Return the attributes of such a contact for steps of length h."""
    return f'condim="3" solref="{2 * h!r} 1" solimp="0.9999 0.9999 0.001"'


if __name__ == "__main__":
    settings = {
        "defaults": maker("", lambda h: 'condim="3"'),
        "elliptic cone, solref = 2h": maker(STIFF, stiff_contact),
    }
    report("MuJoCo", mujoco.__version__, settings)
