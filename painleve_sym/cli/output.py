"""Output of the commands: exact JSON, aligned text."""

from __future__ import annotations

import json
import math
import sys
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from painleve_sym.files import write_beside
from painleve_sym.plain_data import to_plain
from painleve_sym.problem.risk import slip_angle
from painleve_sym.quantities import ROUNDING
from painleve_sym.tables import display_width, text_lines

if TYPE_CHECKING:
    from painleve_sym.study.critical.outcome_map import OutcomeMap
    from painleve_sym.study.maps.region_map import RegionMap

WIDTH = 80


def print_json(data: Mapping[str, Any]) -> None:
    """Print one JSON object with full precision, ending in a newline.

    JSON has no nan and no infinity: each becomes null, and the key ``not_finite`` then maps its
    place to what it was. Zero has no sign.
    """
    lost: dict[str, str] = {}
    clean = _finite(to_plain(data), "", lost)
    if lost:
        clean["not_finite"] = lost
    sys.stdout.write(_laid_out(clean, "") + "\n")


def draw(figure: str, path: Path, look: Mapping[str, Any], *subject: Any) -> None:
    """Write the figure that the function of `present` of this name draws of a subject.

    Matplotlib is loaded here.
    """
    from painleve_sym import present

    chosen = present.Look(**look)
    drawn = getattr(present, figure)(*subject, width=chosen.width)
    present.write_figure(drawn, path, chosen)


def notices_data(notices: Sequence[str]) -> dict[str, list[str]]:
    """Return the key of notices in JSON; nothing where there is none."""
    return {"notices": list(notices)} if notices else {}


def show_notices(notices: Sequence[str]) -> None:
    """Print notices, each as a paragraph."""
    for notice in notices:
        show()
        show(notice)


def deliver_map(
    computed: RegionMap | OutcomeMap,
    files: Sequence[Path],
    figure: str,
    look: Mapping[str, Any],
    show_text: Callable[[], None] | None,
    notices: Sequence[str],
) -> None:
    """Write a map as JSON, as arrays (``.npz``) or as a figure (see `draw`), and print it.

    Without `show_text` its summary is printed as JSON, with the notices in either case.
    """
    for path in files:
        suffix = path.suffix.lower()
        if suffix == ".npz":
            computed.save(path)
        elif suffix == ".json":
            content = json.dumps(computed.to_dict(), allow_nan=False) + "\n"
            write_beside(path, lambda file, text=content: file.write(text.encode("ascii")))
        else:
            draw(figure, path, look, computed)
    if show_text is None:
        written = {"files": list(map(str, files))} if files else {}
        print_json(computed.summary() | notices_data(notices) | written)
        return
    show_text()
    show_notices(notices)
    for path in files:
        show(f"written: {path}")


def _laid_out(value: Any, indent: str) -> str:
    """Write objects over several lines and lists of plain values on one."""
    inner = indent + "  "
    if isinstance(value, dict) and value:
        rows = [f"{inner}{json.dumps(k)}: {_laid_out(v, inner)}" for k, v in value.items()]
        return "{\n" + ",\n".join(rows) + f"\n{indent}}}"
    if isinstance(value, list) and any(isinstance(v, dict | list) for v in value):
        return "[\n" + ",\n".join(inner + _laid_out(v, inner) for v in value) + f"\n{indent}]"
    return json.dumps(value, allow_nan=False)


def _finite(value: Any, place: str, lost: dict[str, str]) -> Any:
    if isinstance(value, dict):
        dot = f"{place}." if place else ""
        return {str(k): _finite(v, f"{dot}{k}", lost) for k, v in value.items()}
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, list):
        return [_finite(v, f"{place}[{i}]", lost) for i, v in enumerate(value)]
    if isinstance(value, float):
        if math.isfinite(value):
            return value + 0.0  # -0.0 is 0.0
        lost[place] = repr(value)
        return None
    return value


def number(value: float, digits: int = 6, size: float = 0.0) -> str:
    """Return a number for people: `digits` significant ones, and 0 for the rounding of a size."""
    shown = 0.0 if abs(value) <= ROUNDING * size else value + 0.0
    return f"{shown:.{digits}g}"


def quantity(value: float, unit: str, digits: int = 6) -> str:
    """Return a number with its unit; the unit 1 is left out."""
    return number(value, digits) + ("" if unit == "1" else f" {unit}")


def assignments(values: Mapping[str, float], units: Mapping[str, str]) -> str:
    """Return ``name = value unit`` entries, separated by commas."""
    return ", ".join(f"{n} = {quantity(v, units.get(n, '1'))}" for n, v in values.items())


def velocity_table(
    courses: Sequence[tuple[str, Mapping[str, float]]],
    units: Mapping[str, str],
    corner: str = "",
    sizes: Mapping[str, float] | None = None,
) -> list[tuple[str, ...]]:
    """Return head and rows of a table of velocities by name: a row for each of several courses.

    `sizes` are those of the velocities, as for `number`.
    """
    names, known = list(courses[0][1]), sizes or {}
    rows = [(name, *(number(v[n], size=known.get(n, 0.0)) for n in names)) for name, v in courses]
    return [(corner, *(f"{n} [{units[n]}]" for n in names)), *rows]


def show(text: str = "") -> None:
    """Print a line, wrapped at 80 columns with its indentation kept."""
    print(wrapped(text))


def wrapped(text: str) -> str:
    """Return a line wrapped at 80 columns with its indentation kept."""
    if len(text) <= WIDTH:
        return text
    indent = " " * (len(text) - len(text.lstrip()) + 2)
    lines = textwrap.wrap(
        text,
        WIDTH,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
        drop_whitespace=True,
    )
    return "\n".join(lines)


def slip_head(n_tangents: int) -> tuple[str, ...]:
    """Return the title of the column of directions of slip: one tangent has none."""
    return ("slip [rad]",) if n_tangents > 1 else ()


def slip_cells(direction: Sequence[float]) -> tuple[str, ...]:
    """Return the cell of a direction of slip in that column: its angle, if it slips."""
    if len(direction) < 2:
        return ()
    return (number(slip_angle(direction)) if any(direction) else "",)


def show_table(
    head: Sequence[str], rows: Iterable[Sequence[str]], left: Sequence[int] = (0,), indent: int = 2
) -> None:
    """Print aligned columns; those in `left` are flush left, the others flush right.

    The last column is wrapped into the rest of the line where it is flush left.
    """
    table = [list(head), *(list(row) for row in rows)]
    widths = [max(map(display_width, column)) for column in zip(*table, strict=True)]
    last = len(head) - 1
    room = WIDTH - indent - sum(widths[:-1]) - 2 * last
    if last in left and room >= 20:
        widths[-1] = min(widths[-1], room)
    for line in text_lines(table, widths, left, indent):
        print(line)
