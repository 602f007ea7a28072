"""Progress on a terminal, and nowhere else."""

from __future__ import annotations

import io
import re
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import painleve_sym as ps
from painleve_sym.cli import main
from painleve_sym.errors import PainleveWarning
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.progress import progress, show_progress
from painleve_sym.study.sweeps.runner import run_sweep
from painleve_sym.study.sweeps.sweep import Sweep
from tests.study.sweep_cases import SMALL
from tests.test_escape import POINT


class Terminal(io.StringIO):
    """A stream that says that it is a terminal."""

    def isatty(self):
        return True


def terminal_of(monkeypatch):
    """Return a terminal in the place of standard error; not by a fixture, which comes too early."""
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    return stream


def shown(terminal):
    """Return the lines that a terminal showed one after the other."""
    return [line.strip() for line in re.split(r"[\r\n]", terminal.getvalue()) if line.strip()]


def test_progress_is_a_line_that_disappears(monkeypatch):
    terminal = terminal_of(monkeypatch)
    with show_progress(), progress("work", 4, "points", 1) as advance:
        advance(1)
        advance(2)
    assert shown(terminal)[0].startswith("painleve: work:  25%") and "1/4" in shown(terminal)[0]
    assert terminal.getvalue().endswith("\r") and "\n" not in terminal.getvalue().strip()


def test_nothing_is_shown_where_nobody_asks_or_there_is_no_terminal(monkeypatch):
    terminal = terminal_of(monkeypatch)
    with progress("work", 4) as advance:
        advance(1)
    assert terminal.getvalue() == ""
    file = io.StringIO()
    monkeypatch.setattr(sys, "stderr", file)
    with show_progress(), progress("work", 4) as advance:
        advance(1)
    assert file.getvalue() == ""


def test_name_of_a_mechanism_does_not_control_the_terminal(monkeypatch):
    terminal = terminal_of(monkeypatch)
    with show_progress(), progress("compiling \x1b[2J"):
        pass
    assert "compiling \\x1b[2J ..." in terminal.getvalue()


def test_first_run_says_that_it_derives_and_compiles(tmp_path, monkeypatch):
    terminal = terminal_of(monkeypatch)
    monkeypatch.setenv("PAINLEVE_CACHE", str(tmp_path / "cache"))
    point = mechanism_from_text(POINT.replace("[coord", "gravity = 9.8\n[coord"), name="point")
    options = {"t_end": 1e-4, "engine": "compiled"}
    with show_progress():
        ps.simulate(point, "linear", {"y": 0.1}, **options)
    texts = (
        "painleve: deriving point with linear ...",
        "painleve: compiling point with linear ...",
    )
    assert set(shown(terminal)) == set(texts)
    terminal.truncate(0)
    with show_progress():
        ps.Simulator(point, "linear", engine="compiled").run({"y": 0.1}, t_end=1e-4)
    assert "compiling" not in terminal.getvalue()


def test_sweeps_and_reproductions_show_what_is_done(tmp_path, monkeypatch):
    terminal = terminal_of(monkeypatch)
    with show_progress():
        run_sweep(Sweep.from_text(SMALL, "small.toml"), tmp_path / "a.npz")
        ps.reproduce(["eq-1", "eq-2"])
    lines = shown(terminal)
    assert any(re.search(r"sweep small\.toml: .* \d+/36 \[.* points/s\]", line) for line in lines)
    assert any(re.search(r"reproduce: .* \d/2 \[.* items/s\]", line) for line in lines)


@pytest.mark.parametrize("terminals", [True, False])
def test_command_shows_progress_on_a_terminal_alone(monkeypatch, terminals):
    stream = Terminal() if terminals else io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    assert main(["reproduce", "--only", "eq-1", "--json"]) == 0
    assert ("painleve: reproduce" in stream.getvalue()) == terminals
    assert terminals or stream.getvalue() == ""


def test_tqdm_is_loaded_for_a_terminal_alone():
    package = Path(ps.__file__).parent
    importing = [p for p in package.rglob("*.py") if re.search("(from|import) tqdm", p.read_text())]
    assert importing == [package / "progress.py"]
    code = "import sys; from painleve_sym.progress import progress, show_progress\n"
    code += "with show_progress(), progress('work', 1) as advance: advance(1)\n"
    code += "print('tqdm' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_notice_that_several_engines_have_is_said_once(monkeypatch, capsys):
    def repeat(arguments):
        for message in ("no compiler", "no compiler", "another"):
            warnings.warn(message, PainleveWarning, stacklevel=1)
        return 0

    monkeypatch.setattr("painleve_sym.cli.run_command", repeat)
    for _ in range(2):
        assert main(["models"]) == 0
        assert capsys.readouterr().err == "painleve: note: no compiler\npainleve: note: another\n"
