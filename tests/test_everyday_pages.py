"""Everyday mechanisms: each has a page, whose closed form agrees, and a film."""

from __future__ import annotations

import re

import pytest
from PIL import Image

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.mechanics.models import EVERYDAY
from tests.site_pages import ROOT, Page
from tools.figures import films

FOLDER = ROOT / "docs" / "everyday"
PAGES = {path.stem: path for path in FOLDER.glob("*.md") if path.stem != "index"}
FILMS = ROOT / "docs" / "figures" / "everyday"


def test_every_mechanism_has_a_page_and_a_card():
    index = (FOLDER / "index.md").read_text("utf-8")
    assert set(PAGES) == set(EVERYDAY)
    assert re.findall(r"^:link: (.*)$", index, re.M) == list(EVERYDAY)
    assert re.findall(r":img-top: \.\./figures/everyday/(.*)\.gif", index) == list(EVERYDAY)


@pytest.mark.parametrize("name", EVERYDAY)
def test_page_agrees_with_its_closed_form(name, tmp_path):
    page = Page(PAGES[name], tmp_path)
    page.run()
    assert page.commands > 2


@pytest.mark.parametrize("name", EVERYDAY)
def test_film_of_a_page_is_that_of_its_command(name):
    """The command draws the mechanism of the page; the film moves."""
    command = dict(films())[f"everyday/{name}.gif"]
    assert command.split()[:2] == ["animate", name]
    with Image.open(FILMS / f"{name}.gif") as film:
        assert film.n_frames > 20
        first = film.convert("RGB").tobytes()
        film.seek(film.n_frames // 2)
        assert film.convert("RGB").tobytes() != first


@pytest.mark.parametrize("name", EVERYDAY)
def test_file_has_the_name_of_the_mechanism(name):
    mechanism = model(name)
    assert mechanism.name == name and mechanism.title and mechanism.source
    assert mechanism.start, "a first command needs a state to begin with"
