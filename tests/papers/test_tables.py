"""The printed numbers, kept here apart from the package: computed values must print the same."""

import csv
from decimal import Decimal
from pathlib import Path

import pytest

from painleve_sym.contacts.classify import classify
from painleve_sym.laws.catalogue import law
from painleve_sym.mechanics.models import rod
from painleve_sym.papers.impact_resolution.claims import INITIAL_FORCES, TABLES
from painleve_sym.papers.registry import reproduce
from painleve_sym.simulate.compliant import SoftenedSimulator

DATA = Path(__file__).parent / "data"


def rows(name):
    with (DATA / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def half_last_digit(text):
    return 0.5 * 10.0 ** Decimal(text).as_tuple().exponent


def prints_as(value, text, tolerance=""):
    # An edge of the last digit rounds either way: a millionth of it decides nothing.
    width = float(tolerance) if tolerance else half_last_digit(text)
    return value == pytest.approx(float(text), rel=0, abs=width * (1 + 1e-6))


STATES = {row.pop("table"): {k: float(v) for k, v in row.items()} for row in rows("states.csv")}
COEFFICIENTS = rows("tables.csv")
FORCES = rows("initial_forces.csv")


@pytest.fixture(scope="module")
def mechanism():
    return rod()


@pytest.fixture(scope="module")
def simulator(mechanism):
    return SoftenedSimulator(mechanism, law("bilinear-hertz", reload="virgin"))


def computed(mechanism, row):
    return getattr(classify(mechanism, STATES[row["table"]]), row["quantity"])


@pytest.mark.parametrize("row", COEFFICIENTS, ids=lambda r: f"table-{r['table']}-{r['quantity']}")
def test_coefficients_print_as_in_the_tables(mechanism, row):
    assert prints_as(computed(mechanism, row), row["holds"] or row["printed"])


def test_coefficient_of_table_3_does_not_print_as_the_paper_has_it(mechanism):
    row = next(r for r in COEFFICIENTS if r["holds"])
    assert not prints_as(computed(mechanism, row), row["printed"])


@pytest.mark.parametrize("row", FORCES, ids=lambda r: f"{r['force']} N")
def test_initial_force_follows_from_the_printed_height(simulator, row):
    parameters = simulator.parameters({"E": float(row["modulus"])})
    depth = simulator.compression_of_force(float(row["force"]), parameters)
    assert prints_as(-depth, row["height"])
    # F ~ depth^n: the force that the printed height carries.
    force = float(row["force"]) * (-float(row["height"]) / depth) ** parameters["n"]
    assert prints_as(force, row["force"], row["tolerance"])


@pytest.mark.parametrize("row", FORCES, ids=lambda r: f"{r['force']} N")
def test_initial_force_contradicts_the_formula_printed_for_the_radius(simulator, row):
    radius = simulator.parameters()["R"] / 2
    parameters = simulator.parameters({"E": float(row["modulus"]), "R": radius})
    depth = simulator.compression_of_force(float(row["force"]), parameters)
    assert not prints_as(-depth, row["height"])


@pytest.mark.parametrize("row", rows("text_numbers.csv"), ids=lambda r: r["item"])
def test_numbers_in_the_text_print_as_in_the_paper(row):
    data = reproduce([row["item"]]).items[0].data
    value = data["solutions"][0] if row["key"] == "solution" else data[row["key"]]
    assert prints_as(value, row["printed"], row["tolerance"])


def test_claims_of_the_package_are_the_printed_ones():
    for row in COEFFICIENTS:
        table = TABLES[int(row["table"])]
        assert getattr(table, row["quantity"]).text == row["printed"]
        assert (table.corrected_A.text if table.corrected_A else "") == (
            row["holds"] if row["quantity"] == "A" else ""
        ) or row["quantity"] == "B"
    for number, table in TABLES.items():
        zeros = dict.fromkeys(STATES[str(number)], 0.0)
        assert zeros | dict(table.state) == STATES[str(number)]
    for row, claim in zip(FORCES, INITIAL_FORCES, strict=True):
        assert (claim.force.text, claim.height.text) == (row["force"], row["height"])
        assert (claim.table, claim.modulus) == (int(row["table"]), float(row["modulus"]))
