"""Headless Chromium for tests of pages, and axe-core; `make setup-browser` installs both."""

from __future__ import annotations

import contextlib
import importlib.util
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)
AXE = Path(sys.prefix, "browser", "node_modules", "axe-core", "axe.min.js")
"""Where `make setup-browser` puts axe-core."""

MISSING = [
    name
    for name, there in (
        ("Chromium", CHROMIUM),
        ("the package playwright", importlib.util.find_spec("playwright")),
    )
    if not there
]
needs_chromium = pytest.mark.skipif(
    bool(MISSING), reason=f"{' and '.join(MISSING)} not installed: see `make setup-browser`"
)
needs_axe = pytest.mark.skipif(
    not AXE.is_file(), reason="axe-core is not installed: see `make setup-browser`"
)


@contextlib.contextmanager
def chromium() -> Iterator[Any]:
    """Start the browser, which is closed at the end."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        # In a container there is no user that its sandbox could take.
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield browser
        browser.close()


def violations(page: Any) -> list[str]:
    """Return what axe-core finds on a page: the rule, and the first elements that break it."""
    page.evaluate(AXE.read_text("utf-8"))
    faults = page.evaluate("axe.run()")["violations"]
    return [f"{v['id']}: {v['help']}: {[n['html'][:200] for n in v['nodes'][:3]]}" for v in faults]
