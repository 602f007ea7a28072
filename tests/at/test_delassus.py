"""The numbers of contacts at states, against CasADi's own and against a mass matrix by hand."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import pytest

from painleve_sym.at.delassus import ContactNumbers, Delassus, MotionNumbers
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import ModelError
from painleve_sym.mechanics.outline import MechanismOutline

NAMES = ["rod", "block-two-feet", "painleve-klein"]


def values_of(mechanism, seed=0, points=()):
    """Return coordinates, velocities and parameters by name, in the domain of the mechanism."""
    draw = np.random.default_rng(seed)
    start = mechanism.at(mechanism.start).values
    moved = {n: start[n] + draw.uniform(0.05, 0.2, points) for n in mechanism.state_names}
    return start | (moved if points else {n: float(v) for n, v in moved.items()})


def by_casadi(mechanism, values):
    """Return W, b, J, D and the free accelerations from energies and gaps, by differentiation."""
    from painleve_sym.codegen.bridge import Translator

    system = mechanism.system
    q, u = (ca.SX.sym(name, len(system.q)) for name in "qu")
    table = {s: q[i] for i, s in enumerate(system.q)}
    table |= {s: u[i] for i, s in enumerate(system.q_dot)}
    table |= {p.symbol: ca.SX(values[p.name]) for p in system.parameters}
    translate = Translator(table, floor=0.0)
    T, V = translate(system.kinetic_energy), translate(system.potential_energy)
    momenta = ca.gradient(T, u)
    M = ca.jacobian(momenta, u)
    force = ca.gradient(T - V, q) - ca.jtimes(momenta, q, u)
    force += ca.vertcat(*[translate(system.generalized_forces.get(s.name, 0)) for s in system.q])
    rates = ca.vertcat(
        *[translate(v) for c in mechanism.contacts for v in (c.gap_rate, c.slip_velocity)]
    )
    J = ca.jacobian(rates, u)
    free = ca.solve(M, force)
    D = ca.solve(M, J.T)
    results = [J @ D, J @ free + ca.jtimes(rates, q, u), J, D, free, T]
    point = [[values[s.name] for s in group] for group in (system.q, system.q_dot)]
    return [np.array(v) for v in ca.Function("numbers", [q, u], results)(*point)]


@pytest.mark.parametrize("name", NAMES)
def test_numbers_are_those_of_energies_and_gaps(name):
    mechanism = model(name)
    values = values_of(mechanism)
    of = Delassus.of(mechanism)
    contacts, motion = of.whole_at(values)
    W, b, J, D, free, T = by_casadi(mechanism, values)
    close = {"rtol": 1e-11, "atol": 1e-11}
    np.testing.assert_allclose(contacts.W, W, **close)
    np.testing.assert_allclose(contacts.b, b.ravel(), **close)
    np.testing.assert_allclose(motion.J, J, **close)
    np.testing.assert_allclose(motion.D, D, **close)
    np.testing.assert_allclose(motion.free, free.ravel(), **close)
    np.testing.assert_allclose(motion.kinetic_energy, T.ravel(), **close)
    velocities = [values[n] for n in mechanism.outline.velocity_names]
    np.testing.assert_allclose(contacts.v, J @ velocities, **close)


@pytest.mark.parametrize("name", NAMES)
def test_numbers_at_an_array_of_states_have_the_bits_of_each(name):
    mechanism = model(name)
    of, values = Delassus.of(mechanism), values_of(mechanism, 1, (4, 3))
    contacts, moves = of.whole_at_each(values)
    every = [*contacts, *moves]
    for place in np.ndindex(4, 3):
        one = {n: float(v[place]) if np.ndim(v) else v for n, v in values.items()}
        for whole, own in zip(every, [*of.at(one), *of.whole_at(one)[1]], strict=True):
            assert whole[(..., *place)].tobytes() == np.asarray(own).tobytes()


def test_numbers_of_single_numbers_have_no_further_axes():
    mechanism = model("block-two-feet")
    values = values_of(mechanism)
    of = Delassus.of(mechanism)
    one, alone = of.at_each(values), of.at(values)
    for name in set(ContactNumbers._fields) - {"margins"}:
        np.testing.assert_array_equal(getattr(one, name), getattr(alone, name), strict=True)


def test_mobility_is_symmetric_to_the_last_bit():
    W = Delassus.of(model("block-two-feet")).at(values_of(model("block-two-feet"))).W
    np.testing.assert_array_equal(W, W.T)


# ---- a mechanism without SymPy ----


@dataclass(frozen=True)
class RodByHand:
    """The rod as CasADi functions: mass M, force f of M a = f + Jᵀ F, gap and Jacobian by hand."""

    outline: MechanismOutline
    definition = "rod by hand"
    n_tangents = 1

    @property
    def n_margins(self):
        return len(self.outline.domain)

    def _parts(self):
        x = ca.SX.sym("x", len(self.outline.argument_names))
        at = dict(zip(self.outline.argument_names, ca.vertsplit(x), strict=True))
        m, l, g, spin = (at[name] for name in ("m", "l", "g", "theta_dot"))
        c, s = m * l * ca.cos(at["theta"]), m * l * ca.sin(at["theta"])
        M = ca.vertcat(
            ca.horzcat(m, 0, -s), ca.horzcat(0, m, c), ca.horzcat(-s, c, m * l**2 * 4 / 3)
        )
        force = ca.vertcat(c * spin**2, s * spin**2 - m * g, -g * c)
        u = ca.vertcat(*(at[name] for name in self.outline.velocity_names))
        J = ca.SX(ca.DM([[0, 1, 0], [1, 0, 0]]))
        return x, at, u, M, J, ca.solve(M, J.T), ca.solve(M, force)

    def contact_function(self):
        x, at, u, _, J, D, free = self._parts()
        W, b, v = J @ D, J @ free, J @ u
        A_stick, B_stick = W[0, 0] - W[0, 1] ** 2 / W[1, 1], b[0] - W[0, 1] / W[1, 1] * b[1]
        near = [1e-12 * at["l"], 1e-12 * ca.sqrt(at["g"] * at["l"])]
        rows = [at["y_A"], v, A_stick, B_stick, *near, ca.vec(W.T), b]
        margins = [at["theta"], np.pi - at["theta"]]
        return ca.Function("contacts", [x], [ca.densify(ca.vertcat(*rows, *margins))])

    def motion_function(self):
        x, _, u, M, J, D, free = self._parts()
        rows = [ca.vec(J.T), ca.vec(D.T), free, ca.SX.zeros(2), u.T @ M @ u / 2]
        return ca.Function("motion", [x], [ca.densify(ca.vertcat(*rows))])


def test_mechanism_of_casadi_functions_has_the_same_numbers():
    rod = model("rod")
    values = values_of(rod, 2)
    of, by_hand = Delassus.of(rod), Delassus(RodByHand(rod.outline))
    own, other = of.at(values), by_hand.at(values)
    for name in ("gap", "v", "A_stick", "B_stick", "W", "b", "mu"):
        np.testing.assert_allclose(getattr(other, name), getattr(own, name), rtol=1e-12, atol=1e-14)
    for moved, given in zip(by_hand.whole_at(values)[1], of.whole_at(values)[1], strict=True):
        np.testing.assert_allclose(moved, given, rtol=1e-12, atol=1e-14)
    drawn = values_of(rod, 3, (5,))
    np.testing.assert_allclose(
        by_hand.at_each(drawn).W, of.at_each(drawn).W, rtol=1e-12, atol=1e-14
    )


def test_function_with_other_numbers_than_contacts_need_is_rejected():
    class Short(RodByHand):
        definition = "a short rod"

        def contact_function(self):
            x = ca.SX.sym("x", len(self.outline.argument_names))
            return ca.Function("contacts", [x], [x[:3]])

    rod = model("rod")
    with pytest.raises(ModelError, match="of 10 arguments to 3 numbers"):
        Delassus(Short(rod.outline)).at(values_of(rod))


def test_layouts_have_the_shapes_of_the_contacts():
    feet = model("block-two-feet")
    of = Delassus.of(feet)
    shapes = dict(zip(ContactNumbers._fields, map(np.shape, of.at(values_of(feet))), strict=True))
    assert shapes["W"] == (4, 4) and shapes["b"] == (4,) and shapes["gap"] == (2,)
    sizes = map(np.shape, of.whole_at(values_of(feet))[1])
    moved = dict(zip(MotionNumbers._fields, sizes, strict=True))
    assert moved["J"] == (4, 3) and moved["D"] == (3, 4) and moved["free"] == (3,)
