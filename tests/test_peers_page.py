"""The page of the other programs: its tables are the kept results; the package's are computed."""

from __future__ import annotations

import importlib
import json
import re

import pytest

from tests.benchmarks import peers_page
from tools.tables import written

FOLDER = peers_page.RESULTS.parent


@pytest.fixture(scope="module")
def results():
    return json.loads(peers_page.RESULTS.read_text("utf-8"))


def test_tables_of_the_page_are_the_results(results):
    page = peers_page.PAGE.read_text("utf-8")
    assert written(page, peers_page.tables(results)) == page


def test_every_script_has_a_result_and_the_versions_of_the_requirements(results):
    of = {r["program"].split(" ")[0].lower(): r for r in results}
    scripts = {p.name.removesuffix("_rod.py") for p in FOLDER.glob("*_rod.py")}
    assert {name.split("-")[0] for name in of} - {"chrono"} == scripts - {"pybullet"} | {"bullet"}
    for line in (FOLDER / "requirements.txt").read_text("utf-8").splitlines():
        if pinned := re.fullmatch(r"(\w+)==([\d.]+)", line):
            name = {"pybullet": "bullet"}.get(pinned[1], pinned[1])
            assert of[name].get("version") == pinned[2]


def test_a_missing_program_is_a_row_that_says_so(results):
    lost = [{"program": "Drake", "missing": "not installed: No module named 'pydrake'"}]
    table = peers_page.state_table(lost, "no solution (Table 3)")
    assert table.splitlines()[-1].startswith("| Drake | not installed | — |")
    assert "No module named" in peers_page.version_table(lost)


@pytest.mark.filterwarnings("ignore::pytest.PytestWarning")
def test_the_packages_own_rows_can_be_computed_again(results, monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    rod = importlib.import_module("rod")
    own = importlib.import_module("painleve_rod")
    kept = next(r for r in results if r["program"] == "painleve-sym")["settings"]
    for solver in ("least-impulse", "lemke"):
        for state in rod.STATES:
            rows = rod.measured(own.stepping(solver), state, steps=(1e-3,))
            old = kept[f"Moreau-Jean, {solver}"][state][0]
            assert rows[0]["force"] == pytest.approx(old["force"], rel=1e-6, abs=1e-5)
            assert rows[0]["end"] == pytest.approx(old["end"], rel=1e-6, abs=1e-5)


def test_siconos_and_the_package_agree_on_the_first_step(results):
    """Two programs of their own, and the same scheme: equal but for the gap of 1e-9 m."""
    of = {r["program"]: r["settings"] for r in results if "settings" in r}
    for state in peers_page.MARKS:
        own = of["painleve-sym"]["Moreau-Jean, lemke"][state]
        other = of["Siconos"]["Moreau-Jean, Lemke, e = 0"][state]
        for a, b in zip(own, other, strict=True):
            assert a["force"] == pytest.approx(b["force"], rel=0.01, abs=1e-3)
            assert a["impulse"] == pytest.approx(b["impulse"], rel=0.01, abs=1e-4)
