"""Parameters that most mechanisms have."""

from __future__ import annotations

from painleve_sym.mechanics.declarations import Parameter


def positive(name: str, default: float, unit: str, meaning: str, material: str = "") -> Parameter:
    """Return a parameter that must be > 0; `material` is the property of one that it stands for."""
    return Parameter(name, default, unit, meaning, 0.0, lower_closed=False, material=material)


def gravity() -> Parameter:
    """Return g, with the paper's value."""
    return Parameter("g", 9.8, "m/s^2", "gravity", 0.0)


def friction(default: float, name: str = "mu", where: str = "") -> Parameter:
    """Return μ; `where` names the contact when there are several."""
    return Parameter(name, default, "1", f"friction coefficient{where}", 0.0)
