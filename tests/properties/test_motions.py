"""Motions of compliant contacts exist and are unique: the inequality, what it gives, exceptions."""

from __future__ import annotations

import math

import pytest
from hypothesis import find, given, settings
from hypothesis import strategies as st

import painleve_sym as ps
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text

NUMBERS = st.floats(-10, 10)
FORCES = st.floats(0, 10)
PART = st.floats(-1, 1)


def friction(v, N, mu, part, static=1.0):
    """Return a friction force that the law allows; `part` chooses where it is not determined."""
    return -mu * N * (math.copysign(1.0, v) if v else static * part)


@given(NUMBERS, NUMBERS, FORCES, FORCES, st.floats(0, 3), PART, PART)
def test_power_of_a_difference_is_bounded_by_that_of_the_normal_forces(u, v, N, P, mu, a, b):
    for first, second in ((u, v), (0.0, v), (0.0, 0.0)):
        power = (first - second) * (friction(first, N, mu, a) - friction(second, P, mu, b))
        assert power <= mu * abs(N - P) * abs(first - second) + 1e-9


def test_static_friction_above_the_kinetic_one_has_no_such_bound():
    u, part = find(
        st.tuples(st.floats(0.001, 1), PART),
        lambda x: -x[0] * (friction(0.0, 1.0, 1.0, x[1], 1.5) - friction(x[0], 1.0, 1.0, 0)) > 0,
    )
    assert u > 0 and part > 0


# ---- runs ----

CLOSE = 1e-9
STARTS = st.fixed_dictionaries(
    {
        "theta": st.floats(0.7, 1.3),
        "theta_dot": st.floats(-1, 1),
        "x_A_dot": st.floats(-1.5, 1.5),
        "y_A_dot": st.floats(-0.2, 0.0),
    }
)


@pytest.fixture(scope="module")
def compliant():
    return ps.Simulator("rod", "hertz")


@settings(max_examples=60)
@given(STARTS, st.floats(0.0, 2.0), st.sampled_from(["x_A_dot", "y_A_dot", "theta"]))
def test_neighbouring_starts_stay_neighbours(compliant, start, mu, name):
    """Through touches, stops, slips and lift-offs, in the paradox and outside it."""
    options = {"t_end": 3e-3, "parameters": {"mu": mu, "E": 1e10}, "rtol": 1e-12}
    ends = [
        compliant.run(state, **options).final
        for state in (start, start | {name: start[name] + CLOSE})
    ]
    names = ("theta", "theta_dot", "x_A_dot", "y_A_dot")
    difference = max(abs(ends[0][n] - ends[1][n]) for n in names)
    # Without a Lipschitz constant it would be that of two motions, 1e-3 and more.
    assert difference < 1e5 * CLOSE


PULLED = """
gravity = "g"
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
m = { default = 1.0, unit = "kg", positive = true }
g = { default = 9.8, unit = "m/s^2", lower = 0 }
mu = { default = 0.5, unit = "1", lower = 0 }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[[springs]]
extension = "x + 5.5"
stiffness = 1
[[contacts]]
name = "A"
point = ["x", "y"]
friction = "mu"
"""
"""A mass that a soft spring pulls along with 5.5 N, between 4.9 N and 1.25 times as much."""


@pytest.mark.parametrize(("choice", "parted"), [("coulomb", False), ("static", True)])
def test_a_mass_pulled_between_both_frictions_has_two_motions(choice, parted):
    """At rest it rests; with the least slip it slides, where static friction is larger."""
    mass, law = mechanism_from_text(PULLED, "pulled"), ps.law("linear", friction=choice)
    ends = [
        ps.simulate(mass, law, {"x_dot": slip}, t_end=0.1, initial_force=9.8).final["x_dot"]
        for slip in (0.0, -1e-9)
    ]
    # 0.6 m/s² for 0.1 s.
    assert ends[1] == pytest.approx(-0.06, rel=0.01)
    assert (abs(ends[1] - ends[0]) > 0.05) == parted


@given(st.floats(1e-6, 1.0), st.floats(1.0, 100.0))
@settings(max_examples=10)
def test_a_dashpot_jumps_at_the_touch_by_its_rate(approach, c):
    run = ps.simulate(
        "rod", ps.laws.linear(k=1e6, c=c), {"theta": 1.0, "y_A_dot": -approach}, t_end=1e-9,
        parameters={"mu": 0.0},
    )  # fmt: skip
    force = float(run.values("normal_force", [1e-12])[0])
    assert force == pytest.approx(c * approach, rel=1e-4)


def test_a_virgin_reload_jumps_in_force_where_the_compression_turns():
    law = ps.laws.bilinear_hertz(reload="virgin")
    run = ps.simulate("rod", law, {"theta": 0.5, "theta_dot": 1.0, "x_A_dot": -1.0}, t_end=0.01)
    turn = next(e for e in run.events if e.kind == "reload")
    before, after = run.values("normal_force", [turn.time * (1 - 1e-9), turn.time * (1 + 1e-9)])
    assert after > 1.05 * before
