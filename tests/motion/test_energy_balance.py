"""Energies and works are as exact as the states, on every engine, in runs and batches."""

from functools import cache

import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import StopReason
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.simulator import Simulator

ENGINES = ("compiled", "taylor", "erk")
COMPLIANT = ("bilinear-hertz", "hertz", "hunt-crossley", "linear")
JAM = {"mu": 2.0}
"""The strut, pressed by the surface that it should slip on: its force grows without end."""


@cache
def strut(kind, engine):
    return Simulator(model("strut"), law(kind), engine)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("kind", COMPLIANT)
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
def test_works_of_a_batch_are_those_of_its_runs(engine):
    simulator = strut("hertz", engine)
    batch = run_batch(simulator, model("strut").start, {"mu": [1.8, 2.0, 2.2]}, t_end=0.02)
    run = simulator.run(parameters=JAM, t_end=0.02)
    assert batch["force_dissipation"][1] == run.final["force_dissipation"]


@pytest.mark.parametrize("engine", ENGINES)
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
