"""Mechanisms from `sympy.physics.mechanics` and from M and h are those of our own description."""

from __future__ import annotations

import functools

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from sympy.physics.mechanics import (
    KanesMethod,
    LagrangesMethod,
    Lagrangian,
    Particle,
    Point,
    ReferenceFrame,
    RigidBody,
    dynamicsymbols,
    inertia,
)

import painleve_sym as ps
from painleve_sym.laws.catalogue import LAWS

T = dynamicsymbols._t
X, Y, THETA = dynamicsymbols("x_A y_A theta")
RATES = X_DOT, Y_DOT, THETA_DOT = tuple(q.diff(T) for q in (X, Y, THETA))
M, L, G, MU = sp.symbols("m l g mu")  # plain symbols, as people write them
VALUES = {M: 1.0, L: 1.0, G: 9.8, MU: ps.Parameter("mu", 1.4, "1", "friction", lower=0.0)}
START = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}


def rod_body(rates):
    """Return frame, origin, end and body of the rod with these rates of its coordinates."""
    N, O = ReferenceFrame("N"), Point("O")
    O.set_vel(N, 0)
    B = N.orientnew("B", "Axis", [THETA, N.z])
    A = O.locatenew("A", X * N.x + Y * N.y)
    centre = A.locatenew("G", L * B.x)
    A.set_vel(N, rates[0] * N.x + rates[1] * N.y)
    B.set_ang_vel(N, rates[2] * N.z)
    centre.v2pt_theory(A, N, B)
    body = RigidBody("rod", centre, B, M, (inertia(B, 0, 0, M * L**2 / 3), centre))
    body.potential_energy = M * G * (Y + L * sp.sin(THETA))
    return N, O, A, body


def lagrange_rod():
    N, O, A, body = rod_body(RATES)
    method = LagrangesMethod(Lagrangian(N, body), [X, Y, THETA])
    return ps.Mechanism.from_sympy(
        method, {"A": {"point": A, "friction": MU}}, VALUES, frame=N, origin=O, name="rod"
    )


def kane_rod(turned, **options):
    """Return the rod by Kane's equations, the speeds of its end along N or turned with it."""
    u = dynamicsymbols("u1:4")
    c, s = (sp.cos(THETA), sp.sin(THETA)) if turned else (1, 0)
    kinematic = [u[0] - c * X_DOT - s * Y_DOT, u[1] + s * X_DOT - c * Y_DOT, u[2] - THETA_DOT]
    N, O, A, body = rod_body((c * u[0] - s * u[1], s * u[0] + c * u[1], u[2]))
    kane = KanesMethod(N, q_ind=[X, Y, THETA], u_ind=list(u), kd_eqs=kinematic)
    kane.kanes_equations([body], [(body.masscenter, -M * G * N.y)])
    contacts = {"A": {"point": A, "friction": MU}}
    return ps.Mechanism.from_sympy(kane, contacts, VALUES, frame=N, origin=O, name="rod", **options)


@pytest.fixture(scope="module")
def own_run():
    return ps.simulate("rod", "bilinear-hertz", START, t_end=5e-3)


def test_the_rod_of_lagranges_method_is_our_own(own_run):
    rod, own = lagrange_rod(), ps.models.rod()
    assert rod.system.generalized_forces == {}
    for name in ("A", "B", "A_stick", "B_stick"):
        one, other = (getattr(m.coefficients, name) for m in (rod, own))
        one, other = (v() if callable(v) else v for v in (one, other))
        numbers = {"m": 2, "l": 3, "g": 9, "theta": 0.7, "theta_dot": 0.4, "mu": 0.8}
        values = [v.subs({s: numbers[str(s)] for s in v.free_symbols}) for v in (one, other)]
        assert float(values[0]) == pytest.approx(float(values[1]), rel=1e-13)
    run = ps.simulate(rod, "bilinear-hertz", START, t_end=5e-3)
    assert run.final == pytest.approx(own_run.final, rel=1e-11, abs=1e-14)
    assert run.energy_closes and rod.parameters == {"m": 1, "l": 1, "g": 9.8, "mu": 1.4}


@pytest.mark.parametrize("turned", [False, True])
def test_the_rod_of_kanes_method_is_our_own(own_run, turned):
    rod = kane_rod(turned)
    # The weight is a load.
    assert set(rod.system.generalized_forces) == {"y_A", "theta"}
    run = ps.simulate(rod, "bilinear-hertz", START, t_end=5e-3)
    kept = {k: v for k, v in own_run.final.items() if "dissipation" not in k}
    assert {k: run.final[k] for k in kept} == pytest.approx(kept, rel=1e-10, abs=1e-13)
    assert run.energy_closes


def test_a_given_potential_energy_takes_the_place_of_its_forces():
    rod = kane_rod(True, potential_energy=M * G * (Y + L * sp.sin(THETA)))
    assert rod.system.generalized_forces == {}
    assert lagrange_rod().coefficients.B == rod.coefficients.B


def test_a_cart_with_two_links_by_both_methods_is_one_mechanism():
    x, a, b = dynamicsymbols("x a b")
    u = dynamicsymbols("u1:4")
    mass, length, g, mu = sp.symbols("mass length g mu")
    values = {mass: 1.5, length: 0.4, g: 9.81, mu: 0.9}
    N, O = ReferenceFrame("N"), Point("O")
    O.set_vel(N, 0)

    def tip(rates):
        """Return particles of cart, elbow and tip."""
        A, B = N.orientnew("A", "Axis", [a, N.z]), N.orientnew("B", "Axis", [b, N.z])
        A.set_ang_vel(N, rates[1] * N.z)
        B.set_ang_vel(N, rates[2] * N.z)
        cart = O.locatenew("cart", x * N.x + length * N.y)
        cart.set_vel(N, rates[0] * N.x)
        elbow = cart.locatenew("elbow", length * A.x)
        elbow.v2pt_theory(cart, N, A)
        end = elbow.locatenew("end", length * B.x)
        end.v2pt_theory(elbow, N, B)
        return [Particle(p.name, p, mass) for p in (cart, elbow, end)], end

    particles, end = tip([q.diff(T) for q in (x, a, b)])
    for p in particles:
        p.potential_energy = mass * g * p.point.pos_from(O).dot(N.y)
    contacts = {"tip": {"point": end, "friction": mu}}
    options = {"frame": N, "origin": O}
    lagrange = ps.Mechanism.from_sympy(
        LagrangesMethod(Lagrangian(N, *particles), [x, a, b]), contacts, values, **options
    )
    particles, end = tip(u)
    kane = KanesMethod(
        N,
        q_ind=[x, a, b],
        u_ind=list(u),
        kd_eqs=[u[i] - q.diff(T) for i, q in enumerate((x, a, b))],
    )
    kane.kanes_equations(particles, [(p.point, -mass * g * N.y) for p in particles])
    other = ps.Mechanism.from_sympy(
        kane, {"tip": {"point": end, "friction": mu}}, values, **options
    )
    state = {"a": 0.3, "b": -0.8, "x_dot": 0.5, "a_dot": 0.2, "b_dot": -0.4}
    for quantity in ("W", "b"):
        numbers = []
        for mechanism in (lagrange, other, own_cart()):
            place = mechanism.at(state)
            own = [place.parameters[n] for n in mechanism.parameters]
            numbers.append(np.array(mechanism.casadi(quantity)([*place.state.values()], own)))
        np.testing.assert_allclose(numbers[1], numbers[0], rtol=1e-12)
        np.testing.assert_allclose(numbers[2], numbers[0], rtol=1e-12)


def own_cart():
    """Return the cart with two links in our own description."""
    x, a, b = (ps.Coordinate(n, n, u) for n, u in (("x", "m"), ("a", "rad"), ("b", "rad")))
    values = {"mass": 1.5, "length": 0.4, "g": 9.81, "mu": 0.9}
    known = [ps.Parameter(n, v, "1", n, 0.0, lower_closed=False) for n, v in values.items()]
    m, l, g, mu = (p.symbol for p in known)
    points = [(x.symbol, l)]
    for angle in (a.symbol, b.symbol):
        last_x, last_y = points[-1]
        points.append((last_x + l * sp.cos(angle), last_y + l * sp.sin(angle)))
    bodies = [ps.Body(m, point) for point in points]
    system = ps.LagrangianSystem.of_bodies("cart", (x, a, b), known, bodies, gravity=g)
    contact = ps.Contact.of_point("tip", system, points[-1], mu)
    return ps.Mechanism("cart", "cart with two links", "own", system, (contact,))


def test_a_pair_of_matrices_is_a_mechanism():
    x, y = dynamicsymbols("x y")
    k, c = sp.symbols("k c")
    M_h = sp.diag(2, 2), sp.Matrix([-k * x - c * x.diff(T), -2 * sp.Symbol("g")])
    block = ps.Mechanism.from_sympy(
        M_h,
        {"A": {"gap": y, "slip_velocity": x.diff(T), "friction": sp.Symbol("mu")}},
        {"k": 8.0, "c": 0.0, "g": 9.8, "mu": 0.0},
        coordinates=[x, y],
        units={"x": "m", "y": "m", "k": "N/m"},
    )
    run = ps.simulate(block, "rigid", {"x": 0.1}, t_end=1.0)
    # A pendulum of ω = 2 rad/s.
    assert run.final["x"] == pytest.approx(0.1 * float(sp.cos(2)), rel=1e-9)
    assert block.units["x_dot"] == "m/s" and run.energy_closes


def test_a_pivot_that_moves_as_prescribed_is_that_of_scipy():
    theta, (m, l, g, b, omega, mu) = dynamicsymbols("theta"), sp.symbols("m l g b omega mu")
    N, O = ReferenceFrame("N"), Point("O")
    O.set_vel(N, 0)
    pivot = O.locatenew("P", b * sp.sin(omega * T) * N.x + 2 * l * N.y)
    end = pivot.locatenew("Q", l * sp.sin(theta) * N.x - l * sp.cos(theta) * N.y)
    end.set_vel(N, end.pos_from(O).dt(N))
    mass = Particle("q", end, m)
    mass.potential_energy = m * g * end.pos_from(O).dot(N.y)
    pendulum = ps.Mechanism.from_sympy(
        LagrangesMethod(Lagrangian(N, mass), [theta]),
        {"A": {"point": end, "friction": mu}},
        {m: 1.5, l: 0.7, g: 9.81, b: 0.1, omega: 3.0, mu: 0.3},
        frame=N,
        origin=O,
    )
    run = ps.simulate(pendulum, "rigid", {"theta": 0.4}, t_end=0.8)

    def rates(t, y):
        return [y[1], (0.9 * np.sin(3 * t) * np.cos(y[0]) - 9.81 * np.sin(y[0])) / 0.7]

    (angle, rate) = solve_ivp(rates, (0, 0.8), [0.4, 0], rtol=1e-12, atol=1e-12).y[:, -1]
    assert run.final["theta"] == pytest.approx(angle, rel=1e-9)
    assert run.final["theta_dot"] == pytest.approx(rate, rel=1e-8)
    assert run.energy_closes


def test_a_contact_in_space_has_two_tangents():
    x, y, z = dynamicsymbols("x y z")
    m, g, mu = sp.symbols("m g mu")
    N, O = ReferenceFrame("N"), Point("O")
    P = O.locatenew("P", x * N.x + y * N.y + z * N.z)
    lagrangian = m * sum(q.diff(T) ** 2 for q in (x, y, z)) / 2 - m * g * z
    contacts = {"P": {"point": P, "normal": N.z, "friction": mu}}
    block = ps.Mechanism.from_sympy(
        LagrangesMethod(lagrangian, [x, y, z]),
        contacts,
        {m: 2.0, g: 9.8, mu: 0.5},
        frame=N,
        origin=O,
        in_space=True,
    )
    answer = ps.classify(block, {"x_dot": 3.0, "y_dot": 4.0})
    assert answer.solutions[0].force == pytest.approx([19.6, -5.88, -7.84])


def with_constraint():
    x, y = dynamicsymbols("x y")
    L = x.diff(T) ** 2 + y.diff(T) ** 2
    return LagrangesMethod(L, [x, y], hol_coneqs=[x - y]), [x, y]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"equations": with_constraint()[0]}, "the equations have constraints"),
        ({"equations": 3}, "need a LagrangesMethod, a KanesMethod, or a pair"),
        ({"parameters": {"m": 1.0}}, "g: no value"),
        ({"parameters": {"m": "1", "g": 9.8, "mu": 0}}, "parameter 'm': got '1', need a number"),
        (
            {"contacts": {"A": {"point": (0, dynamicsymbols("w")), "friction": sp.Symbol("mu")}}},
            r"point: w\(t\): no value",
        ),
        ({"contacts": {"A": {"point": (0, 1), "friction": "mu"}}}, "friction: got a text"),
        ({"contacts": {"A": {"friction": sp.Symbol("mu")}}}, "got friction, need some of point"),
    ],
)
def test_faulty_equations_are_one_sentence(change, message):
    x, y = dynamicsymbols("x y")
    m, g, mu = sp.symbols("m g mu")
    whole = {
        "equations": LagrangesMethod(m * (x.diff(T) ** 2 + y.diff(T) ** 2) / 2 - m * g * y, [x, y]),
        "contacts": {"A": {"point": (x, y), "friction": mu}},
        "parameters": {m: 1.0, g: 9.8, mu: 0.5},
    }
    with pytest.raises(ps.InputError, match=message):
        ps.Mechanism.from_sympy(**whole | change)


def test_a_pair_needs_a_symmetric_mass_matrix():
    x, y = dynamicsymbols("x y")
    pair = sp.Matrix([[2, sp.cos(x)], [0, 2]]), sp.zeros(2, 1)
    with pytest.raises(ps.InputError, match="M is not symmetric"):
        ps.Mechanism.from_sympy(pair, {}, {}, coordinates=[x, y])


def test_a_pair_needs_its_coordinates_and_their_number():
    x, y = dynamicsymbols("x y")
    pair = sp.eye(2), sp.zeros(3, 1)
    with pytest.raises(ps.InputError, match=r"got M of shape \(2, 2\) and h of shape \(3, 1\)"):
        ps.Mechanism.from_sympy(pair, {}, {}, coordinates=[x, y])
    with pytest.raises(ps.InputError, match="need a function of the time"):
        pair = sp.eye(2), sp.zeros(2, 1)
        ps.Mechanism.from_sympy(pair, {}, {}, coordinates=[sp.Symbol("x"), y])


QUICK = {"hertz", "rigid"}


@functools.cache
def both_rods():
    return lagrange_rod(), ps.models.rod()


@pytest.mark.parametrize(
    "law", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in sorted(LAWS)]
)
def test_one_motion_through_both_descriptions_under_every_law(law):
    """The rod falls onto the ground, sliding, and leaves it again."""
    start = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0, "y_A": 1e-4, "y_A_dot": -0.1}
    imported, own = (ps.simulate(rod, law, start, t_end=5e-3, rtol=1e-12) for rod in both_rods())
    assert [e.kind for e in imported.events] == [e.kind for e in own.events] != []
    times = [e.time for e in own.events]
    assert [e.time for e in imported.events] == pytest.approx(times, rel=1e-9)
    for name in both_rods()[1].state_names:
        size = max(own.size(name), 1e-3)
        assert imported.final[name] == pytest.approx(own.final[name], abs=1e-8 * size), name
    assert imported.energy_closes


def test_the_point_of_a_contact_may_be_that_of_a_body():
    q, h = dynamicsymbols("q h")
    N, O = ReferenceFrame("N"), Point("O")
    O.set_vel(N, 0)
    P = O.locatenew("P", q * N.x + h * N.y)
    P.set_vel(N, q.diff(T) * N.x + h.diff(T) * N.y)
    ball = Particle("ball", P, M)
    ball.potential_energy = M * G * h
    method = LagrangesMethod(Lagrangian(N, ball), [q, h])
    for body in (ball, P, RigidBody("body", P, N, M, (inertia(N, 1, 1, 1), P))):
        mechanism = ps.Mechanism.from_sympy(
            method, {"A": {"point": body, "friction": MU}}, {**VALUES, L: 1}, frame=N, origin=O
        )
        assert str(mechanism.contact.gap) == "h"
        assert str(mechanism.contact.slip_velocity) == "q_dot"


def test_a_model_of_pydy_is_our_own_mechanism():
    """The pendulum of two links on a cart that PyDy derives; its tip touches the ground."""
    models = pytest.importorskip("pydy.models", reason="needs the group test (pydy)")
    kane = models.n_link_pendulum_on_cart(2, cart_force=False, joint_torques=False).eom_method
    tip, frame = kane.bodies[-1], kane._inertial
    (origin,) = (p for p in kane.bodies[0].masscenter._pos_dict if p.name == "O")
    values = {"m0": 1.5, "m1": 0.8, "m2": 0.5, "l0": 0.4, "l1": 0.3, "g": 9.81, "mu": 0.6}
    contact = {"tip": {"point": tip, "friction": sp.Symbol("mu")}}
    ours = ps.Mechanism.from_sympy(kane, contact, values, frame=frame, origin=origin)

    x, a, b = (ps.Coordinate(n, n, u) for n, u in (("q0", "m"), ("q1", "rad"), ("q2", "rad")))
    known = [ps.Parameter(n, v, "1", n) for n, v in values.items()]
    m0, m1, m2, l0, l1, g, mu = (p.symbol for p in known)
    points = [(x.symbol, sp.Integer(0))]
    for length, angle in ((l0, a.symbol), (l1, b.symbol)):
        last_x, last_y = points[-1]
        points.append((last_x + length * sp.cos(angle), last_y + length * sp.sin(angle)))
    bodies = [ps.Body(m, point) for m, point in zip((m0, m1, m2), points, strict=True)]
    system = ps.LagrangianSystem.of_bodies("cart", (x, a, b), known, bodies, gravity=g)
    own = ps.Mechanism(
        "cart", "", "own", system, (ps.Contact.of_point("tip", system, points[-1], mu),)
    )
    state = {"q1": 0.3, "q2": -0.8, "q0_dot": 0.5, "q1_dot": 0.2, "q2_dot": -0.4}
    for quantity in ("W", "b", "M"):
        numbers = []
        for mechanism in (ours, own):
            place = mechanism.at(state)
            given = [place.parameters[n] for n in mechanism.parameters]
            numbers.append(np.array(mechanism.casadi(quantity)([*place.state.values()], given)))
        np.testing.assert_allclose(*numbers, rtol=1e-11, atol=1e-12)
