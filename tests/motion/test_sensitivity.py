"""Derivatives of motions of mechanisms, against differences of plain runs."""

from __future__ import annotations

import functools
import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, PainleveWarning, StopReason
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.motion.sensitivity import variational
from painleve_sym.motion.sensitivity.result import EventMarks
from painleve_sym.motion.simulator import Simulator
from tests.support.paper_law import paper_law

TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
TABLE_4 = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
HARD = {"E": 20.9e14}
WRT = ("theta", "y_A", "mu", "e_energetic", "E")


@functools.cache
def softened(name="rod"):
    return Simulator(model(name), paper_law(reload="virgin"))


def richardson(simulator, state, name, parameters, values, *, step=4e-4, levels=3, **options):
    """Differences of plain runs, extrapolated: what `values` of a run changes by per unit."""
    state, parameters = dict(state), simulator.parameters(parameters)
    force = options.pop("initial_force", None)

    def at(change):
        moved, p, f = dict(state), dict(parameters), force
        if name == "initial_force":
            f = force + change
        elif name in p:
            p[name] += change
        else:
            moved[name] = moved.get(name, 0.0) + change
        forced = {} if f is None else {"initial_force": f}
        return values(simulator.run(moved, parameters=p, rtol=1e-13, **forced, **options))

    given_force = force if name == "initial_force" else None
    size = abs(parameters.get(name, given_force or state.get(name, 0.0))) or 1.0
    steps = [step * size / 2**i for i in range(levels)]
    table = [(at(h) - at(-h)) / (2 * h) for h in steps]
    for order in range(1, levels):
        table = [(4**order * b - a) / (4**order - 1) for a, b in itertools.pairwise(table)]
    return table[0]


def end_and_times(run):
    return np.concatenate([run.final_state, [e.time for e in run.events]])


def assert_derivatives(simulator, state, wrt, parameters, tolerance=1e-8, step=4e-4, **options):
    """Final state and event times in every direction, in parts of the size of each quantity."""
    sensitivities = simulator.sensitivities(
        state, wrt, parameters=parameters, rtol=1e-12, **options
    )
    assert all(e.note == "" for e in sensitivities.events)
    rows = [sensitivities.final_jacobian, *(e.time_gradient[None] for e in sensitivities.events)]
    derivatives, plain = np.vstack(rows), end_and_times(sensitivities.trajectory)
    values = simulator.parameters(parameters) | dict(state)
    scale = np.maximum(np.abs(plain), 1e-3)
    for k, name in enumerate(wrt):
        size = abs(values.get(name, options.get(name, 0.0))) or 1.0
        exact = richardson(simulator, state, name, parameters, end_and_times, step=step, **options)
        error = np.abs(derivatives[:, k] - exact) * size / np.maximum(scale, np.abs(exact) * size)
        assert np.max(error) < tolerance, (name, error)
    return sensitivities


# ---- compliant ----


@pytest.mark.slow
def test_table_3_impact_through_every_event():
    sensitivities = assert_derivatives(
        softened(),
        TABLE_3,
        WRT[:1] + WRT[2:],
        HARD,
        t_end=0.01,
        until="separation",
    )
    kinds = [e.event.kind for e in sensitivities.events]
    assert kinds == ["slip_stop", "max_compression", "slip_start", "separation"]
    assert sensitivities.trajectory.stop_reason is StopReason.UNTIL


@pytest.mark.slow
def test_fall_impact_and_flight_at_a_fixed_end_time():
    start = TABLE_3 | {"y_A": 0.01}
    sensitivities = assert_derivatives(softened(), start, WRT, HARD, t_end=0.06)
    assert sensitivities.trajectory.stop_reason is StopReason.T_END
    np.testing.assert_array_equal(sensitivities.final_time_gradient, 0.0)
    np.testing.assert_array_equal(sensitivities.final_jacobian, sensitivities.fixed_time_jacobian)
    np.testing.assert_allclose(
        sensitivities.at(0.06)[0], sensitivities.final_jacobian, rtol=1e-9, atol=1e-12
    )


@pytest.mark.slow
def test_states_and_forces_between_events():
    start, options = TABLE_3 | {"y_A": 0.01}, {"t_end": 0.05}
    motion = softened().sensitivities(start, WRT, parameters=HARD, rtol=1e-12, **options)
    events = [e.event.time for e in motion.events]
    # Not so near an event that a difference reaches over it.
    times = np.array([0.5 * events[0], events[0] + 2e-4, events[-1] + 1e-3, 0.049])
    for k, name in enumerate(WRT):
        if name == "y_A":
            continue
        for quantity in ("y_A_dot", "theta", "normal_force"):
            exact = richardson(
                softened(), start, name, HARD,
                lambda run, q=quantity: run.values(q, times), step=1e-5, levels=2, **options,
            )  # fmt: skip
            derivative = motion.gradient(quantity, times)[:, k]
            size = (HARD | start | softened().parameters())[name] if name != "E" else HARD["E"]
            bound = 1e-6 * max(1.0, float(np.max(np.abs(exact) * size)))
            np.testing.assert_allclose(derivative * size, exact * size, rtol=1e-6, atol=bound)


@pytest.mark.slow
def test_where_an_event_ends_the_run_its_time_moves_along():
    run = softened().sensitivities(
        TABLE_3 | {"y_A": 0.01}, WRT, parameters=HARD, t_end=1.0, until="touchdown", rtol=1e-12
    )
    last = run.events[-1]
    np.testing.assert_array_equal(run.final_time_gradient, last.time_gradient)
    np.testing.assert_array_equal(run.final_jacobian, last.state_jacobian)
    gap = run.trajectory.state_names.index("y_A")
    # It ends where the gap is 0, whatever the direction.
    np.testing.assert_allclose(run.final_jacobian[gap], 0.0, atol=1e-12)
    rate = run.trajectory.final["y_A_dot"]
    np.testing.assert_allclose(
        run.fixed_time_jacobian[gap], -rate * run.final_time_gradient, rtol=1e-11, atol=1e-14
    )


@settings(max_examples=12)
@given(
    theta=st.floats(0.8, 1.2),
    theta_dot=st.floats(-1.0, 3.0),
    slip=st.floats(-1.5, 1.5),
    fall=st.floats(-0.5, -0.05),
    direction=st.lists(st.floats(-1, 1), min_size=4, max_size=4),
)
def test_any_direction_is_a_difference_of_two_runs(theta, theta_dot, slip, fall, direction):
    start = {
        "theta": theta, "theta_dot": theta_dot, "x_A_dot": slip, "y_A": 0.01, "y_A_dot": fall,
    }  # fmt: skip
    names = ("theta", "mu", "e_energetic", "E")
    sizes = np.array([1.0, 1.4, 0.75, HARD["E"]])
    options = {"t_end": 0.5, "until": "separation"}
    motion = softened().sensitivities(start, WRT, parameters=HARD, **options)
    if motion.trajectory.stop_reason is not StopReason.UNTIL:
        return
    if max(e.condition for e in motion.events) > 1e3:
        return  # a difference would reach beyond where it is linear
    ends = []
    for sign in (1, -1):
        change = dict(zip(names, sign * 1e-6 * sizes * np.array(direction), strict=True))
        moved = start | {"theta": theta + change["theta"]}
        base = softened().parameters(HARD)
        p = {n: base[n] + change[n] for n in names[1:]}
        run = softened().run(moved, parameters=p, rtol=1e-13, **options)
        if [e.kind for e in run.events] != [e.event.kind for e in motion.events]:
            return
        ends.append(run.final_state)
    columns = [WRT.index(n) for n in names]
    slope = motion.final_jacobian[:, columns] @ (sizes * np.array(direction))
    difference = (ends[0] - ends[1]) / 2e-6
    np.testing.assert_allclose(slope, difference, rtol=1e-4, atol=2e-5)


@pytest.mark.slow
def test_an_initial_force_moves_the_start():
    sim, wrt = softened(), ("initial_force", "E")
    assert_derivatives(
        sim, TABLE_4, wrt, HARD, tolerance=3e-8, initial_force=450.0, t_end=3e-4, step=2e-4
    )


@pytest.mark.slow
def test_eight_parameters_of_a_tangential_impact():
    names = ("mu", "e_energetic", "E", "n", "m", "l", "alpha", "g")
    assert_derivatives(
        softened("rod-inertia"), TABLE_3, names, HARD, t_end=0.01, until="separation",
        step=2e-3,
    )  # fmt: skip


ARM = {"theta_1": -0.6, "theta_2": -0.9272952180016122, "theta_1_dot": -0.3}
ARM_WRT = ("theta_1", "theta_2_dot", "mu", "e_energetic", "m_2", "l_1", "u")


@pytest.mark.parametrize(
    ("other", "name", "contact_law", "start", "wrt", "options"),
    [
        pytest.param(
            engine, "rod", paper_law(reload="virgin"), TABLE_3 | {"y_A_dot": -0.01},
            WRT, {"parameters": HARD, "t_end": 0.01, "until": "separation"}, id=f"rod-{engine}",
            marks=pytest.mark.slow if engine == "compiled" else (),
        )
        for engine in ("erk", "compiled")
    ]
    + [
        pytest.param(
            "compiled", "two-link-arm", contact_law, ARM, ARM_WRT,
            {"parameters": parameters | {"mu": 0.9}, "t_end": 0.12},
            id=f"arm-{contact_law.name}", marks=pytest.mark.slow,
        )
        for contact_law, parameters in (
            (paper_law(reload="virgin"), {"E": 20.9e12}),
            (RigidLaw(), {"e_energetic": 0.4}),
        )
    ],
)  # fmt: skip
def test_engines_agree(other, name, contact_law, start, wrt, options):
    simulators = (Simulator(model(name), contact_law, engine) for engine in ("taylor", other))
    a, b = (s.sensitivities(start, wrt, rtol=1e-12, **options) for s in simulators)
    assert (a.trajectory.engine, b.trajectory.engine) == ("taylor", other)
    scale = np.max(np.abs(a.final_jacobian), axis=0)
    np.testing.assert_allclose(b.final_jacobian / scale, a.final_jacobian / scale, atol=1e-8)
    for e, f in zip(a.events, b.events, strict=True):
        assert e.event.kind == f.event.kind
        np.testing.assert_allclose(f.time_gradient, e.time_gradient, rtol=1e-7, atol=1e-20)


@pytest.mark.slow
def test_arm_that_strikes_a_moving_belt():
    """Its gap is not a coordinate, and the belt drives it."""
    sim = Simulator(model("two-link-arm"), RigidLaw())
    run = assert_derivatives(
        sim, ARM, ARM_WRT, {"mu": 0.9, "e_energetic": 0.4}, t_end=0.12, tolerance=1e-8
    )
    assert "impact" in [e.event.kind for e in run.events]


def test_the_gap_of_a_touching_start_is_differentiated_towards_compression():
    """There the law is not smooth: (K δⁿ)'' is infinite at δ = 0."""
    options = {"parameters": HARD, "t_end": 0.01, "until": "separation", "rtol": 1e-13}
    column = softened().sensitivities(TABLE_3, WRT, **options).final_jacobian[:, WRT.index("y_A")]
    plain, pressed = (
        softened().run(TABLE_3 | {"y_A": -d}, **options).final_state for d in (0.0, 1e-12)
    )
    np.testing.assert_allclose(column, (plain - pressed) / 1e-12, rtol=2e-5)


# ---- rigid ----


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["energetic", "newton", "poisson"])
def test_rigid_impacts(rule):
    sim, wrt = Simulator(model("rod"), RigidLaw(rule)), ("y_A", "theta", "mu", f"e_{rule}")
    assert_derivatives(sim, TABLE_3 | {"y_A": 0.01, "y_A_dot": -0.5}, wrt, {}, t_end=0.15)


@pytest.mark.slow
def test_bounces_that_die_out_and_the_slip_after_them():
    start = {"theta": 0.7, "y_A": 0.01, "x_A_dot": -0.3}
    sensitivities = assert_derivatives(
        Simulator(model("rod"), RigidLaw()),
        start,
        ("y_A", "theta", "mu", "e_energetic"),
        {"mu": 0.3, "e_energetic": 0.3},
        t_end=0.3,
    )
    kinds = [e.event.kind for e in sensitivities.events]
    assert "settle" in kinds
    assert sensitivities.events[-1].event.time < 0.2
    assert sensitivities.trajectory.mode_names[sensitivities.trajectory.final_mode].startswith(
        "slip"
    )


# ---- what cannot be differentiated ----


def grazing_start(overshoot):
    """A rod whose end swings through its lowest point at a gap of −overshoot."""
    sim, state = softened(), {"theta": 1.0, "theta_dot": 8.0, "x_A_dot": -1.0, "y_A_dot": -0.3}
    run = sim.run(state | {"y_A": 0.1}, parameters=HARD, t_end=0.05, rtol=1e-13)
    times = np.linspace(1e-3, 0.049, 2001)
    t = times[int(np.argmin(run.values("y_A", times)))]
    for _ in range(50):
        t -= float(run.values("y_A_dot", t)[0]) / float(
            (run.values("y_A_dot", t + 1e-6)[0] - run.values("y_A_dot", t - 1e-6)[0]) / 2e-6
        )
    low = float(run.values("y_A", t)[0])
    return state | {"y_A": 0.1 - low - overshoot}, t


def test_a_grazing_event_is_reported_and_nothing_after_it_is_given():
    state, t = grazing_start(2e-12)
    with pytest.warns(PainleveWarning, match="touchdown.*tangentially"):
        run = softened().sensitivities(state, WRT, parameters=HARD, t_end=0.05)
    assert run.singular is not None
    assert (run.singular.event.kind, run.singular.note) == ("touchdown", "grazing")
    assert run.valid_until == pytest.approx(t, rel=1e-3)
    assert np.isnan(run.final_jacobian).all()
    assert np.isnan(run.at(t * 1.1)).all()
    assert np.isfinite(run.at(t * 0.9)).all()
    assert np.isnan(run.singular.time_gradient).all()
    # The motion itself is there to its end.
    assert run.trajectory.final_time == 0.05


def test_an_event_far_from_grazing_is_not_called_so():
    state, _ = grazing_start(1e-4)
    run = softened().sensitivities(state, WRT, parameters=HARD, t_end=0.05)
    assert run.singular is None
    assert run.events[0].condition < 1e5


def verdict(**given):
    """Condition and note of one event, at t = 1 s, by one direction of size 1."""
    base = {"guard": 0.0, "rate": -1.0, "bend": 0.0, "timed": False, "shift": 0.0}
    numbers = {name: np.array([value]) for name, value in (base | given).items()}
    numbers["shift"] = numbers["shift"][:, None]
    one = np.ones(1)
    marks = EventMarks(
        time=one, slopes=np.ones((1, 2)), time_gradient=numbers["shift"], notes=("",), **numbers
    )
    return marks.verdicts(one, 1e-11)[0]


def test_events_that_meet_by_chance_are_one_sided():
    assert verdict(shift=0.3) == (0.0, "one-sided")
    # The same surface twice: it moves no further. And one that lies well behind.
    assert verdict(shift=0.0) == (0.0, "")
    assert verdict(shift=0.3, guard=-1.0) == (0.0, "")


def test_a_guard_without_speed_has_no_time():
    assert verdict(shift=math.inf, rate=0.0, bend=1.0, timed=True)[1] == "grazing"


# ---- input ----


@pytest.mark.parametrize(
    ("wrt", "said"),
    [
        (("mue",), "Did you mean 'mu'"),
        (("mu", "mu"), "twice"),
        ((), "at least one"),
        (("initial_force",), "unknown direction 'initial_force'"),
        (("friction_dissipation",), "unknown direction"),
    ],
)
def test_directions_are_checked(wrt, said):
    with pytest.raises(InputError, match=said):
        softened().sensitivities(TABLE_3, wrt, t_end=0.01)


def test_a_rigid_contact_takes_no_initial_force():
    with pytest.raises(InputError, match="no compression"):
        Simulator(model("rod"), RigidLaw()).sensitivities(
            TABLE_3, ("mu",), t_end=0.01, initial_force=1.0
        )


def test_unknown_quantities_are_named():
    run = softened().sensitivities(TABLE_3, WRT, parameters=HARD, t_end=1e-4)
    with pytest.raises(InputError, match="normal_force"):
        run.gradient("normal_forse", 1e-5)
    with pytest.raises(InputError, match="theta_dot"):
        run.final_gradient("theta_dott")
    assert set(run.final_gradient("theta")) == set(WRT)
    data = run.to_dict()
    assert data["wrt"] == list(WRT)
    assert set(data["final_jacobian"]) == set(run.trajectory.state_names)


@pytest.mark.slow
def test_a_reset_without_a_derivative_is_reported():
    """At e = 0 the speed after an impact is a square root at zero."""
    sim, state = Simulator(model("rod"), RigidLaw()), TABLE_3 | {"y_A": 0.01, "y_A_dot": -0.5}
    with pytest.warns(PainleveWarning, match="impact_end.*no finite derivative"):
        sensitivities = sim.sensitivities(
            state, ("y_A", "theta", "mu", "e_energetic"), parameters={"e_energetic": 0.0},
            t_end=0.05,
        )  # fmt: skip
    assert sensitivities.singular is not None and sensitivities.singular.note == "singular"
    assert sensitivities.trajectory.stop_reason is StopReason.T_END
    assert len(sensitivities.events) == len(sensitivities.trajectory.events)
    assert np.isfinite(sensitivities.at(0.01)).all() and np.isnan(sensitivities.at(0.04)).all()


def test_the_c_of_derivatives_is_written_once(monkeypatch):
    options = {"t_end": 1e-5, "parameters": HARD}
    first = softened().sensitivities(TABLE_3, ("mu", "theta"), **options)

    def refuse(_):
        raise AssertionError("this should have come from the cache")

    again = Simulator(model("rod"), paper_law(reload="virgin"))
    monkeypatch.setattr(type(again.integrator), "_source", staticmethod(refuse))
    second = again.sensitivities(TABLE_3, ("mu", "theta"), **options)
    np.testing.assert_array_equal(second.final_jacobian, first.final_jacobian)


def test_other_directions_and_laws_are_other_c(monkeypatch):
    monkeypatch.setattr(variational, "make_engine", lambda *given: given[-1]("taylor"))
    directions = [("mu", "theta"), ("theta", "mu"), ("E", "theta"), ("mu", "y_A"), ("mu",)]
    names = [variational.Directions(softened(), wrt, False).engine for wrt in directions]
    elastic = Simulator(model("rod"), paper_law(reload="elastic"))
    names.append(variational.Directions(elastic, directions[0], False).engine)
    assert None not in names and len(set(names)) == len(names)
    assert variational.Directions(softened(), directions[0], False).engine == names[0]
