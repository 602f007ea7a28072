"""`plot` with chosen quantities and in axes of one's own."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from matplotlib.figure import Figure

import painleve_sym as ps
from painleve_sym.errors import InputError


@functools.cache
def bounce():
    return ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 1.0}, t_end=0.2)


@functools.cache
def feet():
    start = {"y_A": 0.01, "theta": 0.02, "x_A_dot": 1.0}
    return ps.simulate("block-two-feet", "rigid", start, t_end=0.1)


def drawn(axes):
    """Return times and values of the only line of axes."""
    (line,) = axes.lines
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


def test_each_quantity_has_a_panel():
    figure = bounce().plot(["y_A", "normal_force", "theta_dot"])
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["$y_A$ (m)", "$F_n$ (N)", r"$\dot{\theta}$ (rad/s)"]
    assert [axes.get_xlabel() for axes in figure.axes] == ["", "", "time (s)"]
    for axes, name in zip(figure.axes, ("y_A", "normal_force", "theta_dot"), strict=True):
        times, values = drawn(axes)
        np.testing.assert_array_equal(values, bounce().values(name, times))
        assert times[0] == 0 and times[-1] == bounce().final_time


def test_several_axes_take_a_quantity_each_in_si_units():
    figure = Figure()
    grid = figure.subplots(2, 2)
    names = ("y_A", "theta", "gap", "normal_force")
    assert bounce().plot(names, ax=grid, color="red") is figure
    for axes, name in zip(grid.ravel(), names, strict=True):
        times, values = drawn(axes)
        np.testing.assert_array_equal(values, bounce().values(name, times))
        assert axes.lines[0].get_color() == "red" and axes.get_xlabel() == "time (s)"


def test_axes_that_are_shared_have_one_unit_and_a_legend():
    axes = Figure().subplots()
    bounce().plot("x_A_dot,y_A_dot", ax=axes)
    assert axes.get_ylabel() == "m/s"
    assert [t.get_text() for t in axes.get_legend().get_texts()] == ["x A dot", "y A dot"]
    bounce().plot("x_A_dot", ax=axes, label="again")
    assert len(axes.lines) == 3
    with pytest.raises(InputError, match="quantities of one unit, not of m, rad"):
        bounce().plot("y_A,theta", ax=axes)


@pytest.mark.parametrize(
    ("run", "labels"),
    [
        (bounce, ["normal force", "tangential force"]),
        (feet, ["normal force A", "normal force B"]),
    ],
)
def test_forces_are_drawn_in_axes_without_quantities(run, labels):
    axes = Figure().subplots()
    run().plot(ax=axes)
    assert [line.get_label() for line in axes.lines] == labels and axes.get_ylabel() == "N"


def test_a_figure_within_a_figure_is_the_whole():
    figure = Figure()
    left, _ = figure.subfigures(1, 2)
    assert bounce().plot("y_A", ax=left.subplots()) is figure


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"quantities": "thta"}, "unknown quantity 'thta'. Did you mean 'theta'"),
        ({"quantities": "run.png"}, r"to write a file, plot\(\).savefig"),
        ({"quantities": ()}, "got none"),
        ({"ax": "axes"}, "need axes of Matplotlib"),
        ({"ax": []}, "need axes of Matplotlib"),
        ({"quantities": "theta", "width": -1}, "a number > 0 of inches"),
    ],
)
def test_what_cannot_be_drawn_is_said(arguments, said):
    with pytest.raises(InputError, match=said):
        bounce().plot(**arguments)


def test_axes_and_quantities_are_as_many():
    axes = Figure().subplots(1, 3)
    with pytest.raises(InputError, match="got 3 axes and the quantities theta, y_A"):
        bounce().plot("theta,y_A", ax=axes)
    with pytest.raises(InputError, match="width: got 3, need none with axes"):
        bounce().plot("theta", ax=axes[0], width=3)
    ended = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 1.0}, t_end=0.1, record="end")
    with pytest.raises(InputError, match="holds no steps"):
        ended.plot("theta")


def test_a_map_is_drawn_in_axes_of_its_own():
    regions = ps.region_map("rod", ("theta", "theta_dot"), points=20)
    figure = Figure()
    left, right = figure.subplots(1, 2)
    assert regions.plot(ax=right) is figure
    assert not left.images and right.images[0].get_array().shape == (20, 20)
    assert "inconsistent" in " ".join(t.get_text() for t in right.get_legend().get_texts())
    for wrong in ({"ax": figure}, {"ax": right, "width": 3}):
        with pytest.raises(InputError, match="need axes of Matplotlib"):
            regions.plot(**wrong)
