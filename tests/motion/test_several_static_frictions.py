"""Static friction and Stribeck's curve of several contacts: two coupled blocks on a belt."""

from __future__ import annotations

import functools
import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import painleve_sym as ps
from painleve_sym.errors import StopReason
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.batch.run import run_batch
from tests.motion.comparisons import assert_same_motion

BLOCKS = """
name = "blocks-on-belt"
title = "two blocks on a belt, coupled by a spring and held by springs"
source = "two blocks of a spring-block model"
gravity = "g"

[coordinates]
x_1 = { unit = "m", meaning = "position of block 1 along the belt" }
y_1 = { unit = "m", meaning = "height of block 1" }
x_2 = { unit = "m", meaning = "position of block 2 along the belt" }
y_2 = { unit = "m", meaning = "height of block 2" }

[parameters]
m_1 = { default = 2.0, unit = "kg", meaning = "mass of block 1", positive = true }
m_2 = { default = 1.5, unit = "kg", meaning = "mass of block 2", positive = true }
k_1 = { default = 300.0, unit = "N/m", meaning = "stiffness of the spring of block 1", lower = 0 }
k_2 = { default = 250.0, unit = "N/m", meaning = "stiffness of the spring of block 2", lower = 0 }
k_c = { default = 120.0, unit = "N/m", meaning = "stiffness of the coupling", lower = 0 }
u = { default = 0.1, unit = "m/s", meaning = "speed of the belt" }
g = { default = 9.8, unit = "m/s^2", meaning = "gravity", lower = 0 }
mu_1 = { default = 0.4, unit = "1", meaning = "friction coefficient of block 1" }
mu_2 = { default = 0.5, unit = "1", meaning = "friction coefficient of block 2" }

[[bodies]]
mass = "m_1"
centre = ["x_1", "y_1"]

[[bodies]]
mass = "m_2"
centre = ["x_2", "y_2"]

[[springs]]
extension = "x_1"
stiffness = "k_1"

[[springs]]
extension = "x_2"
stiffness = "k_2"

[[springs]]
extension = "x_2 - x_1"
stiffness = "k_c"

[[contacts]]
name = "left"
point = ["x_1", "y_1"]
surface_speed = "u"
friction = "mu_1"

[[contacts]]
name = "right"
point = ["x_2", "y_2"]
surface_speed = "u"
friction = "mu_2"
"""
M, K, K_C, U, G = (2.0, 1.5), (300.0, 250.0), 120.0, 0.1, 9.8
MU, K_N, T_END = (0.4, 0.5), 1e5, 1.2
SIDES = ("left", "right")
C_N, DEEPER = 20.0, 0.01


@pytest.fixture(scope="module")
def simulator():
    mechanism = mechanism_from_text(BLOCKS)

    @functools.cache
    def blocks(first, second, engine="auto"):
        frictions = {"left": first, "right": second}
        laws = {c: ps.law("linear", friction=f) for c, f in frictions.items()}
        return ps.Simulator(mechanism, laws, engine)

    return blocks


def at_rest_on_belt(**more):
    """Both blocks go with the belt, pressed in by a little more than their weight."""
    start = {"x_1_dot": U, "x_2_dot": U}
    start |= {f"y_{i + 1}": -(1 + DEEPER) * m * G / K_N for i, m in enumerate(M)}
    return start | more


def own_parameters(first, second, ratio, width):
    """Return the laws' parameters; static ratio and Stribeck velocity where the law has them."""
    values = {"k_left": K_N, "k_right": K_N, "c_left": C_N, "c_right": C_N}
    for contact, friction in (("left", first), ("right", second)):
        values |= {f"static_ratio_{contact}": ratio} if friction != "coulomb" else {}
        values |= {f"stribeck_velocity_{contact}": width} if friction == "stribeck" else {}
    return values


class Oracle:
    """Two blocks by hand: coordinates along the belt alone, each slips (±1) or sticks (0)."""

    def __init__(self, frictions, ratio, width):
        self.static = [1.0 if f == "coulomb" else ratio for f in frictions]
        self.width = [width if f == "stribeck" else math.inf for f in frictions]
        self.curve = [f == "stribeck" for f in frictions]

    def load(self, x):
        coupling = K_C * (x[1] - x[0])
        return np.array([-K[0] * x[0] + coupling, -K[1] * x[1] - coupling])

    def normal(self, i, t):
        """Return k d + c ḋ of the damped oscillation about the static compression; N."""
        decay = C_N / (2 * M[i])
        w, deep = math.sqrt(K_N / M[i] - decay**2), DEEPER * M[i] * G / K_N
        swing = math.exp(-decay * t) * deep
        d = swing * (math.cos(w * t) + decay / w * math.sin(w * t))
        rate = -swing * (w**2 + decay**2) / w * math.sin(w * t)
        return M[i] * G + K_N * d + C_N * rate

    def friction(self, i, v, sign, t):
        rise = (self.static[i] - 1) / (1 + (v / self.width[i]) ** 2) if self.curve[i] else 0.0
        return -sign * MU[i] * self.normal(i, t) * (1 + rise)

    def limit(self, i, t):
        return MU[i] * self.static[i] * self.normal(i, t)

    def run(self, x, v, t_end):
        """Return events (time, kind, block) and the end state."""
        t, y, events = 0.0, np.array([*x, *v]), []
        signs = [int(np.sign(round(w - U, 12))) for w in v]
        while t < t_end and len(events) < 100:

            def rates(t, y):
                load = self.load(y[:2])
                a = [
                    (load[i] + self.friction(i, y[2 + i] - U, s, t)) / M[i] if s else 0.0
                    for i, s in enumerate(signs)
                ]
                return [y[2], y[3], *a]

            guards = []
            for i, s in enumerate(signs):
                if s:
                    guards.append(lambda t, y, i=i, s=s: s * (y[2 + i] - U))
                else:
                    guards.append(lambda t, y, i=i: self.limit(i, t) - abs(self.load(y[:2])[i]))
                guards[-1].terminal, guards[-1].direction = True, -1
            solved = solve_ivp(
                rates,
                (t, t_end),
                y,
                "DOP853",
                rtol=1e-12,
                atol=1e-14,
                events=guards,
                max_step=0.005,
            )
            t, y = solved.t[-1], solved.y[:, -1]
            if solved.status != 1:
                break
            i = next(k for k, e in enumerate(solved.t_events) if len(e))
            load = self.load(y[:2])[i]
            if signs[i]:
                y[2 + i] = U
                signs[i] = 0
                events.append((t, "slip_stop", SIDES[i]))
                if abs(load) > self.limit(i, t):
                    signs[i] = int(np.sign(load))
            else:
                signs[i] = int(np.sign(load))
                events.append((t, "slip_start", SIDES[i]))
        return events, y


PAIRS = [("static", "coulomb"), ("stribeck", "static")]


@pytest.mark.slow
@pytest.mark.parametrize("pair", PAIRS)
@settings(max_examples=6)
@given(
    ratio=st.floats(1.1, 2.0),
    width=st.floats(0.02, 0.3),
    x=st.tuples(st.integers(-100, 100), st.integers(-100, 100)),
)
def test_stick_slip_of_two_blocks_equals_scipy(simulator, pair, ratio, width, x):
    """Each sticks until μ_s m g, slips with μ r(v_t) m g, and sticks again where v_t = 0."""
    x = 1e-4 * x[0], 1e-4 * x[1]
    events, end = Oracle(pair, ratio, width).run(x, (U, U), T_END)
    run = simulator(*pair).run(
        at_rest_on_belt(x_1=x[0], x_2=x[1]),
        t_end=T_END,
        parameters=own_parameters(*pair, ratio, width),
    )
    assert run.stop_reason is StopReason.T_END
    slips = [e for e in run.events if e.kind in ("slip_start", "slip_stop")]
    assert [(e.kind, e.contact) for e in slips] == [(k, c) for _, k, c in events]
    np.testing.assert_allclose([e.time for e in slips], [t for t, *_ in events], atol=1e-8)
    own = [run.final[n] for n in ("x_1", "x_2", "x_1_dot", "x_2_dot")]
    np.testing.assert_allclose(own, end, atol=1e-8)
    assert run.energy_residual < 1e-10


START = at_rest_on_belt(x_1=0.004, x_2=-0.003)


@pytest.mark.slow
def test_equal_static_and_kinetic_friction_is_coulomb(simulator):
    plain, other = (
        simulator(*f).run(START, t_end=T_END, parameters=own_parameters(*f, 1.0, 0.1))
        for f in (("coulomb", "coulomb"), ("stribeck", "static"))
    )
    assert_same_motion(other, plain, times=1e-12, values=1e-10)
    assert {"slip_start", "slip_stop"} <= {e.kind for e in plain.events}


@pytest.mark.parametrize(
    "pair", [PAIRS[0], *(pytest.param(p, marks=pytest.mark.slow) for p in PAIRS[1:])]
)
def test_mirrored_motion_is_the_mirror_image(simulator, pair):
    p, turned = own_parameters(*pair, 1.4, 0.05), {"u": -U}
    mirrored = {n: -v if n.startswith("x") else v for n, v in START.items()}
    runs = [
        simulator(*pair).run(START, t_end=T_END, parameters=p),
        simulator(*pair).run(mirrored, t_end=T_END, parameters=p | turned),
    ]
    times = [[e.time for e in run.events] for run in runs]
    np.testing.assert_array_equal(*times)
    for name, value in runs[0].final.items():
        sign = -1 if name.startswith("x") else 1
        if "slip" not in name:
            assert runs[1].final[name] == sign * value


@pytest.mark.parametrize(
    "pair", [PAIRS[0], *(pytest.param(p, marks=pytest.mark.slow) for p in PAIRS[1:])]
)
@settings(max_examples=15)
@given(exponents=st.tuples(*3 * (st.floats(-12, 12),)))
def test_motion_follows_a_change_of_the_units(simulator, pair, exponents):
    """Units of length, mass and time changed by up to twelve decades."""
    L, mass, T = (10**e for e in exponents)
    stiffness = mass / T**2
    own = own_parameters(*pair, 1.4, 0.05)
    for name in own:
        units = {"k": stiffness, "c": mass / T}
        own[name] *= units.get(name[0], L / T if "velocity" in name else 1)
    given_ = {"m_1": M[0] * mass, "m_2": M[1] * mass, "u": U * L / T, "g": G * L / T**2}
    given_ |= {"k_1": K[0] * stiffness, "k_2": K[1] * stiffness, "k_c": K_C * stiffness}
    start = {n: v * (L / T if n.endswith("_dot") else L) for n, v in START.items()}
    run = simulator(*pair).run(start, t_end=T_END * T, parameters=own | given_)
    plain = simulator(*pair).run(START, t_end=T_END, parameters=own_parameters(*pair, 1.4, 0.05))
    for one, other in (
        (e, f)
        for k in ("slip_start", "slip_stop")
        for e, f in zip(plain.events_of(k), run.events_of(k), strict=True)
    ):
        assert (one.contact, one.time) == (other.contact, pytest.approx(other.time / T, rel=1e-9))
        assert one.mode_after.split("/")[0] == other.mode_after.split("/")[0]
    assert run.final["x_1"] == pytest.approx(plain.final["x_1"] * L, rel=1e-8)
    assert run.final["x_2_dot"] == pytest.approx(plain.final["x_2_dot"] * L / T, rel=1e-8)


def test_rows_of_a_batch_are_the_runs(simulator):
    pair, ratios = ("static", "coulomb"), np.linspace(1.0, 1.8, 11)
    p = own_parameters(*pair, 1.4, 0.05)
    batch = run_batch(
        simulator(*pair), START, p | {"static_ratio_left": ratios}, t_end=T_END, events=2
    )
    for i, ratio in enumerate(ratios):
        own = p | {"static_ratio_left": float(ratio)}
        run = simulator(*pair).run(START, t_end=T_END, parameters=own)
        assert batch["x_1"][i] == run.final["x_1"]
        assert batch["times_of_slip_start"][i, 0] == run.events_of("slip_start")[0].time


@pytest.mark.slow
@pytest.mark.parametrize(
    "landing, own",
    [
        (-0.46, {"mu_A": 0.55, "mu_B": 0.594, "beta": -0.028, "h": 0.557, "static_ratio": 1.733}),
        (0.0, {"mu_A": 0.46, "mu_B": 0.943, "beta": 0.0337, "h": 0.512, "static_ratio": 1.464}),
    ],
)
def test_of_two_sticking_feet_that_one_slips_whose_friction_reaches_its_cone(landing, own):
    """Either foot could slip while the other sticks: friction in slip is lower."""
    block = ps.Simulator(ps.model("block-two-feet"), ps.law("linear", friction="static"))
    start = {"y_A": 0.0, "y_A_dot": landing}
    run = block.run(start, parameters=own | {"k": 1e5, "c": 50.0}, t_end=0.0075)
    first = run.events_of("slip_start")[0]
    assert first.contact == "A"
    assert re.match(r"slip_(pos|neg)/\w+ \+ stick/\w+$", first.mode_after)
