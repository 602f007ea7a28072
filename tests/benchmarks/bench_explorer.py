"""How large are explorer pages, and how long do they take to open and to map outcomes?

``python -m tests.benchmarks.bench_explorer`` writes the pages of all named mechanisms and opens
that of the rod in headless Chromium: from the request to the first complete drawing, one motion
with drawings after a change, and the map of 100 × 100 motions.
"""

from __future__ import annotations

import contextlib
import tempfile
from pathlib import Path
from typing import Any

from painleve_sym import explore
from painleve_sym.errors import CompilerMissing
from painleve_sym.mechanics.models import MODELS
from tests.browser import MISSING, chromium

MAX_BYTES = 400_000
MAX_OPEN = 2.0
MAX_CHANGE = 0.2
MAX_MAP = 1.0
"""Limits: bytes of the rod's page, seconds to open it, to follow a change, and to fill the map."""


def sizes() -> dict[str, int]:
    """Return the bytes of the page of every named mechanism that can be compiled here."""
    own = {}
    for name in MODELS:
        with contextlib.suppress(CompilerMissing):
            own[name] = len(explore(name).html.encode())
    return own


def opening(repeats: int = 5) -> dict[str, float]:
    """Return the least seconds until the rod's page is drawn, drawn again, and its map is full."""
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        path = Path(folder, "rod.html")
        explore("rod", out=path)
        times: dict[str, list[float]] = {"open": [], "change": [], "map": []}
        for _ in range(repeats):
            page = browser.new_page()
            page.goto(f"file://{path}")
            page.wait_for_selector("[data-ready]")
            times["open"].append(page.evaluate("performance.now() / 1000"))
            times["change"].append(page.evaluate(CHANGE) / 1000)
            page.locator("input[value=outcomes]").check()
            note = page.locator("[data-seconds]")
            times["map"].append(float(note.get_attribute("data-seconds") or "nan"))
            page.close()
    return {name: min(own) for name, own in times.items()}


CHANGE = """async () => {
  const slider = document.querySelector("input[aria-label*='(theta)']");
  const start = performance.now();
  slider.value = 400;
  slider.dispatchEvent(new Event("input"));
  await new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
  return performance.now() - start;
}"""


def measure() -> dict[str, Any]:
    """Print and return sizes and times, with their limits."""
    own = sizes()
    for name, size in own.items():
        print(f"{name:20} {size / 1000:6.0f} kB", flush=True)
    wanted = {"explorer page of the rod, bytes": {"measured": own["rod"], "at_most": MAX_BYTES}}
    if MISSING:
        print(f"explorer pages are not opened: {' and '.join(MISSING)} not installed")
        return {"bytes": own, "wanted": wanted}
    times = opening()
    print(", ".join(f"{name} {seconds:.3f} s" for name, seconds in times.items()), flush=True)
    limits = {"open": MAX_OPEN, "change": MAX_CHANGE, "map": MAX_MAP}
    for name, limit in limits.items():
        wanted[f"explorer of the rod: {name}, s"] = {"measured": times[name], "at_most": limit}
    return {"bytes": own, "seconds": times, "wanted": wanted}


if __name__ == "__main__":
    measure()
