"""Figures as a reader meets them: legible, labelled, nothing on top of anything else."""

import re
from pathlib import Path

import numpy as np
import pytest

import painleve_sym
from painleve_sym.errors import InputError
from painleve_sym.papers.panels import FORCE, TIME_MS, Mark, Panel, line
from painleve_sym.papers.registry import reproduce
from painleve_sym.present.figures import draw
from painleve_sym.present.style import COLUMN, MARKERS, PAGE
from painleve_sym.quantities import axis_label, text_label
from tests.present.reading import assert_texts_apart, assert_texts_legible, painted

FIGURES = ("fig-2", "fig-4", "fig-8", "fig-10", "fig-12")


@pytest.fixture(scope="module")
def items():
    return reproduce(["figure"]).items


@pytest.fixture(scope="module")
def figures(items):
    return {i.id: (i, painted(draw(i.series))) for i in items if i.id in FIGURES}


@pytest.mark.parametrize("name", FIGURES)
def test_figure_is_labelled_legible_and_of_a_standard_width(figures, name):
    item, figure = figures[name]
    assert_texts_apart(figure, name)
    assert_texts_legible(figure)
    assert figure.get_size_inches()[0] == (COLUMN if len(item.series) == 1 else PAGE)
    for legend in figure.legends:
        top = legend.get_window_extent().y1
        assert all(top <= axes.bbox.y0 for axes in figure.axes)
    for letter, axes, panel in zip("abcdef", figure.axes, item.series, strict=False):
        assert f"({panel.x.unit})" in axes.get_xlabel()
        assert f"({panel.y.unit})" in axes.get_ylabel()
        if len(item.series) > 1:
            assert axes.get_title(loc="left").startswith(f"({letter})")
        (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
        for curve in axes.get_lines():
            x, y = np.asarray(curve.get_xdata()), np.asarray(curve.get_ydata())
            assert np.any((x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)) or len(x) == 2


@pytest.mark.slow
def test_texts_of_every_figure_are_apart_and_legible():
    for item in reproduce().items:
        if item.series is not None:
            figure = painted(draw(item.series))
            assert_texts_apart(figure, item.id)
            assert_texts_legible(figure)


def test_figure_marks_have_a_name_for_every_kind_used(items):
    kinds = {m.kind for i in items for p in i.series for m in p.marks}
    assert kinds <= set(MARKERS)


def simple_panel(**changes):
    times = np.linspace(0, 1e-3, 5)
    values = {"x": TIME_MS, "y": FORCE, "curves": (line("a", times, times),)} | changes
    return Panel(**values)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 6])
def test_draw_takes_one_to_six_panels(count):
    figure = draw([simple_panel()] * count)
    assert sum(axes.axison for axes in figure.axes) == count


@pytest.mark.parametrize("count", [0, 7])
def test_draw_refuses_another_number_of_panels(count):
    with pytest.raises(InputError, match="panels"):
        draw([simple_panel()] * count)


def test_draw_shows_units_scaled():
    figure = draw([simple_panel(marks=(Mark("solution", 5e-4, 5e-4),))])
    curve, mark = figure.axes[0].get_lines()
    assert curve.get_xdata()[-1] == pytest.approx(1.0)
    assert mark.get_xdata()[0] == pytest.approx(0.5)
    assert [t.get_text() for t in figure.legends[0].get_texts()] == ["a", "solution"]


def test_axis_labels_are_written_by_one_function():
    folder = Path(painleve_sym.__file__).parent / "present"
    by_hand = re.compile(r"""(?:set_[xy]label|set_label_text)\(\s*(?:r|f|rf)?["'][^"']*[\[(]""")
    faults = [path.name for path in folder.glob("*.py") if by_hand.search(path.read_text())]
    assert faults == []
    assert axis_label(r"\dot{\theta}", "rad/s") == r"$\dot{\theta}$ (rad/s)"
    assert axis_label(r"\mu") == axis_label(r"\mu", "1") == r"$\mu$"
    assert text_label("time", "ms") == "time (ms)"
