"""How every figure looks: one journal column or two, one palette, files that never change."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from painleve_sym.simulate.trajectory import write_beside

COLUMN, PAGE = 3.4, 7.0
"""Widths of one column and of the page; inch."""
DPI = 200
"""Resolution of the PNG: 680 or 1400 pixels wide."""

# Okabe & Ito (2008): told apart with any colour vision. The dashes tell them apart in grey.
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

MARKERS = {
    "slip_stop": ("v", "slip stops"),
    "slip_start": (">", "reverse slip starts"),
    "max_compression": ("D", "maximum compression"),
    "reload": ("^", "reload"),
    "yield": ("s", "yield"),
    "separation": ("o", "separation"),
    "solution": ("o", "solution"),
}
"""Marker and name of each kind of mark."""

STYLE: dict[str, Any] = {
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
    "axes.xmargin": 0.02,
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
    "legend.handlelength": 2.4,
    "legend.columnspacing": 1.4,
    "figure.dpi": DPI,
    "savefig.dpi": DPI,
    "svg.hashsalt": "painleve-sym",
    "svg.fonttype": "path",
    "path.simplify": True,
}


def save(figure: Figure, stem: Path) -> tuple[Path, Path]:
    """Write a figure as PNG and SVG beside the names, then rename; return both paths.

    Equal figures give equal files: no date, no version, no random ids.

    Parameters
    ----------
    figure : Figure
    stem : Path
        Path without suffix.

    Raises
    ------
    InputError
        The folder does not exist or cannot be written.
    """
    written = []
    for suffix, metadata in (("png", {"Software": None}), ("svg", {"Date": None})):
        buffer = io.BytesIO()
        figure.savefig(buffer, format=suffix, metadata=metadata)
        path = stem.with_name(f"{stem.name}.{suffix}")
        content = buffer.getvalue()
        write_beside(path, lambda f, content=content: f.write(content))
        written.append(path)
    return written[0], written[1]
