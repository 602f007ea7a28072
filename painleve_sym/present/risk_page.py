"""The page of a robot's contact: mobility, thresholds, distribution over poses, assumptions."""

from __future__ import annotations

import math

import numpy as np

from painleve_sym.present.page import Page, Part, figure, paragraph, table
from painleve_sym.present.risk_figure import risk_figure
from painleve_sym.present.style import svg_text
from painleve_sym.robots.report import RiskReport


def risk_page(report: RiskReport) -> Page:
    """Return the page of the risk of a contact at its pose, and over its poses."""
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
    if risk.mu is not None and risk.half_angle is not None:
        degrees = f"{math.degrees(risk.half_angle):.3g}°"
        lead += paragraph(
            f"With μ = {risk.mu:g}, slip within {degrees} of the worst direction is inside it."
            if risk.half_angle
            else f"With μ = {risk.mu:g} no slip at this pose is inside the paradox."
        )
    lead += "".join(paragraph(notice) for notice in report.notices)
    rows: list[tuple[str, object]] = [
        ("μ_P at this pose", risk.mu_P),
        ("worst direction of slip, from t1 towards t2, rad", risk.direction),
        (
            "worst direction of slip in the world",
            ", ".join(f"{v:.6g}" for v in risk.worst_direction),
        ),
        ("least μ_P of all surface normals", risk.least_over_normals),
    ]
    if risk.impact is not None:
        rebound, _, _ = risk.impact.velocity
        rows.append(("P_n that stops slip at 1 m/s there, N s", risk.impact.normal_impulse))
        rows.append(("v_n after it, energetic with e = 0.75, m/s", rebound))
    if report.least is not None:
        rows.append(("least μ_P that a search over joint limits reached", report.least.mu_P))
    if report.share_at_risk is not None:
        rows.append(("share of random poses with μ_P < μ", report.share_at_risk))
    axes = ("n", "t1", "t2")
    mobility = [(axis, *row) for axis, row in zip(axes, risk.W.tolist(), strict=True)]
    slopes = [(n, g, f"1/{report.units[n]}") for n, g in risk.gradient.items()]
    parts = [
        Part("Thresholds of friction", table(("quantity", "value"), rows, "thresholds")),
        Part("Mobility W, 1/kg", table(("row", *axes), mobility, "mobility")),
    ]
    if bounded:
        shown = table(("joint", "derivative", "unit"), slopes, "derivatives")
        parts.append(Part("Derivatives of μ_P by joint values", shown))
    if np.isfinite(report.distribution).any():
        drawing = svg_text(risk_figure(report), "risk", "Share of poses below each threshold")
        caption = f"Share of {len(report.distribution)} random poses with a smaller μ_P."
        parts.append(Part("All poses", figure(drawing, caption)))
    if report.least is not None:
        pose = list(report.least.joints.items())
        parts.append(Part("Pose with the least μ_P", table(("joint", "value"), pose, "worst pose")))
    return Page(report.title, lead, parts)
