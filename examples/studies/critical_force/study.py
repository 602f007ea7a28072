"""From which initial force does the paper's Table 4 impact, and how fast is sliding left?

The paper (§3.4) says that F_n* = -B/A separates lift-off from impact. Compliant runs give more: the
border at finite stiffness, its expansion in 1/lambda, and the growth of deviations. Forces in N,
E in Pa. Writes tables, figures and critical-force.json (all numbers) into the folder given as the
first argument, by default out/critical_force.
"""

import csv
import json
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import simpson

import painleve_sym as ps
from painleve_sym.arrays import Array
from painleve_sym.papers.panels import MODULUS, Axis, Panel, line
from painleve_sym.present.figure_of_outcome import outcome_figure
from painleve_sym.present.figures import draw
from painleve_sym.present.style import save
from painleve_sym.study.critical.bisection import Border, CriticalForceFinder
from painleve_sym.study.critical.continuation import critical_curve
from painleve_sym.study.critical.gradient import critical_force_gradient
from painleve_sym.study.critical.outcome_map import outcome_map

TABLE_4 = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
STIFF = 20.9e14
PAPER_EXPONENT = 1.764  # of the paper's law, which is that of no material
OTHERS = {
    "rod-inertia": ({"theta": 1.1, "theta_dot": 5.0, "x_A_dot": -1.0}, {"alpha": 3.5}),
    "eccentric-disc": ({"phi": 1.0, "phi_dot": -8.0, "x_dot": -3.0}, {"mu": 1.2}),
    "cart-pendulum": ({"phi": 2.7, "phi_dot": 5.0, "x_dot": -1.0}, {}),
}

POINTS = 81
OFFSET = 1e-10
"""Relative deviation of the force at the start: far above round-off, and linear for 20 e-folds."""
E_FOLDING_WINDOW = (4.0, 14.0)
"""Where the growth is read, in units of 1/λ: the decaying part is gone, the growing still small."""
SAMPLES = 41


def finder_of(name):
    law = ps.laws.bilinear_hertz(n=PAPER_EXPONENT, reload="virgin")
    return CriticalForceFinder(ps.Simulator(ps.model(name), law))


KEPT = {}
"""Every table by its name."""


def write(folder, name, head, rows):
    KEPT[name] = {"head": head, "rows": rows}
    with (folder / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([head, *rows])


def convergence(folder, finder):
    """Critical force over the stiffness, and what the expansion leaves."""
    moduli = np.geomspace(20.9e10, 20.9e22, 49)
    curves = {b: critical_curve(finder, TABLE_4, "E", moduli, border=b) for b in Border}
    stops, squeezes = curves[Border.SLIP_STOP], curves[Border.COMPRESSION]
    rest = [np.abs(stops.remainders(k)) for k in (1, 2, 3)]
    rows = np.column_stack([moduli, stops.forces, squeezes.forces, *rest])
    head = ["E", "slip_stop", "compression", "first", "second", "third"]
    write(folder, "convergence", head, rows.tolist())
    print(f"F_n* = -B/A = {stops.limits[0]:.6f} N")
    for row in rows[16::4]:
        print("E = {:8.2e}: {:.9f} and {:.9f}; left {:.1e}, {:.1e}, {:.1e}".format(*row))
    for k in (1, 2, 3):
        print(f"order after {k} term(s): {stops.orders(k)[-4]:.4f}, expected {-k / 3.528:.4f}")
    stiff = moduli >= 20.9e13
    gap = squeezes.forces - stops.forces
    gap[gap < 1e-11] = np.nan  # round-off
    force, left = Axis(r"$F_{n0}$", "N", limits=(130.0, 470.0)), Axis("difference", "N", log=True)
    panels = (
        Panel(
            MODULUS,
            force,
            (
                line("slip stops at all", moduli, stops.forces),
                line("slip stops in compression", moduli, squeezes.forces),
                line("$F_n^*=-B/A$", moduli, stops.limits, "reference"),
            ),
            title="critical forces",
        ),
        Panel(
            MODULUS,
            left,
            (
                line("critical force less 1 term", moduli[stiff], rest[0][stiff]),
                line("less 2 terms", moduli[stiff], rest[1][stiff]),
                line("less 3 terms", moduli[stiff], rest[2][stiff]),
                line("between both critical forces", moduli[stiff], gap[stiff]),
            ),
            title="their differences",
        ),
    )
    save(draw(panels), folder / "critical-force-convergence")


class Growth(NamedTuple):
    """A deviation from the sliding solution, m, and λ₊ along the run, 1/s, at the times.

    `measured` and `predicted` are ln of its growth from the first to the last, and ∫λ₊ dt.
    """

    times: Array
    deviation: Array
    rates: Array
    measured: float
    predicted: float

    @property
    def error(self):
        """measured/predicted − 1, which tends to 0 like 1/λ."""
        return self.measured / self.predicted - 1


def compare_growth(finder, state, parameters):
    """Two runs, from the critical force and from a part `OFFSET` above it: what separates them."""
    simulator = finder.simulator
    critical = finder.find(state, parameters, check_tolerance=False)
    first, last = (fold / critical.sliding.growth_rate for fold in E_FOLDING_WINDOW)
    times = np.linspace(first, last, SAMPLES)
    given = {"until": ("separation", "slip_stop"), "t_end": float(last), "rtol": finder.rtol}
    base, other = (
        simulator.run(state, parameters=parameters, initial_force=force, **given)
        for force in (critical.value, critical.value * (1 + OFFSET))
    )
    if min(base.final_time, other.final_time) < last:
        raise ValueError(f"the contact slides less than {last:g} s: give a stiffer one.")
    deviation = np.abs(other.values("compression", times) - base.values("compression", times))
    names = simulator.mechanism.state_names
    states = [{n: at[n] for n in names} for at in map(base.state, times.tolist())]
    rates = np.array([finder.analysis.along(at, parameters).growth_rate for at in states])
    grown = np.log(deviation[-1] / deviation[0])
    return Growth(times, deviation, rates, grown, simpson(rates, x=times))


def growth(folder, finder):
    """A deviation of 1e-10 of the force, in two runs, against the closed form."""
    rows, curves = [], []
    for E in (20.9e16, 20.9e18, 20.9e20):
        comparison = compare_growth(finder, TABLE_4, {"E": E})
        rows.append(
            [
                E,
                comparison.rates[0],
                comparison.measured,
                comparison.predicted,
                comparison.error,
            ]
        )
        print("E = {:8.2e}: lambda {:.5e} 1/s, grew by exp({:.5f}), closed form exp({:.5f})".format(
            *rows[-1][:4]
        ))  # fmt: skip
        folds = comparison.rates[0] * comparison.times
        rate = np.gradient(np.log(comparison.deviation), comparison.times, edge_order=2)
        power = round(np.log10(E / 20.9))
        curves.append(line(rf"$20.9\times 10^{{{power}}}$ Pa", folds, rate / comparison.rates))
    curves.append(line("closed form", folds, np.ones_like(folds), "reference"))
    write(folder, "growth", ["E", "lambda", "measured", "predicted", "error"], rows)
    ratio = Axis(r"measured rate / $\lambda(t)$", limits=(0.985, 1.002))
    panel = Panel(Axis(r"$\lambda t$"), ratio, tuple(curves))
    save(draw([panel]), folder / "critical-force-growth")


def maps(folder, finder):
    """Draw the outcome, lift-off or impact, over E and over the approach velocity."""
    over_E = outcome_map(
        finder, TABLE_4, "E", (20.9e12, 20.9e18), forces=(280.0, 420.0), points=POINTS
    )
    over_v = outcome_map(
        finder, TABLE_4, "y_A_dot", (-3e-3, 2e-3), points=POINTS, parameters={"E": STIFF}
    )
    for name, outcomes in (("E", over_E), ("approach", over_v)):
        outcomes.save(folder / f"critical-force-map-{name}.npz")
        save(outcome_figure(outcomes), folder / f"critical-force-map-{name}")
        print(f"map over {name}: {outcomes.counts}")


def derivatives(folder, finder):
    """Write the derivatives of the critical force of Table 4."""
    names = ["mu", "theta", "theta_dot", "x_A_dot", "y_A_dot", "m", "E", "e_energetic"]
    gradient = critical_force_gradient(finder, TABLE_4, names, parameters={"E": STIFF})
    for g in gradient.values():
        print(f"dF/d{g.name:12s} {g.value:18.9g} +- {g.error:.1e}")
    write(
        folder, "gradient", ["name", "value", "error"],
        [[g.name, g.value, g.error] for g in gradient.values()],
    )  # fmt: skip


def others(folder):
    """The same expansion for other mechanisms."""
    rows = []
    for name, (state, parameters) in OTHERS.items():
        critical = finder_of(name).find(state, {**parameters, "E": STIFF})
        terms = critical.sliding.expansion
        rows.append([name, *terms, sum(terms), critical.value])
        print("{}: {:.5f} {:+.5f} {:+.6f} = {:.6f} N; runs: {:.6f} N".format(*rows[-1]))
    write(folder, "others", ["mechanism", "limit", "first", "second", "sum", "computed"], rows)


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/critical_force")
    folder.mkdir(parents=True, exist_ok=True)
    finder = finder_of("rod")
    convergence(folder, finder)
    growth(folder, finder)
    maps(folder, finder)
    derivatives(folder, finder)
    others(folder)
    law = finder.simulator.law
    computed = {
        "version": ps.__version__,
        "law": f"{law.name}, reload=virgin: that of the seed paper",
        "n": PAPER_EXPONENT,
    }
    text = json.dumps({"computed": computed, **KEPT}, indent=1) + "\n"
    (folder / "critical-force.json").write_text(text, "utf-8")


if __name__ == "__main__":
    main()
