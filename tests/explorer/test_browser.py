"""The page in headless Chromium: numbers, controls, drawings, accessibility."""

from __future__ import annotations

import dataclasses
import io
import json
import os
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageFilter

from painleve_sym import explore
from painleve_sym.errors import CompilerMissing
from painleve_sym.explorer.script import web_text
from tests.browser import chromium, needs_axe, needs_chromium, violations
from tests.cli.cli_helpers import only_contact, run_json

pytestmark = needs_chromium

SCREENS = Path(__file__).with_name("screens")
TABLE_3 = "theta=1&theta_dot=1&x_A_dot=-1&E=2.09e15&t-end=0.001"
STATE_3 = ("--state", "theta=1,theta_dot=1,x_A_dot=-1")
LAW_3 = ("--law", "bilinear-hertz", "--law-set", "E=20.9e14", "--t-end", "0.001")


@pytest.fixture(scope="module")
def browser():
    with chromium() as running:
        yield running


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Return the path of the page of a mechanism, made once; others than the rod's are compiled."""
    folder = tmp_path_factory.mktemp("pages")

    def path(name):
        file = folder / f"{name}.html"
        if not file.exists():
            try:
                explore(name, docs="..", out=file)
            except CompilerMissing as error:
                pytest.skip(str(error))
        return file

    return path


@pytest.fixture
def opened(browser, pages):
    """Return a function that opens a page from disk; at the end no fault may have been reported."""
    contexts, faults = [], []

    def open_page(name="rod", hash_="", **options):
        context = browser.new_context(viewport={"width": 1250, "height": 900}, **options)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda m: faults.append(m.text) if m.type == "error" else None)
        page.requests = []
        page.on("request", lambda request: page.requests.append(request.url))
        page.goto(f"file://{pages(name)}{f'#{hash_}' if hash_ else ''}")
        page.wait_for_selector("[data-ready]")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert faults == []


def settled(page):
    """Wait until what was changed is drawn."""
    page.evaluate("new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)))")


def until(page, condition):
    """Wait until a condition of the page holds; its policy forbids to do so in its own scripts."""
    for _ in range(200):
        if page.evaluate(condition):
            return
        page.wait_for_timeout(50)
    raise AssertionError(f"never: {condition}")


def set_slider(slider, value):
    """Move a slider, as the mouse would."""
    slider.evaluate(f"(s) => {{ s.value = {value}; s.dispatchEvent(new Event('input')); }}")


def take(page, name, text):
    """Write into the field of a quantity."""
    field = page.locator(f'input[name="{name}"]')
    field.fill(text)
    field.press("Tab")
    settled(page)
    return field


def rows(page, table):
    """Return the rows of a table: each a dict of numbers by name, with the event's words."""
    script = """(table) => [...table.tBodies[0].rows].map((row) => ({
      words: [...row.cells].filter((c) => !c.querySelector("data")).map((c) => c.textContent),
      ...Object.fromEntries(
        [...row.querySelectorAll("data")].map((d) => [d.dataset.name, +d.value]))
    }))"""
    return page.locator("table").nth(table).evaluate(script)


def coefficient(page, name):
    return float(page.locator(f'data[data-name="{name}"]').first.get_attribute("value"))


def number_field(page, name):
    return float(page.locator(f'input[name="{name}"]').input_value())


# ---- numbers ----


def test_page_opens_from_disk_without_a_request_and_has_the_numbers_of_the_command_line(
    opened, pages, capsys
):
    page = opened(hash_=TABLE_3)
    assert page.requests == [page.url.partition("#")[0]]
    assert pages("rod").stat().st_size < 650_000
    run = run_json(capsys, "simulate", "rod", *STATE_3, *LAW_3)
    compliant = rows(page, 1)
    assert len(compliant) == len(run["events"]) + 1
    for row, event in zip(compliant, run["events"], strict=False):
        assert row["words"][1] == event["kind"].replace("_", " ")
        assert row["time"] == pytest.approx(event["time"], rel=1e-12, abs=0)
        assert row["normal_force"] == pytest.approx(event["normal_force"], rel=1e-12, abs=1e-9)
        for name in ("x_A_dot", "y_A_dot", "theta_dot"):
            assert row[name] == pytest.approx(event["state"][name], rel=1e-12, abs=1e-12)
    assert compliant[-1]["theta_dot"] == pytest.approx(run["final"]["state"]["theta_dot"], 1e-12)
    jump = run_json(capsys, "jump", "rod", *STATE_3)
    after = rows(page, 0)
    assert after[2]["words"] == ["rigid: after the jump"]
    for name, value in jump["final"]["velocity"].items():
        assert after[2][name] == pytest.approx(value, rel=1e-12, abs=1e-12)
    at = run_json(capsys, "classify", "rod", *STATE_3)
    assert page.locator("[data-case]").get_attribute("data-case") == at["case"]
    for shown, name in (("A", "A"), ("B", "B"), ("A′", "A_stick"), ("B′", "B_stick")):
        assert coefficient(page, shown) == pytest.approx(only_contact(at)[0][name], rel=1e-12)


@pytest.mark.slow
def test_every_solution_of_the_contact_problem_is_marked(opened, capsys):
    for theta, theta_dot, count in ((0.5, 1, 1), (1, 1, 0), (1, 5, 2)):
        page = opened(hash_=f"theta={theta}&theta_dot={theta_dot}")
        words = f"theta={theta},theta_dot={theta_dot},x_A_dot=-1"
        at = run_json(capsys, "classify", "rod", "--state", words)
        assert len(at["solutions"]) == count
        assert page.locator("circle.solution").count() == count
        values = page.locator(".solutions data").evaluate_all("(all) => all.map((d) => +d.value)")
        forces = [s["normal_force"] for s in only_contact(at)[1]]
        assert sorted(values) == pytest.approx(sorted(forces), rel=1e-12)


@pytest.mark.slow
def test_outcome_map_runs_ten_thousand_motions(opened):
    page = opened(hash_="map-of=outcomes")
    page.wait_for_selector("[data-seconds]")
    counts = json.loads(page.locator("svg.map").get_attribute("data-counts"))
    assert sum(counts.values()) == 10_000
    assert counts["slip_stop"] > 500 and counts["separation"] > 500 and counts["open"] > 500
    assert "10000 motions with the law bilinear-hertz" in page.locator(".map ~ .note").inner_text()
    # Each outcome stands in the legend with its part of the map.
    legend = page.locator(".map + .legend").inner_text()
    for outcome, text in (("open", "lifts off at once"), ("slip_stop", "the slip stops")):
        (part,) = re.findall(rf"{text} \(([\d.]+) %\)", legend)
        assert float(part) == pytest.approx(counts[outcome] / 100, rel=0.05)
    # What happens at the same instant as a deciding event is not the outcome.
    other = opened(hash_="theta_dot=5&E=2.09e15&law-reload=virgin&map-of=outcomes")
    other.wait_for_selector("[data-seconds]")
    outcomes = json.loads(other.locator("svg.map").get_attribute("data-counts"))
    deciding = {"slip_stop", "separation", "liftoff", "jam", "left_domain"}
    assert outcomes.keys() <= deciding | {"open", "no event", "outside"}
    # A change while it fills begins it again, and the shown motion stays that of the start.
    before = rows(page, 1)
    take(page, "x_A_dot", "-2")
    take(page, "x_A_dot", "-1")
    page.wait_for_selector(".map ~ .note:has-text('10000 motions')")
    assert rows(page, 1) == before


# ---- controls ----


@pytest.mark.slow
def test_slider_field_and_keys_change_the_numbers_and_the_address(opened):
    page = opened()
    before = coefficient(page, "A")
    slider = page.get_by_label("angle from the ground to the rod (theta)", exact=True)
    set_slider(slider, 500)
    settled(page)
    assert coefficient(page, "A") != before
    assert number_field(page, "theta") == pytest.approx(np.pi / 2, abs=1e-2)
    assert f"theta={page.locator('input[name=theta]').input_value()}" in page.url
    slider.focus()
    page.keyboard.press("ArrowLeft")
    settled(page)
    assert number_field(page, "theta") < 1.57
    take(page, "mu", "0.5")
    assert coefficient(page, "μ") == 0.5
    assert "mu=0.5" in page.url
    alert, status = page.get_by_role("alert").first, page.locator(".controls > [role=status]")
    for text, shown in (("-1", "-1"), ("", "nothing that is a number")):
        field = take(page, "mu", text)
        assert alert.inner_text() == f"mu: got {shown}, need a finite number with 0 <= mu."
        assert field.get_attribute("aria-invalid") == "true"
        assert coefficient(page, "μ") == 0.5
    # What was done is a status and not an alert.
    page.get_by_role("button", name="Copy link").click()
    until(page, "document.querySelector('.controls > [role=status]').textContent !== ''")
    assert "link" in status.inner_text() and alert.inner_text() == ""


def test_few_controls_stand_first_and_the_pictures_are_two_keys_away(opened):
    page = opened()
    shown = page.locator(".controls > .field .name").all_inner_texts()
    assert [text.split(" ")[0] for text in shown] == [
        *("θ", "x\u0307A", "θ\u0307", "μ", "E", "eenergetic", "t", "Fn"),
    ]
    assert page.locator("details[open]").count() == 0
    assert page.locator("input[name=nu]").is_visible() is False
    page.locator("summary", has_text="Contact law").click()
    assert page.locator("input[name=nu]").is_visible()
    # Skip to the pictures, and the next key plays.
    page.locator("button.skip").focus()
    page.keyboard.press("Enter")
    for _ in range(4):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.textContent") == "Play":
            break
    assert page.evaluate("document.activeElement.textContent") == "Play"


@pytest.mark.slow
def test_numbers_fit_their_fields(opened):
    page = opened("strut")
    field = page.locator("input[name=theta]")
    assert field.input_value() == "0.92729522"
    assert field.evaluate("(f) => f.scrollWidth <= f.clientWidth")
    # Arrow keys leave few digits, and the address all of those of the start.
    page.locator("g.point").focus()
    page.keyboard.press("ArrowRight")
    settled(page)
    assert len(field.input_value()) <= 8
    assert "θ = 0.9" in page.locator("g.point").get_attribute("aria-valuetext")


@pytest.mark.slow
def test_the_law_and_its_choices_stand_on_the_page(opened):
    page = opened()
    law = page.locator("p.law")
    curves = page.locator(".motion .legend li").evaluate_all(
        "(all) => all.map((li) => [li.textContent, li.firstChild.className.split(' ')[2]])"
    )
    assert curves == [
        *(
            [f"{name}, {kind}", force]
            for kind in ("compliant", "rigid")
            for name, force in (("Fn", "normal"), ("Ft", "tangential"))
        ),
        ["events, numbered as below", "event"],
    ]
    # Symbols are typeset: no index stands on the line.
    texts = "(all) => all.map((e) => e.textContent).filter((text) => /\\p{L}_/u.test(text))"
    shown = page.locator("li, p, th, dt, .name, svg text, svg tspan")
    assert shown.count() > 50 and shown.evaluate_all(texts) == []
    assert law.inner_text() == (
        "Contact law: bilinear-hertz, reload elastic; beside it rigid, restitution energetic, "
        "impact friction path, policy liftoff."
    )
    events = [row["words"][1] for row in rows(page, 1)]
    page.get_by_label("reload").select_option("virgin")
    settled(page)
    assert "reload virgin" in law.inner_text() and "law-reload=virgin" in page.url
    # No compression begins again in this motion.
    assert [row["words"][1] for row in rows(page, 1)] == events
    notes = page.locator(".motion .note p").all_inner_texts()
    assert [n.split(" to ")[0] for n in notes] == [
        f"{kind}: the energy balance closes" for kind in ("compliant", "rigid")
    ]
    # In Table 1 it does, many times, and each creates energy.
    page.get_by_label("from the paper").select_option(index=1)
    settled(page)
    assert "by the reload rule virgin" in page.locator(".motion div.note").inner_text()


@pytest.mark.slow
def test_a_law_without_reload_has_no_choice_of_it(opened):
    assert opened("strut").get_by_label("reload").count() == 0


def test_controls_stay_beside_the_pictures(opened):
    page = opened()
    page.set_viewport_size({"width": 1400, "height": 900})
    boxes = [page.locator(f).bounding_box() for f in (".controls", ".views")]
    assert boxes[0]["x"] + boxes[0]["width"] <= boxes[1]["x"]
    assert page.locator(".motion svg").last.bounding_box()["y"] < 300
    page.locator("table").last.scroll_into_view_if_needed()
    assert page.locator("input[name=theta]").bounding_box()["y"] >= 0


def test_on_a_phone_the_chosen_slider_is_below_the_picture(opened):
    page = opened()
    page.set_viewport_size({"width": 390, "height": 844})
    fields = page.locator(".controls .field:visible")
    assert fields.count() == 1 and "θ" in fields.inner_text()
    drawer = page.get_by_role("button", name="All controls")
    drawer.click()
    assert fields.count() == 8 and page.locator(".controls").bounding_box()["height"] < 0.6 * 844
    page.locator("input[name=mu]").focus()
    page.get_by_role("button", name="Close", exact=True).click()
    assert fields.count() == 1 and "friction" in fields.inner_text()
    # A picture and the slider are in sight together, wherever the page is.
    figure = page.locator("svg.map")
    figure.scroll_into_view_if_needed()
    box, controls = figure.bounding_box(), page.locator(".controls").bounding_box()
    assert box["y"] < 844 / 2 and abs(controls["y"] + controls["height"] - 844) < 1


@pytest.mark.slow
def test_every_control_can_be_touched(opened):
    page = opened("block-two-feet")
    page.set_viewport_size({"width": 390, "height": 844})
    page.get_by_role("button", name="All controls").click()
    for details in page.locator("details").all():
        details.evaluate("(d) => { d.open = true; }")
    sizes = page.locator("button, input, select, summary, .row label").evaluate_all(
        "(all) => all.filter((e) => e.checkVisibility() && e.type !== 'radio')"
        ".map((e) => [e.outerHTML.slice(0, 80), e.getBoundingClientRect().toJSON()])"
    )
    small = [html for html, box in sizes if min(box["width"], box["height"]) < 24]
    assert len(sizes) > 30 and small == []


@pytest.mark.slow
def test_point_on_the_map_follows_the_mouse_and_the_arrow_keys(opened):
    page = opened()
    page.locator("svg.map").scroll_into_view_if_needed()
    box = page.locator("svg.map").bounding_box()
    middle = (box["x"] + 0.6 * box["width"], box["y"] + 0.35 * box["height"])
    point = page.locator("g.point circle").last.bounding_box()
    page.mouse.move(point["x"] + point["width"] / 2, point["y"] + point["height"] / 2)
    page.mouse.down()
    page.mouse.move(*middle, steps=4)
    page.mouse.up()
    settled(page)
    theta, theta_dot = number_field(page, "theta"), number_field(page, "theta_dot")
    assert theta > 1.5 and theta_dot > 1
    assert page.locator("[data-case]").get_attribute("data-case") == "slip"
    # The mouse no longer drags.
    page.mouse.move(middle[0] + 50, middle[1])
    settled(page)
    assert number_field(page, "theta") == theta
    page.locator("g.point").focus()
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Shift+ArrowRight")
    settled(page)
    assert number_field(page, "theta_dot") == pytest.approx(theta_dot + 0.1)
    assert number_field(page, "theta") == pytest.approx(theta + 0.3124, abs=1e-3)
    assert "slip" in page.locator("g.point").get_attribute("aria-valuetext")


@pytest.mark.slow
def test_a_link_shares_everything(opened):
    page = opened(hash_="theta=1.05&theta_dot=4.5&E=2.09e15&initial-force=200&map-over=theta,mu")
    set_slider(page.locator("input[aria-label='time of the animation']"), 0.25)
    settled(page)
    assert "play-at=0.25" in page.url
    other = opened(hash_=page.url.partition("#")[2])
    for name in ("theta", "theta_dot", "E", "initial-force"):
        assert number_field(other, name) == number_field(page, name)
    assert rows(other, 1) == rows(page, 1)
    assert other.locator("output.time").inner_text() == page.locator("output.time").inner_text()
    # An address that is typed into an open page is read, and what cannot be taken is named.
    page.evaluate("location.hash = 'theta=0.5&mu=-2'")
    until(page, "document.querySelector('input[name=theta]').value === '0.5'")
    assert "mu=-2" in page.get_by_role("alert").first.inner_text()


@pytest.mark.slow
def test_presets_are_the_tables_of_the_paper(opened):
    page = opened()
    select = page.get_by_label("from the paper")
    names = select.locator("option").all_inner_texts()[1:]
    cases = ["slip", "liftoff", "inconsistent", "indeterminate", "indeterminate", "indeterminate"]
    assert [name.split(":")[0] for name in names] == [f"Table {i}" for i in range(1, 7)]
    for name, case in zip(names, cases, strict=True):
        select.select_option(label=name)
        settled(page)
        assert page.locator("[data-case]").get_attribute("data-case") == case
        assert len(page.locator(".presets .note").inner_text()) > 40
    # Pressed with 350 N the rod has an impact, with 300 N it lifts off.
    assert rows(page, 1)[0]["words"][1] == "slip stop"
    select.select_option(label=names[4])
    settled(page)
    assert "slip stop" not in [row["words"][1] for row in rows(page, 1)]
    page.get_by_role("button", name="Reset").click()
    settled(page)
    assert "#" not in page.url
    assert select.input_value() == ""


@pytest.mark.slow
def test_a_motion_without_force_and_a_start_at_the_edge_have_readable_pictures(opened):
    page = opened()
    page.get_by_label("from the paper").select_option(label="Table 4: two solutions")
    settled(page)
    assert "no contact force until the end" in page.locator(".motion svg").last.inner_html()
    # The point is inside its map, not on the edge of it.
    point, frame = (
        page.locator(f).bounding_box() for f in ("g.point circle:last-child", "svg.map image")
    )
    middle = point["y"] + point["height"] / 2
    assert frame["y"] + 0.05 * frame["height"] < middle < frame["y"] + 0.95 * frame["height"]
    outside = opened(hash_="y_A=-0.1")
    assert outside.locator("p.fault").inner_text() == (
        "rigid: the start is inside the ground, gap = -0.1 m, and a rigid contact has no "
        "compression. Fix: start with gap >= 0, or give a compliant law."
    )
    flat = opened(hash_="theta=3.1&theta_dot=3&t-end=0.05&map-of=outcomes")
    notes = flat.locator(".motion .note p").all_inner_texts()
    assert [n.partition(" s: ")[2] for n in notes[::2]] == ["the rod lies flat at theta = pi."] * 2
    flat.wait_for_selector("[data-seconds]")
    assert "the rod lies flat (" in flat.locator(".legend").nth(1).inner_text()


@pytest.mark.slow
def test_animation_plays_pauses_and_magnifies_impacts(opened):
    page = opened(hash_=TABLE_3)
    page.get_by_role("button", name="Play").click()
    scrub = page.locator("input[aria-label='time of the animation']")
    until(page, "document.querySelector('input[aria-label^=time]').value > 0.05")
    assert page.locator(".scene path.body").count() == 2
    page.get_by_role("button", name="Pause").click()
    stopped = scrub.input_value()
    page.wait_for_timeout(200)
    assert scrub.input_value() == stopped
    set_slider(scrub, 0.5)
    magnified, forces = page.locator("output.time").inner_text(), page.locator(".motion svg").last
    assert "times slower" in magnified
    assert "time (s), magnified where it is short" in forces.inner_html()
    set_slider(page.get_by_label("magnify short times"), 0)
    settled(page)
    assert page.locator("output.time").inner_text() == "t = 5·10⁻⁴ s"
    assert "magnified" not in forces.inner_html() and "time (s)" in forces.inner_html()


def test_reduced_motion_shows_still_pictures(opened):
    page = opened(hash_=TABLE_3, reduced_motion="reduce")
    page.get_by_role("button", name="Play").click()
    scrub = page.locator("input[aria-label='time of the animation']")
    page.wait_for_timeout(300)
    assert float(scrub.input_value()) == 0
    until(page, "document.querySelector('input[aria-label^=time]').value > 0")
    assert float(scrub.input_value()) >= 0.08


@pytest.mark.slow
def test_a_contact_that_opened_can_be_closed_again(opened):
    page = opened("strut")
    take(page, "theta", "0.8")
    note = page.locator("p.note", has_text="The contact is open")
    assert "here it is taken as closed" in note.inner_text()
    page.get_by_role("button", name="Close the contact").click()
    settled(page)
    assert note.count() == 0


@pytest.mark.parametrize("name", ["block-two-feet", "painleve-klein", "strut"])
@pytest.mark.slow
def test_other_mechanisms_have_pages_too(opened, pages, name):
    page = opened(name, "play-at=0.5")
    assert pages(name).stat().st_size < 650_000
    assert page.locator("[data-case]").inner_text()
    assert page.locator(".scene .body, .scene .dot").count() >= 1
    assert page.locator(".fault p, p.fault").count() == 0
    regions = json.loads(page.locator("svg.map").get_attribute("data-counts"))
    assert len(regions.keys() - {"outside"}) >= 2
    # The strut turns about a fixed pin, over a surface that moves.
    scenes = page.locator(".scene").count()
    counts = [page.locator(f".scene {kind}").count() for kind in (".pin", "path.belt", ".ground")]
    own = scenes * (name == "strut")
    grounds = scenes * (2 if name == "block-two-feet" else 1)
    assert counts == [own, own, grounds]


def test_words_are_explained_and_panels_lead_to_the_documentation(opened):
    page = opened()
    marked = page.locator("abbr").evaluate_all("(all) => all.map((a) => [a.textContent, a.title])")
    titles = dict(marked)
    assert titles["A"].startswith("normal acceleration per normal force")
    assert titles["flight, indented"].startswith("the contact carries no force")
    assert titles["separation"] == "the normal force falls to zero"
    assert all(titles.values())
    hrefs = "(all) => all.map((a) => a.getAttribute('href'))"
    links = page.locator("section a").evaluate_all(hrefs)
    pages = ("impacts", "maps", "complementarity", "reference/events")
    assert links == [f"../{name}.html" for name in pages]
    assert "stands alone" not in page.locator("footer").inner_text()
    page.locator("summary", has_text="Words").click()
    assert page.locator("footer dd").count() == len(explore("rod").data["words"])


def test_a_page_without_documentation_has_no_links_and_says_why(browser, tmp_path):
    file = tmp_path / "alone.html"
    explore("rod", out=file)
    page = browser.new_page()
    page.goto(f"file://{file}")
    page.wait_for_selector("[data-ready]")
    assert page.locator("section code").count() == 0
    assert page.locator("a").count() == 0
    assert "painleve explore --docs ADDRESS adds links" in page.locator("footer").inner_text()
    page.close()


@pytest.mark.slow
def test_many_events_are_counted_where_not_all_are_shown(opened):
    page = opened("block-two-feet", "t-end=0.1")
    count = len(rows(page, 1))
    (text,) = [t for t in page.locator(".motion .legend li").all_inner_texts() if "events" in t]
    lines = page.locator(".motion svg .event").count()
    assert lines == 60 and re.fullmatch(r"events, the first 60 of \d+", text)
    total = int(text.split()[-1])
    assert total > 200 and count == 201
    caption = page.locator("caption").nth(1).inner_text()
    assert caption == f"Events, compliant, the first 200 of {total}"


def test_each_colour_has_one_meaning():
    text = web_text("style.css")
    for scheme in text.split("@media (prefers-color-scheme: dark)")[:2]:
        block = scheme[scheme.index("--text") :].partition("}")[0]
        colours = dict(re.findall(r"--([\w-]+): (#\w{6});", block))
        del colours["page"], colours["panel"], colours["text"]
        assert len(colours) > 15 and len(set(colours.values())) == len(colours)


def test_a_page_whose_texts_are_hostile_opens(browser, tmp_path):
    shown = explore("rod")
    description = json.loads(json.dumps(shown.data["description"]))
    description["mechanism"]["title"] = title = "a <!-- b <script> c </script><b>d"
    page = browser.new_page()
    path = tmp_path / "hostile.html"
    dataclasses.replace(shown, data={**shown.data, "description": description}).save(path)
    page.goto(f"file://{path}")
    page.wait_for_selector("[data-ready]")
    assert page.locator("header p").first.inner_text() == f"{title}."
    page.close()


@pytest.mark.slow
def test_a_bent_rod_is_drawn_bent(opened):
    page = opened("rod-bending", "play-at=0.5")
    assert "Deflections are drawn " in page.locator(".motion div.note").inner_text()
    d = page.locator(".scene path.stick").first.get_attribute("d")
    x, y = np.array([p.split() for p in d[1:].split("L")], float).T
    assert len(x) == 21
    chord = np.hypot(x[-1] - x[0], y[-1] - y[0])
    away = ((x - x[0]) * (y[-1] - y[0]) - (y - y[0]) * (x[-1] - x[0])) / chord**2
    assert 0.01 < abs(away).max() < 0.2


# ---- browsers, sizes, people ----


def test_a_browser_without_webassembly_or_scripts_is_told_so(browser, pages):
    context = browser.new_context()
    context.add_init_script("delete globalThis.WebAssembly;")
    page = context.new_page()
    page.goto(f"file://{pages('rod')}")
    text = page.get_by_role("alert").inner_text()
    assert text.startswith("This page computes with WebAssembly, which this browser lacks")
    context.close()
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(f"file://{pages('rod')}")
    assert "needs JavaScript with WebAssembly" in page.locator("body").inner_text()
    context.close()


@pytest.mark.parametrize("width", [320, 390, 768, 1600])
@pytest.mark.slow
def test_no_width_needs_scrolling_sideways(opened, width):
    page = opened("block-two-feet")
    page.set_viewport_size({"width": width, "height": 800})
    assert page.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.slow
@needs_axe
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", ["rod", "block-two-feet", "painleve-klein"])
def test_axe_finds_no_violation(opened, name, scheme):
    page = opened(name, "mu=3&map-over=x", color_scheme=scheme, bypass_csp=True)
    assert page.get_by_role("alert").first.inner_text() != ""
    for details in page.locator("details").all():
        details.evaluate("(d) => { d.open = true; }")
    assert violations(page) == []
    page.set_viewport_size({"width": 360, "height": 800})
    page.get_by_role("button", name="All controls").click()
    page.locator("input[value=outcomes]").check()
    page.wait_for_selector("[data-seconds]")
    assert violations(page) == []


# ---- screenshots ----

STATES = {
    "no-solution": ("rod", f"{TABLE_3}&play-at=0.3", 1200, "light"),
    "two-solutions-phone": ("rod", "theta_dot=5&E=2.09e15&initial-force=300", 390, "dark"),
    "slip": ("rod", "theta=0.5&t-end=0.02&play-at=0.4", 800, "light"),
    "two-feet": ("block-two-feet", "play-at=0.5", 1200, "dark"),
    "guide": ("painleve-klein", "play-at=0.5", 1200, "light"),
}
SIZE = (360, 900)
"""Largest width and height of the pictures that are kept."""
MEAN, WORST = 4.0, 60.0
"""Differences of blurred pixels, of 255: fonts differ between machines, drawings must not."""


def screen(opened, state):
    """Return a small picture of a whole page."""
    name, hash_, width, scheme = state
    page = opened(name, hash_, color_scheme=scheme)
    page.set_viewport_size({"width": width, "height": 900})
    settled(page)
    image = Image.open(io.BytesIO(page.screenshot(full_page=True))).convert("RGB")
    image.thumbnail(SIZE, Image.Resampling.LANCZOS)
    return image


def difference(image, other):
    """Return mean and 99.9th percentile of the difference of two blurred pictures."""
    pair = (image.convert("RGB"), other.convert("RGB").resize(image.size))
    a, b = (np.asarray(i.filter(ImageFilter.GaussianBlur(3)), float) for i in pair)
    return float(np.abs(a - b).mean()), float(np.percentile(np.abs(a - b), 99.9))


@pytest.mark.parametrize(
    "state",
    [
        pytest.param(s, marks=() if s in ("slip", "two-solutions-phone") else pytest.mark.slow)
        for s in STATES
    ],
)
def test_page_looks_as_it_did_when_it_was_last_looked_at(opened, state, tmp_path):
    image, file = screen(opened, STATES[state]), SCREENS / f"{state}.png"
    if os.environ.get("EXPLORER_SCREENS") == "write":
        image.quantize(128, Image.Quantize.MAXCOVERAGE).save(file, optimize=True)
    reference = Image.open(file)
    image.save(tmp_path / file.name)
    assert abs(image.height - reference.height) <= 0.04 * reference.height
    mean, worst = difference(image, reference)
    assert mean < MEAN and worst < WORST, f"{mean:.1f}, {worst:.1f}: see {tmp_path / file.name}"


@pytest.mark.slow
def test_the_comparison_of_screenshots_notices_another_state(opened):
    pictures = [
        Image.open(SCREENS / f"{name}.png") for name in ("no-solution", "two-feet", "guide")
    ]
    for i, first in enumerate(pictures):
        for second in pictures[:i]:
            mean, worst = difference(first, second)
            assert mean > MEAN or worst > WORST
    moved = screen(opened, ("rod", f"{TABLE_3}&play-at=0.3&theta=1.3", 1200, "light"))
    mean, worst = difference(moved, pictures[0])
    assert mean > MEAN or worst > WORST
