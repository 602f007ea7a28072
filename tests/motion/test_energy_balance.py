"""Energies and works are as exact as the states, on every engine, in runs and batches."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.automata.model import LOSSES
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, StopReason
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.energy_balance import balance_closes, balance_residual
from painleve_sym.motion.simulator import Simulator

ENGINES = ("compiled", "taylor", "erk")
COMPLIANT = ("bilinear-hertz", "hertz", "hunt-crossley", "linear")
QUICK_JAMS = {
    *(("bilinear-hertz", "compiled"), ("hertz", "taylor"), ("hunt-crossley", "compiled")),
    *((kind, "erk") for kind in COMPLIANT),
}
JAM = {"mu": 2.0}
"""The strut, pressed by the surface that it should slip on: its force grows without end."""
PUSHED = """
name = "pushed"
[coordinates]
x = { unit = "m", meaning = "place" }
y = { unit = "m", meaning = "height" }
[parameters]
m = { default = 1.0, unit = "kg", meaning = "mass", positive = true }
F = { default = 1e100, unit = "N", meaning = "force along the ground" }
mu = { default = 0.5, unit = "1", meaning = "friction coefficient" }
[energy]
kinetic = "m*(x_dot**2 + y_dot**2)/2"
potential = "-F*x"
[[contacts]]
name = "ground"
gap = "y"
slip_velocity = "x_dot"
friction = "mu"
"""


@cache
def strut(kind, engine):
    return Simulator(model("strut"), law(kind), engine)


@pytest.mark.parametrize(
    ("kind", "engine"),
    [
        pytest.param(k, e, marks=() if (k, e) in QUICK_JAMS else pytest.mark.slow)
        for k in COMPLIANT
        for e in ENGINES
    ],
)
def test_energy_of_a_jam_closes(kind, engine):
    run = strut(kind, engine).run(parameters=JAM, t_end=0.02)
    assert run.stop_reason is StopReason.T_END
    assert run.final["force_dissipation"] < -1e4
    assert run.energy_residual < 1e-10


@pytest.mark.parametrize("rtol", [1e-9, 1e-10, 1e-12])
@pytest.mark.parametrize("engine", ENGINES[:2])
def test_dissipation_in_a_jam_does_not_depend_on_the_tolerance(engine, rtol):
    """A tighter tolerance has steps of other lengths, in which the force grows by decades."""
    one = strut("hunt-crossley", engine).run(parameters=JAM, t_end=0.02, rtol=rtol)
    two = strut("hunt-crossley", "erk").run(parameters=JAM, t_end=0.02)
    assert one.energy_residual < 10 * rtol
    for name in ("contact_dissipation", "friction_dissipation", "force_dissipation"):
        assert one.final[name] == pytest.approx(two.final[name], rel=1e-7)


@pytest.mark.parametrize("engine", ENGINES[:2])
def test_forces_that_hold_a_slip_do_not_cancel_in_the_motion(engine):
    """Pressed for long, the strut rolls over a force of 3e9 N that does not accelerate it."""
    parameters = {"mu": 1.28, "E": 2.26e12, "e_energetic": 0.74}
    run = strut("bilinear-hertz", engine).run(parameters=parameters, t_end=0.5)
    assert run.final["force_dissipation"] < -4e8
    assert run.energy_residual < 1e-11
    assert run.counters["accepted_steps"] < 150


@pytest.mark.parametrize("engine", ENGINES[:2])
def test_works_of_a_batch_are_those_of_its_runs(engine):
    simulator = strut("hertz", engine)
    batch = run_batch(simulator, model("strut").start, {"mu": [1.8, 2.0, 2.2]}, t_end=0.02)
    run = simulator.run(parameters=JAM, t_end=0.02)
    assert batch["force_dissipation"][1] == run.final["force_dissipation"]


@pytest.mark.parametrize("engine", ["taylor", pytest.param("compiled", marks=pytest.mark.slow)])
def test_bounces_that_die_out_keep_the_energy_and_leave_a_body_at_rest(engine):
    """Gaps that close at one instant but for rounding lower the block; its weight does work."""
    feet = Simulator(model("block-two-feet"), law("rigid"), engine)
    start = {"y_A": 1.6e-5, "theta": 1.5e-5, "x_A_dot": 5e-3}
    parameters = {"mu_A": 0.2, "mu_B": 0.7, "e_energetic": 0.9, "beta": 0.0}
    run = feet.run(start, parameters=parameters, t_end=1.0)
    assert run.stop_reason is StopReason.T_END
    assert run.energy_residual < 1e-10
    # The velocities of the coordinates vanish with those of the feet.
    assert abs(run.events_of("settle")[-1].state["theta_dot"]) < 1e-20


def test_works_from_rest_are_exact_and_take_hardly_more_steps_than_free_ones():
    """The arm rests, its works end near 0.1 J: they have a size from the start."""
    angles = {"theta_1": -1.3, "theta_2": -1.8}
    height = -0.5 * (math.sin(-1.3) + math.sin(-1.8))
    simulator = Simulator(model("two-link-arm"), law("bilinear-hertz"), "taylor")
    given = {"parameters": {"h": height, "n": 1.764, "E": 20.9e14}, "t_end": 8e-4}
    scale = simulator.start(simulator.at(angles, given["parameters"])).scale
    free = np.where([name in LOSSES for name in simulator.outline.state_names], np.inf, scale)
    run, other, exact = (
        simulator.run(angles, rtol=rtol, atol=rtol * atol, **given)
        for rtol, atol in ((1e-11, scale), (1e-11, free), (1e-14, 1e-2 * scale))
    )
    for name in LOSSES:
        assert run.final[name] == pytest.approx(exact.final[name], rel=1e-11)
    assert run.counters["accepted_steps"] <= other.counters["accepted_steps"] + 2


# ---- balances that do not close ----


def with_free_works(simulator):
    """Return tolerances that leave the works out of the step control."""
    start = simulator.start(simulator.at(None, JAM))
    free = [name in LOSSES for name in simulator.outline.state_names]
    return np.where(free, np.inf, 1e-11 * start.scale)


def test_a_balance_that_does_not_close_is_said():
    simulator = strut("hertz", "taylor")
    run = simulator.run(parameters=JAM, t_end=0.02, atol=with_free_works(simulator))
    assert run.energy_residual == pytest.approx(0.081, abs=5e-4)
    assert run.energy_closes is run.to_dict()["energy_closes"] is False
    notice, *others = run.notices
    assert notice.startswith("The energy balance is off by 8.1 % of its largest term")
    exact = simulator.run(parameters=JAM, t_end=0.02)
    assert exact.energy_closes is True and list(exact.notices) == others
    ends = simulator.run(parameters=JAM, t_end=0.02, record="end")
    assert ends.energy_closes is None


@pytest.mark.parametrize(
    ("rtol", "least"), [(1e-15, 1e-9), (1e-11, 1e-8), (1e-6, 1e-3), (1e-2, 0.1)]
)
def test_a_balance_closes_within_a_thousand_times_the_tolerance(rtol, least):
    assert balance_closes(0.99 * least, rtol) is True
    assert balance_closes(1.01 * least, rtol) is False
    assert balance_closes(math.inf, rtol) is False
    assert balance_closes(math.nan, rtol) is None


def test_a_residual_is_the_largest_change_of_the_sum_by_the_largest_term():
    terms = {"kinetic_energy": [0.0, 3.0, 4.0], "potential_energy": [100.0, 96.0, 94.0]}
    arrays = {name: np.array(values) for name, values in terms.items()}
    # Sums 100, 99, 98; the potential energy falls by 6, more than the kinetic energy of 4.
    assert balance_residual(arrays) == pytest.approx(2 / 6)
    assert balance_residual(arrays, scale=20.0) == pytest.approx(0.1)
    arrays["kinetic_energy"][1] = np.nan
    assert balance_residual(arrays) == math.inf
    rest = {"kinetic_energy": np.array([0.0, 1e-20]), "potential_energy": np.array([1.0, 1.0])}
    assert balance_residual(rest) == 0.0


@pytest.mark.parametrize("engine", ENGINES)
def test_rows_of_a_batch_have_the_residual_of_their_ends(engine):
    """A loose tolerance makes residuals that are far above rounding."""
    simulator = Simulator(model("rod"), law("bilinear-hertz"), engine)
    states = {"theta": [1.0, 1.2, 1.5], "theta_dot": [1.0, -0.5, 0.0], "x_A_dot": -1.0}
    options = {"t_end": 2e-3, "rtol": 1e-4}
    batch = run_batch(simulator, states, **options)
    for i, residual in enumerate(batch["energy_residual"]):
        row = {"theta": states["theta"][i], "theta_dot": states["theta_dot"][i], "x_A_dot": -1.0}
        run = simulator.run(row, **options)
        terms = run.energies([0.0, run.final_time])
        change = float(np.diff(terms.pop("total"))[0])
        scale = simulator.start(simulator.at(row)).scale[run.state_names.index(LOSSES[0])]
        terms["potential_energy"] -= terms["potential_energy"][0]
        size = max(scale, *(abs(v).max() for v in terms.values()))
        assert residual == pytest.approx(abs(change) / size, rel=1e-6, abs=1e-15)
        assert residual > 1e-14
    assert batch.notices == ()


def test_a_batch_says_where_balances_do_not_close():
    states = {"theta": [1.0, 1.1, 1.2, 4.0], "x_A_dot": -1.0}
    simulator = Simulator(model("rod"), law("bilinear-hertz"))
    batch = run_batch(simulator, states, t_end=1e-3)
    # The last one is outside the domain and does not move.
    assert (batch["energy_residual"][:3] < 1e-9).all() and np.isnan(batch["energy_residual"][3])
    rows = replace(batch.rows, energy_residual=np.array([1e-12, 0.02, math.inf, math.nan]))
    (notice,) = replace(batch, rows=rows).notices
    assert notice.startswith("The energy balance of 2 of 4 motions does not close")
    rows = replace(batch.rows, energy_residual=np.array([1e-12, 0.02, 1e-7, math.nan]))
    assert "energy_residual up to 0.02" in replace(batch, rows=rows).notices[0]


def test_energies_that_are_not_finite_have_no_finite_residual(tmp_path):
    """A point above the ground is pushed until its energies overflow; its state does not."""
    path = tmp_path / "pushed.toml"
    path.write_text(PUSHED)
    pushed = Simulator(model(str(path)), law("linear"), "compiled")
    run = pushed.run({"y": 1.0}, parameters={"m": 1e-50}, t_end=1e5)
    assert np.isfinite(run.final_state).all()
    assert run.energy_residual == math.inf and run.energy_closes is False
    assert run.notices == ("The energies are not finite.",)
    assert run.energies(run.t)["total"].shape == run.t.shape
    rows = run_batch(pushed, {"y": [1.0]}, {"m": 1e-50}, t_end=1e5)
    assert rows["energy_residual"].tolist() == [math.inf]
    # A state that is not finite has such energies.
    lost = replace(run, final_state=np.full_like(run.final_state, math.nan))
    assert lost.energy_residual == math.inf


def test_a_spring_along_the_tangent_refuses_a_force_that_falls_to_nothing():
    spring = Simulator(model("rod"), law("bilinear-hertz", friction="spring"))
    with pytest.raises(InputError, match=r"got 0\.0, need a finite number with 0 < e_energetic"):
        spring.run(t_end=1e-3, parameters={"e_energetic": 0.0})
    with pytest.raises(InputError, match="0 < e_energetic"):
        law("bilinear-hertz").with_parameters(e_energetic=0.0).with_friction("spring")


@pytest.mark.parametrize("law", ["bilinear-hertz", "rigid"])
def test_balance_of_events_alone_is_that_of_the_whole_motion(law, tmp_path):
    arguments = ("rod", law, {"theta": 1.0, "y_A": 0.01})
    events, dense = (ps.simulate(*arguments, t_end=0.05, record=r) for r in ("events", "dense"))
    assert len(events.step_time) == 0 and events.energy_closes
    assert events.energy_residual == pytest.approx(dense.energy_residual, rel=0.2, abs=1e-14)
    events.save(tmp_path / "run.npz")
    loaded = ps.Trajectory.load(tmp_path / "run.npz")
    assert loaded.energy_residual == events.energy_residual
