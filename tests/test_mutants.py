"""The list of wrong changes applies to the package as it is; `make mutants` runs them."""

import pytest

from tests.mutants.__main__ import NEEDED
from tests.mutants.mutants import ROOT, read_mutants

MUTANTS = read_mutants()


def test_list_is_long_enough_and_names_are_different():
    assert 0.9 <= NEEDED < 1 and len(MUTANTS) >= 400
    page = (ROOT / "docs" / "engine.md").read_text("utf-8")
    assert f"at least {100 * NEEDED:.0f} % of the changes must make one of them fail" in page
    assert len({m.name for m in MUTANTS}) == len(MUTANTS)


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda m: m.name)
def test_change_applies_in_one_place_and_names_tests(mutant):
    assert mutant.occurrences() == 1
    assert mutant.new != mutant.old
    assert mutant.tests
    for test in mutant.tests:
        path, *name = test.split("::")
        text = (ROOT / "tests" / path).read_text("utf-8")
        assert all(f"def {n.split('[')[0]}(" in text for n in name)
