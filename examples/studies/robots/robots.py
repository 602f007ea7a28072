"""The friction from which feet and tools of real robots are at risk.

    python examples/studies/robots/robots.py [--quick] [--out FOLDER]

Each robot of the package example-robot-data (pip install example-robot-data) stands in its pose
on a level floor, and one of its contacts is judged: mu_P at the origin of its frame and, where the
file has a ball as the shape of the foot, at the lowest point of that ball; its least value over all
surface normals, and the share of random poses within joint limits with mu_P below 0.8, at the
lowest point where there is one. It prints the table of the page "Is my robot's foot at risk?", and
writes robots.json with full precision.
"""

from __future__ import annotations

import argparse
import json
import sys
import sysconfig
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

import painleve_sym as ps
from painleve_sym.robots import RobotContact

MU = 0.8


@dataclass(frozen=True)
class Case:
    """A robot of the package, its contact and its pose."""

    title: str
    file: str
    frame: str
    pose: str | None = None
    joints: dict[str, float] = field(default_factory=dict)
    floating: bool = True
    words: str = "standing"
    srdf: str | None = None


def legs(haa: float, hfe: float, kfe: float, fore_hind: tuple[str, str]) -> dict[str, float]:
    """Return the joints of four legs: outwards alike, fore and hind knees bent to each other."""
    joints = {}
    for end, sign in zip(fore_hind, (1, -1), strict=True):
        for side, out in (("L", 1), ("R", -1)):
            leg = f"{side}{end}"
            values = (out * haa, sign * hfe, sign * kfe)
            joints |= dict(zip((f"{leg}_HAA", f"{leg}_HFE", f"{leg}_KFE"), values, strict=True))
    return joints


ANYMAL = legs(-0.1, 0.7, -1.0, ("F", "H"))
CASES = (
    Case("ANYmal C", "anymal_c_simple_description/urdf/anymal.urdf", "LF_FOOT", joints=ANYMAL),
    Case("ANYmal B", "anymal_b_simple_description/robots/anymal.urdf", "LF_FOOT", "standing"),
    Case("Bolt", "bolt_description/robots/bolt.urdf", "FL_FOOT", "standing"),
    Case(
        "HyQ",
        "hyq_description/robots/hyq_no_sensors.urdf",
        "lf_foot",
        "standing",
        srdf="hyq_description/srdf/hyq.srdf",
    ),
    Case(
        "Solo 12",
        "solo_description/robots/solo12.urdf",
        "FL_FOOT",
        "standing",
        srdf="solo_description/srdf/solo.srdf",
    ),
    Case("Solo 8", "solo_description/robots/solo.urdf", "FL_FOOT", "standing"),
    Case("Go1", "go1_description/urdf/go1.urdf", "FL_foot", "standing"),
    Case("Go2", "go2_description/urdf/go2.urdf", "FL_foot", "standing"),
    Case("A1", "a1_description/urdf/a1.urdf", "FL_foot", "standing"),
    Case("B1", "b1_description/urdf/b1.urdf", "FL_foot", "standing"),
    Case(
        "Talos",
        "talos_data/robots/talos_reduced.urdf",
        "left_sole_link",
        "half_sitting",
        words="half sitting",
        srdf="talos_data/srdf/talos.srdf",
    ),
    Case(
        "UR5",
        "ur_description/urdf/ur5_robot.urdf",
        "tool0",
        joints={"shoulder_lift_joint": -1.2, "elbow_joint": 1.6},
        floating=False,
        words="bent",
    ),
    Case(
        "Panda",
        "panda_description/urdf/panda.urdf",
        "panda_hand_tcp",
        "default",
        floating=False,
        words="default",
    ),
)


def data_folder() -> Path | None:
    """Return the folder of robots of the package example-robot-data, or None."""
    places = (Path(p) for p in {*sys.path, sysconfig.get_path("platlib")} if p)
    inner = Path("cmeel.prefix", "share", "example-robot-data", "robots")
    return next((p / inner for p in places if (p / inner).is_dir()), None)


def ball_of(case: Case, folder: Path) -> tuple[list[float], float] | None:
    """Return centre in the frame, m, and radius of the ball that is the shape of a foot."""
    root = ElementTree.parse(folder / case.file).getroot()
    link = next(e for e in root.iter("link") if e.get("name") == case.frame)
    for shape in link.iterfind("collision"):
        if (ball := shape.find("geometry/sphere")) is not None:
            origin = shape.find("origin")
            place = "0 0 0" if origin is None else origin.get("xyz", "0 0 0")
            return [float(v) for v in place.split()], float(ball.get("radius", ""))
    return None


def contact_of(case: Case, folder: Path, lowest: bool = False) -> RobotContact:
    """Return the contact of a case, at the origin of its frame, or at its lowest point."""
    poses = None if case.srdf is None else folder / case.srdf
    robot = ps.robot(folder / case.file, floating=case.floating, srdf=poses)
    ball = ball_of(case, folder) if lowest else None
    place = {} if ball is None else {"point": ball[0], "radius": ball[1]}
    return robot.contact(case.frame, pose=case.pose, joints=case.joints, **place)


def row(case: Case, folder: Path, poses: int) -> dict[str, object]:
    """Return the numbers of a case."""
    at_frame, ball = contact_of(case, folder).risk(MU), ball_of(case, folder)
    contact = contact_of(case, folder, lowest=True)
    risk = contact.risk(MU)
    thresholds = contact.thresholds(contact.random_poses(poses))
    return {
        "robot": case.title,
        "contact": case.frame,
        "pose": case.words,
        "mu_P_at_frame": at_frame.mu_P,
        "mu_P_lowest": None if ball is None else risk.mu_P,
        "least_over_normals": risk.least_over_normals,
        "share_at_risk": float(np.mean(thresholds < MU)),
    }


def cells(row: dict[str, Any]) -> tuple[str, ...]:
    """Return the numbers of a row of the table."""
    lowest = row["mu_P_lowest"]
    return (
        f"{row['mu_P_at_frame']:.3f}",
        "" if lowest is None else f"{lowest:.3f}",
        f"{row['least_over_normals']:.3f}",
        f"{row['share_at_risk']:.0%}",
    )


def main() -> None:
    """Print the table and write its numbers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="the first two robots, few poses")
    parser.add_argument("--out", default="out/robots", help="folder of robots.json")
    arguments = parser.parse_args()
    folder = data_folder()
    if folder is None:
        print("The robots are not installed. Fix: pip install example-robot-data.")
        return
    cases, poses = (CASES[:2], 200) if arguments.quick else (CASES, 5000)
    rows = [row(case, folder, poses) for case in cases]
    print("| robot | contact | pose | mu_P at the frame | at the lowest point | ", end="")
    print(f"least over normals | poses with mu_P < {MU} |")
    print("|---|---|---|---|---|---|---|")
    for r in rows:
        print(f"| {r['robot']} | `{r['contact']}` | {r['pose']} | {' | '.join(cells(r))} |")
    out = Path(arguments.out)
    out.mkdir(parents=True, exist_ok=True)
    (out / "robots.json").write_text(json.dumps(rows, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
