"""Every item of the paper, its verdict, and the registry of papers."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from painleve_sym import papers
from painleve_sym.errors import InputError
from painleve_sym.papers.impact_resolution import items
from painleve_sym.papers.item import Verdict, checked
from painleve_sym.papers.registry import chosen_papers, known_papers, reproduce, selected
from painleve_sym.present.report import markdown, terminal_table, write_report
from painleve_sym.references import reference

ROOT = Path(__file__).parents[2]
ITEMS = [name for _, name in selected()]


def group(name):
    return next(p.claims.items[n].group for p, n in selected() if n == name)


@pytest.fixture(scope="module")
def everything():
    return reproduce()


@pytest.mark.parametrize("name", ITEMS)
def test_item_has_the_expected_verdict(everything, name):
    item = next(i for i in everything.items if i.id == name)
    wrong = [statement for statement, holds in item.data.get("checks", {}).items() if not holds]
    assert item.as_expected, f"{item.verdict}: {item.computed}; {item.reason}; {wrong}"
    assert "{" not in item.reason
    assert item.paper
    assert item.computed
    assert item.verdict is Verdict.REPRODUCED or item.reason


def test_reproduction_is_ok_with_every_verdict_as_expected(everything):
    assert everything.ok
    assert sum(everything.counts.values()) == len(ITEMS)


def test_misprints_and_differences_are_the_known_ones(everything):
    by = {v: {i.id for i in everything.items if i.verdict is v} for v in Verdict}
    assert by[Verdict.MISPRINT] == {
        "eq-4-radius",
        "eq-14-spin",
        "eq-18-impulse",
        "table-2",
        "table-3",
        "radius",
        "gravity-unit",
    }
    in_doubt = {i.id for i in everything.items if i.copy_in_doubt}
    assert in_doubt == {"eq-14-spin", "eq-18-impulse", "table-2", "table-3"}
    assert by[Verdict.DIFFERS] == {
        "eq-4-stiffness",
        "stable-force",
        "sticking-compression",
        "rotation",
        "third-period",
        "jump-precision",
        "critical-force",
    }


def test_page_has_the_counts_and_energies_of_the_reproduction(everything):
    page = " ".join((ROOT / "docs" / "reproduction.md").read_text("utf-8").split())
    n, doubtful = everything.counts, sum(i.copy_in_doubt for i in everything.items)
    assert f"Of {len(ITEMS)} items {n['reproduced']} are reproduced" in page
    assert f"{n['misprint']} are misprints ({doubtful} possibly of the copy)" in page
    assert f"and {n['differs']} are claims that" in page
    assert page.count(", or fault of the copy |") == doubtful
    # Work of compression and its recoverable part e², of Table 3's first period.
    (item,) = (i for i in everything.items if i.id == "energy-portions")
    energy = {row[0]: row[3] for row in item.data["table"]["rows"]}
    assert energy["recoverable"] == pytest.approx(0.75**2 * energy["compression"], rel=1e-9)
    words = "{rotation:.3f} J to rotation and {compression:.4f} J to compression, of which "
    assert words.format(**energy) + f"{energy['recoverable']:.4f} J, the part e²" in page


def test_items_cover_every_table_and_figure():
    assert {f"table-{n}" for n in range(1, 7)} <= set(ITEMS)
    # Fig. 1 is a sketch.
    assert {f"fig-{n}" for n in range(2, 15)} <= set(ITEMS)
    numbers = {int(m[1]) for m in (re.match(r"eq-(\d+)", i) for i in ITEMS) if m}
    assert numbers == set(range(1, 22))


def test_item_ids_are_unique_and_differ_from_groups():
    assert len(set(ITEMS)) == len(ITEMS)
    assert not set(ITEMS) & {group(name) for name in ITEMS}


def test_figures_have_series_and_formulas_none(everything):
    for item in everything.items:
        assert item.group != "figure" or item.series
        assert item.group != "formula" or item.series is None


def test_results_are_plain_data_without_nan(everything):
    text = json.dumps(everything.to_dict(), allow_nan=False)
    data = json.loads(text)
    assert data["format"] == "painleve-sym reproduction 1"
    assert data["ok"] is True
    assert set(data["items"][0]) == {
        "id",
        "group",
        "title",
        "paper",
        "computed",
        "verdict",
        "expected_verdict",
        "as_expected",
        "reason",
        "seconds",
        "copy_in_doubt",
        "has_figure",
        "data",
        "paper_name",
    }
    assert data["papers"] == ["impact-resolution"]
    for item in data["items"]:
        table = item["data"].get("table")
        assert table is None or all(len(r) == len(table["columns"]) for r in table["rows"])


def test_sticking_compression_lasts_two_microseconds(everything):
    data = next(i for i in everything.items if i.id == "sticking-compression").data
    assert data["sticking_compression"] == pytest.approx(1.9972648e-6, rel=1e-6)
    assert data["restitution"] == pytest.approx(1.7303777e-5, rel=1e-6)


def test_separating_forces_are_the_independent_ones(everything):
    data = next(i for i in everything.items if i.id == "critical-force").data
    assert data["F_n*"] == pytest.approx(332.992, abs=5e-4)
    assert data["slip_stops"] == pytest.approx(346.8785, abs=5e-5)
    assert data["slip_stops_before_maximum"] == pytest.approx(346.9994, abs=5e-5)


def test_velocity_problem_finds_the_jump_where_accelerations_have_no_solution(everything):
    items = {i.id: i.data for i in everything.items}
    kinds = [[s["kind"] for s in items[f"fig-{n}"]["over_a_step"]] for n in (3, 5, 7, 11)]
    assert kinds == [
        ["slides on"],
        ["lifts off"],
        ["jump to rest"],
        ["lifts off", "slides on", "jump to rest"],
    ]
    # Over a vanishing step it is the compression of the jump rule: P_n1 + P_n2.
    rule = dict(row[:2] for row in items["jump-values"]["table"]["rows"])
    jump = items["fig-7"]["over_a_step"][0]["normal_impulse"]
    assert jump == pytest.approx(rule["P_n1"] + rule["P_n2"], rel=1e-4)


def test_selected_keeps_the_order_and_takes_groups():
    assert [name for _, name in selected(["fig-8", "table-1"])] == ["table-1", "fig-8"]
    assert {group(name) for _, name in selected(["jump"])} == {"jump"}
    assert selected("fig-8") == selected(["fig-8"])
    assert [name for _, name in selected(None)] == ITEMS


def test_unknown_item_suggests_the_nearest():
    with pytest.raises(InputError, match="Did you mean 'fig-8'"):
        reproduce(["fig8"])


def test_empty_selection_is_refused():
    with pytest.raises(InputError, match="at least one"):
        reproduce([])


def test_items_alone_give_the_same_as_together(everything):
    alone = reproduce(["fig-14", "energy"]).items
    together = {i.id: i for i in everything.items}
    for item in alone:
        assert item.data == together[item.id].data


def test_features_differ_when_one_check_fails():
    assert checked("c", {"a": True}).verdict is Verdict.REPRODUCED
    outcome = checked("c", {"a": True, "b": np.bool_(False)})
    assert outcome.verdict is Verdict.DIFFERS
    assert outcome.data["checks"] == {"a": True, "b": False}


# ---- failures ----


def divide(bench):
    return 1 / 0


def not_a_number(bench):
    return checked("c", {"a": True}, {"value": float("nan")})


@pytest.mark.parametrize(
    ("compute", "exception"), [(divide, "ZeroDivisionError"), (not_a_number, "ValueError")]
)
def test_item_that_raises_has_failed_and_the_others_are_computed(
    monkeypatch, tmp_path, compute, exception
):
    monkeypatch.setitem(items.COMPUTE, "eq-2", compute)
    reproduction = reproduce(["eq-1", "eq-2", "eq-3"])
    assert [i.verdict for i in reproduction.items] == [
        Verdict.REPRODUCED,
        Verdict.FAILED,
        Verdict.REPRODUCED,
    ]
    assert not reproduction.ok
    failed = reproduction.items[1]
    assert failed.reason.startswith(f"{exception}: ")
    assert failed.data["exception"] == exception
    assert reproduction.counts["failed"] == 1
    assert "1 failed; NOT as on record: eq-2" in terminal_table(reproduction)
    assert "verdict: **failed**, on record reproduced" in markdown(reproduction)
    write_report(reproduction, tmp_path)
    assert json.loads((tmp_path / "results.json").read_text("utf-8"))["ok"] is False


# ---- several papers ----

TINY = """
source = "Newton1687"

[formulas.eq-1]
number = "(1)"
title = "height of fall"
text = "h = g t²/2"
expression = "g*t**2/2"

[items.fig-7]
group = "figure"
title = "an apple"
paper = "it falls"
expected = "differs"
reason = "it rises by {height:.1f} m"
"""
TINY_ITEMS = """
import sympy as sp
from painleve_sym.papers.claims import read_claims
from painleve_sym.papers.item import ItemOutcome, Verdict
from painleve_sym.papers.formula import identical
from painleve_sym.papers.panels import Axis, Panel, line
from pathlib import Path

class Workbench:
    claims = read_claims(Path(__file__).parent / "claims.toml")

def formula(bench):
    g, t = sp.symbols("g t")
    printed = bench.claims.expression("eq-1", {"g": g, "t": t})
    return ItemOutcome("", Verdict.of(identical(printed, sp.integrate(g * t, t))))

def figure(bench):
    panel = Panel(Axis("$t$"), Axis("$h$"), (line("", [0, 1], [0, 1]),))
    return ItemOutcome("it rises", Verdict.DIFFERS, {"height": 2.0}, panels=(panel,))

COMPUTE = {"eq-1": formula, "fig-7": figure}
"""


@pytest.fixture
def apples(tmp_path, monkeypatch):
    folder = tmp_path / "papers" / "fall_of_apples"
    folder.mkdir(parents=True)
    for name, text in {"claims.toml": TINY, "items.py": TINY_ITEMS, "__init__.py": ""}.items():
        (folder / name).write_text(text, encoding="utf-8")
    monkeypatch.setattr(papers, "__path__", [*papers.__path__, str(folder.parent)])
    yield folder
    for name in [n for n in sys.modules if n.startswith("painleve_sym.papers.fall_of_apples")]:
        del sys.modules[name]
    vars(papers).pop("fall_of_apples", None)


def test_paper_is_added_by_its_folder_alone(apples):
    assert list(known_papers()) == ["fall-of-apples", "impact-resolution"]
    reproduction = reproduce(paper="fall-of-apples")
    assert reproduction.ok
    assert [i.id for i in reproduction.items] == ["eq-1", "fig-7"]
    assert reproduction.items[1].reason == "it rises by 2.0 m"
    assert reproduction.source == str(reference("Newton1687"))


def test_papers_together_keep_items_of_one_id_apart(apples, tmp_path):
    reproduction = reproduce(["fig-7"])
    assert [i.paper_name for i in reproduction.items] == ["fall-of-apples", "impact-resolution"]
    write_report(reproduction, tmp_path / "out")
    figures = {path.stem for path in (tmp_path / "out" / "figures").iterdir()}
    assert figures == {"fall-of-apples-fig-7", "impact-resolution-fig-7"}
    assert "\nimpact-resolution-" in terminal_table(reproduction)


def test_item_without_claim_or_computation_is_an_error(apples):
    text = TINY_ITEMS.replace('"fig-7": figure', '"fig-8": figure')
    (apples / "items.py").write_text(text, encoding="utf-8")
    with pytest.raises(LookupError, match=r"\['fig-7', 'fig-8'\]"):
        reproduce(paper="fall-of-apples")


def test_unknown_paper_suggests_the_nearest():
    with pytest.raises(InputError, match="Did you mean 'impact-resolution'"):
        chosen_papers("impact-resolutoin")
