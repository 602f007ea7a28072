"""Code of a user of the package; mypy checks it and must reject each `# error:` line."""

import numpy as np

import painleve_sym as ps
from painleve_sym.at import ClassificationTable, JumpPhase, JumpResult
from painleve_sym.motion import EventRecord, Segment, SensitiveTrajectory
from painleve_sym.study import Border, CriticalForce, FitResult, RegionMap, SweepSummary

rod: ps.Mechanism = ps.models.rod(mu=1.5)
law: ps.ContactLaw = ps.laws.bilinear_hertz(E=20.9e14, reload="virgin")
rigid: ps.RigidLaw = ps.laws.rigid(restitution=ps.Restitution.POISSON, policy="slip", e=0.5)
start = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}

run: ps.Trajectory = ps.simulate(rod, law, start, t_end=1e-3, engine="taylor")
mixed = ps.simulate("block-two-feet", {"A": "hertz", "B": rigid}, t_end=1e-3)
seconds: float = run.events[0].time
kind: ps.EventKind = run.events[0].kind
batch: ps.BatchResult = ps.simulate_batch(rod, law, {"theta": np.linspace(0.9, 1.0, 3)}, t_end=1e-3)
case: ps.ContactCase = ps.classify(rod, start).case
jump: JumpResult = ps.evaluate_jump(rod, "energetic", start)
simulator = ps.Simulator(rod, law, engine=ps.EngineName.COMPILED)
again: ps.Trajectory = simulator.run(start, t_end=1e-3, record=ps.Record.EVENTS)
derivatives: SensitiveTrajectory = simulator.sensitivities(start, ["mu"], t_end=1e-3)
force: CriticalForce = ps.critical_force(rod, law, start, border=Border.COMPRESSION)
regions: RegionMap = ps.region_map("rod", ("theta", "theta_dot"), points=20)
timed: ps.Trajectory = ps.simulate(rod, law, {"theta": "30 deg"}, t_end="1 ms", initial_force="5 N")
ranged: RegionMap = ps.region_map(rod, "theta,mu", ranges={"theta": ("10 deg", "80 deg")})
event: EventRecord = run.events[0]
segment: Segment = run.segments[0]
solution: ps.ContactSolution = ps.classify(rod, start).solutions[0]
phase: JumpPhase = jump.phases[0]
result: FitResult = ps.fit("rod", law, "impacts.csv", ["mu"])
summary: SweepSummary = ps.sweep("grid.toml", "grid.nc")
points: int = summary["points"]
first: float | None = summary["quantities"]["theta_dot"]["from"]
columns: FitResult = ps.fit("rod", law, {"t": [0.0], "gap": [0.1]}, "mu", csv={"skip": 1})
in_order: ps.Trajectory = ps.simulate(rod, law, np.zeros(6), t_end=1e-3)
rows: ps.BatchResult = ps.simulate_batch(rod, law, start=run, t_end=2e-3)
table: ClassificationTable = ps.classify_batch(rod, {"theta": np.linspace(0.9, 1.0, 3)})

ps.simulate(rod, law, start)  # error: [call-arg]
ps.simulate(rod, law, start, t_end=1e-3, engine="fortran")  # error: [arg-type]
ps.simulate(rod, law, start, t_end=1e-3, tolerance=1e-9)  # error: [call-arg]
ps.laws.rigid(policy="jump")  # error: [arg-type]
ps.laws.bilinear_hertz(reload="never")  # error: [arg-type]
ps.models.rod(mu=None)  # error: [arg-type]
ps.models.step()  # error: [attr-defined]
nonsense = ps.nonsense  # error: [attr-defined]
ps.evaluate_jump(rod, "moreau", start)  # error: [arg-type]
simulator.run(start, t_end=None)  # error: [arg-type]
dataset: int = run.to_xarray()  # error: [assignment]
energy = run.energy  # error: [attr-defined]
seconds_of_sweep = summary["seconds"]  # error: [typeddict-item]
ps.simulate(rod, law, "theta=1", t_end=1e-3)  # error: [arg-type]
