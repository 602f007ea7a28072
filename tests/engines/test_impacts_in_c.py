"""Impacts of several contacts in C against the same path in NumPy."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import sympy as sp

from painleve_sym.at.delassus import Delassus
from painleve_sym.automata.automaton import Choice, HybridAutomaton, Mode, Transition
from painleve_sym.engines.impacts import solve_simultaneous_impact
from painleve_sym.errors import EventKind, ModelError, StopReason
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.problem.impact.one_contact import ImpactEnd
from tests.scenes import FEET, simulator
from tests.support.numpy_impact import path_in_numpy

LAWS = ("energetic", "poisson", "newton")
FINAL_SLIP = "newton by the final slip"


def in_c(W, mu, v, held, restitution, e, load, impact_friction="path"):
    """Return whether it ends, velocities, impulses and works."""
    impact = solve_simultaneous_impact(
        W, mu, v, restitution, e, impact_friction=impact_friction, load=load, bilateral=held
    )
    ended = impact.end is not ImpactEnd.JAM
    return ended, impact.velocities, impact.impulses, impact.works


def scene(rng, n, kind, guided):
    """Return W, μ, velocity and sides of n contacts that hit, or rest without collision."""
    points = rng.uniform(-1, 1, (n, 2))
    while (
        n > 1
        and min(np.linalg.norm(points[i] - points[j]) for i in range(n) for j in range(i)) < 0.2
    ):
        points = rng.uniform(-1, 1, (n, 2))
    walls = rng.random(n) < 0.4
    if kind == "level":
        points[:, 1], walls[:] = -0.3, False
    if kind == "equal":  # the last contact has the rows of the first
        points[-1], walls[-1] = points[0], walls[0]
    if kind == "grid":  # contacts above each other, opposite, at the height of the mass centre
        points = np.rint(2 * points) / 2
    rows = []
    for (x, y), wall in zip(points, walls, strict=True):
        along = np.array([1.0, 0.0, -y]), np.array([0.0, 1.0, x])
        rows += along if wall else along[::-1]
    J = np.array(rows)
    if kind == "bodies":  # one body for each contact, coupled to the next: W is regular
        J = rng.normal(size=(2 * n, 2 * n + 1))
    mass = 10 ** rng.uniform(-1, 1, J.shape[1])
    W = J @ np.diag(1 / mass) @ J.T
    mu = np.where(rng.random(n) < 0.15, 0.0, 10 ** rng.uniform(-2, 0.5, n))
    v = J @ rng.normal(size=J.shape[1])
    v[::2] = -np.abs(v[::2])
    v[1::2] *= rng.random(n) < 0.8
    v[::2] *= rng.random(n) < 0.9
    held = np.zeros(n, dtype=bool)
    if guided:
        held = rng.random(n) < 0.5
        v[::2][held] = 0.0
    return W, mu, v * 10 ** rng.uniform(-3, 3), held


KINDS = ("body", "level", "bodies", "equal", "grid")


# Each law, each number of contacts, and contacts with and without guides.
QUICK_PATHS = {
    (1, False, "poisson"),
    (2, False, "newton"),
    (2, True, "energetic"),
    (3, True, "newton"),
    (1, False, FINAL_SLIP),
    (2, False, FINAL_SLIP),
    (2, True, FINAL_SLIP),
}


@pytest.mark.parametrize(
    ("n", "count", "guided", "restitution"),
    [
        pytest.param(n, count // 2, guided, name)
        if (n, guided, name) in QUICK_PATHS
        else pytest.param(n, count, guided, name, marks=pytest.mark.slow)
        for (n, count), guided, name in itertools.product(
            [(1, 500), (2, 300), (3, 50)], [False, True], [*LAWS, FINAL_SLIP]
        )
    ],
)
def test_c_follows_the_path_of_numpy(restitution, n, count, guided):
    rng = np.random.default_rng(n + 10 * [*LAWS, FINAL_SLIP].index(restitution))
    final, jams = restitution == FINAL_SLIP, 0
    restitution = "newton" if final else restitution
    for k in range(count):
        kind = KINDS[k % len(KINDS)]
        W, mu, v, held = scene(rng, n, kind, guided)
        e = [0.0, 1.0, rng.uniform(), rng.uniform(size=n)][rng.integers(4)]
        b = rng.normal(size=2 * n)
        want = path_in_numpy(W, mu, v, restitution, e, final_slip=final, load=b, bilateral=held)
        by = "final_slip" if final else "path"
        ended, velocity, impulse, work = in_c(W, mu, v, held, restitution, e, b, by)
        assert ended is (want.end is not ImpactEnd.JAM), (k, W, mu, v, e)
        if not ended:
            jams += 1
            continue
        speed = np.max(np.abs(v)) + np.max(np.abs(W) @ np.abs(want.impulses))
        size = np.max(np.abs(want.impulses), initial=0.0) + speed / np.max(W)
        assert np.max(np.abs(velocity - want.velocities)) <= 1e-12 * speed, (k, W, mu, v, e)
        if guided and kind != "bodies" and n > 1:
            # Rigidity leaves the forces of one body's guides open, or all but open.
            effect = np.max(np.abs(W)) * size
            assert np.max(np.abs(W @ (impulse - want.impulses))) <= 1e-12 * effect, (k, W, mu, v, e)
            continue
        assert np.max(np.abs(impulse - want.impulses)) <= 1e-12 * size, (k, W, mu, v, e)
        assert np.max(np.abs(work - want.works)) <= 1e-12 * size * speed, (k, W, mu, v, e)
    # A guide by itself has no impact, unless its friction finds no force.
    assert jams < count * (0.8 if guided else 0.5)


@pytest.mark.parametrize("mu", [0.0, 0.3, 2.0])
@pytest.mark.parametrize("v_n", [-1e-11, -1e-13, -1e-15, -1e-300])
def test_newtons_law_in_c_gives_back_e_of_a_slow_approach_that_is_no_rounding(mu, v_n):
    W, v, none = np.array([[1.0, 0.6], [0.6, 1.0]]), np.array([v_n, 1.0]), np.zeros(2)
    ended, velocity, *_ = in_c(W, np.array([mu]), v, np.array([False]), "newton", 0.5, none)
    assert ended and velocity[0] == (-0.5 * v_n if v_n < -1e-14 else 0.0)


@pytest.mark.parametrize("count", [1_000, pytest.param(10_000, marks=pytest.mark.slow)])
def test_with_e_1_every_contact_gives_back_all_that_it_stored(count):
    """Energetic law: also a contact that the others press again after they had lifted it."""
    rng = np.random.default_rng(8)
    jams = 0
    for k in range(count):
        n = 2 + k % 2
        W, mu, v, held = scene(rng, n, KINDS[k % len(KINDS)], guided=False)
        load_ = rng.normal(size=2 * n)
        ended, _, impulse, work = in_c(W, mu, v, held, "energetic", 1.0, load_)
        if not ended:
            jams += 1
            continue
        speed = np.max(np.abs(v)) + np.max(np.abs(W) @ np.abs(impulse))
        assert np.max(np.abs(work[::2])) <= 1e-9 * np.max(np.abs(impulse)) * speed, (W, mu, v)
    assert jams < count / 10


# ---- within runs ----


@pytest.mark.parametrize(
    ("laws", "engine"),
    [
        ("A=hertz,B=rigid", "taylor"),
        pytest.param("rigid", "taylor", marks=pytest.mark.slow),
        pytest.param("rigid", "compiled", marks=pytest.mark.slow),
    ],
)
def test_rows_of_a_batch_are_single_runs_bit_for_bit(laws, engine):
    feet, tilt = simulator(FEET, laws, engine), np.linspace(-0.2, 0.2, 19)
    start, own = {"y_A": 0.3, "x_A_dot": 0.2}, {"mu_A": 0.5}
    options = {"t_end": 0.6, "events": 2, "maxima": ("normal_force_A",)}
    one, two = (
        run_batch(feet, start | {"theta": tilt}, own, threads=threads, **options)
        for threads in (1, 2)
    )
    assert one.rows.state.tobytes() == two.rows.state.tobytes()
    assert one.rows.extremes.tobytes() == two.rows.extremes.tobytes()
    impacts = 0
    for i, theta in enumerate(tilt):
        single = feet.run(start | {"theta": theta}, parameters=own, t_end=0.6)
        assert one.rows.state[i].tobytes() == single.final_state.tobytes()
        assert one.rows.memory[i].tobytes() == single.final_memory.tobytes()
        assert one["stop_reason"][i] == single.stop_reason.label
        assert one["mode"][i] == single.mode_names[single.final_mode]
        assert one["count_of_impact"][i] == len(single.events_of("impact"))
        impacts += len(single.events_of("impact"))
    assert impacts >= 10


def contact_values(simulator, state):
    """Return gaps, gap rates and slip velocities."""
    return np.array([[state[n] for n in row] for row in simulator.contact.rows]).T


@pytest.mark.parametrize("restitution", LAWS)
def test_impacts_of_a_run_are_those_of_numpy(restitution):
    feet = simulator(FEET, restitution=restitution)
    run = feet.run({"y_A": 0.05, "theta": 0.1, "x_A_dot": 0.3}, t_end=0.4)
    e = run.parameters[f"e_{restitution}"]
    events, seen = run.events, 0
    of = Delassus.of(feet.mechanism)
    places = np.array([[run.state_names.index(n) for n in row] for row in feet.contact.rows])
    for before, impact in itertools.pairwise(events):
        if impact.kind != "impact":
            continue
        state = np.array([before.state[n] for n in run.state_names])
        gaps, rates, slips = (state[places[:, k]] for k in range(3))
        values = {**before.state, **run.parameters}
        terms, moved = of.whole_at(values)
        closed = [i for i in range(2) if abs(gaps[i]) < 1e-12 and rates[i] <= 0]
        rows = [r for i in closed for r in (2 * i, 2 * i + 1)]
        v = np.ravel([rates, slips], order="F")[rows]
        want = path_in_numpy(
            terms.W[np.ix_(rows, rows)], terms.mu[closed], v, restitution, e, load=terms.b[rows]
        )
        size = np.max(np.abs(want.impulses))
        np.testing.assert_allclose(
            np.array(impact.impulses)[rows], want.impulses, atol=1e-12 * size
        )
        after = np.array([impact.state[n] for n in run.state_names])
        _, new_rates, new_slips = (after[places[:, k]] for k in range(3))
        computed = np.ravel([new_rates, new_slips], order="F")[rows]
        np.testing.assert_allclose(
            computed, want.velocities, rtol=0, atol=1e-12 * np.max(np.abs(v))
        )
        q = [after[run.state_names.index(n)] for n in ("x_A_dot", "y_A_dot", "theta_dot")]
        start = [state[run.state_names.index(n)] for n in ("x_A_dot", "y_A_dot", "theta_dot")]
        np.testing.assert_allclose(q, start + moved.D @ impact.impulses, atol=1e-12)
        seen += 1
    assert seen >= 3


def test_foot_that_approaches_by_the_rounding_of_its_slip_slides_on():
    feet = simulator(FEET, restitution="newton")
    start = {"theta": 0.1, "x_A_dot": 1.0, "y_A_dot": -1e-16}
    assert feet.run(start, t_end=1e-3).stop_reason is StopReason.T_END


def test_run_with_an_impact_ends_where_it_is_asked_to():
    start = {"y_A": 0.05, "theta": 0.1}
    run = simulator(FEET).run(start, t_end=1.0, until="impact", record="end")
    assert run.stop_reason is StopReason.UNTIL and np.any(run.final_memory[-4:] > 0)
    # A touchdown that ends the run still has its impact.
    landed = simulator(FEET).run(start, t_end=1.0, until="touchdown")
    assert [str(e.kind) for e in landed.events][-2:] == ["touchdown", "impact"]
    limited = simulator(FEET).run(start, t_end=1.0, max_events=3)
    assert limited.stop_reason is StopReason.EVENT_LIMIT and len(limited.events) >= 3


def test_transition_that_strikes_needs_impacts():
    x = sp.Symbol("x", real=True)
    hit = Transition("hit", EventKind.IMPACT, x, (Choice("air"),), strikes=True)
    with pytest.raises(ModelError, match="no impacts are declared"):
        HybridAutomaton(
            "ball", (x,), (), (), {}, (Mode("air", {x: sp.Integer(-1)}, (hit,)),), (Choice("air"),)
        )
