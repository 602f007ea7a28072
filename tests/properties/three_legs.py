"""Random drops of a table on three legs, rigid and compliant in every combination."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory
from tests.scenes import TABLE

FEET = ("left", "middle", "right")
COMPLIANT = ("linear", "hertz", "hunt-crossley", "bilinear-hertz")
LENGTHS = {"x": 1, "y": 1, "theta": 0, "x_dot": 1, "y_dot": 1, "theta_dot": 0}
TIMES = {"x": 0, "y": 0, "theta": 0, "x_dot": -1, "y_dot": -1, "theta_dot": -1}
UNITS = {
    "kg": (1, 0, 0), "kg m^2": (1, 2, 0), "m": (0, 1, 0), "m/s^2": (0, 1, -2), "1": (0, 0, 0),
    "N/m": (1, 0, -2), "N s/m": (1, 0, -1), "Pa": (1, -1, -2), "s/m": (0, -1, 1),
}  # fmt: skip
"""Powers of the units of mass, length and time in a unit."""


def _laws() -> Iterator[tuple[str, ...]]:
    """Yield the law of each foot: rigid and compliant in every combination, of four laws."""
    soft = itertools.cycle(COMPLIANT)
    for rigid in itertools.product((True, False), repeat=3):
        laws = tuple("rigid" if r else next(soft) for r in rigid)
        yield laws
        yield laws[::-1]
    yield from [("linear",) * 3, ("bilinear-hertz",) * 3, ("rigid", "bilinear-hertz", "rigid")]
    yield from [("hertz", "rigid", "linear"), ("linear", "rigid", "hertz")]


LAWS = tuple(dict.fromkeys(_laws()))
"""Laws of the three feet; the mirror image of each is among them."""


@dataclass(frozen=True)
class Drop:
    """A start of the table with its parameters and those of the laws, by the feet of the table."""

    start: dict[str, float]
    parameters: dict[str, float]
    own: dict[str, dict[str, float]]
    t_end: float
    e: float

    def mirrored(self) -> Drop:
        """Return the mirror image: right and left are exchanged, and the ways along the ground."""
        start = {k: v if k.startswith("y") else -v for k, v in self.start.items()}
        other = {"left": "right", "middle": "middle", "right": "left"}
        mu = {f"mu_{foot}": self.parameters[f"mu_{other[foot]}"] for foot in FEET}
        own = {foot: self.own[other[foot]] for foot in FEET}
        return replace(self, start=start, parameters=self.parameters | mu, own=own)


def _restitution(rng: np.random.Generator) -> float:
    """Return a coefficient of restitution that is neither 0 nor 1."""
    return float(rng.choice([0.3, 0.5, 0.75, rng.uniform(0.02, 0.98)]))


def drops(laws: tuple[str, ...], count: int, seed: int = 0) -> Iterator[Drop]:
    """Yield level and tilted drops with parameters of the laws of the feet."""
    rng = np.random.default_rng([seed, LAWS.index(laws)])
    for i in range(count):
        tilt = (0.0, 1e-12, 1.0, 1.0)[i % 4]
        start = {
            "theta": tilt * float(rng.uniform(-0.02, 0.02)),
            "y": float(rng.uniform(0.002, 0.012)),
            "x_dot": float(rng.choice([0.0, 1.0], p=[0.2, 0.8]) * rng.uniform(-0.2, 0.2)),
            "y_dot": float(rng.uniform(-0.12, 0.05)),
            "theta_dot": float(tilt * rng.choice([0.0, 1.0], p=[0.3, 0.7]) * rng.normal(0, 0.15)),
        }
        parameters = {
            "m": float(rng.uniform(2, 12)),
            "J": float(rng.uniform(0.3, 2.0)),
            "a": float(rng.uniform(0.3, 0.7)),
            "h": float(rng.uniform(0.3, 0.8)),
            "g": 9.8,
            **{f"mu_{foot}": float(rng.uniform(0.05, 0.9)) for foot in FEET},
        }
        start["y"] += parameters["a"] * abs(np.sin(start["theta"]))
        own = {foot: _own(name, rng) for foot, name in zip(FEET, laws, strict=True)}
        yield Drop(start, parameters, own, float(rng.uniform(0.15, 0.4)), _restitution(rng))


def _own(name: str, rng: np.random.Generator) -> dict[str, float]:
    stiff = float(np.exp(rng.uniform(np.log(1e4), np.log(1e6))))
    damped = float(rng.choice([0.0, 1.0]) * np.exp(rng.uniform(np.log(1.0), np.log(300.0))))
    if name == "linear":
        return {"k": stiff, "c": damped}
    return {
        "rigid": {},
        "hertz": {"E": 1e4 * stiff},
        "hunt-crossley": {"E": 1e3 * stiff, "c": 0.1 * damped},
        "bilinear-hertz": {"E": 1e3 * stiff, "e_energetic": _restitution(rng)},
    }[name]


@cache
def table(laws: tuple[str, ...], engine: str, *, backwards: bool = False) -> Simulator:
    """Return the table, its feet in the mechanism's order or from right to left."""
    mechanism = model(str(TABLE))
    if backwards:
        mechanism = replace(mechanism, contacts=mechanism.contacts[::-1])
    own = {foot: law(name) for foot, name in zip(FEET, laws, strict=True)}
    return Simulator(mechanism, own, engine)


def fall(
    sim: Simulator, drop: Drop, units: tuple[float, float, float] = (1.0, 1.0, 1.0), **options: Any
) -> Trajectory:
    """Run a drop, in units of mass, length and time that are these parts of kg, m and s."""
    values = sim.parameters(drop.parameters | _of_laws(sim, drop))
    declared = (*sim.mechanism.system.parameters, *sim.own_parameters)
    powers = {p.name: UNITS[p.unit] for p in declared}
    scaled = {k: v * _factor(units, powers[k]) for k, v in values.items()}
    start = {k: v * _factor(units, (0, LENGTHS[k], TIMES[k])) for k, v in drop.start.items()}
    limits = {"max_events": 20_000, "max_steps": 200_000} | options
    return sim.run(start, parameters=scaled, t_end=drop.t_end * units[2], **limits)


def _factor(units: tuple[float, float, float], powers: tuple[int, ...]) -> float:
    return float(np.prod([u**k for u, k in zip(units, powers, strict=True)]))


def _of_laws(sim: Simulator, drop: Drop) -> Mapping[str, float]:
    names = {p.name for p in sim.own_parameters}
    own = {f"{k}_{foot}": v for foot, law_ in drop.own.items() for k, v in law_.items()}
    if "e_energetic" in names:  # that of the rigid feet
        own["e_energetic"] = drop.e
    return own
