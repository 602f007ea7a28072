"""A robot from its file: URDF or MJCF, by the root element."""

from __future__ import annotations

from pathlib import Path

from painleve_sym.errors import InputError
from painleve_sym.files import file_path
from painleve_sym.robots.mjcf import mjcf_tree
from painleve_sym.robots.tree import RobotTree
from painleve_sym.robots.urdf import urdf_tree
from painleve_sym.robots.xml_text import label, read_elements

_READERS = {"robot": urdf_tree, "mujoco": mjcf_tree}


def read_robot(path: str | Path, *, floating: bool | None = None) -> RobotTree:
    """Return the robot of a URDF or MJCF file.

    Parameters
    ----------
    path : str or Path
    floating : bool, optional
        Whether the base moves freely. By default as the file says: MJCF by a free joint; a URDF
        base floats unless its root link is called ``world`` or has no inertia.

    Raises
    ------
    InputError
        The file is not readable, not XML of one of both kinds, not a tree, or has what is not an
        inertia.
    """
    where = f"robot file {file_path(path, 'robot file')}"
    root = read_elements(path, where)
    if root.tag not in _READERS:
        raise InputError(
            f"{where}: the root element is {label(root)}, need <robot> (URDF) or <mujoco> (MJCF)."
        )
    return _READERS[root.tag](root, where, floating)
