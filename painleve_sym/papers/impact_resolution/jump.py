"""§4: the jump rule in numbers, against compliant impacts; and the force that separates (§3.4)."""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy as sp

from painleve_sym.papers.impact_resolution.claims import CLAIMS, STIFF
from painleve_sym.papers.impact_resolution.formulas import derived_forms
from painleve_sym.papers.impact_resolution.runs import MODULI, Workbench, modulus_text
from painleve_sym.papers.item import ItemOutcome, Verdict, checked, table
from painleve_sym.papers.panels import MODULUS, Axis, Panel, line
from painleve_sym.study.comparisons.jump_convergence import JumpComparison, compare_jump
from painleve_sym.study.critical.bisection import Border, CriticalForceFinder

QUANTITIES = (
    (1, "y_A_dot", r"$\dot{y}_A(t_1)$"),
    (2, "theta_dot", r"$\dot{\theta}(t_2)$"),
    (3, "y_A_dot", r"$\dot{y}_A(t_3)$"),
    (3, "theta_dot", r"$\dot{\theta}(t_3)$"),
)
PRECISE = 0.05
"""A relative error above this is not called quite precise."""


def comparison(bench: Workbench) -> JumpComparison:
    """Return the jump of Table 3 against compliant impacts, computed once."""
    return bench.shared(
        "comparison", lambda: compare_jump(bench.simulator(), bench.state(3), MODULI)
    )


def _printed_jump(bench: Workbench) -> dict[str, float]:
    """Evaluate (14), (18) and (21) as printed, misprints corrected, at Table 3."""
    d = derived_forms(bench)
    system = bench.rod.system
    values: dict[Any, Any] = dict(system.defaults)
    start = bench.state(3)
    values |= {s: start[s.name] for s in (*system.q, *system.q_dot)}
    values[d["e_s"]] = bench.simulator().parameters()["e_energetic"]
    for name in ("x_A_dot", "y_A_dot", "theta_dot"):
        values[d[f"{name}_0"]] = start[name]

    def evaluated(formula: str, symbol: str = "") -> float:
        number = float(sp.N(d.printed(formula, corrected=True).subs(values), 17))
        if symbol:
            # Later formulas use it.
            values[d[symbol]] = number
        return number

    results = {
        "P_n1": evaluated("eq-14-impulse", "P_n1"),
        "ẏ_A(t1)": evaluated("eq-14-normal", "y_A_dot_1"),
        "θ̇(t1)": evaluated("eq-14-spin", "theta_dot_1"),
        "P_n2": evaluated("eq-18-impulse"),
        "θ̇(t2)": evaluated("eq-18-spin", "theta_dot_2"),
    }
    values[d["E_nc"]] = evaluated("eq-17") + evaluated("eq-20")
    results["ẏ_A(t3)"] = evaluated("eq-21-normal", "y_A_dot_3")
    results["θ̇(t3)"] = evaluated("eq-21-spin")
    return results


def compute_values(bench: Workbench) -> ItemOutcome:
    """Evaluate the printed rule and the package's jump side by side."""
    printed, jump = _printed_jump(bench), comparison(bench).jump
    first, second, third = jump.phases
    ours = {
        "P_n1": first.normal_impulse,
        "ẏ_A(t1)": first.velocity["y_A_dot"],
        "θ̇(t1)": first.velocity["theta_dot"],
        "P_n2": second.normal_impulse,
        "θ̇(t2)": second.velocity["theta_dot"],
        "ẏ_A(t3)": third.velocity["y_A_dot"],
        "θ̇(t3)": third.velocity["theta_dot"],
    }
    # Seventeen digits on one side, double precision on the other.
    checks = {k: bool(np.isclose(ours[k], printed[k], rtol=1e-13, atol=0)) for k in ours}
    rows = [[k, printed[k], ours[k]] for k in ours]
    return checked(
        f"ẏ_A(t1) = {ours['ẏ_A(t1)']:.5f}, ẏ_A(t3) = {ours['ẏ_A(t3)']:.5f}, "
        f"θ̇(t3) = {ours['θ̇(t3)']:.5f}",
        checks,
        {"table": table(["quantity", "printed formulas", "package"], rows)},
    )


def extrapolated(errors: np.ndarray[Any, Any], stiffness: np.ndarray[Any, Any], n: float) -> float:
    """Return the limit of the error for infinite stiffness from the last four values.

    The error is a series in ε = E^(−1/(2n)) times powers of η = E^(−(n−1)/(2n(n+1))): the first
    phase ends before its blow-up time by a part η of it. Fitted: a₀ + ε (a₁ + a₂ η + a₃ η²).
    """
    scaled = stiffness[-4:] / stiffness[-4]
    eps = scaled ** (-1 / (2 * n))
    eta = scaled ** (-(n - 1) / (2 * n * (n + 1)))
    matrix = np.column_stack([np.ones(4), eps, eps * eta, eps * eta**2])
    return float(np.linalg.solve(matrix, errors[-4:])[0])


def _panels(c: JumpComparison) -> tuple[Panel, Panel]:
    errors, orders = [], []
    between = np.sqrt(c.stiffness[1:] * c.stiffness[:-1])
    for phase, name, label in QUANTITIES:
        rule, _, error = c.column(phase, name)
        errors.append(line(label, c.stiffness, np.abs(error / rule), "points"))
        orders.append(line(label, between, c.orders(phase, name), "points"))
    slope = c.stiffness**c.expected_order
    level = 2.5 * float(np.max([e.y[-1] for e in errors])) / slope[-1]
    errors.append(line(r"$E^{-1/(2n)}$", c.stiffness, level * slope, "reference"))
    flat = np.full(2, c.expected_order)
    ends = c.stiffness[[0, -1]]
    orders.append(line(r"$E^{-1/(2n)}$", ends, flat, "reference"))
    error_axis = Axis("|compliant − rule| / |rule|", log=True)
    return (
        Panel(MODULUS, error_axis, tuple(errors), title="relative error"),
        Panel(MODULUS, Axis("local order"), tuple(orders), title="order of convergence"),
    )


def compute_convergence(bench: Workbench) -> ItemOutcome:
    """Measure how the compliant impacts converge to the rule."""
    c = comparison(bench)
    n = -0.5 / c.expected_order
    rows, checks = list[list[Any]](), dict[str, bool]()
    for phase, name, _ in QUANTITIES:
        rule, _, error = c.column(phase, name)
        orders = c.orders(phase, name)
        key = f"{name}(t{phase})"
        rest = extrapolated(error, c.stiffness, n)
        checks |= {
            f"{key}: the error shrinks": bool(np.all(np.diff(np.abs(error)) < 0)),
            # η falls by 0.84 a decade: after nine the order is within 0.04 of its limit.
            f"{key}: the order approaches −1/(2n)": bool(
                np.all(np.diff(orders) < 0) and 0 < orders[-1] - c.expected_order < 0.04
            ),
            # A fiftieth of the last error: a fit of four terms resolves no less.
            f"{key}: the limit is the rule": abs(rest) < 0.02 * abs(error[-1]),
        }
        rows += [
            [key, float(E), float(e), float(e / rule), float(p)]
            for E, e, p in zip(c.stiffness, error, [np.nan, *orders], strict=True)
        ]
    dropped = _dropped_impulse(bench, c)
    checks["ẏ_A(t1): the error is the impulse of B"] = bool(np.all(np.abs(dropped - 1) < 0.03))
    last = c.orders(3, "y_A_dot")[-1]
    return checked(
        f"order {last:.3f} at E = {modulus_text(MODULI[-1])}, tending to "
        f"−1/(2n) = {c.expected_order:.3f}; limit = rule",
        checks,
        {
            "expected_order": c.expected_order,
            "error_over_dropped_impulse": dropped.tolist(),
            "slip_stop_times": c.times[:, 0].tolist(),
            "table": table(
                ["quantity", "E (Pa)", "softened − rule", "relative", "local order"],
                [[None if v != v else v for v in row] for row in rows],
            ),
        },
        _panels(c),
        first=dropped[0],
        last=dropped[-1],
    )


def _dropped_impulse(bench: Workbench, c: JumpComparison) -> np.ndarray[Any, Any]:
    """Return the error of ẏ_A(t1) over (B − A b_t/C) t1, which finite forces contribute."""
    problem = bench.rigid(3).problem
    sliding = problem.W_nt + problem.mu * problem.W_tt
    rate = problem.b_n - problem.A_slip(-1) / sliding * problem.b_t
    ratio: np.ndarray[Any, Any] = c.column(1, "y_A_dot")[2] / (rate * c.times[:, 0])
    return ratio


def compute_precision(bench: Workbench) -> ItemOutcome:
    """§4: how precise the rule is for E above 1e14 Pa."""
    c = comparison(bench)
    rows = list[list[Any]]()
    for phase, name, _ in QUANTITIES:
        rule, values, error = c.column(phase, name)
        for E, value, e in zip(c.stiffness, values, error, strict=True):
            if CLAIMS.data["inputs"]["precise_from"] <= E:
                rows.append([f"{name}(t{phase})", float(E), rule, float(value), float(-e / value)])
    at = {(row[0], row[1]): row for row in rows}
    rebound, spin = at["y_A_dot(t3)", STIFF], at["theta_dot(t3)", STIFF]
    worst = max(abs(row[4]) for row in rows)
    enough = next(E for k, E, *_, r in rows if k == "y_A_dot(t3)" and abs(r) < PRECISE)
    columns = ["quantity", "E (Pa)", "rule", "softened", "rule off by"]
    return ItemOutcome(
        f"at {modulus_text(STIFF)}: ẏ_A(t3) {rebound[2]:.5f} for {rebound[3]:.5f} "
        f"({100 * rebound[4]:+.0f} %), θ̇(t3) {spin[2]:.5f} for {spin[3]:.5f}",
        Verdict.of(worst <= PRECISE),
        {"spin": 100 * abs(spin[4]), "precise": 100 * PRECISE, "enough": modulus_text(enough)},
        {"table": table(columns, rows)},
    )


def _thresholds(bench: Workbench) -> list[list[float]]:
    """Return modulus and both critical forces."""
    finder = CriticalForceFinder(bench.simulator())
    state = bench.state(4)
    return [[E, *(finder.find(state, {"E": E}, border=b).value for b in Border)] for E in MODULI]


def compute_critical(bench: Workbench) -> ItemOutcome:
    """§3.4: which initial force separates lift-off from impact."""
    critical = -bench.rigid(4).B / bench.rigid(4).A
    rows = bench.shared("thresholds", lambda: _thresholds(bench))
    at = {row[0]: row for row in rows}[STIFF]
    excess = np.array([row[2] / critical - 1 for row in rows])
    tends = bool(np.all(np.diff(excess) < 0)) and excess[-1] < 0.005
    same = abs(at[1] / critical - 1) < 1e-3
    moduli = [row[0] for row in rows]
    at_all, before = ([row[i] / critical for row in rows] for i in (1, 2))
    panel = Panel(
        MODULUS,
        Axis(r"$F_{n0}\,/\,F_n^*$"),
        (
            line("slip stops before maximum compression", moduli, before, "points"),
            line("slip stops at all", moduli, at_all, "points"),
            line("$F_n^*=-B/A$", [moduli[0], moduli[-1]], [1.0, 1.0], "reference"),
        ),
    )
    orders = np.diff(np.log10(excess)) / np.diff(np.log10(moduli))
    return ItemOutcome(
        f"F_n* = {critical:.3f} N; at E = {modulus_text(STIFF)} the slip stops from {at[1]:.4f} N, "
        f"before the maximum from {at[2]:.4f} N",
        Verdict.of(same, corrected=not tends),
        {"order": orders[-1]},
        {
            "F_n*": critical,
            "slip_stops": at[1],
            "slip_stops_before_maximum": at[2],
            "table": table(
                ["E (Pa)", "slip stops from (N)", "before the maximum from (N)"],
                [list(row) for row in rows],
            ),
        },
        (panel,),
    )


def compute_unstable(bench: Workbench) -> ItemOutcome:
    """§3.4: sliding with F_n* is left on both sides."""
    critical = -bench.rigid(4).B / bench.rigid(4).A
    kinds = {}
    for part in (0.99, 1.05):
        run = bench.simulator().run(
            bench.state(4),
            t_end=1.0,
            parameters={"E": STIFF},
            until="separation",
            initial_force=part * critical,
        )
        times = np.linspace(0.0, run.final_time, 400)
        ratio = run.values("normal_force", times) / bench.sliding_force_along(run, times)
        kinds[part] = [e.kind for e in run.events], float(np.max(ratio))
    checks = {
        "1 % less: lifts off": "slip_stop" not in kinds[0.99][0] and kinds[0.99][1] < 1,
        "5 % more: impact": "slip_stop" in kinds[1.05][0] and kinds[1.05][1] > 2,
    }
    return checked(
        f"from 0.99 F_n* lifts off, from 1.05 F_n* impact with {kinds[1.05][1]:.0f} times −B/A",
        checks,
        {"events": {str(k): v[0] for k, v in kinds.items()}},
        modulus=modulus_text(STIFF),
    )


COMPUTE = {
    "jump-values": compute_values,
    "jump-convergence": compute_convergence,
    "jump-precision": compute_precision,
    "critical-force": compute_critical,
    "unstable": compute_unstable,
}
