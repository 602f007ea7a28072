"""One motion in every engine: kinds of contacts and laws, and every named mechanism.

Tests elsewhere leave the engine open: here the others follow the same motions.

How far apart they may be follows from the tolerance: by no more than the tolerance itself, in
the scales that it is measured in, and what a hundred times looser one changes in both, which tells
how errors grow in that motion. Both must run through the same events and modes.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.laws.catalogue import law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.motion.simulator import Simulator
from tests.mechanics.catalogue import ONE_CONTACT, SOFTENED, derived
from tests.scenes import FEET, LADDER, TABLE
from tests.scenes import simulator as scene
from tests.support.paper_law import paper_law

ENGINES = ("compiled", "taylor")
ROD = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
TILTED = {"y_A": 1e-3, "theta": 0.02, "x_A_dot": -0.3}
SOFT = {"k": 1e5, "c": 40.0}
SCENES = {
    "static friction": ("rod", "hertz/static", ROD, {}, 0.006),
    "Stribeck friction": ("rod", "hertz/stribeck", ROD, {}, 0.006),
    "spring": ("rod", "linear/spring", ROD, {"tangential_stiffness": 1e6}, 0.006),
    "spring that reloads": ("rod", "bilinear-hertz/spring", ROD, {}, 0.006),
    "rigid feet": (FEET, "rigid", {"y_A": 0.05, "theta": 0.1, "x_A_dot": 0.3}, {}, 0.4),
    "soft feet": (FEET, "linear", TILTED, SOFT, 0.1),
    "feet that yield": (FEET, "bilinear-hertz", TILTED, {"E": 3e7}, 0.1),
    "rigid and soft foot": (FEET, "A=rigid,B=hertz", TILTED, {"E_B": 1e7}, 0.2),
    "sprung feet": (FEET, "bilinear-hertz/spring", TILTED, {"E": 3e7}, 0.1),
    "ladder on springs": (
        LADDER,
        "linear",
        {"x": 1.02, "y": 0.003, "theta": np.pi / 3, "theta_dot": 0.2},
        {"k": 1e5, "c": 10.0},
        0.2,
    ),
    "ladder that slides": (
        LADDER,
        "rigid",
        {"theta": 0.9, "x": 1.32, "theta_dot": -0.1, "x_dot": -0.9},
        {"e_energetic": 0.5},
        0.45,
    ),
    "three soft legs": (
        TABLE,
        "linear",
        {"y": 0.012, "theta": 0.011, "x_dot": 0.3, "theta_dot": -0.4},
        {"k": 1e5, "c": 30.0, "mu_left": 0.3, "mu_middle": 0.5, "mu_right": 0.6},
        0.1,
    ),
    "guide": ("painleve-klein", "rigid", {"phi": 1.2, "x_dot": 1.0}, {}, 0.3),
}
"""Mechanism, laws, start, parameters and end in s."""
LONG = {
    "feet that yield",
    "ladder on springs",
    "ladder that slides",
    "rigid and soft foot",
    "sprung feet",
    "three soft legs",
}
"""Which take seconds to compile."""
RTOL, LOOSE_RTOL = 1e-11, 1e-9
LONGEST = {"bilinear-hertz": 0.01, "rigid": 0.2}
ONE_ANGLE = ("strut", "pr-robot")
"""Elastic reload ends exactly where it began here: the last test of this file."""
EVERY = [(n, "bilinear-hertz") for n in SOFTENED] + [(n, "rigid") for n in ONE_CONTACT]
# An elastic bar bounces hundreds of times on a rigid contact, and differences grow at each impact.
EVERY.remove(("rod-bending", "rigid"))


@cache
def simulator(name: str, kind: str, engine: str):
    if kind == "rigid":
        return Simulator(derived(name), RigidLaw(), engine)
    reload = "virgin" if name in ONE_ANGLE else "elastic"
    return Simulator(derived(name), law(kind, reload=reload), engine)


def touching_start(name: str, rng: np.random.Generator):
    """Return a state near the mechanism's own, in contact, and parameters."""
    m = derived(name)
    values = dict.fromkeys(m.state_names, 0.0) | m.start
    for c in m.system.coordinates:
        if m.contact.gap != c.symbol:
            values[c.name] += rng.uniform(-0.2, 0.2)
        values[c.rate.name] += rng.normal()
    parameters = {p.name: p.default for p in m.system.parameters} | {"mu": rng.uniform(0.2, 1.6)}
    if name == "painleve-klein":  # the guide holds the rod at this angle
        parameters["phi_0"], values["phi_dot"] = values["phi"], 0.0
    elif "h" in parameters:
        parameters["h"] -= float(numbers([m.contact.gap], values | parameters)[0])
    return values, parameters


def run(name, kind, engine, start, rtol):
    state, parameters = start
    return simulator(name, kind, engine).run(
        state, parameters=parameters, t_end=LONGEST[kind], rtol=rtol, record="events"
    )


def sequence(t):
    return [(e.kind, e.mode_before, e.mode_after) for e in t.events]


def distance(a, b, scale):
    """Return the largest difference of times and states, each relative to its own size."""
    pairs = [(a.final_time, a.final_state, b.final_time, b.final_state)]
    for e, f in zip(a.events, b.events, strict=False):
        if (e.kind, e.mode_after) != (f.kind, f.mode_after):
            break  # one more or less of the bounces that die out: the end is compared all the same
        pairs.append((e.time, [*e.state.values()], f.time, [*f.state.values()]))
    s, x, t, y = (np.array(column) for column in zip(*pairs, strict=True))
    states = np.abs(x - y) / np.maximum(scale, np.max(np.abs(x), axis=0))
    return max(float(np.max(states)), float(np.max(np.abs(s - t))) / max(a.final_time, 1e-300))


def scales(name, kind, start):
    sim = simulator(name, kind, "compiled")
    return sim.start(sim.at(*start)).scale


def assert_engines_agree(name, kind, start):
    close = {e: run(name, kind, e, start, RTOL) for e in ENGINES}
    rough = {e: run(name, kind, e, start, LOOSE_RTOL) for e in ENGINES}
    a, b = close.values()
    scale = scales(name, kind, start)
    assert b.stop_reason is a.stop_reason
    assert sequence(b) == sequence(a)
    changes = sum(distance(close[e], rough[e], scale) for e in ENGINES)
    # Each engine is off by what a looser tolerance changes, and by its own.
    assert distance(a, b, scale) <= changes + len(ENGINES) * RTOL


@pytest.mark.parametrize(
    ("name", "engine"),
    [
        *(
            pytest.param(name, "compiled", marks=[pytest.mark.slow] * (name in LONG))
            for name in SCENES
        ),
        ("static friction", "erk"),
        ("guide", "erk"),
    ],
)
def test_engines_follow_one_motion(name, engine):
    mechanism, laws, start, parameters, t_end = SCENES[name]
    own, other = (
        scene(mechanism, laws, e).run(start, parameters=parameters, t_end=t_end, rtol=1e-10)
        for e in ("auto", engine)
    )
    assert (own.engine, other.engine) == ("taylor", engine)
    assert other.stop_reason is own.stop_reason
    assert sequence(other) == sequence(own)
    assert max(own.energy_residual, other.energy_residual) < 1e-8
    simulator = scene(mechanism, laws)
    scale = simulator.start(simulator.at(start, parameters)).scale
    assert distance(own, other, np.where(np.isinf(scale), 1.0, scale)) < 1e-7


@pytest.mark.parametrize("kind", LONGEST)
def test_engines_agree_on_the_rod(kind):
    rng = np.random.default_rng(3)
    for start in ((derived("rod").start, None), *(touching_start("rod", rng) for _ in range(3))):
        assert_engines_agree("rod", kind, start)


@pytest.mark.parametrize("rate", [3.38, 3.40, 3.42, 3.43])
def test_engines_agree_where_the_rod_hardly_presses(rate):
    # B = −0.07 m/s² and above zero soon after: without the contact force it would lift off at once.
    for E in (20.9e10, 20.9e14):
        start = derived("rod").start | {"theta_dot": rate}, {"E": E}
        assert_engines_agree("rod", "bilinear-hertz", start)
        taylor = simulator("rod", "bilinear-hertz", "taylor")
        run = taylor.run(start[0], parameters=start[1], t_end=0.01)
        assert run.energy_residual < 1e-10


@pytest.mark.slow
@pytest.mark.usefixtures("optimized")
@pytest.mark.parametrize(("name", "kind"), EVERY)
def test_engines_agree_on_every_mechanism(name, kind):
    rng = np.random.default_rng(5)
    for start in ((derived(name).start, None), *(touching_start(name, rng) for _ in range(12))):
        assert_engines_agree(name, kind, start)


@pytest.mark.slow
@pytest.mark.usefixtures("optimized")
@pytest.mark.parametrize("engine", ENGINES)
def test_elastic_reload_of_one_coordinate_ends_where_it_began(engine):
    """Whether the force reaches its largest value again is then decided by round-off.

    One coordinate and slip of one sign make a motion that has a first integral, as the force along
    the elastic curve depends on the compression alone: it comes back to rest at exactly the
    compression it left. ``yield`` and ``max_compression`` tie, and no engine can distinguish them.
    """
    strut = Simulator(derived("strut"), paper_law(), engine)
    run = strut.run(derived("strut").start, t_end=0.007, record="events")
    first, second = run.events_of("max_compression")
    assert second.compression == pytest.approx(first.compression, rel=1e-11)
    tied = [e for e in run.events if e.kind == "yield"]
    assert all(abs(e.time - second.time) < 1e-6 * second.time for e in tied)
