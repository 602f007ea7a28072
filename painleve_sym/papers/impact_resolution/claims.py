"""The claims of ``claims.toml`` in the form that the items use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from painleve_sym.papers.claims import Printed, read_claims

CLAIMS = read_claims(Path(__file__).parent / "claims.toml")
NUMBERS = CLAIMS.numbers


@dataclass(frozen=True)
class PrintedTable:
    """An initial state, misprints corrected, with its coefficients; absent entries are 0.

    SI units, rad. `corrected_A` is the print of the other tables at the same θ where A is
    misprinted, `row` the printed row where its columns are damaged.
    """

    state: Mapping[str, float]
    A: Printed
    B: Printed
    corrected_A: Printed | None = None
    row: str = ""


@dataclass(frozen=True)
class PrintedForce:
    """An initial compression with the force it carries: Tables 5 and 6, §3.4."""

    table: int
    force: Printed
    height: Printed
    modulus: float


def _table(entry: Mapping[str, object]) -> PrintedTable:
    printed = {k: Printed(str(v)) for k, v in entry.items() if k in ("A", "B", "corrected_A")}
    rest = {k: v for k, v in entry.items() if k not in printed}
    return PrintedTable(**rest, **printed)  # type: ignore[arg-type]


TABLES = {int(number): _table(entry) for number, entry in CLAIMS.data["tables"].items()}
"""Tables 1–6 by number."""
EXPONENT: float = CLAIMS.data["inputs"]["parameters"]["n"]
"""n of the paper's law K δⁿ, that of no material."""
COLUMNS = ("x_A", "x_A_dot", "y_A", "y_A_dot", "theta", "theta_dot", "A", "B")
"""Columns of every table, in order."""

NAMED_MODULI: Mapping[str, float] = CLAIMS.data["inputs"]["moduli"]
SOFT, STIFF, STIFFER = (NAMED_MODULI[name] for name in ("soft", "stiff", "stiffer"))
"""The elastic moduli of §3.1, §3.3 and Table 6; Pa."""

INITIAL_FORCES = tuple(
    PrintedForce(
        row["table"],
        Printed(row["force"], CLAIMS.data["initial_forces"]["within"]),
        Printed(row["y_A"]),
        NAMED_MODULI[row["modulus"]],
    )
    for row in CLAIMS.data["initial_forces"]["rows"]
)
STABLE_FORCES = {SOFT: NUMBERS["stable-force-soft"], STIFF: NUMBERS["stable-force-stiff"]}
"""§3.1: the value at which F_n is said to become stable, by modulus; N."""
SETTLING_TIMES = {SOFT: NUMBERS["settling-time-soft"], STIFF: NUMBERS["settling-time-stiff"]}
"""§3.1: how long F_n oscillates, by modulus; s."""
