"""The command materials and the option --material."""

from __future__ import annotations

import pytest

from painleve_sym.mechanics.materials import materials
from painleve_sym.references import reference
from tests.cli.cli_helpers import LAW, TABLE_3, rejected, run, run_json

START = ("--state", TABLE_3)


def test_materials_are_listed_and_shown_alone_with_their_sources(capsys):
    data = run_json(capsys, "materials")
    assert [m["name"] for m in data["materials"]] == list(materials())
    (steel,) = run_json(capsys, "materials", "steel")["materials"]
    assert steel["properties"]["density"]["value"] == 7860.0
    assert {"HallidayEtAl"} <= {r["key"] for r in steel["references"]}
    _, out, _ = run(capsys, "materials", "wood")
    assert "sliding_friction with steel" in out
    assert reference("LustFormulaBank").link in out


def test_options_set_what_the_material_provides_and_given_numbers_win(capsys):
    data = run_json(capsys, "simulate", "rod", *START, *LAW, "--material", "aluminium",
                    "--law-set", "nu=0.25", "--t-end", "1e-3")  # fmt: skip
    assert data["parameters"]["E"] == 70e9
    assert data["parameters"]["nu"] == 0.25
    command = ("jump", "rod", *START, *LAW)
    by_name = run_json(capsys, *command, "--material", "steel")
    by_number = run_json(capsys, *command, "--law-set", "E=200e9,nu=0.3")
    (notice,) = by_name.pop("notices")
    assert "rod is not rigid in this impact" in notice and by_number.pop("notices") == []
    assert by_name == by_number


@pytest.mark.slow
def test_material_of_a_scenario_and_of_a_map(capsys, tmp_path):
    file = tmp_path / "case.toml"
    file.write_text('model = "rod-bending:0,1"\nmaterial = "wood"\nparameters = { Y = 1e10 }\n')
    _, out, _ = run(capsys, "classify", file)
    assert "material wood" in out
    assert "rho = 525 kg/m^3, Y = 1e+10 Pa" in " ".join(out.split())
    data = run_json(capsys, "map", "rod-bending:0,1", "--over", "theta,rho", "--points", "5",
                    "--material", "chalk")  # fmt: skip
    assert data["parameters"]["Y"] == 8.6e9


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (("materials", "stel"), "unknown material 'stel'. Did you mean 'steel'?"),
        (("simulate", "rod", *LAW, "--material", "steel,wood", "--t-end", "1"), "of two bodies"),
        (("classify", "rod-inertia", "--material", "steel"), "nothing here depends on a material."),
        (("map", "block", "--over", "mu,m", "--material", "wood"), "map: material wood: nothing"),
        (
            (
                "simulate",
                "rod",
                *LAW,
                "--law-set",
                "n=1.764",
                "--material",
                "steel",
                "--t-end",
                "1",
            ),
            "by Hertz's theory, with n = 1.5 alone. Fix: leave n out",
        ),
        (
            ("jump", "rod", *START, *LAW, "--law-set", "n=1.764", "--material", "steel"),
            "got material steel with n = 1.764",
        ),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(capsys, command, message):
    assert message in rejected(capsys, *command)
