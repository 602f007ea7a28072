"""Every command and every line of Python of the tutorials and how-to pages gives what is shown."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from painleve_sym.cli.texts import COMMANDS
from tests.site_pages import ROOT, Page, matches

DOCS = ROOT / "docs"
PAGES = sorted([*(DOCS / "tutorials").glob("*.md"), *(DOCS / "how-to").glob("*.md")])
PAGES.append(DOCS / "reference" / "cite.md")
SLOW = {"cluster", "fit"}
# Pages that show nothing to run.
TEXT = {"explorer", "newcomers-hour", "which-command"}


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(p, id=p.stem, marks=pytest.mark.slow if p.stem in SLOW else ())
        for p in PAGES
        if p.stem not in TEXT
    ],
)
def test_a_page_shows_what_its_commands_print(path, tmp_path, monkeypatch):
    if path.stem == "c-code" and not (shutil.which("cc") and shutil.which("c++")):
        pytest.skip("needs cc and c++")
    monkeypatch.chdir(tmp_path)
    page = Page(path, tmp_path)
    page.run()
    assert page.commands > 0


def test_pages_of_text_show_no_command():
    for path in PAGES:
        assert (path.stem in TEXT) == ("```console" not in path.read_text("utf-8") and
                                       "```python" not in path.read_text("utf-8"))  # fmt: skip


def test_other_output_is_noticed():
    assert matches("a\n...\nc\n", "a\nb\nb\nc\n")
    assert not matches("a\n...\nc\n", "a\nb\n")
    assert not matches("1.25\n", "1.26\n")


def test_table_of_questions_has_every_command():
    page = (DOCS / "how-to" / "which-command.md").read_text("utf-8")
    named = set(re.findall(r"`painleve (\w+)", page))
    assert named >= set(COMMANDS) - {"cache"}


def test_every_page_is_in_the_table_of_contents():
    index = (DOCS / "index.md").read_text("utf-8")
    listed = set(re.findall(r"^([\w/-]+)$", index, re.MULTILINE))
    pages = {
        p.relative_to(DOCS).with_suffix("").as_posix()
        for folder in (".", "tutorials", "how-to", "reference", "notebooks")
        for p in (DOCS / folder).glob("*.md")
    }
    assert pages - {"index"} <= listed
    assert all((Path(DOCS) / f"{name}.md").exists() for name in listed if "/" in name
               and not name.startswith(("gallery", "reference/api")))  # fmt: skip
