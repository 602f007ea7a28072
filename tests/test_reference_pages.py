"""The pages that the documentation site generates have everything of the package."""

from __future__ import annotations

import importlib
import inspect
import json
import re
import sys
import tomllib
from pathlib import Path

import pytest

from painleve_sym.cli.commands import COMMANDS
from painleve_sym.cli.grammar import parsers
from painleve_sym.doors import public_names
from painleve_sym.errors import EventKind, StopReason
from painleve_sym.laws.catalogue import LAWS
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.models import NAMED
from painleve_sym.quantities import QUANTITIES

ROOT = Path(__file__).parents[1]
EXTENSION = ROOT / "docs" / "_ext"


@pytest.fixture(scope="module")
def pages():
    # Imported as Sphinx does; the module needs nothing of Sphinx.
    sys.path.insert(0, str(EXTENSION))
    try:
        import reference_pages
    finally:
        sys.path.remove(str(EXTENSION))
    return reference_pages


@pytest.fixture(scope="module")
def classes():
    sys.path.insert(0, str(EXTENSION))
    try:
        import class_pages
    finally:
        sys.path.remove(str(EXTENSION))
    return class_pages


RESULTS = (
    *("BatchResult", "Classification", "ClassificationTable", "Comparison", "ContactSolution"),
    *("CorrectedJump", "CriticalForce", "EventRecord", "FitData", "FitResult", "Impact"),
    *("JumpPhase", "JumpResult", "RegionMap", "Reference", "SensitiveTrajectory", "SweepSummary"),
    *("Robot", "TangentialImpact", "Trajectory"),
)


@pytest.mark.parametrize("name", RESULTS)
def test_page_of_a_result_begins_with_its_example(classes, name):
    public = getattr(importlib.import_module(public_names()[name]), name)
    lines = inspect.getdoc(public).splitlines()
    shown = classes.example_first(lines)
    first = next(i for i, line in enumerate(shown) if line.startswith(">>> "))
    sections = [i for i, line in enumerate(shown) if line.startswith("---")]
    assert first < min(sections, default=len(shown)) and shown[0] == lines[0]
    left = {"Examples", "--------", ""}
    assert sorted(set(shown) - left) == sorted(set(lines) - left)
    assert classes.hide_constructor(None, "class", name, public, None, "(x)", None) == ("", "")


def test_what_users_make_keeps_its_constructor(classes):
    for name in ("Body", "Contact", "Coordinate", "CsvFormat", "Disc", "Parameter", "Simulator"):
        public = getattr(importlib.import_module(public_names()[name]), name)
        assert classes.is_made_by_users(public), name
        assert classes.hide_constructor(None, "class", name, public) is None


def test_examples_move_and_nothing_else_does(classes):
    text = "One line.\n\nMore.\n\nAttributes\n----------\na : int\n\nExamples\n--------\n>>> 1\n1"
    expected = "One line.\n\n>>> 1\n1\n\n\nMore.\n\nAttributes\n----------\na : int\n"
    assert "\n".join(classes.example_first(text.splitlines())) == expected
    assert classes.example_first(["No example."]) == ["No example."]


def first_cells(table):
    return re.findall(r"^\| `([^`]+)`", table, re.MULTILINE)


def test_tables_have_every_event_reason_and_quantity(pages):
    assert first_cells(pages.events()) == [str(kind) for kind in EventKind]
    assert first_cells(pages.stop_reasons()) == [reason.label for reason in StopReason]
    assert first_cells(pages.quantities()) == list(QUANTITIES)


def test_every_command_has_a_section_with_every_option(pages):
    sections = dict(
        re.findall(r"^## `painleve (\w+)`\n(.*?)(?=^\(|\Z)", pages.commands(), re.M | re.S)
    )
    assert list(sections) == list(COMMANDS)
    _, sub = parsers()
    for name, text in sections.items():
        for option in sub[name].options():
            assert option == "--help" or f"`{option}" in text


def test_every_command_with_json_has_calls_that_show_its_keys(pages):
    _, sub = parsers()
    with_json = {name for name in COMMANDS if "--json" in sub[name].options()}
    assert set(pages.OUTPUTS) == with_json
    for name, calls in pages.OUTPUTS.items():
        assert all(call.split()[0] == name for call in calls)


def test_keys_of_a_call_are_listed_with_type_and_example(pages):
    answer = {"events": [{"time": 0.5, "state": {"theta": 1.0}}], "limit": None}
    assert list(pages.paths(answer)) == [
        ("events", answer["events"]),
        ("events[].time", 0.5),
        ("events[].state", {"theta": 1.0}),
        ("events[].state.STATE", 1.0),
        ("limit", None),
    ]
    assert pages.call("cache")["bytes"] >= 0
    with pytest.raises(RuntimeError, match="unknown"):
        pages.call("classify rodd")


@pytest.mark.slow
def test_every_key_that_a_command_prints_has_a_meaning(pages):
    by_command = pages.json_keys()
    assert set(by_command) == set(pages.OUTPUTS) and all(map(first_cells, by_command.values()))
    listed = "".join(by_command.values())
    file = ROOT / "docs" / "reference" / "json-meanings.toml"
    meanings = tomllib.loads(file.read_text("utf-8"))
    assert set(meanings) - {"every"} <= set(COMMANDS)
    printed = {path.rpartition(".")[2].removesuffix("[]") for path in first_cells(listed)}
    assert {name for table in meanings.values() for name in table} <= printed


def test_mechanisms_laws_and_choices_are_complete(pages):
    headings = r"^## `([\w-]+)`"
    assert re.findall(headings, pages.mechanisms(), re.M) == list(NAMED)
    laws = pages.laws()
    assert re.findall(headings, laws, re.M) == list(LAWS)
    assert first_cells(laws.split("## Restitution rules")[1]) == list(RESTITUTIONS)
    assert "`virgin`" in pages.named_choices()


@pytest.mark.parametrize("name", ["mechanism", "scenario", "sweep"])
def test_every_key_of_a_schema_is_in_its_table(pages, name):
    schema = json.loads((ROOT / "docs" / "schemas" / f"{name}.schema.json").read_text("utf-8"))
    keys = first_cells(pages.schema_table(name))
    assert set(schema["properties"]) <= set(keys)
    assert len(keys) > len(schema["properties"])


def test_every_public_name_is_on_one_page():
    public = {n: p for n, p in public_names().items() if not n.startswith("_")}
    del public["rigid"]  # It stands with the other named laws, on the page of their module.
    for place in {*public.values()}:
        folder = place.removeprefix("painleve_sym").lstrip(".")
        path = ROOT / "docs" / (f"doors/{folder}.md" if folder else "reference/names.md")
        shown = re.findall(r"^   (\w+)$", path.read_text("utf-8"), re.M)
        assert sorted(shown) == sorted(n for n, p in public.items() if p == place), path


def test_cells_keep_bars(pages):
    assert pages.table(("a",), [("|F_n|",)]) == "| a |\n|---|\n| \\|F_n\\| |\n"
