"""Named mechanisms against Newton and Euler, and their critical friction in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from painleve_sym.at.cases import classify, contact_problem
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.models import MODELS, NAMED, title_of
from painleve_sym.mechanics.paradox.critical_friction import critical_friction
from tests.mechanics.catalogue import (
    NAMES,
    ONE_CONTACT,
    SOFTENED,
    by_symbol,
    derived,
    random_numbers,
)
from tests.mechanics.machines import MACHINES
from tests.support.vanishing import vanishes

every_mechanism = pytest.mark.parametrize("name", NAMES)
SEEDS = range(4)


def test_machines_cover_every_named_mechanism():
    assert set(MACHINES) == set(MODELS)


def test_lists_of_mechanisms_are_by_their_contacts():
    assert [n for n in NAMES if len(derived(n).contacts) == 1] == ONE_CONTACT
    assert [n for n in ONE_CONTACT if not derived(n).contact.bilateral] == SOFTENED


# ---- Newton and Euler ----


def _accelerations(mechanism, values, forces):
    """Return q̈ of Lagrange's equations under the forces (F_n, F_t) of every contact."""
    free = mechanism.system.free_acceleration
    total = numbers(list(free), by_symbol(mechanism, values))
    for c, (f_n, f_t) in zip(mechanism.all_coefficients, forces, strict=True):
        part = c.accelerations - free
        at = by_symbol(mechanism, values) | {F_N: f_n, F_T: f_t}
        total = total + numbers(list(part), at)
    return total


def _closeness(actual, expected):
    return np.max(np.abs(np.subtract(actual, expected))) / max(1.0, np.max(np.abs(expected)))


@every_mechanism
@pytest.mark.parametrize("pushed", [False, True], ids=["free", "with contact forces"])
def test_mechanism_accelerations_agree_with_newton_and_euler(name, pushed):
    mechanism, rng = derived(name), np.random.default_rng(7)
    for _ in SEEDS:
        values = random_numbers(mechanism, rng)
        machine = MACHINES[name](values)
        motion = machine.motion(np.array([values[v.name] for v in mechanism.system.q_dot]))
        n = len(mechanism.contacts)
        forces = rng.uniform(-3, 3, (n, 2)) if pushed else np.zeros((n, 2))
        expected = machine.accelerations(motion, forces)
        assert _closeness(_accelerations(mechanism, values, forces), expected) < 1e-10


@every_mechanism
def test_mechanism_contact_velocities_agree_with_newton_and_euler(name):
    mechanism, rng = derived(name), np.random.default_rng(11)
    for _ in SEEDS:
        values = random_numbers(mechanism, rng)
        machine = MACHINES[name](values)
        motion = machine.motion(np.array([values[v.name] for v in mechanism.system.q_dot]))
        for contact, touch in zip(mechanism.contacts, machine.touches, strict=True):
            rates = [contact.gap_rate, contact.slip_velocity]
            velocities = numbers(rates, by_symbol(mechanism, values))
            assert _closeness(velocities, machine.contact_velocity(motion, touch)) < 1e-12


@every_mechanism
def test_mechanism_contact_accelerations_agree_with_newton_and_euler(name):
    mechanism, rng = derived(name), np.random.default_rng(13)
    for _ in SEEDS:
        values = random_numbers(mechanism, rng)
        machine = MACHINES[name](values)
        motion = machine.motion(np.array([values[v.name] for v in mechanism.system.q_dot]))
        entries = zip(mechanism.all_coefficients, machine.touches, strict=True)
        for i, (c, touch) in enumerate(entries):
            forces = np.zeros((len(mechanism.contacts), 2))
            forces[i] = rng.uniform(-3, 3, 2)
            f_n, f_t = forces[i]
            rates = [c.W_nn * f_n + c.W_nt * f_t + c.b_n, c.W_nt * f_n + c.W_tt * f_t + c.b_t]
            accelerations = numbers(rates, by_symbol(mechanism, values))
            expected = machine.contact_acceleration(motion, touch, forces)
            assert _closeness(accelerations, expected) < 1e-10


@every_mechanism
def test_mechanism_dissipated_power_is_the_power_balance(name):
    """d(T + V)/dt = −P along the motion without contact forces."""
    mechanism, rng = derived(name), np.random.default_rng(17)
    system = mechanism.system
    energy = system.kinetic_energy + system.potential_energy
    values = random_numbers(mechanism, rng)
    at = by_symbol(mechanism, values)
    slopes = numbers([sp.diff(energy, s) for s in (*system.q, *system.q_dot)], at)
    rates = [values[v.name] for v in system.q_dot]
    power = slopes @ np.concatenate([rates, numbers(list(system.free_acceleration), at)])
    lost = numbers([system.dissipated_power], at)[0]
    assert math.isclose(power, -lost, rel_tol=1e-10, abs_tol=1e-10 * np.abs(slopes).max())


# ---- what every mechanism has ----


@pytest.mark.parametrize("name", ONE_CONTACT)
def test_mechanism_starts_in_contact_and_sliding(name):
    mechanism = derived(name)
    if mechanism.contact.bilateral:
        # Two solutions are possible; here only that the start slides.
        values = {p.name: p.default for p in mechanism.system.parameters}
        start = dict.fromkeys(mechanism.state_names, 0.0) | dict(mechanism.start)
        assert contact_problem(mechanism, start, values).slip_direction
        return
    classification = classify(mechanism, mechanism.start)
    assert classification.problem.slip_direction


@every_mechanism
def test_mechanism_has_a_sketch_of_ascii_lines(name):
    mechanism = derived(name)
    assert mechanism.sketch.isascii() and mechanism.sketch.endswith("\n")
    assert all(len(line) <= 78 for line in mechanism.sketch.splitlines())
    assert mechanism.name == name


@every_mechanism
def test_mechanism_parameters_do_not_clash_with_those_of_laws(name):
    taken = {"E", "nu", "R", "n", "l_0", "k", "c", "e_energetic", "e_newton", "e_poisson"}
    assert not taken & {p.name for p in derived(name).system.parameters}


# Operations in (W_nn, W_nt, W_tt, b_n, b_t, A_stick): a longer writing is a change to be seen.
LONGEST = {
    "rod": (5, 6, 5, 5, 4, 6),
    "rod-inertia": (5, 6, 5, 5, 4, 7),
    "rod-bending": (124, 107, 124, 264, 239, 356),
    "block": (25, 18, 25, 10, 10, 28),
    "block-two-feet": (19, 13, 19, 10, 11, 26),
    "eccentric-disc": (7, 8, 14, 5, 4, 27),
    "cart-pendulum": (24, 17, 24, 74, 56, 18),
    "two-link-arm": (29, 32, 29, 156, 155, 69),
    "pr-robot": (14, 17, 15, 50, 60, 9),
    "strut": (4, 6, 4, 22, 22, 0),
    "painleve-klein": (10, 11, 11, 27, 27, 8),
}


@every_mechanism
def test_mechanism_closed_forms_stay_as_short_as_they_are(name):
    for c in derived(name).all_coefficients:
        forms = (c.W_nn, c.W_nt, c.W_tt, c.b_n, c.b_t, c.A_stick)
        lengths = tuple(int(sp.count_ops(form)) for form in forms)
        assert all(n <= limit for n, limit in zip(lengths, LONGEST[name], strict=True)), lengths


@every_mechanism
def test_mechanism_mass_matrix_is_positive_definite_at_random_states(name):
    mechanism = derived(name)
    entries = list(mechanism.system.mass_matrix)

    @settings(max_examples=15)
    @given(st.integers(0, 10**6))
    def check(seed):
        values = random_numbers(mechanism, np.random.default_rng(seed))
        n = len(mechanism.system.q)
        mass = numbers(entries, by_symbol(mechanism, values)).reshape(n, n)
        assert np.array_equal(mass, mass.T)
        assert np.all(np.linalg.eigvalsh(mass) > 0)

    check()


def test_block_with_two_feet_names_its_contacts_but_has_no_only_one():
    mechanism = derived("block-two-feet")
    assert [c.name for c in mechanism.contacts] == ["A", "B"]
    with pytest.raises(InputError, match="got 2 contacts, need one"):
        _ = mechanism.coefficients


# ---- critical friction ----


def _coefficients_at(name, **values):
    """Return W as a function of the free quantities, the rest at its default."""
    mechanism = derived(name)
    at = {p.symbol: sp.nsimplify(p.default) for p in mechanism.system.parameters}
    at |= {s: v for s in mechanism.system.symbols for n, v in values.items() if s.name == n}
    c = mechanism.coefficients
    return [form.subs(at) for form in (c.W_nn, c.W_nt, c.W_tt)]


def test_rod_of_any_inertia_has_the_critical_friction_of_the_literature():
    c = derived("rod-inertia").coefficients
    alpha, theta = sp.Symbol("alpha", positive=True), sp.Symbol("theta", real=True)
    expected = (1 + alpha + sp.tan(theta) ** 2) / (alpha * sp.tan(theta))
    assert vanishes(-c.W_nn / c.W_nt - expected)
    lowest = critical_friction(c).minimum("theta")
    assert vanishes(lowest.value - 2 * sp.sqrt(1 + alpha) / alpha)
    assert lowest.variable == sp.tan(theta)
    assert {sp.simplify(abs(p)) for p in lowest.at} == {sp.sqrt(alpha + 1)}
    assert lowest.value.subs(alpha, 3) == sp.Rational(4, 3)


def test_rod_of_any_inertia_is_the_slender_rod_at_three():
    rod, any_rod = derived("rod").coefficients, derived("rod-inertia").coefficients
    alpha = sp.Symbol("alpha", positive=True)
    for form in ("W_nn", "W_nt", "W_tt", "b_n", "b_t", "A_stick", "B_stick", "sticking_force"):
        difference = getattr(any_rod, form).subs(alpha, 3) - getattr(rod, form)
        assert vanishes(difference), form


@pytest.mark.parametrize("name", ["rod", "block", "cart-pendulum"])
def test_critical_friction_is_least_where_the_surface_halves_the_axes_of_the_mobility(name):
    """min μ_P = 2 √(λ₁ λ₂)/(λ₂ − λ₁): turning the body turns W, whose eigenvalues stay."""
    angle = {"rod": "theta", "block": "theta", "cart-pendulum": "phi"}[name]
    q = sp.Symbol(angle, real=True)
    W_nn, W_nt, W_tt = _coefficients_at(name, mu=0)
    at = {q: sp.Rational(7, 10)}
    low, high = np.linalg.eigvalsh(
        np.array([[W_nn.subs(at), W_nt.subs(at)], [W_nt.subs(at), W_tt.subs(at)]], dtype=float)
    )
    ratio = sp.lambdify(q, W_nn / sp.Abs(W_nt), "math")
    grid = np.linspace(0.01, 3.13, 400)
    best = grid[np.argmin([ratio(float(x)) for x in grid])]
    minimum = minimize_scalar(ratio, bounds=(best - 0.01, best + 0.01), options={"xatol": 1e-12})
    assert math.isclose(minimum.fun, 2 * math.sqrt(low * high) / (high - low), rel_tol=1e-9)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("rod", "4/3"),
        ("block", "4/3"),
        ("cart-pendulum", "2*sqrt(M*(M + m))/m"),
    ],
)
def test_critical_friction_minimum_in_closed_form(name, expected):
    mechanism = derived(name)
    values = {p.symbol.name: p.default for p in mechanism.system.parameters}
    c, J = mechanism.coefficients, sp.Symbol("J", nonnegative=True)
    product = (c.W_nn * c.W_tt - c.W_nt**2).subs(J, 0)
    discriminant = ((c.W_nn - c.W_tt) ** 2 + 4 * c.W_nt**2).subs(J, 0)
    least = 2 * sp.sqrt(product / discriminant)
    at = by_symbol(mechanism, {**values, **dict.fromkeys(mechanism.state_names, 0.4)})
    wanted = sp.sympify(expected).subs(values)
    assert math.isclose(float(least.subs(at)), float(wanted), rel_tol=1e-12)


def test_eccentric_disc_critical_friction_in_closed_form():
    c = derived("eccentric-disc").coefficients
    m, r, J = (sp.Symbol(n, positive=True) for n in ("m", "r", "J"))
    d, phi = sp.Symbol("d", nonnegative=True), sp.Symbol("phi", real=True)
    expected = (J / m + d**2 * sp.cos(phi) ** 2) / (d * sp.cos(phi) * (r + d * sp.sin(phi)))
    assert vanishes(-c.W_nn / c.W_nt - expected)


def test_pr_robot_critical_friction_in_closed_form():
    c = derived("pr-robot").coefficients
    m_1, m_2 = (sp.Symbol(n, positive=True) for n in ("m_1", "m_2"))
    theta = sp.Symbol("theta", real=True)
    expected = 2 * (m_1 + m_2) / ((2 * m_1 + m_2) * sp.tan(theta))
    assert vanishes(-c.W_nn / c.W_nt - expected)


def test_strut_has_a_mobility_of_rank_one():
    c = derived("strut").coefficients
    theta = sp.Symbol("theta", real=True)
    assert vanishes(c.W_nn * c.W_tt - c.W_nt**2)
    assert c.A_stick == 0
    assert vanishes(-c.W_nn / c.W_nt - 1 / sp.tan(theta))


def test_painleve_klein_critical_friction_in_closed_form():
    mechanism = derived("painleve-klein")
    c = mechanism.coefficients
    m_1, m_2 = (sp.Symbol(n, positive=True) for n in ("m_1", "m_2"))
    phi = sp.Symbol("phi", real=True)
    assert mechanism.contact.bilateral
    assert vanishes(-c.W_nn / c.W_nt - (m_1 + m_2) / (m_2 * sp.tan(phi)))


def test_painleve_klein_normal_force_at_rest_carries_the_weights_and_the_pull():
    """At rest and μ = 0: F_n = −b_n/W_nn; the upper guide takes its share of the weight."""
    mechanism = derived("painleve-klein")
    c = mechanism.coefficients
    values = {p.name: p.default for p in mechanism.system.parameters} | {"P_1": 0.0, "P_2": 3.0}
    values |= dict.fromkeys(mechanism.state_names, 0.0) | {"phi": values["phi_0"]}
    force = numbers([-c.b_n / c.W_nn], by_symbol(mechanism, values))[0]
    # The rod pulls both blocks along with P_2/(m_1 + m_2): its force is m_1 a/cosφ.
    a = 3.0 / (values["m_1"] + values["m_2"])
    expected = values["m_1"] * values["g"] - values["m_1"] * a * math.tan(values["phi_0"])
    assert math.isclose(force, expected, rel_tol=1e-12)


# ---- the registry ----


def test_model_reads_a_mechanism_file(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        model(str(tmp_path / "absent.toml"))


def test_model_suggests_the_nearest_name():
    with pytest.raises(InputError, match="Did you mean 'two-link-arm'"):
        model("two-link-am")


@pytest.mark.parametrize("name", NAMED)
def test_title_is_known_without_the_mechanism(name):
    assert title_of(name) == model(name).title
