"""Style of all figures: one or two journal columns, one palette, reproducible files."""

from __future__ import annotations

import functools
import io
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ParamSpec

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import get_registered_canvas_class
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from painleve_sym.errors import InputError
from painleve_sym.escape import html_text as escape
from painleve_sym.files import write_beside
from painleve_sym.present.fonts import FAMILY, make_legible, text_width
from painleve_sym.quantities import ROUNDING, number_latex, symbol_latex

P = ParamSpec("P")

_METADATA: dict[str, dict[str, Any]] = {
    # Neither a date nor a version.
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
COLUMN, PAGE = 3.4, 7.0
"""Widths of one column and of the page; inch."""
NARROW = 5.0
"""Figures narrower than this have their panels below each other; inch."""
TALLEST = 9.0
"""Height of a figure that fits a journal's page with its caption; inch."""
DPI = 300
"""Resolution of the PNG: 1020 or 2100 pixels wide, as journals want it."""

# Okabe & Ito (2008): distinct to any colour vision. The dashes distinguish them in grey.
PALETTE = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7")
DASHES: tuple[Any, ...] = (
    "solid",
    (0, (5, 1.5)),
    (0, (5, 1.5, 1, 1.5)),
    (0, (1, 1)),
    (0, (7, 1.5, 1, 1.5, 1, 1.5)),
)
CONTACTS = (PALETTE[0], PALETTE[3], PALETTE[4], PALETTE[1], PALETTE[2])
"""Colours of several contacts; each has its dashes, too."""
SLIP, EVENT = "#6B6B00", "#882255"
"""Colours of a slip velocity and of an event in films; contacts and forces have others."""
TICKS = (EVENT, "#E69F00", "#7F7F7F", "#56B4E9", SLIP)
"""Colours of the ticks of events that are too many to be marked."""
STEPS = [1, 2, 2.5, 4, 5, 10]
"""Distances of the numbers along an axis, of a power of ten."""
REFERENCE = "#7F7F7F"
# Okabe's blue made darker and his vermilion lighter: so the two differ in grey, too.
NORMAL, TANGENTIAL = "#005A9C", "#E66100"
"""Colours of the normal and of the tangential force."""
ADMISSIBLE = "#56B4E9"


@dataclass(frozen=True)
class Marker:
    """Style of a kind of mark: small filled ones stay visible inside open ones."""

    name: str
    symbol: str
    size: float
    face: str


MARKERS = {
    "slip_stop": Marker("slip stops", "v", 5.8, "white"),
    "slip_start": Marker("reverse slip starts", ">", 5.0, "white"),
    "max_compression": Marker("maximum compression", "D", 2.6, "black"),
    "reload": Marker("reload", "^", 4.6, "white"),
    "separation": Marker("separation", "o", 4.2, "white"),
    "solution": Marker("solution", "o", 6.0, PALETTE[2]),
}
"""By the kind of a mark."""

_EVENT_LABELS = {"liftoff": "lift-off", "slip_start": "slip starts"}


def event_label(kind: str) -> str:
    """Return the words for a kind of event in figures."""
    if kind in _EVENT_LABELS:
        return _EVENT_LABELS[kind]
    return MARKERS[kind].name if kind in MARKERS else kind.replace("_", " ")


_COLUMNS = {1: 1, 2: 2, 4: 2}
"""Columns of panels by their number; 3 of others."""
LEGEND_ROW = 0.17
"""Height of a row of a legend; inch."""
# Any: the stubs of matplotlib type every key by name.
STYLE: Any = {
    "font.family": FAMILY,
    "mathtext.fontset": "stix",
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.titlepad": 4.0,
    "axes.linewidth": 0.6,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 5),
    "axes.formatter.use_mathtext": True,
    "axes.unicode_minus": True,
    "axes.xmargin": 0.03,
    "axes.ymargin": 0.06,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.top": True,
    "ytick.right": True,
    "lines.linewidth": 1.1,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "legend.borderpad": 0.1,
    "legend.handlelength": 2.4,
    "legend.columnspacing": 1.4,
    "figure.dpi": DPI,
    "savefig.dpi": DPI,
    "svg.hashsalt": "painleve-sym",
    "svg.fonttype": "path",
    "path.simplify": True,
}


class PlainTicks(ScalarFormatter):
    """Numbers along an axis as words, where matplotlib reads and draws each as a formula.

    The power of ten that they share stays a formula.
    """

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the text of a tick."""
        return super().__call__(x, pos).removeprefix(r"$\mathdefault{").removesuffix("}$")


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Let a function draw in the style of the project, with fonts that have every letter."""

    @functools.wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with matplotlib.rc_context(STYLE):
            figure = draw(*args, **kwargs)
            for axes in figure.axes:
                for axis in (axes.xaxis, axes.yaxis):
                    if type(axis.get_major_formatter()) is ScalarFormatter:
                        axis.set_major_formatter(PlainTicks())
            for text in figure.findobj(Text):
                make_legible(text)
        return figure

    return drawn


def value_text(name: str, value: float, unit: str = "1") -> str:
    """Return a value of a coordinate, velocity or parameter as a formula with its unit."""
    return f"${symbol_latex(name)} = {number_latex(value)}$" + (f" {unit}" if unit != "1" else "")


def fitted(parts: Sequence[str], width: float) -> str:
    """Return the parts as a title, separated by commas, on lines that fit the width; inch."""
    lines: list[str] = []
    for part in parts:
        longer = f"{lines[-1]}, {part}" if lines else part
        if lines and text_width(longer, STYLE["axes.titlesize"]) <= width:
            lines[-1] = longer
        else:
            lines = [*lines[:-1], f"{lines[-1]},", part] if lines else [part]
    return "\n".join(lines)


def legend_below(figure: Figure, entries: Mapping[str, Any]) -> None:
    """Draw a legend of handles by name below the figure, in columns that fit its width.

    The figure becomes as much higher, up to `TALLEST`. Entries are read row by row.
    """
    if not entries:
        return
    names = list(entries)
    width, height = figure.get_size_inches()
    # The widest text with the handle, gap and column spacing of the legend.
    size = max(text_width(name, STYLE["legend.fontsize"]) for name in names) + 0.6
    columns = max(1, min(len(names), int((width + 0.16) / size)))
    rows = -(-len(names) // columns)
    columns = -(-len(names) // rows)
    # Legends are filled column by column.
    by_column = [name for i in range(columns) for name in names[i::columns]]
    figure.set_size_inches(width, min(height + LEGEND_ROW * rows, TALLEST))
    handles = [entries[name] for name in by_column]
    figure.legend(handles, by_column, loc="outside lower center", ncols=columns)


def panel_grid(
    count: int, width: float | None, height: float, own: float = PAGE
) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels in two or three columns, or below each other in a narrow one.

    Width, by default the figure's own, and height of a panel are in inches; the height shrinks
    where the panels do not fit a page.
    """
    wide = own if width is None else width
    columns = 1 if wide < NARROW else _COLUMNS.get(count, 3)
    rows = -(-count // columns)
    size = (wide, rows * min(height, TALLEST / rows))
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in grid[count:]:
        axes.remove()
    return figure, list(grid[:count])


def legend_entries(axes: Iterable[Axes]) -> dict[str, Any]:
    """Return the labelled artists of panels by label, each label once."""
    entries: dict[str, Any] = {}
    for panel in axes:
        for handle, name in zip(*panel.get_legend_handles_labels(), strict=True):
            entries.setdefault(name, handle)
    return entries


def show_above_rounding(axes: Axes, scale: float, tolerance: float = 0.0) -> None:
    """Draw a curve flat that varies by rounding only: within a tolerance, or 1e-13 of its scale."""
    low, high = axes.dataLim.intervaly
    size = max(abs(low), abs(high), scale)
    least = max(2 * tolerance, ROUNDING * size)
    if np.isfinite(size) and 0 < high - low <= least:
        middle, half = (high + low) / 2, 0.05 * max(scale, abs(high))
        middle = 0.0 if abs(middle) <= least else middle
        axes.set_ylim(middle - half, middle + half)


def log_ticks(axis: Any) -> None:
    """Mark few powers of ten along a logarithmic axis, without numbers between."""
    axis.set_major_locator(LogLocator(numticks=6))
    axis.set_minor_locator(LogLocator(numticks=30))
    axis.set_minor_formatter(NullFormatter())


@dataclass(frozen=True)
class Look:
    """Choices of a caller about a figure; by default they are the figure's own.

    The width, for which the figure is drawn, is in inches; without titles, panels keep their
    letters.
    """

    width: float | None = None
    titled: bool = True
    file_format: str = ""

    def apply(self, figure: Figure) -> None:
        """Remove the titles of a finished figure where they are not wanted."""
        if not self.titled:
            for axes in figure.axes:
                letter = re.match(r"\([a-z]\)", axes.get_title(loc="left"))
                axes.set_title(letter.group() if letter else "", loc="left")
                axes.set_title("", loc="right")


def lay_out(figure: Figure) -> None:
    """Place the panels of a finished figure once, so that equal figures give equal files.

    The solver of the layout adds up in an order that changes from process to process. Places are
    therefore rounded, to a thousandth of a pixel, above what that changes.
    """
    engine = figure.get_layout_engine()
    if engine is None:
        return
    engine.execute(figure)
    figure.set_layout_engine("none")
    for axes in figure.axes:
        # Drawing makes the active place from the original one and the aspect of the panel.
        x, y, wide, high = axes.get_position(original=True).bounds
        axes.set_position((round(x, 6), round(y, 6), round(wide, 6), round(high, 6)))


def write_figure(figure: Figure, path: str | Path, look: Look | None = None) -> None:
    """Write a figure as PNG, SVG or PDF, as the suffix says: whole, or not at all.

    Equal figures give equal files: no date, no version, no random ids. The look has the last word
    on titles and format. InputError for another suffix, or a folder that cannot
    be written.
    """
    path, chosen = Path(path), look or Look()
    suffix = f".{chosen.file_format}" if chosen.file_format else path.suffix.lower()
    if suffix not in _METADATA:
        raise InputError(f"figure {path}: got {suffix!r}, need one of {', '.join(_METADATA)}.")
    chosen.apply(figure)
    with matplotlib.rc_context(STYLE):
        lay_out(figure)
        write_beside(path, lambda file: _print(figure, file, suffix))


def _print(figure: Figure, file: Any, suffix: str) -> None:
    """Draw a figure that is laid out to a file, once, where savefig would draw twice."""
    own_canvas, dpi, name = figure.canvas, figure.dpi, suffix[1:]
    canvas: Any = get_registered_canvas_class(name)(figure)
    try:
        getattr(canvas, f"print_{name}")(file, metadata=_METADATA[suffix])
    finally:
        figure.set_canvas(own_canvas)
        figure.dpi = dpi


def svg_text(figure: Figure, label: str, title: str = "") -> str:
    """Return a figure as an SVG element for a page; `label` keeps its ids apart from others'.

    The label is a word that no other figure of the page has, the title what a screen reader says.
    """
    text = io.StringIO()
    with matplotlib.rc_context(STYLE):
        lay_out(figure)
        _print(figure, text, ".svg")
    return inline_svg(text.getvalue(), label, title)


def inline_svg(text: str, label: str, title: str = "") -> str:
    """Return the text of an SVG file as an element for a page; see `svg_text`."""
    svg = text[text.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    prefix = re.sub(r"[^A-Za-z0-9]", "-", label)
    svg = re.sub(r'\bid="', f'id="{prefix}-', svg)
    svg = re.sub(r'href="#', f'href="#{prefix}-', svg).replace("url(#", f"url(#{prefix}-")
    name = escape(title or label)
    return svg.replace("<svg", f'<svg role="img" aria-label="{name}"', 1)


def save(figure: Figure, stem: Path, look: Look | None = None) -> tuple[Path, ...]:
    """Write a figure as PNG and SVG, as `write_figure` does; return the paths, PNG and SVG first.

    The stem is a path without suffix; a third format of the look is written besides the two.
    """
    chosen = look or Look()
    chosen.apply(figure)
    png, svg, other = (
        stem.with_name(f"{stem.name}.{suffix}") for suffix in ("png", "svg", chosen.file_format)
    )
    more = () if chosen.file_format in ("", "png", "svg") else (other,)
    for path in (*more, png, svg):
        write_figure(figure, path)
    return png, svg, *more
