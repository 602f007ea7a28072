"""The JSON Schemas of TOML files agree with the readers, and with every file of the repository."""

from __future__ import annotations

import json
import re
import tomllib
from dataclasses import fields
from pathlib import Path

import jsonschema
import pytest

from painleve_sym import InputError
from painleve_sym.choices import EngineName, Restitution
from painleve_sym.files import CsvFormat
from painleve_sym.laws.catalogue import CHOICES
from painleve_sym.mechanics.toml import mechanism_file as reader
from painleve_sym.motion.timetable import InputValues, Phase
from painleve_sym.study import scenario
from painleve_sym.study.sweeps import space, sweep

ROOT = Path(__file__).parents[1]
SCHEMAS = {
    name: json.loads((ROOT / "docs" / "schemas" / f"{name}.schema.json").read_text("utf-8"))
    for name in ("mechanism", "scenario", "sweep")
}
MECHANISM, SCENARIO, SWEEP = (SCHEMAS[name]["properties"] for name in SCHEMAS)
PAGES = [*(ROOT / "docs").glob("*.md"), *(ROOT / "docs").glob("*/*.md")]
FILES = [
    ("mechanism", p.name, p.read_text("utf-8"))
    for folder in ("examples/mechanisms", "painleve_sym/mechanics/models/everyday")
    for p in ROOT.glob(f"{folder}/*.toml")
]
FILES += [("sweep", p.name, p.read_text("utf-8")) for p in ROOT.glob("examples/sweeps/*.toml")]


def kind_of(data):
    """Return which kind of file the data is, or None for a part of one."""
    if "coordinates" in data:
        return "mechanism"
    if "model" in data:
        return "sweep" if {"axes", "sample"} & set(data) else "scenario"
    return None


for page in PAGES:
    for text in re.findall(
        r"^```toml\n(.*?)^```", page.read_text("utf-8"), re.MULTILINE | re.DOTALL
    ):
        if kind := kind_of(tomllib.loads(text)):
            FILES.append((kind, page.name, text))


def valid(kind, data):
    return jsonschema.Draft7Validator(SCHEMAS[kind]).is_valid(data)


@pytest.mark.parametrize("kind", SCHEMAS)
def test_a_schema_is_one(kind):
    jsonschema.Draft7Validator.check_schema(SCHEMAS[kind])


@pytest.mark.parametrize(("kind", "text"), [pytest.param(k, t, id=f"{k}-{n}") for k, n, t in FILES])
def test_a_schema_accepts_every_file_of_examples_and_pages(kind, text):
    jsonschema.validate(tomllib.loads(text), SCHEMAS[kind])


def test_files_of_every_kind_are_tested():
    assert {kind for kind, _, _ in FILES} == set(SCHEMAS) and len(FILES) > 14


@pytest.mark.parametrize(
    ("part", "keys"),
    [
        (MECHANISM, reader._TOP),
        (MECHANISM["coordinates"]["additionalProperties"]["properties"], reader._COORDINATE),
        (MECHANISM["quaternions"]["additionalProperties"]["properties"], reader._QUATERNION),
        (MECHANISM["parameters"]["additionalProperties"]["properties"], reader._PARAMETER),
        (MECHANISM["inputs"]["additionalProperties"]["properties"], reader._INPUT),
        (MECHANISM["bodies"]["items"]["properties"], reader._BODY),
        (MECHANISM["bodies"]["items"]["properties"]["modes"]["items"]["properties"], reader._MODE),
        (MECHANISM["shapes"]["items"]["properties"], reader._SHAPE),
        (MECHANISM["springs"]["items"]["properties"], reader._SPRING),
        (MECHANISM["loads"]["items"]["properties"], reader._LOAD),
        (MECHANISM["contacts"]["items"]["properties"], reader._CONTACT),
        (SCENARIO, scenario._READERS),
        (SCENARIO["robot"]["properties"], (*scenario._OF_FILE, *scenario._OF_CONTACT)),
        (SCENARIO["phases"]["items"]["properties"], Phase.__annotations__),
        (
            SCENARIO["inputs"]["additionalProperties"]["oneOf"][1]["properties"],
            InputValues.__annotations__,
        ),
        (SCENARIO["csv"]["properties"], [f.name for f in fields(CsvFormat)]),
        (SWEEP, (set(scenario._READERS) - set(sweep.UNUSED_KEYS)) | set(sweep.OWN_KEYS)),
    ],
)
def test_a_schema_has_the_keys_that_the_reader_accepts(part, keys):
    assert set(part) == set(keys)


def test_a_schema_has_the_choices_of_the_package():
    law = SCENARIO["law"]["oneOf"][1]["properties"]
    assert {name: tuple(law[name]["enum"]) for name in CHOICES} == {
        name: tuple(map(str, values)) for name, values in CHOICES.items()
    }
    assert set(law) == {"name", "parameters", *CHOICES}
    assert SCENARIO["engine"]["enum"] == [str(e) for e in EngineName]
    assert SCENARIO["rule"]["enum"] == [str(r) for r in Restitution]
    assert set(SWEEP["format"]["enum"]) == set(sweep.FORMATS)
    assert SWEEP["sample"]["properties"]["method"]["enum"] == list(space.METHODS)
    scales = SWEEP["axes"]["additionalProperties"]["oneOf"][1]["properties"]["scale"]["enum"]
    assert scales == list(space.SCALES)


WHEEL = (ROOT / "examples" / "mechanisms" / "wheel-on-slope.toml").read_text("utf-8")
FAULTS = [
    ("mechanism", WHEEL.replace("gravity", "gravty"), "gravty"),
    ("mechanism", WHEEL.replace('unit = "m",', "unit = 3,", 1), "unit"),
    ("mechanism", WHEEL + '\n[[contacts]]\nname = "b"\nfriction = "mu"\n', "point, disc, gap"),
    ("scenario", 'model = "rod"\nstate = { theta = "much" }\n', "theta"),
    ("scenario", 'model = "rod"\nt_ende = 1.0\n', "t_ende"),
    ("scenario", "t_end = 1.0\n", "model"),
    ("sweep", 'model = "rod"\nrule = "newton"\n[axes]\nmu = [1.0]\n', "rule"),
    ("sweep", 'model = "rod"\n[axes]\nmu = { from = 1.0, to = 2.0, pts = 3 }\n', "pts"),
]


@pytest.mark.parametrize(("kind", "text", "word"), FAULTS)
def test_what_a_schema_rejects_the_reader_rejects(kind, text, word):
    assert not valid(kind, tomllib.loads(text))
    with pytest.raises(InputError, match=word):
        if kind == "mechanism":
            reader.mechanism_from_text(text)
        elif kind == "scenario":
            scenario.Scenario.from_data(tomllib.loads(text))
        else:
            sweep.Sweep.from_text(text, "sweep")
