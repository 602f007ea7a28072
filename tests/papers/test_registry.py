"""Every item of the paper, its verdict, and the interface around it."""

import json
import re

import pytest

from painleve_sym.errors import InputError
from painleve_sym.papers.claim import Verdict
from painleve_sym.papers.registry import ENTRIES, group_names, item_ids, reproduce, selected


@pytest.fixture(scope="module")
def everything():
    return reproduce()


@pytest.mark.parametrize("name", item_ids())
def test_item_has_the_expected_verdict(everything, name):
    item = next(i for i in everything.items if i.id == name)
    failed = [k for k, held in item.data.get("checks", {}).items() if not held]
    assert item.as_expected, f"{item.verdict}: {item.computed}; failed: {failed}"
    assert item.paper
    assert item.computed
    assert item.verdict is Verdict.REPRODUCED or item.reason


def test_reproduction_is_ok_with_every_verdict_as_expected(everything):
    assert everything.ok
    assert sum(everything.counts.values()) == len(ENTRIES)


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
    assert by[Verdict.DIFFERS] == {
        "stable-force",
        "sticking-compression",
        "rotation",
        "third-period",
        "jump-precision",
        "critical-force",
        "reference-exact",
    }


def test_items_cover_every_table_and_figure():
    assert {f"table-{n}" for n in range(1, 7)} <= set(item_ids())
    # Fig. 1 is a sketch.
    assert {f"fig-{n}" for n in range(2, 15)} <= set(item_ids())
    numbers = {int(m[1]) for m in (re.match(r"eq-(\d+)", i) for i in item_ids()) if m}
    assert numbers == set(range(1, 22))


def test_item_ids_are_unique_and_differ_from_groups():
    assert len(set(item_ids())) == len(item_ids())
    assert not set(item_ids()) & set(group_names())


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
        "has_figure",
        "data",
    }
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
    assert [e.id for e in selected(["fig-8", "table-1"])] == ["table-1", "fig-8"]
    assert {e.group for e in selected(["jump"])} == {"jump"}
    assert selected("fig-8") == selected(["fig-8"])
    assert selected(None) == ENTRIES


def test_unknown_item_suggests_the_nearest():
    with pytest.raises(InputError, match="Did you mean 'fig-8'"):
        reproduce(["fig8"])


def test_empty_selection_is_refused():
    with pytest.raises(InputError, match="at least one"):
        reproduce([])


def test_progress_is_told_before_every_item():
    told = []
    reproduce(["eq-2", "eq-3"], lambda *args: told.append(args))
    assert told == [(1, 2, "coefficient A"), (2, 2, "coefficient B")]


def test_items_alone_give_the_same_as_together(everything):
    alone = reproduce(["fig-14", "energy"]).items
    together = {i.id: i for i in everything.items}
    for item in alone:
        assert item.data == together[item.id].data
