"""The data file of a paper: printed digits, formulas as text, the bibliographic record."""

import tomllib
from pathlib import Path

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from painleve_sym.errors import InputError
from painleve_sym.papers.claims import Printed, read_claims
from painleve_sym.papers.formula import expression
from painleve_sym.papers.impact_resolution.claims import CLAIMS, COLUMNS, TABLES
from painleve_sym.papers.impact_resolution.formulas import derived_forms
from painleve_sym.papers.impact_resolution.runs import Workbench
from painleve_sym.papers.item import Verdict
from painleve_sym.papers.registry import known_papers
from painleve_sym.references import reference

ROOT = Path(__file__).parents[2]


@given(st.floats(-1e6, 1e6), st.integers(0, 6))
def test_printed_number_matches_what_rounds_to_it(value, digits):
    text = f"{value:.{digits}f}"
    assert Printed(text).matches(value)
    assert not Printed(text).matches(float(text) + 1.01 * 10.0**-digits)


@pytest.mark.parametrize(
    ("text", "tolerance"), [("1.5434", 5e-5), ("150", 0.5), ("-1.7628e-7", 5e-12), ("4e-4", 5e-5)]
)
def test_printed_tolerance_is_half_the_last_digit(text, tolerance):
    assert Printed(text).tolerance == pytest.approx(tolerance)


def test_printed_tolerance_can_be_given():
    assert Printed("0.75e-3", 1e-4).matches(0.00084)
    assert not Printed("0.75e-3", 1e-4).matches(0.00086)


def test_every_formula_of_the_claims_is_an_expression_in_known_letters():
    names = derived_forms(Workbench()).names
    names |= {n: sp.Symbol(n, real=True) for n in ("E_n1", "E_n2")}
    for name, formula in CLAIMS.formulas.items():
        assert formula.expression or formula.fault, name
        assert not (formula.misprint and formula.differs), name
        if formula.expression:
            assert CLAIMS.expression(name, names).free_symbols <= set().union(
                *(sp.sympify(n).free_symbols for n in names.values())
            )
        assert bool(formula.fault) == bool(formula.corrected) == bool(formula.holds)


@pytest.mark.parametrize(
    "text", ["__import__('os').getcwd()", "x.real", "unknown*2", "[x for x in y]", "x; y", ""]
)
def test_formula_text_is_parsed_and_never_executed(text):
    with pytest.raises(InputError, match="formula"):
        expression(text, {"x": sp.Symbol("x")})


def test_letter_stands_for_the_formula_that_defines_it():
    names = derived_forms(Workbench()).names
    a, b = (CLAIMS.expression(name, names) for name in ("eq-2", "eq-3"))
    assert CLAIMS.expression("eq-1", names) == a * names["F_n"] + b


def test_row_of_table_2_is_its_state_without_the_first_column():
    table = TABLES[2]
    state = dict.fromkeys(COLUMNS[:6], 0.0) | dict(table.state)
    state |= {"A": table.A.value, "B": table.B.value}
    assert [float(word) for word in table.row.split()] == [state[name] for name in COLUMNS[1:]]


def test_items_that_are_not_reproduced_have_a_reason():
    for name, item in CLAIMS.items.items():
        assert item.expected is not Verdict.FAILED
        assert item.expected is Verdict.REPRODUCED or item.reason, name


def test_paper_is_an_entry_of_the_bibliography(tmp_path):
    assert CLAIMS.source is reference("ImpactModelResolution")
    path = tmp_path / "claims.toml"
    path.write_text('source = "ImpactModelResolutions"\n', encoding="utf-8")
    with pytest.raises(InputError, match="Did you mean 'ImpactModelResolution'"):
        read_claims(path)


@pytest.mark.parametrize("entry", ['paper = "x"', 'group = "g"\ntitle = "t"\nverdict = "differs"'])
def test_claims_with_a_missing_or_unknown_key_are_refused(tmp_path, entry):
    path = tmp_path / "claims.toml"
    path.write_text(f'source = "Newton1687"\n[items.a]\n{entry}\n', encoding="utf-8")
    with pytest.raises(TypeError):
        read_claims(path)


def test_claims_are_installed_with_the_package():
    with (ROOT / "pyproject.toml").open("rb") as file:
        data = tomllib.load(file)["tool"]["setuptools"]["package-data"]
    installed = {
        path
        for package, patterns in data.items()
        for pattern in patterns
        for path in (ROOT / package.replace(".", "/")).glob(pattern)
    }
    assert {paper.folder / "claims.toml" for paper in known_papers().values()} <= installed
