"""``--print-completion``, and the commands that show one mechanism or law."""

from __future__ import annotations

import shutil
import subprocess
import sys

import pytest

from painleve_sym.cli.commands import COMMANDS
from tests.cli.cli_helpers import rejected, run, run_json


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_completion_knows_every_command_and_its_options(capsys, shell):
    code, out, err = run(capsys, "--print-completion", shell)
    assert (code, err) == (0, "")
    for name in (*COMMANDS, "close", "law-set", "print-completion"):
        assert name in out


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_bash_completes_an_option_of_a_command(capsys):
    _, script, _ = run(capsys, "--print-completion", "bash")
    asked = (
        "COMP_WORDS=(painleve classify --cl); COMP_CWORD=2; _shtab_painleve; echo ${COMPREPLY[@]}"
    )
    done = subprocess.run(["bash", "-c", f"{script}\n{asked}"], capture_output=True, text=True)
    assert done.stdout.strip() == "--close"


def test_without_shtab_the_install_line_is_given(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert "pip install 'painleve-sym[completion]'" in rejected(
        capsys, "--print-completion", "bash"
    )


def test_one_mechanism_one_law_and_one_rule_are_shown_alone(capsys):
    every = {m["name"]: m for m in run_json(capsys, "models")["models"]}
    assert run_json(capsys, "models", "strut") == {"models": [every["strut"]]}
    _, out, _ = run(capsys, "models", "examples/mechanisms/bead-in-groove.toml")
    assert out.startswith("bead-in-groove: ") and "pr-robot" not in out
    laws = run_json(capsys, "laws")
    (hertz,) = (one for one in laws["laws"] if one["name"] == "hertz")
    assert run_json(capsys, "laws", "hertz") == {"laws": [hertz], "restitution_rules": []}
    _, out, _ = run(capsys, "laws", "poisson")
    assert "e_poisson" in out and "energetic" not in out
    assert run(capsys, "laws", "hert")[0] == run(capsys, "models", "rood")[0] == 2
