"""The check of the project's English, on planted offences."""

from __future__ import annotations

import pytest

from tools import prose

HABITS = prose.read_habits()
PLANTED = '''"""How numbers are kept."""

# The answer is no
# polygon.


class Run:
    """Steps of a run.

    The loop then goes
    on.
    """

    rate: float
    """Read anew in every step."""


def step(found):
    """Return the step."""
    if found:
        raise ValueError(f"the step {found} has no place here")
    wish = "softened"  # It may run for ever.
    return [many for many in wish]
'''


@pytest.fixture
def offences(tmp_path, monkeypatch):
    """Return a function that writes a file and gives line, scope and words of its offences."""
    monkeypatch.setattr(prose, "ROOT", tmp_path)

    def check(name, text):
        path = tmp_path / name
        path.write_text(text, "utf-8")
        lines = [m.split(":", 2) for m in prose.offences(path, HABITS)]
        return [
            (int(line), rest.split("'")[0].strip(), rest.split("'")[1]) for _, line, rest in lines
        ]

    return check


def test_planted_offences_in_python_are_noticed(offences):
    assert offences("planted.py", PLANTED) == [
        (1, "summary", "How"),
        (3, "text", "is no"),
        (10, "text", "goes on"),
        (15, "text", "anew"),
        (18, "name", "found"),
        (21, "text", "has no place"),
        (22, "name", "wish"),
        (22, "text", "for ever"),
        (23, "name", "many"),
    ]


def test_code_links_and_numbers_of_lines_in_pages(offences):
    page = (
        "# Title\n\n`anew` and [text](anew.md)\n\n```\nanew\n```\n\n``a ` anew``\nIt is no\nlaw.\n"
    )
    assert offences("page.md", page) == [(10, "text", "is no")]


def test_headings(offences):
    page = "# How it is built\n\n## How is it built?\n\n## Building\n"
    assert offences("page.md", page) == [(1, "summary", "How")]


def test_comments_of_c(offences):
    assert offences("code.c", "int anew; /* one\n * told */\n// so many\n") == [
        (2, "text", "told"),
        (3, "text", "so many"),
    ]


def test_allowed_lines_and_good_text(offences):
    page = "There is no law.\nIt is no longer there.\nThe text 'told' <!-- prose: allow -->\n"
    assert offences("page.md", page) == []


@pytest.mark.parametrize("habit", HABITS, ids=lambda habit: habit.avoid.pattern)
def test_better_words_are_given(habit):
    assert habit.use


def test_all_kinds_of_files_are_checked():
    checked = prose.files()
    assert {p.suffix for p in checked} >= {".py", ".md", ".c", ".toml", ".txt", ".yml"}
    assert prose.ROOT / "README.md" in checked
    assert prose.ROOT / "painleve_sym" / "__init__.py" in checked


def test_exit_code(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(prose, "ROOT", tmp_path)
    page = tmp_path / "page.md"
    page.write_text("It goes on.\n", "utf-8")
    monkeypatch.setattr("sys.argv", ["prose.py", str(page)])
    assert prose.main() == 1
    assert capsys.readouterr().out.startswith("page.md:1: text 'goes on': ")
    page.write_text("It continues.\n", "utf-8")
    assert prose.main() == 0
