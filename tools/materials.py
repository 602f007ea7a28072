"""Tables of ``docs/materials.md``, of the package's data: `python -m tools.materials`."""

from __future__ import annotations

from pathlib import Path

from painleve_sym.mechanics.materials import PAIR_PROPERTIES, MaterialValue, materials
from painleve_sym.references import reference
from painleve_sym.tables import markdown_table as table
from tools.tables import written

PAGE = Path(__file__).parents[1] / "docs" / "materials.md"
UNITS = {"young_modulus": ("GPa", 1e9), "yield_strength": ("MPa", 1e6), "density": ("kg/m³", 1.0)}
NAMES = {"young_modulus": "Young's modulus", "poisson_ratio": "Poisson's ratio"}
Row = tuple[str, str, MaterialValue]


def properties() -> list[Row]:
    """Return material, property and value of every number of a material."""
    return [(one.name, key, v) for one in materials().values() for key, v in one.properties.items()]


def pairs() -> list[Row]:
    """Return both bodies, property and value of every number of a pair, each pair once."""
    rows: dict[frozenset[str], list[Row]] = {}
    for one in materials().values():
        for pair in one.pairs:
            values = {name: getattr(pair, name) for name in PAIR_PROPERTIES}
            named = f"{one.name}, {pair.other}"
            rows.setdefault(
                frozenset((one.name, pair.other)),
                [(named, name, value) for name, value in values.items() if value is not None],
            )
    return [row for of_pair in rows.values() for row in of_pair]


def tables() -> dict[str, str]:
    """Return the tables and the list of sources, by their marks on the page."""
    sources = list(dict.fromkeys(key for *_, v in (*properties(), *pairs()) for key in v.sources))

    def lines(rows: list[Row]) -> list[tuple[str, ...]]:
        return [
            (name, NAMES.get(key, key.replace("_", " ")), _value(key, v), _cited(v, sources))
            for name, key, v in rows
        ]

    works = [
        f"{i}. [{reference(key).label}](references.md#{key.lower()})"
        for i, key in enumerate(sources, 1)
    ]
    return {
        "properties": table(
            ("material", "property", "value (range)", "source"), lines(properties())
        ),
        "pairs": table(("pair", "property", "value (range)", "source"), lines(pairs())),
        "sources": "\n".join(works),
    }


def _value(key: str, v: MaterialValue) -> str:
    unit, scale = UNITS.get(key, ("", 1.0))
    spread = f" ({v.lower / scale:g} to {v.upper / scale:g})" if v.lower < v.upper else ""
    return f"{v.value / scale:g}{spread} {unit}".strip()


def _cited(v: MaterialValue, sources: list[str]) -> str:
    return ", ".join(str(sources.index(key) + 1) for key in v.sources)


def main() -> None:
    """Write the page."""
    PAGE.write_text(written(PAGE.read_text("utf-8"), tables()), "utf-8")


if __name__ == "__main__":
    main()
