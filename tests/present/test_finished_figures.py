"""Figures of the commands: units, prefixes, marks that stay visible, borders, width and format."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from PIL import Image

from painleve_sym import simulate
from painleve_sym.__main__ import main
from painleve_sym.present.figure_of_outcome import _borders, outcome_figure
from painleve_sym.present.figures import draw
from painleve_sym.present.style import DPI, Look, write_figure
from painleve_sym.quantities import number_latex, scaled_unit
from painleve_sym.study.critical.outcome_map import OutcomeMap

IMPACT = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}


@pytest.fixture(scope="module")
def impact():
    return simulate("rod", "bilinear-hertz", IMPACT, t_end=0.02)


@pytest.mark.parametrize(
    ("unit", "largest", "expected"),
    [
        ("m", 3.5e-4, (1e6, "μm")),
        ("m", 0.02, (1e3, "mm")),
        ("m", 0.5, (1.0, "m")),
        ("m/s", 0.06, (1e3, "mm/s")),
        ("s", 4e-6, (1e6, "μs")),
        ("s", 2e-3, (1e3, "ms")),
        ("s", 1e-12, (1e9, "ns")),
        ("N", 2e4, (1e-3, "kN")),
        ("N", 900.0, (1.0, "N")),
        ("rad", 1e-5, (1.0, "rad")),
        ("N", 1.4e8, (1e-6, "MN")),
        ("Pa", 2e6, (1e-6, "MPa")),
        ("Pa", 2.1e11, (1e-9, "GPa")),
        ("kg m^2", 1e-5, (1.0, "kg m^2")),
        ("m", 0.0, (1.0, "m")),
        ("m", float("nan"), (1.0, "m")),
    ],
)
def test_prefix_suits_the_size(unit, largest, expected):
    assert scaled_unit(unit, largest) == expected


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (2.09e15, r"2.09\times 10^{15}"),
        (1e13, "10^{13}"),
        (-3e-5, r"-3\times 10^{-5}"),
        (0.001, "0.001"),
        (12.5, "12.5"),
        (9.999e8, r"10^{9}"),
    ],
)
def test_numbers_have_one_style(value, text):
    assert number_latex(value) == text


def _labels(figure: Figure) -> list[str]:
    texts = [a.get_xlabel() for a in figure.axes] + [a.get_ylabel() for a in figure.axes]
    return [t for t in texts if t]


def test_units_are_in_parentheses_with_prefixes(impact):
    labels = _labels(impact.plot())
    assert "time (ms)" in labels and "$y_A$ (μm)" in labels and "force (N)" in labels
    assert not any("[" in label for label in labels)


def test_events_close_together_have_a_panel_of_their_own(impact):
    figure = impact.plot()
    near = figure.axes[1]
    low, high = near.get_xlim()
    times = [e.time * 1e3 for e in impact.events]
    assert low < min(times) and max(times) < high
    assert high - low < 2 * (max(times) - min(times))
    assert near.get_title(loc="left") == f"time magnified {20 / (high - low):.0f} times"


def test_events_spread_over_the_motion_are_not_magnified(impact):
    last = impact.events[-1].time
    run = simulate("rod", "bilinear-hertz", IMPACT, t_end=1.05 * last)
    titles = [axes.get_title(loc="left") for axes in run.plot().axes]
    assert len(titles) == 7 and not any("magnified" in title for title in titles)


def test_event_names_are_words(impact):
    figure = impact.plot()
    names = {t.get_text() for legend in figure.legends for t in legend.get_texts()}
    assert "lift-off" in names and "liftoff" not in names


def test_force_jumps_upright_at_an_event():
    run = simulate(
        "rod", "rigid", {"theta": 1.0, "x_A_dot": -0.5}, t_end=0.6, parameters={"mu": 0.5}
    )
    line = run.plot().axes[0].lines[1]
    x, y = line.get_data()
    event = run.events_of("slip_stop")
    if not event:
        pytest.skip("the rod did not stop")
    jump = int(np.argmax(np.abs(np.diff(y))))
    assert x[jump + 1] - x[jump] < 1e-9


def test_marks_of_many_events_do_not_bury_the_curve():
    run = simulate("block-two-feet", "rigid", {"theta": 0.1}, t_end=1.5, parameters={"beta": 0.0})
    top = run.plot().axes[0]
    marks = [line for line in top.lines if line.get_marker() not in ("None", "", None)]
    assert all(len(line.get_xdata()) <= 12 for line in marks)
    assert {len(e) for e in map(run.events_of, {e.kind for e in run.events})} - set(range(13))


def _outcomes(**changes) -> OutcomeMap:
    values, forces = np.linspace(1.0, 2.0, 5), np.linspace(0.0, 10.0, 21)
    stop, compression = 3.0 + values, 5.0 + values
    codes = (forces[:, None] > stop).astype(np.int8) + (forces[:, None] > compression)
    given = {
        "mechanism": "rod", "law": "hertz", "over": "E", "unit": "Pa",
        "forces": forces, "values": values, "outcome": codes.astype(np.int8),
        "limit": np.full(5, 4.0), "predicted": stop, "slip_stop": stop,
        "compression": compression, "state": {}, "parameters": {},
    }  # fmt: skip
    return OutcomeMap(**(given | changes))


def test_each_colour_of_a_motion_has_one_meaning():
    from painleve_sym.present import style

    meanings = [
        *style.CONTACTS[1:],
        *(style.NORMAL, style.TANGENTIAL, style.SLIP, style.EVENT),
        *style.TICKS[1:-1],
    ]
    colours = {to_hex(colour) for colour in meanings}
    assert len(colours) == len(meanings)


def test_borders_of_outcomes_are_the_bisected_ones():
    outcomes = _outcomes()
    borders = _borders(outcomes)
    assert borders is not None
    assert (borders[0] == outcomes.slip_stop).all()
    assert (borders[1] == outcomes.compression).all()
    figure = outcome_figure(outcomes)
    fills = [c for c in figure.axes[0].collections if c.get_array() is None]
    assert len(fills) >= 3


def test_outcomes_that_disagree_with_borders_are_drawn_by_cells():
    odd = _outcomes().outcome.copy()
    odd[-1, 2] = 0
    assert _borders(_outcomes(outcome=odd)) is None
    assert len(outcome_figure(_outcomes(outcome=odd)).axes[0].collections) == 1


def test_column_without_a_critical_force_follows_its_runs():
    stop = _outcomes().slip_stop.copy()
    stop[0] = np.nan
    codes = _outcomes().outcome.copy()
    codes[:, 0] = 2
    both = {"slip_stop": stop, "compression": np.where(np.isnan(stop), np.nan, stop + 2)}
    borders = _borders(_outcomes(outcome=codes, **both))
    assert borders is not None and borders[0][0] == 0.0 == borders[1][0]


def test_marks_that_hide_each_other_have_an_inset():
    from painleve_sym.papers.panels import Axis, Curve, Mark, Panel

    x = np.linspace(0, 1, 2000)
    curve = Curve("", x, x**2)
    marks = (Mark("slip_stop", 0.8, 0.64), Mark("max_compression", 0.805, 0.648))
    panel = Panel(Axis("$t$", "s"), Axis("$F$", "N"), (curve,), marks)
    (axes,) = draw([panel]).axes
    (inset,) = axes.child_axes
    low, high = inset.get_xlim()
    assert low < 0.8 < 0.805 < high < 0.83
    apart = Panel(Axis("$t$", "s"), Axis("$F$", "N"), (curve,), (marks[0],))
    assert draw([apart]).axes[0].child_axes == []


def test_width_title_and_format(tmp_path, impact):
    path = tmp_path / "motion"
    write_figure(impact.plot(width=5.0), path, Look(titled=False, file_format="png"))
    with Image.open(path) as image:
        assert image.format == "PNG" and image.width == 5 * DPI
        assert round(image.info["dpi"][0]) == DPI == 300


def test_titles_leave_their_letters():
    figure = Figure()
    axes = figure.add_subplot()
    axes.set_title("(a) normal velocity", loc="left")
    Look(titled=False).apply(figure)
    assert axes.get_title(loc="left") == "(a)"


CALL = ["simulate", "rod", "--law", "rigid", "--t-end", "0.01", "--plot"]


def test_options_of_figures(tmp_path, capsys):
    out = tmp_path / "figure"
    assert main([*CALL, str(out), "--width", "10", "--title", "none", "--format", "png"]) == 0
    with Image.open(out) as image:
        assert abs(image.width - 10 / 2.54 * DPI) <= 1
    assert main([*CALL, str(tmp_path / "a.png"), "--width", "column"]) == 0
    with Image.open(tmp_path / "a.png") as image:
        assert image.width == round(3.4 * DPI)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--width", "wide"], "--width: got 'wide'"),
        (["--width", "1000"], "need column, page, or 3 to 60, in cm"),
        (["--title", "mine"], "--title: got 'mine', need none"),
        (["--format", "bmp"], "--format: unknown format 'bmp'"),
    ],
)
@pytest.mark.parametrize("command", ["simulate", "map", "critical", "contrast", "fit"])
def test_bad_options_of_figures_end_with_2(command, words, message, tmp_path, capsys):
    first = {
        "simulate": CALL[1:-1],
        "map": ["rod", "--over", "theta,theta_dot"],
        "critical": ["rod", "--over", "E=1e14:1e15"],
        "contrast": ["rod"],
        "fit": ["data.csv", "rod"],
    }[command]
    assert main([command, *first, *words]) == 2
    assert message in capsys.readouterr().err
