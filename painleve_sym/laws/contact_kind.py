"""The kinds of contacts, as their laws name them."""

from __future__ import annotations

import enum


class ContactKind(enum.StrEnum):
    """Kind of a contact: what its forces follow from."""

    GUIDE = "guide"
    """It cannot open: the gap stays 0, and the normal force has either sign."""
    RIGID = "rigid"
    """It does not yield: its force keeps the gap at 0 while it is closed."""
    COMPLIANT = "compliant"
    """It yields along its normal."""
    SPRING = "spring"
    """It yields along its normal and, by a spring, along its tangent."""
