"""The check of the site finds what is wrong with a page."""

from __future__ import annotations

import pytest

from tests.browser import chromium, needs_axe, needs_chromium

GOOD = """<!doctype html><html lang="en"><head><title>Good</title>
<meta name="viewport" content="width=device-width"></head>
<body><main><h1>Good</h1><p>A page without a fault.</p></main></body></html>"""
BAD = {
    "an image without a text": ("<p>", '<img src="good.svg"><p>', "image-alt"),
    "a figure whose text is empty": (
        "<p>",
        '<article><img alt="" src="good.svg"></article><p>',
        "image without a text",
    ),
    "an image that is not there": ("<p>", '<img alt="x" src="none.png"><p>', "broken image"),
    "a page wider than a phone": ("<p>", '<p style="width: 800px">', "pixels wide"),
    "grey on grey": ("<p>", '<p style="color: #aaa">', "color-contrast"),
    "an address elsewhere": ("<p>", '<img alt="x" src="http://localhost:9/x.png"><p>', "leaves"),
}


@needs_chromium
@needs_axe
@pytest.mark.slow
def test_every_kind_of_fault_is_found_and_a_good_page_has_none(tmp_path):
    pytest.importorskip("playwright")
    from tools import check_site

    (tmp_path / "good.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>", "utf-8")
    (tmp_path / "good.html").write_text(GOOD, "utf-8")
    for name, (old, new, _) in BAD.items():
        (tmp_path / f"{name}.html").write_text(GOOD.replace(old, new), "utf-8")
    with check_site.served(tmp_path) as address, chromium() as browser:
        names = check_site.pages_of(tmp_path)
        faults = check_site.page_faults(browser, address, names)
    assert names == sorted(["good.html", *(f"{name}.html" for name in BAD)])
    for name, (_, _, fault) in BAD.items():
        assert any(line.startswith(f"{name}.html: ") and fault in line for line in faults), name
    assert [line for line in faults if line.startswith("good.html")] == []
