"""Tables 1–6: their coefficients, and the forces of the initial compressions."""

from __future__ import annotations

from functools import partial
from typing import Any

import sympy as sp

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.papers.impact_resolution.claims import CLAIMS, COLUMNS, INITIAL_FORCES, TABLES
from painleve_sym.papers.impact_resolution.runs import Workbench
from painleve_sym.papers.item import ItemOutcome, Verdict, table


def compute_table(number: int, bench: Workbench) -> ItemOutcome:
    """Compare A and B of a table's state with its print."""
    printed, rigid = TABLES[number], bench.rigid(number)
    same_A, same_B = printed.A.matches(rigid.A), printed.B.matches(rigid.B)
    data: dict[str, Any] = {"state": rigid.state, "A": rigid.A, "B": rigid.B}
    if printed.row:
        words = printed.row.split()
        data |= {"columns": list(COLUMNS), "printed_row": words}
        # Read in order the row gives θ = θ̇'s number, A = θ's and so on: not this state.
        complete = len(words) == len(COLUMNS)
        state = " ".join(f"{rigid.state[name]:g}" for name in COLUMNS[:6])
        return ItemOutcome(
            f"row: {state} {rigid.A:.4f} {rigid.B:.4f}",
            Verdict.of(same_A and same_B and complete, corrected=same_A and same_B),
            {"numbers": len(words), "columns": len(COLUMNS)},
            data,
            paper=f"row: {printed.row}",
        )
    corrected = printed.corrected_A is not None and printed.corrected_A.matches(rigid.A)
    digits = "5" if corrected else "4"
    return ItemOutcome(
        f"A = {rigid.A:.{digits}f}, B = {rigid.B:.4f}",
        Verdict.of(same_A and same_B, corrected=corrected and same_B),
        data=data,
        paper=f"A = {printed.A.text}, B = {printed.B.text}",
    )


def _force(bench: Workbench, modulus: float, compression: float, radius: float = 1.0) -> float:
    """Return K_e δⁿ with R* = `radius` R; N."""
    simulator = bench.simulator()
    values = simulator.parameters({"E": modulus})
    values = simulator.parameters({"E": modulus, "R": values["R"] * radius})
    symbols = simulator.constants(values)
    k, n = numbers([simulator.contact_law.stiffness, simulator.contact_law.exponent], symbols)
    return float(k * compression**n)


def compute_forces(number: int, bench: Workbench) -> ItemOutcome:
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
    return ItemOutcome(
        ", ".join(f"{row[2]:.2f}" for row in rows) + " N; y_A to every digit",
        Verdict.of(same),
        data={"table": table(columns, rows)},
    )


def compute_radius(bench: Workbench) -> ItemOutcome:
    """Show that the printed formula for R* contradicts the printed forces."""
    rows = []
    for claim in INITIAL_FORCES:
        depth = -claim.height.value
        whole, half = (_force(bench, claim.modulus, depth, r) for r in (1.0, 0.5))
        rows.append([claim.force.value, whole, half])
    as_printed = all(c.force.matches(r[2]) for c, r in zip(INITIAL_FORCES, rows, strict=True))
    corrected = all(c.force.matches(r[1]) for c, r in zip(INITIAL_FORCES, rows, strict=True))
    return ItemOutcome(
        f"R/2 gives {rows[0][2]:.2f} N for the 150 N of Table 5, R gives {rows[0][1]:.2f} N",
        Verdict.of(as_printed, corrected),
        data={"table": table(["F_n0 (N)", "with R* = R (N)", "with R* = R/2 (N)"], rows)},
    )


def compute_unit(bench: Workbench) -> ItemOutcome:
    """Derive the unit of g from the dimensions of B = l θ̇² sinθ − g."""
    system = bench.rod.system
    units = {p.name: p.unit for p in system.parameters}
    # l θ̇²: the unit of l over s², since angles have none.
    needed, printed = f"{units['l']}/s^2", CLAIMS.data["inputs"]["gravity_unit"]
    uses = bench.rod.coefficients.B.has(sp.Symbol("g", nonnegative=True))
    return ItemOutcome(
        f"g adds to l θ̇² sinθ in (3): {needed.replace('^2', '²')}",
        Verdict.of(needed == printed, corrected=uses and units["g"] == needed),
        data={"unit": units["g"]},
        paper=f"g = 9.8 {printed}",
    )


COMPUTE = {
    **{f"table-{number}": partial(compute_table, number) for number in TABLES},
    "table-5-forces": partial(compute_forces, 5),
    "table-6-forces": partial(compute_forces, 6),
    "radius": compute_radius,
    "gravity-unit": compute_unit,
}
