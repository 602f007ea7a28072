"""The energy balance closes, whatever moves: random motions of all mechanisms, laws and engines."""

from __future__ import annotations

import pytest

from painleve_sym.choices import EngineName
from tests.mechanics.catalogue import derived
from tests.properties.energy_motions import CASES, motions, simulator

CLOSED = 2e-8
"""Of the Runge–Kutta engine on undamped modes of a bar: 1.5e-8, and 4e-12 at the rtol 1e-13."""
SERIES = (EngineName.TAYLOR, EngineName.COMPILED)
SAMPLE = [
    ("rod", "bilinear-hertz", {}),
    ("rod", "rigid", {}),
    ("strut", "hertz", {}),
    ("strut", "hunt-crossley", {}),
    ("block-two-feet", "rigid", {}),
    ("block-two-feet", "linear", {}),
]
"""Cases whose libraries other tests compile, too."""


def residuals(name, kind, choices, engine, count):
    sim = simulator(name, kind, choices, engine)
    for i, given in enumerate(motions(sim, count)):
        run = sim.run(**given)
        if len(run.step_time):
            yield i, run.stop_reason.label, run.energy_residual


def open_balances(*case):
    return [motion for motion in residuals(*case) if not motion[-1] < CLOSED]


@pytest.mark.parametrize("engine", SERIES)
@pytest.mark.parametrize(("name", "kind", "choices"), SAMPLE)
def test_energy_of_random_motions_closes(name, kind, choices, engine):
    assert open_balances(name, kind, choices, engine, 12) == []


@pytest.mark.slow
@pytest.mark.parametrize("k", range(len(CASES)), ids=lambda k: " ".join(map(str, CASES[k])))
def test_energy_of_random_motions_closes_for_every_mechanism_law_and_choice(k):
    """Engines of C take turns: 15 motions of each case, more than 3 000 in all."""
    assert open_balances(*CASES[k], SERIES[k % 2], 15) == []


ONE = [k for k, (name, *_) in enumerate(CASES) if len(derived(name).outline.contacts) == 1]
"""Cases of one contact, which the engine without compiled code runs."""


@pytest.mark.slow
@pytest.mark.parametrize("k", ONE[::4], ids=lambda k: " ".join(map(str, CASES[k])))
def test_energy_of_random_motions_closes_without_compiled_code(k):
    assert open_balances(*CASES[k], EngineName.ERK, 2) == []
