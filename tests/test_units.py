"""Values in other units than SI: converted where pint is there, else rejected in one sentence."""

from __future__ import annotations

import contextlib
import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import painleve_sym as ps
from painleve_sym.study import read_fit_data
from painleve_sym.units import factor, in_unit, is_quantity
from tests.cli.cli_helpers import rejected, run, run_json

CONVERTED = [
    ("30deg", "rad", math.pi / 6),
    ("-5 mm/s", "m/s", -0.005),
    ("200g", "kg", 0.2),
    ("209GPa", "Pa", 209e9),
    ("60 rpm", "rad/s", 2 * math.pi),
    ("12 deg/s", "rad/s", math.pi / 15),
    ("4 kN mm", "N m", 4.0),
    ("3 g·cm^2", "kg m^2", 3e-7),
    ("7 g^-1", "1/kg", 7000.0),
    ("20 percent", "1", 0.2),
    ("1e3 N*s/m", "N s/m", 1000.0),
]


@pytest.mark.parametrize(("text", "unit", "value"), CONVERTED)
def test_a_number_with_its_unit_becomes_si(text, unit, value):
    assert in_unit(text, unit, "x") == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("5 kg", "m"),
        ("5 Hz", "rad/s"),
        ("5 rad", "1"),
        ("20 degC", "K"),
        ("3 dB", "1"),
        ("1 foo", "m"),
        ("2 N", "what the law needs"),
        ("1e400 m", "m"),
        ("1e308 km", "m"),
        ("1e", "rad"),
        ("m", "m"),
        ("1 m; import os", "m"),
        ("__import__('os').system('false')", "m"),
        ("1 m**999999999", "m"),
        ("1 (m)", "m"),
        ("9" * 200 + " m", "m"),
        ("1 " + "m " * 40, "m"),
    ],
)
def test_what_is_no_unit_of_the_kind_is_refused_with_the_unit_needed(text, unit):
    with pytest.raises(ps.InputError, match=r"x: got .* need ") as caught:
        in_unit(text, unit, "x")
    assert len(str(caught.value)) < 300


@settings(max_examples=200)
@given(text=st.text(alphabet="0123456789.eE+-*/^ ()_[]{}'\";:,mkgsradNJ°μ\n", max_size=40))
def test_any_text_is_a_number_or_an_input_error(text):
    for convert in (in_unit, factor):
        with contextlib.suppress(ps.InputError):
            assert math.isfinite(convert(text, "m", "x"))


def test_states_and_parameters_take_texts_everywhere():
    state = {"theta": "30 deg", "theta_dot": "57.29577951308232 deg/s", "x_A_dot": "-1000 mm/s"}
    plain = {"theta": math.pi / 6, "theta_dot": 1.0, "x_A_dot": -1.0}
    own = ps.classify("rod", state, parameters={"m": "200 g"})
    assert own.state == pytest.approx({**own.state, **plain}, rel=1e-15)
    assert own.parameters["m"] == 0.2
    run = ps.simulate("rod", "hertz", state, t_end=1e-5, law_parameters={"E": "209 GPa"})
    same = ps.simulate("rod", "hertz", own.state, t_end=1e-5, law_parameters={"E": 209e9})
    assert run.final == same.final and run.parameters == same.parameters
    with pytest.raises(ps.InputError, match=r"state theta: got the unit \[kg\], need \[rad\]"):
        ps.classify("rod", {"theta": "1 kg"})
    with pytest.raises(ps.InputError, match=r"parameter m: got 'heavy', need a number in kg"):
        ps.classify("rod", parameters={"m": "heavy"})


def test_times_forces_and_ranges_take_texts_everywhere(tmp_path):
    run = ps.simulate("rod", "hertz", {"theta": 1.0}, t_end="0.01 ms", initial_force="5000 mN")
    same = ps.simulate("rod", "hertz", {"theta": 1.0}, t_end=1e-5, initial_force=5.0)
    assert run.final == same.final and run.final_time == 1e-5
    rows = ps.simulate_batch(
        "rod", "hertz", {"theta": "1 rad"}, t_end="10 us", max_step="1 us", initial_force="5 N",
        parameters={"m": "1000 g"},
    )  # fmt: skip
    assert float(rows["time"]) == pytest.approx(1e-5, rel=1e-15)
    mapped = ps.region_map(
        "rod", "theta,theta_dot", points=5, ranges={"theta": ("10 deg", "80 deg")}
    )
    np.testing.assert_allclose(mapped.values[0][[0, -1]], np.radians([10, 80]), rtol=1e-15)
    page = ps.explore("rod", t_end="5 ms", initial_force="2 N", law_parameters={"E": "3 GPa"})
    initial = page.data["initial"]
    assert (initial["end"], initial["force"], initial["values"]["E"]) == (0.005, 2.0, 3e9)
    state = {"theta": "1 rad", "theta_dot": "1 rad/s", "x_A_dot": "-1 m/s"}
    compared = ps.compare(
        "rod", state, solvers=("lemke",), stiffness=("2.09e15 Pa",), steps=("1 ms",), t_end="10 ms"
    )
    assert compared.t_end == 0.01 and compared.softened[0].setting == 2.09e15
    corrected = [
        ps.evaluate_corrected_jump("rod", "hertz", state, initial_force=f) for f in ("1 N", 1.0)
    ]
    assert corrected[0].velocity == corrected[1].velocity
    exported = ps.export_c("rod", "hertz", {"theta": 1.0}, folder=tmp_path / "c", t_end="10 us")
    assert exported.trajectory.final_time == pytest.approx(1e-5, rel=1e-15)
    assert ps.model("rod", m="200 g").parameters["m"] == 0.2
    assert ps.laws.hertz(E="3 GPa").parameters[0].default == 3e9
    for wrong in ({"t_end": "5 N"}, {"t_end": 1.0, "initial_force": "5 s"}):
        with pytest.raises(ps.InputError, match=r"got the unit \[[Ns]\], need \[[Ns]\]"):
            ps.simulate("rod", "hertz", {"theta": 1.0}, **wrong)
    with pytest.raises(ps.InputError, match=r"range theta: got '10:80', need two numbers"):
        ps.region_map("rod", "theta,theta_dot", ranges={"theta": "10:80"})


def test_a_fit_takes_texts():
    data = "examples/studies/fit/impacts.csv"
    texts = {"law_parameters": {"E": "209 GPa"}, "t_end": "1000 ms"}
    fitted = [
        ps.fit("rod", "bilinear-hertz", data, ["e_energetic"], **given)
        for given in (texts, {"law_parameters": {"E": 209e9}, "t_end": 1.0})
    ]
    np.testing.assert_array_equal(fitted[0].estimate, fitted[1].estimate)


def test_commands_take_units(capsys):
    words = ("--state", "theta=30deg,x_A_dot=-5 mm/s", "--set", "m=200g")
    data = run_json(capsys, "classify", "rod", *words)
    assert data["state"]["theta"] == pytest.approx(math.pi / 6)
    assert data["state"]["x_A_dot"] == -0.005 and data["parameters"]["m"] == 0.2
    law = ("--law", "hertz", "--law-set", "E=209GPa", "--t-end", "1e-5")
    assert run_json(capsys, "simulate", "rod", *words, *law)["parameters"]["E"] == 209e9
    mapped = ("map", "rod", "--over", "theta,theta_dot", "--points", "5", "--set", "m=200g")
    assert run_json(capsys, *mapped)["parameters"]["m"] == 0.2
    code, _, err = run(capsys, "classify", "rod", "--state", "theta=3mm")
    assert code == 2 and "--state theta: got the unit [mm], need [rad]" in err
    assert "unknown quantity 'angle'" in rejected(capsys, "classify", "rod", "--state", "angle=3mm")


def test_columns_in_other_units_are_converted(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("t [ms], x_A_dot [mm/s], theta [deg], normal_force [kN]\n1, 5, 180, 2\n")
    data = read_fit_data(path, ps.model("rod"))
    assert data.times is not None
    np.testing.assert_allclose(data.times, [0.001], rtol=1e-15)
    values = {name: float(v[0]) for name, v in data.measured.items()}
    expected = {"x_A_dot": 0.005, "theta": math.pi, "normal_force": 2000.0}
    assert values == pytest.approx(expected, rel=1e-15)
    path.write_text("t [s], x_A_dot [kg]\n1, 5\n")
    with pytest.raises(ps.InputError, match=r"column x_A_dot: got the unit \[kg\], need \[m/s\]"):
        read_fit_data(path, ps.model("rod"))


def test_without_pint_the_install_line_is_given(capsys, monkeypatch):
    from painleve_sym import units

    units._registry.cache_clear()
    monkeypatch.setitem(sys.modules, "pint", None)
    code, _, err = run(capsys, "classify", "rod", "--state", "theta=30deg")
    assert code == 2
    assert "pip install 'painleve-sym[units]'" in err and "in rad" in err
    assert run(capsys, "classify", "rod", "--state", "theta=1rad,theta_dot=2 rad/s")[0] == 0


def test_numbers_without_a_unit_never_import_pint():
    program = (
        "import sys; from painleve_sym.cli import main; "
        "main(['classify', 'rod', '--state', 'theta=1', '--set', 'm=2']); "
        "print('pint' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "False"


def test_a_quantity_is_a_number_and_a_unit():
    assert is_quantity("30deg") and is_quantity(" 5 mm/s")
    assert not any(map(is_quantity, ("30", "deg", "1e3", "nan", "inf", "0x10")))
