"""Friction laws by their formulas; tests of motions are in tests/motion/test_friction_laws.py."""

from __future__ import annotations

import pytest
import sympy as sp

from painleve_sym.laws.friction import FrictionLaw


@pytest.mark.parametrize(("velocity", "part"), [(0, 1), (1, 2), (-1, 2), (3, 10)])
def test_friction_above_mu_falls_to_its_half_at_the_velocity_of_stribeck(velocity, part):
    """1 + (r_s − 1)/(1 + (v_t/v_s)²), with v_t in parts of v_s."""
    law = FrictionLaw.named("stribeck")
    ratio, v_s = (p.symbol for p in law.parameters)
    above = law.kinetic_ratio(velocity * v_s) - 1
    assert sp.simplify(above - (ratio - 1) / part) == 0


@pytest.mark.parametrize("name", ["coulomb", "static", "spring"])
def test_friction_of_other_laws_does_not_depend_on_the_velocity(name):
    assert FrictionLaw.named(name).kinetic_ratio(sp.Symbol("v")) == 1
