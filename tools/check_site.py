"""Check of the built documentation site in headless Chromium.

`python tools/check_site.py out/site` opens every page and reports errors on the console, broken
images, requests that leave the machine, pages that are wider than a phone, what axe-core finds
(accessibility), and words whose search does not lead to their page. It prints one line per fault
and exits with 1 if there are any. `--screenshots DIR` keeps pictures of some pages: light and dark,
on a desk and on a phone.
"""

from __future__ import annotations

import argparse
import functools
import shutil
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from playwright.sync_api import Browser, Page, TimeoutError, sync_playwright

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
PHONE, DESK = {"width": 390, "height": 844}, {"width": 1400, "height": 900}
AXE = Path(sys.prefix, "browser", "node_modules", "axe-core", "axe.min.js")
"""Where `make setup-browser` puts axe-core."""
# Pages of which pictures are kept.
PICTURED = (
    "index.html",
    "install.html",
    "tutorials/paradox.html",
    "tutorials/own-mechanism.html",
    "how-to/which-command.html",
    "how-to/own-w.html",
    "mechanisms.html",
    "reference/commands.html",
    "reference/json/simulate.html",
    "reference/api/Trajectory.html",
    "reference/named-mechanisms.html",
    "references.html",
    "impacts.html",
    "derivations/sticking.html",
    "gallery/index.html",
    "notebooks/lecture-on-the-paradox.html",
)
# Words that a reader looks for, and a page that is among the first results.
SEARCHES = {
    "restitution": "reference/laws.html",
    "Trajectory": "reference/api/Trajectory.html",
    "inconsistent": "reference/glossary.html",
    "install": "install.html",
    "URDF": "reference/glossary.html",
    "jam": "reference/glossary.html",
    "Zeno": "reference/glossary.html",
    "close": "reference/glossary.html",
}
FIRST = 8


class Handler(SimpleHTTPRequestHandler):
    """Serves files without a line per request."""

    def log_message(self, format: str, *args: object) -> None:
        """Print nothing."""


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve a folder on this machine; yield its address."""
    handler = functools.partial(Handler, directory=str(folder))
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        server.server_close()


def faults_of(page: Page, address: str, name: str) -> list[str]:
    """Open a page and return one line per fault."""
    faults: list[str] = []

    def watch_console(message: object) -> None:
        if message.type == "error":
            faults.append(f"{name}: console: {message.text}")

    def watch_request(request: object) -> None:
        if not request.url.startswith((address, "data:", "blob:")):
            faults.append(f"{name}: request leaves the machine: {request.url}")

    page.on("console", watch_console)
    page.on("pageerror", lambda error: faults.append(f"{name}: script: {error}"))
    page.on("request", watch_request)
    page.goto(f"{address}/{name}", wait_until="load")
    # Images below the fold are loaded when they are needed.
    page.evaluate("document.querySelectorAll('img').forEach(i => { i.loading = 'eager' })")
    page.wait_for_function("[...document.images].every(i => i.complete)", timeout=20_000)
    broken = "[...document.images].filter(i => i.naturalWidth == 0).map(i => i.src)"
    faults += [f"{name}: broken image {source}" for source in page.evaluate(broken)]
    silent = "[...document.querySelectorAll('article img')].filter(i => !i.alt).map(i => i.src)"
    faults += [f"{name}: image without a text {source}" for source in page.evaluate(silent)]
    width = page.evaluate("document.scrollingElement.scrollWidth")
    if width > PHONE["width"]:
        faults.append(f"{name}: {width} pixels wide on a phone of {PHONE['width']}")
    return faults


def accessibility_faults(page: Page, name: str) -> list[str]:
    """Return what axe-core finds on the open page, in light and the contrast in dark colours."""
    page.evaluate(AXE.read_text("utf-8"))
    violations = page.evaluate("axe.run()")["violations"]
    page.emulate_media(color_scheme="dark")
    violations += page.evaluate("axe.run({runOnly: ['color-contrast']})")["violations"]
    return [f"{name}: {v['id']}: {v['help']}: {v['nodes'][0]['html'][:120]}" for v in violations]


def search_faults(page: Page, address: str) -> list[str]:
    """Return a line for each word whose search does not lead to its page."""
    faults = []
    for word, wanted in SEARCHES.items():
        page.goto(f"{address}/search.html?q={word}")
        results = page.locator("#search-results ul.search li a")
        try:
            page.wait_for_function(
                "document.querySelector('.search-summary')?.textContent.includes('found')",
                timeout=15_000,
            )
        except TimeoutError:
            faults.append(f"search.html: no result for {word!r}")
            continue
        links = [link.get_attribute("href") or "" for link in results.all()[:FIRST]]
        if not any(link.partition("#")[0].endswith(wanted) for link in links):
            faults.append(f"search.html: {wanted} is not among the first for {word!r}: {links}")
    return faults


def take_pictures(browser: Browser, address: str, folder: Path) -> None:
    """Write a picture of the shown pages for each size of screen and colour scheme."""
    folder.mkdir(parents=True, exist_ok=True)
    for screen, viewport in (("desk", DESK), ("phone", PHONE)):
        for scheme in ("light", "dark"):
            context = browser.new_context(viewport=viewport, color_scheme=scheme)
            page = context.new_page()
            for name in PICTURED:
                page.goto(f"{address}/{name}", wait_until="load")
                page.wait_for_timeout(800)  # formulas are set after loading
                picture = name.replace("/", "-").removesuffix(".html")
                page.screenshot(path=folder / f"{picture}-{screen}-{scheme}.png")
            context.close()


def main() -> int:
    """Check the site named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("site", type=Path)
    parser.add_argument("--screenshots", type=Path, metavar="DIR")
    arguments = parser.parse_args()
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    if program is None:
        sys.exit("check_site: no Chromium. Fix: sudo apt install chromium")
    if not AXE.is_file():
        sys.exit("check_site: no axe-core. Fix: make setup-browser")
    with served(arguments.site) as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        names = pages_of(arguments.site)
        faults = page_faults(browser, address, names)
        faults += search_faults(browser.new_page(), address)
        if arguments.screenshots:
            take_pictures(browser, address, arguments.screenshots)
        browser.close()
    print(*faults, sep="\n", end="\n" if faults else "")
    print(f"{len(names)} pages, {len(SEARCHES)} searches, {len(faults)} faults")
    return 1 if faults else 0


def pages_of(site: Path) -> list[str]:
    """Return the pages of a site, as paths in its folder."""
    return sorted(p.relative_to(site).as_posix() for p in site.rglob("*.html"))


def page_faults(browser: Browser, address: str, names: list[str]) -> list[str]:
    """Return the faults of all pages, as a phone shows them."""
    faults: list[str] = []
    context = browser.new_context(viewport=PHONE)
    for name in names:
        page = context.new_page()
        faults += faults_of(page, address, name)
        faults += accessibility_faults(page, name)
        page.close()
    context.close()
    return faults


if __name__ == "__main__":
    sys.exit(main())
