"""Numbers and words of figures: axes' texts, units, limits, data, titles, legends, at any width."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from painleve_sym import PainleveWarning, load_mechanism, region_map, simulate
from painleve_sym.present import fonts
from painleve_sym.present.figure_of_contrast import contrast_figure
from painleve_sym.present.figure_of_map import FILLS, map_figure
from painleve_sym.present.figure_of_outcome import outcome_figure
from painleve_sym.present.figures import draw
from painleve_sym.present.fonts import make_legible
from painleve_sym.present.style import (
    COLUMN,
    NORMAL,
    PAGE,
    TALLEST,
    TANGENTIAL,
    fitted,
    show_above_rounding,
    styled,
    text_width,
    value_text,
)
from painleve_sym.problem.case_codes import LEGEND
from painleve_sym.study.comparisons.comparison import compare
from painleve_sym.study.critical.outcome_map import OutcomeMap
from tests.present.reading import assert_texts_apart, assert_texts_legible, legend_names, painted

ROD = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}


@pytest.fixture(scope="module")
def one():
    return simulate("rod", "bilinear-hertz", ROD, t_end=0.02)


@pytest.fixture(scope="module")
def two():
    return simulate("block-two-feet", "rigid", None, t_end=0.5)


@pytest.fixture(scope="module")
def regions():
    state = {"x_A_dot": -2.0, "y_A_dot": 0.5}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PainleveWarning)
        ranges = {"theta": (0.5, 1.4), "theta_dot": (-6.0, 4.0)}
        return region_map("rod", ("theta", "theta_dot"), ranges=ranges, points=41, state=state)


@pytest.fixture(scope="module")
def one_figure(one):
    return one.plot()


@pytest.fixture(scope="module")
def two_figure(two):
    return two.plot()


@pytest.fixture(scope="module")
def map_of_regions(regions):
    return map_figure(regions, PAGE)


@pytest.fixture(scope="module")
def comparison():
    return compare("rod", ROD, steps=(1e-3, 5e-4), stiffness=(2e13, 2e15), t_end=5e-3)


def outcomes(over="E", unit="Pa", values=(1e9, 9e9)) -> OutcomeMap:
    forces, given = np.linspace(0.0, 10.0, 21), np.linspace(*values, 5)
    stop = np.linspace(4.0, 5.0, 5)
    codes = (forces[:, None] > stop).astype(np.int8) + (forces[:, None] > stop + 2)
    return OutcomeMap(
        mechanism="rod", law="hertz", over=over, unit=unit, forces=forces, values=given,
        outcome=codes.astype(np.int8), limit=np.full(5, 4.0), predicted=stop + 20,
        slip_stop=stop, compression=stop + 2, state={}, parameters={},
    )  # fmt: skip


# ---- every figure of a command, in a column and on a page ----


@pytest.mark.parametrize(
    ("name", "width"),
    [
        *(("one", COLUMN), ("two", PAGE), ("regions", COLUMN)),
        *(("comparison", PAGE), ("outcomes", COLUMN)),
        *(pytest.param(n, PAGE, marks=pytest.mark.slow) for n in ("one", "regions", "outcomes")),
        *(pytest.param(n, COLUMN, marks=pytest.mark.slow) for n in ("two", "comparison")),
    ],
)
def test_texts_are_apart_and_inside_at_both_widths(name, width, request):
    subject = outcomes() if name == "outcomes" else request.getfixturevalue(name)
    figures = {"regions": map_figure, "comparison": contrast_figure, "outcomes": outcome_figure}
    figure = figures[name](subject, width) if name in figures else subject.plot(width=width)
    assert_texts_apart(painted(figure), name)
    assert_texts_legible(figure)
    assert figure.get_figwidth() == width and figure.get_figheight() <= TALLEST
    for legend in figure.legends:
        box = legend.get_window_extent()
        assert box.x0 >= 0 and box.x1 <= figure.bbox.width
        assert all(box.y1 <= axes.bbox.y0 for axes in figure.axes)


def test_column_has_its_magnified_panel_below_the_other(one, one_figure):
    column = one.plot(width=COLUMN)
    first, second = column.axes[:2]
    titles = [axes.get_title(loc="left") for axes in (first, second)]
    assert titles[0].startswith("rod,") and "magnified" in titles[1]
    column.canvas.draw()
    assert second.get_position().y1 < first.get_position().y0
    assert any("magnified" in axes.get_title(loc="left") for axes in one_figure.axes)


@pytest.mark.parametrize("count", [2, 3, 6])
def test_panels_of_a_paper_stand_below_each_other_in_a_column(count):
    from tests.present.test_figures import simple_panel

    figure = painted(draw([simple_panel()] * count, COLUMN))
    assert len({round(axes.bbox.x0) for axes in figure.axes}) == 1
    assert_texts_apart(figure, "column")


# ---- a motion ----


def grey(colour):
    """Return the lightness of a colour in CIELAB, 0 to 100."""
    rgb = [int(to_hex(colour)[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in rgb]
    return 116 * math.cbrt(np.dot([0.2126, 0.7152, 0.0722], linear)) - 16


def test_normal_and_tangential_force_differ_in_colour_grey_and_dashes(one_figure):
    normal, tangential = one_figure.axes[0].lines[:2]
    assert [normal.get_label(), tangential.get_label()] == ["$F_n$", "$F_t$"]
    assert (normal.get_color(), tangential.get_color()) == (NORMAL, TANGENTIAL)
    assert normal.get_linestyle() != tangential.get_linestyle()
    assert grey(TANGENTIAL) - grey(NORMAL) > 15
    # 3 : 1 against paper, as graphics need.
    assert grey(TANGENTIAL) < 62


def test_curves_of_a_motion_are_its_values_in_the_units_of_the_axes(one, one_figure):
    axes = {a.get_ylabel(): a for a in one_figure.axes}
    for label, name, factor in (
        ("$y_A$ (μm)", "y_A", 1e6),
        (r"$\dot{x}_A$ (m/s)", "x_A_dot", 1.0),
        (r"$\dot{\theta}$ (rad/s)", "theta_dot", 1.0),
    ):
        x, y = axes[label].lines[0].get_data()
        np.testing.assert_allclose(y, factor * one.values(name, np.asarray(x) / 1e3), rtol=1e-9)
    assert one_figure.axes[0].get_xlabel() == "time (ms)"
    times, forces = one_figure.axes[0].lines[0].get_data()
    own = one.values("normal_force", np.clip(np.asarray(times) / 1e3, 0, one.final_time))
    np.testing.assert_allclose(forces, own, rtol=1e-6, atol=1e-3 * np.abs(own).max())
    assert times[-1] == pytest.approx(1e3 * one.final_time)


def test_marks_stand_at_the_time_and_force_of_their_events(one, one_figure):
    marks = {line.get_label(): line for line in one_figure.axes[0].lines}
    (event,) = one.events_of("max_compression")
    np.testing.assert_allclose(
        marks["maximum compression"].get_xydata(), [[event.time * 1e3, event.normal_force]]
    )


def test_several_contacts_are_named_and_drawn_alike(two_figure):
    normal, tangential = two_figure.axes[:2]
    assert (normal.get_ylabel(), tangential.get_ylabel()) == ("$F_n$ (N)", "$F_t$ (N)")
    for axes in (normal, tangential):
        lines = axes.lines[:2]
        assert [line.get_label() for line in lines] == ["A", "B"]
        assert len({line.get_linewidth() for line in lines}) == 1
        assert len({line.get_color() for line in lines}) == 2
        assert len({str(line._dash_pattern) for line in lines}) == 2
    assert legend_names(two_figure)[:2] == ["A", "B"]


def test_rounding_is_drawn_as_a_flat_line(two, two_figure):
    assert 0 < abs(two.final["theta"]) < 1e-13
    axes = {a.get_ylabel(): a for a in two_figure.axes}
    for label in (r"$\theta$ (rad)", r"$\dot{\theta}$ (rad/s)"):
        low, high = axes[label].get_ylim()
        assert high == -low > 1e-3
    low, high = axes["$x_A$ (m)"].get_ylim()
    assert high - low < 1


@pytest.mark.parametrize(("size", "flat"), [(1e-14, True), (1e-11, False)])
def test_limits_are_those_of_the_scale_only_where_the_values_are_rounding(size, flat):
    axes = Figure().add_subplot()
    axes.plot([0, 1], [2.0, 2.0 + size])
    show_above_rounding(axes, 1.0)
    low, high = axes.get_ylim()
    assert (high - low > 0.1) == flat and low < 2.0 < high


def test_parabola_of_one_step_is_drawn_as_a_curve(two, two_figure):
    x, y = next(a for a in two_figure.axes if a.get_ylabel() == "$x_A$ (m)").lines[0].get_data()
    assert len(x) > 500
    np.testing.assert_allclose(y, two.values("x_A", x), rtol=1e-9, atol=1e-15)


# ---- maps ----


def test_axes_and_title_of_a_map_have_symbols_units_and_the_direction_of_slip(map_of_regions):
    axes = map_of_regions.axes[0]
    assert axes.get_xlabel() == r"$\theta$ (rad)"
    assert axes.get_ylabel() == r"$\dot{\theta}$ (rad/s)"
    assert axes.get_xlim() == (0.5, 1.4) and axes.get_ylim() == (-6.0, 4.0)
    assert axes.get_title(loc="left") == (
        r"rod, $v_t < 0$, $\mu = 1.4$, $\dot{x}_{A} = -2$ m/s, $\dot{y}_{A} = 0.5$ m/s"
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PainleveWarning)
        right = region_map("rod", ("theta", "mu"), points=5, slip=1)
    assert "$v_t > 0$" in map_figure(right).axes[0].get_title(loc="left")


def test_title_of_a_map_names_what_closes_the_contact():
    closed = region_map(
        "rod", ("theta", "mu"), points=5, state={"x_A_dot": -1.0, "y_A": 0.1}, close="y_A"
    )
    title = map_figure(closed).axes[0].get_title(loc="left")
    assert title.endswith("$y_{A}$ closes the contact") and "$y_{A} =" not in title


def test_picture_of_a_map_has_its_cases_in_their_colours_the_right_way_up(regions, map_of_regions):
    axes = map_of_regions.axes[0]
    (image,) = axes.images
    left, right, bottom, top = image.get_extent()
    cells = np.asarray(image.get_array())
    if image.origin == "upper":
        cells = cells[::-1]
    x, y = regions.values
    for i, j in ((3, 30), (20, 12), (35, 38), (1, 2)):
        column = int((x[i] - left) / (right - left) * cells.shape[1])
        row = int((y[j] - bottom) / (top - bottom) * cells.shape[0])
        assert cells[row, column] == regions.case[i, j]
        name = next(n for n, code in LEGEND.items() if code == regions.case[i, j])
        assert to_hex(image.cmap(image.norm(cells[row, column]))) == FILLS[name].lower()
    # A map is not symmetric: cases above and below differ somewhere.
    assert (regions.case != regions.case[:, ::-1]).any()


def test_legend_of_a_map_names_the_fills_that_occur(regions, map_of_regions):
    names = legend_names(map_of_regions)
    occurring = [n for n in regions.counts if regions.counts[n]]
    assert len([n for n in names if n not in ("flow of slip", "$A = B = 0$")]) == len(occurring)
    assert ("inconsistent: no solution" in names) == (regions.counts["inconsistent"] > 0)


@pytest.mark.parametrize(
    ("over", "unit", "values", "label", "ends"),
    [
        ("E", "Pa", (2e9, 9e9), "$E$ (GPa)", (2e9, 9e9)),
        ("y_A_dot", "m/s", (-3e-3, 2e-3), r"$\dot{y}_{A}$ (mm/s)", (-3e-3, 2e-3)),
    ],
)
def test_axes_of_an_outcome_map_have_units_and_limits(over, unit, values, label, ends):
    axes = outcome_figure(outcomes(over, unit, values)).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (label, "$F_{n0}$ (N)")
    assert axes.get_xlim() == ends and axes.get_ylim() == (0.0, 10.0)
    assert axes.get_title(loc="left") == "rod, hertz"
    shown = axes.xaxis.get_major_formatter()(ends[1], 0)
    assert float(shown) == pytest.approx(ends[1] * (1e-9 if unit == "Pa" else 1e3))


def test_lines_of_an_outcome_map_are_the_forces_and_only_those_shown_are_named():
    given = outcomes()
    figure = outcome_figure(given)
    critical = figure.axes[0].lines[0]
    np.testing.assert_array_equal(
        critical.get_xydata(), np.stack([given.values, given.slip_stop], 1)
    )
    names = legend_names(figure)
    assert {"critical force", "$F_n^* = -B/A$", "lift-off"} <= set(names)
    assert "closed form" not in names


# ---- a comparison ----


def test_panels_of_a_contrast_have_units_and_the_velocities(comparison):
    figure = contrast_figure(comparison)
    normal, slip, steps, stiffness = figure.axes
    assert [a.get_xlabel() for a in figure.axes] == [
        "$t$ (ms)", "$t$ (ms)", "step $h$ (s)", "modulus $E$ (Pa)",
    ]  # fmt: skip
    assert normal.get_ylabel() == r"$\dot{g}_N$ (m/s)" and slip.get_ylabel() == "$v_t$ (m/s)"
    answer = comparison.softened[0]
    for axes, column in ((normal, 0), (slip, 1)):
        drawn = next(line for line in axes.lines if "compliant" in str(line.get_label()))
        expected = np.stack([answer.times * 1e3, answer.contact_velocities[:, column]], 1)
        np.testing.assert_array_equal(drawn.get_xydata(), expected)
    errors = stiffness.lines[0].get_xydata()
    np.testing.assert_allclose(errors, [(a.setting, a.error) for a in comparison.softened])
    assert "order 1" in [t.get_text().replace("$", "") for t in steps.texts]


# ---- texts ----


def test_titles_break_between_their_parts_where_they_do_not_fit():
    parts = ["rod", "bilinear-hertz", "reload elastic"]
    assert fitted(parts, 7.0) == "rod, bilinear-hertz, reload elastic"
    lines = fitted(parts, 1.2).split("\n")
    assert len(lines) > 1 and " ".join(lines) == fitted(parts, 7.0)
    assert all(text_width(line, 9.0) < 1.2 for line in lines)


def test_values_have_symbols_and_units():
    assert value_text("x_A_dot", -1.0, "m/s") == r"$\dot{x}_{A} = -1$ m/s"
    assert value_text("mu", 1.4) == r"$\mu = 1.4$"


@styled
def titled(title):
    figure = Figure(figsize=(3, 1), layout="constrained")
    figure.add_subplot().set_title(title)
    return figure


ROD_FILE = "examples/mechanisms/rod.toml"


@pytest.fixture(scope="module")
def foreign(tmp_path_factory):
    text = (Path(__file__).parents[2] / ROD_FILE).read_text("utf-8")
    path = tmp_path_factory.mktemp("foreign") / "rod.toml"
    path.write_text(text.replace('"rod-from-file"', '"棒 5 $"'), "utf-8")
    return load_mechanism(str(path))


def test_name_in_another_script_has_a_font_or_one_clear_notice(foreign):
    run = simulate(foreign, "rigid", None, t_end=0.01)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        figure = painted(run.plot())
    title = figure.axes[0].get_title(loc="left")
    messages = [str(w.message) for w in caught]
    assert all("no installed font has '棒' (U+68D2)" in m for m in messages)
    assert ("棒" in title) == (not messages) and r"\$" in title


def test_name_in_another_script_beside_formulas_has_its_own_font(foreign, monkeypatch):
    monkeypatch.setattr(fonts, "_best_font", lambda letters: (fonts.FAMILY, letters))
    (axes,) = map_figure(region_map(foreign, ("theta", "mu"), points=5)).axes
    assert axes.get_title(loc="right") == r"棒 5 \$"
    assert axes.get_title(loc="left").startswith("$v_t < 0$")


def test_font_is_that_with_the_missing_letters(monkeypatch):
    monkeypatch.setattr(fonts, "_best_font", lambda letters: ("Some Font", letters))
    text = titled("棒 and more").axes[0]._left_title
    assert text.get_fontfamily() == ["Some Font", fonts.FAMILY]
    assert text.get_text() == "棒 and more"


def test_letter_that_no_font_has_is_named_once(monkeypatch):
    monkeypatch.setattr(fonts, "_best_font", lambda letters: (fonts.FAMILY, frozenset()))
    with pytest.warns(
        PainleveWarning, match=r"no installed font has '棒' \(U\+68D2\).*Fix:"
    ) as seen:
        figure = titled("棒 and 棒")
    assert len(seen) == 1
    assert figure.axes[0].title.get_text() == figure.axes[0].get_title() == ""
    assert figure.axes[0].get_title(loc="left") == "? and ?"


def test_text_with_letters_of_the_style_keeps_its_font():
    text = titled("rod μ").axes[0]._left_title
    before = text.get_fontfamily()
    make_legible(text)
    assert text.get_fontfamily() == before
