"""One classification for every mechanism: one contact, a guide, several, both kinds together."""

from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.codegen.quantities import Quantities
from painleve_sym.contacts.classify import contact_problem
from painleve_sym.contacts.problem import ContactCase
from painleve_sym.mechanics.models import model
from painleve_sym.mechanics.toml.mechanism_file import load_mechanism

LADDER = Path(__file__).parents[2] / "examples" / "mechanisms" / "ladder.toml"
ONE = {"mechanism", "state", "parameters", "A", "B", "A_stick", "B_stick", "case", "solutions"}
MANY = {"contacts", "open", "kinds", "slip_velocities", "W", "b", "promise", "case", "solutions"}
GUIDE = {"bilateral", "slip", "A_push", "A_pull", "B", "A_stick", "B_stick", "excess"}


def test_friction_of_any_size_has_its_solution():
    # One solution for every friction: the rod at rest slips left, F_t = mu F_n.
    rod = model("rod")
    for power in range(-12, 0):
        mu = 10.0**power
        found = ps.classify(rod, {"theta": 1.0}, {"mu": mu})
        (solution,) = found.solutions
        assert found.case is ContactCase.SLIP
        assert solution.tangential_force == mu * solution.normal_force
        assert solution.normal_force == -found.B / found.A


@pytest.mark.parametrize(
    ("name", "state", "keys"),
    [
        ("rod", {"theta": 1.0}, ONE | {"chatter"}),
        ("painleve-klein", {"phi": 1.2, "x_dot": 1.0}, (ONE - {"A"}) | GUIDE | MANY),
        ("block-two-feet", {}, (ONE & {"mechanism", "state", "parameters"}) | MANY),
        ("ladder", {}, (ONE & {"mechanism", "state", "parameters"}) | MANY),
    ],
)
def test_classify_takes_every_mechanism(name, state, keys):
    mechanism = load_mechanism(LADDER) if name == "ladder" else model(name)
    found = ps.classify(mechanism, state or mechanism.start)
    assert set(found.to_dict()) == keys
    assert all(s.residual < 1e-12 for s in found.solutions)


def test_contact_numbers_are_evaluated_once(monkeypatch):
    calls, evaluate = [], Quantities.__call__

    def counted(self, values):
        calls.append(self.names)
        return evaluate(self, values)

    monkeypatch.setattr(Quantities, "__call__", counted)
    ps.classify(model("rod"), {"theta": 1.0})
    assert len([names for names in calls if "W_nn" in names]) == 1


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


def table(kinds=(False, False, False), h=0.5):
    """A block of mass m on three feet at x - a, x, x + a, some of which are guides."""
    raise NotImplementedError
