"""The gradient of the critical force, against bisections beside it."""

from __future__ import annotations

import pytest

from painleve_sym.errors import InputError
from painleve_sym.laws.compliance import law
from painleve_sym.mechanics.models import model
from painleve_sym.simulate.compliant import SoftenedSimulator
from painleve_sym.study.compare import separating_force
from painleve_sym.study.critical_force import critical_force_gradient

TABLE_4 = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
HARD = {"E": 20.9e14}
BRACKET = (150.0, 500.0)


@pytest.mark.parametrize("compressing", [False, True])
def test_gradient_of_the_critical_force_is_that_of_bisections(compressing):
    sim = SoftenedSimulator(model("rod"), law("bilinear-hertz", reload="virgin"))
    found = critical_force_gradient(
        sim, TABLE_4, ("theta", "mu"), bracket=BRACKET, parameters=HARD, compressing=compressing
    )
    expected = 346.99944 if compressing else 346.87847
    assert found.force == pytest.approx(expected, abs=1e-4)
    for k, (name, value) in enumerate((("theta", 1.0), ("mu", 1.4))):
        forces = []
        for sign in (1, -1):
            moved = value * (1 + sign * 1e-5)
            state = TABLE_4 | ({name: moved} if name == "theta" else {})
            given = HARD | ({name: moved} if name == "mu" else {})
            forces.append(
                separating_force(sim, state, given, BRACKET, compressing=compressing, rtol=1e-13)
            )
        difference = (forces[0] - forces[1]) / (2e-5 * value)
        assert found.gradient[k] == pytest.approx(difference, rel=1e-6)


def test_a_bracket_on_one_side_is_refused():
    sim = SoftenedSimulator(model("rod"), law("bilinear-hertz", reload="virgin"))
    with pytest.raises(InputError, match="bracket"):
        critical_force_gradient(sim, TABLE_4, ("mu",), bracket=(150.0, 200.0), parameters=HARD)
