"""Named mechanisms derived once per process, and random values for their symbols."""

from __future__ import annotations

from functools import cache

import numpy as np
import sympy as sp

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import MODELS


@cache
def derived(name: str) -> Mechanism:
    """Return a mechanism that keeps what was derived from it."""
    return model(name)


NAMES = sorted(MODELS)
ONE_CONTACT = [n for n in NAMES if n != "block-two-feet"]
SOFTENED = [n for n in ONE_CONTACT if n != "painleve-klein"]
"""By name, since deriving all of them takes seconds: a test compares them."""


def random_numbers(mechanism: Mechanism, rng: np.random.Generator) -> dict[str, float]:
    """Return random values by name: parameters of either sign where they may have it."""
    system = mechanism.system
    values = {c.name: float(rng.uniform(-1.4, 1.4)) for c in system.coordinates}
    values |= {c.rate.name: float(rng.uniform(-2, 2)) for c in system.coordinates}
    # Deflections are small: the terms of second order that modes leave out are round-off then.
    modal = [c.name for c in system.coordinates if "mode" in c.meaning]
    values |= {n: 1e-12 * values[n] for name in modal for n in (name, f"{name}_dot")}
    for p in system.parameters:
        low = 0.3 if p.lower == 0 else max(-1.4, p.lower)
        values[p.name] = float(rng.uniform(low, min(2.0, p.upper)))
    return values


def by_symbol(mechanism: Mechanism, numbers: dict[str, float]) -> dict[sp.Symbol, float]:
    """Return the same values by symbol."""
    return {s: numbers[s.name] for s in {*mechanism.system.symbols, *mechanism.motion}}
