"""The printed numbers of the claims against the package: computed values must print the same."""

import pytest

from painleve_sym.contacts.classify import classify
from painleve_sym.laws.compliance import law
from painleve_sym.mechanics.models import rod
from painleve_sym.papers.impact_resolution.claims import COLUMNS, INITIAL_FORCES, NUMBERS, TABLES
from painleve_sym.papers.registry import reproduce
from painleve_sym.simulate.compliant import SoftenedSimulator


@pytest.fixture(scope="module")
def mechanism():
    return rod()


@pytest.fixture(scope="module")
def simulator(mechanism):
    return SoftenedSimulator(mechanism, law("bilinear-hertz", reload="virgin"))


@pytest.mark.parametrize("number", TABLES)
def test_coefficients_print_as_in_the_tables(mechanism, number):
    table, rigid = TABLES[number], classify(mechanism, TABLES[number].state)
    assert (table.corrected_A or table.A).matches(rigid.A)
    assert table.B.matches(rigid.B)
    assert len(table.A.text.lstrip("-")) == len("0.0337")


def test_coefficient_of_table_3_does_not_print_as_the_paper_has_it(mechanism):
    misprinted = [number for number, table in TABLES.items() if table.corrected_A]
    assert misprinted == [3]
    assert not TABLES[3].A.matches(classify(mechanism, TABLES[3].state).A)


def test_row_of_table_2_is_its_state_without_the_first_column():
    table = TABLES[2]
    state = dict.fromkeys(COLUMNS[:6], 0.0) | dict(table.state) | {"A": table.A, "B": table.B}
    numbers = [getattr(state[name], "value", state[name]) for name in COLUMNS[1:]]
    assert [float(word) for word in table.row.split()] == numbers


@pytest.mark.parametrize("claim", INITIAL_FORCES, ids=lambda c: f"{c.force.text} N")
def test_initial_force_follows_from_the_printed_height(simulator, claim):
    parameters = simulator.parameters({"E": claim.modulus})
    depth = simulator.compression_of_force(claim.force.value, parameters)
    assert claim.height.matches(-depth)
    # F ~ depth^n: the force that the printed height carries.
    assert claim.force.matches(claim.force.value * (-claim.height.value / depth) ** parameters["n"])


@pytest.mark.parametrize("claim", INITIAL_FORCES, ids=lambda c: f"{c.force.text} N")
def test_initial_force_contradicts_the_formula_printed_for_the_radius(simulator, claim):
    radius = simulator.parameters()["R"] / 2
    parameters = simulator.parameters({"E": claim.modulus, "R": radius})
    assert not claim.height.matches(-simulator.compression_of_force(claim.force.value, parameters))


@pytest.mark.parametrize(
    ("item", "key", "number"),
    [
        ("fig-3", "solutions", "sliding-force"),
        ("stick-time", "slip_stop", "sticking-time"),
        ("pendulum", "period", "pendulum-period"),
    ],
)
def test_numbers_in_the_text_print_as_in_the_paper(item, key, number):
    value = reproduce([item]).items[0].data[key]
    assert NUMBERS[number].matches(value[0] if isinstance(value, list) else value)
