"""Properties of the whole process: imports, streams, signals, notices, exit codes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import warnings

import pytest

import painleve_sym
from painleve_sym.cli import main
from painleve_sym.errors import CompileError, PainleveWarning
from tests.cli.cli_helpers import LAW, ROOT, TABLE_3, process, run

HEAVY = ("casadi", "matplotlib", "numpy", "scipy", "sympy")


@pytest.mark.parametrize(
    "code",
    [
        "import painleve_sym",
        "import painleve_sym.cli",
        "from painleve_sym.cli import main; main(['--version'])",
        "from painleve_sym.cli import main; main(['simulate', '--help'])",
        "from painleve_sym.cli import main; main(['simulat'])",
    ],
)
def test_nothing_heavy_is_imported_before_it_is_needed(code):
    check = f"import sys; print([m for m in {HEAVY} if m in sys.modules])"
    done = process("-c", f"{code}\n{check}")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "[]"


def test_module_runs_as_a_command():
    done = process("-m", "painleve_sym", "classify", "rod", "--state", TABLE_3, "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["case"] == "inconsistent"
    assert done.stdout.endswith("}\n")


def test_module_returns_the_exit_code():
    done = process("-m", "painleve_sym", "classify", "rod")
    assert done.returncode == 2
    assert done.stdout == "" and done.stderr.count("\n") == 1


def test_version_and_help(capsys):
    assert run(capsys, "--version") == (0, f"{painleve_sym.__version__}\n", "")
    for arguments in ((), ("--help",), ("help",)):
        code, out, err = run(capsys, *arguments)
        assert (code, err) == (0, "")
        assert "commands:" in out and "exit codes:" in out
    code, out, _ = run(capsys, "help", "simulate")
    assert code == 0
    assert "step_limit" in out and "--law-set" in out


@pytest.mark.parametrize("command", ["", "classify", "simulate", "jump", "derive", "reproduce"])
def test_help_fits_80_columns(capsys, monkeypatch, command):
    monkeypatch.setenv("COLUMNS", "80")
    code, out, _ = run(capsys, *([command] if command else []), "--help")
    assert code == 0
    assert all(len(line) <= 80 for line in out.splitlines())


def test_broken_pipe_is_quiet():
    command = f"'{sys.executable}' -m painleve_sym laws --json | head -c 1; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(
        ["bash", "-c", command],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        timeout=120,
        check=False,
    )
    assert (done.stdout, done.stderr) == ("{", "")
    # 0 where everything fitted into the pipe before it closed.
    assert done.returncode in (0, 141)


def test_full_disk_is_one_line():
    if not os.path.exists("/dev/full"):
        pytest.skip("this system has no /dev/full")
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "painleve_sym", "laws"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            timeout=120,
            check=False,
        )
    assert done.returncode == 1
    assert done.stderr.startswith("painleve: error: standard output: ")
    assert done.stderr.count("\n") == 1


def test_output_survives_an_ascii_terminal():
    done = process("-m", "painleve_sym", "models", env={"PYTHONIOENCODING": "ascii"})
    assert (done.returncode, done.stderr) == (0, "")
    assert "Painlev\\xe9" in done.stdout


def test_interrupt_is_one_line_and_130():
    code = """
import signal, sys, time
import painleve_sym.cli as cli
def wait(_):
    print("ready", flush=True)
    time.sleep(60)
cli.run_command = wait
# A background job of a shell inherits an ignored SIGINT.
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.exit(cli.main(["models"]))
"""
    child = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "ready\n"
    child.send_signal(signal.SIGINT)
    _, err = child.communicate(timeout=60)
    assert (child.returncode, err) == (130, "painleve: interrupted.\n")


def test_interrupt_in_process_returns_130(capsys, monkeypatch):
    def interrupt(_):
        raise KeyboardInterrupt

    monkeypatch.setattr("painleve_sym.cli.run_command", interrupt)
    assert run(capsys, "models") == (130, "", "painleve: interrupted.\n")


def test_unexpected_error_is_one_line_and_1(capsys, monkeypatch):
    def fail(_):
        raise CompileError("compiler said:\n  no\n  space")

    monkeypatch.setattr("painleve_sym.cli.run_command", fail)
    assert run(capsys, "models") == (1, "", "painleve: error: compiler said: no space\n")


def test_notice_is_one_line_on_standard_error(capsys, monkeypatch):
    def notice(_):
        warnings.warn("slower\nengine.", PainleveWarning, stacklevel=1)
        return 0

    monkeypatch.setattr("painleve_sym.cli.run_command", notice)
    assert run(capsys, "models") == (0, "", "painleve: note: slower engine.\n")


def test_no_compiler_uses_the_other_engine_with_a_notice(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("CC", str(tmp_path / "none"))
    options = ("--state", TABLE_3, *LAW, "--t-end", "1e-5")
    code, out, err = run(capsys, "simulate", "rod", *options, "--json")
    assert code == 0
    assert json.loads(out)["engine"] == "erk"
    assert err.startswith("painleve: note: no working C compiler") and err.count("\n") == 1
    code, out, err = run(capsys, "simulate", "rod", *options, "--engine", "compiled")
    assert (code, out) == (1, "")
    assert err.startswith("painleve: error: no working C compiler") and err.count("\n") == 1


def test_main_takes_the_arguments_of_the_process(capsys, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["painleve", "--version"])
    assert main() == 0
    assert capsys.readouterr().out == f"{painleve_sym.__version__}\n"
