"""The page of a robot's contact: mobility, thresholds, distribution over poses, assumptions."""

from __future__ import annotations

import math

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.present.figure_of_risk import risk_figure
from painleve_sym.present.figure_of_risk_trajectory import risk_trajectory_figure
from painleve_sym.present.page import HtmlPage, PageSection, figure, paragraph, table
from painleve_sym.present.style import svg_text
from painleve_sym.problem.risk import slip_angle
from painleve_sym.quantities import ROUNDING
from painleve_sym.robots.report import RiskReport
from painleve_sym.robots.trajectory import RiskTrajectory


def risk_page(report: RiskReport, motion: RiskTrajectory | None = None) -> HtmlPage:
    """Return the page of the risk of a contact at its pose, over its poses, and along a motion."""
    risk = report.risk
    bounded = math.isfinite(risk.mu_P)
    lead = paragraph(
        f"Up to a friction coefficient of {risk.mu_P:.4g} the rigid contact has one answer at this "
        "pose while it slides, whatever the direction of slip. Above it there are directions of "
        "slip for which it has none or several (A < 0)."
        if bounded
        else "Whatever its friction, the rigid contact has one answer at this pose while it "
        "slides: tangential forces do not move it along its normal (w = 0)."
    )
    if risk.sector is not None:
        degrees = f"{math.degrees(risk.sector.half_angle):.3g}°"
        lead += paragraph(
            f"With μ = {risk.mu:g}, slip within {degrees} of the worst direction is inside it."
        )
    elif risk.mu is not None:
        lead += paragraph(f"With μ = {risk.mu:g} no slip at this pose is inside the paradox.")
    lead += "".join(paragraph(notice) for notice in report.notices)
    rows: list[tuple[str, object]] = [
        ("μ_P at this pose", _shown(risk.mu_P)),
        ("least μ_P of all surface normals", _shown(risk.least_over_normals)),
    ]
    if bounded:
        world = ", ".join(f"{v:.6g}" for v in _cleaned(risk.worst_direction, 1.0))
        rows[1:1] = [
            ("worst direction of slip, from t1 towards t2, rad", slip_angle(risk.direction)),
            ("worst direction of slip in the world", world),
        ]
    if risk.mu is not None:
        rows.insert(0, ("friction coefficient μ", risk.mu))
    if risk.impact is not None:
        rebound, _, _ = risk.impact.velocity
        rows.append(("P_n of the impact of slip at 1 m/s there, N s", risk.impact.normal_impulse))
        rows.append(("v_n after it, energetic with e = 0.75, m/s", rebound))
    if report.least is not None:
        least = _shown(report.least.mu_P)
        rows.append(("least μ_P that a search over joint limits reached", least))
    if report.share_at_risk is not None:
        rows.append(("share of random poses with μ_P < μ", report.share_at_risk))
    axes = ("n", "t1", "t2")
    W = _cleaned(risk.W, float(np.trace(risk.W))).tolist()
    mobility = [(axis, *row) for axis, row in zip(axes, W, strict=True)]
    gradient = np.array(list(risk.gradient.values()))
    sizes = _cleaned(gradient, float(np.abs(gradient).max(initial=0.0))).tolist()
    slopes = [(n, g, f"1/{report.units[n]}") for n, g in zip(risk.gradient, sizes, strict=True)]
    parts = [
        PageSection(
            "Robot, contact and pose", table(("part", "value"), report.subject.rows, "subject")
        ),
        PageSection("Thresholds of friction", table(("quantity", "value"), rows, "thresholds")),
        PageSection("Mobility W, 1/kg", table(("row", *axes), mobility, "mobility")),
    ]
    if bounded:
        shown = table(("joint", "derivative", "unit"), slopes, "derivatives")
        parts.append(PageSection("Derivatives of μ_P by joint values", shown))
    if np.isfinite(report.distribution).any():
        drawing = svg_text(risk_figure(report), "risk", "Share of poses below each threshold")
        caption = f"Share of {len(report.distribution)} random poses with a smaller μ_P."
        parts.append(PageSection("All poses", figure(drawing, caption)))
    if report.least is not None:
        pose = list(report.least.joints.items())
        parts.append(
            PageSection("Pose with the least μ_P", table(("joint", "value"), pose, "worst pose"))
        )
    if motion is not None:
        parts.append(PageSection("Along the motion", _along(motion)))
    return HtmlPage(report.title, lead, parts)


def _cleaned(values: Array, size: float) -> Array:
    """Return numbers with 0 in place of the rounding of a size."""
    return np.where(np.abs(values) <= ROUNDING * size, 0.0, values)


def _shown(threshold: float) -> object:
    """Return a threshold as a cell, in words where no friction reaches it."""
    return threshold if math.isfinite(threshold) else "infinite: no friction is enough"


def _along(motion: RiskTrajectory) -> str:
    """Return the numbers of a motion, its cases, its notices and its figure."""
    rows: list[tuple[str, object]] = [
        ("samples", len(motion.t)),
        ("share of the time in which the contact touches", motion.share_closed),
    ]
    if (least := motion.least) is not None:
        rows.append(("least μ_P while it touches", _shown(float(motion.mu_P[least]))))
        rows.append(("its time, s", float(motion.t[least])))
    if motion.share_at_risk is not None:
        rows.append(("share of the time at risk", motion.share_at_risk))
    rows += [(f"share of the time: {case}", share) for case, share in motion.case_shares.items()]
    html = table(("quantity", "value"), rows, "motion")
    html += "".join(paragraph(notice) for notice in motion.notices)
    if np.isfinite(motion.mu_P).any():
        drawing = svg_text(risk_trajectory_figure(motion), "motion", "μ_P along the motion")
        html += figure(drawing, "μ_P along the motion; the time at risk is shaded.")
    return html
