"""The literature that the project cites: ``docs/references.bib`` as values.

A work is cited by its label, *Authors (year)*, wherever a text names it: in pages, docstrings,
comments and the source of a law or mechanism. `cited_works` returns the works that a text cites.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol
from urllib.parse import quote

from painleve_sym.errors import InputError, refuse_unknown

DATA = "references.json"
"""File of the package that `tools/references.py` makes from ``docs/references.bib``."""


@dataclass(frozen=True)
class Reference:
    """One work of the literature.

    Attributes
    ----------
    key : str
        Its key in ``docs/references.bib``.
    authors : tuple of str
        Family name and initials, such as ``Génot, F.``; the last may be ``others``. Empty where
        they are not known.
    title : str
    year : int
        0 where it is not known.
    venue : str
        Journal, proceedings or book with its series, or the publisher, and the edition.
    volume, number, pages, doi, url, eprint, note : str
        `eprint` is the number in arXiv. These and `venue` are empty where the work has none.
    unconfirmed : tuple of str
        Fields of the entry that were not compared with a public record. The note names them.
    bibtex : str
        The entry for a bibliography of LaTeX, with that note.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> work = ps.citation(ps.laws.hertz())[0]
    >>> work.label, work.year
    ('Johnson (1985)', 1985)
    """

    key: str
    title: str
    authors: tuple[str, ...] = ()
    year: int = 0
    venue: str = ""
    volume: str = ""
    number: str = ""
    pages: str = ""
    doi: str = ""
    url: str = ""
    eprint: str = ""
    note: str = ""
    unconfirmed: tuple[str, ...] = ()
    bibtex: str = ""

    @property
    def label(self) -> str:
        """Citation in a text: authors and year; the title where these are not certain."""
        if self.cited_by_title:
            return self.title
        families = [author.split(",")[0] for author in self.authors]
        names = f"{families[0]} et al." if len(families) > 3 else _joined(families)
        return f"{names} ({self.year})"

    @property
    def cited_by_title(self) -> bool:
        """Whether the authors or the year are not known, or unconfirmed."""
        unconfirmed = not {"author", "year"}.isdisjoint(self.unconfirmed)
        return unconfirmed or not (self.authors and self.year)

    @property
    def link(self) -> str:
        """Address of the work; empty where none is confirmed."""
        if doi := self._confirmed("doi"):
            return f"https://doi.org/{quote(doi, safe='/:;.')}"
        eprint = self._confirmed("eprint")
        return self._confirmed("url") or (f"https://arxiv.org/abs/{eprint}" if eprint else "")

    @property
    def text(self) -> str:
        """The work with its confirmed data and its note, without its address."""
        number = self._confirmed("number")
        volume = self._confirmed("volume") + f"({number})" * bool(number)
        place = ", ".join(
            filter(None, [f"{self.venue} {volume}".strip(), self._confirmed("pages")])
        )
        sentences = [self.title, place, self.note]
        if not self.cited_by_title:
            sentences.insert(0, f"{_joined(self.authors)} ({self.year})")
        if eprint := self._confirmed("eprint"):
            sentences.append(f"arXiv:{eprint}")
        return " ".join(f"{sentence}." for sentence in sentences if sentence)

    def _confirmed(self, name: str) -> str:
        """Return a field, empty where it was not compared with a public record."""
        return "" if name in self.unconfirmed else str(getattr(self, name))

    def __str__(self) -> str:
        """Return `text` and the address."""
        return f"{self.text} {self.link}".strip()


def _joined(names: Sequence[str]) -> str:
    """Return names as a list in a sentence; a last name ``others`` stands for the rest."""
    *firsts, last = names
    if last == "others":
        return f"{', '.join(firsts)} et al."
    return f"{', '.join(firsts)} & {last}" if firsts else last


@cache
def references() -> Mapping[str, Reference]:
    """Return every work by its key, in the order of ``docs/references.bib``."""
    entries = json.loads(Path(__file__).with_name(DATA).read_text("utf-8"))
    return MappingProxyType({entry["key"]: reference_from(entry) for entry in entries})


def reference_from(entry: Mapping[str, Any]) -> Reference:
    """Return the work of an entry of the data file."""
    lists = {name: tuple(entry.get(name, ())) for name in ("authors", "unconfirmed")}
    return Reference(**{**entry, **lists})


def reference(key: str) -> Reference:
    """Return the work of a key; InputError names the nearest known key."""
    refuse_unknown("key of a reference", key, references())
    return references()[key]


class HasSource(Protocol):
    """A mechanism, law, simulator or result that names its source."""

    @property
    def source(self) -> str:
        """Citations of the works that it rests on, in words."""


def citation(*results: HasSource) -> tuple[Reference, ...]:
    """Return the works that results, mechanisms or laws rest on, each once.

    A motion rests on the sources of its mechanism, of its contact and restitution laws, and of its
    integrator. The text of a work has all its data; `Reference.bibtex` is its entry for LaTeX.

    Parameters
    ----------
    *results : Mechanism, ContactLaw, RigidLaw, Simulator, Trajectory, BatchResult or Reproduction

    Raises
    ------
    InputError
        An object without a source.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> for work in ps.citation(ps.model("two-link-arm"), ps.laws.hertz()):
    ...     print(work.label, work.link)
    Zhao et al. (2008) https://doi.org/10.1115/1.2910825
    Johnson (1985) https://doi.org/10.1017/CBO9781139171731
    """
    for result in results:
        if not isinstance(getattr(result, "source", None), str):
            raise InputError(
                f"citation: got {type(result).__name__}, which names no source; need a mechanism, "
                "a law, a simulator, or the result of a run."
            )
    return cited_works("; ".join(result.source for result in results))


def cited_works(text: str) -> tuple[Reference, ...]:
    """Return the works that a text cites, each once, in the order of their labels in the text.

    The year of a label may stand without its parentheses, and a line may end within it.

    Examples
    --------
    >>> from painleve_sym.references import cited_works
    >>> [work.key for work in cited_works("Routh (1905), and later Génot & Brogliato 1999")]
    ['Routh1905', 'GenotBrogliato1999']
    """
    works = [references()[str(match.lastgroup)] for match in _label_pattern().finditer(text)]
    return tuple(dict.fromkeys(works))


@cache
def _label_pattern() -> re.Pattern[str]:
    """Return a pattern of all labels, the longest first; the key names the group of each."""
    works = sorted(references().values(), key=lambda work: -len(work.label))
    labels = [f"(?P<{work.key}>{loose_pattern(work.label)})" for work in works]
    # Few letters of a text begin a label: at the others no label is tried.
    initials = re.escape("".join(sorted({work.label[0] for work in works})))
    # A family name that ends another label, as in "Wang & Mason", does not begin one.
    return re.compile(rf"(?<![\w&-])(?<!& )(?=[{initials}])(?:{'|'.join(labels)})(?!\w)")


def loose_pattern(label: str) -> str:
    """Return a pattern of a label with any blanks, and with or without parentheses."""
    return re.escape(label).replace(r"\ ", r"\s+").replace(r"\(", r"\(?").replace(r"\)", r"\)?")
