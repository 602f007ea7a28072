"""The risk of a robot's contact as C code for a controller: joint values to W, μ_P and sector."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np

from painleve_sym.c_export.export import empty_folder, write_folder
from painleve_sym.c_export.files import filled
from painleve_sym.codegen.c_functions import c_functions
from painleve_sym.escape import c_comment, c_name, c_string
from painleve_sym.robots.dynamics import BASE, NORMAL, TANGENT
from painleve_sym.robots.robot_contact import INFINITE, RobotContact
from painleve_sym.robots.tree import rotation_rpy
from painleve_sym.version import __version__

MAX_PREFIX = 40
"""Letters of the prefix of C names: C compares the first 63 of a name."""


def export_risk(contact: RobotContact, folder: Path) -> tuple[str, ...]:
    """Write the function joint values, normal → W, μ_P, direction of the worst slip.

    The normal is in the axes of the base, as a controller knows it. Locked joints keep the values
    of the pose; what the other contacts do is that of the contact.

    Parameters
    ----------
    contact : RobotContact
    folder : Path
        Made where it is absent; must be empty.

    Returns
    -------
    tuple of str
        Names of the files.

    Raises
    ------
    InputError
        The folder holds something, or cannot be written: nothing is left then.
    """
    target = empty_folder(folder)
    tree = contact.dynamics.tree
    name = _prefix(f"{tree.name}_{contact.dynamics.contacts[0].frame}")
    joints = tuple(contact.joints)
    own = [contact.dynamics.coordinates[name] for name in joints]
    function = _mobility(contact, own)
    normal = contact.axes[0]
    if tree.floating:
        normal = rotation_rpy(*(contact.values[n] for n in BASE[3:])).T @ normal
    values = {
        "name": name,
        "guard": name.upper(),
        "robot": c_comment(tree.name),
        "contact": c_comment(contact.dynamics.contacts[0].frame),
        "subject": _subject(contact),
        "version": __version__,
        "count": len(joints),
        # An array of C is not empty.
        "room": max(1, len(joints)),
        "names": ", ".join(map(c_string, joints)) or "0",
        "generated": c_functions([function]),
        "work": 1 + function.sz_w(),
        "integers": 1 + function.sz_iw(),
        "arguments": 1 + function.sz_arg(),
        "results": 1 + function.sz_res(),
        "joints": ", ".join(repr(float(contact.values[n])) for n in own) or "0",
        "infinite": repr(INFINITE),
        "normal": ", ".join(map(repr, np.asarray(normal).tolist())),
    }
    files = {f"{name}.h": "robot.h", f"{name}.c": "robot.c", "main.c": "robot_main.c"}
    write_folder(target, {file: filled(template, values) for file, template in files.items()})
    return tuple(files)


def _subject(contact: RobotContact) -> str:
    """Return the lines of a comment on what the code has of the robot: all but its arguments."""
    rows = (f"{n}: {t}" for n, t in contact.subject.rows if n not in ("normal", "tilt"))
    lines = (line for row in rows for line in textwrap.wrap(c_comment(row), 92))
    return "\n * ".join(lines)


def _prefix(text: str) -> str:
    """Return the prefix of all C names: a letter first, and of a length that any compiler keeps."""
    name = c_name(text.lower())
    return (name if name[:1].isalpha() else f"robot_{name}")[:MAX_PREFIX]


def _mobility(contact: RobotContact, coordinates: Sequence[str]) -> ca.Function:
    """Return W row by row as a function of joint values, normal and tangent in the base's axes."""
    given = (*coordinates, *NORMAL, *TANGENT)
    x = ca.SX.sym("x", len(given))
    at = dict(zip(given, ca.vertsplit(x), strict=True))
    fixed = {**contact.values, **dict.fromkeys(BASE, 0.0)}
    point = ca.vertcat(*(at.get(n, fixed.get(n, 0.0)) for n in contact.arguments))
    return ca.Function("mobility", [x], ca.cse([ca.densify(ca.vec(contact.mobility_of(point).T))]))
