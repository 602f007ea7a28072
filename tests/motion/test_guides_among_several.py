"""Guides beside contacts that open, through impacts of both."""

from dataclasses import replace

import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import StopReason
from painleve_sym.laws.catalogue import one_law
from painleve_sym.motion.simulator import Simulator

START = {"theta": 0.01, "x_A_dot": -0.5}
SOFT = {"k_B": 1e5, "c_B": 10.0, "beta": 0.0}


def _guided_block():
    block = model("block-two-feet")
    held, free = block.contacts
    return replace(block, contacts=(replace(held, bilateral=True), free))


def test_guide_beside_a_compliant_foot_keeps_its_gap_and_the_energy():
    laws = {"A": one_law("rigid"), "B": one_law("linear")}
    run = Simulator(_guided_block(), laws).run(START, parameters=SOFT, t_end=0.3)
    assert run.stop_reason is StopReason.T_END
    assert run.final["y_A"] == 0 and run.final["y_A_dot"] == 0
    assert run.energy_residual < 1e-9


def test_impacts_beside_a_guide_without_friction_are_those_of_a_pendulum():
    """The foot on a pivot-like guide without friction: the motion keeps y_A = 0 and the energy."""
    for e in (0.0, 0.6, 1.0):
        run = Simulator(_guided_block(), one_law("rigid")).run(
            {"theta": 0.2},
            parameters={"beta": 0.0, "mu_A": 0.0, "mu_B": 0.0, "e_energetic": e},
            t_end=1.0,
        )
        assert run.stop_reason is StopReason.T_END
        assert run.final["y_A"] == 0 and run.final["y_A_dot"] == 0
        assert run.energy_residual < 1e-9
        hits = run.events_of("impact")
        assert len(hits) >= 1 and all(h.impulses[2] > 0 for h in hits if h.impulses)
        # Without friction a guide with a foot is one degree of freedom: each bounce keeps e.
        for hit, start in zip(hits, run.events_of("touchdown"), strict=False):
            assert hit.state["theta_dot"] == pytest.approx(
                -e * start.state["theta_dot"], rel=1e-9, abs=1e-12
            )


@pytest.mark.parametrize("engine", ["taylor", "compiled", "erk"])
def test_impacts_beside_a_guide_with_friction_close_the_energy(engine):
    options = {"parameters": {"beta": 0.0, "mu_A": 0.4, "mu_B": 0.6}, "t_end": 0.6}
    run = Simulator(_guided_block(), one_law("rigid"), engine).run(
        {"theta": 0.05, "theta_dot": 0.3}, **options
    )
    assert run.stop_reason is StopReason.T_END
    assert len(run.events_of("impact")) >= 2
    assert run.final["y_A"] == 0 and run.final["y_A_dot"] == 0
    assert run.energy_residual < 1e-9
    for hit in run.events_of("impact"):
        P_n, P_t = hit.impulses[:2]
        assert abs(P_t) <= 0.4 * abs(P_n) * (1 + 1e-9)
    kinds = [str(e.kind) for e in run.events]
    wanted = Simulator(_guided_block(), one_law("rigid")).run(
        {"theta": 0.05, "theta_dot": 0.3}, **options
    )
    assert kinds == [str(e.kind) for e in wanted.events]
    assert run.final["x_A"] == pytest.approx(wanted.final["x_A"], rel=1e-8)
