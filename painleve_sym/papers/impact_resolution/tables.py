"""Tables 1–6: their coefficients, and the forces of the initial compressions."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import sympy as sp

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.contacts.classify import Classification
from painleve_sym.papers.claim import Entry, Outcome, Verdict, table
from painleve_sym.papers.impact_resolution.claims import (
    COLUMNS,
    GRAVITY_UNIT,
    INITIAL_FORCES,
    TABLES,
)
from painleve_sym.papers.impact_resolution.diagrams import rigid
from painleve_sym.papers.run_cache import Workbench

GROUP = "table"


def _verdict(as_printed: bool, corrected: bool) -> Verdict:
    if as_printed:
        return Verdict.REPRODUCED
    return Verdict.MISPRINT if corrected else Verdict.DIFFERS


def _row(found: Classification) -> str:
    state = found.state
    numbers_ = [state[name] for name in COLUMNS[:6]]
    return " ".join(f"{v:g}" for v in numbers_) + f" {found.A:.4f} {found.B:.4f}"


def compute_table(number: int, bench: Workbench) -> Outcome:
    """Compare A and B of a table's state with its print."""
    printed, found = TABLES[number], rigid(bench, number)
    same_A, same_B = printed.A.matches(found.A), printed.B.matches(found.B)
    data: dict[str, Any] = {"state": found.state, "A": found.A, "B": found.B}
    if printed.row:
        words = printed.row.split()
        data |= {"columns": list(COLUMNS), "printed_row": words}
        # Read in order the row gives θ = θ̇'s number, A = θ's and so on: not this state.
        complete = len(words) == len(COLUMNS)
        verdict = _verdict(same_A and same_B and complete, same_A and same_B)
        return Outcome(
            f"row: {printed.row}",
            f"row: {_row(found)}",
            verdict,
            f"{len(words)} numbers for {len(COLUMNS)} columns: the first, x_A = 0, is lost and the "
            "others have moved; read so, A and B agree",
            data,
        )
    corrected = printed.corrected_A is not None and printed.corrected_A.matches(found.A)
    digits = "5" if corrected else "4"
    reason = ""
    if not same_A and corrected:
        reason = "a 3 became a 0; Tables 4–6 print −0.0337 at the same θ and μ"
    return Outcome(
        f"A = {printed.A.text}, B = {printed.B.text}",
        f"A = {found.A:.{digits}f}, B = {found.B:.4f}",
        _verdict(same_A and same_B, corrected and same_B),
        reason,
        data,
    )


def _force(bench: Workbench, modulus: float, compression: float, radius: float = 1.0) -> float:
    """Return K_e δⁿ with R* = `radius` R; N."""
    simulator = bench.simulator()
    values = simulator.parameters({"E": modulus})
    values = simulator.parameters({"E": modulus, "R": values["R"] * radius})
    symbols = simulator.constants(values)
    k, n = numbers([simulator.law.stiffness, simulator.law.exponent], symbols)
    return float(k * compression**n)


def compute_forces(number: int, bench: Workbench) -> Outcome:
    """Compare the forces of the printed compressions, and the compressions of the forces."""
    rows, same = [], True
    for claim in (f for f in INITIAL_FORCES if f.table == number):
        force = _force(bench, claim.modulus, -claim.height.value)
        parameters = bench.simulator().parameters({"E": claim.modulus})
        height = -bench.simulator().compression_of_force(claim.force.value, parameters)
        same &= claim.force.matches(force) and claim.height.matches(height)
        halved = _force(bench, claim.modulus, -claim.height.value, 0.5)
        rows.append([claim.force.value, claim.height.value, force, height, halved])
    columns = ["F_n0 (N)", "y_A printed (m)", "F_n(y_A) (N)", "y_A(F_n0) (m)", "with R/2 (N)"]
    return Outcome(
        ", ".join(f"{row[0]:g}" for row in rows) + " N at the printed y_A",
        ", ".join(f"{row[2]:.2f}" for row in rows) + " N; y_A to every digit",
        _verdict(same, False),
        "with R* = R, not with the formula printed for R*",
        {"table": table(columns, rows)},
    )


def compute_radius(bench: Workbench) -> Outcome:
    """Show that the printed formula for R* contradicts the printed forces."""
    rows = []
    for claim in INITIAL_FORCES:
        depth = -claim.height.value
        whole, half = (_force(bench, claim.modulus, depth, r) for r in (1.0, 0.5))
        rows.append([claim.force.value, whole, half])
    as_printed = all(c.force.matches(r[2]) for c, r in zip(INITIAL_FORCES, rows, strict=True))
    corrected = all(c.force.matches(r[1]) for c, r in zip(INITIAL_FORCES, rows, strict=True))
    return Outcome(
        "1/R* = sum of four curvatures: R* = R/2 on a plane",
        f"R/2 gives {rows[0][2]:.2f} N for the 150 N of Table 5, R gives {rows[0][1]:.2f} N",
        _verdict(as_printed, corrected),
        "the relative curvature is half the sum of the principal ones; all five initial forces "
        f"need R* = R (R/2 makes them √2 = {math.sqrt(2):.3f} times too small)",
        {"table": table(["F_n0 (N)", "with R* = R (N)", "with R* = R/2 (N)"], rows)},
    )


def compute_unit(bench: Workbench) -> Outcome:
    """Find the unit of g from the dimensions of B = l θ̇² sinθ − g."""
    system = bench.rod.system
    units = {p.name: p.unit for p in system.parameters}
    # l θ̇²: the unit of l over s², since angles have none.
    needed = f"{units['l']}/s^2"
    uses = bench.rod.coefficients.B.has(sp.Symbol("g", nonnegative=True))
    return Outcome(
        f"g = 9.8 {GRAVITY_UNIT}",
        f"g adds to l θ̇² sinθ in (3): {needed.replace('^2', '²')}",
        _verdict(needed == GRAVITY_UNIT, uses and units["g"] == needed),
        "kg·m/s² is a force; g is an acceleration",
        {"unit": units["g"]},
    )


ENTRIES = (
    *(
        Entry(
            f"table-{number}",
            GROUP,
            f"Table {number}: A and B",
            partial(compute_table, number),
            Verdict.MISPRINT if number in (2, 3) else Verdict.REPRODUCED,
        )
        for number in TABLES
    ),
    Entry("table-5-forces", GROUP, "Table 5: initial forces", partial(compute_forces, 5)),
    Entry("table-6-forces", GROUP, "Table 6: initial forces", partial(compute_forces, 6)),
    Entry("radius", GROUP, "R* and the initial forces", compute_radius, Verdict.MISPRINT),
    Entry("gravity-unit", GROUP, "unit of g", compute_unit, Verdict.MISPRINT),
)
