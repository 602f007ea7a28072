"""The literature as data of the package, made from `docs/references.bib`.

`python tools/references.py` writes `painleve_sym/references.json`, from which the package names the
works that a result rests on. The page of the site is made by sphinxcontrib-bibtex.
"""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

from pybtex.database import Entry, Person, parse_file

from painleve_sym.references import DATA, Reference

ROOT = Path(__file__).parents[1]
BIBLIOGRAPHY = ROOT / "docs" / "references.bib"
PAGE = ROOT / "docs" / "references.md"
PACKAGE_DATA = ROOT / "painleve_sym" / DATA
VENUES = (
    "journal", "booktitle", "series", "publisher", "institution", "school", "howpublished",
)  # fmt: skip
"""Fields of an entry that say where the work appeared."""


def read_bibliography(path: Path = BIBLIOGRAPHY) -> list[Reference]:
    """Return the works of a BibTeX file in its order."""
    return [_reference(entry) for entry in parse_file(path, "bibtex").entries.values()]


def package_data(works: list[Reference]) -> str:
    """Return the file of the package: a JSON list of works without their empty fields."""
    entries = [
        {name: value for name, value in dataclasses.asdict(work).items() if value} for work in works
    ]
    return json.dumps(entries, ensure_ascii=False, indent=1) + "\n"


def anchor(work: Reference) -> str:
    """Return the target of links to a work on the page."""
    return work.key.lower()


def _reference(entry: Entry) -> Reference:
    fields = {name.lower(): _plain(text) for name, text in exported_fields(entry).items()}
    names = ("volume", "number", "pages", "doi", "url", "eprint", "note")
    edition = f"{fields['edition']} edition" if "edition" in fields else ""
    venue = [fields.get(name, "") for name in VENUES]
    return Reference(
        key=entry.key,
        authors=tuple(_name(person) for person in entry.persons.get("author", ())),
        title=fields["title"],
        year=int(fields.get("year", 0)),
        venue=", ".join(filter(None, [*venue, edition])),
        **{name: fields.get(name, "") for name in names},
        unconfirmed=_unconfirmed(entry),
        bibtex=_bibtex(entry),
    )


def _unconfirmed(entry: Entry) -> tuple[str, ...]:
    return tuple(filter(None, entry.fields.get("unconfirmed", "").split(", ")))


def exported_fields(entry: Entry) -> dict[str, str]:
    """Return the fields of an entry, where a note names those that are unconfirmed."""
    fields = {name: text for name, text in entry.fields.items() if name != "unconfirmed"}
    if marked := _unconfirmed(entry):
        names = ", ".join(name.replace("doi", "DOI") for name in marked)
        note = f"Not compared with a public record: {names}"
        fields["note"] = ". ".join(filter(None, [fields.get("note"), note]))
    return fields


def exported_bibliography(works: list[Reference]) -> str:
    """Return the bibliography as BibTeX for others: notes name what is unconfirmed."""
    return "\n\n".join(work.bibtex for work in works) + "\n"


def _name(person: Person) -> str:
    family = _plain(" ".join([*person.prelast_names, *person.last_names]))
    given = _plain(" ".join([*person.first_names, *person.middle_names]))
    return f"{family}, {given}" if given else family


def _plain(text: str) -> str:
    """Return a field of BibTeX as plain text."""
    return text.replace("{", "").replace("}", "").replace("--", "–")


def _bibtex(entry: Entry) -> str:
    """Return the entry as BibTeX."""
    persons = entry.persons.get("author", ())
    fields = {"author": " and ".join(map(str, persons)), **exported_fields(entry)}
    lines = [f"  {name} = {{{text}}},\n" for name, text in fields.items() if text]
    return f"@{entry.type}{{{entry.key},\n{''.join(lines)}}}"


def main() -> None:
    """Write the data of the package."""
    PACKAGE_DATA.write_text(package_data(read_bibliography()), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
