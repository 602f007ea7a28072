"""models, laws, automaton, derive and reproduce."""

from __future__ import annotations

import json
import math
import re
import runpy

import numpy as np
import pytest

from painleve_sym.at.cases import classify
from painleve_sym.at.jump import evaluate_jump
from painleve_sym.automata.derivation import ContactDerivation
from painleve_sym.cli.output import number, print_json, show_table
from painleve_sym.cli.texts import meanings
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.laws.catalogue import CHOICES, LAWS, all_choices, law
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.formulas.formula import wrap_expression
from painleve_sym.mechanics.materials import materials
from painleve_sym.mechanics.models import NAMED
from painleve_sym.papers import registry as study
from painleve_sym.papers.impact_resolution import items
from tests.cli.cli_helpers import rejected, run, run_json


def test_models_lists_names_coordinates_parameters_units_and_source(capsys):
    data = run_json(capsys, "models")["models"]
    assert [m["name"] for m in data] == list(NAMED)
    rod = next(m for m in data if m["name"] == "rod")
    assert [c["name"] for c in rod["coordinates"]] == ["x_A", "y_A", "theta"]
    parameters = {p["name"]: p for p in rod["parameters"]}
    assert parameters["g"]["default"] == 9.8 and parameters["g"]["unit"] == "m/s^2"
    assert parameters["mu"]["upper"] is None
    assert rod["source"] and rod["sketch"]
    assert [work["key"] for work in rod["references"]] == ["ImpactModelResolution"]
    assert rod["references"][0]["text"].startswith("Impact model resolution")
    code, out, err = run(capsys, "models", "rod")
    assert (code, err) == (0, "")
    assert "theta_dot" in out and "friction coefficient" in out


@pytest.mark.parametrize(
    ("command", "names"),
    [("models", NAMED), ("laws", [*LAWS, *RESTITUTIONS]), ("materials", materials())],
)
def test_a_list_has_a_line_for_each_name_with_its_sentence(capsys, command, names):
    code, out, err = run(capsys, command)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    first = {line.split()[0]: line.split(maxsplit=1)[1] for line in lines if line[:3].strip()[:1]}
    shown = [line.split()[0] for line in lines if line.startswith("  ") and line[2] != " "]
    assert shown == list(names)
    assert len(lines) < 2 * len(names) + 8 and all(len(line) <= 80 for line in lines)
    title = data_of(capsys, command)[0]["title"]
    assert " ".join(title.split()[:3]) in first[shown[0]]
    assert f"`painleve {command} NAME` shows one" in lines[-1]


def data_of(capsys, command):
    return next(iter(run_json(capsys, command).values()))


def test_help_explains_words_of_laws_and_events(capsys):
    for command in ("simulate", "jump", "sweep", "automaton", "explore"):
        _, out, _ = run(capsys, command, "--help")
        flat = " ".join(out.split())
        assert all(f"{word} {meaning}" in flat for word, meaning in meanings().items())
        assert all(len(line) <= 80 for line in out.split("words:")[1].splitlines())
    _, out, _ = run(capsys, "classify", "--help")
    assert "words:" not in out
    _, out, _ = run(capsys, "laws", "rigid")
    assert "policy (what a rigid contact does where" in out


def test_laws_lists_every_law_with_choices_that_work(capsys):
    data = run_json(capsys, "laws")
    assert [one["name"] for one in data["laws"]] == list(LAWS)
    assert [r["name"] for r in data["restitution_rules"]] == list(RESTITUTIONS)
    linear = next(one for one in data["laws"] if one["name"] == "linear")
    (work,) = linear["references"]
    assert work["link"] == "https://doi.org/10.1098/rspa.2016.0773"
    assert all(one["references"] for one in (*data["laws"], *data["restitution_rules"]))
    for one in data["laws"]:
        for name, choice in one["choices"].items():
            assert choice["default"] in choice["values"]
            for value in choice["values"]:
                # Friction opposes the final slip by Newton's law alone.
                others = {"restitution": "newton"} if value == "final_slip" else {}
                chosen = law(one["name"], **{name: value}, **others)
                assert all_choices(chosen)[name] == value
    with pytest.raises(InputError) as error:
        law("bilinear-hertz", reload="other")
    assert all(value in str(error.value) for value in CHOICES["reload"])
    code, out, err = run(capsys, "laws")
    assert (code, err) == (0, "")
    assert all(len(line) <= 80 for line in out.splitlines())


@pytest.mark.parametrize(
    ("form", "start"), [("text", "rod with"), ("mermaid", "stateDiagram-v2"), ("graphviz", "dig")]
)
def test_automaton_formats(capsys, form, start):
    options = ("--law", "bilinear-hertz", "--law-set", "reload=virgin", "--format", form)
    code, out, err = run(capsys, "automaton", "rod", *options)
    assert (code, err) == (0, "")
    assert out.startswith(start)
    assert "slip_stop" in out


def test_automaton_json_targets_are_modes(capsys):
    code, out, _ = run(capsys, "automaton", "rod", "--law", "hertz", "--format", "json")
    data = json.loads(out)
    assert run_json(capsys, "automaton", "rod", "--law", "hertz") == data
    names = {m["name"] for m in data["modes"]} | {"end"}
    assert code == 0
    assert {t for m in data["modes"] for x in m["transitions"] for t in x["targets"]} <= names


def test_automaton_is_derived_once_for_each_law(capsys, monkeypatch):
    first = [run(capsys, "automaton", "rod", "--law", name)[1] for name in ("hertz", "rigid")]
    monkeypatch.setattr(ContactDerivation, "automaton", property(lambda self: pytest.fail()))
    again = [run(capsys, "automaton", "rod", "--law", name)[1] for name in ("hertz", "rigid")]
    assert again == first and first[0] != first[1]


# ---- derive ----


@pytest.fixture(scope="module")
def forms(request):
    """Every format once: the closed forms take seconds to find."""
    from painleve_sym.cli import formula_pages

    formulas = formula_pages.closed_forms(model("rod"))
    patch = pytest.MonkeyPatch()
    patch.setattr(formula_pages, "closed_forms", lambda _: formulas)
    request.addfinalizer(patch.undo)


NAMES = ("T", "V", "M", "h", "A_neg", "A_pos", "B", "F_t_stick", "A_stick", "B_stick")
PHASES = ("tangential_neg", "tangential_pos", "sticking_compression", "sticking_restitution")


def test_derive_text_is_complete_and_fits_the_terminal(capsys, forms):
    code, out, err = run(capsys, "derive", "rod")
    assert (code, err) == (0, "")
    for name in (*NAMES, *PHASES, "mu_critical", "rebound_energetic"):
        assert f"  {name}" in out
    assert "= 4/3" in out
    assert all(len(line) <= 80 for line in out.splitlines())


def test_derive_latex_has_balanced_braces(capsys, forms):
    code, out, err = run(capsys, "derive", "rod", "--format", "latex")
    assert (code, err) == (0, "")
    assert out.count("\\[") == out.count("\\]") > 30
    for line in out.splitlines():
        assert line.count("{") == line.count("}"), line
    assert "\\dot{x}_A" in out


def test_derive_json_has_text_latex_and_python(capsys, forms):
    code, out, _ = run(capsys, "derive", "rod", "--format", "json")
    data = json.loads(out)
    assert code == 0
    assert set(NAMES) <= set(data["formulas"])
    assert set(PHASES) == set(data["jump"])
    for entry in data["formulas"].values():
        assert {"text", "latex", "python", "unit", "meaning"} <= set(entry)
    values = {"math": math, "g": 9.8, "l": 1.0, "theta": 1.0, "theta_dot": 5.0}
    computed = eval(data["formulas"]["B"]["python"], values)
    assert computed == pytest.approx(11.2368, abs=0.5e-4)


@pytest.fixture
def module(capsys, forms, tmp_path):
    code, out, err = run(capsys, "derive", "rod", "--format", "python")
    assert (code, err) == (0, "")
    assert all(len(line) <= 100 for line in out.splitlines())
    path = tmp_path / "rod_forms.py"
    path.write_text(out, "utf-8")
    return runpy.run_path(str(path))


def test_derive_python_gives_the_coefficients_of_the_package(module):
    state = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
    classification = classify(model("rod"), state)
    assert module["A_neg"](theta=1.0, m=1.0, mu=1.4) == pytest.approx(classification.A, rel=1e-14)
    assert module["B"](theta=1.0, theta_dot=5.0, l=1.0, g=9.8) == pytest.approx(
        classification.B, rel=1e-14
    )
    assert module["A_stick"](theta=1.0, m=1.0) == pytest.approx(classification.A_stick, rel=1e-14)
    assert module["mu_critical_min_theta"]() == 4 / 3
    assert module["M"](theta=1.0, m=2.0, l=3.0)[2][2] == pytest.approx(24.0)
    for name in NAMES:
        assert callable(module[name])


@pytest.mark.parametrize(
    "state",
    [
        {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0},
        {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": 0.2, "y_A_dot": -3.0},
    ],
)
def test_derive_python_jump_equals_the_package(module, state):
    velocities = {"x_A_dot": 0.0, "y_A_dot": 0.0, "theta_dot": 0.0, **state}
    jump = evaluate_jump(model("rod"), "energetic", velocities, parameters={"e_energetic": 0.6})
    phases = module["jump"](m=1.0, l=1.0, mu=1.4, e_energetic=0.6, **velocities)
    for phase, expected in zip(phases, jump.phases, strict=True):
        assert phase["normal_impulse"] == pytest.approx(expected.normal_impulse, rel=1e-12)
        assert phase["stored_energy"] == pytest.approx(expected.stored_energy, rel=1e-12)
        for name, value in expected.velocity.items():
            assert phase[name] == pytest.approx(value, rel=1e-12, abs=1e-12)


# ---- reproduce ----


def test_reproduce_list_names_every_item(capsys):
    code, out, err = run(capsys, "reproduce", "--list")
    assert (code, err) == (0, "")
    names = [name for _, name in study.selected()]
    assert [line.split()[0] for line in out.splitlines()[1:]] == names
    data = run_json(capsys, "reproduce", "--list")
    assert [item["id"] for item in data["items"]] == names
    assert set(data["items"][0]) == {"id", "group", "title", "paper_name"}


def test_reproduce_one_paper_by_its_name(capsys):
    code, out, _ = run(capsys, "reproduce", "impact-resolution", "--only", "eq-2", "--json")
    assert (code, json.loads(out)["papers"]) == (0, ["impact-resolution"])
    assert "Did you mean 'impact-resolution'" in rejected(capsys, "reproduce", "impact-resolutoin")


def test_reproduce_with_an_item_that_raises_exits_with_1_and_keeps_its_json(capsys, monkeypatch):
    def fail(bench):
        raise RuntimeError("no such rod")

    monkeypatch.setitem(items.COMPUTE, "eq-2", fail)
    code, out, _ = run(capsys, "reproduce", "--only", "eq-2,eq-3", "--json")
    data = json.loads(out)
    assert code == 1
    assert [item["verdict"] for item in data["items"]] == ["failed", "reproduced"]
    assert data["items"][0]["reason"] == "RuntimeError: no such rod"


def test_reproduce_one_item_reports_its_verdict(capsys):
    code, out, err = run(capsys, "reproduce", "--only", "eq-2", "--json")
    data = json.loads(out)
    assert code == 0
    assert [item["id"] for item in data["items"]] == ["eq-2"]
    assert err == ""
    code, out, _ = run(capsys, "reproduce", "--only", "eq-2")
    assert code == 0
    assert "eq-2" in out


def test_reproduce_exit_code_is_1_when_a_verdict_is_not_the_expected_one(capsys, monkeypatch):
    monkeypatch.setattr(study.Reproduction, "ok", property(lambda _: False))
    assert run(capsys, "reproduce", "--only", "eq-2", "--json")[0] == 1


def test_reproduce_writes_a_report(capsys, tmp_path):
    code, _, err = run(capsys, "reproduce", "--only", "eq-2", "--out", tmp_path / "a" / "b")
    assert code == 0
    assert "report written to" in err
    assert any((tmp_path / "a" / "b").iterdir())


# ---- printing ----


def test_json_replaces_what_json_cannot_hold(capsys):
    print_json({"a": math.nan, "b": [1.0, -math.inf], "c": {"d": 0.1}})
    data = json.loads(capsys.readouterr().out)
    assert data["a"] is None and data["b"] == [1.0, None] and data["c"] == {"d": 0.1}
    assert data["not_finite"] == {"a": "nan", "b[1]": "-inf"}


@pytest.mark.parametrize("value", [0.1, 1 / 3, 5e-324, 1.7976931348623157e308])
def test_json_keeps_every_bit(capsys, value):
    print_json({"value": value})
    assert repr(json.loads(capsys.readouterr().out)["value"]) == repr(value)


def test_zero_has_no_sign_in_json(capsys):
    print_json({"a": -0.0, "b": [[1.0, -0.0], {"c": np.array([-0.0, -2.0])}]})
    out = capsys.readouterr().out
    assert "-0.0" not in out
    assert json.loads(out) == {"a": 0.0, "b": [[1.0, 0.0], {"c": [0.0, -2.0]}]}


@pytest.mark.parametrize(
    "command",
    [
        ("classify", "rod-3d"),
        ("jump", "brick", "--state", "z_C_dot=-1"),
        ("map", "rod", "--over", "theta,mu", "--range", "theta=-0.0:1", "--points", "6"),
    ],
)
@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
def test_no_command_prints_a_negative_zero(capsys, tmp_path, command):
    out = run(capsys, *command, "--json")[1]
    assert out and not re.search(r"-0\.0\b(?!\d)", out)
    if command[0] == "map":
        file = tmp_path / "map.json"
        run(capsys, *command, "--out", str(file))
        assert not re.search(r"-0\.0\b(?!\d)", file.read_text())


def test_table_aligns_columns_and_wraps_the_last(capsys):
    show_table(("a", "b"), [("x", "word " * 30), ("yy", "short")], left=(0, 1))
    lines = capsys.readouterr().out.splitlines()
    assert all(len(line) <= 80 for line in lines)
    assert lines[-1] == "  yy  short"


def test_long_formula_is_broken_where_it_can_be():
    lines = wrap_expression("f = ", "(aaa + bbb)*ccc + (ddd - eee)*fff", 24, "    ")
    assert lines == ["f = (aaa + bbb)*ccc", "    + (ddd - eee)*fff"]
    assert wrap_expression("", "x" * 50, 20) == ["x" * 50]


def test_numbers_of_rounding_are_zero_beside_their_size():
    assert number(-6.1e-21) == "-6.1e-21" and number(-0.0) == "0"
    assert number(-6.1e-21, size=1e-4) == "0" and number(2e-17, size=1e-4) == "2e-17"
