"""Execution of what a page of the site shows: commands, files, Python."""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

from painleve_sym.cli import main

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


class Page:
    """A page whose blocks are executed from top to bottom in one folder.

    A block of TOML or C++ whose first line is a comment with a file name is written to that file.
    Lines of a ``console`` block that begin with ``$`` are run, and the lines below are what they
    print; ``...`` stands for lines left out. Blocks of Python are doctests, or programs that print
    the block of text below them.

    By default commands and Python run in this process, and what only a shell can do is left to
    one. With `programs`, the folder ``bin`` of an environment, everything runs in there.
    """

    def __init__(self, path: Path, folder: Path, programs: Path | None = None) -> None:
        self.path, self.folder, self.programs = path, folder, programs
        self.commands = 0
        if programs:
            self.environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"}
            return
        programs = folder / ".programs"
        programs.mkdir()
        program = programs / "painleve"
        program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m painleve_sym "$@"\n', "utf-8")
        program.chmod(0o755)
        (folder / "examples").symlink_to(ROOT / "examples")
        paths = {"PATH": f"{programs}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
        self.environment = {**os.environ, **paths}

    def run(self) -> None:
        """Execute every block; AssertionError where something else is printed."""
        examples: dict[str, object] = {}
        blocks = BLOCK.findall(self.path.read_text("utf-8"))
        for (language, body), (_, below) in zip(blocks, [*blocks[1:], ("", "")], strict=True):
            name = re.match(r"(?:#|//) ([\w-]+\.\w+)\n", body)
            if name:
                (self.folder / name[1]).write_text(body, "utf-8")
            elif language == "console":
                self.console(body)
            elif language == "python" and ">>>" in body:
                self.python(body, examples)
            elif language == "python":
                assert matches(below, self.program(body)), body
                self.commands += 1

    def console(self, body: str) -> None:
        """Run the commands of a block and compare what they print with the lines below each."""
        for command, shown in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", body, re.MULTILINE):
            plain = command.startswith("painleve ") and not re.search(r"[;|&<>$*]", command)
            if plain and not self.programs:
                status, printed = self.call(shlex.split(command)[1:])
            else:
                status, printed = self.shell(["bash", "-c", command])
            assert status == 0 or "painleve: error: " in shown, printed
            assert matches(shown, printed), f"{command}\n{printed}"
            self.commands += 1

    def shell(self, words: list[str]) -> tuple[int, str]:
        """Run a program in the page's folder; return its status and all it printed."""
        answer = subprocess.run(
            words,
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=600,
        )
        return answer.returncode, answer.stdout + answer.stderr

    def call(self, words: list[str]) -> tuple[int, str]:
        """Run a command of the package in this process."""
        printed, notices = io.StringIO(), io.StringIO()
        with (
            contextlib.chdir(self.folder),
            contextlib.redirect_stdout(printed),
            contextlib.redirect_stderr(notices),
        ):
            status = main(words)
        return status, printed.getvalue() + notices.getvalue()

    def program(self, body: str) -> str:
        """Return what a program of Python prints."""
        if self.programs:
            status, printed = self.shell([str(self.programs / "python"), "-c", body])
            assert status == 0, printed
            return printed
        output = io.StringIO()
        with contextlib.chdir(self.folder), contextlib.redirect_stdout(output):
            exec(compile(body, self.path.name, "exec"), {})
        return output.getvalue()

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
    """Return the words of a text, its numbers to ten digits and those below 1e-11 as 0.

    Columns are as wide as their numbers, so one blank stands for any number of them.
    """
    text = re.sub(r"\d+\.\d{8,}\b(?!e)", lambda number: f"{float(number[0]):.10g}", text)
    text = re.sub(r" +-?[\d.]+e-(?:1[2-9]|[2-9]\d)\b", " 0", text)
    return "".join(f"{' '.join(line.split())}\n" for line in text.splitlines())
