"""Every command and every line of Python of the tutorials and how-to pages gives what is shown."""

from __future__ import annotations

import doctest
import re
import shutil

import pytest

from painleve_sym.cli.commands import COMMANDS
from tests.site_pages import ROOT, Page, matches

DOCS = ROOT / "docs"
PAGES = sorted([*(DOCS / "tutorials").glob("*.md"), *(DOCS / "how-to").glob("*.md")])
PAGES += [DOCS / "reference" / "cite.md", DOCS / "install.md"]
SLOW = {"c-code", "cluster", "figure", "fit", "own-mechanism"}
# Pages on other libraries, by the module that they import.
LIBRARIES = {"drake": "pydrake", "fmu": "fmpy", "mujoco": "mujoco", "pinocchio": "pinocchio"}
# Pages that show nothing to run.
TEXT = {"explorer", "index", "newcomers-hour", "which-command"}


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
    if path.stem in LIBRARIES:
        pytest.importorskip(LIBRARIES[path.stem], reason="the page is on this library")
    monkeypatch.chdir(tmp_path)
    page = Page(path, tmp_path)
    page.run()
    assert page.commands > 0


EXAMPLES = sorted(p for p in DOCS.glob("*.md") if re.search(r"^>>> ", p.read_text("utf-8"), re.M))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_examples_of_a_page_print_what_it_says(path, monkeypatch):
    monkeypatch.chdir(ROOT)
    text = "\n".join(re.findall(r"^```python\n(.*?)^```", path.read_text("utf-8"), re.M | re.S))
    result = doctest.DocTestRunner(verbose=False)
    result.run(doctest.DocTestParser().get_doctest(text, {}, path.name, None, 0))
    assert result.tries > 3 and result.failures == 0


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


def test_every_page_is_in_a_table_of_contents():
    listed = set()
    pages = [p for p in DOCS.rglob("*.md") if "_generated" not in p.parts]
    pages = [p for p in pages if not p.is_relative_to(DOCS / "gallery") and p.parent.name != "json"]
    for page in pages:
        for body in re.findall(r"^```{toctree}\n(.*?)^```", page.read_text("utf-8"), re.M | re.S):
            names = re.findall(r"^([\w./-]+)$", body, re.M)
            listed |= {(page.parent / f"{name}.md").resolve() for name in names}
    derivations = set((DOCS / "derivations").glob("*.md"))
    assert {p.resolve() for p in pages} - derivations - {DOCS / "index.md"} <= listed
    others = {p for p in listed if not p.exists() and not p.with_suffix(".ipynb").exists()}
    assert others == {DOCS / "gallery" / "index.md"}
