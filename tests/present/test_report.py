"""The files of a reproduction and its terminal table."""

import json
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest

from painleve_sym.errors import InputError
from painleve_sym.papers.item import Verdict
from painleve_sym.papers.registry import reproduce, selected
from painleve_sym.present.report import WIDTH, markdown, terminal_table, write_report
from painleve_sym.tables import display_width

FEW = ("eq-18-impulse", "table-3", "fig-7", "fig-8", "rotation")


@pytest.fixture(scope="module")
def few():
    return reproduce(FEW)


@pytest.fixture(scope="module")
def written(few, tmp_path_factory):
    out = tmp_path_factory.mktemp("report") / "made" / "here"
    return out, write_report(few, out)


@pytest.mark.slow
def test_report_writes_all_files_and_nothing_else(written):
    out, files = written
    names = {p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file()}
    figures = {f"figures/{n}.{s}" for n in ("fig-7", "fig-8") for s in ("png", "svg")}
    assert names == {"report.md", "report.html", "results.json"} | figures
    assert {p.relative_to(out).as_posix() for p in files} == names


@pytest.mark.slow
def test_report_figures_are_png_and_svg(written):
    out, _ = written
    assert (out / "figures/fig-8.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    root = ET.parse(out / "figures/fig-8.svg").getroot()
    assert root.tag.endswith("svg")


def test_report_results_hold_every_item_and_its_figures(written, few):
    out, _ = written
    data = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert [i["id"] for i in data["items"]] == list(FEW)
    assert data["ok"] is True
    assert data["counts"] == {"reproduced": 2, "misprint": 2, "differs": 1, "failed": 0}
    by_id = {i["id"]: i for i in data["items"]}
    assert by_id["fig-7"]["figures"] == ["figures/fig-7.png", "figures/fig-7.svg"]
    assert by_id["table-3"]["figures"] == []
    assert by_id["table-3"]["data"]["A"] == few.items[1].data["A"]


def test_report_markdown_names_every_item_and_figure(written):
    out, _ = written
    text = (out / "report.md").read_text(encoding="utf-8")
    for name in FEW:
        assert f'<a id="{name}"></a>' in text
        assert f"(#{name})" in text
    assert "![Fig. 7: no solution](figures/fig-7.png)" in text
    assert "**misprint or fault of the copy**" in text
    assert r"\frac{" in text


@pytest.mark.slow
def test_report_figures_are_the_same_every_time(written, tmp_path, few):
    out, _ = written
    write_report(few, tmp_path)
    for name in ("fig-7.png", "fig-7.svg", "fig-8.png", "fig-8.svg"):
        assert (tmp_path / "figures" / name).read_bytes() == (out / "figures" / name).read_bytes()


def test_report_replaces_an_older_one(tmp_path):
    write_report(reproduce(["eq-2"]), tmp_path)
    write_report(reproduce(["eq-3"]), tmp_path)
    data = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert [i["id"] for i in data["items"]] == ["eq-3"]


def test_report_refuses_a_folder_that_is_a_file(tmp_path, few):
    path = tmp_path / "file"
    path.write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="Fix: name a folder"):
        write_report(few, path)


def test_terminal_table_fits_its_width_and_names_every_item(few):
    text = terminal_table(few)
    assert all(display_width(line) <= WIDTH for line in text.splitlines())
    for name in FEW:
        assert f"\n{name} " in text
    assert " ".join(text.split()).endswith(
        "5 items: 2 reproduced, 2 misprint (2 possibly of the copy), 1 differs; every "
        "verdict is that on record."
    )


def test_terminal_table_columns_line_up_under_dotted_letters(few):
    lines = [line for line in terminal_table(few).splitlines() if "θ̇ falls" in line]
    assert display_width(lines[0][: lines[0].index("differs")]) == 88


def test_unexpected_verdict_is_marked_everywhere(few):
    odd = replace(few, items=(replace(few.items[0], verdict=Verdict.DIFFERS), *few.items[1:]))
    assert not odd.ok
    assert "differs !" in terminal_table(odd)
    assert "NOT as on record: eq-18-impulse" in " ".join(terminal_table(odd).split())
    assert "on record misprint" in markdown(odd)


@pytest.mark.slow
def test_report_of_everything_is_written(tmp_path):
    everything = reproduce()
    files = write_report(everything, tmp_path)
    assert everything.ok
    with_figure = [i for i in everything.items if i.series is not None]
    assert len(files) == 3 + 2 * len(with_figure)
    assert len(everything.items) == len(selected())
    assert all(display_width(line) <= WIDTH for line in terminal_table(everything).splitlines())
