"""Materials: the data and its page, what they set in mechanisms and laws, bad input."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

import painleve_sym as ps
from painleve_sym.errors import InputError, ModelError
from painleve_sym.laws.catalogue import COMPLIANT_LAWS, law
from painleve_sym.mechanics.materials import (
    PAIR_PROPERTIES,
    PROPERTIES,
    material,
    material_values,
    materials,
    two_materials,
)
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.references import references
from painleve_sym.study.scenario import Scenario
from painleve_sym.study.sweeps.sweep import Sweep
from tests.support.paper_law import paper_law
from tools import materials as tool
from tools.tables import written

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "materials.md").read_text("utf-8")
TEXTS = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted((ROOT / "docs").rglob("*.ipynb")),
    *sorted(p for p in (ROOT / "examples").rglob("*") if p.suffix in {".py", ".toml"}),
]
"""What users read."""


def _values(one):
    pairs = [getattr(pair, name) for pair in one.pairs for name in PAIR_PROPERTIES]
    return [*one.properties.values(), *(v for v in pairs if v is not None)]


# ---- the data ----


@pytest.mark.parametrize("one", materials().values(), ids=materials())
def test_every_number_has_its_sources_and_lies_in_its_range(one):
    assert set(one.properties) <= set(PROPERTIES)
    for value in _values(one):
        assert value.lower <= value.value <= value.upper
        assert value.sources and set(value.sources) <= set(references())
    assert -1 < one.poisson_ratio <= 0.5


def test_a_pair_of_materials_is_the_same_from_both_sides():
    for one in materials().values():
        for pair in one.pairs:
            if pair.other in materials():
                (back,) = [p for p in material(pair.other).pairs if p.other == one.name]
                assert replace(back, other=pair.other) == pair


def test_moduli_of_chalk_are_those_of_its_bulk_and_shear_modulus():
    bulk, shear = 9e9, 3.2e9
    young = 9 * bulk * shear / (3 * bulk + shear)
    ratio = (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear))
    assert math.isclose(material("chalk").young_modulus, young, rel_tol=0.005)
    assert math.isclose(material("chalk").poisson_ratio, ratio, rel_tol=0.005)


def test_page_has_the_numbers_of_the_data():
    assert written(PAGE, tool.tables()) == PAGE, "Fix: run python -m tools.materials."
    rows = [[c.strip() for c in row.strip("|").split("|")] for row in re.findall(r"\|.*\|", PAGE)]
    assert ["steel", "Young's modulus", "200 (200 to 207) GPa", "1, 2"] in rows
    for one in materials().values():
        assert len([row for row in rows if row[0] == one.name]) == len(one.properties)
        for pair in one.pairs:
            named = {f"{one.name}, {pair.other}", f"{pair.other}, {one.name}"}
            given = [n for n in PAIR_PROPERTIES if getattr(pair, n) is not None]
            assert len([row for row in rows if row[0] in named]) == len(given)
        sources = {key for value in _values(one) for key in value.sources}
        assert all(f"references.md#{key.lower()}" in PAGE for key in sources)


def test_metals_and_wood_rest_on_handbooks():
    """Of what is not a table on the web without author or year."""
    handbooks = {"HallidayEtAl", "CallisterEtAl", "GereEtAl", "ForestProductsLaboratory2010"}
    for name in ("steel", "aluminium", "wood"):
        for value in material(name).properties.values():
            assert handbooks & set(value.sources)


# ---- what they set ----


@pytest.mark.parametrize("name", [n for n in COMPLIANT_LAWS if n != "linear"])
def test_laws_of_one_modulus_and_of_two_take_what_materials_provide(name):
    chosen = law(name)
    values = material_values(name, two_materials("steel"), chosen.parameters)
    expected = {"E": 200e9, "nu": 0.3}
    if name.endswith("two-bodies"):
        expected = {f"{key}_{i}": value for key, value in expected.items() for i in (1, 2)}
        mixed = material_values(name, two_materials("steel,rubber"), chosen.parameters)
        assert mixed == expected | {"E_2": 2.76e6, "nu_2": 0.48}
    else:
        with pytest.raises(InputError, match="got steel and rubber, but parameter E is that of"):
            material_values(name, two_materials("steel,rubber"), chosen.parameters)
    assert values == expected


def test_elastic_rod_takes_density_and_modulus_and_the_law_of_a_contact_takes_its_own():
    simulator = ps.Simulator(ps.model("rod-bending:1,0"), {"A": ps.law("hertz")})
    assert simulator.values_of_materials("wood", {"E": 1.0}) == {
        "rho": 525.0,
        "Y": 13e9,
        "nu": 0.29,
    }
    laws = law("A=hertz,B=bilinear-hertz-two-bodies").parameters
    values = material_values("laws", two_materials("steel"), laws)
    assert values == {"E_A": 2e11, "nu_A": 0.3, "E_1_B": 2e11, "nu_1_B": 0.3, "E_2_B": 2e11,
                      "nu_2_B": 0.3}  # fmt: skip


def test_given_values_win_and_the_run_is_the_one_with_these_numbers():
    start = {"theta": 1.0, "x_A_dot": -1.0, "theta_dot": 1.0}
    by_name = ps.simulate("rod", "hertz", start, t_end=1e-3, material="steel",
                          law_parameters={"nu": 0.2})  # fmt: skip
    by_number = ps.simulate(
        "rod", "hertz", start, t_end=1e-3, law_parameters={"E": 2e11, "nu": 0.2}
    )
    assert by_name.parameters == by_number.parameters
    assert by_name.final == by_number.final


def test_parameter_of_a_file_stands_for_a_property():
    text = """\
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
rho = { default = 1000.0, unit = "kg/m^3", positive = true, material = "density" }
g = { default = 9.8, unit = "m/s^2" }
mu = { default = 0.5, unit = "1" }
[[bodies]]
mass = "rho*0.001"
centre = ["x", "y"]
[[contacts]]
name = "A"
friction = "mu"
point = ["x", "y"]
"""
    declared = mechanism_from_text(text).outline.parameters
    assert material_values("file", two_materials("chalk"), declared) == {"rho": 2100.0}
    for old, new, fault in (
        (
            '"density"',
            '"densty"',
            "unknown property of a material 'densty'. Did you mean 'density'",
        ),
        ('"density"', '"young_modulus"', "unit is 'kg/m^3', need 'Pa' of the young_modulus."),
    ):
        with pytest.raises(ModelError, match=re.escape(fault)):
            mechanism_from_text(text.replace(old, new))


def _simulated(**given):
    ps.simulate("rod", ps.laws.hertz(), {"theta": 1.0}, t_end=1e-4, material="steel", **given)


@pytest.mark.parametrize(
    "ask",
    [
        lambda: _simulated(law_parameters={"n": 1.764}),
        lambda: ps.simulate(
            "rod", paper_law(), {"theta": 1.0}, t_end=1e-4, material="steel"
        ),
        lambda: ps.Simulator("rod", paper_law(bodies=2)).values_of_materials("steel,rubber"),
        lambda: ps.Simulator("rod", "hunt-crossley").values_of_materials("chalk", {"n": 1.764}),
        lambda: Scenario(
            "rod", law="bilinear-hertz", law_parameters={"n": 1.764}, material="wood"
        ).from_material(),
        lambda: Scenario("rod", law="hertz", material="wood").from_material(["n"]),
    ],
)  # fmt: skip
def test_a_material_goes_with_the_exponent_of_hertz_alone(ask):
    with pytest.raises(InputError, match=r"got material .* with n = .* Hertz's theory, with n = 1"):
        ask()


def test_hertz_s_exponent_goes_with_a_material_also_where_it_is_given():
    _simulated(law_parameters={"n": 1.5})
    assert {p.name: p.default for p in ps.law("bilinear-hertz").parameters}["n"] == 1.5


def test_the_exponent_of_the_paper_stands_beside_the_word():
    """n = 1.764 is the paper's alone: wherever it stands, the lines around say so."""
    count = 0
    for path in TEXTS:
        lines = path.read_text("utf-8").splitlines()
        for i, line in enumerate(lines):
            if "1.764" in line and "1.7646e-10" not in line:
                count += 1
                around = "\n".join(lines[max(0, i - 12) : i + 12]).lower()
                assert "paper" in around, (path.name, line)
    assert count > 10


def test_sweep_over_a_property_keeps_the_values_of_its_axis():
    text = """\
model = "rod"
t_end = 1e-3
material = "aluminium"
state = { theta = 1.0, theta_dot = 1.0, x_A_dot = -1.0 }
law = { name = "hertz" }
[axes]
E = [1e9, 2e9]
"""
    assert Sweep.from_text(text, "here").scenario.law_parameters == {"nu": 0.33}


# ---- bad input ----


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"material": "stel"}, "unknown material 'stel'. Did you mean 'steel'"),
        ({"material": "steel,wood,chalk"}, "got 3 materials, need one of both bodies"),
        ({"material": "steel", "law": None}, "nothing here depends on a material. Fix: leave it"),
        ({"material": "steel", "law": "linear"}, "nothing here depends on a material."),
        ({"material": "steel,wood"}, "name one material, or a law of two bodies"),
    ],
)
def test_materials_that_cannot_be_are_refused(given, message):
    with pytest.raises(InputError, match=re.escape(message)):
        Scenario(**{"model": "rod-inertia", "law": "hertz", **given}).from_material()


def test_property_that_a_material_lacks_is_named_with_who_needs_it():
    steel = material("steel")
    bare = replace(steel, properties={"density": steel.properties["density"]})
    with pytest.raises(InputError, match="'steel': young_modulus is missing, which parameter E of"):
        material_values("law 'hertz'", two_materials(bare), law("hertz").parameters)
    given = {"E": 1e9, "nu": 0.3}
    assert material_values("law", two_materials(bare), law("hertz").parameters, given) == {}
