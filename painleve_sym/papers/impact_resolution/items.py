"""The items of the paper: a function for each claim in ``claims.toml``."""

from __future__ import annotations

from painleve_sym.papers.impact_resolution import (
    beyond,
    diagrams,
    figures,
    formulas,
    impacts,
    jump,
    physical,
    reference_values,
    statements,
    tables,
)
from painleve_sym.papers.impact_resolution.runs import Workbench

__all__ = ["COMPUTE", "Workbench"]

COMPUTE = {
    **formulas.COMPUTE,
    **tables.COMPUTE,
    **diagrams.COMPUTE,
    **figures.COMPUTE,
    **impacts.COMPUTE,
    **statements.COMPUTE,
    **jump.COMPUTE,
    **reference_values.COMPUTE,
    **beyond.COMPUTE,
    **physical.COMPUTE,
}
"""By item, as a function of the `Workbench` that they share."""
