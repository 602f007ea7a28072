"""Does a contact that yields along its tangent, too, remove the paradox of the rod?

The rod on the linear law with a tangential spring of stiffness k_t = ratio * k: the impact without
collision with constant coefficients, the rod of Table 3, the window of approaches that lead to an
impact in the indeterminate state of Table 4, and the convergence to a rigid tangent.

Run: python examples/studies/tangential_compliance.py [--quick] [--out STEM]
Prints the tables; writes STEM.png, STEM.svg (figure) and STEM.json (the numbers). SI units.
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import painleve_sym as ps
from painleve_sym.mechanics.general_contact import general_contact
from painleve_sym.present.style import DASHES, PAGE, PALETTE, REFERENCE, save, styled

DEFAULT = Path(__file__).parents[2] / "docs" / "figures" / "tangential-compliance"
TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
TABLE_4 = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
VELOCITIES = ("x_A_dot", "y_A_dot", "theta_dot")
# Mindlin: 2 (1 - nu)/(2 - nu) is 1 at nu = 0 and 2/3 at nu = 1/2.
MINDLIN = (2 / 3, 1.0)
STEEL = 2 * (1 - 0.3) / (2 - 0.3)
STIFF = 1e12  # N/m: the window of approaches is that of the limit to 1 %
CONVERGENCE = {
    "dashpot, slips all along": ({"x_A_dot": -3.0, "y_A_dot": -0.3}, {"mu": 0.3, "c": 3e3}, 0.02),
    "slip reverses": ({"x_A_dot": 0.3, "y_A_dot": -1.0}, {"mu": 0.2}, 0.02),
    "Table 3, while it sticks": (TABLE_3, {}, 0.00131),
    "Table 3, after separation": (TABLE_3, {}, 0.02),
}

RIGID, SPRING = (
    {
        name: ps.Simulator(mechanism, ps.law("linear", friction=friction))
        for name, mechanism in (("rod", ps.model("rod")), ("contact", general_contact()))
    }
    for friction in ("coulomb", "spring")
)


def run(name: str, state: dict[str, float], ratio: float, **options: Any) -> Any:
    """Return the motion with a tangential spring of ratio * k; inf: with a rigid tangent."""
    parameters = dict(options.pop("parameters"))
    options = {"until": "separation", "max_events": 100_000, **options}
    if math.isinf(ratio):
        return RIGID[name].run(state, parameters=parameters, **options)
    parameters["tangential_stiffness"] = ratio * parameters["k"]
    return SPRING[name].run(state, parameters=parameters, **options)


# ---- the impact without collision ----


def mobility() -> np.ndarray:
    """Return W of the slender rod (m = l = 1) at theta = 1."""
    sin, cos = math.sin(1.0), math.cos(1.0)
    return np.array([[1 + 3 * cos**2, -3 * sin * cos], [-3 * sin * cos, 1 + 3 * sin**2]])


def impact(mu: float, ratio: float) -> dict[str, float]:
    """Return the impact of a contact that slides at 1 m/s and is not driven, with k = 1 N/m.

    It starts on the growing solution of the slip, from a compression that is next to nothing.
    """
    W, depth = mobility(), 1e-9
    rate = math.sqrt(-(W[0, 0] + mu * W[0, 1]))
    contact = {"W_tt": W[1, 1], "kappa": W[0, 1] / W[1, 1], "b_t": 0.0, "b_n": 0.0, "mu": mu}
    contact["A_stick"] = W[0, 0] - W[0, 1] ** 2 / W[1, 1]
    start = {"x_t_dot": -1.0, "x_n": -depth, "x_n_dot": -rate * depth}
    own = run("contact", start, ratio, parameters={**contact, "k": 1.0}, t_end=1e5)
    after = np.array([own.final["x_n_dot"], own.final["x_t_dot"]])
    before = np.array([0.0, -1.0])
    energies = [v @ np.linalg.solve(W, v) for v in (after, before)]
    stop = own.events_of("slip_stop")[0].state["x_t_dot"]
    return {
        "ratio": ratio,
        "normal_velocity": float(after[0]),
        "tangential_velocity": float(after[1]),
        "energy_kept": float(energies[0] / energies[1]),
        "slip_velocity_at_stop": stop,
        "events": len(own.events),
    }


# ---- the rod ----


def table_3(ratio: float) -> dict[str, float]:
    """Return the rod of Table 3 at k = 1e8 N/m."""
    own = run("rod", TABLE_3, ratio, parameters={"k": 1e8}, t_end=0.05)
    times = np.linspace(0, own.final_time, 4000)
    return {
        "ratio": ratio,
        **{name: own.final[name] for name in VELOCITIES},
        "slip_stop": own.events_of("slip_stop")[0].time,
        "separation": own.final_time,
        "largest_force": float(own.values("normal_force", times).max()),
    }


def impacts(ratio: float, approach: float) -> bool:
    """Return whether the rod of Table 4 that lands has its slip stopped or reversed."""
    state = {**TABLE_4, "y_A_dot": -approach}
    own = run("rod", state, ratio, parameters={"k": STIFF}, t_end=0.1)
    return bool(own.final["x_A_dot"] > -0.5)


def border(ratio: float, low: float, high: float) -> float:
    """Return the approach between two outcomes, m/s."""
    first = impacts(ratio, low)
    while high - low > 1e-9 * high:
        middle = (low + high) / 2
        low, high = (middle, high) if impacts(ratio, middle) == first else (low, middle)
    return high


def windows(ratios: np.ndarray) -> tuple[float, list[dict[str, float]]]:
    """Return the critical approach of a rigid tangent, and the window of impacts by ratio."""
    critical = border(math.inf, 1e-5, 1e-3)
    rows = []
    for ratio in ratios:
        tried = critical * np.concatenate([np.linspace(0.9, 2.5, 33), np.geomspace(2.6, 4000, 150)])
        hits = [bool(impacts(float(ratio), float(v))) for v in tried]
        if not any(hits):
            rows.append({"ratio": float(ratio), "least": math.nan, "largest": math.nan})
            continue
        first = hits.index(True)
        last = next((i for i in range(first, len(hits)) if not hits[i]), len(hits) - 1)
        least = border(float(ratio), tried[first - 1], tried[first])
        largest = border(float(ratio), tried[last - 1], tried[last])
        rows.append({"ratio": float(ratio), "least": least, "largest": largest})
    return critical, rows


def errors(name: str, decades: range) -> list[dict[str, float]]:
    """Return the largest difference of a velocity from a rigid tangent, by decade of the ratio."""
    state, more, t_end = CONVERGENCE[name]
    options = {"parameters": {"k": 1e8, **more}, "t_end": t_end, "rtol": 1e-13}
    state = {"theta": 1.0, **state}
    rigid = run("rod", state, math.inf, **options)
    rows = []
    for decade in decades:
        own = [
            run("rod", state, 10.0 ** (decade + f), **options) for f in np.linspace(-0.4, 0.4, 9)
        ]
        worst = max(abs(r.final[n] - rigid.final[n]) for r in own for n in VELOCITIES)
        rows.append({"ratio": 10.0**decade, "error": worst})
    return rows


# ---- figure ----


def draw_impacts(axes: Axes, data: dict[str, Any]) -> None:
    """Draw the velocities after the impact without collision."""
    for i, (mu, rows) in enumerate(data["impact"].items()):
        x = [r["ratio"] for r in rows if math.isfinite(r["ratio"])]
        for name, dash in (("normal_velocity", DASHES[0]), ("tangential_velocity", DASHES[1])):
            y = [r[name] for r in rows if math.isfinite(r["ratio"])]
            text = rf"$v_{name[0]}^+$, $\mu = {mu}$"
            axes.plot(x, y, color=PALETTE[i + 1], linestyle=dash, label=text)
            axes.axhline(rows[-1][name], color=PALETTE[i + 1], linewidth=0.6, linestyle=DASHES[3])
    axes.axvspan(*MINDLIN, color=REFERENCE, alpha=0.3, linewidth=0)
    axes.set(xscale="log", xlabel="$k_t/k$", ylabel="velocity over that of the slip")


def draw_table_3(axes: Axes, data: dict[str, Any]) -> None:
    """Draw the rebound of the rod of Table 3."""
    rows = [r for r in data["table_3"] if math.isfinite(r["ratio"])]
    x = [r["ratio"] for r in rows]
    axes.plot(x, [r["y_A_dot"] for r in rows], color=PALETTE[1], label=r"$\dot{y}_A$")
    axes.plot(
        x, [r["x_A_dot"] for r in rows], color=PALETTE[2], linestyle=DASHES[1], label=r"$\dot{x}_A$"
    )
    for name, color in (("y_A_dot", PALETTE[1]), ("x_A_dot", PALETTE[2])):
        axes.axhline(data["table_3"][-1][name], color=color, linewidth=0.6, linestyle=DASHES[3])
    axes.plot([], [], color="black", linewidth=0.6, linestyle=DASHES[3], label="rigid tangent")
    band = "elastic contacts, $\\nu$ = 0 to 0.5"
    axes.axvspan(*MINDLIN, color=REFERENCE, alpha=0.3, linewidth=0, label=band)
    axes.set(xscale="log", xlabel="$k_t/k$", ylabel="velocity at separation (m/s)")


def draw_windows(axes: Axes, data: dict[str, Any]) -> None:
    """Draw the approaches that lead to an impact."""
    rows = [r for r in data["windows"] if not math.isnan(r["least"])]
    x = [r["ratio"] for r in rows]
    least, largest = ([r[n] for r in rows] for n in ("least", "largest"))
    axes.fill_between(x, least, largest, color=PALETTE[1], alpha=0.25, linewidth=0, label="impact")
    axes.plot(x, least, color=PALETTE[1])
    axes.plot(x, largest, color=PALETTE[1])
    every = [r["ratio"] for r in data["windows"]]
    text = r"$\mu |v_n| = (k_t/k) |v_t|$"
    axes.plot(every, [r / 1.4 for r in every], color=PALETTE[2], linestyle=DASHES[1], label=text)
    rigid = {"color": REFERENCE, "linewidth": 0.8, "label": "critical approach, rigid tangent"}
    axes.axhline(data["critical_approach"], **rigid)
    axes.set(xscale="log", yscale="log", xlabel="$k_t/k$", ylabel="approach (m/s)")


def draw_convergence(axes: Axes, data: dict[str, Any]) -> None:
    """Draw the differences from a rigid tangent."""
    for i, (name, rows) in enumerate(data["convergence"].items()):
        x, y = [r["ratio"] for r in rows], [r["error"] for r in rows]
        axes.plot(x, y, "o", linestyle=DASHES[i], color=PALETTE[i], markersize=2.5, label=name)
    axes.set(
        xscale="log", yscale="log", xlabel="$k_t/k$", ylabel="difference of a velocity (m/s, rad/s)"
    )


TITLES = (
    "impact without collision",
    "rebound of Table 3",
    "approaches that end in an impact",
    "what a rigid tangent leaves",
)


@styled
def figure(data: dict[str, Any]) -> Figure:
    """Return the figure of the study."""
    own = Figure(figsize=(PAGE, 6.6), layout="constrained")
    axes = own.subplots(2, 2).ravel()
    draws = (draw_impacts, draw_table_3, draw_windows, draw_convergence)
    for letter, axis, draw, title in zip("abcd", axes, draws, TITLES, strict=True):
        draw(axis, data)
        axis.set_title(f"({letter}) {title}")
        columns = 2 if letter in "ab" else 1
        axis.legend(loc="upper left", bbox_to_anchor=(0, -0.2), ncols=columns)
    return own


# ---- tables ----


def show(data: dict[str, Any]) -> None:
    """Print the tables of the page."""
    for mu, rows in data["impact"].items():
        print(
            f"impact without collision, mu = {mu}: ratio, v_n, v_t, energy kept, v_t at slip stop"
        )
        for r in rows:
            print(
                f"  {r['ratio']:<10.4g} {r['normal_velocity']:.6f} {r['tangential_velocity']:+.6f} "
                f"{r['energy_kept']:.4f} {r['slip_velocity_at_stop']:+.4f}"
            )
    print("Table 3, k = 1e8 N/m: ratio, y_A_dot, x_A_dot, theta_dot, slip stop, largest force")
    for r in data["table_3"]:
        print(
            f"  {r['ratio']:<10.4g} {r['y_A_dot']:.6f} {r['x_A_dot']:+.6f} {r['theta_dot']:.6f} "
            f"{r['slip_stop']:.6e} {r['largest_force']:.1f}"
        )
    print(f"Table 4, k = {STIFF:g} N/m: critical approach {data['critical_approach']:.6e} m/s")
    for r in data["windows"]:
        print(f"  {r['ratio']:<10.4g} {r['least']:.6e} to {r['largest']:.6e}")
    for name, rows in data["convergence"].items():
        print(f"convergence, {name}")
        for before, r in zip([None, *rows], rows, strict=False):
            order = math.log10(before["error"] / r["error"]) if before else math.nan
            print(f"  {r['ratio']:<10.4g} {r['error']:.3e}  order {order:.2f}")


def read(path: Path) -> dict[str, Any]:
    """Return the kept numbers; a ratio that is null is infinite, any other null is nan."""

    def finite(entry: dict[str, Any]) -> dict[str, Any]:
        lost = {name: math.inf if name == "ratio" else math.nan for name in entry}
        return {name: lost[name] if value is None else value for name, value in entry.items()}

    data: dict[str, Any] = json.loads(path.read_text("utf-8"), object_hook=finite)
    return data


def main() -> None:
    """Compute, print, and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few points")
    parser.add_argument("--out", type=Path, default=DEFAULT, help="stem of the files")
    parser.add_argument("--draw", action="store_true", help="draw the kept numbers again")
    arguments = parser.parse_args()
    quick = arguments.quick
    if arguments.draw:
        save(figure(read(DEFAULT.with_suffix(".json"))), arguments.out)
        return
    named = [1e-4, 1e-3, 1e-2, 0.1, MINDLIN[0], STEEL, 1.0, 10.0, 100.0, 1e4]
    fine = named if quick else sorted({*named, *np.geomspace(1e-4, 1e4, 161).tolist()})
    ratios = np.geomspace(6e-5, 5e-2, 3 if quick else 30)
    critical, rows = windows(ratios)
    decades = range(2, 5) if quick else range(8)
    data = {
        "computed": {
            "version": ps.__version__,
            "law": "linear, with and without a tangential spring",
            "n": 1,
        },
        "impact": {mu: [impact(mu, r) for r in (*fine, math.inf)] for mu in (1.4, 2.0)},
        "table_3": [table_3(r) for r in (*(r for r in fine if r >= 1e-3), math.inf)],
        "critical_approach": critical,
        "windows": rows,
        "convergence": {name: errors(name, decades) for name in CONVERGENCE},
    }
    near = {**data, "impact": {}}
    for mu, every in data["impact"].items():
        near["impact"][mu] = [r for r in every if r["ratio"] in named or math.isinf(r["ratio"])]
    wanted = [r for r in data["table_3"] if r["ratio"] in named or math.isinf(r["ratio"])]
    show({**near, "table_3": wanted})
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    save(figure(data), arguments.out)
    text = json.dumps(data, indent=1).replace("Infinity", "null").replace("NaN", "null")
    arguments.out.with_suffix(".json").write_text(text + "\n", "utf-8")


if __name__ == "__main__":
    main()
