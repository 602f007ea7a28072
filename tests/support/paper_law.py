"""The contact law of the paper, whose exponent is not that of a material."""

from __future__ import annotations

from painleve_sym.laws.compliant_laws import bilinear_hertz

PAPER_EXPONENT = 1.764
"""n of (4) of the paper."""


def paper_law(**choices):
    """Return K δ^1.764 with unloading by the energetic restitution, and parameters or a choice."""
    return bilinear_hertz(n=PAPER_EXPONENT, **choices)
