"""`painleve jump --law`: the jump at finite stiffness as text and JSON, and wrong input."""

import json
import math

import pytest

from painleve_sym.cli import main

CASE = ["jump", "rod", "--state", "theta=1,theta_dot=1,x_A_dot=-1"]
HERTZ = [*CASE, "--law", "bilinear-hertz", "--law-set", "E=20.9e14,n=1.764"]
KEYS = {
    *("law", "configuration", "method", "stiffness", "exponent", "initial_compression"),
    *("largest_compression", "duration", "end", "phases", "final"),
}


def test_jump_with_a_law_prints_both_rules(capsys):
    assert main(HERTZ) == 0
    text = capsys.readouterr().out
    assert "at finite stiffness" in text
    assert "0.065561" in text
    assert "0.0524701" in text
    assert "by integration" in text


def test_jump_json_has_the_documented_keys(capsys):
    assert main([*HERTZ, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    jump = data["corrected"]
    assert set(jump) == KEYS
    assert jump["end"] == "separation"
    assert [p["name"] for p in jump["phases"]] == [
        "slip compression",
        "sticking compression",
        "sticking restitution",
        "reverse slip restitution",
    ]
    assert jump["final"]["velocity"]["y_A_dot"] == pytest.approx(0.0656115, rel=1e-3)
    assert data["final"]["velocity"]["y_A_dot"] == pytest.approx(0.0524701, rel=1e-5)


def test_jump_with_a_law_refuses_a_mobility_of_rank_one(capsys):
    """Of one coordinate A' = 0; rounding used to decide between an error and wrong velocities."""
    case = ["jump", "strut", "--state", "theta=1.3,theta_dot=3", "--law", "bilinear-hertz"]
    height = f"h={math.sin(1.3)!r},mu=0.3"
    assert main([*case, "--set", height]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "its W has rank one" in err and "simulate" in err
    assert main([*case[:4], "--set", height]) == 0


def test_jump_without_a_law_has_no_corrected_part(capsys):
    assert main([*CASE, "--json"]) == 0
    assert "corrected" not in json.loads(capsys.readouterr().out)


def test_restitution_belongs_to_rule_and_law(capsys):
    results = []
    for extra in (["--restitution", "0.5"], ["--law-set", "e_energetic=0.5"]):
        assert main([*HERTZ, *extra, "--json"]) == 0
        data = json.loads(capsys.readouterr().out)
        results.append((data["final"]["velocity"], data["corrected"]["final"]["velocity"]))
    assert results[0] == results[1]


def test_initial_force_and_carried_configuration_are_taken(capsys):
    options = ["--initial-force", "100", "--configuration", "carried", "--json"]
    assert main([*HERTZ, *options]) == 0
    data = json.loads(capsys.readouterr().out)["corrected"]
    assert data["configuration"] == "carried"
    assert data["initial_compression"] > 0


@pytest.mark.parametrize(
    ("extra", "text"),
    [
        (["--configuration", "moved"], "need one of frozen, carried"),
        (["--initial-force", "-3"], "initial force: got -3.0"),
        (["--law-set", "c=1"], "unknown parameter 'c'"),
    ],
)
def test_wrong_input_is_named(capsys, extra, text):
    assert main([*HERTZ, *extra]) == 2
    assert text in capsys.readouterr().err


@pytest.mark.parametrize("extra", [["--configuration", "carried"], ["--initial-force", "10"]])
def test_options_of_a_law_without_one_are_named(capsys, extra):
    assert main([*CASE, *extra]) == 2
    assert "need a compliant contact" in capsys.readouterr().err
