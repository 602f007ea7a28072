"""Provenance of the numbers of a page: version, law, exponent and modes, in one line.

`python -m tools.provenance` writes the line between ``<!-- computed -->`` and
``<!-- /computed -->`` of every page in `PAGES`. A study keeps under ``computed`` the version of the
package, its contact law, the exponent n of a force K δⁿ, and the modes of elastic bodies.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tools.tables import written

ROOT = Path(__file__).parents[1]
STUDIES, FIGURES = Path("examples/studies"), Path("docs/figures")
PAGES: Mapping[str, tuple[Path, ...]] = {
    "docs/contact-solvers.md": (STUDIES / "peers" / "cone-dual.json",),
    "docs/corrected-jump.md": (FIGURES / "corrected-jump.json",),
    "docs/cost.md": (Path("docs/cost.json"),),
    "docs/critical-force.md": (FIGURES / "critical-force.json",),
    "docs/everyday/woodpecker.md": (FIGURES / "woodpecker.json",),
    "docs/experiments.md": (STUDIES / "bench_rod" / "bench-rod.json",),
    "docs/impacts.md": (FIGURES / "impact-energy.json",),
    "docs/numerics.md": (Path("docs/numerics.json"),),
    "docs/peers.md": (STUDIES / "peers" / "results.json",),
    "docs/reverse-chatter.md": (STUDIES / "reverse_chatter" / "growth.json",),
    "docs/rigid-rod.md": tuple(
        STUDIES / "rigid_rod" / name for name in ("landing.json", "rigid-rod.json")
    ),
    "docs/sensitivities.md": (FIGURES / "sensitive-impact.json",),
    "docs/several-contacts.md": (FIGURES / "sticking-feet.json",),
    "docs/singular-point.md": (STUDIES / "singular_point" / "fates.json",),
    "docs/tangential-compliance.md": (FIGURES / "tangential-compliance.json",),
    "paper/contact-solvers.md": (STUDIES / "peers" / "cone-dual.json",),
    "paper/elastic-bar.md": (STUDIES / "rigid_rod" / "landing.json",),
}
"""Page → the kept numbers that it shows."""
PACKAGE = "painleve-sym"


def computed(kept: Path) -> Mapping[str, Any]:
    """Return what the numbers of a file were computed with.

    Comparisons with other programs keep the version of each instead, ours among them where it took
    part, and name the laws with their numbers.
    """
    data = json.loads((ROOT / kept).read_text("utf-8"))
    if isinstance(data, list):
        versions = {r["program"]: r["version"] for r in data if "version" in r}
    elif "computed" in data:
        given: dict[str, Any] = data["computed"]
        return {"programs": {PACKAGE: given["version"]}, **given}
    else:
        versions = data["machine"]["versions"] if "machine" in data else data["versions"]
    own = {PACKAGE: versions[PACKAGE]} if PACKAGE in versions else versions
    return {"programs": own, "law": "named with the numbers"}


def line(page: str) -> str:
    """Return the line of a page."""
    parts = []
    for kept in PAGES[page]:
        given = computed(kept)
        words = [", ".join(f"{name} {version}" for name, version in given["programs"].items())]
        if "law" in given:
            n = f" (n = {given['n']:g})" if "n" in given else ""
            words.append(f"contact law: {given['law']}{n}")
        if "modes" in given:
            words.append(f"modes: {given['modes']}")
        parts.append(f"`{kept.name}`: {'; '.join(words)}")
    return f"*Computed with:* {'. '.join(parts)}."


def main() -> None:
    """Write the line into every page."""
    for page in PAGES:
        path = ROOT / page
        path.write_text(written(path.read_text("utf-8"), {"computed": line(page)}), "utf-8")


if __name__ == "__main__":
    main()
