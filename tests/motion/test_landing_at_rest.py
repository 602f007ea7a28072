"""Landings without slip velocity: cone and slip are decided by a force that is hardly there yet."""

from __future__ import annotations

import numpy as np
import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.motion.batch.run import run_batch
from tests.scenes import simulator

CASES = {
    "rod": {"theta": (0.1, 3.0), "y_A_dot": (-1.0, 0.0)},
    "eccentric-disc": {"phi": (-3.0, 3.0), "y_dot": (-1.0, 0.0)},
    "cart-pendulum": {"phi": (-3.0, 3.0), "phi_dot": (-0.02, 0.02), "y_dot": (-0.2, 0.0)},
}
ROWS = 1000


def landings(name, seed=5):
    draw = np.random.default_rng(seed)
    states = {n: draw.uniform(*ends, ROWS) for n, ends in CASES[name].items()}
    return states, {"mu": draw.uniform(0, 2.5, ROWS)}


def both(name, law_name):
    runs = []
    for engine in ("auto", "compiled"):
        own = simulator(name, law_name, engine)
        runs.append(run_batch(own, *landings(name), t_end=0.01, rtol=1e-10, max_steps=2000))
    return runs


@pytest.mark.parametrize(
    ("name", "law_name"),
    [
        ("rod", "hertz"),
        ("rod", "bilinear-hertz"),
        ("eccentric-disc", "hunt-crossley"),
        ("cart-pendulum", "hertz"),
    ],
)
@pytest.mark.slow
def test_engines_agree_on_landings_at_rest(name, law_name):
    taylor, runge_kutta = both(name, law_name)
    assert taylor.counts() == runge_kutta.counts() == {"t_end": ROWS}
    for state in model(name).state_names:
        scale = np.abs(runge_kutta[state]).max() or 1.0
        assert np.abs(taylor[state] - runge_kutta[state]).max() < 1e-7 * scale
    other = (taylor["event_counts"] != runge_kutta["event_counts"]).any(axis=-1)
    # The cart with its pendulum may stick for 1e-10 s at first: shorter than the tolerance tells.
    assert other.sum() <= (0.1 * ROWS if name == "cart-pendulum" else 2)


@pytest.mark.slow
def test_cone_within_its_round_off_does_not_stop_the_time():
    # Deep in the ground; the damper all but cancels a force a million times larger.
    draw, arm = np.random.default_rng(100), model("two-link-arm")
    states = {
        name: arm.start.get(name, 0.0) + draw.normal(0, 1.0 if "dot" in name else 0.2, 20_000)
        for name in arm.state_names
    }
    parameters = {"mu": draw.uniform(0, 2, 20_000)}
    batch = run_batch(
        simulator("two-link-arm", "hunt-crossley"),
        states,
        parameters,
        t_end=2e-5,
        rtol=1e-10,
        max_steps=2000,
    )
    assert batch.counts() == {"t_end": 20_000}
