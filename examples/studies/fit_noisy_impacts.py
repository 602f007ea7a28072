"""Which restitution, friction and stiffness do noisy measurements of impacts give back?

Two synthetic experiments with known answers (E = 209e9 Pa, mu = 1.4, e = 0.75): forty tangential
impacts of the rod, of which the velocities after separation are measured with 2 mm/s and 4 mrad/s
of noise; and the force of one oblique impact, sampled every 20 microseconds with 5 N of noise.
`python examples/studies/fit_noisy_impacts.py DIR` writes the data files; without DIR they are read
from examples/studies/fit/ and the parameters are estimated. SI units.
"""

import sys
from pathlib import Path

import numpy as np

import painleve_sym as ps
from painleve_sym.study import FitProblem, read_fit_data

TRUTH = {"e_energetic": 0.75, "mu": 1.4, "E": 209e9}
GUESS = {"e_energetic": 0.5, "mu": 1.35, "E": 5e10}
SIGMAS = {"y_A_dot": 2e-3, "theta_dot": 4e-3, "normal_force": 5.0}
FALL = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0, "y_A_dot": -0.02}
simulator = ps.Simulator(ps.model("rod"), ps.law("bilinear-hertz"))


def write(folder):
    rng = np.random.default_rng(20240611)
    rows = ["start theta [rad],start theta_dot [rad/s],start x_A_dot [m/s],"
            "end y_A_dot [m/s],end theta_dot [rad/s]"]  # fmt: skip
    for _ in range(40):
        start = {
            "theta": round(rng.uniform(0.9, 1.2), 3),
            "theta_dot": round(rng.uniform(0.5, 1.5), 3),
            "x_A_dot": round(rng.uniform(-1.5, -0.7), 3),
        }
        run = simulator.run(start, parameters=TRUTH, t_end=1.0, until="separation")
        after = [run.final[n] + SIGMAS[n] * rng.standard_normal() for n in ("y_A_dot", "theta_dot")]
        rows.append(",".join([*map(str, start.values()), *(f"{v:.5f}" for v in after)]))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "impacts.csv").write_text("\n".join(rows) + "\n", "utf-8")
    times = np.arange(0, 101) * 2e-5
    run = simulator.run(FALL, parameters=TRUTH, t_end=1.0001 * times[-1])
    force = run.values("normal_force", times) + SIGMAS["normal_force"] * rng.standard_normal(101)
    lines = [f"{t:.5e},{f:.2f}" for t, f in zip(times, force, strict=True)]
    (folder / "force.csv").write_text("\n".join(["t [s],normal_force [N]", *lines, ""]), "utf-8")


def estimate(name, folder, state):
    data = read_fit_data(folder / name, simulator.mechanism)
    fit = FitProblem(simulator, data, tuple(TRUTH), state, GUESS).solve()
    print(f"{name}: {data.count} values, {fit.evaluations} evaluations")
    for i, parameter in enumerate(fit.names):
        low, high = fit.interval[i]
        print(f"  {parameter:12s} true {TRUTH[parameter]:8.4g}  estimate {fit.estimate[i]:10.5g}"
              f"  95 % interval {low:.5g} to {high:.5g}")  # fmt: skip


if len(sys.argv) > 1:
    write(Path(sys.argv[1]))
else:
    here = Path(__file__).parent / "fit"
    estimate("impacts.csv", here, {})
    estimate("force.csv", here, FALL)
