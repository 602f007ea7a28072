"""Guides beside contacts that open: what is available, and how the rest ends."""

from dataclasses import replace

from painleve_sym.errors import StopReason
from painleve_sym.laws.catalogue import one_law
from painleve_sym.mechanics.models import model
from painleve_sym.simulate.factory import make_simulator

START = {"theta": 0.01, "x_A_dot": -0.5}
SOFT = {"k_B": 1e5, "c_B": 10.0, "beta": 0.0}


def _guided_block():
    block = model("block-two-feet")
    held, free = block.contacts
    return replace(block, contacts=(replace(held, bilateral=True), free))


def test_guide_beside_a_compliant_foot_keeps_its_gap_and_the_energy():
    laws = {"A": one_law("rigid"), "B": one_law("linear")}
    run = make_simulator(_guided_block(), laws).run(START, parameters=SOFT, t_end=0.3)
    assert run.stop_reason is StopReason.T_END
    assert run.final["y_A"] == 0 and run.final["y_A_dot"] == 0
    assert run.energy_residual < 1e-9


def test_impact_beside_a_guide_stops_with_its_reason():
    run = make_simulator(_guided_block(), one_law("rigid")).run(
        START, parameters={"beta": 0.0}, t_end=0.3
    )
    assert run.stop_reason is StopReason.NO_MODE
    assert "holds from both sides" in run.stop_detail
    assert run.final["y_A_dot"] == 0
