"""Tables of the manuscript ``paper/elastic-bar.md``, from the kept numbers of landings."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from painleve_sym.tables import markdown_table as table
from tools.tables import written

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "examples" / "studies" / "rigid_rod" / "landing.json"
PAGE = ROOT / "paper" / "elastic-bar.md"
Rows = Sequence[Mapping[str, Any]]


def _table(columns: Mapping[str, str], rows: Rows, form: str = ".4f") -> str:
    """Return a table whose first column has its numbers as they are, as texts are."""
    first, *others = columns.values()
    lines = [
        (f"{row[first]}", *(v if isinstance(v := row[n], str) else format(v, form) for n in others))
        for row in rows
    ]
    return table(tuple(columns), lines)


def tables(data: Mapping[str, Any]) -> dict[str, str]:
    """Return every table of the manuscript."""
    by_speed: dict[float, dict[str, float]] = {}
    for r in data["speeds"]:
        row = by_speed.setdefault(r["speed"], {"speed": r["speed"], "rigid": r["rigid"]})
        row[f"θ = {r['theta']}"] = r["landing"]
    angles = list(dict.fromkeys(f"θ = {r['theta']}" for r in data["speeds"]))
    limit = {f"θ = {r['theta']}": r["divergence"] for r in data["speeds"]}
    limit |= {"speed": "divergence, rigid contact, 24,12"}
    fast = [
        {
            "theta": r["theta"],
            "modes": r["modes"],
            "factor": r["factor"],
            "divergence": r["divergence"],
        }
        | {f"{v:g} m/s": x for v, x in zip(r["speed"], r["landing"], strict=True)}
        for r in data["fast"]
    ]
    speeds = [f"{v:g} m/s" for v in data["fast"][0]["speed"]]
    return {
        "thresholds": _table(
            {"θ": "theta", "cot θ": "cot", "mode coupling": "coupling",
             "landing, 1 m/s": "landing 48,24", "divergence, k of 9.8 N": "divergence at 9.8 N",
             "divergence, rigid contact": "divergence",
             "rigid rod, landing": "landing of the rigid rod",
             "rigid rod, divergence": "rigid rod"},
            data["angles"],
        ),
        "speeds": _table(
            {"speed, m/s": "speed", **dict(zip(angles, angles, strict=True))},
            [*by_speed.values(), limit],
        ),
        "modes": _table(
            {"modes": "modes", "θ = 1.0": "landing 1.0", "θ = 1.4": "landing 1.4"},
            data["convergence"],
        ),
        "fast": _table(
            {"θ": "theta", "modes": "modes", "K over Hertz's": "factor",
             **dict(zip(speeds, speeds, strict=True)), "divergence, rigid contact": "divergence"},
            fast, ".5g",
        ),
        "belt": _table(
            {"θ": "theta", "end of radius 0": "landing 48,24", "round end": "round end 48,24",
             "hard tip without mass": "hard tip 48,24", "hard tip of 7.06 g": "heavy tip 48,24",
             "rigid rod": "landing of the rigid rod"},
            data["belt"],
        ),
        "ends": _table(
            {"θ": "theta", "radius 0": "point 48,24", "ball of 6.45 mm": "ball 48,24"},
            data["round ends"],
        ),
        "slenderness": _table(
            {"L/d": "slenderness", "angle": "theta", "landing": "landing",
             "divergence, rigid contact": "divergence",
             "rigid rod, landing": "landing of the rigid rod"},
            [row | {"slenderness": f"{row['slenderness']:g}", "theta": f"{row['theta']:.2f}"}
             for row in data["slenderness"]],
        ),
    }  # fmt: skip


def main() -> None:
    """Write the manuscript."""
    data = json.loads(RESULTS.read_text("utf-8"))
    PAGE.write_text(written(PAGE.read_text("utf-8"), tables(data)), "utf-8")


if __name__ == "__main__":
    main()
