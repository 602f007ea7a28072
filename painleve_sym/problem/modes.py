"""Modes of a contact, and rounding of differences."""

from __future__ import annotations

import enum

CONTACT_LIMIT = 6
"""Most contacts whose pieces are all tried: 4**6 regular systems take a tenth of a second."""


class ContactMode(enum.StrEnum):
    """Name what the contact does next.

    LIFTOFF
        F_n = 0, F_t = 0, a_n >= 0 (grazing where a_n = 0); unilateral contacts only.
    SLIP_POS
        a_n = 0, F_t = -mu |F_n|: v_t > 0, or v_t = 0 and a_t > 0.
    SLIP_NEG
        a_n = 0, F_t = +mu |F_n|: v_t < 0, or v_t = 0 and a_t < 0.
    SLIP
        In space: a_n = 0, F_t = -mu |F_n| e with e along v_t, or along a_t where v_t = 0.
    STICK
        a_n = 0, a_t = 0 with v_t = 0 and |F_t| <= mu |F_n|, the edge of the cone included.

    PRESSED
        a_n = 0 of a contact without tangents.

    F_n > 0 except for LIFTOFF; a bilateral contact has either sign of F_n.
    """

    LIFTOFF = "liftoff"
    SLIP_POS = "slip_pos"
    SLIP_NEG = "slip_neg"
    SLIP = "slip"
    STICK = "stick"
    PRESSED = "pressed"


def sign_of(value: float) -> int:
    """Return -1, 0 or +1."""
    return int(value > 0) - int(value < 0)


def slip_mode(direction: float) -> ContactMode:
    """Return the mode of slip along the sign of `direction`, which is not 0."""
    return ContactMode.SLIP_POS if direction > 0 else ContactMode.SLIP_NEG
