"""Pages of results: the report of a paper and the page of one motion."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import replace
from html import escape
from html.parser import HTMLParser
from pathlib import Path

import pytest

from painleve_sym import Trajectory, citation
from painleve_sym.__main__ import main
from painleve_sym.mechanics.mathml import symbol_mathml
from painleve_sym.papers.registry import reproduce
from painleve_sym.present.page import Html, HtmlPage, PageSection, preformatted, table, unit_html
from painleve_sym.present.report import report_page, write_report
from painleve_sym.present.run_page import run_page, scenario_command
from painleve_sym.study.scenario import Scenario
from tests.browser import chromium, needs_axe, needs_chromium, violations

ROOT = Path(__file__).parents[2]
QUADRUPED = ROOT / "examples" / "robots" / "quadruped.urdf"
FEW = ("eq-4-radius", "eq-14-spin", "eq-18-impulse", "table-3", "fig-7", "rotation")
CASE = Scenario(
    "rod",
    state={"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0},
    law="bilinear-hertz",
    law_parameters={"E": 20.9e14},
    law_choices={"reload": "virgin"},
    t_end=1e-3,
)
VOID = {"meta", "input", "img", "br", "path", "use", "link", "rect"}


class _Reader(HTMLParser):
    """Checks that elements are closed in order; collects ids, links and sources."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open, self.ids, self.links, self.elsewhere = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.ids += [values["id"]] if "id" in values else []
        links = [values[k] for k in ("href", "src", "xlink:href") if k in values]
        # A link that a reader may follow is not a file that the page needs.
        outside = tag == "a" and not links[0].startswith("#")
        (self.elsewhere if outside else self.links).extend(links)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag


@pytest.fixture(scope="module")
def few():
    return reproduce(FEW)


@pytest.fixture(scope="module")
def report(few, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("report")
    write_report(few, out)
    return out / "report.html"


@pytest.fixture(scope="module")
def motion(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("motion") / "run.html"
    run_page(CASE, CASE.simulate()).write(path)
    return path


@pytest.fixture(scope="module")
def risk(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("risk") / "risk.html"
    foot = (str(QUADRUPED), "--contact", "LF_foot", "--mu", "2", "--poses", "2")
    assert main(["robot", *foot, "--report", str(path)]) == 0
    return path


@pytest.mark.parametrize("name", ["report", "motion", "risk"])
def test_page_is_whole_and_needs_no_other_file(name, request):
    text = request.getfixturevalue(name).read_text("utf-8")
    read = _Reader(text)
    assert len(read.ids) == len(set(read.ids))
    assert all(link.startswith(("#", "data:")) for link in read.links)
    assert all(link.startswith("https://doi.org/") for link in read.elsewhere)
    assert {link[1:] for link in read.links if link[0] == "#"} <= set(read.ids)
    assert "@media print" in text


def test_report_has_every_item_with_formulas_side_by_side(report, few):
    text = report.read_text("utf-8")
    for item in few.items:
        assert f'id="{item.id}"' in text
        command = f"painleve reproduce {item.paper_name} --only {item.id} --out {item.id}"
        assert command in text
    section = text.split('id="eq-18-impulse"')[1].split("<h3")[0]
    assert section.count("<math") == 2 and section.count('class="misprint"') == 1
    assert section.index("printed in the paper") < section.index("derived here")
    assert re.search(r'class="misprint"><mi>l</mi>', section)
    assert text.split('id="eq-14-spin"')[1].split("<h3")[0].count("<math") == 1


def test_report_is_the_same_every_time(report, few, tmp_path):
    write_report(few, tmp_path)
    assert (tmp_path / "report.html").read_bytes() == report.read_bytes()


def test_text_of_a_report_is_escaped(few):
    bad = replace(few.items[3], title="<b>T</b>", paper="<script>1</script>", reason="a & b")
    text = report_page(replace(few, items=(bad,)), {}).html()
    assert "<script>1" not in text and "<b>T" not in text
    assert "&lt;script&gt;1" in text and "a &amp; b" in text


def test_motion_has_its_numbers(motion):
    text, run = motion.read_text("utf-8"), CASE.simulate()
    for event in run.events:
        assert f"<td>{event.time:.10g}</td>" in text
    assert f"<td>{run.final['theta_dot']:.10g}</td>" in text
    assert text.count("<svg") == 2
    works = citation(run)
    assert len(works) >= 2
    for work in works:
        assert escape(work.title) in text and work.link in text
    assert "<math" in text


def test_page_of_a_motion_has_symbols_units_and_its_end_in_words(motion):
    text = motion.read_text("utf-8")
    assert "It reached the end time t = 0.001 s." in text and "(t_end)" not in text
    assert (
        f"<td>{symbol_mathml('theta_dot')}</td><td>theta_dot</td><td>1</td><td>rad/s</td>" in text
    )
    assert "<td>m/s<sup>2</sup></td><td>gravity</td>" in text
    assert "<td>2.09&nbsp;·&nbsp;10<sup>15</sup></td><td>Pa</td>" in text
    assert f'<th scope="col">{symbol_mathml("F_n")} (N)</th>' in text
    for doubt in ("onfirmed", "Probably", "only the title"):
        assert doubt not in text
    paper = citation(CASE.simulate())[0]
    assert (paper.authors, paper.venue, paper.doi) == ((), "", "")
    listed = text[text.index("Works to cite") :]
    assert "Impact model resolution on Painlev" in listed and "doi.org" in listed
    assert not any(work.unconfirmed for work in citation(CASE.simulate()))


def test_first_picture_is_the_mechanism_and_no_frame_of_a_film(motion):
    text = motion.read_text("utf-8")
    first, second = re.findall(r'<svg role="img" aria-label="([^"]*)"', text)
    assert (first, second) == ("The mechanism at the start", "Forces and motion over time")
    assert "slow motion" not in text


def test_pages_know_dark_mode_and_paper():
    text = HtmlPage("t", "").html()
    assert "color-scheme: light dark" in text and "prefers-color-scheme: dark" in text
    assert "background: #fff" in text  # figures are drawn for paper


@pytest.mark.slow
@needs_chromium
@pytest.mark.parametrize("name", ["report", "motion", "risk"])
def test_page_fits_a_phone(name, request):
    with chromium() as browser:
        page = browser.new_page(viewport={"width": 390, "height": 800})
        page.goto(f"file://{request.getfixturevalue(name)}")
        assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_command_of_a_page_computes_the_same(capsys):
    words = shlex.split(scenario_command(CASE))
    assert words[:2] == ["painleve", "simulate"]
    assert main([*words[1:], "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    run: Trajectory = CASE.simulate()
    assert data["final"]["state"] == run.final
    assert [e["time"] for e in data["events"]] == [e.time for e in run.events]


@pytest.mark.slow
def test_command_of_every_option(capsys):
    case = Scenario(
        "block-two-feet",
        state={"theta": 0.1},
        parameters={"beta": 0.05},
        law="A=hertz,B=rigid",
        t_end=0.01,
        until=("liftoff", "touchdown"),
        close="A:y_A",
        rtol=1e-8,
        max_steps=500,
        max_events=50,
        engine="compiled",
    )
    words = shlex.split(scenario_command(case))
    assert main([*words[1:], "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["final"]["state"] == case.simulate().final


@pytest.mark.slow
def test_report_of_a_file_shows_its_names_as_text(tmp_path, capsys):
    text = (ROOT / "examples" / "mechanisms" / "rod.toml").read_text("utf-8")
    text = text.replace('"rod-from-file"', '"<img src=x onerror=alert(1)>"')
    text = text.replace('source = "Impact', 'source = "<script>alert(2)</script>, Impact')
    assert "alert(2)" in text
    text = text.replace('meaning = "mass"', 'meaning = "<i>mass</i>"')
    (tmp_path / "own.toml").write_text(text, "utf-8")
    out = tmp_path / "page.html"
    words = ["simulate", str(tmp_path / "own.toml"), "--law", "rigid", "--t-end", "0.01"]
    assert main([*words, "--report", str(out)]) == 0
    assert f"report: {out}" in " ".join(capsys.readouterr().out.split())
    page = out.read_text("utf-8")
    assert "<img src=x" not in page and "<script>alert" not in page and "<i>mass" not in page
    assert "&lt;i&gt;mass" in page
    _Reader(page)


def test_report_needs_a_html_file(capsys):
    words = ["simulate", "rod", "--law", "rigid", "--t-end", "0.01", "--report", "page.pdf"]
    assert main(words) == 2
    assert "need one of .html" in capsys.readouterr().err


@pytest.mark.parametrize(
    "model",
    [
        "block-two-feet",
        pytest.param("painleve-klein", marks=pytest.mark.slow),
        pytest.param("eccentric-disc", marks=pytest.mark.slow),
    ],
)
def test_pages_of_other_mechanisms(model, tmp_path):
    case = Scenario(model, law="rigid", t_end=0.02)
    run_page(case, case.simulate()).write(tmp_path / "page.html")
    _Reader((tmp_path / "page.html").read_text("utf-8"))


@pytest.mark.slow
def test_rounding_at_the_end_is_shown_as_zero():
    case = Scenario("block-two-feet", law="rigid", t_end=0.5)
    run = case.simulate()
    assert 0 < abs(run.final["theta"]) < 1e-13
    text = run_page(case, run).html()
    end = text[text.index(">End<") : text.index("Energy balance")]
    assert f"<td>{symbol_mathml('theta')}</td><td>theta</td><td>0</td>" in end
    assert "10<sup>" not in end


def test_parts_of_a_page_are_escaped():
    page = HtmlPage(
        "<t>", table(["<c>"], [["<v>", 1.5, None, True]], "<l>"), [PageSection("<p>", "")]
    )
    text = page.html() + preformatted("<x>", "<y>") + unit_html("<u>")
    for letter in "tcvlpxyu":
        assert f"<{letter}>" not in text.replace("<p>Written", "")
    assert "<td>1.5</td><td></td><td>yes</td>" in text
    cells = table(["n"], [[-1.5e-7], [-0.0], [Html("<b>1</b>")], ["1e-7"]], "l")
    assert re.findall("<td>(.*?)</td>", cells) == [
        "\u22121.5&nbsp;·&nbsp;10<sup>\u22127</sup>", "0", "<b>1</b>", "1e-7",
    ]  # fmt: skip
    assert unit_html("kg m^2") == "kg m<sup>2</sup>" and unit_html("1") == ""


@pytest.mark.slow
@needs_chromium
@needs_axe
@pytest.mark.parametrize("name", ["report", "motion", "risk"])
def test_page_has_no_fault_of_accessibility(name, request):
    path = request.getfixturevalue(name)
    with chromium() as browser:
        page = browser.new_page()
        faults = []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto(f"file://{path}")
        assert violations(page) == [] == faults


@pytest.mark.slow
@needs_chromium
def test_verdicts_are_filtered(report):
    with chromium() as browser:
        page = browser.new_page()
        requests = []
        page.on("request", lambda request: requests.append(request.url))
        page.goto(f"file://{report}")
        rows = page.locator("#verdicts tbody tr:visible")
        assert rows.count() == len(FEW)
        page.get_by_role("button", name="misprint").click()
        assert rows.count() == 4
        assert page.get_by_role("status").inner_text() == f"4 of {len(FEW)} items"
        page.get_by_role("searchbox").fill("impulse")
        assert rows.count() == 1
        assert len(requests) == 1
        page.emulate_media(media="print")
        assert rows.count() == len(FEW)
        context = browser.new_context(java_script_enabled=False)
        plain = context.new_page()
        plain.goto(f"file://{report}")
        assert plain.locator("#verdicts tbody tr:visible").count() == len(FEW)
