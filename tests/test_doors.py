"""The doors of the package: their names, their pages, and what a missing name says."""

from __future__ import annotations

import doctest
import importlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

import painleve_sym
from painleve_sym.doors import FOLDER, doors, listed

ROOT = Path(FOLDER)
DOCS = ROOT.parent / "docs"
PAGES = sorted((DOCS / "doors").glob("*.md"))


def test_the_package_itself_has_the_names_that_people_need_first():
    assert 55 < len(painleve_sym.__all__) < 65


def test_every_room_with_a_stub_is_a_door():
    rooms = {f"painleve_sym.{p.parent.name}" for p in ROOT.glob("*/__init__.py")}
    assert rooms - {*doors()} == {"painleve_sym.cli"}
    assert {f"painleve_sym.{p.stem}" for p in PAGES} == {*doors(), "painleve_sym.index"}


@pytest.mark.parametrize("name", doors())
def test_a_door_has_what_it_names_and_no_module_is_in_the_way(name):
    door = importlib.import_module(name)
    folder = ROOT / name.split(".")[1]
    modules = {p.stem for p in folder.glob("*.py")}
    modules |= {p.parent.name for p in folder.glob("*/__init__.py")}
    # Importing a module sets an attribute of its name, which would hide a name of the door.
    assert not {*dir(door)} & modules
    assert {*dir(door)} == {*door.__all__, *listed(name)}
    for own in dir(door):
        assert getattr(door, own).__doc__
    with pytest.raises(AttributeError, match=r"has no attribute 'nonsense'$"):
        _ = door.nonsense


def test_no_name_stands_behind_two_doors():
    names = [name for door in doors() for name in listed(door)]
    assert sorted({*names}) == sorted(names)


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("FitProblem", ". Fix: from painleve_sym.study import FitProblem"),
        ("c_export", ". Fix: import painleve_sym.c_export"),
        ("nonsense", ""),
        ("_repr_html_", ""),
    ],
)
def test_a_missing_name_says_behind_which_door_it_is(name, remedy):
    code = f"import painleve_sym as ps\ntry:\n ps.{name}\nexcept AttributeError as e:\n print(e)"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert answer.stdout == f"module 'painleve_sym' has no attribute {name!r}{remedy}\n"


def test_the_lists_of_public_names_cost_no_library():
    code = "import sys, painleve_sym, painleve_sym.at, painleve_sym.study, painleve_sym.present\n"
    code += "print({'numpy', 'sympy', 'casadi', 'matplotlib'} & {*sys.modules})"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert answer.stdout == "set()\n", answer.stderr


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_a_page_begins_with_a_few_lines_of_python_that_run(page, tmp_path, monkeypatch):
    if page.stem == "certify":
        pytest.importorskip("flint")
    text = page.read_text("utf-8")
    _, block = re.match(r"# (.+)\n\n```python\n(.*?)```", text, re.S).groups()
    assert 2 <= len(re.findall("^>>> ", block, re.M)) <= 7
    assert page.stem == "index" or f"painleve_sym.{page.stem}" in block + text.split("\n")[0]
    (tmp_path / "examples").symlink_to(ROOT.parent / "examples")
    monkeypatch.chdir(tmp_path)
    result = doctest.testfile(str(page), module_relative=False)
    assert result.attempted >= 2 and result.failed == 0


def test_lists_are_part_of_an_installed_package():
    text = Path(ROOT.parent, "pyproject.toml").read_text("utf-8")
    assert '"*" = ["*.pyi"]' in text
