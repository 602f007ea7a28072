"""Impacts in space of a contact that moves in one plane, such as the tip of a planar arm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from painleve_sym.checks import INDEFINITE, SYMMETRY, spatial_mobility_faults
from painleve_sym.problem.impact.path import ImpactPhase
from painleve_sym.problem.modes import ContactMode

Tangent = tuple[float, float]


def moving_tangent(W: Sequence[Sequence[float]]) -> Tangent | None:
    """Return the one tangent along which a contact in space moves; None where it moves in both.

    Across it no impulse moves the contact, so that an impact is one in the plane of the normal and
    this tangent.

    Parameters
    ----------
    W : sequence of 3 sequences of 3 float
        Rows n, t1, t2, finite; 1/kg.
    """
    (nn, n1, n2), (m1, one, m), (m2, m21, two) = W
    total = one + two
    uneven = max(abs(n1 - m1), abs(n2 - m2), abs(m - m21))
    if min(nn, one, two) < 0 or uneven > SYMMETRY * (nn + total):
        return None
    determinant, size = one * two - m * m, total**2
    if determinant > INDEFINITE * size:
        return None
    if determinant > INDEFINITE**2 * size and not spatial_mobility_faults(W, definite=True):
        return None
    along = (one, m) if one >= two else (m, two)
    length = math.hypot(*along)
    c, s = (along[0] / length, along[1] / length) if length else (1.0, 0.0)
    if abs(c * n2 - s * n1) > SYMMETRY * math.sqrt(nn) * math.sqrt(total):
        return None
    return c, s


def in_plane(
    W: Sequence[Sequence[float]], tangent: Tangent
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the mobility in the plane of the normal and a tangent; 1/kg."""
    (nn, n1, n2), (_, one, m), (_, _, two) = W
    c, s = tangent
    coupling = c * n1 + s * n2
    return (nn, coupling), (coupling, c * c * one + 2 * c * s * m + s * s * two)


def is_regular(W: tuple[tuple[float, float], tuple[float, float]]) -> bool:
    """Return whether a mobility in the plane is positive definite, beyond its rounding."""
    (nn, nt), (_, tt) = W
    return nn * tt - nt * nt > INDEFINITE * nn * tt


def axes_of_motion(
    W: Sequence[Sequence[float]], velocity: Sequence[float]
) -> tuple[Tangent, float] | None:
    """Return the tangent along which a contact moves, and the slip across it, m/s.

    None where it moves along both. Across it only a surface that is driven slips, at a speed that
    no impulse changes. Where none moves the contact along any, the tangent is that of the slip.
    """
    tangent = moving_tangent(W)
    if tangent is None:
        return None
    _, v_1, v_2 = velocity
    speed = math.hypot(v_1, v_2)
    if W[1][1] == W[2][2] == 0.0 and speed:
        return (v_1 / speed, v_2 / speed), 0.0
    across = tangent[0] * v_2 - tangent[1] * v_1
    return tangent, across if abs(across) > SYMMETRY * math.hypot(*velocity) else 0.0


def phase_along(phase: ImpactPhase, tangent: Tangent) -> ImpactPhase:
    """Return a phase with the rows n, t, and in space t2 at right angles, in the axes of space."""
    c, s = tangent

    def turned(along: float, across: float = 0.0) -> tuple[float, float]:
        return c * along - s * across + 0.0, s * along + c * across + 0.0

    v_n, *v_t = phase.velocity
    return replace(
        phase,
        mode=ContactMode.STICK if phase.mode is ContactMode.STICK else ContactMode.SLIP,
        tangential_impulse=turned(*phase.impulse[1:]),
        velocity=(v_n, *turned(*v_t)),
        direction=turned(*phase.direction),
    )
