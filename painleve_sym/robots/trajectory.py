"""The risk of a robot's contact along a logged motion: joint positions, velocities and torques."""

from __future__ import annotations

import csv
import io
import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.checks import number
from painleve_sym.contacts.one_contact_answer import contact as contact_answer
from painleve_sym.contacts.risk import friction_threshold
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.files import read_text
from painleve_sym.robots.robot_contact import RobotContact

MAX_BYTES = 200_000_000
TIME = "t"
_UNIT = re.compile(r"\s*\[([^\]]*)\]\s*$")


@dataclass(frozen=True, eq=False)
class RiskTrajectory(Compared):
    """The risk of a contact along a motion of n samples.

    Attributes
    ----------
    t : ndarray, shape (n,)
        s.
    mu : float or None
    mu_P : ndarray, shape (n,)
    margin : ndarray, shape (n,) or None
        μ_P/μ: below 1 some direction of slip is at risk. None without a friction coefficient.
    case : tuple of str
        Case of the contact at each sample; empty without velocities, torques or friction.
    share_at_risk : float or None
        Part of the time with a margin below 1.
    """

    t: Array
    mu: float | None
    mu_P: Array
    margin: Array | None
    case: tuple[str, ...]
    share_at_risk: float | None

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, the samples included."""
        least = int(np.nanargmin(self.mu_P))
        return {
            "samples": len(self.t),
            "least_mu_P": float(self.mu_P[least]),
            "time_of_least": float(self.t[least]),
            "share_at_risk": self.share_at_risk,
            "cases": self.case_shares,
            "t": self.t.tolist(),
            "mu_P": self.mu_P.tolist(),
            "margin": None if self.margin is None else self.margin.tolist(),
            "case": list(self.case),
        }

    @property
    def case_shares(self) -> dict[str, float]:
        """Part of the time in each case."""
        shares: Counter[str] = Counter()
        for case, weight in zip(self.case, time_weights(self.t).tolist(), strict=False):
            shares[case] += weight
        return dict(shares)


def time_weights(t: Array) -> Array:
    """Return the part of the whole time that each sample stands for: half of both intervals."""
    if len(t) < 2:
        return np.ones(len(t))
    steps = np.diff(t)
    weights = np.concatenate([[0.0], steps]) + np.concatenate([steps, [0.0]])
    return np.asarray(weights / weights.sum())


def read_motion(path: str | Path, contact: RobotContact) -> dict[str, Array]:
    """Return the columns of a CSV file by name: ``t``, joint values, velocities and torques.

    A velocity is called as its joint with ``_dot``, a torque as its joint after ``torque_``; the
    base of a floating robot has ``base_roll`` and others, too. A unit in brackets must be SI.

    Raises
    ------
    InputError
        Not a table of finite numbers, unknown columns, no time, a time that does not grow.
    """
    where = f"trajectory {path}"
    outline = contact.dynamics.outline
    units = {TIME: "s", **outline.state_units, **{p.name: p.unit for p in outline.parameters}}
    rows = list(csv.reader(io.StringIO(read_text(path, where, MAX_BYTES, "CSV file"))))
    rows = [row for row in rows if row and not row[0].lstrip().startswith("#")]
    if len(rows) < 2:
        raise InputError(f"{where}: got {len(rows)} lines, need a header and at least one sample.")
    names = []
    for cell in rows[0]:
        unit = _UNIT.search(cell)
        name = _UNIT.sub("", cell).strip()
        refuse_unknown("column", name, units, where)
        if unit and unit[1].strip() != units[name]:
            raise InputError(
                f"{where}: column {name}: got the unit {unit[1]!r}, need {units[name]}."
            )
        if name in names:
            raise InputError(f"{where}: got column {name} twice. Fix: give it once.")
        names.append(name)
    if TIME not in names:
        raise InputError(f"{where}: has no column {TIME}, the time in s.")
    table = np.full((len(rows) - 1, len(names)), math.nan)
    for i, row in enumerate(rows[1:]):
        try:
            table[i] = [float(cell) for cell in row]
        except ValueError:
            table[i] = math.nan
        if len(row) != len(names) or not np.isfinite(table[i]).all():
            raise InputError(
                f"{where}: sample {i + 1}: need {len(names)} finite numbers, got {len(row)} cells."
            )
    columns = dict(zip(names, table.T.copy(), strict=True))
    if not (np.diff(columns[TIME]) > 0).all():
        k = int(np.argmin(np.diff(columns[TIME])))
        raise InputError(f"{where}: sample {k + 2}: the time does not grow.")
    return columns


def risk_along(
    contact: RobotContact, motion: Mapping[str, Array], mu: float | None = None
) -> RiskTrajectory:
    """Return the risk of a contact along a motion.

    Parameters
    ----------
    contact : RobotContact
        Whose values hold for what the motion does not give.
    motion : mapping of str to ndarray, shape (n,)
        ``t`` and others, as `read_motion` returns.
    mu : float, optional
        Friction coefficient, >= 0.
    """
    if mu is not None:
        mu = number(mu, "mu", where="trajectory", lower=0.0)
    columns = {name: column for name, column in motion.items() if name != TIME}
    t = np.asarray(motion[TIME])
    values = {**contact.values, **columns}
    values["mu"] = np.full(len(t), 0.0 if mu is None else mu)
    numbers = contact.numbers_at(values)
    W, b = contact.in_question(numbers)
    mu_P = friction_threshold(W)
    given = any(name.endswith("_dot") or name.startswith("torque_") for name in columns)
    case: tuple[str, ...] = ()
    if mu and given:
        slips = numbers.slip_velocity[0].T.tolist()
        each = range(len(t))
        case = tuple(contact_answer(W[..., k], b[:, k], mu, slips[k]).case.value for k in each)
    margin = None if not mu else mu_P / mu
    share = None if margin is None else float(time_weights(t)[margin < 1].sum())
    return RiskTrajectory(t, mu, mu_P, margin, case, share)
