"""Which parameter decides how fast the rod leaves the ground after a tangential impact?

The impact of Table 3 with the paper's law (n = 1.764, E = 20.9e14 Pa): derivatives of the
velocities and of the time at separation, each by a relative change of a parameter, through all four
events; then the gradient of the force that separates lift-off from impact (Table 4).
`... sensitive_impact.py STEM` draws the normal velocity and its derivatives over time to STEM.png
and STEM.svg, and keeps the numbers in STEM.json. SI units.
"""

import json
import sys
from pathlib import Path

import painleve_sym as ps
from painleve_sym.study import CriticalForceFinder, critical_force_gradient

WRT = ("mu", "e_energetic", "E", "n")
PARAMETERS = {"E": 20.9e14}
STATE = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
PAPER = ps.laws.bilinear_hertz(n=1.764, reload="virgin")
simulator = ps.Simulator(ps.model("rod"), PAPER)
sensitivities = simulator.sensitivities(
    STATE, WRT, parameters=PARAMETERS, t_end=0.01, until="separation"
)

values = simulator.parameters(PARAMETERS)
computed = {
    "version": ps.__version__,
    "law": f"{PAPER.name}, reload=virgin: that of the seed paper",
    "n": values["n"],
}
kept = {"computed": computed, "wrt": WRT, "events": {}, "velocities": {}, "critical force": {}}
print("change per relative change of  " + "".join(f"{w:>14s}" for w in WRT))
for event in sensitivities.events:
    row = [float(event.time_gradient[k] * values[w]) for k, w in enumerate(WRT)]
    kept["events"][event.event.kind] = row
    print(f"  t({event.event.kind}) [s]".ljust(31) + "".join(f"{v:14.5e}" for v in row))
for name in ("y_A_dot", "theta_dot"):
    gradient = sensitivities.final_gradient(name)
    row = [float(gradient[w] * values[w]) for w in WRT]
    kept["velocities"][name] = row
    print(f"  {name} at separation".ljust(31) + "".join(f"{v:14.5e}" for v in row))

finder = CriticalForceFinder(simulator)
slopes = critical_force_gradient(
    finder,
    STATE | {"theta_dot": 5.0},
    ("theta", "mu", "E", "n"),
    parameters=PARAMETERS,
    method="sensitivities",
)
print("critical force")
for name, slope in slopes.items():
    kept["critical force"][name] = float(slope.value)
    print(f"  by {name:12s} {slope.value: .6e} N per unit (+- {slope.error:.1e})")

if len(sys.argv) > 1:
    from painleve_sym.present.figure_of_sensitivity import sensitivity_figure
    from painleve_sym.present.style import save

    symbols = {"e_energetic": "e", "mu": r"\mu"}
    drawn = simulator.sensitivities(STATE, WRT, parameters=PARAMETERS, t_end=4.5e-4)
    figure = sensitivity_figure(drawn, "y_A_dot", r"$\dot{y}_A$ (m/s)", symbols, 3.95e-4)
    save(figure, Path(sys.argv[1]))
    text = json.dumps(kept, indent=1) + "\n"
    Path(sys.argv[1]).with_suffix(".json").write_text(text, "utf-8")
