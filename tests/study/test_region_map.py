"""Maps of the rigid contact: codes as `classify` gives them, crossings in closed form."""

from __future__ import annotations

import dataclasses
import json
import math
import time

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

import painleve_sym as ps
from painleve_sym.at.cases import classify, contact_problem
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, PainleveWarning
from painleve_sym.mechanics.declarations import DomainBound
from painleve_sym.study.maps.region_map import LEGEND, RegionMap, region_map
from painleve_sym.study.maps.zero_curves import common_zeros, zero_segments

CASE_OF = {code: name for name, code in LEGEND.items()}


@pytest.fixture(scope="module")
def rod():
    return model("rod")


@pytest.fixture(scope="module")
def rod_map(rod):
    ranges = {"theta": (0.1, 1.5), "theta_dot": (-5.0, 5.0)}
    return region_map(rod, ("theta", "theta_dot"), ranges=ranges, points=81)


def rod_crossings(mu, g, l):
    """Return θ and |θ̇| where A = B = 0: 3 t μ = 4 + t², θ̇² = g/(l sinθ)."""
    root = math.sqrt(9 * mu**2 - 16)
    angles = [math.atan((3 * mu + sign * root) / 2) for sign in (-1, 1)]
    return [(theta, math.sqrt(g / (l * math.sin(theta)))) for theta in angles]


def at_point(regions, i, j, slip_name, slip):
    """Return state and parameters of a grid point, sliding with `slip` along `slip_name`."""
    state, parameters = {**regions.state, slip_name: slip}, dict(regions.parameters)
    for name, value in zip(regions.over, (regions.values[0][i], regions.values[1][j]), strict=True):
        (parameters if name in ("mu", "m", "g") else state)[name] = float(value)
    return state, parameters


# Mechanism, axes, slip direction, the velocity that sets it, held state.
PLACES = [
    ("rod", ("theta", "theta_dot"), -1, "x_A_dot", {}),
    ("rod", ("theta", "mu"), 1, "x_A_dot", {"theta_dot": 3.4}),
    ("rod", ("mu", "g"), -1, "x_A_dot", {"theta": 1.1, "theta_dot": 3.0}),
    ("eccentric-disc", ("phi", "phi_dot"), -1, "x_dot", {}),
]


@pytest.mark.parametrize(("name", "over", "slip", "slip_name", "state"), PLACES)
def test_map_codes_equal_classify_at_random_points(name, over, slip, slip_name, state):
    mechanism = model(name)
    regions = region_map(mechanism, over, points=61, slip=slip, state=state)
    rng = np.random.default_rng(7)
    for i, j in rng.integers(0, 61, (25, 2)):
        # 40 m/s outweighs r φ̇ of the disc, whose slip also depends on φ̇.
        point, parameters = at_point(regions, i, j, slip_name, 40.0 * slip)
        single = classify(mechanism, point, parameters=parameters)
        assert CASE_OF[int(regions.case[i, j])] == single.case.value
        for grid, value in (("A", single.A), ("B", single.B), ("A_stick", single.A_stick)):
            assert getattr(regions, grid)[i, j] == pytest.approx(value, rel=1e-12, abs=1e-12)


@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
def test_map_has_a_case_where_no_motion_slides_the_contact():
    """At theta = 0 the tip of the strut moves along its normal alone: W_tt = W_nt = 0."""
    strut = model("strut")
    regions = region_map(strut, ("theta", "theta_dot"), points=5)
    assert regions.values[0][2] == 0.0
    for theta_dot, case, A in zip(regions.values[1], regions.case[2], regions.A[2], strict=True):
        state = {"theta": 0.0, "theta_dot": float(theta_dot)}
        problem = contact_problem(strut, state, strut.parameters)
        assert problem.W_tt == 0.0 and problem.A_slip(-1) == A
        assert case == LEGEND[problem.case_of(problem.solutions()).value]


def test_map_sticking_equals_classify_at_rest(rod, rod_map):
    rng = np.random.default_rng(3)
    seen = set()
    for i, j in rng.integers(0, 81, (30, 2)):
        point, parameters = at_point(rod_map, i, j, "x_A_dot", 0.0)
        modes = {s.mode.value for s in classify(rod, point, parameters=parameters).solutions}
        assert bool(rod_map.stick_feasible[i, j]) == ("stick" in modes)
        seen.add("stick" in modes)
    assert seen == {True, False}


@pytest.mark.parametrize(("mu", "g", "l"), [(1.4, 9.8, 1.0), (1.7, 9.8, 0.7), (1.3334, 3.0, 1.0)])
def test_rod_crossings_are_the_closed_form(rod, mu, g, l):
    want = rod_crossings(mu, g, l)
    parameters = {"mu": mu, "g": g, "l": l}
    # Crossings near the least friction lie close together, those near π/2 need the wide range.
    for points in (40, 101):
        regions = region_map(
            rod,
            ("theta", "theta_dot"),
            ranges={"theta": (0.1, 1.56), "theta_dot": (-6, 6)},
            points=points,
            parameters=parameters,
        )
        expected = sorted((t, s * v) for t, v in want for s in (-1, 1))
        # At μ = 1.3334 the two roots nearly meet, and A = 0 is ill-conditioned there.
        tolerance = 1e-12 if mu > 1.35 else 1e-10
        np.testing.assert_allclose(regions.crossings, expected, rtol=0, atol=tolerance)


def test_rod_crossing_over_theta_and_mu(rod):
    regions = region_map(rod, ("theta", "mu"), state={"theta_dot": 3.4}, points=50)
    theta = math.asin(9.8 / 3.4**2)
    t = math.tan(theta)
    assert regions.flow is None
    np.testing.assert_allclose(regions.crossings, [[theta, (4 + t**2) / (3 * t)]], atol=1e-12)


def test_map_thresholds_of_the_rods(rod_map):
    known = {"mu_P": 4 / 3, "mu_C": 8 / 3**1.5, "least_over_normals": 4 / 3}
    assert rod_map.thresholds == pytest.approx(known, rel=1e-12)
    heavy = region_map(
        model("rod-inertia"), ("theta", "mu"), points=20, parameters={"alpha": 8.0}
    ).thresholds
    known = {"mu_P": 3 / 4, "mu_C": 3 / 4 * 2 / math.sqrt(3), "least_over_normals": 3 / 4}
    assert heavy == pytest.approx(known, rel=1e-12)


@pytest.mark.parametrize("alpha", [3.0, 8.0])
def test_rod_rates_of_approach_are_equal_at_the_second_threshold(alpha):
    # In τ with dτ = dt/A the slip is regular at the crossing: f = (θ̇ A, θ̈ A) = 0 there.
    mechanism = model("rod-inertia")
    system, c = mechanism.system, mechanism.coefficients
    x, v = system.q[2], system.q_dot[2]
    normal, tangential = c.force_directions
    A = c.A(-1)
    field = sp.Matrix([v * A, A * system.free_acceleration[2]])
    field[1] -= c.B * (normal[2] + c.mu * tangential[2])
    slope, along_A = field.jacobian([x, v]), sp.diff(A, x) * v
    for factor, sign in ((0.99, 1), (1.0, 0), (1.01, -1)):
        regions = region_map(mechanism, ("theta", "mu"), points=5, parameters={"alpha": alpha})
        mu = factor * regions.thresholds["mu_C"]
        numbers = {"m": 1.0, "l": 1.0, "g": 9.8, "alpha": alpha, "mu": mu}
        over = region_map(mechanism, ("theta", "theta_dot"), points=50, parameters=numbers)
        first = over.crossings[over.crossings[:, 1] > 0][0]
        values = {p.symbol: numbers[p.name] for p in system.parameters}
        values |= {x: first[0], v: first[1]}
        rate_A = float(along_A.subs(values))
        rate_B = float(slope.trace().subs(values)) - rate_A
        assert float(slope.det().subs(values)) == pytest.approx(rate_A * rate_B, rel=1e-9)
        assert rate_A < 0 and rate_B < 0
        if sign == 0:
            assert rate_A == pytest.approx(rate_B, rel=1e-12)
        else:
            assert sign * (rate_A - rate_B) > 0


def test_map_is_its_mirror_image(rod):
    left = region_map(
        rod, ("theta", "theta_dot"), ranges={"theta": (0.1, math.pi - 0.1)}, points=60
    )
    right = region_map(
        rod, ("theta", "theta_dot"), ranges={"theta": (0.1, math.pi - 0.1)}, points=60, slip=1
    )
    np.testing.assert_array_equal(left.case, right.case[::-1, ::-1])
    np.testing.assert_allclose(left.A, right.A[::-1], rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(left.flow[1], -right.flow[1][::-1, ::-1], rtol=1e-9, atol=1e-9)
    mirrored = sorted((math.pi - x, -y) for x, y in right.crossings.tolist())
    np.testing.assert_allclose(left.crossings, mirrored, atol=1e-12)


def test_map_counts_every_point_once(rod_map):
    assert list(rod_map.counts) == list(LEGEND)
    assert sum(rod_map.counts.values()) == rod_map.case.size == 81**2
    assert rod_map.case.dtype == np.int8


def test_map_flow_is_the_motion_of_slip(rod, rod_map):
    slips = rod_map.case == LEGEND["slip"]
    assert np.isfinite(rod_map.flow[:, slips]).all()
    assert np.isnan(rod_map.flow[:, ~slips]).all()
    i, j = (k[17] for k in np.nonzero(slips))
    theta, speed = rod_map.values[0][i], rod_map.values[1][j]
    force = -rod_map.B[i, j] / rod_map.A[i, j]
    # J θ̈ = l (F_t sinθ − F_n cosθ) about the centre, J = m l²/3, F_t = +μ F_n.
    spin = 3 * force * (1.4 * math.sin(theta) - math.cos(theta))
    np.testing.assert_allclose(rod_map.flow[:, i, j], [speed, spin], rtol=1e-12)


def test_map_curves_lie_on_their_zeros(rod_map):
    theta = rod_map.curves["A"][..., 0]
    A = 1 + 3 * np.cos(theta) * (np.cos(theta) - 1.4 * np.sin(theta))
    assert len(theta) == 2 * 80 and np.abs(A).max() < 1e-13
    theta, speed = np.moveaxis(rod_map.curves["B"], -1, 0)
    assert np.abs(speed**2 * np.sin(theta) - 9.8).max() < 1e-13


def test_map_masks_what_is_outside_the_domain(rod):
    ranges = {"theta": (-0.5, 1.5)}
    regions = region_map(rod, ("theta", "theta_dot"), ranges=ranges, points=41)
    outside = regions.case == LEGEND["outside"]
    np.testing.assert_array_equal(outside.all(axis=1), regions.values[0] <= 0)
    assert np.isnan(regions.A[outside]).all() and not regions.stick_feasible[outside].any()
    assert (regions.crossings[:, 0] > 0).all()


def test_map_says_where_the_contact_is_not_closed():
    with pytest.warns(PainleveWarning, match="drawn as if the contact were closed"):
        region_map(model("strut"), ("theta", "mu"), points=10)


def test_map_npz_and_dict_round_trip(rod_map, tmp_path):
    rod_map.save(tmp_path / "map.npz")
    back = RegionMap.load(tmp_path / "map.npz")
    assert [p.name for p in tmp_path.iterdir()] == ["map.npz"]
    for name in ("case", "A", "B", "A_stick", "B_stick", "stick_feasible", "flow", "crossings"):
        np.testing.assert_array_equal(getattr(back, name), getattr(rod_map, name))
    assert back.summary() == rod_map.summary()
    assert (back.over, back.labels, back.units) == (rod_map.over, rod_map.labels, rod_map.units)
    data = json.loads(json.dumps(rod_map.to_dict(), allow_nan=False))
    np.testing.assert_array_equal(data["case"], rod_map.case)
    flow = np.array(data["flow"], dtype=float)
    np.testing.assert_array_equal(flow, rod_map.flow)


def test_map_without_flow_round_trips(rod, tmp_path):
    regions = region_map(rod, ("mu", "g"), points=5, state={"theta": 1.0})
    regions.save(tmp_path / "map.npz")
    assert RegionMap.load(tmp_path / "map.npz").flow is None
    assert regions.to_dict()["flow"] is None


def test_map_load_refuses_other_files(rod_map, tmp_path):
    path = tmp_path / "map.npz"
    rod_map.save(path)
    content = path.read_bytes()
    np.savez(tmp_path / "other.npz", text=json.dumps({"format": "other"}))
    for bad in (b"", content[: len(content) // 2], b"no archive"):
        path.write_bytes(bad)
        with pytest.raises(InputError, match="not readable"):
            RegionMap.load(path)
    for name in ("none.npz", "other.npz"):
        with pytest.raises(InputError, match="not readable"):
            RegionMap.load(tmp_path / name)


BAD = [
    ((("theta", "thta_dot"), {}), "Did you mean 'theta_dot'"),
    ((("theta", "theta"), {}), "two different names"),
    ((("theta",), {}), "two different names"),
    ((("theta", "mu"), {"ranges": {"theta": (1.0, 0.5)}}), "need from < to"),
    ((("theta", "mu"), {"ranges": {"theta": (1.0, 1.0)}}), "need from < to"),
    ((("theta", "mu"), {"ranges": {"theta": (math.nan, 1.0)}}), "finite"),
    ((("theta", "mu"), {"ranges": {"theta": (0.0, math.inf)}}), "finite"),
    ((("theta", "mu"), {"ranges": {"theta": (1.0, 1.0 + 1e-15)}}), "not distinct"),
    ((("theta", "mu"), {"ranges": {"mu": (-1.0, 1.0)}}), "mu"),
    ((("theta", "mu"), {"ranges": {"m": (1.0, 2.0)}}), "unknown axis 'm'"),
    ((("theta", "mu"), {"points": 4}), "5 to 2000"),
    ((("theta", "mu"), {"points": 2001}), "5 to 2000"),
    ((("theta", "mu"), {"slip": 0}), "slip"),
    ((("theta", "mu"), {"parameters": {"mu": 1.0}}), "mu is an axis"),
    ((("theta", "mu"), {"state": {"theta": 1.0}}), "theta is an axis"),
    ((("theta", "mu"), {"state": {"x": 1.0}}), "unknown state 'x'"),
    ((("theta_dot", "mu"), {"state": {"x_A_dot": -1.0}}), "no point of the map is inside"),
]


@pytest.mark.parametrize(("call", "words"), BAD)
def test_map_refuses_bad_input(rod, call, words):
    over, options = call
    with pytest.raises(InputError, match=words):
        region_map(rod, over, **options)


def test_map_without_compiler_is_the_same(rod, rod_map, monkeypatch, tmp_path):
    monkeypatch.setenv("CC", str(tmp_path / "none"))
    ranges = {"theta": (0.1, 1.5), "theta_dot": (-5.0, 5.0)}
    other = region_map(rod, ("theta", "theta_dot"), ranges=ranges, points=81)
    np.testing.assert_array_equal(rod_map.case, other.case)
    np.testing.assert_allclose(rod_map.crossings, other.crossings, atol=1e-13)
    np.testing.assert_allclose(rod_map.flow, other.flow, rtol=1e-12)


def test_map_refuses_several_contacts():
    with pytest.raises(InputError, match="got 2 contacts"):
        region_map(model("block-two-feet"), ("theta", "mu_A"))


# ---- bilateral contacts ----


def test_bilateral_map_counts_solutions(tmp_path):
    mechanism, state = model("painleve-klein"), {"phi": 1.2}
    options = {"ranges": {"P_2": (-20, 60)}, "state": state, "points": 23}
    for slip in (-1, 1):
        regions = region_map(mechanism, ("mu", "P_2"), slip=slip, **options)
        assert regions.bilateral and set(regions.curves) == {"A", "B", "A_pull"}
        for i in (0, 9, 15, 22):
            for j in range(0, 23, 3):
                values = {"mu": regions.values[0][i], "P_2": regions.values[1][j]}
                solutions = classify(
                    mechanism, state | {"x_dot": slip}, parameters=values
                ).solutions
                name = ("inconsistent", "slip", "indeterminate")[len(solutions)]
                assert regions.case[i, j] == LEGEND[name]
        # Klein's condition with equal masses, and the load at which the guide is free.
        mu, load = regions.crossings[0]
        assert mu == pytest.approx(2 / math.tan(1.2), rel=1e-12)
        assert load == pytest.approx(2 * 9.8 / math.tan(1.2), rel=1e-12)
    regions.save(tmp_path / "klein.npz")
    again = RegionMap.load(tmp_path / "klein.npz")
    assert again.bilateral and again.to_dict() == regions.to_dict()


@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
def test_bilateral_map_flows_as_the_side_that_bears():
    """F_n = -B/A with the sign it was assumed to have, and friction against the slip."""
    klein = model("painleve-klein")
    system, c = klein.system, klein.coefficients
    normal, tangential = c.force_directions
    x, phi = system.q_dot
    bearing = []
    for load in (-30.0, 30.0):
        options = {"state": {"phi_dot": 0.5}, "parameters": {"P_2": load}, "points": 24}
        regions = region_map(klein, ("phi", "x_dot"), **options)
        numbers = {p.symbol: regions.parameters[p.name] for p in system.parameters}
        slips = np.argwhere(regions.case == LEGEND["slip"])
        for i, j in slips[:: len(slips) // 6]:
            angle, speed = float(regions.values[0][i]), float(regions.values[1][j])
            values = {**numbers, system.q[0]: 0.0, system.q[1]: angle, x: speed, phi: 0.5}
            forces = [(side, -c.B / (c.W_nn + side * c.mu * c.W_nt)) for side in (1, -1)]
            ((side, force),) = (f for f in forces if f[0] * float(f[1].subs(values)) > 0)
            change = (normal[0] + side * c.mu * tangential[0]) * force
            want = float((system.free_acceleration[0] + change).subs(values))
            np.testing.assert_allclose(regions.flow[:, i, j], [0.5, want], rtol=1e-9)
            bearing.append(side)
    assert set(bearing) == {1, -1}


# ---- curves and zeros of plain functions ----


def test_zero_segments_of_a_circle_have_its_length():
    x, y = np.linspace(-2, 2, 90), np.linspace(-2, 2, 77)

    def circle(a, b):
        return a**2 + b**2 - 1

    pieces = zero_segments(circle, x, y, circle(*np.meshgrid(x, y, indexing="ij")))
    assert np.abs(circle(*np.moveaxis(pieces, -1, 0))).max() < 1e-14
    length = np.hypot(*(pieces[:, 1] - pieces[:, 0]).T).sum()
    assert length == pytest.approx(2 * math.pi, rel=1e-3)


def test_zero_segments_are_none_at_a_pole():
    x = np.linspace(-1, 1, 20)
    values = np.broadcast_to(1 / x[:, None], (20, 20))
    assert zero_segments(lambda a, b: 1 / np.where(a == 0, 1e-300, a), x, x, values).size == 0


def test_zero_segments_are_none_where_the_function_jumps_over_zero():
    x = np.linspace(-1, 1, 20)
    values = np.broadcast_to(np.where(x < 0.1, -0.4, 0.6)[:, None], (20, 20))
    assert zero_segments(lambda a, b: np.where(a < 0.1, -0.4, 0.6), x, x, values).size == 0


def test_zero_segments_follow_both_branches_through_a_saddle():
    x = np.array([0.0, 1.0])
    values = np.array([[1.0, -1.0], [-1.0, 1.0]])
    pieces = zero_segments(lambda a, b: 1 - 2 * (a + b) + 4 * a * b, x, x, values)
    assert pieces.shape == (2, 2, 2)


def test_common_zeros_of_circle_and_line():
    x, y = np.linspace(-2, 2, 31), np.linspace(-2, 2, 33)

    def system(a, b):
        one = np.ones_like(a)
        return np.stack([a**2 + b**2 - 1, a - b, 2 * a, 2 * b, one, -one])

    first, second = system(*np.meshgrid(x, y, indexing="ij"))[:2]
    zeros, shared = common_zeros(system, x, y, first, second)
    np.testing.assert_allclose(zeros, [[-math.sqrt(0.5)] * 2, [math.sqrt(0.5)] * 2], atol=1e-15)
    assert shared == []


def products(factor, one, other):
    """Return the system of factor · one and factor · other; each returns value and slopes."""

    def system(a, b):
        f, f_a, f_b = factor(a, b)
        rows = [
            (f * g, f_a * g + f * g_a, f_b * g + f * g_b)
            for g, g_a, g_b in (one(a, b), other(a, b))
        ]
        values, first, second = zip(*rows, strict=True)
        return np.stack([*values, first[0], second[0], first[1], second[1]])

    return system


def line(p, q, r):
    return lambda a, b: (p * a + q * b - r, np.full_like(a, p), np.full_like(b, q))


def square(a, b):
    return (a - 0.3) ** 2, 2 * (a - 0.3), np.zeros_like(b)


def circle_of_half(a, b):
    return a**2 + b**2 - 0.25, 2 * a, 2 * b


@pytest.mark.parametrize(
    ("factor", "curve"),
    [
        (line(1, 0, 0.3), (0.3, None)),
        (line(0, 2, 0.3), (None, 0.15)),
        (circle_of_half, "a point"),
        (line(1, 1, -0.4), "a point"),
        (square, "not told"),
    ],
)
def test_functions_with_a_common_factor_cross_where_the_others_do_alone(factor, curve):
    x, y = np.linspace(-1, 1, 41), np.linspace(-1, 1, 38)
    system = products(factor, line(1, 0, 0.7), line(1, 1, 0.8))
    first, second = system(*np.meshgrid(x, y, indexing="ij"))[:2]
    zeros, shared = common_zeros(system, x, y, first, second)
    np.testing.assert_allclose(zeros, [[0.7, 0.1]], atol=1e-13)
    if curve == "a point":
        ((a, b),) = shared
        assert abs(factor(np.array(a), np.array(b))[0]) < 1e-12
    elif isinstance(curve, tuple):
        assert shared == [tuple(v if v is None else pytest.approx(v, abs=1e-12) for v in curve)]
    else:
        assert shared == []


def test_curves_that_touch_neither_cross_nor_share_anything():
    x = np.linspace(-1, 1, 40)

    def system(a, b):
        one = np.ones_like(a)
        return np.stack([b, b - a**2, 0 * one, one, -2 * a, one])

    first, second = system(*np.meshgrid(x, x, indexing="ij"))[:2]
    zeros, shared = common_zeros(system, x, x, first, second)
    assert zeros.shape == (0, 2) and shared == []


def test_map_of_a_million_points_is_quick(rod):
    region_map(rod, ("theta", "theta_dot"), points=10)
    start = time.perf_counter()
    region_map(rod, ("theta", "theta_dot"), points=1000)
    print(f"map of 10^6 points: {time.perf_counter() - start:.3f} s")


@pytest.mark.parametrize("name", ["rod", "block", "cart-pendulum"])
@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
def test_a_friction_axis_reaches_past_the_threshold_by_itself(name):
    smooth = model(name, mu=0.05)
    angle = next(c.name for c in smooth.outline.coordinates if c.unit == "rad")
    regions = region_map(smooth, (angle, "mu"), points=40)
    threshold, reach = regions.thresholds["mu_P"], regions.values[1]
    assert reach[-1] == pytest.approx(1.25 * threshold)
    # At the threshold A < 0 begins.
    assert (regions.A[:, reach > threshold * 1.01] < 0).any()
    assert (regions.A[:, reach < threshold] > 0).all()
    given = region_map(smooth, (angle, "mu"), ranges={"mu": (0.01, 0.02)}, points=5)
    assert given.values[1][-1] == 0.02


@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
def test_a_zero_line_that_A_and_B_share_is_one_line_and_no_crossing(tmp_path):
    # A and B of the strut both have the factor cos(theta).
    options = {"ranges": {"theta": (0.1, 3.04), "mu": (0.0, 2.0)}, "points": 101}
    regions = region_map("strut", ("theta", "mu"), **options)
    assert regions.shared_zeros == [{"theta": pytest.approx(math.pi / 2, abs=1e-12)}]
    # Without the factor, A = 0 is tan(theta) = 1/mu, and B = 0 the balance of spring and weight.
    upright = brentq(lambda a: 10 * (a - 1.5) - 9.8 * 0.5 * math.cos(a), 1.0, 1.57, xtol=1e-15)
    expected = [[upright, 1 / math.tan(upright)]]
    np.testing.assert_allclose(regions.crossings, expected, rtol=1e-12)
    regions.save(tmp_path / "map.npz")
    assert RegionMap.load(tmp_path / "map.npz").shared_zeros == regions.shared_zeros


@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
def test_crossing_of_A_and_B_has_four_cases_around_it():
    """Each combination of signs is next to it, however near; a false crossing lacks some."""
    options = {"ranges": {"theta": (0.1, 3.04), "mu": (0.0, 2.0)}, "points": 101}
    (theta, mu), *more = region_map("strut", ("theta", "mu"), **options).crossings.tolist()
    assert not more
    for width in (1e-2, 1e-4):
        ranges = {"theta": (theta - width, theta + width), "mu": (mu - width, mu + width)}
        near = region_map("strut", ("theta", "mu"), ranges=ranges, points=11)
        cases = ("slip", "liftoff", "inconsistent", "indeterminate")
        assert all(near.counts[name] >= 5 for name in cases)
        assert sum(near.counts[name] for name in cases) == 121
        assert near.shared_zeros == []
        np.testing.assert_allclose(near.crossings, [[theta, mu]], rtol=1e-12)


@pytest.mark.parametrize(("beyond", "count"), [(0.01, 0), (-0.01, 1)])
def test_crossing_outside_the_domain_is_none(beyond, count):
    theta = math.asin(9.8 / 3.4**2)
    mu = (4 + math.tan(theta) ** 2) / (3 * math.tan(theta))
    rod = ps.models.rod()
    own = {str(s): s for s in rod.system.mass_matrix.free_symbols}
    # Both curves reach into the domain, whose border passes near the place where they cross.
    margin = rod.contacts[0].friction - mu + own["theta"] - theta - beyond
    half = ps.Mechanism(
        "half rod",
        "rod of a half plane of theta and mu",
        "none",
        rod.system,
        rod.contacts,
        domain=(DomainBound(margin, "in its half plane"),),
    )
    ranges = {"theta": (0.5, 1.5), "mu": (0.5, 3.0)}
    regions = region_map(half, ("theta", "mu"), ranges=ranges, state={"theta_dot": 3.4}, points=40)
    assert all(len(curve) > 3 for curve in regions.curves.values())
    assert len(regions.crossings) == count


def test_a_map_follows_the_gap_where_the_contact_moves_with_an_axis():
    ranges = {"h": (0.2, 1.2), "tau": (-20.0, 20.0)}
    options = {"ranges": ranges, "points": 25, "close": "theta", "parameters": {"mu": 2.0}}
    regions = region_map("pr-robot", ("h", "tau"), **options)
    reached = regions.values[0] < 1.0  # the arm is 1 m long
    assert ((regions.case == LEGEND["outside"]) == ~reached[:, None]).all()
    for i, j in ((0, 3), (11, 20), (18, 12)):
        axes = {"h": float(regions.values[0][i]), "tau": float(regions.values[1][j])}
        alone = classify("pr-robot", regions.state, parameters={"mu": 2.0, **axes}, close="theta")
        assert (regions.A[i, j], regions.B[i, j]) == (alone.A, alone.B)
    assert len(regions.crossings)
    for point in regions.crossings.tolist():
        axes = dict(zip(regions.over, point, strict=True))
        at = classify("pr-robot", regions.state, parameters={"mu": 2.0, **axes}, close="theta")
        assert abs(at.A) < 1e-12 * np.nanmax(np.abs(regions.A))
        assert abs(at.B) < 1e-11 * np.nanmax(np.abs(regions.B))


def test_a_map_without_a_state_is_at_the_start_of_the_mechanism():
    robot = model("pr-robot")
    regions = region_map(robot, ("x_dot", "mu"), points=5)
    start = dict.fromkeys(robot.state_names, 0.0) | robot.start
    assert regions.state == {n: v for n, v in start.items() if n != "x_dot"}
    with pytest.raises(InputError, match="close: theta is an axis"):
        region_map(robot, ("theta", "mu"), points=5, close="theta")


def test_crossings_outside_of_the_domain_are_left_out():
    rod = model("rod")
    over = {"over": ("theta", "theta_dot"), "points": 61, "ranges": {"theta": (0.2, 1.5)}}
    every = region_map(rod, **over).crossings
    angles = sorted({round(x, 9) for x in every[:, 0].tolist()})
    assert len(angles) == 2 and len(every) == 4
    (theta,) = (c.symbol for c in rod.system.coordinates if c.name == "theta")
    # Next to a crossing, within a cell of the grid, and half way between both.
    for beyond, kept in ((0.004, 1), (-0.004, 0), (0.15, 1)):
        border = sp.Rational(round(10_000 * (angles[1 - kept] + beyond)), 10_000)
        sign = 1 if kept else -1
        part = dataclasses.replace(
            rod, domain=(*rod.domain, DomainBound(sign * (theta - border), "it is on one side"))
        )
        regions = region_map(part, **over)
        expected = every[np.isclose(every[:, 0], angles[kept])]
        np.testing.assert_allclose(regions.crossings, expected, atol=1e-9)
        listed = regions.to_dict()["crossings"]
        assert [p["theta"] for p in listed] == regions.crossings[:, 0].tolist()


def test_a_crossing_just_beyond_the_domain_is_left_out():
    """Both curves pass the last cell inside; they meet a little above, where Newton's steps go."""
    rod = model("rod")
    every = region_map(rod, ("theta", "theta_dot"), points=61).crossings
    theta, rate = next((x, y) for x, y in every.tolist() if y > 0)
    (symbol,) = (v.symbol for v in rod.system.velocities if v.name == "theta_dot")
    end = rate - 0.01
    ranges = {"theta": (theta - 0.305, theta + 0.295), "theta_dot": (end - 3.0, end + 3.0)}
    over = {"over": ("theta", "theta_dot"), "points": 61, "ranges": ranges}
    assert np.isclose(region_map(rod, **over).crossings, [theta, rate]).all(axis=1).any()
    bound = DomainBound(rate - 0.005 - symbol, "it turns slowly")
    slow = dataclasses.replace(rod, domain=(*rod.domain, bound))
    assert (region_map(slow, **over).crossings[:, 1] < rate - 0.005).all()


def test_tables_and_figure_of_a_map_have_its_numbers():
    pytest.importorskip("pandas", reason="needs the extra cluster (pandas)")
    pytest.importorskip("xarray", reason="needs the extra cluster (xarray)")
    regions = ps.region_map("rod", ("theta", "mu"), points=12)
    frame, data = regions.to_dataframe(), regions.to_xarray()
    assert frame.shape == (144, 8) and data["A"].dims == ("theta", "mu")
    assert frame["case"].value_counts().to_dict() == {k: v for k, v in regions.counts.items() if v}
    k = 5 * 12 + 7  # the point (5, 7)
    for i, name in enumerate(regions.over):
        assert frame[name][k] == regions.values[i][(5, 7)[i]]
    assert frame["A"][k] == regions.A[5, 7] == float(data["A"][5, 7])
    assert str(data["case"].values[5, 7]) == frame["case"][k]
    assert frame.attrs["units"]["B"] == data["B"].attrs["units"] == "m/s^2"
    figure = regions.plot()
    assert "theta" in figure.axes[0].get_xlabel() and "mu" in figure.axes[0].get_ylabel()
