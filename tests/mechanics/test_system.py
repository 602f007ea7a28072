"""Lagrangian systems: equations of motion, and every fault of a definition."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, ModelError
from painleve_sym.mechanics.declarations import Coordinate, Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import MODELS
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.mechanics.system import LagrangianSystem
from tests.mechanics.made_up import MADE_UP, skew_block, two_link_arm
from tests.support.vanishing import vanishes

ALL = {**MODELS, **MADE_UP}


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(
            n, marks=pytest.mark.slow if n in ("rod-bending", "block", "two-link-arm") else ()
        )
        for n in sorted(ALL)
    ],
)
def mechanism(request):
    return ALL[request.param]()


def _lagranges_method(mechanism: Mechanism) -> tuple[sp.Matrix, sp.Matrix]:
    """Return mass matrix and forcing by SymPy's own formulation."""
    system = mechanism.system
    paths = [dynamicsymbols(c.name) for c in system.coordinates]
    time = dynamicsymbols._t
    forward = dict(zip(system.q, paths, strict=True))
    forward |= {v: p.diff(time) for v, p in zip(system.q_dot, paths, strict=True)}
    frame = sp.physics.mechanics.ReferenceFrame("N")
    points, loads = [], []
    for c, p in zip(system.coordinates, paths, strict=True):
        # A force on a point with velocity q̇ has the generalized force it is itself.
        point = sp.physics.mechanics.Point(c.name)
        point.set_vel(frame, p.diff(time) * frame.x)
        force = sp.sympify(system.generalized_forces.get(c.name, 0)).subs(forward)
        loads.append((point, force * frame.x))
        points.append(point)
    lagrangian = (system.kinetic_energy - system.potential_energy).subs(forward)
    method = LagrangesMethod(lagrangian, paths, forcelist=loads, frame=frame)
    method.form_lagranges_equations()
    back = {p.diff(time): v for v, p in zip(system.q_dot, paths, strict=True)}
    back |= dict(zip(paths, system.q, strict=True))
    return method.mass_matrix.subs(back), method.forcing.subs(back)


def _random_values(mechanism: Mechanism, rng: np.random.Generator) -> dict[sp.Symbol, float]:
    system = mechanism.system
    values = {s: float(rng.uniform(-2, 2)) for s in (*system.q, *system.q_dot)}
    for p in system.parameters:
        low = 0.3 if p.lower == 0 else -1.5
        values[p.symbol] = float(rng.uniform(low, 2.5))
    return values


def test_system_equations_agree_with_lagranges_method(mechanism):
    mass, forcing = _lagranges_method(mechanism)
    rng = np.random.default_rng(0)
    ours = (mechanism.system.mass_matrix, mechanism.system.bias_force)
    draws = [_random_values(mechanism, rng) for _ in range(3)]
    numbers = sp.lambdify(list(draws[0]), [ours, (mass, forcing)])
    for values in draws:
        for left, right in zip(*numbers(*values.values()), strict=True):
            np.testing.assert_allclose(left, right, rtol=1e-12, atol=1e-12)


def test_system_inverse_mass_matrix_is_the_inverse(mechanism):
    values = _random_values(mechanism, np.random.default_rng(1))
    mass = np.array(mechanism.system.mass_matrix.subs(values), dtype=float)
    inverse = np.array(mechanism.system.inverse_mass_matrix.subs(values), dtype=float)
    np.testing.assert_allclose(inverse @ mass, np.eye(len(mass)), atol=1e-11)


@pytest.mark.parametrize("name", sorted(ALL))
def test_system_mass_matrix_is_symmetric_positive_definite(name):
    system = ALL[name]().system
    arguments = (*system.q, *(p.symbol for p in system.parameters))
    mass = sp.lambdify(arguments, system.mass_matrix, modules="numpy")
    ranges = [st.floats(-6.0, 6.0)] * len(system.q)
    ranges += [
        st.floats(0.05, 5.0) if p.lower == 0 and not p.lower_closed else st.floats(0.0, 3.0)
        for p in system.parameters
    ]

    @settings(max_examples=60)
    @given(st.tuples(*ranges))
    def check(values):
        matrix = np.array(mass(*values), dtype=float)
        assert np.array_equal(matrix, matrix.T)
        assert np.all(np.linalg.eigvalsh(matrix) > 0)

    check()


def test_system_of_the_rod_reads_as_in_a_book():
    system = rod().system
    names = [str(entry) for entry in system.mass_matrix]
    assert names[0] == "m"
    assert names[2] == "-l*m*sin(theta)"
    assert names[8] == "4*l**2*m/3"
    assert str(two_link_arm().system.mass_matrix[0, 1]) == "l_1*l_2*m_2*cos(alpha - beta)"


def test_system_energy_is_conserved_without_generalized_forces():
    system = rod().system
    q_dot, free = sp.Matrix(system.q_dot), system.free_acceleration
    energy = system.kinetic_energy + system.potential_energy
    power = sum(sp.diff(energy, q) * v for q, v in zip(system.q, q_dot, strict=True))
    power += sum(sp.diff(energy, v) * a for v, a in zip(q_dot, free, strict=True))
    assert vanishes(power)
    assert system.dissipated_power == 0


def test_system_dissipated_power_of_joint_friction_is_nonnegative():
    system = two_link_arm().system
    k, rate = sp.Symbol("k", nonnegative=True), sp.Symbol("alpha_dot", real=True)
    assert system.dissipated_power == k * rate**2


def test_model_entries_have_meaning_unit_and_source(mechanism):
    for entry in (*mechanism.system.coordinates, *mechanism.system.parameters):
        assert entry.meaning and entry.unit, entry.name
    assert mechanism.title and mechanism.source


def test_model_defaults_are_valid(mechanism):
    assert [p.fault(p.default) for p in mechanism.system.parameters] == [None] * len(
        mechanism.system.parameters
    )


def test_model_unknown_name_suggests_the_nearest():
    with pytest.raises(InputError, match="Did you mean 'rod'"):
        model("rods")


def test_model_state_names_are_coordinates_then_velocities():
    assert rod().state_names == ("x_A", "y_A", "theta", "x_A_dot", "y_A_dot", "theta_dot")


X = Coordinate("x", "place", "m")
M = Parameter("m", 1.0, "kg", "mass", 0.0, lower_closed=False)
KINETIC = M.symbol * X.rate**2 / 2


def test_system_faults_are_reported_together():
    stray = sp.Symbol("theat")
    with pytest.raises(ModelError) as caught:
        LagrangianSystem(
            "bad",
            (X, Coordinate("m", "twice", "m")),
            (M,),
            KINETIC + stray,
            X.rate * X.symbol,
            {"z": M.symbol},
        )
    text = str(caught.value)
    assert "mechanism 'bad'" in text
    assert "name 'm' is declared twice" in text
    assert "kinetic energy: unknown symbol 'theat'" in text
    assert "unknown coordinate of a generalized force 'z'" in text
    assert "potential energy depends on a velocity" in text
    assert len(caught.value.faults) == 4


def test_system_rejects_a_kinetic_energy_that_is_not_quadratic():
    with pytest.raises(ModelError, match="not quadratic"):
        LagrangianSystem("bad", (X,), (M,), KINETIC * X.rate, sp.Integer(0))


def test_system_rejects_a_singular_mass_matrix():
    y = Coordinate("y", "height", "m")
    with pytest.raises(ModelError, match=r"singular.*Fix: give every coordinate"):
        LagrangianSystem("bad", (X, y), (M,), M.symbol * (X.rate + y.rate) ** 2, sp.Integer(0))


def test_system_whose_energy_is_nowhere_finite_is_rejected():
    hidden = sp.sin(X.symbol) ** 2 + sp.cos(X.symbol) ** 2 - 1
    with pytest.raises(ModelError, match=r"potential energy: not finite: .* is 0 everywhere"):
        LagrangianSystem("bad", (X,), (M,), KINETIC, sp.log(hidden))


@pytest.mark.parametrize(
    ("parameter", "positive", "nonnegative"),
    [
        (M, True, True),
        (Parameter("mu", 1.0, "1", "friction", 0.0), None, True),
        (Parameter("c", 1.0, "1", "anything"), None, None),
    ],
)
def test_parameter_symbol_knows_its_sign(parameter, positive, nonnegative):
    assert parameter.symbol.is_positive is positive
    assert parameter.symbol.is_nonnegative is nonnegative


@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
def test_parameter_fault_names_value_and_range(value):
    fault = M.fault(value)
    assert fault is not None
    assert "parameter m (mass)" in fault
    assert "need a finite number with 0 < m" in fault


def test_parameter_range_text_has_both_ends():
    e = Parameter("e", 0.5, "1", "restitution", 0.0, 1.0)
    assert e.range_text == "a finite number with 0 <= e <= 1"
    assert e.fault(0.0) is None and e.fault(1.0) is None and e.fault(1.1) is not None
    assert Parameter("c", 1.0, "1", "anything").range_text == "a finite number"


def test_mechanism_without_contact_is_rejected():
    system = skew_block().system
    with pytest.raises(ModelError, match="no contact"):
        Mechanism("bare", "nothing touches", "a test", system, ())


def test_mechanism_with_two_contacts_has_no_only_contact():
    block = skew_block()
    twice = Mechanism("two", "two contacts", "a test", block.system, block.contacts * 2)
    with pytest.raises(InputError, match="got 2 contacts, need one"):
        _ = twice.contact
