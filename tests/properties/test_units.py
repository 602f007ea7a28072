"""No result depends on the units of length, mass and time."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from painleve_sym.at.cases import classify
from painleve_sym.at.jump import evaluate_jump
from painleve_sym.at.tangential import tangential_impact
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.laws.catalogue import law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.toml.mechanism_file import load_mechanism
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.finite_stiffness import evaluate_corrected_jump
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.time_stepping.stepping import TimeStepper
from tests.support.paper_law import paper_law

DECADES = st.floats(-6.0, 6.0)
FACTORS = st.tuples(DECADES, DECADES, DECADES).map(lambda d: tuple(10.0**x for x in d))
"""Numbers of new units in one metre, one kilogram and one second."""
MILLI = (1e3, 1e3, 1e3)
"""The same for millimetre, gram and millisecond."""
_DERIVED = {"N": "kg m/s^2", "Pa": "kg/(m s^2)", "J": "kg m^2/s^2"}
_BASE = {"m": (1, 0, 0), "kg": (0, 1, 0), "s": (0, 0, 1), "rad": (0, 0, 0), "1": (0, 0, 0)}


def rigid_simulator(mechanism, engine="auto"):
    return Simulator(mechanism, RigidLaw(), engine)


@functools.cache
def dimension(unit: str) -> tuple[float, float, float]:
    """Return the powers of length, mass and time of a unit such as ``N m s/rad``."""
    above, _, below = unit.partition("/")
    powers = np.zeros(3)
    for part, sign in ((above, 1), (below.strip("()"), -1)):
        for name, power in re.findall(r"([A-Za-z]+|1)(?:\^([\d.]+))?", part):
            own = _BASE.get(name) or dimension(_DERIVED[name])
            powers += sign * float(power or 1) * np.array(own)
    return tuple(powers)


def factor(unit: str, factors: tuple[float, ...]) -> float:
    """Return the number of new units in one of the old."""
    return float(np.prod(np.power(factors, dimension(unit))))


def test_dimension_of_units_is_read_from_their_text():
    assert dimension("N m s/rad") == (2, 1, -1)
    assert dimension("Pa") == (-1, 1, -2)
    assert dimension("kg m^2") == (2, 1, 0)
    assert dimension("1/m") == (-1, 0, 0)


@dataclass(frozen=True)
class Motion:
    """One motion and what runs it."""

    mechanism: Callable[[], Mechanism]
    simulator: Callable[[Mechanism], Any]
    state: Mapping[str, float]
    t_end: float
    events: int
    """How many there are at least: a motion without events shows little."""
    parameters: Mapping[str, float] = field(default_factory=dict)
    initial_force: float | None = None


def _example(name: str) -> Callable[[], Mechanism]:
    return lambda: load_mechanism(f"examples/mechanisms/{name}.toml")


def _named(name: str) -> Callable[[], Mechanism]:
    return lambda: model(name)


def _rigid(engine: str) -> Callable[[Mechanism], Any]:
    return lambda mechanism: rigid_simulator(mechanism, engine=engine)


def _plural(*laws: Any) -> Callable[[Mechanism], Any]:
    def simulator(mechanism: Mechanism) -> Any:
        names = [c.name for c in mechanism.contacts]
        own = dict(zip(names, laws, strict=True)) if len(laws) > 1 else laws[0]
        return Simulator(mechanism, own)

    return simulator


def _compliant(name: str, **choices: str) -> Callable[[Mechanism], Any]:
    return lambda mechanism: Simulator(mechanism, law(name, **choices))


MOTIONS = {
    "rod, rigid, from rest": Motion(
        _named("rod"), rigid_simulator, {"y_A": 0.3, "theta": 1.0}, 0.75, 5
    ),
    "rod, rigid, bounces that die out": Motion(
        _named("rod"),
        rigid_simulator,
        {"y_A": 0.1, "theta": 1.3, "x_A_dot": 0.3},
        0.7,
        20,
        {"mu": 0.3, "e_energetic": 0.4},
    ),
    "rod, rigid, impact without collision": Motion(
        _named("rod"), rigid_simulator, {"theta": 1.0, "x_A_dot": -1.0}, 0.2, 3, {"mu": 2.0}
    ),
    "rod, rigid, Runge-Kutta": Motion(
        _named("rod"), _rigid("compiled"), {"y_A": 0.3, "theta": 1.0}, 0.75, 5
    ),
    "rod, compliant, pressed": Motion(
        _named("rod"),
        _compliant("bilinear-hertz"),
        {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0},
        0.01,
        2,
        {"E": 20.9e14},
        initial_force=100.0,
    ),
    "rod, compliant, Table 3": Motion(
        _named("rod"),
        _compliant("bilinear-hertz"),
        {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0},
        0.01,
        5,
        {"E": 20.9e14},
    ),
    "rod, tangential spring": Motion(
        _named("rod"),
        _compliant("linear", friction="spring"),
        {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0},
        0.006,
        5,
        {"tangential_stiffness": 8e7},
    ),
    "rod, Hertz's law and a tangential spring": Motion(
        _named("rod"),
        _compliant("hertz", friction="spring"),
        {"theta": 1.0, "x_A_dot": -0.3, "y_A_dot": -0.4, "y_A": 1e-3},
        0.006,
        4,
    ),
    "rod, Hertz's law with another exponent": Motion(
        _named("rod"),
        _compliant("hertz"),
        {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0},
        0.01,
        4,
        {"E": 20.9e13, "n": 1.2, "l_0": 0.01},
    ),
    "rod, static friction": Motion(
        _named("rod"),
        _compliant("hertz", friction="static"),
        {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0},
        0.01,
        4,
        {"E": 20.9e13, "static_ratio": 1.4},
    ),
    "rod, Stribeck's curve": Motion(
        _named("rod"),
        _compliant("hertz", friction="stribeck"),
        {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0},
        0.01,
        4,
        {"E": 20.9e13, "static_ratio": 1.4, "stribeck_velocity": 0.05},
    ),
    "rod, two bodies": Motion(
        _named("rod"),
        _compliant("bilinear-hertz-two-bodies"),
        {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0},
        0.01,
        5,
        {"E_1": 20.9e14, "E_2": 20.9e13, "kappa_2": 3.0},
    ),
    "disc, rigid": Motion(
        _named("eccentric-disc"), rigid_simulator, {"y": 0.5, "x_dot": 0.3, "phi": 0.4}, 1.5, 10
    ),
    "disc, rigid, from rest until it rests": Motion(
        _named("eccentric-disc"),
        rigid_simulator,
        {"y": 0.6},
        3.0,
        100,
        {"d": 0, "e_energetic": 0.4},
    ),
    "disc, compliant": Motion(
        _named("eccentric-disc"),
        _compliant("hunt-crossley"),
        {"y": 0.5, "x_dot": 0.3, "phi": 0.4},
        0.6,
        5,
        {"E": 2e7},
    ),
    "block, rigid": Motion(
        _named("block"), rigid_simulator, {"y_A": 0.1, "x_A_dot": -0.5, "theta": 0.1}, 0.4, 5
    ),
    "bead in a groove": Motion(
        _example("bead-in-groove"), rigid_simulator, {"phi": 0.8, "x_dot": 1.0}, 2.0, 3
    ),
    "block with two feet, rigid, from rest": Motion(
        _named("block-two-feet"),
        _plural(RigidLaw()),
        {"theta": 0.3},
        0.64,
        20,
        {"e_energetic": 0.3, "beta": 0.1, "mu_A": 0.5, "mu_B": 0.7},
    ),
    "block with two feet, compliant": Motion(
        _named("block-two-feet"),
        _plural(law("linear")),
        {"y_A": 1e-3, "theta": 0.02, "x_A_dot": -0.3},
        0.1,
        6,
        {"k": 1e5, "c": 40.0},
    ),
    "block with two feet, static friction and Stribeck's curve": Motion(
        _named("block-two-feet"),
        _plural(law("linear", friction="static"), law("linear", friction="stribeck")),
        {"y_A": 1e-3, "theta": 0.02, "x_A_dot": -0.3},
        0.1,
        6,
        {"k_A": 1e5, "c_A": 40.0, "k_B": 1e5, "c_B": 40.0, "stribeck_velocity_B": 0.05},
    ),
    "block with two feet, tangential springs": Motion(
        _named("block-two-feet"),
        _plural(law("linear", friction="spring"), law("hertz", friction="spring")),
        {"y_A": 1e-3, "theta": 0.02, "x_A_dot": -0.3},
        0.1,
        6,
        {
            "k_A": 1e5,
            "c_A": 40.0,
            "E_B": 2e7,
            "tangential_stiffness_A": 5e4,
            "tangential_stiffness_B": 5e4,
        },
    ),
    "block with two feet, rigid and compliant": Motion(
        _named("block-two-feet"),
        _plural(law("linear"), RigidLaw()),
        {"y_A": 1e-3, "theta": 0.02, "x_A_dot": -0.3},
        0.1,
        6,
        {"k_A": 1e5, "c_A": 40.0},
    ),
    "ladder, rigid": Motion(
        _named("ladder"), _plural(RigidLaw()), {"x": 1.7, "y": 1.3, "theta": 0.9}, 1.0, 3
    ),
    "mass on an oscillating table": Motion(
        _example("oscillating-table"), rigid_simulator, {"y": 0.02, "x_dot": 0.1}, 0.5, 4
    ),
}


LONG = {
    "bead in a groove",
    "block, rigid",
    "block with two feet, rigid and compliant",
    "block with two feet, static friction and Stribeck's curve",
    "block with two feet, tangential springs",
}
"""Which take seconds to derive and compile."""


@functools.cache
def _simulator(name: str) -> Any:
    return MOTIONS[name].simulator(MOTIONS[name].mechanism())


def _declared_units(simulator: Any) -> dict[str, str]:
    """Return the unit of every parameter and state."""
    return {p.name: p.unit for p in simulator.own_parameters} | simulator.mechanism.units


def _scaled(
    values: Mapping[str, float], units: Mapping[str, str], factors: Any
) -> dict[str, float]:
    return {n: v * factor(units[n], factors) for n, v in values.items()}


def _run(name: str, factors: tuple[float, ...]) -> Any:
    motion, simulator = MOTIONS[name], _simulator(name)
    parameters = simulator.parameters(motion.parameters)
    units = _declared_units(simulator)
    more = {}
    if motion.initial_force is not None:
        more["initial_force"] = motion.initial_force * factor("N", factors)
    return simulator.run(
        _scaled(motion.state, units, factors),
        parameters=_scaled(parameters, units, factors),
        t_end=motion.t_end * factor("s", factors),
        **more,
    )


@functools.cache
def _reference(name: str) -> Any:
    return _run(name, (1.0, 1.0, 1.0))


def _columns(run: Any, units: Mapping[str, str], factors: Any) -> dict[str, np.ndarray]:
    """Return times, coordinates and velocities of all events and of the end, in the old units."""
    columns = {"time": np.array([*(e.time for e in run.events), run.final_time])}
    for name in units:
        columns[name] = np.array([*(e.state[name] for e in run.events), run.final[name]])
    every = {"time": "s", **units}
    return {n: v / factor(every[n], factors) for n, v in columns.items()}


def _kinds(run: Any) -> list[tuple[str, ...]]:
    return [(str(e.kind), e.contact, e.mode_before, e.mode_after) for e in run.events]


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n in LONG else ()) for n in MOTIONS]
)
@settings(max_examples=20)
@given(factors=FACTORS)
@example(factors=MILLI)
def test_motion_is_the_same_in_any_units(name, factors):
    run, reference = _run(name, factors), _reference(name)
    assert len(reference.events) >= MOTIONS[name].events
    assert run.stop_reason is reference.stop_reason
    assert _kinds(run) == _kinds(reference)
    units = _simulator(name).mechanism.state_units
    same, need = _columns(run, units, factors), _columns(reference, units, (1.0, 1.0, 1.0))
    for column, values in need.items():
        # Much quicker than approx, for hundreds of events.
        np.testing.assert_allclose(
            same[column], values, 0, 1e-9 * np.abs(values).max(), equal_nan=False, err_msg=column
        )


@pytest.mark.parametrize("name", ["rod, rigid, from rest", "rod, compliant, Table 3"])
@settings(max_examples=5)
@given(units=st.lists(FACTORS, min_size=2, max_size=5))
def test_batch_has_the_same_rows_in_any_units(name, units):
    motion, simulator, reference = MOTIONS[name], _simulator(name), _reference(name)
    declared = _declared_units(simulator)
    # One run has one end time: the units differ where the time they are made of does not.
    factors = [(length, mass, 1.0) for length, mass, _ in units]

    def rows(values):
        own = [_scaled(values, declared, f) for f in factors]
        return {n: np.array([row[n] for row in own]) for n in values}

    batch = run_batch(
        simulator,
        rows(motion.state),
        parameters=rows(simulator.parameters(motion.parameters)),
        t_end=motion.t_end,
    )
    for name_, unit in simulator.mechanism.state_units.items():
        values = batch[name_] / [factor(unit, f) for f in factors]
        scale = abs(reference.final[name_]) + 1e-3
        assert values == pytest.approx(reference.final[name_], rel=0, abs=1e-9 * scale), name_


CONTACTS = {
    "rod": (_named("rod"), {"theta": 1.0, "x_A_dot": -1.0}, {}),
    "rod, inconsistent": (_named("rod"), {"theta": 1.0, "x_A_dot": -1.0}, {"mu": 2.0}),
    "rod, indeterminate": (
        _named("rod"),
        {"theta": 1.0, "x_A_dot": -1.0, "theta_dot": 5.0},
        {"mu": 2.0},
    ),
    "rod, at rest": (_named("rod"), {"theta": 1.2}, {"mu": 1.0}),
    "sliding rods in a guide": (_named("painleve-klein"), dict(model("painleve-klein").start), {}),
    "two-link arm": (_named("two-link-arm"), dict(model("two-link-arm").start), {}),
    "block with two feet": (_named("block-two-feet"), {"x_A_dot": -0.5}, {"beta": 0.3}),
    "block with two feet, at rest": (_named("block-two-feet"), {}, {"beta": 0.3}),
    "ladder": (_named("ladder"), dict(_named("ladder")().start), {}),
    "oscillating table": (
        _example("oscillating-table"),
        {"t": 0.01, "x": 1.0, "y": 0.01 * np.sin(0.4), "y_dot": 0.4 * np.cos(0.4), "x_dot": 1.0},
        {},
    ),
}


@functools.cache
def _classified(name: str, factors: tuple[float, ...]) -> Any:
    mechanism, (_, state, parameters) = _mechanism(name), CONTACTS[name]
    values = {p.name: p.default for p in mechanism.system.parameters} | parameters
    units = mechanism.units
    own = _scaled(values, units, factors)
    return classify(mechanism, _scaled(state, units, factors), parameters=own)


@functools.cache
def _mechanism(name: str) -> Any:
    return CONTACTS[name][0]()


def _forces(solution: Any, factors: Any) -> list[np.ndarray]:
    newton = factor("N", factors)
    return [np.append(s.normal_forces, s.tangential_forces) / newton for s in solution.solutions]


@pytest.mark.parametrize("name", CONTACTS)
@settings(max_examples=30)
@given(factors=FACTORS)
def test_contact_problem_is_the_same_in_any_units(name, factors):
    one = (1.0, 1.0, 1.0)
    reference, same = _classified(name, one), _classified(name, factors)
    assert same.case is reference.case
    assert same.contacts == reference.contacts
    assert [s.modes for s in same.solutions] == [s.modes for s in reference.solutions]
    for own, need in zip(_forces(same, factors), _forces(reference, one), strict=True):
        assert own == pytest.approx(need, rel=0, abs=1e-9 * np.abs(need).max(initial=0))


@pytest.mark.parametrize("parts", [0.4, -0.4, 2.5])
@settings(max_examples=30)
@given(factors=FACTORS)
def test_contact_is_closed_within_the_same_part_of_its_length(parts, factors):
    """The rod's length is 1 m: 1e-12 m of gap close its contact, in any units."""
    mechanism = model("rod")
    values = {p.name: p.default for p in mechanism.system.parameters}
    state = {"y_A": parts * 1e-12, "theta": 1.0, "x_A_dot": -1.0}
    given_state = _scaled(state, mechanism.units, factors)
    given_values = _scaled(values, mechanism.units, factors)
    if abs(parts) < 1:
        assert classify(mechanism, given_state, parameters=given_values).contacts == ("A",)
    else:
        with pytest.raises(InputError, match="the contact is open"):
            classify(mechanism, given_state, parameters=given_values)


@pytest.mark.parametrize("approach", [0.0, -0.5])
@settings(max_examples=30)
@given(factors=FACTORS)
def test_jump_is_the_same_in_any_units(approach, factors):
    mechanism, one = model("rod"), (1.0, 1.0, 1.0)
    state = {"theta": 1.0, "x_A_dot": -1.0, "y_A_dot": approach}
    values = {p.name: p.default for p in mechanism.system.parameters} | {"mu": 2.0}

    def jump(f):
        units = mechanism.units
        own = _scaled(values, units, f) | {"e_energetic": 0.6}
        return evaluate_jump(mechanism, "energetic", _scaled(state, units, f), parameters=own)

    reference, same = jump(one), jump(factors)
    assert (same.case, same.end) == (reference.case, reference.end)
    assert [p.name for p in same.phases] == [p.name for p in reference.phases]
    joule = factor("J", factors)
    assert same.energy_change / joule == pytest.approx(reference.energy_change, rel=1e-10)
    for name, value in reference.velocity.items():
        own = same.velocity[name] / factor(mechanism.units[name], factors)
        assert own == pytest.approx(value, rel=1e-10, abs=1e-10)


def _corrected(factors: Any, configuration: str, **changes: float) -> dict[str, float]:
    """Return the jump of the rod at finite stiffness by name, in the old units."""
    rod, paper = model("rod"), law("bilinear-hertz")
    units = {p.name: p.unit for p in paper.parameters} | rod.units
    values = {p.name: p.default for p in (*rod.system.parameters, *paper.parameters)}
    jump = evaluate_corrected_jump(
        rod,
        paper,
        _scaled({"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}, units, factors),
        parameters=_scaled(values | {"E": 20.9e14}, units, factors) | changes,
        initial_force=5.0 * factor("N", factors),
        configuration=configuration,
    )
    velocity = {name: v / factor(units[name], factors) for name, v in jump.velocity.items()}
    depth = jump.largest_compression / factor("m", factors)
    return velocity | {"depth": depth, "duration": jump.duration / factor("s", factors)}


@pytest.mark.parametrize("configuration", ["frozen", "carried"])
@settings(max_examples=10)
@given(factors=FACTORS)
@example(factors=MILLI)
def test_jump_at_finite_stiffness_is_the_same_in_any_units(configuration, factors):
    reference = _corrected((1.0, 1.0, 1.0), configuration)
    assert _corrected(factors, configuration) == pytest.approx(reference, rel=1e-9, abs=1e-12)


def test_without_its_reference_length_the_law_of_the_paper_depends_on_the_unit_of_length():
    """The same E, R and δ in mm with l_0 = 1: the force is 10^(3n − 4.5) times as large."""
    millimetre = (1e3, 1.0, 1.0)
    simulator = Simulator(model("rod"), paper_law())
    values = simulator.parameters()
    scaled = _scaled(values, _declared_units(simulator), millimetre)
    depth = simulator.compression_of_force(1.0, values)
    constants = simulator.constants(scaled | {"l_0": 1.0})
    numbers = {s: np.array([v]) for s, v in constants.items()}
    stiffness, exponent = (float(v[0]) for v in simulator.loading_curve(numbers))
    newton = factor("N", millimetre)
    force = stiffness * (depth * 1e3) ** exponent / newton
    assert force == pytest.approx(10 ** (3 * 1.764 - 4.5), rel=1e-12)
    assert force == pytest.approx(6.19, rel=1e-3)
    assert simulator.compression_of_force(newton, scaled) == pytest.approx(depth * 1e3, rel=1e-12)


@settings(max_examples=30)
@given(factors=FACTORS)
def test_tangential_impact_is_the_same_in_any_units(factors):
    mechanism = model("painleve-klein")
    values = {p.name: p.default for p in mechanism.system.parameters} | {"mu": 5.0}

    def impulse(f):
        units = mechanism.units
        state = _scaled(mechanism.start, units, f)
        impact = tangential_impact(mechanism, state, parameters=_scaled(values, units, f))
        return impact.normal_impulse / factor("N s", f)

    assert impulse(factors) == pytest.approx(impulse((1.0, 1.0, 1.0)), rel=1e-10)


@functools.cache
def _stepped(scheme: str, factors: tuple[float, ...]) -> Any:
    mechanism, second = model("rod"), factor("s", factors)
    values = {p.name: p.default for p in mechanism.system.parameters}
    state = _scaled({"y_A": 0.01, "theta": 1.0, "x_A_dot": -1.0}, mechanism.units, factors)
    own = _scaled(values, mechanism.units, factors)
    stepper = TimeStepper(mechanism, scheme)
    return stepper.run(state, step=0.002 * second, t_end=0.1 * second, parameters=own)


@pytest.mark.parametrize("scheme", ["moreau-jean", "stewart-trinkle"])
@settings(max_examples=10)
@given(factors=FACTORS)
def test_time_stepping_is_the_same_in_any_units(scheme, factors):
    reference, same = _stepped(scheme, (1.0, 1.0, 1.0)), _stepped(scheme, factors)
    assert same.stop_reason is reference.stop_reason
    newton_second = factor("N s", factors)
    need = reference.impulses
    assert np.abs(need).max() > 0
    assert same.impulses / newton_second == pytest.approx(need, rel=0, abs=1e-9 * need.max())
