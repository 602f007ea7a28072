"""Execution of what a page of the site shows: commands, files, Python."""

from __future__ import annotations

import doctest
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


class Page:
    """A page whose blocks are executed from top to bottom in one folder.

    A block of TOML or C++ whose first line is a comment with a file name is written to that file.
    Lines of a ``console`` block that begin with ``$`` are run by the shell, and the lines below are
    what they print; ``...`` stands for lines left out. Blocks of Python are doctests.
    """

    def __init__(self, path: Path, folder: Path) -> None:
        self.path, self.folder = path, folder
        programs = folder / ".programs"
        programs.mkdir()
        program = programs / "painleve"
        program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m painleve_sym "$@"\n', "utf-8")
        program.chmod(0o755)
        (folder / "examples").symlink_to(ROOT / "examples")
        paths = {"PATH": f"{programs}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
        self.environment = {**os.environ, **paths}
        self.commands = 0

    def run(self) -> None:
        """Execute every block; AssertionError where something else is printed."""
        examples: dict[str, object] = {}
        for language, body in BLOCK.findall(self.path.read_text("utf-8")):
            name = re.match(r"(?:#|//) ([\w-]+\.\w+)\n", body)
            if name:
                (self.folder / name[1]).write_text(body, "utf-8")
            elif language == "console":
                self.console(body)
            elif language == "python":
                self.python(body, examples)

    def console(self, body: str) -> None:
        """Run the commands of a block and compare what they print with the lines below each."""
        for command, shown in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", body, re.MULTILINE):
            answer = subprocess.run(
                ["bash", "-c", command],
                cwd=self.folder,
                env=self.environment,
                capture_output=True,
                text=True,
                timeout=300,
            )
            printed = answer.stdout + answer.stderr
            assert answer.returncode == 0 or "painleve: error: " in shown, printed
            assert matches(shown, printed), f"{command}\n{printed}"
            self.commands += 1

    def python(self, body: str, examples: dict[str, object]) -> None:
        """Run a doctest in the page's folder; names stay for the next block."""
        test = doctest.DocTestParser().get_doctest(body, examples, self.path.name, None, 0)
        runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
        outputs: list[str] = []
        runner.run(test, out=outputs.append, clear_globs=False)
        examples.update(test.globs)
        assert runner.failures == 0, "".join(outputs)
        self.commands += runner.tries


def matches(shown: str, printed: str) -> bool:
    """Return whether the lines shown are printed in this order; ``...`` stands for any lines."""
    parts = [without_round_off(part) for part in re.split(r"^\.\.\.\n", shown, flags=re.MULTILINE)]
    pattern = "(?:.*\n)*?".join(map(re.escape, parts))
    return re.fullmatch(pattern, without_round_off(printed)) is not None


def without_round_off(text: str) -> str:
    """Return a text without blanks at line ends, and with round-off below 1e-18 replaced by 0."""
    text = re.sub(r" +-?[\d.]+e-(?:1[89]|[2-9]\d)$", " 0", text, flags=re.MULTILINE)
    return "".join(f"{line.rstrip()}\n" for line in text.splitlines())
