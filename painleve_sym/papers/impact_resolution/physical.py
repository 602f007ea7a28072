"""Beyond the paper: the impact of its Table 3 with the stiffness of real materials."""

from __future__ import annotations

from typing import Any

from painleve_sym.contacts.impact.jump import evaluate_jump
from painleve_sym.errors import EventKind
from painleve_sym.mechanics.materials import materials
from painleve_sym.motion.finite_stiffness import CONFIGURATIONS, CorrectedJumpRule
from painleve_sym.motion.rigidity import contact_durations
from painleve_sym.papers.impact_resolution.claims import SOFT, STIFF
from painleve_sym.papers.impact_resolution.runs import Workbench, modulus_text
from painleve_sym.papers.item import Outcome, checked, table

T_END = 1.0
"""s; the softest of the materials, rubber, is in contact for less than a tenth of it."""
_PAPER = {"soft": SOFT, "stiff": STIFF}
"""Moduli of the paper."""


def _case(bench: Workbench, name: str) -> dict[str, Any]:
    """Return the impact with one modulus of the paper, or at one material."""
    simulator, state = bench.simulator(), bench.state(3)
    material = materials().get(name)
    given = simulator.of_materials(material) if material else {"E": _PAPER[name]}
    values = simulator.parameters(given)
    run = simulator.run(
        state, t_end=T_END, parameters=given, material=material, until=EventKind.SEPARATION
    )
    rule = CorrectedJumpRule(simulator.mechanism, simulator.contact_law)
    classical = evaluate_jump(
        simulator.mechanism,
        "energetic",
        state,
        parameters={p: values[p] for p in (*simulator.mechanism.parameters, "e_energetic")},
    )
    jumps = {c: rule(state, values, configuration=c) for c in CONFIGURATIONS}
    return {
        "E": values["E"],
        "compliant": run.final["y_A_dot"],
        "classical": classical.velocity["y_A_dot"],
        **{c: float(jumps[c].velocity["y_A_dot"]) for c in CONFIGURATIONS},
        "slip stops": run.events_of("slip_stop")[0].time,
        "separation": contact_durations(run.events)["A"],
        "bending period": run.body_periods[0].period if run.body_periods else None,
    }


def compute_physical(bench: Workbench) -> Outcome:
    """Set the three rules beside the compliant impact of Table 3 at every material."""
    cases = {name: _case(bench, name) for name in (*_PAPER, *materials())}
    off = {
        name: {rule: abs(c[rule] / c["compliant"] - 1) for rule in ("classical", *CONFIGURATIONS)}
        for name, c in cases.items()
    }
    real = {name: cases[name] for name in materials()}
    checks = {
        "classical: less than half of the rebound at every material": all(
            c["classical"] < c["compliant"] / 2 for c in real.values()
        ),
        "carried: right to 3 % at every material": all(off[n]["carried"] < 0.03 for n in real),
        "frozen, carried: right to 0.5 % at every material but rubber": all(
            max(off[n][rule] for rule in CONFIGURATIONS) < 5e-3 for n in real if n != "rubber"
        ),
        "a bar of no material is rigid: the contact is shorter than its first bending period": all(
            c["separation"] < c["bending period"] for c in real.values()
        ),
    }
    units = {"E": "Pa", "separation": "s", "slip stops": "s", "bending period": "s"}
    keys = list(next(iter(cases.values())))
    columns = [f"{key} ({units.get(key, 'ẏ_A, m/s')})" for key in keys]
    rows = [[name, *(c[key] for key in keys)] for name, c in cases.items()]
    steel = cases["steel"]
    return checked(
        f"ẏ_A(t3) of steel, E = {steel['E']:.3g}: classical {steel['classical']:.4f}, "
        f"frozen {steel['frozen']:.4f}, carried {steel['carried']:.4f}, compliant "
        f"{steel['compliant']:.4f}; at the paper's {modulus_text(STIFF)} compliant "
        f"{cases['stiff']['compliant']:.4f}",
        checks,
        {"table": table(["case", *columns], rows)},
        duration=steel["separation"],
        period=steel["bending period"],
    )


COMPUTE = {"physical-values": compute_physical}
