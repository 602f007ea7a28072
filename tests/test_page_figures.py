"""Figures of the pages and of the gallery: their recipes, their texts, their sizes."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from PIL import Image

from tools import figures

ROOT = figures.ROOT
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
PICTURE = re.compile(r"!\[([^]]*)\]\(([^)]+\.(?:png|gif))\)")
RECIPES = {path for paths, _ in figures.recipes() for path in paths}


def shown():
    for page in PAGES:
        if "_generated" not in page.parts and "gallery" not in page.parts:
            for words, link in PICTURE.findall(page.read_text("utf-8")):
                yield words, (page.parent / link).resolve()


def test_every_committed_figure_has_a_recipe():
    kept = [p for p in (ROOT / "docs/figures").rglob("*") if p.suffix in (".png", ".gif")]
    kept += (ROOT / "examples/studies").rglob("*.png")
    assert {p.relative_to(ROOT) for p in kept} == RECIPES


def test_every_picture_of_a_page_exists_and_is_told_in_words():
    pictures = list(shown())
    assert len(pictures) > 20
    for words, path in pictures:
        assert path.is_file() and len(words.split()) >= 3, (words, path)


def test_figures_are_small_and_made_for_print():
    for path in RECIPES:
        assert (ROOT / path).stat().st_size < (300_000 if path.suffix == ".gif" else 200_000), path
        if path.suffix == ".png" and path.name not in figures.PAGES:
            with Image.open(ROOT / path) as image:
                assert image.width in (1020, 1260, 2100) and round(image.info["dpi"][0]) == 300


@pytest.mark.parametrize("name", figures.COMMANDS)
def test_commands_of_figures_are_those_of_the_pages(name):
    words = shlex.split(figures.COMMANDS[name])
    texts = " ".join(p.read_text("utf-8").replace("\\\n", " ") for p in PAGES)
    commands = [
        shlex.split(line) for line in re.findall(r"painleve (\w+ .*--(?:out|plot)) ", texts)
    ]
    assert words in commands


def test_a_png_in_few_colours_looks_the_same(tmp_path, monkeypatch):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(2, 1))
    figure.add_subplot().plot([0, 1], [0, 1], color="#D55E00")
    figure.savefig(tmp_path / "a.png", dpi=300)
    with Image.open(tmp_path / "a.png") as image:
        before = image.convert("RGB")
    monkeypatch.setattr(figures, "ROOT", tmp_path)
    figures.place(tmp_path / "a.png", Path("b.png"))
    with Image.open(tmp_path / "b.png") as image:
        after = image.convert("RGB")
        assert image.mode == "P" and round(image.info["dpi"][0]) == 300
    pairs = zip(before.tobytes(), after.tobytes(), strict=True)
    assert max(abs(a - b) for a, b in pairs) < 40
