"""Properties of the whole process: imports, streams, signals, notices, exit codes."""

from __future__ import annotations

import errno
import io
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
from tests.cli.cli_helpers import LAW, ROOT, TABLE_3, process, rejected, run

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
    done = process("-m", "painleve_sym", "classify", "road")
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


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (("simulate", "rod", "--state", TABLE_3, *LAW, "--t-end", "1e-5", "--save"), "run.npz"),
        (("simulate", "rod", "--state", TABLE_3, *LAW, "--t-end", "1e-5", "--plot"), "run.png"),
        (("map", "rod", "--over", "theta,theta_dot", "--points", "5", "--out"), "map.npz"),
        (("map", "rod", "--over", "theta,theta_dot", "--points", "5", "--out"), "map.json"),
        (("map", "rod", "--over", "theta,theta_dot", "--points", "5", "--out"), "map.svg"),
    ],
)
def test_full_disk_names_the_file_that_cannot_be_written(
    capsys, monkeypatch, tmp_path, arguments, name
):
    _fill_the_disk(monkeypatch)
    code, out, err = run(capsys, *arguments, tmp_path / name)
    assert (code, out) == (1, "")
    assert err == f"painleve: error: {tmp_path / name}: No space left on device.\n"
    assert list(tmp_path.iterdir()) == []


def test_full_disk_names_the_file_of_a_report(capsys, monkeypatch, tmp_path):
    _fill_the_disk(monkeypatch)
    code, out, err = run(capsys, "reproduce", "--only", "fig-3", "--out", tmp_path / "report")
    assert (code, out) == (1, "")
    image = tmp_path / "report" / "figures" / "fig-3.png"
    assert err.endswith(f"painleve: error: {image}: No space left on device.\n")


@pytest.mark.slow
def test_figures_of_a_report_have_the_look_asked_for(capsys, tmp_path):
    look = ("--width", "10", "--title", "none", "--format", "pdf")
    code, _, err = run(capsys, "reproduce", "--only", "fig-3", "--out", tmp_path / "own")
    assert code == 0
    code, _, err = run(capsys, "reproduce", "--only", "fig-3", "--out", tmp_path / "new", *look)
    assert code == 0 and "report written" in err
    figures = {path.name: path for path in (tmp_path / "new" / "figures").iterdir()}
    assert set(figures) == {"fig-3.png", "fig-3.svg", "fig-3.pdf"}
    assert figures["fig-3.pdf"].read_bytes().startswith(b"%PDF")
    # Bytes 16 to 20 of a PNG are its width; 300 dpi.
    assert int.from_bytes(figures["fig-3.png"].read_bytes()[16:20]) == int(10 / 2.54 * 300)
    own = tmp_path / "own" / "figures"
    assert {path.name for path in own.iterdir()} == {"fig-3.png", "fig-3.svg"}
    assert (own / "fig-3.png").read_bytes() != figures["fig-3.png"].read_bytes()
    err = rejected(capsys, "reproduce", "--width", "wide")
    assert err.startswith("painleve: error: --width")


def _fill_the_disk(monkeypatch):
    class Full(io.BytesIO):
        def write(self, _):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("painleve_sym.files.open", lambda *_, **__: Full(), raising=False)


def test_error_without_a_file_does_not_blame_standard_output(capsys, monkeypatch):
    def fail(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("painleve_sym.cli.run_command", fail)
    assert run(capsys, "models") == (1, "", "painleve: error: No space left on device.\n")


CLOSED = {
    "bad": ("classify", "road"),
    "notice": ("simulate", "rod", "--state", TABLE_3, *LAW, "--t-end", "1e-5", "--json"),
    "progress": ("reproduce", "--only", "eq-1", "--json"),
}


@pytest.mark.parametrize(
    ("case", "code"),
    [("bad", 2), ("notice", 0), pytest.param("progress", 0, marks=pytest.mark.slow)],
)
def test_nothing_is_said_on_standard_output_where_standard_error_is_closed(case, code):
    done = subprocess.run(
        ["sh", "-c", 'exec "$@" 2>&-', "sh", sys.executable, "-m", "painleve_sym", *CLOSED[case]],
        stdout=subprocess.PIPE,
        text=True,
        # No compiler, for the notice.
        env={**os.environ, "PYTHONPATH": str(ROOT), "CC": "/nonexistent/cc"},
        timeout=120,
        check=False,
    )
    assert done.returncode == code
    assert "painleve:" not in done.stdout
    if code:
        assert done.stdout == ""
    else:
        json.loads(done.stdout)


def test_file_is_not_written_in_place_of_a_closed_standard_error(tmp_path):
    """A file opened first would take the number 2, and what C code says there would be in it."""
    code = (
        "import os; from painleve_sym.cli import _standard_error\n"
        f"with _standard_error(), open({str(tmp_path / 'f')!r}, 'w') as f: print(f.fileno())"
    )
    done = subprocess.run(
        ["sh", "-c", 'exec "$@" 2>&-', "sh", sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        timeout=120,
        check=True,
    )
    assert int(done.stdout) > 2


def test_every_exit_code_is_documented():
    import painleve_sym.cli as cli
    from painleve_sym.cli.run import EXIT_DOUBTFUL
    from painleve_sym.cli.texts import EXAMPLES

    page = (ROOT / "docs" / "cli.md").read_text("utf-8")
    own = {value for name, value in vars(cli).items() if name.startswith("EXIT_")}
    assert own == {1, 2, 130, 141}
    for exit_code in {0, EXIT_DOUBTFUL, *own}:
        assert f"\n| {exit_code} | " in page
        assert f" {exit_code} " in EXAMPLES.partition("exit codes:")[2]


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
