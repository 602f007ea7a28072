"""Mechanism and law may have parameters of one name."""

import numpy as np
import pytest
import sympy as sp

import painleve_sym as ps
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text


def test_radius_of_a_drum_is_not_that_of_the_law():
    drum = renamed_disc("R")
    other = renamed_disc("radius")
    law = ps.laws.hertz(E=1e9, R=0.02)
    start = {"y_C": 0.31, "theta": 0.2}
    runs = [ps.simulate(m, law, start, t_end=0.05) for m in (drum, other)]
    assert {"R": 0.3, "R_law": 0.02}.items() <= runs[0].parameters.items()
    assert len(runs[0].events) >= 3
    for own, same in zip(runs[0].events, runs[1].events, strict=True):
        assert (own.kind, own.time) == (same.kind, same.time)
    np.testing.assert_array_equal(runs[0].final_state, runs[1].final_state)
    wider = ps.simulate(drum, "hertz", start, t_end=0.05, law_parameters={"R": 0.02, "E": 1e9})
    np.testing.assert_array_equal(wider.final_state, runs[0].final_state)
    moved = ps.simulate(drum, law, start, t_end=0.05, parameters={"R": 0.305})
    assert moved.parameters["R_law"] == 0.02 and moved.events[0].time < runs[0].events[0].time


def renamed_disc(radius):
    """Return a disc that falls on a plane, its radius a parameter of the name given."""
    x, y, angle = (
        ps.Coordinate("x_C", "centre, along", "m"),
        ps.Coordinate("y_C", "centre, above", "m"),
        ps.Coordinate("theta", "rotation", "rad"),
    )
    parameters = [
        ps.Parameter("m", 1.0, "kg", "mass", 0.0, lower_closed=False),
        ps.Parameter(radius, 0.3, "m", "radius of the disc", 0.0, lower_closed=False),
        ps.Parameter("g", 9.81, "m/s^2", "gravity", 0.0),
        ps.Parameter("mu", 0.4, "1", "friction", 0.0),
    ]
    m, r, g, mu = (p.symbol for p in parameters)
    inertia = sp.Rational(1, 2) * m * r**2
    system = ps.LagrangianSystem(
        "disc",
        (x, y, angle),
        tuple(parameters),
        m * (x.rate**2 + y.rate**2) / 2 + inertia * angle.rate**2 / 2,
        m * g * y.symbol,
    )
    contact = ps.Contact("A", system, y.symbol - r, x.rate + r * angle.rate, mu)
    return ps.Mechanism("disc", "falling disc", "test", system, (contact,))


def test_coefficient_of_a_rigid_law_must_be_told_from_that_of_the_mechanism():
    with pytest.raises(ps.InputError, match="the mechanism has the name 'e_energetic' too"):
        ps.Simulator(renamed_disc("e_energetic"), ps.laws.rigid())


def test_unknown_parameter_of_a_law_is_told():
    with pytest.raises(ps.InputError, match="law 'hertz': unknown parameter 'Q'"):
        ps.simulate("rod", "hertz", t_end=1e-3, law_parameters={"Q": 1.0})


ROD = """
name = "rod"
gravity = "g"
[coordinates]
s = {{ unit = "m", meaning = "tip, along" }}
{y} = {{ unit = "m", meaning = "tip, above" }}
{angle} = {{ unit = "rad", meaning = "angle" }}
[parameters]
m = {{ default = 1.0, unit = "kg", meaning = "mass", positive = true }}
l = {{ default = 1.0, unit = "m", meaning = "half length", positive = true }}
g = {{ default = 9.81, unit = "m/s^2", meaning = "gravity", lower = 0 }}
mu = {{ default = 2.0, unit = "1", meaning = "friction coefficient" }}
[[bodies]]
mass = "m"
inertia = "m*l**2/3"
angle = "{angle}"
centre = ["s + l*cos({angle})", "{y} + l*sin({angle})"]
[[contacts]]
name = "tip"
point = ["s", "{y}"]
friction = "mu"
"""


@pytest.mark.parametrize("names", [("n", "E"), ("R", "nu"), ("l_0", "e_energetic")])
def test_coordinates_may_have_the_names_of_a_laws_parameters(names):
    """The critical force, a motion and its derivatives are those of other names."""
    results = []
    for y, angle in [("y", "theta"), names]:
        rod = mechanism_from_text(ROD.format(y=y, angle=angle))
        state = {angle: 1.0, f"{angle}_dot": 5.0, "s_dot": -1.0}
        force = ps.critical_force(rod, "bilinear-hertz", state, law_parameters={"n": 1.6})
        start = {**state, y: 0.01}
        simulator = ps.Simulator(rod, "bilinear-hertz")
        run = simulator.run(start, t_end=0.05, law_parameters={"n": 1.6})
        slopes = simulator.sensitivities(start, [y, angle], t_end=0.05)
        results.append((force, run.final_state, slopes.final_jacobian))
    assert results[0][0].value == results[1][0].value
    for one, same in zip(*[r[1:] for r in results], strict=True):
        np.testing.assert_array_equal(one, same)
