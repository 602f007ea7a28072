"""Bodies with modes: energies by quadrature, files against the named rod, limits, bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, ModelError
from painleve_sym.mechanics.bars import (
    MAX_MODES,
    axial_modes,
    bending_modes,
    first_bending_wavenumber,
)
from painleve_sym.mechanics.bodies import Body, Mode
from painleve_sym.mechanics.declarations import Coordinate
from painleve_sym.mechanics.models.rods import rod_bending
from painleve_sym.mechanics.system import LagrangianSystem
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.simulator import Simulator
from tests.mechanics.catalogue import by_symbol, random_numbers
from tests.support.paper_law import paper_law

# ---- uniform bars ----

CHARACTERISTIC = {
    ("free", "free"): lambda x: math.cos(x) - 1 / math.cosh(x),
    ("clamped", "clamped"): lambda x: math.cos(x) - 1 / math.cosh(x),
    ("clamped", "free"): lambda x: math.cos(x) + 1 / math.cosh(x),
    ("pinned", "free"): lambda x: math.tan(x) - math.tanh(x),
    ("pinned", "pinned"): math.sin,
}


@pytest.mark.parametrize(
    "ends",
    [
        pytest.param(e, marks=pytest.mark.slow if k > 1 else ())
        for k, e in enumerate(CHARACTERISTIC)
    ],
)
def test_wavenumbers_are_the_roots_of_the_classical_equations(ends):
    for mode in bending_modes(ends, 8):
        beta = float(mode.wavenumber)
        root = brentq(CHARACTERISTIC[ends], beta - 0.3, beta + 0.3, xtol=1e-14)
        assert math.isclose(beta, root, rel_tol=1e-13)
    assert first_bending_wavenumber(ends) == bending_modes(ends, 1)[0].wavenumber


@pytest.mark.slow
def test_free_ends_deflect_by_twice_the_root_mean_square_in_bending_and_root_two_along():
    for i, mode in enumerate(bending_modes(("free", "free"), MAX_MODES)):
        assert mode.ends == (2, 2 * (-1) ** i)
        assert mode.momentum == 0 and mode.moment == 0
    for j, mode in enumerate(axial_modes(("free", "free"), 5), 1):
        assert mode.ends == (sp.sqrt(2), sp.sqrt(2) * (-1) ** j)


@pytest.mark.slow
@pytest.mark.parametrize("modes", [axial_modes, bending_modes])
def test_modes_of_a_clamped_bar_carry_its_whole_momentum(modes):
    """Completeness: Σ (∫φ)² → ∫1² = 1, Σ (∫(s − ½) φ)² → 1/12 as the modes become many."""
    bar = modes(("clamped", "free"), 12)
    rest = [1 - sum(float(m.momentum) ** 2 for m in bar[:n]) for n in (3, 6, 12)]
    assert rest[0] > rest[1] > rest[2] > 0 and rest[2] < 0.04
    turning = [1 / 12 - sum(float(m.moment) ** 2 for m in bar[:n]) for n in (3, 6, 12)]
    assert turning[0] > turning[1] > turning[2] > 0 and turning[2] < 0.02


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: bending_modes(("free", "free"), 21), "got 21, need a whole number 0 to 20"),
        (lambda: bending_modes(("free", "loose"), 2), "got 'loose', need one of free, clamped"),
        (lambda: axial_modes(("pinned", "free"), 2), "got 'pinned', need one of free, clamped."),
        (lambda: model("rod-bending:3"), "need the numbers of bending modes and axial modes"),
        (lambda: model("rod-bending:3,-1"), "need the numbers of bending modes and axial modes"),
        (lambda: model("rod-bending:99,1"), "got 99, need a whole number 0 to 20"),
        (lambda: model("rod:3"), "nothing is counted"),
        (lambda: model("rod-bendin:3,1"), "unknown model 'rod-bendin:3,1'. Did you mean"),
    ],
)
def test_numbers_of_modes_and_ends_that_cannot_be_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()


# ---- energies ----


def _clamped_bar():
    """Return a bar clamped in a moving frame, with two bending modes and one along it."""
    names = ("x", "y", "phi", "w_1", "w_2", "u_1")
    coordinates = [Coordinate(n, n, "rad" if n == "phi" else "m") for n in names]
    x, y, phi, *modal = (c.symbol for c in coordinates)
    bend, along = bending_modes(("clamped", "free"), 2), axial_modes(("clamped", "free"), 1)
    modes = [
        Mode(q, 1, 10 + i, momentum=(0, b.momentum), angular_momentum=b.moment)
        for i, (q, b) in enumerate(zip(modal[:2], bend, strict=True))
    ]
    modes.append(Mode(modal[2], 1, 90, momentum=(along[0].momentum, 0), stretch=along[0].moment))
    return coordinates, Body(1, (x, y), sp.Rational(1, 12), phi, tuple(modes), "bar")


def _bar_shapes(s):
    """Return the shapes of the bar by the textbook formulas."""
    across = []
    for beta in (1.8751040687119612, 4.694091132974174):
        sigma = (math.cosh(beta) + math.cos(beta)) / (math.sinh(beta) + math.sin(beta))
        x = beta * s
        across.append(np.cosh(x) - np.cos(x) - sigma * (np.sinh(x) - np.sin(x)))
    across = [a * np.sign(a[-1]) for a in across]
    return across, [np.sqrt(2) * np.sin(np.pi / 2 * s)]


@pytest.mark.slow
@settings(max_examples=20)
@given(st.integers(0, 10**6))
def test_kinetic_energy_and_momentum_of_a_clamped_bar_are_those_of_its_particles(seed):
    rng = np.random.default_rng(seed)
    coordinates, body = _clamped_bar()
    rates = {c.symbol: c.rate for c in coordinates}
    nodes, weights = np.polynomial.legendre.leggauss(40)
    s = np.append((nodes + 1) / 2, 1.0)
    across, along = _bar_shapes(s)
    values = {c.symbol: rng.uniform(-1, 1) for c in coordinates}
    speeds = {c.rate: rng.uniform(-1, 1) for c in coordinates}
    # The bar is not deflected: what modes leave out is of second order in the deflections.
    values |= {m.coordinate: 0.0 for m in body.modes}
    turn = values[coordinates[2].symbol]
    v_x, v_y, omega, *modal = (speeds[c.rate] for c in coordinates)
    local = np.stack([sum(m * a for m, a in zip(modal[2:], along, strict=True)),
                      sum(m * a for m, a in zip(modal[:2], across, strict=True))
                      + omega * (s - 0.5)])  # fmt: skip
    c, d = math.cos(turn), math.sin(turn)
    velocity = np.array([v_x + c * local[0] - d * local[1], v_y + d * local[0] + c * local[1]])
    expected = np.sum(weights / 2 * (velocity[:, :-1] ** 2).sum(axis=0)) / 2
    kinetic = float(body.kinetic_energy(rates).subs(values | speeds))
    assert math.isclose(kinetic, expected, rel_tol=1e-12)
    end = body.point((sp.Rational(1, 2), 0), {
        m.coordinate: (0, 2) if i < 2 else (sp.sqrt(2), 0) for i, m in enumerate(body.modes)
    })  # fmt: skip
    rate = [sum(sp.diff(p, q) * v for q, v in rates.items()).subs(values | speeds) for p in end]
    assert np.allclose([float(r) for r in rate], velocity[:, -1], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("seed", range(4))
def test_mass_matrix_of_a_stretched_bar_is_that_of_its_particles(seed):
    """With modes along the bar alone nothing of their second order is left out."""
    rng = np.random.default_rng(seed)
    mechanism = model("rod-bending:0,3")
    values = random_numbers(mechanism, rng)
    stretched = rng.uniform(-0.3, 0.3, 3)
    values |= {f"u_{j}": u for j, u in enumerate(stretched, 1)}
    nodes, weights = np.polynomial.legendre.leggauss(40)
    s, weights = (nodes + 1) / 2, values["m"] * weights / 2
    shift = sum(u * np.sqrt(2) * np.cos(j * np.pi * s) for j, u in enumerate(stretched, 1))
    arm = values["l"] * (2 * s - 1) + shift
    system = mechanism.system
    inertia = numbers([system.mass_matrix[2, 2]], by_symbol(mechanism, values))[0]
    expected = np.sum(weights * arm**2) + values["m"] * values["l"] ** 2
    assert math.isclose(inertia, expected, rel_tol=1e-12)


# ---- files ----

FREE_ROD = """\
[coordinates]
x_A = { unit = "m" }
y_A = { unit = "m" }
theta = { unit = "rad" }
w_1 = { unit = "m" }
u_1 = { unit = "m" }
[parameters]
m = { default = 1.0, unit = "kg", positive = true }
l = { default = 1.0, unit = "m", positive = true }
g = { default = 9.8, unit = "m/s^2", lower = 0 }
mu = { default = 1.4, unit = "1" }
[[bodies]]
name = "rod"
mass = "m"
inertia = "m*l**2/3"
centre = ["x_A + l*cos(theta)", "y_A + l*sin(theta)"]
angle = "theta"
[[bodies.modes]]
coordinate = "w_1"
mass = "m"
frequency = 65
damping = 0.01
[[bodies.modes]]
coordinate = "u_1"
mass = "m"
frequency = 8105
stretch = "-4*sqrt(2)/pi**2*m*l"
[[contacts]]
name = "A"
friction = "mu"
point = { body = "rod", at = ["-l", "0"], shape = { w_1 = ["0", "2"], u_1 = ["sqrt(2)", "0"] } }
"""


ONE_KIND = FREE_ROD.replace('stretch = "-4*sqrt(2)/pi**2*m*l"\n', "")
"""The same with two modes of bending."""


def test_file_with_modes_is_the_named_elastic_rod():
    named, file = model("rod-bending:1,1"), mechanism_from_text(FREE_ROD)
    values = random_numbers(named, np.random.default_rng(3))
    for form in ("W_nn", "W_nt", "W_tt"):
        pair = [
            numbers([getattr(m.coefficients, form)], by_symbol(m, values))[0] for m in (named, file)
        ]
        assert math.isclose(*pair, rel_tol=1e-13)


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("frequency = 65", "frequency = 0", "mode w_1: frequency is 0, need > 0."),
        ("frequency = 65", "frequency = -1", "mode w_1: frequency is -1, need > 0."),
        ("frequency = 65", "frequency = 9000", "frequency 8105 is below the one before, 9000."),
        ("damping = 0.01", "damping = -0.01", "mode w_1: damping ratio is -1/100, need >= 0."),
        ("w_1 = [\"0\", \"2\"], ", "", "mode w_1 has no value at this point. Fix: give its shape"),
        ("u_1 = [\"sqrt", "v_1 = [\"sqrt", "v_1 is not a mode of this body; its modes: w_1, u_1."),
        ("body = \"rod\"", "body = \"rob\"", "unknown body 'rob'. Did you mean 'rod'?"),
        ("body = \"rod\", ", "", "contacts[1].point: body is missing."),
        ("coordinate = \"w_1\"", "coordinate = \"w_2\"", "unknown coordinate 'w_2'. Did you"),
        ("coordinate = \"w_1\"\nmass = \"m\"", "coordinate = \"w_1\"\nmass = 0", "mass is 0, need"),
        ("frequency = 65", "", "bodies[1].modes[1]: frequency is missing."),
        ("frequency = 65", "frequncy = 65", "unknown key 'frequncy'. Did you mean 'frequency'?"),
    ],
)  # fmt: skip
def test_modes_with_a_fault_are_refused_with_line_and_fix(old, new, fault):
    assert old in ONE_KIND
    with pytest.raises(ModelError) as caught:
        mechanism_from_text(ONE_KIND.replace(old, new, 1), "file")
    assert any(fault in f for f in caught.value.faults), caught.value.faults


@pytest.mark.slow
def test_modes_ascend_within_their_kind_alone():
    """The seventeenth bending mode of the paper's rod is faster than its first axial one."""
    assert len(mechanism_from_text(FREE_ROD.replace("= 65", "= 9000", 1)).system.q) == 5
    bar = model("rod-bending:17,1")
    (body,) = bar.system.bodies
    values = {p.symbol: p.default for p in bar.system.parameters}
    frequencies = [float(mode.frequency.subs(values)) for mode in body.modes]
    assert frequencies[16] > frequencies[17]
    assert [len(list(b.successive_modes)) for b in bar.system.bodies] == [16]


OPEN_ROD = ONE_KIND.replace("[[bodies]]", 'q = { default = -3.0, unit = "1" }\n[[bodies]]', 1)


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        (
            "frequency = 65",
            'frequency = "q"',
            "w_1: frequency is q = -3.00000 at the defaults, need",
        ),
        ("frequency = 65", 'frequency = "-3000*q"', "8105 is below the one before, -3000*q."),
        ("damping = 0.01", 'damping = "q"', "w_1: damping ratio is q = -3.00000 at the defaults"),
        ("damping = 0.01", 'damping = "-q"', "is -q, which other parameters make negative, need"),
    ],
)
def test_formulas_of_modes_with_a_fault_at_the_defaults_are_rejected(old, new, fault):
    with pytest.raises(ModelError) as caught:
        mechanism_from_text(OPEN_ROD.replace(old, new, 1), "file")
    assert any(fault in f for f in caught.value.faults), caught.value.faults


@pytest.mark.slow
@pytest.mark.parametrize(
    ("value", "fault"),
    [
        (-3.0, "need q > 0 (rod: mode w_1: a natural frequency is positive)"),
        (9000.0, "need 8105 - q > 0 (rod: mode u_1: modes of one kind ascend in frequency)"),
    ],
)
def test_parameters_that_make_frequencies_descend_or_negative_are_rejected(value, fault):
    from painleve_sym.at.cases import classify

    text = OPEN_ROD.replace("frequency = 65", 'frequency = "q"').replace("-3.0", "65.0")
    mechanism, state = mechanism_from_text(text), {"theta": 1.0, "x_A_dot": -1.0}
    assert classify(mechanism, state).solutions is not None
    with pytest.raises(InputError) as caught:
        classify(mechanism, state, parameters={"q": value})
    assert fault in str(caught.value)


def test_mode_of_a_coordinate_that_the_system_lacks_is_refused():
    coordinates, body = _clamped_bar()
    with pytest.raises(ModelError, match="bar: mode: unknown coordinate 'u_1'"):
        LagrangianSystem.of_bodies("bar", coordinates[:-1], (), [body])


def test_bar_that_is_too_thick_for_its_length_is_outside_the_model():
    from painleve_sym.at.cases import classify

    with pytest.raises(InputError, match="thicker than a fifth of its length is not slender"):
        classify("rod-bending:1,0", {"theta": 1.0, "x_A_dot": -1.0}, parameters={"rho": 1.0})


# ---- motion ----

HERTZ = paper_law()
TABLE_3 = {"theta": 1.0, "x_A_dot": -1.0, "theta_dot": 1.0}


def test_rod_without_modes_is_the_rigid_rod():
    runs = [Simulator(m, HERTZ).run(TABLE_3, t_end=0.01) for m in (rod_bending(0, 0), model("rod"))]
    for pair in zip(*(run.events for run in runs), strict=True):
        assert math.isclose(*(e.time for e in pair), rel_tol=1e-10)


def test_stiff_modes_tend_to_the_rigid_rod_and_the_difference_falls_as_their_stiffness_grows():
    """The rod of a modulus 10 times as large differs a tenth as much: modes follow statically."""
    rigid = Simulator(model("rod"), HERTZ).run(TABLE_3, t_end=0.01)
    separation = rigid.events_of("slip_stop")[0].time
    simulator = Simulator(model("rod-bending:1,0"), HERTZ)
    errors = []
    for modulus in (1e16, 1e17, 1e18):
        run = simulator.run(TABLE_3, t_end=0.01, parameters={"Y": modulus}, until="slip_stop")
        errors.append(run.events_of("slip_stop")[0].time - separation)
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(10, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("zeta", [0.0, 0.05])
def test_energy_closes_with_what_stays_in_vibration(zeta):
    run = Simulator(model("rod-bending:2,1"), HERTZ).run(
        TABLE_3, t_end=0.02, parameters={"zeta": zeta}
    )
    assert run.energy_residual < 1e-9
    vibration = sum(run[f"{q}_dot"][-1] ** 2 / 2 for q in ("w_1", "w_2", "u_1"))
    assert vibration > 1e-3
