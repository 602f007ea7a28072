"""Random robots as URDF, which may be written with other names and in another order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

HOSTILE = (
    *("normal_x", "normal_y", "tangent_z", "mu", "t", "base_x", "base_pitch", "base_yaw_dot"),
    *("j1", "j1_dot", "torque_j1", "torque_j2", "j1_dot_dot", "torque_j1_dot", "joint_mu"),
    *("joint_j1_dot", "I", "E", "S", "N", "pi", "lambda", "class", "None", "def", "x", "ratio"),
    *("W_0_0", "a joint", "left-knee", "2nd", "0", "knie é", "all", "none", "base", "world2", "R"),
    *("e_energetic", "e_poisson", "nu", "kappa_1", "stribeck_velocity", "torque_E", "n_dot", "gap"),
)
"""Names of other quantities, of Python and SymPy, and names that no language takes."""


@dataclass(frozen=True)
class Part:
    """A link and the joint that carries it, as XML with places for names; its parent by number."""

    link: str
    joint: str
    parent: int


def random_parts(seed: int) -> list[Part]:
    """Return two to five links of a robot, each with a joint but the first."""
    random = np.random.default_rng(seed)

    def three(scale: float = 1.0) -> str:
        return " ".join(f"{v:.6g}" for v in scale * random.normal(size=3))

    parts = []
    for k in range(random.integers(2, 6)):
        a, b, c = random.uniform(0.02, 0.03, size=3)
        inertia = f"ixx='{a:.6g}' iyy='{b:.6g}' izz='{c:.6g}' ixy='0' ixz='0' iyz='0'"
        link = (
            f"<link name='{{link}}'><inertial><origin xyz='{three(0.1)}' rpy='{three()}'/>"
            f"<mass value='{random.uniform(0.5, 3):.6g}'/><inertia {inertia}/></inertial></link>"
        )
        kind = "prismatic" if random.random() < 0.25 else "revolute"
        joint = (
            f"<joint name='{{joint}}' type='{kind}'><parent link='{{parent}}'/>"
            f"<child link='{{link}}'/><origin xyz='{three(0.3)}' rpy='{three()}'/>"
            f"<axis xyz='{three()}'/><limit lower='-1' upper='1' effort='9' velocity='9'/></joint>"
        )
        parts.append(Part(link, joint if k else "", int(random.integers(k)) if k else -1))
    return parts


def urdf(parts: list[Part], links: list[str], joints: list[str], order: list[int]) -> str:
    """Return the robot with these names, its elements in this order."""
    text = []
    for k in order:
        names = {"link": links[k], "joint": joints[k], "parent": links[parts[k].parent]}
        text += [parts[k].joint.format(**names), parts[k].link.format(**names)]
    return f"<robot name='random'>{''.join(text)}</robot>"
