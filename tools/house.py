"""The picture of the package in docs/architecture.md, from its imports: `python tools/house.py`.

A box is a folder of the package or a module beside them; the modules that import no folder are one
box. An arrow is an import that no chain of others implies, so that all imports lead down.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from painleve_sym.escape import html_text
from painleve_sym.files import write_beside

ROOT = Path(__file__).parents[1]
PACKAGE = "painleve_sym"
PICTURE = Path("docs/figures/house.svg")
GROUND = "tools and words"
"""The modules beside the folders that import none of them."""

_WIDE, _HIGH, _ACROSS, _DOWN, _EDGE = 150, 34, 240, 74, 20  # px, of boxes and between them


class Imports(ast.NodeVisitor):
    """Imports of one module of the package that run, with their lines; those for types are none."""

    def __init__(self, name: str, modules: set[str], *, calls: bool) -> None:
        self.name, self.modules, self.imports = name, modules, dict[str, int]()
        self.calls = calls  # whether a call may import, so that expressions are read

    def visit(self, node: ast.AST) -> None:
        """Read statements, and expressions where one may import."""
        if self.calls or not isinstance(node, ast.expr):
            super().visit(node)

    def visit_If(self, node: ast.If) -> None:
        """Read what runs: not what is for type checkers alone."""
        typed = ast.unparse(node.test)
        for child in [*([] if typed == "TYPE_CHECKING" else node.body), *node.orelse]:
            self.visit(child)

    def visit_Import(self, node: ast.Import) -> None:
        """Add whole modules."""
        for alias in node.names:
            self._add(alias.name, node.lineno)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        """Add modules, or those that a name is taken from."""
        for alias in node.names:
            inner = f"{node.module}.{alias.name}"
            self._add(inner if inner in self.modules else str(node.module), node.lineno)

    def visit_Call(self, node: ast.Call) -> None:
        """Add what is imported by a string."""
        if called(node) in ("import_module", "__import__"):
            given = node.args[0]
            first = given.values[0] if isinstance(given, ast.JoinedStr) else given
            text = first.value if isinstance(first, ast.Constant) else ""
            for module in self.modules:
                if str(text).startswith(f"{PACKAGE}.") and module.startswith(str(text)):
                    self._add(module, node.lineno)
        self.generic_visit(node)

    def _add(self, module: str, line: int) -> None:
        # The package itself stands above all stages; what is taken from it is its version.
        if module in self.modules and module not in (self.name, PACKAGE):
            self.imports[module] = line


def called(node: ast.Call) -> str:
    """Return the name of the function that is called, without its module or object."""
    func = node.func
    return str(getattr(func, "attr", getattr(func, "id", "")))


@cache
def imports_of(root: Path) -> dict[str, dict[str, int]]:
    """Return the imports of every module by module, each with its line."""
    paths = {}
    for path in (root / PACKAGE).rglob("*.py"):
        parts = path.relative_to(root).with_suffix("").parts
        paths[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    every, modules = {}, set(paths)
    for name, path in paths.items():
        source = path.read_text("utf-8")
        reader = Imports(name, modules, calls="import_module" in source or "__import__" in source)
        reader.visit(ast.parse(source))
        every[name] = reader.imports
    del every[PACKAGE]
    return every


def below(imports: dict[str, set[str]], start: str, without: str = "") -> set[str]:
    """Return all that `start` imports directly or through others, but for one direct import."""
    seen, todo = set[str](), list(imports[start] - {without})
    while todo:
        new = imports[todo.pop()] - seen
        seen |= new
        todo += new
    return seen | imports[start] - {without}


def rooms_of(root: Path) -> dict[str, set[str]]:
    """Return folders and modules of the package, and `GROUND`, each with those that it imports."""
    parts: dict[str, set[str]] = {}
    for name, own in imports_of(root).items():
        # The command line is what runs the package as a module.
        if name != f"{PACKAGE}.__main__":
            part = name.split(".")[1]
            parts.setdefault(part, set()).update({o.split(".")[1] for o in own} - {part})
    folders = {p.parent.name for p in (root / PACKAGE).glob("*/__init__.py")}
    ground = {name for name in parts if not (below(parts, name) | {name}) & folders}
    rooms: dict[str, set[str]] = {name: set() for name in sorted({*parts, GROUND} - ground)}
    for name, own in parts.items():
        if name not in ground:
            rooms[name] = {GROUND if o in ground else o for o in own}
    return rooms


def picture(root: Path) -> str:
    """Return the picture as SVG."""
    rooms = rooms_of(root)
    direct = {
        name: {other for other in own if other not in below(rooms, name, other)}
        for name, own in rooms.items()
    }
    floors = _floors(direct)
    places = _places(direct, floors)
    left, right = min(x for x, _ in places.values()), max(x for x, _ in places.values())
    wide = right - left + _WIDE + 2 * _EDGE
    high = _DOWN * (len(floors) - 1) + _HIGH + 2 * _EDGE
    middle = {n: (x - left + _WIDE / 2 + _EDGE, y + _EDGE) for n, (x, y) in places.items()}
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide:g} {high:g}" '
        f'width="{wide:g}" height="{high:g}" font-family="sans-serif" font-size="15">',
        '<defs><marker id="end" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0 0L8 4L0 8z" fill="#555"/></marker></defs>',
        f'<rect width="{wide:g}" height="{high:g}" fill="#ffffff"/>',
    ]
    for name, own in direct.items():
        x, y = middle[name]
        for other in sorted(own):
            end, top = middle[other]
            end = x if other == GROUND else end
            way = _way((x, y + _HIGH), (end, top), middle.values())
            lines.append(
                f'<path d="{way}" fill="none" stroke="#555" stroke-width="1.4" '
                'marker-end="url(#end)"/>'
            )
    for name, (x, y) in middle.items():
        start, size = (_EDGE, wide - 2 * _EDGE) if name == GROUND else (x - _WIDE / 2, _WIDE)
        lines.append(
            f'<rect x="{start:g}" y="{y:g}" width="{size:g}" height="{_HIGH}" rx="4" '
            'fill="#e8eef4" stroke="#345"/>'
        )
        lines.append(
            f'<text x="{start + size / 2:g}" y="{y + _HIGH / 2 + 5:g}" text-anchor="middle" '
            f'fill="#123">{html_text(name)}</text>'
        )
    return "\n".join([*lines, "</svg>", ""])


def _way(
    start: tuple[float, float], end: tuple[float, float], boxes: Iterable[tuple[float, float]]
) -> str:
    """Return the path of an arrow: straight, or to the right of the boxes that are in its way."""
    (x, y), (last, top) = start, end
    met = [
        at
        for at, above in boxes
        if y < above < top - _HIGH
        and abs(x + (last - x) * (above + _HIGH / 2 - y) / (top - y) - at) < _WIDE / 2
    ]
    if not met:
        return f"M{x:g} {y:g}L{last:g} {top:g}"
    side = max(met) + 1.1 * _WIDE
    return f"M{x:g} {y:g}C{side:g} {y:g} {side:g} {top - _HIGH:g} {last:g} {top:g}"


def _floors(direct: dict[str, set[str]]) -> list[list[str]]:
    """Return the rooms by the longest chain of imports below them, the highest first."""
    depth: dict[str, int] = {}

    def level(name: str) -> int:
        if name not in depth:
            depth[name] = 1 + max(map(level, direct[name]), default=-1)
        return depth[name]

    for name in direct:
        level(name)
    return [[n for n in direct if depth[n] == k] for k in range(max(depth.values()), -1, -1)]


def _places(
    direct: dict[str, set[str]], floors: Iterable[list[str]]
) -> dict[str, tuple[float, float]]:
    """Return x and y of each room, below those that import it."""
    places: dict[str, tuple[float, float]] = {}
    for k, floor in enumerate(floors):
        above = {n: [places[o] for o, own in direct.items() if n in own] for n in floor}
        wanted = {n: sum(x for x, _ in at) / len(at) if at else -1.0 for n, at in above.items()}
        reach = {n: min((y for _, y in at), default=0.0) for n, at in above.items()}
        order = sorted(floor, key=lambda n: (wanted[n], reach[n], n))
        for i, name in enumerate(order):
            places[name] = ((i - (len(order) - 1) / 2) * _ACROSS, float(k * _DOWN))
    return places


if __name__ == "__main__":
    write_beside(ROOT / PICTURE, lambda file: file.write(picture(ROOT).encode()))
