"""No module imports what stands above it: neither when it loads, nor later, nor by a string."""

from __future__ import annotations

import ast
import re

import pytest

from tools.house import PACKAGE, PICTURE, ROOT, below, called, imports_of, picture


def climbing(imports: dict[str, dict[str, int]]) -> list[str]:
    """Return the imports that lead back to their own module."""
    direct = {name: set(own) for name, own in imports.items()}
    above = {name: below(direct, name) for name in imports}
    return sorted(
        f"{name}:{line} imports {other}"
        for name, own in imports.items()
        for other, line in own.items()
        if name in above[other]
    )


def test_no_import_climbs():
    assert climbing(imports_of(ROOT)) == []


@pytest.mark.parametrize(
    "line",
    [
        "def late():\n    from painleve_sym.top import name",
        "def late():\n    import painleve_sym.top",
        'def late():\n    importlib.import_module("painleve_sym.top")',
        'def late(name):\n    return importlib.import_module(f"painleve_sym.{name}")',
        'def late():\n    return __import__("painleve_sym.top")',
    ],
)
def test_climb_is_noticed(tmp_path, line):
    folder = tmp_path / PACKAGE
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "top.py").write_text("from painleve_sym.ground import late")
    (folder / "ground.py").write_text(line)
    assert "painleve_sym.ground:" in " ".join(climbing(imports_of(tmp_path)))


def test_picture_of_the_house_is_that_of_the_imports():
    drawn = (ROOT / PICTURE).read_text("utf-8")
    assert drawn == picture(ROOT), "Fix: run `python tools/house.py`."


def test_names_of_modules_stand_as_texts_only_above_all_stages():
    texts = {
        name
        for name, source in _sources()
        if re.search("import_module|__import__", source)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call)
        and called(node) in ("import_module", "__import__")
        and PACKAGE in ast.unparse(node)
    }
    assert texts <= {"__init__.py", "cli"}


def _sources() -> list[tuple[str, str]]:
    folder = ROOT / PACKAGE
    return [(p.relative_to(folder).parts[0], p.read_text("utf-8")) for p in folder.rglob("*.py")]
