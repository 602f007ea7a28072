"""No module imports what stands above it: neither when it loads, nor later, nor by a string."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = "painleve_sym"
ROOT = Path(__file__).parents[1]


class Imports(ast.NodeVisitor):
    """Imports of one module of the package that run, with their lines; those for types are none."""

    def __init__(self, name: str, modules: set[str]) -> None:
        self.name, self.modules, self.imports = name, modules, dict[str, int]()

    def visit_If(self, node: ast.If) -> None:
        typed = ast.unparse(node.test)
        for child in [*([] if typed == "TYPE_CHECKING" else node.body), *node.orelse]:
            self.visit(child)

    def visit_Import(self, node: ast.Import) -> None:
        for alias in node.names:
            self._add(alias.name, node.lineno)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        for alias in node.names:
            inner = f"{node.module}.{alias.name}"
            self._add(inner if inner in self.modules else str(node.module), node.lineno)

    def visit_Call(self, node: ast.Call) -> None:
        if ast.unparse(node.func).split(".")[-1] in ("import_module", "__import__"):
            given = node.args[0]
            first = given.values[0] if isinstance(given, ast.JoinedStr) else given
            text = first.value if isinstance(first, ast.Constant) else ""
            for module in self.modules:
                if text.startswith(f"{PACKAGE}.") and module.startswith(text):
                    self._add(module, node.lineno)
        self.generic_visit(node)

    def _add(self, module: str, line: int) -> None:
        # The package itself stands above all stages; what is taken from it is its version.
        if module in self.modules and module not in (self.name, PACKAGE):
            self.imports[module] = line


def imports_of(root: Path) -> dict[str, dict[str, int]]:
    """Return the imports of every module by module, each with its line."""
    paths = {}
    for path in (root / PACKAGE).rglob("*.py"):
        parts = path.relative_to(root).with_suffix("").parts
        paths[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    every = {}
    for name, path in paths.items():
        reader = Imports(name, set(paths))
        reader.visit(ast.parse(path.read_text("utf-8")))
        every[name] = reader.imports
    del every[PACKAGE]
    return every


def climbing(imports: dict[str, dict[str, int]]) -> list[str]:
    """Return the imports that lead back to their own module."""

    def reached(start: str) -> set[str]:
        seen, todo = set[str](), [start]
        while todo:
            new = set(imports[todo.pop()]) - seen
            seen |= new
            todo += new
        return seen

    above = {name: reached(name) for name in imports}
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


def test_names_of_modules_stand_as_texts_only_above_all_stages():
    texts = {
        name
        for name, path in _sources()
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Call)
        and ast.unparse(node.func).split(".")[-1] in ("import_module", "__import__")
        and PACKAGE in ast.unparse(node)
    }
    assert texts <= {"__init__.py", "cli"}


def _sources() -> list[tuple[str, Path]]:
    folder = ROOT / PACKAGE
    return [(path.relative_to(folder).parts[0], path) for path in folder.rglob("*.py")]
