"""The gallery of the site: every script has a title, and every study in it a figure."""

from __future__ import annotations

import sys

import pytest

from tests.site_pages import ROOT


@pytest.fixture(scope="module")
def gallery():
    # Imported as Sphinx does.
    pytest.importorskip("sphinx_gallery")
    sys.path.insert(0, str(ROOT / "docs" / "_ext"))
    try:
        import gallery
    finally:
        sys.path.remove(str(ROOT / "docs" / "_ext"))
    return gallery


def test_scripts_are_staged_with_title_and_figure(gallery, tmp_path):
    gallery.stage(ROOT, tmp_path / "staged")
    scripts = {p.stem: p.read_text("utf-8") for p in (tmp_path / "staged").rglob("*.py")}
    assert {"classify_the_tables", "rigid_and_softened", "bench_rod", "rigid_rod"} <= set(scripts)
    for name, text in scripts.items():
        compile(text, name, "exec")
        quotes, line, question, below = text.split("\n")[:4]
        assert quotes == '"""' and line == below == "=" * len(question), name
        picture = gallery.PICTURES.get(name)
        if picture:
            assert (ROOT / picture).is_file()
            assert f".. image:: /../{picture}\n   :alt: {question}\n" in text
            assert text.endswith(f"# sphinx_gallery_thumbnail_path = '../{picture}'\n")
        else:
            assert "Figure(" in text or "region_map(" in text or ".plot(" in text, name


def test_every_study_has_a_picture_but_those_of_the_page_of_other_programs(gallery):
    studies = {p.stem for p in (ROOT / "examples" / "studies").rglob("*.py")}
    peers = {p.stem for p in (ROOT / "examples" / "studies" / "peers").glob("*.py")}
    # Its result is a table.
    without = {"robots"}
    assert studies - peers - without <= set(gallery.PICTURES) <= studies


def test_a_docstring_of_one_line_has_a_title_alone(gallery, tmp_path):
    script = tmp_path / "one.py"
    script.write_text('"""Is one line enough?"""\n\nprint(1)\n', "utf-8")
    text = gallery.staged(script, "docs/figures/x.png")
    compile(text, "one.py", "exec")
    assert text.startswith('"""\n===================\nIs one line enough?\n===================\n')
    assert ":alt: Is one line enough?\n" in text
