"""Raw CSV files: other separators, decimals and headers, and columns by formulas."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from painleve_sym.errors import InputError
from painleve_sym.mechanics.toml.mechanism_file import load_mechanism
from painleve_sym.study.fitting.data import read_fit_data
from painleve_sym.study.fitting.problem import fit
from tests.cli.cli_helpers import rejected, run_json

ROOT = Path(__file__).parents[2]
RAW = ROOT / "examples" / "studies" / "fit" / "rebounds.csv"
BALL = ROOT / "examples" / "mechanisms" / "dropped-ball.toml"
GERMAN = {"separator": ";", "decimal": ","}
FORM = {"skip": 2, **GERMAN}
COLUMNS = {"start y": "drop", "end y_dot": "sqrt(2*g*rebound)"}


def by_hand() -> tuple[float, float]:
    """Return e and its error of the line v = e u through the origin, u and v from the heights."""
    with RAW.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file, delimiter=";"))[3:]
    drop, rebound = (np.array([float(r[k].replace(",", ".")) / 100 for r in rows]) for k in (1, 2))
    u, v = np.sqrt(2 * 9.81 * drop), np.sqrt(2 * 9.81 * rebound)
    e = float(u @ v / (u @ u))
    return e, math.sqrt(float((v - e * u) @ (v - e * u)) / (len(u) - 1) / float(u @ u))


def test_restitution_of_fifty_rebounds_follows_from_their_heights():
    e, error = by_hand()
    assert (e, error) == pytest.approx((0.8832583, 0.0026486), rel=1e-5)
    fitted = fit(str(BALL), "rigid", RAW, "e_energetic", csv={**FORM, "columns": COLUMNS})
    assert fitted.estimate[0] == pytest.approx(e, rel=1e-9)
    assert fitted.standard_error[0] == pytest.approx(error, rel=1e-6)


def test_a_scenario_file_and_options_read_the_same_data(capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    wanted = ("--estimate", "e_energetic")
    of_file = run_json(capsys, "fit", RAW, RAW.with_suffix(".toml"), *wanted)
    form = ("--skip", "2", "--separator", ";", "--decimal", ",")
    columns = ("--column", "start y=c2/100", "--column", "end y_dot = sqrt(2*g*c3/100)")
    of_options = run_json(capsys, "fit", RAW, BALL, "--law", "rigid", *wanted, *form, *columns)
    assert of_file["estimates"][0]["estimate"] == pytest.approx(by_hand()[0], rel=1e-9)
    estimate = of_options["estimates"][0]["estimate"]  # rounded otherwise: c2/100 and drop in cm
    assert estimate == pytest.approx(by_hand()[0], rel=1e-9)
    rougher = run_json(capsys, "fit", RAW, RAW.with_suffix(".toml"), *wanted, "--set", "g=19.62")
    assert rougher["estimates"][0]["estimate"] == pytest.approx(by_hand()[0], rel=1e-9)


def read(tmp_path, text, columns=COLUMNS, **form):
    path = tmp_path / "raw.csv"
    path.write_text(text, "utf-8")
    return read_fit_data(path, load_mechanism(BALL), {"columns": columns, **form})


@pytest.mark.parametrize(
    ("text", "form"),
    [
        ("drop [m],rebound [m]\n0.65,0.5\n0.55,\n", {}),
        ("film\n\ndrop (mm);rebound (mm);\n650,0;500;\n;;\n550;;\n", {"skip": 1, **GERMAN}),
        ("drop\trebound\n0.65\t0.5\n0.55\t\n", {"separator": "tab"}),
        ("drop\trebound\n0.65\t0.5\n0.55\t\n", {"separator": "\t"}),
        ("  drop   rebound\n 0.65  0.5\n", {"separator": "space"}),
    ],
)  # fmt: skip
def test_one_table_is_read_from_several_ways_to_write_it(tmp_path, text, form):
    data = read(tmp_path, text, **form)
    assert data.starts["y"][0] == pytest.approx(0.65, rel=1e-15)
    assert data.measured["y_dot"][0] == pytest.approx(math.sqrt(9.81), rel=1e-15)
    assert np.isnan(data.measured["y_dot"][1:]).all() and data.count == 1


def test_a_file_without_header_has_its_columns_by_place(tmp_path):
    data = read(tmp_path, "0.65,0.5\n0.55,0.4\n", {"start y": "c1", "end y_dot": "-c2"})
    np.testing.assert_array_equal(data.measured["y_dot"], [-0.5, -0.4])


def test_a_name_has_the_unit_of_its_header_and_a_place_has_none(tmp_path):
    columns = {"start y": "drop", "end y_dot": "c1"}
    data = read(tmp_path, "drop (cm),rebound [mm]\n65,50\n", columns)
    assert (data.starts["y"][0], data.measured["y_dot"][0]) == (pytest.approx(0.65), 65.0)


def test_columns_that_no_formula_names_may_hold_anything(tmp_path):
    data = read(tmp_path, "day,drop,rebound\nMonday,0.65,0.5\n")
    assert data.count == 1


@pytest.mark.parametrize(
    ("text", "form", "said"),
    [
        ("drop;rebound\n0,65;0,5\n", {"separator": ";"}, "got '0,65'.*comma as the decimal sign"),
        ("drop;rebound\n1.065;0,5\n", GERMAN, "line 2, column drop: got '1.065'"),
        ("drop,rebound\n0.65,-0.5\n", {}, r"line 2: sqrt.*not a finite number at .*rebound = -0.5"),
        ("drop,rebound\n0.65,nan\n", {}, "line 2, column rebound: got 'nan', need a finite number"),
        ("drop,rebound\n0.65,0.5\n,0.4\n", {}, "line 3, column start y: got an empty cell.*Fix"),
        ("drop,drop,rebound\n1,2,3\n", {}, "drop may be column c1 or column c2. Fix: write c2"),
        ("drop,g,rebound\n1,2,3\n", {}, "g may be column c2 or a parameter. Fix: write c2"),
        ("drop [parsec2],rebound\n1,2\n", {}, "column drop .parsec2.: got the unit"),
        ("drop,hight\n1,2\n", {}, "unknown name 'rebound'"),
        ("drop,rebound\n1,2\n", {"separator": ":"}, "csv: separator: got ':', need one of ','"),
        ("drop,rebound\n1,2\n", {"decimal": ","}, "as the separator and as the decimal sign"),
        ("drop,rebound\n1,2\n", {"skip": -1}, "csv: skip: got -1, need a whole number"),
        ("drop,rebound\n1,2\n", {"skips": 1}, "Did you mean 'skip'"),
        ("drop,rebound\n1,2\n", {"columns": {"end y_dot": "__import__('os')"}}, "not allowed"),
        ("drop,rebound\n1,2\n", {"columns": {"end y_dott": "drop"}}, "Did you mean 'y_dot'"),
        ("drop,rebound\n1,2\n", {"skip": 9}, "got no rows"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_said_in_one_sentence(tmp_path, text, form, said):
    with pytest.raises(InputError, match=said):
        read(tmp_path, text, **form)


def test_an_estimated_parameter_is_no_constant_of_the_data(tmp_path):
    form = {**FORM, "columns": COLUMNS}
    with pytest.raises(InputError, match="unknown name 'g'"):
        fit(str(BALL), "rigid", RAW, ["e_energetic", "g"], csv=form)


def test_columns_of_a_data_frame_are_data():
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"start y": [0.65, 0.55], "end y_dot [mm/s]": [3100.0, np.nan]})
    data = read_fit_data(frame, load_mechanism(BALL))
    np.testing.assert_array_equal(data.measured["y_dot"], [3.1, np.nan])
    for wrong, said in (
        ({"start y": [0.65], "end y_dot": [1.0, 2.0]}, "different lengths"),
        ({"start y": ["a"]}, "need a list of finite numbers"),
        ({"start z": [1.0]}, "unknown quantity 'z'"),
    ):
        with pytest.raises(InputError, match=said):
            read_fit_data(wrong, load_mechanism(BALL))


def test_options_of_columns_are_checked(capsys):
    case = ("fit", RAW, BALL, "--law", "rigid", "--estimate", "e_energetic")
    assert "need NAME=FORMULA" in rejected(capsys, *case, "--column", "y_dot")
    assert "csv: separator" in rejected(capsys, *case, "--separator", "x")
