"""Beyond the paper: its headline results at the stiffness and friction of real materials."""

from __future__ import annotations

import itertools
from typing import Any

import sympy as sp

from painleve_sym.at.jump import evaluate_jump
from painleve_sym.errors import EventKind
from painleve_sym.mechanics.materials import HERTZ_EXPONENT, materials
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.paradox.critical_friction import least_over_directions
from painleve_sym.motion.finite_stiffness import CONFIGURATIONS, CorrectedJumpRule
from painleve_sym.motion.rigidity import contact_durations
from painleve_sym.motion.simulator import Simulator
from painleve_sym.papers.impact_resolution.claims import SOFT, STIFF
from painleve_sym.papers.impact_resolution.runs import Workbench, modulus_text
from painleve_sym.papers.item import ItemOutcome, checked, table
from painleve_sym.study.critical.bisection import CriticalForceFinder

T_END = 1.0
"""s; the softest of the materials, rubber, is in contact for less than a tenth of it."""
_PAPER = {"soft": SOFT, "stiff": STIFF}
"""Moduli of the paper."""


def _contact(bench: Workbench, name: str) -> tuple[Simulator, dict[str, float]]:
    """Return the rod and parameters: the paper's law and a modulus of it, or a material by Hertz's.

    A modulus says what the stiffness is with Hertz's exponent alone.
    """
    if name in _PAPER:
        return bench.simulator(), {"E": _PAPER[name]}
    simulator = bench.simulator(exponent=HERTZ_EXPONENT)
    return simulator, simulator.values_of_materials(name)


def _case(bench: Workbench, name: str) -> dict[str, Any]:
    """Return the impact with one modulus of the paper, or at one material."""
    simulator, given = _contact(bench, name)
    material, state = materials().get(name), bench.state(3)
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


def compute_physical(bench: Workbench) -> ItemOutcome:
    """Set the three rules beside the compliant impact of Table 3 at every material."""
    cases = {name: _case(bench, name) for name in (*_PAPER, *materials())}
    off = {
        name: {rule: abs(c[rule] / c["compliant"] - 1) for rule in ("classical", *CONFIGURATIONS)}
        for name, c in cases.items()
    }
    real = {name: cases[name] for name in materials()}
    checks = {
        "classical: at least 40 % too low at every material": all(
            c["classical"] < 0.6 * c["compliant"] for c in real.values()
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


def compute_physical_force(bench: Workbench) -> ItemOutcome:
    """Set the critical force of Table 4 at every material beside the paper's modulus and F_n*."""
    state = bench.state(4)
    limit = -bench.rigid(4).B / bench.rigid(4).A
    rows = list[list[Any]]()
    for name in (*_PAPER, *materials()):
        simulator, given = _contact(bench, name)
        force = CriticalForceFinder(simulator).find(state, given, check_tolerance=False).value
        rows.append([name, given["E"], force, force / limit])
    forces = {name: force for name, _, force, _ in rows}
    real = [row for row in rows if row[0] not in _PAPER]  # of one law
    by_modulus = [force for *_, force, _ in sorted(real, key=lambda row: float(row[1]))]
    checks = {
        "a stiffer contact needs more": all(a < b for a, b in itertools.pairwise(by_modulus)),
        "less than F_n* is enough at every material": all(forces[n] < limit for n in materials()),
        "more than F_n* is needed at the paper's modulus": forces["stiff"] > limit,
    }
    return checked(
        f"the slip stops from {forces['steel']:.1f} N at steel, from {forces['stiff']:.1f} N at "
        f"{modulus_text(STIFF)}; F_n* = {limit:.1f} N",
        checks,
        {"F_n*": limit, "table": table(["case", "E (Pa)", "slip stops from (N)", "/F_n*"], rows)},
        share=100 * forces["steel"] / limit,
    )


def compute_physical_friction(bench: Workbench) -> ItemOutcome:
    """Set the friction of real pairs beside the least with which the rigid rod has the paradox."""
    least = float(least_over_directions(bench.rod.coefficients).subs(_at_rest(bench.rod)))
    rows: list[list[Any]] = [
        [f"{material.name}, {pair.other}", friction.lower, friction.upper, friction.upper >= least]
        for material in materials().values()
        for pair in material.pairs
        if (friction := pair.sliding_friction) and pair.other not in _before(material.name)
    ]
    reached = [row[0] for row in rows if row[3]]
    checks = {
        "4/3": abs(least - 4 / 3) < 1e-12,
        "one pair reaches it": reached == ["aluminium, aluminium"],
    }
    return checked(
        f"the paradox needs μ > {least:.4f} while the rod is rigid, which {len(reached)} of "
        f"{len(rows)} pairs reaches",
        checks,
        {
            "least": least,
            "table": table(["pair", "sliding friction from", "to", "reaches that of rigid"], rows),
        },
        pairs=", ".join(reached),
    )


def _before(name: str) -> tuple[str, ...]:
    """Return the materials before one in the table, whose pairs with it were listed."""
    names = tuple(materials())
    return names[: names.index(name)]


def _at_rest(mechanism: Mechanism) -> dict[sp.Symbol, float]:
    """Return the mechanism's defaults, and its start without velocities and deflection."""
    system = mechanism.system
    return system.defaults | {q: mechanism.start.get(q.name, 0.0) for q in system.q}


COMPUTE = {
    "physical-values": compute_physical,
    "physical-critical-force": compute_physical_force,
    "physical-friction": compute_physical_friction,
}
