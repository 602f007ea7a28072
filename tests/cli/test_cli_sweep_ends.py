"""The command sweep: failed points, errors before anything runs, interrupts."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from painleve_sym.cli import main
from painleve_sym.study.sweeps.store import Store
from painleve_sym.study.sweeps.sweep import Sweep

BELOW = """
title = "drops of the rod"
model = "rod"
t_end = 0.3
keep = ["y_A", "times_of_touchdown"]
events = 2
state = { theta = 1.5707963267948966 }
law = { name = "rigid" }
axes = { y_A = [-0.01, 0.01, 0.02], e_energetic = [0.2, 0.5] }
"""


@pytest.fixture
def file(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "drops.toml"
    path.write_text(BELOW)
    return path


def test_failed_points_are_counted_and_explained(file, capsys):
    assert main(["sweep", "drops.toml", "--out", "a.npz", "--threads", "1"]) == 0
    shown = capsys.readouterr()
    words = " ".join(shown.out.split())
    assert "ended by 4 t_end, 2 invalid_start" in words
    assert "invalid_start: the contact law does not admit the start" in words
    with np.load("a.npz") as data:
        assert data["times_of_touchdown"].shape == (3, 2, 2)


def test_json_has_the_documented_keys(file, capsys):
    assert main(["sweep", "drops.toml", "--out", "a.npz", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["stop_reasons"] == {"t_end": 4, "invalid_start": 2}
    assert data["quantities"]["times_of_touchdown"]["missing"] == 2
    assert data["quantities"]["count_of_touchdown"]["from"] == 0
    assert data["axes"] == {"y_A": "m", "e_energetic": "1"}


def test_points_that_start_with_a_past_are_counted_and_no_fault(file, capsys):
    """Two of six are pressed; their motions are sound ones of another start."""
    text = BELOW.replace('"rigid"', '"bilinear-hertz"').replace("0.3", "1e-6")
    axes = "y_A = [-1e-6, 0.0, 0.1], theta_dot = [0.0, 1.0]"
    text = text.replace("y_A = [-0.01, 0.01, 0.02], e_energetic = [0.2, 0.5]", axes)
    file.write_text(text)
    assert main(["sweep", "drops.toml", "--out", "a.npz", "--json", "--threads", "1"]) == 0
    data = json.loads(capsys.readouterr().out)
    (notice,) = data["notices"]
    assert notice.startswith("2 of 6 motions start with a contact pressed")
    assert data["open_balances"] == 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--out", "a.csv"), "need one of .nc, .npz, .zarr"),
        (("--out", "none/a.zarr"), "there is no such folder"),
        (("--threads", "0"), "--threads: got '0'"),
        (("--threads", "2", "--cluster", "local"), "leave out --threads or --cluster"),
        (("--cluster", "nowhere"), "need the address of a Dask scheduler"),
    ],
)
def test_bad_options_are_one_clear_error(file, capsys, options, message):
    assert main(["sweep", "drops.toml", *options]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
    assert [p.name for p in file.parent.iterdir()] == ["drops.toml"]


@pytest.mark.parametrize("where", ["chunks", "result"])
def test_an_interrupt_says_how_to_go_on(file, capsys, monkeypatch, where):
    def stop(*given):
        raise KeyboardInterrupt

    whole = ["sweep", "drops.toml", "--out", "a.npz", "--threads", "1"]
    with monkeypatch.context() as patch:
        patch.setattr(Store, {"chunks": "write", "result": "_write"}[where], stop)
        assert main(whole) == 130
    assert "a.npz.parts; the same command resumes there" in capsys.readouterr().err
    assert main(whole) == 0
    assert sorted(p.name for p in file.parent.iterdir()) == ["a.npz", "drops.toml"]


def test_an_interrupt_before_anything_is_written_promises_nothing(file, capsys, monkeypatch):
    def stop(sweep):
        raise KeyboardInterrupt

    monkeypatch.setattr(Sweep, "check_run", stop)
    assert main(["sweep", "drops.toml", "--out", "a.npz"]) == 130
    assert capsys.readouterr().err == "painleve: interrupted.\n"
