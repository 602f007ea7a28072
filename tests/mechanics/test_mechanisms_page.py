"""The page on mechanisms: what it shows runs, and its table is complete."""

from __future__ import annotations

import re
from pathlib import Path

from painleve_sym.mechanics.models import MODELS
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "mechanisms.md").read_text("utf-8")


def _blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


def test_page_lists_every_named_mechanism():
    assert set(re.findall(r"^\| `([a-z-]+)` \|", PAGE, re.MULTILINE)) >= set(MODELS)


def test_page_shows_a_file_that_can_be_read():
    text, quaternions = _blocks("toml")
    assert mechanism_from_text(text).contacts[0].name == "rim"
    example = ROOT / "examples" / "mechanisms" / "tumbling-brick.toml"
    for line in filter(None, quaternions.splitlines()):
        kept = re.sub(r' *#.*|"J_.*', "", line)
        assert kept in example.read_text("utf-8")


def test_page_shows_python_that_runs(capsys):
    _, code = _blocks("python")
    exec(compile(code, "docs/mechanisms.md", "exec"), {})
    assert capsys.readouterr().out == "slip\n"
