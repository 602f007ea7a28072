"""Random motions of every named mechanism under every law and choice: impacts, jams, rest."""

from __future__ import annotations

import itertools
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from painleve_sym.choices import Friction, Policy, Reload, Restitution
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import Simulator
from tests.mechanics.catalogue import NAMES, ONE_CONTACT, SOFTENED, derived

FALLS = ("y", "y_A")
"""Coordinates that lift a mechanism off the ground."""


def configurations(name: str) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield the laws of a mechanism with their choices."""
    rigid = itertools.product(Restitution, Policy)
    if name in ONE_CONTACT and name not in SOFTENED:
        yield from (("rigid", {"policy": str(p)}) for p in Policy)
        return
    for friction in Friction:
        for kind in ("hertz", "linear", "hunt-crossley", "bilinear-hertz"):
            yield kind, {"friction": str(friction)}
        if friction is not Friction.SPRING:
            yield "bilinear-hertz", {"friction": str(friction), "reload": str(Reload.VIRGIN)}
    yield "bilinear-hertz-two-bodies", {}
    yield from (("rigid", {"restitution": str(r), "policy": str(p)}) for r, p in rigid)
    if name not in ONE_CONTACT:
        yield "A=rigid,B=hertz", {}
        yield "A=bilinear-hertz,B=rigid", {"friction": "stribeck"}
        yield "A=linear,B=hunt-crossley", {"friction": "static"}


CASES = [(n, kind, choices) for n in NAMES for kind, choices in configurations(n)]


def simulator(name: str, kind: str, choices: dict[str, str], engine: str) -> Simulator:
    """Return the simulator of a case."""
    return Simulator(derived(name), law(kind, **choices), engine)


def spread(rng: np.random.Generator, least: float, most: float) -> float:
    """Return a number that is uniform by its logarithm."""
    return float(np.exp(rng.uniform(np.log(least), np.log(most))))


def motions(sim: Simulator, count: int, seed: int = 0) -> Iterator[dict[str, Any]]:
    """Yield arguments of `Simulator.run`, the same ones for every engine."""
    laws = (law_ for law_ in sim.contact.own_laws if law_.is_compliant)
    compliant = {p.name for law_ in laws for p in law_.parameters}
    for i in range(count):
        key = f"{sim.mechanism.name} {sim.label} {sim.choices} {seed} {i}"
        rng = np.random.default_rng(zlib.crc32(key.encode()))
        state, parameters = _start(sim, rng)
        yield {
            "state": state,
            "parameters": parameters,
            "law_parameters": {
                p.name: _law_parameter(p, rng, plastic=p.name not in compliant)
                for p in sim.own_parameters
            },
            "t_end": spread(rng, 1e-3, 0.5),
            "max_events": 3000,
            "max_steps": 20_000,
        }


def _law_parameter(p: Any, rng: np.random.Generator, *, plastic: bool) -> float:
    if p.name.startswith("e_"):
        e = float(
            rng.choice(
                [0.0 if plastic else 0.1, rng.uniform(0.05, 0.95), rng.uniform(0.05, 0.95), 1.0]
            )
        )
        return p.default if p.fault(e) else e
    if p.name.startswith("static_ratio"):
        return float(rng.uniform(1.0, 1.8))
    stiff = p.unit in ("Pa", "N/m")
    if stiff or p.name.startswith("c") or p.name.startswith("stribeck_velocity"):
        return p.default * spread(rng, 1e-4, 1e2) if p.default else spread(rng, 0.1, 1e3)
    return float(p.default)


def _start(sim: Simulator, rng: np.random.Generator) -> tuple[dict[str, float], dict[str, float]]:
    """Return a start that touches, is compressed or falls, near the mechanism's own."""
    m = sim.mechanism
    state = dict.fromkeys(m.state_names, 0.0) | dict(m.start)
    pace = spread(rng, 1e-4, 10.0)
    level = rng.random() < 0.1
    for c in m.system.coordinates:
        small = 1e-4 if "mode" in c.meaning else 1.0
        if c.name not in FALLS and not level:
            state[c.name] += small * float(rng.uniform(-0.2, 0.2)) * min(1.0, 10 * pace)
        state[c.rate.name] += small * pace * float(rng.normal())
    parameters = {p.name: float(p.default) for p in m.system.parameters}
    for p in m.system.parameters:
        if p.name.startswith("mu"):
            parameters[p.name] = spread(rng, 0.05, 3.0)
        elif p.unit in ("kg", "kg m^2") and rng.random() < 0.5:
            parameters[p.name] *= spread(rng, 0.5, 2.0)
    if "phi_0" in parameters:  # the guide holds the rod at this angle
        return state | {"phi_dot": 0.0}, parameters | {"phi_0": state["phi"]}
    gap = min(float(numbers([c.gap], state | parameters)[0]) for c in m.contacts)
    above = spread(rng, 1e-7, 0.03) if rng.random() < 0.4 else 0.0
    for name in FALLS:
        if name in state:
            return state | {name: state[name] + above - gap}, parameters
    return state, parameters | {"h": parameters["h"] - gap + above}
