"""The page in headless Chromium: numbers, controls, drawings, accessibility."""

from __future__ import annotations

import io
import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageFilter

from painleve_sym import explore
from tests.browser import chromium, needs_axe, needs_chromium, violations
from tests.cli.cli_helpers import run_json

pytestmark = needs_chromium

SCREENS = Path(__file__).with_name("screens")
TABLE_3 = "theta=1&theta_dot=1&x_A_dot=-1&E=2.09e15&t-end=0.001"
STATE_3 = ("--state", "theta=1,theta_dot=1,x_A_dot=-1")
LAW_3 = ("--law", "bilinear-hertz", "--law-set", "E=20.9e14,reload=virgin", "--t-end", "0.001")


@pytest.fixture(scope="module")
def browser():
    with chromium() as running:
        yield running


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Return the path of the page of a mechanism, made once."""
    folder = tmp_path_factory.mktemp("pages")

    def path(name):
        file = folder / f"{name}.html"
        if not file.exists():
            explore(name, out=file)
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
    assert pages("rod").stat().st_size < 400_000
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
        assert coefficient(page, shown) == pytest.approx(at[name], rel=1e-12)


def test_every_solution_of_the_contact_problem_is_marked(opened, capsys):
    for theta, theta_dot, count in ((0.5, 1, 1), (1, 1, 0), (1, 5, 2)):
        page = opened(hash_=f"theta={theta}&theta_dot={theta_dot}")
        words = f"theta={theta},theta_dot={theta_dot},x_A_dot=-1"
        at = run_json(capsys, "classify", "rod", "--state", words)
        assert len(at["solutions"]) == count
        assert page.locator("circle.solution").count() == count
        values = page.locator(".solutions data").evaluate_all("(all) => all.map((d) => +d.value)")
        forces = [s["normal_force"] for s in at["solutions"]]
        assert sorted(values) == pytest.approx(sorted(forces), rel=1e-12)


def test_outcome_map_runs_ten_thousand_motions(opened):
    page = opened(hash_="map-of=outcomes")
    page.wait_for_selector("[data-seconds]")
    counts = json.loads(page.locator("svg.map").get_attribute("data-counts"))
    assert sum(counts.values()) == 10_000
    assert counts["slip_stop"] > 500 and counts["separation"] > 500 and counts["open"] > 500
    assert "10000 motions with the law bilinear-hertz" in page.locator(".map ~ .note").inner_text()
    # A change while it fills begins it again, and the shown motion stays that of the start.
    before = rows(page, 1)
    field = page.locator("input[name=x_A_dot]")
    field.fill("-2")
    field.press("Tab")
    field.fill("-1")
    field.press("Tab")
    settled(page)
    page.wait_for_selector(".map ~ .note:has-text('10000 motions')")
    assert rows(page, 1) == before


# ---- controls ----


def test_slider_field_and_keys_change_the_numbers_and_the_address(opened):
    page = opened()
    before = coefficient(page, "A")
    slider = page.get_by_label("angle from the ground to the rod (theta)", exact=True)
    slider.evaluate("(s) => { s.value = 500; s.dispatchEvent(new Event('input')); }")
    settled(page)
    assert coefficient(page, "A") != before
    assert number_field(page, "theta") == pytest.approx(np.pi / 2, abs=1e-2)
    assert f"theta={page.locator('input[name=theta]').input_value()}" in page.url
    slider.focus()
    page.keyboard.press("ArrowLeft")
    settled(page)
    assert number_field(page, "theta") < 1.57
    field = page.locator("input[name=mu]")
    field.fill("0.5")
    field.press("Tab")
    settled(page)
    assert coefficient(page, "μ") == 0.5
    assert "mu=0.5" in page.url
    field.fill("-1")
    field.press("Tab")
    assert "need a finite number with 0 <= mu" in page.get_by_role("alert").first.inner_text()
    assert field.get_attribute("aria-invalid") == "true"
    settled(page)
    assert coefficient(page, "μ") == 0.5


def test_point_on_the_map_follows_the_mouse_and_the_arrow_keys(opened):
    page = opened()
    box = page.locator("svg.map").bounding_box()
    middle = (box["x"] + 0.6 * box["width"], box["y"] + 0.3 * box["height"])
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


def test_a_link_shares_everything(opened):
    page = opened(hash_="theta=1.05&theta_dot=4.5&E=2.09e15&initial-force=200&map-over=theta,mu")
    page.locator("input[aria-label='time of the animation']").evaluate(
        "(s) => { s.value = 0.25; s.dispatchEvent(new Event('input')); }"
    )
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
    scrub.evaluate("(s) => { s.value = 0.5; s.dispatchEvent(new Event('input')); }")
    magnified = page.locator("output.time").inner_text()
    assert "times slower" in magnified
    magnify = page.get_by_label("magnify impacts")
    magnify.evaluate("(s) => { s.value = 0; s.dispatchEvent(new Event('input')); }")
    settled(page)
    assert page.locator("output.time").inner_text() == "t = 5·10⁻⁴ s"


def test_reduced_motion_shows_still_pictures(opened):
    page = opened(hash_=TABLE_3, reduced_motion="reduce")
    page.get_by_role("button", name="Play").click()
    scrub = page.locator("input[aria-label='time of the animation']")
    page.wait_for_timeout(300)
    assert float(scrub.input_value()) == 0
    until(page, "document.querySelector('input[aria-label^=time]').value > 0")
    assert float(scrub.input_value()) >= 0.08


def test_a_contact_that_opened_can_be_closed_again(opened):
    page = opened("two-link-arm")
    field = page.locator("input[name=theta_2]")
    field.fill("-0.7")
    field.press("Tab")
    settled(page)
    note = page.locator("p.note", has_text="The contact is open")
    assert "here it is taken as closed" in note.inner_text()
    page.get_by_role("button", name="Close the contact").click()
    settled(page)
    assert note.count() == 0


@pytest.mark.parametrize("name", ["block-two-feet", "painleve-klein", "eccentric-disc", "strut"])
def test_other_mechanisms_have_pages_too(opened, pages, name):
    page = opened(name, "play-at=0.5")
    assert pages(name).stat().st_size < 400_000
    assert page.locator("[data-case]").inner_text()
    assert page.locator(".scene .body, .scene .dot").count() >= 1
    assert page.locator(".fault").count() == 0


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
def test_no_width_needs_scrolling_sideways(opened, width):
    page = opened("block-two-feet")
    page.set_viewport_size({"width": width, "height": 800})
    assert page.evaluate("document.documentElement.scrollWidth") <= width


@needs_axe
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", ["rod", "block-two-feet", "painleve-klein"])
def test_axe_finds_no_violation(opened, name, scheme):
    page = opened(name, "mu=3&map-over=x", color_scheme=scheme, bypass_csp=True)
    assert page.get_by_role("alert").first.inner_text() != ""
    assert violations(page) == []
    page.set_viewport_size({"width": 360, "height": 800})
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


@pytest.mark.parametrize("state", list(STATES))
def test_page_looks_as_it_did_when_it_was_last_looked_at(opened, state, tmp_path):
    image, file = screen(opened, STATES[state]), SCREENS / f"{state}.png"
    if os.environ.get("EXPLORER_SCREENS") == "write":
        image.quantize(128, Image.Quantize.MAXCOVERAGE).save(file, optimize=True)
    reference = Image.open(file)
    image.save(tmp_path / file.name)
    assert abs(image.height - reference.height) <= 0.04 * reference.height
    mean, worst = difference(image, reference)
    assert mean < MEAN and worst < WORST, f"{mean:.1f}, {worst:.1f}: see {tmp_path / file.name}"


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
