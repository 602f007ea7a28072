"""The literature: one bibliography, its page and its data in the package."""

from __future__ import annotations

import re

import pytest

from painleve_sym.errors import InputError
from painleve_sym.references import cited_works, reference, references
from tools import references as tool

WORKS = {work.key: work for work in tool.read_bibliography()}


def test_generated_files_are_those_of_the_bibliography():
    fix = "Fix: run make references."
    assert tool.PAGE.read_text("utf-8") == tool.page(list(WORKS.values())), fix
    assert tool.PACKAGE_DATA.read_text("utf-8") == tool.package_data(list(WORKS.values())), fix
    assert dict(references()) == WORKS


def test_keys_are_sorted_and_say_authors_and_year():
    assert list(WORKS) == sorted(WORKS, key=str.lower)
    for work in WORKS.values():
        assert work.key.isascii() and work.key.isalnum()
        if not work.cited_by_title:
            assert work.key.endswith(str(work.year))
    assert len({tool.anchor(work) for work in WORKS.values()}) == len(WORKS)
    assert len({work.label for work in WORKS.values()}) == len(WORKS)


@pytest.mark.parametrize("work", WORKS.values(), ids=WORKS)
def test_entry_is_complete(work):
    entry = tool.parse_file(tool.BIBLIOGRAPHY, "bibtex").entries[work.key]
    needed = {
        "article": {"journal", "volume", "pages"},
        "book": {"publisher"},
        "incollection": {"booktitle", "publisher", "pages", "doi"},
        "inproceedings": {"booktitle", "pages", "doi"},
        "techreport": {"institution", "number"},
        "misc": {"url"},
    }[entry.type]
    assert needed <= set(entry.fields)
    assert set(work.unconfirmed) <= {"author", *entry.fields}
    if entry.type == "article" and work.year > 1950:
        assert work.doi
    if work.doi:
        assert re.fullmatch(r"10\.\d{4,5}/\S*[\w>]", work.doi)
        assert re.fullmatch(r"https://doi\.org/10\.[\w.%/:;-]+", work.link)
    assert re.fullmatch(r"(\d{4}\.\d{5})?", work.eprint)
    assert re.fullmatch(r"([a-z]?\d+(–\d+)?)?", work.pages)


def test_labels():
    labels = {
        "Routh1905": "Routh (1905)",
        "GenotBrogliato1999": "Génot & Brogliato (1999)",
        "CottleEtAl1992": "Cottle, Pang & Stone (1992)",
        "ZhaoEtAl2008": "Zhao et al. (2008)",
        "HarrisEtAl2020": "Harris et al. (2020)",
        "ImpactModelResolution": "Impact model resolution on Painlevé's paradox",
    }
    assert {key: reference(key).label for key in labels} == labels


def test_text_has_all_data_and_says_what_is_unconfirmed():
    assert str(reference("Keller1986")) == (
        "Keller, J. B. (1986). Impact with friction. Journal of Applied Mechanics 53(1), 1–4. "
        "https://doi.org/10.1115/1.3171712"
    )
    seed = reference("ImpactModelResolution").text
    assert seed.startswith("Impact model resolution on Painlevé's paradox. Probably Zhao, Z.,")
    assert seed.endswith("Not confirmed: author, journal, volume, number, year, pages, doi.")


def test_citations_of_a_text():
    text = """
        Wang & Mason (1992), after Routh 1905 and Cottle, Pang &
        Stone (1992); Routh (1905) once more. Mason & Wang (1988). Riley (1956).
    """
    keys = ["WangMason1992", "Routh1905", "CottleEtAl1992", "MasonWang1988"]
    assert [work.key for work in cited_works(text)] == keys


def test_unknown_key_names_the_nearest():
    with pytest.raises(InputError, match="Did you mean 'Keller1986'"):
        reference("Keller1985")
