"""The command robot: at which friction the contact of a robot is at risk."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.at.classification import Classification
from painleve_sym.cli.certify import BOX, answer
from painleve_sym.cli.classify import show_solutions
from painleve_sym.cli.options import (
    FIGURES,
    figure_file,
    given_options,
    output_file,
    output_folder,
    read_look,
    read_quantities,
    read_ranges,
)
from painleve_sym.cli.output import draw, number, print_json, show, show_notices, show_table
from painleve_sym.cli.robot_options import file_options, place_options
from painleve_sym.errors import InputError
from painleve_sym.problem.risk import slip_angle
from painleve_sym.quantities import counted
from painleve_sym.robots.contact_mechanism import CAVEATS
from painleve_sym.robots.contact_risk import LeastRisk
from painleve_sym.robots.motion_log import TouchingRule, read_motion
from painleve_sym.robots.report import RiskReport, risk_report
from painleve_sym.robots.robot_contact import RobotContact
from painleve_sym.robots.robot_model import Robot
from painleve_sym.robots.robot_model import robot as read
from painleve_sym.robots.trajectory import REST_SPEED, RiskTrajectory, risk_along

if TYPE_CHECKING:
    from painleve_sym.at.positive import PositiveFunction
    from painleve_sym.certify.checker import Side

SHOWN_GRADIENT = 8
_NOT_PROVED = (
    *("velocities", "torques", "trajectory", "touching", "rest", "poses", "report", "export"),
)
"""Options of the report that a proof does not have."""


def robot(arguments: argparse.Namespace) -> int:
    """Print the risk of the contact of a robot, at a pose and over all poses, or a proof."""
    if arguments.certify:
        return _certify(arguments)
    for option in given_options(arguments, "over", "check"):
        raise InputError(f"--{option}: belongs to --certify. Fix: add --certify.")
    look = read_look(arguments)
    picture = figure_file("--out", arguments.out, look, FIGURES) if arguments.out else None
    page = output_file("--report", arguments.report, (".html",)) if arguments.report else None
    code = output_folder("--export", arguments.export) if arguments.export else None
    one, place = _read(arguments)
    contact = one.contact(arguments.contact, **place)
    motion = None
    if arguments.trajectory is not None:
        text = arguments.touching
        rule = None if text is None else TouchingRule.of(text, "--touching")
        log = read_motion(arguments.trajectory, contact, rule)
        rest = REST_SPEED if arguments.rest is None else arguments.rest
        motion = risk_along(contact, log, arguments.mu, rest)
    else:
        for option in given_options(arguments, "touching", "rest"):
            raise InputError(f"--{option}: belongs to --trajectory. Fix: name the file of a log.")
    report = risk_report(contact, arguments.mu, arguments.poses)
    solved = _answer(arguments, contact)
    if picture is not None and motion is not None:
        draw("risk_trajectory_figure", picture, look, motion)
    elif picture is not None:
        draw("risk_figure", picture, look, report)
    if page is not None:
        from painleve_sym.present.risk_page import risk_page

        risk_page(report, motion).write(page)
    if code is not None:
        from painleve_sym.c_export.robot import export_risk

        export_risk(contact, code)
    if arguments.json:
        data = report.to_dict()
        if solved is not None:
            data |= {key: solved.to_dict()[key] for key in ("contacts", "case", "solutions")}
        if motion is not None:
            data["trajectory"] = motion.to_dict()
        print_json(data | {"notices": list(report.notices)})
        return 0
    show(report.title)
    show_table(("", ""), report.subject.rows, left=(0, 1))
    if not (arguments.joints or arguments.pose):
        poses = ", ".join(one.tree.poses)
        more = f"; --pose takes {poses}" if poses else ""
        show(f"pose: every joint at 0 or at the limit nearest to it{more}")
    *of_file, caveats = report.notices
    show_notices(of_file)
    _show(report)
    if solved is not None:
        _show_answer(solved)
    if motion is not None:
        _show_motion(motion)
    show_notices([caveats])
    for path in (picture, page, code):
        if path is not None:
            show(f"written: {path}")
    return 0


def _read(arguments: argparse.Namespace) -> tuple[Robot, dict[str, Any]]:
    """Return the robot, and where its contact is."""
    one = read(arguments.file, **file_options(arguments))
    place = place_options(arguments)
    if arguments.joints:
        units = {name: joint.unit for name, joint in one.joints.items()}
        place["joints"] = read_quantities("--joints", arguments.joints, lambda: units)
    return one, place


def _certify(arguments: argparse.Namespace) -> int:
    """Prove or refute A > 0 in all poses of a box, or verify a certificate of it."""
    for option in given_options(arguments, *_NOT_PROVED):
        raise InputError(
            f"--{option}: --certify only gives a proof. Fix: leave out one of the two."
        )
    if not arguments.over:
        raise InputError(
            "--certify: needs --over, the box of poses, such as --over knee=-1.1:-0.9,hip=0.6:0.8. "
            "Joints without a range keep their value."
        )
    one, place = _read(arguments)
    contact = one.contact(arguments.contact, **place)
    units = {c.name: c.unit for c in contact.dynamics.outline.coordinates} | {"mu": "1"}
    over = read_ranges("--over", arguments.over, lambda: units, BOX)
    if twice := set(over) & set(place.get("joints", ())):
        raise InputError(f"--over: got {min(twice)} in --joints as well. Fix: give it once.")
    data = {
        "robot": one.tree.name,
        "contact": contact.dynamics.contacts[0].frame,
        "subject": contact.subject.to_dict(),
    }
    notices = (contact.subject.sentence, *contact.dynamics.notices, " ".join(CAVEATS))

    def derive(over: Mapping[str, Side]) -> PositiveFunction:
        return contact.positive_function(over, arguments.mu)

    return answer(arguments, contact.title, data, over, derive, notices)


def _answer(arguments: argparse.Namespace, contact: RobotContact) -> Classification | None:
    """Return every solution where velocities or torques are given."""
    if not (arguments.velocities or arguments.torques):
        return None
    if arguments.mu is None:
        raise InputError("--velocities, --torques: need --mu, the friction coefficient.")
    units = {name: f"{joint.unit}/s" for name, joint in contact.joints.items()}
    units |= {c.name: f"{c.unit}/s" for c in contact.dynamics.outline.coordinates}
    efforts = {n: "N m" if joint.unit == "rad" else "N" for n, joint in contact.joints.items()}
    velocities = read_quantities("--velocities", arguments.velocities, lambda: units)
    torques = read_quantities("--torques", arguments.torques, lambda: efforts)
    return contact.classify(arguments.mu, velocities, torques)


def _show_answer(answer: Classification) -> None:
    show()
    show(f"case with these velocities and torques: {answer.case.value} ({answer.case.sentence})")
    if answer.solutions:
        show_solutions(answer)


def _show_motion(motion: RiskTrajectory) -> None:
    show()
    show(
        f"along the trajectory of {counted(len(motion.t), 'sample')}: the contact touches "
        f"{100 * motion.share_closed:.3g} % of the time"
    )
    if (least := motion.least) is not None:
        show(
            f"least mu_P while it touches: {number(float(motion.mu_P[least]), 6)} at t = "
            f"{number(float(motion.t[least]))} s"
        )
    if motion.share_at_risk is not None:
        show(f"share of time at risk: {100 * motion.share_at_risk:.3g} %")
    if motion.case:
        shares = (f"{case} {100 * share:.3g} %" for case, share in motion.case_shares.items())
        show(f"cases: {', '.join(shares)} of the time")
    show_notices(motion.notices)


def _show(report: RiskReport) -> None:
    risk = report.risk
    show()
    show("mobility W with the rows n, t1, t2, 1/kg")
    size = float(np.trace(risk.W))
    rows = [[number(v, 9, size) for v in row] for row in risk.W.tolist()]
    show_table(("",) * 3, rows, left=())
    show()
    bounded = math.isfinite(risk.mu_P)
    if bounded:
        show(
            f"mu_P = W_nn/|w| = {number(risk.mu_P, 9)}: below it a sliding contact has one answer,"
        )
        show("above it there are directions of slip with A < 0")
        show(
            f"worst direction of slip: {math.degrees(slip_angle(risk.direction)):.4g} deg from t1, "
            f"{', '.join(number(v, 4, 1.0) for v in risk.worst_direction)} in the world"
        )
    else:
        show("w = 0, mu_P = inf: a sliding contact has one answer here, whatever its friction")
    if risk.mu is not None:
        inside = "below mu_P, no slip is inside the paradox"
        if risk.sector is not None:
            within = math.degrees(risk.sector.half_angle)
            inside = f"inside the paradox within {within:.4g} deg of it"
        show(f"mu = {number(risk.mu)}: {inside}")
    if risk.impact is not None:
        rebound, _, _ = risk.impact.velocity
        show(
            f"slip at 1 m/s there is an impact: P_n = {number(risk.impact.normal_impulse, 4)} N s, "
            f"rebound at {number(rebound, 4)} m/s"
        )
        show(f"({risk.impact.restitution}, e = 0.75; the command jump has its phases)")
    show(f"least mu_P of all surface normals: {number(risk.least_over_normals, 9)}")
    if bounded:
        _show_gradient(report)
    if report.least is not None:
        _show_poses(report, report.least)


def _show_gradient(report: RiskReport) -> None:
    show()
    risk = report.risk
    largest = sorted(risk.gradient.items(), key=lambda pair: -abs(pair[1]))[:SHOWN_GRADIENT]
    units = report.units
    size = max((abs(slope) for slope in risk.gradient.values()), default=0.0)
    rows = [(name, number(slope, 6, size), f"1/{units[name]}") for name, slope in largest]
    show_table(("derivative of mu_P by", "value", "unit"), rows, left=(0, 2))


def _show_poses(report: RiskReport, least: LeastRisk) -> None:
    """Print what a search over poses and random ones gave."""
    show()
    singular = "" if least.mu_P else ", beside a pose that cannot move along the normal"
    show(f"least mu_P that a search over joint limits reached: {number(least.mu_P, 6)}{singular}")
    if math.isfinite(least.mu_P):
        pose = (f"{name} = {number(v, 4, 1e3)}" for name, v in least.joints.items())
        show(f"  at {', '.join(pose)}")
    # Values of poses themselves: there is nothing between a number and infinity.
    parts = [0.05, 0.5, 0.95]
    quantiles = np.nanquantile(report.distribution, parts, method="inverted_cdf")
    listed = ", ".join(number(float(q), 4) for q in quantiles)
    show(f"mu_P of {len(report.distribution)} random poses, 5, 50 and 95 %: {listed}")
    if report.share_at_risk is not None:
        show(f"share of poses at risk: {100 * report.share_at_risk:.3g} %")
