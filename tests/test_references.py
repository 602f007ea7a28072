"""The literature: one bibliography, its page and its data in the package."""

from __future__ import annotations

import ast
import json
import re
from functools import cache
from pathlib import Path

import pytest
import yaml
from pybtex.database import parse_string

import painleve_sym as ps
from painleve_sym.errors import InputError
from painleve_sym.references import cited_works, loose_pattern, reference, references
from tools import prose
from tools import references as tool

WORKS = {work.key: work for work in tool.read_bibliography()}


@cache
def written():
    """Return the entries of the bibliography."""
    return tool.parse_file(tool.BIBLIOGRAPHY, "bibtex").entries


@cache
def exported():
    """Return the entries that the works have as BibTeX, one after another."""
    return parse_string("\n".join(work.bibtex for work in WORKS.values()), "bibtex").entries


def test_generated_files_are_those_of_the_bibliography():
    fix = "Fix: run make references."
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
    entry = written()[work.key]
    needed = {
        "article": {"journal", "volume", "pages"},
        "book": {"publisher"},
        "incollection": {"booktitle", "publisher", "pages", "doi"},
        "inproceedings": {"booktitle", "pages", "doi"},
        "phdthesis": {"school"},
        "techreport": {"institution", "number"},
        "misc": {"note"} if work.cited_by_title else {"url"},
    }[entry.type]
    assert needed <= set(entry.fields)
    assert set(work.unconfirmed) <= {"author", *entry.fields}
    if entry.type == "article" and work.year > 1950:
        # A work whose place was not confirmed has no guess of its DOI either.
        assert work.doi or "volume" in work.unconfirmed
    if work.doi:
        assert re.fullmatch(r"10\.\d{4,5}/\S*[\w>]", work.doi)
        by_doi = re.fullmatch(r"https://doi\.org/10\.[\w.%/:;-]+", work.link)
        assert bool(by_doi) == ("doi" not in work.unconfirmed)
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


def test_text_has_the_confirmed_data_and_no_guess():
    assert str(reference("Keller1986")) == (
        "Keller, J. B. (1986). Impact with friction. Journal of Applied Mechanics 53(1), 1–4. "
        "https://doi.org/10.1115/1.3171712"
    )
    assert str(reference("ImpactModelResolution")) == (
        "Impact model resolution on Painlevé's paradox. Authors, journal and year are not known: "
        "the copy that this project works from has no title page."
    )
    for work in WORKS.values():
        shown = str(work)
        assert "unconfirmed" not in shown and "Probably" not in shown
        for name in {"doi", "pages"} & set(work.unconfirmed):
            assert getattr(work, name) not in shown


def test_seed_paper_leaves_with_its_title_alone():
    work = reference("ImpactModelResolution")
    assert (work.authors, work.year, work.venue, work.volume, work.doi) == ((), 0, "", "", "")
    (entry,) = parse_string(work.bibtex, "bibtex").entries.values()
    assert (set(entry.fields), list(entry.persons)) == ({"title", "note"}, [])


def test_every_export_names_what_is_unconfirmed():
    marked = [work for work in WORKS.values() if work.unconfirmed]
    assert marked
    kept = {entry["key"]: entry for entry in json.loads(tool.PACKAGE_DATA.read_text("utf-8"))}
    page = parse_string(tool.exported_bibliography(list(WORKS.values())), "bibtex").entries
    for work in marked:
        note = "Not compared with a public record: " + ", ".join(
            name.replace("doi", "DOI") for name in work.unconfirmed
        )
        exports = [entries[work.key].fields["note"] for entries in (exported(), page)]
        for text in (*exports, kept[work.key]["note"], work.note, str(work)):
            assert note in text
    for key in set(WORKS) - {work.key for work in marked}:
        assert "Not compared" not in page[key].fields.get("note", "")


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


# ---- the texts that cite ----

ROOT = tool.ROOT
PAGES = [
    # What a build of the site leaves there is not part of the project.
    *sorted(
        p
        for p in (ROOT / "docs").rglob("*.md")
        if p != tool.PAGE and not {"_generated", "changes"} & {*p.parts}
    ),
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md")),
    *sorted((ROOT / "examples").rglob("*.md")),
]
SOURCES = [
    path
    for folder in ("painleve_sym", "derivations", "examples", "tests")
    for suffix in ("py", "c", "h", "toml")
    for path in sorted((ROOT / folder).rglob(f"*.{suffix}"))
    if path != Path(__file__)
]
MANUSCRIPTS = sorted((ROOT / "paper").glob("*.md"))
LINK = re.compile(r"\[([^\]]+)\]\(([^)\s]*references\.md)#([^)\s]*)\)")
# A family name with a year behind it, and what belongs to a journal rather than to a text.
AUTHORS_AND_YEAR = re.compile(
    r"(?:[A-ZÀ-Ý][\w’-]+(?:,| &| and| et al\.)\s+)*"
    r"[A-ZÀ-Ý][\w’-]+\.?,?\s+\(?(?:1[6-9]|20)\d\d\b(?!-)"
)
PLACE_IN_A_JOURNAL = re.compile(
    r"\b(?:Proc|Int|Eur|Arch|Math|Trans|Comput|Appl|Dyn|Acad|Soc|Mech|Numer|Sci)\. [A-Z(\d]"
    r"|\bJ\. (?:Appl|Comput|Differ|Mech|Non|Rheol|Sound)"
    r"|\bdoi[ :]*10\.|\barXiv:\d|\bCISM\b|\b(?:SIAM|IMA|IEEE|ACM|ZAMM) [JTR]|\bNonlinear Dynamics\b"
)
# A year behind a blank, or a word of a title or of a journal: without one a file cites nothing.
# Quick ones: they begin with few letters, and ask for no boundary of a word.
MAY_CITE = (
    re.compile(r"[\s(\"'](?:1[6-9]|20)\d\d\b(?!-)"),
    re.compile(
        r"(?:Impact\s+model|Nonlinear\s+Dynamics|doi|arXiv:|CISM|SIAM|IMA|IEEE|ACM|ZAMM"
        r"|(?:Proc|Int|Eur|Arch|Math|Trans|Comput|Appl|Dyn|Acad|Soc|Mech|Numer|Sci|J)\.\s)"
    ),
)


@cache
def _prose(path):
    """Return the texts of a file that can cite, with one blank between words."""
    if path.suffix == ".py":
        source = path.read_text("utf-8")
        if not any(pattern.search(source) for pattern in MAY_CITE):
            return []
        nodes = ast.walk(ast.parse(source))
        constants = [node.value for node in nodes if isinstance(node, ast.Constant)]
        texts = [value for value in constants if isinstance(value, str)]
        texts += re.findall(r"#.*", source)
    else:
        texts = [p.text for p in prose.passages(path) if p.scope == "text"]
    if path.suffix == ".c":
        # Comments of C are ASCII.
        texts = [text.replace("\n *", " ").replace("Norsett", "Nørsett") for text in texts]
    short = [" ".join(text.split()) for text in texts]
    return [text for text in short if re.search(r"\b\d{4}\b|[a-z]\. [A-Z(\d]|Impact model", text)]


def _cited(path):
    return {work.key for text in _prose(path) for work in cited_works(text)}


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_citations_of_a_page_are_links_to_their_entries(page):
    text = page.read_text("utf-8")
    for label, target, key in LINK.findall(text):
        works = [work for work in WORKS.values() if tool.anchor(work) == key]
        assert works, f"{key} is not the anchor of an entry"
        assert [work.key for work in cited_works(label)] == [works[0].key], label
        assert (page.parent / target).resolve() == tool.PAGE
    # A label that stands alone repeats a link of the page.
    linked = {key for _, _, key in LINK.findall(text)}
    for left in _prose(page):
        bare = re.sub(r"`[^`]*`", "", LINK.sub("", left))
        assert {tool.anchor(work) for work in cited_works(bare)} <= linked


def test_no_work_is_cited_outside_the_bibliography():
    offences = []
    for path in [*PAGES, *SOURCES]:
        for text in _prose(path):
            left = LINK.sub("", text)
            for work in cited_works(left):
                left = re.sub(loose_pattern(work.label), "", left)
            for pattern in (PLACE_IN_A_JOURNAL, AUTHORS_AND_YEAR):
                offences += [(path.relative_to(ROOT).as_posix(), m) for m in pattern.findall(left)]
    assert offences == []


def test_every_entry_is_cited():
    cited = {key for path in [*PAGES, *SOURCES] for key in _cited(path)}
    cited |= {key for path in MANUSCRIPTS for key in re.findall(r"@(\w+)", path.read_text("utf-8"))}
    assert sorted(set(WORKS) - cited) == []


def test_patterns_notice_a_citation_outside_the_bibliography():
    works = ("Painlevé (1896)", "Cottle and Stone 1992", "(Moreau 1987)", "Zhao & Chen, 2004")
    assert all(AUTHORS_AND_YEAR.search(text) for text in works)
    places = ("J. Appl. Mech. 53 (1986) 1–4", "doi 10.1115/1.1", "Proc. R. Soc. A 431", "CISM 302")
    assert all(PLACE_IN_A_JOURNAL.search(text) for text in places)


def test_citation_file_has_the_paper_as_the_bibliography_has_it():
    data = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    (paper,) = data["references"]
    work = WORKS["ImpactModelResolution"]
    assert (paper["title"], paper["authors"]) == (work.title, [{"name": "anonymous"}])
    assert paper["notes"].startswith(work.note)
    # A field without a fact would be a guess.
    assert set(paper) == {"type", "title", "notes", "authors"}


# ---- citation ----

START = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}


def _keys(*results):
    return [work.key for work in ps.citation(*results)]


def test_citation_of_a_run_has_mechanism_law_and_integrator(tmp_path):
    run = ps.simulate("rod-inertia", ps.laws.hertz(), START, t_end=1e-5)
    assert run.engine == "taylor"
    assert _keys(run) == ["GenotBrogliato1999", "Johnson1985", "JorbaZou2005"]
    run.save(tmp_path / "run.npz")
    assert _keys(ps.Trajectory.load(tmp_path / "run.npz")) == _keys(run)
    batch = ps.simulate_batch(
        "rod-inertia", ps.laws.hertz(), START, t_end=1e-5, engine="compiled", initial_force=[1.0]
    )
    assert _keys(batch)[2:] == ["PrinceDormand1981", "HairerEtAl1993"]


def test_citation_of_a_rigid_law_has_its_restitution():
    assert "Stronge1990" in _keys(ps.law("rigid"))
    assert "Stronge1990" not in _keys(ps.law("rigid", restitution="newton"))
    assert "Newton1687" in _keys(ps.law("rigid", restitution="newton"))


def test_citation_has_each_work_once():
    rod, law = ps.model("rod"), ps.laws.bilinear_hertz()
    assert _keys(rod, law, rod) == ["ImpactModelResolution"]
    assert "author = {Hogan" in ps.citation(ps.laws.linear())[0].bibtex


def test_citation_of_an_object_without_source_is_rejected():
    with pytest.raises(InputError, match="got dict, which names no source"):
        ps.citation(START)


def test_bibtex_of_a_work_is_an_entry_of_its_own():
    years = [(entry.key, entry.fields.get("year", "0")) for entry in exported().values()]
    assert years == [(key, str(work.year)) for key, work in WORKS.items()]
