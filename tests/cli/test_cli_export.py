"""The command export: its files, messages and errors."""

from __future__ import annotations

import os
import zipfile

import pytest

from tests.cli.cli_helpers import LAW, TABLE_3, run, run_json

ROD = ("export", "rod", "--state", TABLE_3)


def test_export_writes_the_folder_and_says_how_to_build(capsys, tmp_path):
    target = tmp_path / "a" / "rod-c"
    words = (*LAW, "--t-end", "1e-3", "--until", "separation", "--out", target)
    data = run_json(capsys, *ROD, *words, "--name", "my_rod")
    assert sorted(data["files"]) == sorted(os.listdir(target))
    assert set(data["files"]) == {
        *(f"my_rod_{part}" for part in ("model.h", "model.c", "contact.c")),
        *("main.c", "expected.txt", "CMakeLists.txt", "README.md"),
    }
    assert data["name"] == "my_rod" and data["folder"] == str(target)
    assert data["stop_reason"] == "t_end" and data["final_time"] == 1e-3
    assert "options.until[my_rod_event_separation] = 1;" in (target / "main.c").read_text("utf-8")
    code, out, err = run(capsys, *ROD, *words)
    assert (code, out) == (2, "") and "is not empty" in err
    code, out, err = run(capsys, "export", "rod", *LAW, "--out", tmp_path / "b")
    assert (code, err) == (0, "") and "cmake -B build && cmake --build build" in out
    assert all(len(line) <= 80 for line in out.splitlines() if "/" not in line)
    # Without --state: the mechanism's own start; without --t-end: 0.01 s.
    text = (tmp_path / "b" / "main.c").read_text("utf-8")
    assert "1.0,  /* theta: rad */" in text and "rod_default_options(p, x, 0.01, 1e-11" in text


def test_export_takes_a_scenario_file(capsys, tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(
        'model = "rod"\nt_end = 1e-4\nrtol = 1e-8\nmax_events = 7\nengine = "compiled"\n'
        'state = { theta = 1.0, x_A_dot = -1.0 }\n[law]\nname = "bilinear-hertz"\n'
        "parameters = { E = 1e12 }\n",
        "utf-8",
    )
    run_json(capsys, "export", path, "--out", tmp_path / "c")
    text = (tmp_path / "c" / "main.c").read_text("utf-8")
    for part in ("0.0001, 1e-08", "options.max_events = 7;", "1000000000000.0,  /* E: Pa */"):
        assert part in text


def test_export_writes_a_unit_for_co_simulation(capsys, tmp_path):
    file = tmp_path / "rod.fmu"
    words = (*ROD, *LAW, "--fmu", "--inputs", "mu", "--out", file)
    data = run_json(capsys, *words)
    assert data["fmi_version"] == "3.0" and data["inputs"] == ["mu"] and data["file"] == str(file)
    assert {"theta", "normal_force", "mode", "E"} <= set(data["variables"])
    with zipfile.ZipFile(file) as archive:
        assert b'fmiVersion="3.0"' in archive.read("modelDescription.xml")
    # A file that is there is replaced.
    code, out, err = run(capsys, *words, "--fmi", "2.0")
    assert (code, err) == (0, "") and "FMI 2.0" in out and "inputs: mu" in out
    with zipfile.ZipFile(file) as archive:
        assert b'fmiVersion="2.0"' in archive.read("modelDescription.xml")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((*ROD, *LAW), "--out"),
        ((*ROD, "--out", "new"), "no contact law"),
        ((*ROD, "--law", "bilinear-herz", "--out", "new"), "Did you mean 'bilinear-hertz'"),
        (("export", "rodd", *LAW, "--out", "new"), "Did you mean 'rod'"),
        ((*ROD, *LAW, "--out", "full"), "is not empty"),
        ((*ROD, *LAW, "--out", "full/file"), "is a file"),
        ((*ROD, *LAW, "--out", "full/file/new"), "cannot be written"),
        ((*ROD, *LAW, "--out", "/proc/new"), "cannot be written"),
        ((*ROD, *LAW, "--out", "new", "--name", "a b"), "name: got 'a b'"),
        ((*ROD, *LAW, "--out", "new", "--t-end", "-1"), "need a finite number > 0"),
        ((*ROD, *LAW, "--out", "new", "--until", "landing"), "unknown event 'landing'"),
        ((*ROD, *LAW, "--out", "new", "--law-set", "E=-1"), "need"),
        (("export", "painleve-klein", *LAW, "--out", "new"), "use the law rigid"),
        ((*ROD, *LAW, "--out", "new", "--inputs", "F"), "unknown parameter 'F'"),
        ((*ROD, *LAW, "--out", "new", "--fmi", "2.0"), "--fmi: needs --fmu"),
        ((*ROD, *LAW, "--out", "new.fmu", "--fmu", "--fmi", "1.0"), "unknown version of FMI"),
        ((*ROD, *LAW, "--out", "new.zip", "--fmu"), "need one of .fmu"),
        (("export", "rod-3d", *LAW, "--out", "new.fmu", "--fmu"), "in space"),
        (
            ("export", "rod", *LAW, "--engine", "erk", "--out", "new"),
            "need auto, taylor or compiled",
        ),
    ],
)
def test_export_refuses_in_one_sentence_and_writes_nothing(
    capsys, tmp_path, monkeypatch, words, message
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").write_text("mine")
    code, out, err = run(capsys, *words)
    assert (code, out) == (2, "")
    assert message in err and err.count("\n") == 1 and "Traceback" not in err
    assert os.listdir(tmp_path) == ["full"] and os.listdir(tmp_path / "full") == ["file"]
    assert (tmp_path / "full" / "file").read_text() == "mine"


def test_export_without_a_compiler_is_an_error_and_writes_nothing(capsys, tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "/nowhere/cc")
    code, out, err = run(capsys, *ROD, *LAW, "--out", tmp_path / "new")
    assert (code, out) == (1, "") and "no working C compiler" in err
    assert os.listdir(tmp_path) == []
