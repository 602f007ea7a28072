"""Parameters that most mechanisms have."""

from __future__ import annotations

from painleve_sym.mechanics.declarations import Parameter


def gravity() -> Parameter:
    """Return g, with the paper's value."""
    return Parameter("g", 9.8, "m/s^2", "gravity", 0.0)


def friction(default: float, name: str = "mu", where: str = "") -> Parameter:
    """Return μ; `where` names the contact when there are several."""
    return Parameter(name, default, "1", f"friction coefficient{where}", 0.0)
