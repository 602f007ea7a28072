"""Values computed outside this package, and the balance of energy over all runs."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.engines.protocol import DEFAULT_RTOL
from painleve_sym.papers.claims import Printed
from painleve_sym.papers.impact_resolution import runs
from painleve_sym.papers.impact_resolution.claims import CLAIMS, NAMED_MODULI
from painleve_sym.papers.impact_resolution.runs import LONG, RunCase, Workbench, needed
from painleve_sym.papers.item import ItemOutcome, Verdict, checked, table

REFERENCES = CLAIMS.data["references"]
# Fourteen digits want more than the default accuracy; round-off then is some 1e-15.
FINE = 1e-14


def compute_reference(name: str, bench: Workbench) -> ItemOutcome:
    """Compare one run with the values computed elsewhere."""
    reference = REFERENCES[name]
    modulus = NAMED_MODULI[reference["modulus"]]
    run = bench.run(RunCase(reference["table"], modulus, LONG, until=reference["until"], rtol=FINE))
    rows, largest = list[list[Any]](), 0.0
    for kind, quantity, text, *within in reference["values"]:
        event, digits = needed(run, kind), Printed(text, *within)
        outputs = {
            "time": event.time,
            "normal_force": event.normal_force,
            "compression": event.compression,
        }
        ours = {**event.state, **outputs}[quantity]
        largest = max(largest, abs(ours / digits.value - 1))
        rows.append([kind, quantity, text, ours, digits.matches(ours)])
    agree = sum(row[-1] for row in rows)
    exact = all(len(entry) == 3 for entry in reference["values"])
    where = "in every digit" if exact else "within the accuracy of the reference"
    simulator = bench.simulator()
    constants = simulator.constants(simulator.parameters({"E": modulus}))
    return ItemOutcome(
        f"{agree} of {len(rows)} agree {where}",
        Verdict.of(agree == len(rows)),
        data={
            "E": modulus,
            "K_e": float(numbers([simulator.contact_law.stiffness], constants)[0]),
            "largest_relative_difference": largest,
            "source": reference["source"],
            "table": table(["event", "quantity", "reference", "computed", "agrees"], rows),
        },
    )


def all_cases() -> dict[str, RunCase]:
    """Return every case of the figures and statements by the name of its constant."""
    cases: dict[str, RunCase] = {}
    for name, value in vars(runs).items():
        if isinstance(value, RunCase):
            cases[name] = value
        elif isinstance(value, dict) and all(isinstance(v, RunCase) for v in value.values()):
            cases |= {f"{name} {key:g}": case for key, case in value.items()}
    return cases


def compute_energy(bench: Workbench) -> ItemOutcome:
    """Take the balance of energy over every run."""
    trajectories = {name: bench.run(case) for name, case in all_cases().items()}
    residuals = {name: run.energy_residual for name, run in trajectories.items()}
    worst = max(residuals, key=lambda name: residuals[name])
    lost = {name: run.final["contact_dissipation"] for name, run in trajectories.items()}
    checks = {
        # Ten times the tolerance of a step: a few dozen steps may add up to it.
        "balance": bool(residuals[worst] < 10 * DEFAULT_RTOL),
        "every residual is a number": bool(np.all(np.isfinite(list(residuals.values())))),
        "plasticity takes energy": all(v >= 0 for v in lost.values()),
    }
    rows: list[list[Any]] = [[name, value, lost[name]] for name, value in residuals.items()]
    return checked(
        f"kinetic + potential + stored + dissipated constant to {residuals[worst]:.0e} in "
        f"{len(rows)} runs",
        checks,
        {"table": table(["run", "relative residual", "plastic dissipation (J)"], rows)},
        worst=worst,
    )


COMPUTE = {
    **{name: partial(compute_reference, name) for name in REFERENCES},
    "energy": compute_energy,
}
