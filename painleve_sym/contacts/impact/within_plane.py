"""Impacts in space of a contact that moves in one plane, such as the tip of a planar arm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from painleve_sym.checks import INDEFINITE, SYMMETRY, mobility_faults, spatial_mobility_faults
from painleve_sym.contacts.impact.path import ImpactPhase
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


def plane_faults(
    W: Sequence[Sequence[float]], velocity: Sequence[float], tangent: Tangent
) -> list[str]:
    """Return sentences where W or the velocity is not one of motion in this plane."""
    (nn, nt), (tn, tt) = in_plane(W, tangent)
    faults = mobility_faults(nn, nt, tn, tt)
    (c, s), (_, v_1, v_2) = tangent, velocity
    across = c * v_2 - s * v_1
    if abs(across) > SYMMETRY * math.hypot(*velocity):
        faults.append(
            f"velocity: got {across:g} m/s along ({-s:g}, {c:g}), a tangent in which W moves "
            "nothing, need 0 there. Fix: give a velocity that the contact can have."
        )
    return faults


def phase_in_space(phase: ImpactPhase, tangent: Tangent) -> ImpactPhase:
    """Return a phase of the plane of the normal and a tangent as one in space."""
    (_, P_t), (v_n, v_t), (direction,) = phase.impulse, phase.velocity, phase.direction

    def along(value: float) -> tuple[float, float]:
        # Adding 0.0 turns -0.0 into 0.0.
        return value * tangent[0] + 0.0, value * tangent[1] + 0.0

    return replace(
        phase,
        mode=ContactMode.STICK if phase.mode is ContactMode.STICK else ContactMode.SLIP,
        tangential_impulse=along(P_t),
        velocity=(v_n, *along(v_t)),
        direction=along(direction),
    )
