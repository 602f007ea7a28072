"""How good is the jump rule if it keeps the free acceleration B, and which error remains?

The rod of the paper, E in Pa, velocities in m/s and rad/s. Three rules (classical: K to infinity;
frozen: A and B of the start kept; carried: A and B where the impulse acts) against compliant runs,
from three kinds of start, and a linear contact with a dashpot. Writes corrected-jump.png, .svg and
.json (the numbers) into the folder given, by default out/.
"""

import json
import math
import sys
from pathlib import Path

import numpy as np

import painleve_sym as ps
from painleve_sym.motion import CorrectedJumpRule, FrozenImpactSolver
from painleve_sym.papers.impact_resolution.beyond import compute_corrected
from painleve_sym.papers.impact_resolution.runs import Workbench
from painleve_sym.present.figures import draw
from painleve_sym.present.report import save

PAPER_EXPONENT = 1.764  # of the paper's law, which is that of no material

bench = Workbench()
outcome = compute_corrected(bench)
print("Table 3: error of the rebound y_A_dot(t3) and its local order")
print(f"{'E':>9} {'softened':>10}" + 2 * f" {'classical':>10} {'frozen':>10} {'carried':>10}")
for velocity, *numbers in outcome.data["table"]["rows"]:
    if velocity == "y_A_dot":
        E, softened, *errors = (math.nan if x is None else x for x in numbers)
        texts = [f"{x:10.2e}" for x in errors[:3]] + [f"{x:10.3f}" for x in errors[3:]]
        print(f"{E:9.2e} {softened:10.6f} {' '.join(texts)}")
print(f"order of the classical rule tends to -1/(2n) = {-1 / (2 * PAPER_EXPONENT):.4f}")
for velocity, drift in outcome.data["drift"].items():
    limit = outcome.data["drift_limit"][velocity]
    print(
        f"frozen leaves t1 times {limit:.4f} in {velocity}; drift of the classical rule {drift:.4f}"
    )

rod, law = ps.model("rod"), ps.laws.bilinear_hertz(n=PAPER_EXPONENT, reload="virgin")
numbers_of = {
    "computed": {
        "version": ps.__version__,
        "law": f"{law.name}, reload=virgin: that of the seed paper",
        "n": PAPER_EXPONENT,
    },
    "rules": outcome.data["table"],
    "starts": {},
    "dampings": {},
}
simulator = ps.Simulator(rod, law)
print("\nother starts: y_A_dot after the impact")
print(f"{'start':40} {'classical':>10} {'frozen':>10} {'carried':>10} {'softened':>10}")
table_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
table_4 = {**table_3, "theta_dot": 5.0}
for name, state, force, E in (
    ("Table 3, surface energy of 100 N", table_3, 100.0, 20.9e14),
    ("Table 6, surface energy of 500 N", table_4, 500.0, 20.9e16),
    ("Table 6, surface energy of 1000 N", table_4, 1000.0, 20.9e16),
    ("Table 3, approach at 0.01 m/s", {**table_3, "y_A_dot": -0.01}, 0.0, 20.9e14),
    ("Table 3, approach at 0.1 m/s", {**table_3, "y_A_dot": -0.1}, 0.0, 20.9e14),
):
    values = [ps.evaluate_jump(rod, "energetic", state).velocity["y_A_dot"]]
    for configuration in ("frozen", "carried"):
        jump = ps.evaluate_corrected_jump(
            rod, law, state, parameters={"E": E}, initial_force=force, configuration=configuration
        )
        values.append(jump.velocity["y_A_dot"])
    run = simulator.run(
        state,
        t_end=1.0,
        parameters={"E": E},
        until="separation",
        initial_force=force or None,
        rtol=1e-12,
    )
    values.append(run.final["y_A_dot"])
    numbers_of["starts"][name] = values
    print(f"{name:40} " + " ".join(f"{value:10.6f}" for value in values))

print("\nlinear contact k = 1e20 N/m, damping c/sqrt(k): rebound over |v_n1|, and its limits")
at = CorrectedJumpRule(rod, law).coefficients(
    {**dict.fromkeys(rod.state_names, 0.0), **table_3},
    {p.name: p.default for p in (*rod.system.parameters, *law.parameters)},
)
contact = {name: float(at[name]) for name in ("W_nn", "W_nt", "W_tt", "b_n", "b_t", "mu")}
A = contact["W_nn"] + contact["mu"] * contact["W_nt"]
A_stick = contact["W_nn"] - contact["W_nt"] ** 2 / contact["W_tt"]
v_n1 = abs(A / (contact["W_nt"] + contact["mu"] * contact["W_tt"]))
print(f"no damping: sqrt(1 + A'/|A|) = {math.sqrt(1 + A_stick / -A):.6f}")
k, dampings = 1e20, np.array([0.0, 0.1, 1.0, 10.0, 100.0])
impacts = FrozenImpactSolver(ps.law("linear"))(
    contact, {"slip_velocity": -1.0}, {"k": k, "c": dampings * math.sqrt(k)}
)
for damping, velocity in zip(dampings, impacts.head["normal_velocity"], strict=True):
    strong = (1 / -A + 1 / A_stick) / damping**2 if damping else math.inf
    numbers_of["dampings"][f"{damping:g}"] = velocity / v_n1
    print(f"{damping:6.1f} {velocity / v_n1:13.6e}   strong damping: {strong:13.6e}")

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(parents=True, exist_ok=True)
text = json.dumps(numbers_of, indent=1) + "\n"
(folder / "corrected-jump.json").write_text(text, "utf-8")
print(f"\nwritten: {', '.join(map(str, save(draw(outcome.panels), folder / 'corrected-jump')))}")
