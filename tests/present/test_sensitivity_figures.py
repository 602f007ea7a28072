"""Figures of derivatives and of fits."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.motion.simulator import Simulator
from painleve_sym.present.figure_of_fit import fit_figure
from painleve_sym.present.figure_of_sensitivity import sensitivity_figure
from painleve_sym.present.style import save, write_figure
from painleve_sym.study.fitting.result import FitResult
from tests.support.paper_law import paper_law

STATE = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}


@functools.cache
def motion():
    simulator = Simulator(model("rod"), paper_law(reload="virgin"))
    return simulator.sensitivities(STATE, ("mu", "E"), parameters={"E": 20.9e14}, t_end=4.5e-4)


@pytest.mark.slow
def test_derivatives_are_drawn_per_relative_change_with_every_event(tmp_path):
    run = motion()

    def draw():
        return sensitivity_figure(run, "y_A_dot", "velocity (m/s)", {"mu": r"\mu"}, 3.95e-4)

    figure = draw()
    above, below = figure.axes
    events = len(run.events)
    # The legend hides no curve.
    assert above.get_legend() is None and below.get_legend() is None
    (legend,) = figure.legends
    assert "event" in [t.get_text() for t in legend.get_texts()]
    assert len(above.lines) == 1 + events and len(below.lines) == 2 + events
    times, drawn = below.lines[0].get_data()
    expected = 1.4 * run.gradient("y_A_dot", np.asarray(times) / 1e3)[:, 0]
    np.testing.assert_allclose(drawn, expected, rtol=1e-6, atol=1e-9)
    first, second = (save(draw(), tmp_path / n) for n in "ab")
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()


def result(times):
    values = np.array([1.0, 2.0, np.nan])
    return FitResult(
        names=("mu",), units=("1",), start=np.ones(1), estimate=np.ones(1),
        standard_error=np.ones(1), interval=np.array([[0.0, 2.0]]), level=0.95, freedom=1,
        correlation=np.eye(1), noise={"theta_dot": 0.1, "normal_force": 1.0}, noise_given=True,
        measured={"theta_dot": values, "normal_force": values},
        model={"theta_dot": values + 0.1, "normal_force": values}, times=times,
        evaluations=1, condition=1.0, message="",
    )  # fmt: skip


UNITS = {"theta_dot": "rad/s", "normal_force": "N"}


def test_a_history_is_drawn_over_time():
    figure = fit_figure(result(np.array([0.0, 1e-3, 2e-3])), UNITS)
    assert [a.get_ylabel() for a in figure.axes] == [
        r"$\dot{\theta}$ (rad/s)",
        "residual (rad/s)",
        "normal force (N)",
        "residual (N)",
    ]
    np.testing.assert_allclose(figure.axes[0].lines[0].get_xdata(), [0.0, 1.0, 2.0])


@pytest.mark.parametrize(
    "suffix", ["svg", *(pytest.param(s, marks=pytest.mark.slow) for s in ("png", "pdf"))]
)
def test_motions_row_by_row_are_drawn_against_the_data(tmp_path, suffix):
    path = tmp_path / f"fit.{suffix}"
    write_figure(fit_figure(result(None), UNITS), path)
    first = path.read_bytes()
    write_figure(fit_figure(result(None), UNITS), path)
    assert path.read_bytes() == first
    figure = fit_figure(result(None), UNITS)
    assert figure.axes[0].get_xlabel() == r"measured $\dot{\theta}$ (rad/s)"
