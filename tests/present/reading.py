"""Texts of figures as a reader sees them, and their places."""

from __future__ import annotations

import itertools
import re

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg

from painleve_sym.present.style import STYLE


def painted(figure):
    """Return the figure, laid out as a file of it is."""
    with matplotlib.rc_context(STYLE):
        FigureCanvasAgg(figure).draw()
    return figure


def legend_names(figure):
    return [t.get_text() for legend in figure.legends for t in legend.get_texts()]


def texts_of(figure):
    """Return every text that shows, with what it is."""
    texts = []
    for axes in figure.axes:
        low, high = axes.get_xlim(), axes.get_ylim()
        texts += [axes.xaxis.label, axes.yaxis.label, axes.title, axes._left_title, *axes.texts]
        for axis, (a, b) in ((axes.xaxis, low), (axes.yaxis, high)):
            inside = [t for t in axis.get_major_ticks() if min(a, b) <= t.get_loc() <= max(a, b)]
            texts += [tick.label1 for tick in inside]
    for legend in figure.legends:
        texts += legend.get_texts()
    return [t for t in texts if t.get_text() and t.get_visible()]


def assert_texts_apart(figure, name):
    boxes = [(t.get_text(), t.get_window_extent()) for t in texts_of(figure)]
    for (a, first), (b, second) in itertools.combinations(boxes, 2):
        # Half a pixel: boxes of neighbouring lines may touch.
        apart = (
            first.x1 <= second.x0 + 0.5
            or second.x1 <= first.x0 + 0.5
            or first.y1 <= second.y0 + 0.5
            or second.y1 <= first.y0 + 0.5
        )
        assert apart, f"{name}: {a!r} lies on {b!r}"


def assert_texts_legible(figure):
    width, height = figure.bbox.width, figure.bbox.height
    for text in texts_of(figure):
        box = text.get_window_extent()
        assert text.get_fontsize() >= 8, text.get_text()
        inside = box.x0 >= -0.5 and box.y0 >= -0.5
        assert inside and box.x1 <= width + 0.5 and box.y1 <= height + 0.5, text.get_text()


_PREFIXES = {"n": 1e-9, "μ": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}
_UNIT = re.compile(r"\(([^()]+)\)$")


def size_of(label):
    """Return what 1 of an axis with this label is in SI units, by the prefix of its unit."""
    match = _UNIT.search(label)
    unit = match[1] if match else ""
    head = unit.partition("/")[0]
    return _PREFIXES[head[0]] if len(head) > 1 and head[0] in _PREFIXES and head != "mol" else 1.0


def drawn_values(axes, line):
    """Return abscissas and ordinates of a line in SI units, by the labels of its axes."""
    x, y = (np.asarray(v, dtype=float) for v in line.get_data())
    return x * size_of(axes.get_xlabel()), y * size_of(axes.get_ylabel())


def assert_upright(figure):
    """Check that no axis of a figure runs downwards or from right to left."""
    for axes in figure.axes:
        for low, high in (axes.get_xlim(), axes.get_ylim()):
            assert low < high
