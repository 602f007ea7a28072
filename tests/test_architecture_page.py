"""The page on the architecture: its paths, names and stages are those of the code."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from painleve_sym.cli.commands import COMMANDS

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "painleve_sym"
PAGE = (ROOT / "docs" / "architecture.md").read_text("utf-8")
TERMS = sorted(set(re.findall(r"`([^`\n]+)`", re.sub(r"```.*?```", "", PAGE, flags=re.DOTALL))))
PATHS = [t for t in TERMS if re.fullmatch(r"(painleve_sym|tests|docs)(/[\w.]+)*", t)]
NAMES = [t for t in TERMS if re.fullmatch(r"_?[A-Za-z]+(_[a-z]+)*(\(\))?", t) and t not in PATHS]
# Words in code type that are not Python names: tools, and parts of file names.
OTHERS = {"docs", "tests"}


def _names() -> set[str]:
    """Return the names of all modules, classes, functions, constants and parameters."""
    names = {p.stem for p in PACKAGE.rglob("*.py")} | {p.parent.name for p in PACKAGE.rglob("*.py")}
    definition = re.compile(r"^ *(?:(?:class|def) (\w+)|(\w+)(?:: [^=\n]+)? = )", re.M)
    for path in PACKAGE.rglob("*.py"):
        names.update(*definition.findall(path.read_text("utf-8")))
    return names


@pytest.mark.parametrize("path", PATHS)
def test_path_exists(path):
    assert (ROOT / path).exists()


def test_names_exist():
    known = _names() | set(COMMANDS) | OTHERS | {"motion"}
    assert len(NAMES) > 40
    assert [n for n in NAMES if n.removesuffix("()") not in known] == []


def test_name_beside_a_path_is_defined_there():
    pairs = re.findall(r"\*{0,2}`(\w+)`\*{0,2}\s+(?:in\s+|\()`(painleve_sym/[\w/]+\.py)`", PAGE)
    assert len(pairs) >= 20
    for name, path in pairs:
        text = (ROOT / path).read_text("utf-8")
        assert re.search(rf"^(class|def|    def) {name}\b|^{name}\b.*=", text, re.M), (name, path)


def test_stages_are_those_that_the_linter_checks():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]
    (stages,) = (c for c in settings["contracts"] if c["id"] == "stages")
    layers = [re.findall(r"\w+", layer) for layer in stages["layers"]]
    table = PAGE.split("## The picture")[1].split("The same list")[0]
    cells = re.findall(r"^\| [^|]+ \| (`[^|]+`) \| [^|]+ \|$", table, re.M)
    assert [re.findall(r"`(\w+)`", cell) for cell in cells] == layers[1:]
    assert layers[0] == ["__main__"]


def test_page_of_the_command_line_has_every_command():
    page = (ROOT / "docs" / "cli.md").read_text("utf-8")
    rows = re.findall(r"^\| (.*?`) \|", page, re.M)
    documented = {w.split()[0] for row in rows for w in re.findall(r"`([^`]+)`", row)}
    assert set(COMMANDS) <= documented
