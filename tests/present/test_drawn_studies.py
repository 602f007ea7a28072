"""Figures of studies are read by the labels of their axes: fits, derivatives, contrasts."""

from __future__ import annotations

import re

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgba

import painleve_sym as ps
from painleve_sym.papers.panels import Axis, Curve, Mark, Panel
from painleve_sym.present.figure_of_contrast import ASIDE, contrast_figure
from painleve_sym.present.figure_of_fit import fit_figure
from painleve_sym.present.figure_of_outcome import FILLS, NAMES, outcome_figure
from painleve_sym.present.figure_of_sensitivity import sensitivity_figure
from painleve_sym.present.figures import draw
from painleve_sym.study import FitResult
from tests.present.reading import assert_upright, drawn_values, legend_names
from tests.present.test_figure_words import ROD, outcomes


def fitted(times):
    measured = {"normal_force": np.array([1.0, 4.0, 2.0]), "theta": np.array([0.3, 0.1, 0.2])}
    model = {name: values + np.array([0.1, -0.3, 0.2]) for name, values in measured.items()}
    one = np.ones(1)
    return FitResult(
        names=("mu",),
        units=("1",),
        start=one,
        estimate=one,
        standard_error=one,
        interval=np.ones((1, 2)),
        level=0.95,
        freedom=2,
        correlation=np.ones((1, 1)),
        noise={"normal_force": 0.5, "theta": 0.05},
        noise_given=True,
        measured=measured,
        model=model,
        times=times,
        evaluations=3,
        condition=1.0,
        message="",
    )


UNITS = {"normal_force": "N", "theta": "rad"}


def test_a_fit_over_time_shows_data_model_and_what_is_between():
    times = np.array([0.0, 0.002, 0.005])
    result = fitted(times)
    figure = fit_figure(result, UNITS)
    assert_upright(figure)
    for k, (name, unit) in enumerate(UNITS.items()):
        history, residual = figure.axes[2 * k : 2 * k + 2]
        assert history.get_ylabel().endswith(f"({unit})")
        lines = {str(line.get_label()): line for line in history.lines}
        for label, values in (("measured", result.measured), ("fitted model", result.model)):
            np.testing.assert_allclose(lines[label].get_xdata(), times * 1e3)
            np.testing.assert_array_equal(lines[label].get_ydata(), values[name])
        points = residual.lines[-1].get_ydata()
        np.testing.assert_allclose(points, result.measured[name] - result.model[name])
        (band,) = residual.patches
        low, high = band.get_y(), band.get_y() + band.get_height()
        assert (low, high) == pytest.approx((-result.noise[name], result.noise[name]))
    assert figure.axes[-1].get_xlabel() == "time (ms)"


def test_a_fit_row_by_row_shows_the_model_over_the_data():
    result = fitted(None)
    figure = fit_figure(result, UNITS)
    assert_upright(figure)
    for axes, name in zip(figure.axes, UNITS, strict=True):
        points = next(line for line in axes.lines if line.get_marker() == "o")
        expected = np.stack([result.measured[name], result.model[name]], 1)
        np.testing.assert_array_equal(points.get_xydata(), expected)
        assert axes.get_xlabel().startswith("measured") and axes.get_ylabel().startswith("model")
        equal = next(line for line in axes.lines if line.get_label() == "equal")
        np.testing.assert_array_equal(equal.get_xdata(), equal.get_ydata())
        (bars,) = (s.get_segments() for c in axes.containers for s in c.lines[2])
        assert bars[0][1][0] - bars[0][0][0] == pytest.approx(2 * result.noise[name])


def test_derivatives_over_time_are_per_relative_change():
    simulator = ps.Simulator("rod", "bilinear-hertz")
    own = simulator.sensitivities(ROD, wrt="mu,m", t_end=3e-3)
    figure = sensitivity_figure(own, "theta_dot", "rate (rad/s)", {"m": "M"}, 1e-4)
    above, below = figure.axes
    (legend,) = figure.legends
    assert above.get_legend() is below.get_legend() is None
    assert "event" in [text.get_text() for text in legend.get_texts()]
    x = np.asarray(above.lines[0].get_xdata()) / 1e3
    assert x[0] == pytest.approx(1e-4, rel=0.1)
    np.testing.assert_allclose(above.lines[0].get_ydata(), own.trajectory.values("theta_dot", x))
    labels = {name: rf"$\{name}\,\partial/\partial \{name}$" for name in ("mu",)}
    labels["m"] = r"$M\,\partial/\partial M$"
    lines = {str(line.get_label()): line for line in below.lines}
    for k, name in enumerate(("mu", "m")):
        slopes = own.gradient("theta_dot", x)[:, k] * own.trajectory.parameters[name]
        np.testing.assert_allclose(lines[labels[name]].get_ydata(), slopes, rtol=1e-9, atol=1e-12)
    upright = [line for line in above.lines[1:] if len(set(line.get_xdata())) == 1]
    at = sorted({line.get_xdata()[0] / 1e3 for line in upright})
    np.testing.assert_allclose(at, sorted({e.event.time for e in own.events}))


def test_fills_of_an_outcome_map_lie_where_their_outcomes_are():
    given = outcomes()
    (axes,) = outcome_figure(given).axes
    assert_upright(outcome_figure(given))
    assert legend_names(outcome_figure(given))[0] in NAMES.values()
    borders = {
        "lifts_off": (given.forces[0], given.slip_stop),
        "stops_in_restitution": (given.slip_stop, given.compression),
        "stops_in_compression": (given.compression, given.forces[-1]),
    }
    for name, (low, high) in borders.items():
        colour = to_rgba(FILLS[name])
        (fill,) = (
            c
            for c in axes.collections
            if len(c.get_facecolor()) and tuple(c.get_facecolor()[0]) == colour
        )
        y = fill.get_paths()[0].vertices[:, 1]
        assert (y.min(), y.max()) == pytest.approx((np.min(low), np.max(high)))
    figure = outcome_figure(given)
    handles = dict(zip(legend_names(figure), figure.legends[0].legend_handles, strict=True))
    for name in borders:
        assert to_hex(handles[NAMES[name]].get_facecolor()) == FILLS[name].lower()
    limit = handles["$F_n^* = -B/A$"].get_color()
    (line,) = (line for line in axes.lines if line.get_color() == limit)
    np.testing.assert_array_equal(line.get_xydata(), np.stack([given.values, given.limit], 1))


def test_errors_of_a_contrast_stand_at_their_steps():
    result = ps.compare("rod", ROD, steps=(1e-3, 5e-4), stiffness=(2e13, 2e15), t_end=5e-3)
    figure = contrast_figure(result)
    assert_upright(figure)
    steps = figure.axes[2]
    shown = np.concatenate([line.get_xydata() for line in steps.lines])
    known = [a for a in result.stepping if a.error > 1e-9]
    assert known
    for answer in known:
        # Methods that agree stand side by side about the step, at their error.
        beside = shown[np.isclose(shown[:, 1], answer.error, rtol=0.02)]
        assert np.exp(np.log(beside[:, 0]).mean()) == pytest.approx(answer.setting)
        assert np.ptp(np.log(beside[:, 0])) <= 3.001 * np.log(ASIDE)
    labels = [str(line.get_label()) for line in figure.axes[0].lines]
    for answer in result.softened:
        mantissa, _, power = f"{answer.setting:e}".partition("e")
        text = next(label for label in labels if rf"10^{{{int(power)}}}" in label)
        line = next(own for own in figure.axes[0].lines if str(own.get_label()) == text)
        np.testing.assert_array_equal(line.get_ydata(), answer.contact_velocities[:, 0])
        assert float(mantissa) == 2.0 and re.search(r"2\s*\\", text)


def test_curves_and_marks_of_a_papers_figure_are_their_numbers():
    x = np.linspace(0, 2e-3, 5)
    curves = (Curve("one", x, 3e3 * x), Curve("other", x, 1 - x))
    marks = (Mark("slip_stop", 1e-3, 4.0), Mark("separation", 2e-3, 1.0))
    axes_of = {"x": Axis("time", "ms", 1e3), "y": Axis("force", "kN", 1e-3)}
    panel = Panel(curves=curves, marks=marks, **axes_of)
    (axes,) = draw([panel]).axes
    assert_upright(draw([panel]))
    lines = {str(line.get_label()): line for line in axes.lines}
    for curve in curves:
        t, force = drawn_values(axes, lines[curve.label])
        np.testing.assert_allclose(t, curve.x)
        np.testing.assert_allclose(force, curve.y)
    for mark, label in zip(marks, ("slip stops", "separation"), strict=True):
        t, force = drawn_values(axes, lines[label])
        assert (t[0], force[0]) == pytest.approx((mark.x, mark.y))
