"""One classification for every mechanism: one contact, a guide, several, both kinds together."""

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.at.cases import contact_problem
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.codegen.quantities import Quantities
from painleve_sym.errors import InputError
from painleve_sym.problem import NormalCoefficients
from painleve_sym.problem.solution import ContactCase
from tests.scenes import LADDER, standing_body

KEYS = {"mechanism", "state", "parameters", "contacts", "open", "W", "b"}
KEYS |= {"complete", "guarantee", "case", "borders", "solutions"}
KEYS |= {"promise", "chatter"}
OF_CONTACT = {"kind", "slip_velocity", *NormalCoefficients._fields}


def test_friction_of_any_size_has_its_solution():
    # One solution for every friction: the rod at rest slips left, F_t = mu F_n.
    rod = model("rod")
    for power in range(-12, 0):
        mu = 10.0**power
        classification = ps.classify(rod, {"theta": 1.0}, parameters={"mu": mu})
        (solution,) = classification.solutions
        assert classification.case is ContactCase.SLIP
        assert solution.tangential_force == mu * solution.normal_force
        assert solution.normal_force == -classification.B / classification.A


@pytest.mark.parametrize(
    ("name", "state"),
    [
        ("rod", {"theta": 1.0}),
        ("painleve-klein", {"phi": 1.2, "x_dot": 1.0}),
        ("block-two-feet", {}),
        ("ladder", {}),
        ("rod-3d", {"theta": 1.0}),
    ],
)
def test_classify_takes_every_mechanism(name, state):
    mechanism = model(name)
    classification = ps.classify(mechanism, state or mechanism.start)
    data = classification.to_dict()
    assert set(data) == KEYS
    assert all(set(numbers) == OF_CONTACT for numbers in data["contacts"].values())
    assert all(set(s["contacts"]) == set(data["contacts"]) for s in data["solutions"])
    assert all(s.residual < 1e-12 for s in classification.solutions)


def test_classify_away_from_the_wall_has_the_rows_of_the_floor():
    # A slender bar of mass m held by one end, by hand: the wall has no part in it.
    theta, m, g = 0.9, 5.0, 9.8
    ladder = model(LADDER)
    classification = ps.classify(ladder, {"x": 2.0, "theta": theta, "x_dot": -1.0})
    c, s = np.cos(theta), np.sin(theta)
    mobility = np.array([[1 + 3 * c**2, 3 * s * c], [3 * s * c, 1 + 3 * s**2]]) / m
    assert classification.contacts == ("floor",) and classification.open == ("wall",)
    np.testing.assert_allclose(classification.problem.W, mobility, rtol=1e-14)
    np.testing.assert_allclose(classification.problem.b, [-g, 0.0], atol=1e-14)


def test_contact_numbers_are_evaluated_once(monkeypatch):
    calls, evaluate = [], Quantities.of_vector

    def counted(self, values):
        calls.append(self.names)
        return evaluate(self, values)

    monkeypatch.setattr(Quantities, "of_vector", counted)
    for name in ("rod", "block-two-feet"):
        calls.clear()
        ps.classify(model(name), model(name).start)
        (names,) = calls
        assert "W_0_0" in names and "margin_0" in names


def test_numbers_of_all_contacts_are_those_of_each_and_their_coupling():
    feet, state = model("block-two-feet"), {"x_A": 0.0, "y_A": 0.0, "theta": 0.0}
    state |= {f"{name}_dot": 0.0 for name in state}
    values = {p.name: p.default for p in feet.system.parameters}
    both = contact_problem(feet, state, values)
    for i, name in enumerate(("A", "B")):
        alone = contact_problem(feet.only(name), state, values)
        rows = slice(2 * i, 2 * i + 2)
        assert np.array_equal(both.W[rows, rows], alone.W)
        assert np.array_equal(both.b[rows], alone.b)
    # One body: its four contact rows have rank three.
    assert np.linalg.matrix_rank(both.W, tol=1e-12) == 3


# ---- three contacts, and both kinds together ----


def table(places=(-1, 0, 1), held=()):
    """Return a table on feet at `places` times a of its middle, those at `held` in guides."""
    feet = {f"foot{i}": (f"{p}*a", "-h") for i, p in enumerate(places)}
    held = {f"foot{i}": "bilateral = true" for i, p in enumerate(places) if p in held}
    return standing_body(feet, contacts=held, J=0.5, a=0.5, h=0.4)


@pytest.mark.slow
def test_three_feet_that_slide_carry_the_weight_in_many_ways():
    classification = ps.classify(table(), {"x_dot": 1.0})
    assert classification.case is ContactCase.HYPERSTATIC
    for s in classification.solutions:
        assert s.normal_forces.sum() == pytest.approx(2 * 9.8)
        # Moments about the centre: a (F_2 - F_0) = mu h m g.
        assert 0.5 * (s.normal_forces[2] - s.normal_forces[0]) == pytest.approx(0.3 * 0.4 * 19.6)


@pytest.mark.slow
def test_foot_in_a_guide_pulls_where_a_free_one_lifts_off():
    free, held = (ps.classify(table((1, 2), guides), {"x_dot": 1.0}) for guides in ((), (2,)))
    (tips,), (pulls,) = free.solutions, held.solutions
    assert [m.value for m in tips.modes] == ["slip_pos", "liftoff"]
    # By hand: N_1 - P = m g and a N_1 - 2 a P = mu h (N_1 + P), P = -N_2.
    expected = np.linalg.solve([[1.0, -1.0], [0.5 - 0.12, -1.0 - 0.12]], [19.6, 0.0])
    assert pulls.normal_forces == pytest.approx([expected[0], -expected[1]])
    assert pulls.tangential_forces == pytest.approx(-0.3 * expected)
    contacts = held.to_dict()["contacts"].values()
    assert [c["kind"] for c in contacts] == ["unilateral", "bilateral"]


@pytest.mark.parametrize("mu", [1.2, 1.3])
def test_guide_jams_where_friction_passes_the_tipping_limit(mu):
    # By hand: a pulling rear foot asks for a (N_1 - N_0) = mu h (N_1 - N_0), so mu h = a.
    values = {"mu": mu, "J": 5.0}
    assert len(ps.classify(table((-1, 1)), {"x_dot": 1.0}, parameters=values).solutions) == 1
    held = ps.classify(table((-1, 1), (-1,)), {"x_dot": 1.0}, parameters=values)
    assert held.case is (ContactCase.INCONSISTENT if mu * 0.4 > 0.5 else ContactCase.UNIQUE)


def test_faults_of_all_contacts_are_named_at_once():
    words = "'foot0' approaches with 0.5 m/s.*'foot1' approaches with 0.5 m/s"
    with pytest.raises(InputError, match=words):
        ps.classify(table((-1, 0)), {"y_dot": -0.5})
    with pytest.raises(InputError, match="bilateral contact 'foot0' holds its point"):
        ps.classify(table((-1, 0), (-1,)), {"theta": 0.1})
