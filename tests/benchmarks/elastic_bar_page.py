"""Tables of the manuscript ``paper/elastic-bar.md``, from the kept numbers of its study."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from tools.tables import table, written

ROOT = Path(__file__).parents[2]
STUDY = ROOT / "examples" / "studies" / "elastic_bar"
RESULTS = STUDY / "elastic-bar.json"
PAGE = ROOT / "paper" / "elastic-bar.md"


def number(value: float) -> str:
    """Return a friction in print."""
    return f"{value:.4f}" if math.isfinite(value) else "none"


def tables(data: dict[str, Any]) -> dict[str, str]:
    """Return every table of the manuscript."""
    columns = {
        "cot θ": "cot",
        "mode coupling": "coupling",
        "landing, 1 m/s": "landing",
        "divergence, k of 9.8 N": "divergence",
        "divergence, rigid contact": "rigid_contact",
        "rigid rod, landing": "rigid_landing",
        "rigid rod, divergence": "rigid_rod",
    }
    angles = [row["theta"] for row in data["thresholds"]]
    thresholds = table(
        ("θ", *columns),
        [
            (f"{row['theta']}", *(number(row[name]) for name in columns.values()))
            for row in data["thresholds"]
        ],
    )
    head = [f"θ = {angle}" for angle in angles]
    speeds = [(f"{row['speed']:g}", *map(number, row["landing"])) for row in data["speeds"]]
    speeds.append(("divergence, rigid contact, 24,12", *map(number, data["limit"])))
    modes = [
        (f"{row['bending']},{row['axial']}", *map(number, row["landing"])) for row in data["modes"]
    ]
    belt = [
        (f"{row['theta']}", number(row["landing"]), number(row["rigid_landing"]))
        for row in data["belt"]
    ]
    return {
        "thresholds": thresholds,
        "speeds": table(("speed, m/s", *head), speeds),
        "modes": table(("modes", *head), modes),
        "belt": table(("θ", "bar", "rigid rod"), belt),
        "computed": f"Computed with painleve-sym {data['version']}.",
    }


def main() -> None:
    """Write the manuscript."""
    data = json.loads(RESULTS.read_text("utf-8"))
    PAGE.write_text(written(PAGE.read_text("utf-8"), tables(data)), "utf-8")


if __name__ == "__main__":
    main()
