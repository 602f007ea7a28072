"""Style of all figures: one or two journal columns, one palette, reproducible files."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from painleve_sym.errors import InputError
from painleve_sym.escape import html_text as escape
from painleve_sym.files import write_beside

_METADATA: dict[str, dict[str, Any]] = {
    # Neither a date nor a version.
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
COLUMN, PAGE = 3.4, 7.0
"""Widths of one column and of the page; inch."""
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
REFERENCE = "#7F7F7F"
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


# Any: the stubs of matplotlib type every key by name.
STYLE: Any = {
    # STIX comes with matplotlib and looks like a journal's text: the same on every machine.
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.titlepad": 4.0,
    "axes.linewidth": 0.6,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 5),
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


def log_ticks(axis: Any) -> None:
    """Mark few powers of ten along a logarithmic axis, without numbers between."""
    axis.set_major_locator(LogLocator(numticks=6))
    axis.set_minor_locator(LogLocator(numticks=30))
    axis.set_minor_formatter(NullFormatter())


@dataclass(frozen=True)
class Look:
    """Choices of a caller about a finished figure; by default they are the figure's own.

    The width is in inches, and the height keeps its share; without titles, panels keep their
    letters.
    """

    width: float | None = None
    titled: bool = True
    file_format: str = ""

    def apply(self, figure: Figure) -> None:
        """Change the figure."""
        if self.width is not None:
            own = figure.get_size_inches()
            figure.set_size_inches(self.width, own[1] * max(self.width / own[0], 0.75))
        if not self.titled:
            for axes in figure.axes:
                letter = re.match(r"\([a-z]\)", axes.get_title(loc="left"))
                axes.set_title(letter.group() if letter else "", loc="left")


def write_figure(figure: Figure, path: str | Path, look: Look | None = None) -> None:
    """Write a figure as PNG, SVG or PDF, as the suffix says: whole, or not at all.

    Equal figures give equal files: no date, no version, no random ids. The look replaces the width,
    titles and format of figure and suffix. InputError for another suffix, or a folder that cannot
    be written.
    """
    path, chosen = Path(path), look or Look()
    suffix = f".{chosen.file_format}" if chosen.file_format else path.suffix.lower()
    if suffix not in _METADATA:
        raise InputError(f"figure {path}: got {suffix!r}, need one of {', '.join(_METADATA)}.")
    chosen.apply(figure)
    options: dict[str, Any] = {"format": suffix[1:], "metadata": _METADATA[suffix]}
    with matplotlib.rc_context(STYLE):
        write_beside(path, lambda file: figure.savefig(file, **options))


def svg_text(figure: Figure, label: str) -> str:
    """Return a figure as an SVG element for a page; `label` keeps its ids apart from others'.

    The label is a word that no other figure of the page has, and the title of the element, too.
    """
    text = io.StringIO()
    with matplotlib.rc_context(STYLE):
        figure.savefig(text, format="svg", metadata=_METADATA[".svg"])
    return inline_svg(text.getvalue(), label)


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
    for path in more:
        write_figure(figure, path)
    # The canvases draw once each, where savefig would draw twice.
    with matplotlib.rc_context(STYLE):
        pixels: Any = FigureCanvasAgg(figure)
        write_beside(png, lambda file: pixels.print_png(file, metadata=_METADATA[".png"]))
        # Laid out once: the second file has the same places.
        figure.set_layout_engine("none")
        lines: Any = FigureCanvasSVG(figure)
        write_beside(svg, lambda file: lines.print_svg(file, metadata=_METADATA[".svg"]))
    return png, svg, *more
