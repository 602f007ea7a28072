"""Notices on contacts that are pressed deeper or harder than their law holds for."""

from __future__ import annotations

import math

import pytest

import painleve_sym as ps
from painleve_sym.mechanics.materials import material
from painleve_sym.motion.pressing import contact_surfaces
from painleve_sym.motion.trajectory import Trajectory

START = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}


def run_of(law, **options):
    return ps.simulate("rod", law, START, t_end=2.5e-3, **options)


def test_pressure_beyond_yield_is_told_where_the_material_is_known():
    run = run_of("hertz", material="steel")
    (notice,) = [n for n in run.notices if "pressure" in n]
    # Hertz's pressure of the largest force from the modulus, (6 F E*^2 / (pi^3 R^2))^(1/3).
    force = max(e.normal_force for e in run.events)
    modulus = 200e9 / (2 * (1 - 0.3**2))
    peak = (6 * force * modulus**2 / (math.pi**3 * 0.00645**2)) ** (1 / 3)
    assert f"reaches {peak:.2g} Pa, and steel yields from {1.6 * 250e6:.2g} Pa" in notice
    assert not [n for n in run_of("hertz").notices if "pressure" in n]
    # Its own curves have the yielding.
    assert not [n for n in run_of("bilinear-hertz", material="steel").notices if "pressure" in n]


@pytest.mark.parametrize(("radius", "deep"), [(0.00645, False), (1.9e-4, False), (1.5e-4, True)])
def test_a_depth_beyond_a_tenth_of_the_radius_is_told(radius, deep, tmp_path):
    # The stiffness stays that of the radius 6.45 mm.
    law_parameters = {"R": radius, "E": 2.09e11 * math.sqrt(0.00645 / radius)}
    run = run_of("hertz", law_parameters=law_parameters)
    depth = max(e.compression for e in run.events)
    assert depth == pytest.approx(1.75e-5, rel=0.02)
    assert [n.startswith("Contact A is pressed") for n in run.notices] == [True] * deep
    run.save(tmp_path / "run.npz")
    assert Trajectory.load(tmp_path / "run.npz").notices == run.notices


def test_surfaces_are_those_of_the_law_of_each_contact():
    bodies = ps.law("bilinear-hertz-two-bodies").with_parameters(kappa_1=100.0, kappa_2=25.0)
    values = {f"{p.name}_A": p.default for p in bodies.parameters} | {"k_B": 1.0, "c_B": 0.0}
    laws = (bodies, ps.law("linear"))
    own = (bodies.of_contact("A"), ps.law("linear").of_contact("B"))
    (surface,) = contact_surfaces(("A", "B"), laws, own, values)
    assert (surface.contact, surface.radius, surface.yield_strength) == ("A", 0.008, 0.0)
    steel, aluminium, wood = map(material, ("steel", "aluminium", "wood"))
    hertz = ps.law("hertz")
    given = {p.name: p.default for p in hertz.parameters}
    for pair, softest in (((steel, aluminium), "aluminium"), ((wood, steel), "steel")):
        (surface,) = contact_surfaces(("A",), (hertz,), (hertz,), given, pair)
        assert surface.material == softest
    (surface,) = contact_surfaces(("A",), (hertz,), (hertz,), given, (wood, wood))
    assert surface.material == ""


def test_the_size_of_a_quantity_is_that_of_its_motion():
    run = run_of("hertz")
    assert run.size("theta") == pytest.approx(1.0, abs=0.01)
    assert run.size("gap") == pytest.approx(max(e.compression for e in run.events), rel=1e-6)
    forces = [abs(f) for e in run.events for f in (e.normal_force, e.tangential_force)]
    assert run.size("normal_force") == run.size("tangential_force") == max(forces)
    rest = ps.simulate("block-two-feet", "rigid", t_end=1e-3)
    assert rest.size("gap", "B") == rest.size("gap_B") == pytest.approx(0.1)
