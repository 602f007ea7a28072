"""All that the command `robot` says of a contact: its risk at a pose, and over all poses."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.robots.contact_mechanism import CAVEATS
from painleve_sym.robots.contact_risk import ContactRisk, LeastRisk
from painleve_sym.robots.contact_subject import ContactSubject
from painleve_sym.robots.robot_contact import POSES, RobotContact


@dataclass(frozen=True, eq=False)
class RiskReport(Compared):
    """The risk of a contact at its pose, and over all poses within limits.

    Attributes
    ----------
    title : str
    subject : ContactSubject
        What all this is of.
    risk : ContactRisk
    least : LeastRisk or None
        None where no joint has a range.
    distribution : ndarray, shape (poses,)
        μ_P at random poses; nan where the contact cannot move.
    share_at_risk : float or None
        Part of these poses with μ_P < μ; None without a friction coefficient.
    units : dict of str to str
        Of the joints.
    notices : tuple of str
    """

    title: str
    subject: ContactSubject
    risk: ContactRisk
    least: LeastRisk | None
    distribution: Array
    share_at_risk: float | None
    units: dict[str, str]
    notices: tuple[str, ...] = field(default=())

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        return (
            {"subject": self.subject.to_dict(), "mu": self.risk.mu}
            | self.risk.to_dict()
            | {
                "least": None if self.least is None else self.least.to_dict(),
                "share_at_risk": self.share_at_risk,
            }
        )


def risk_report(contact: RobotContact, mu: float | None, count: int | None = None) -> RiskReport:
    """Return the risk of a contact at its pose, and over random poses."""
    risk = contact.risk(mu)
    poses = contact.random_poses(count or POSES)
    least, share, distribution = None, None, np.empty(0)
    if poses:
        distribution = contact.thresholds(poses)
        least = contact.least(poses)
        if mu is not None:
            share = float(np.mean(distribution < mu))
    units = {name: joint.unit for name, joint in contact.joints.items()}
    return RiskReport(
        contact.title,
        contact.subject,
        risk,
        least,
        distribution,
        share,
        units,
        (*contact.dynamics.notices, *_limits_of_friction(contact, risk), " ".join(CAVEATS)),
    )


def _limits_of_friction(contact: RobotContact, risk: ContactRisk) -> tuple[str, ...]:
    """Return a notice with both limits of joints with dry friction: they move, or are held."""
    dynamics = contact.dynamics
    dry = dynamics.tree.dry_joints - dynamics.locked
    if not dry:
        return ()
    locked = dynamics.locked | dry
    held = "nothing moves"
    if dynamics.tree.floating or set(dynamics.tree.joints) - locked:
        other = replace(contact, dynamics=replace(dynamics, locked=locked))
        try:
            held = f"mu_P = {other.risk().mu_P:.6g}"
        except InputError:
            held = "the contact cannot move along its normal"
    return (
        f"Joints with dry friction ({len(dry)}): mu_P = {risk.mu_P:.6g} where they move freely, "
        f"which all numbers here are for; where their friction holds them, {held}.",
    )
