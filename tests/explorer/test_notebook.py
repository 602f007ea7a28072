"""The explorer as a notebook's widget."""

from __future__ import annotations

import importlib.util
import json
import re

import pytest

import painleve_sym as ps
from painleve_sym.explorer import wasm
from tests.browser import chromium, needs_chromium

TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
needs_anywidget = pytest.mark.skipif(
    importlib.util.find_spec("anywidget") is None,
    reason="anywidget is not installed (pip install 'painleve-sym[notebook]')",
)


def motion(**law_parameters):
    return ps.simulate("rod", "bilinear-hertz", TABLE_3, t_end=1e-3, law_parameters=law_parameters)


@needs_anywidget
@pytest.mark.parametrize("reload", ["elastic", "virgin"])
def test_widget_of_the_default_law_needs_no_compiler(monkeypatch, tmp_path, reload):
    law = ps.law("bilinear-hertz", reload=reload)
    run = ps.simulate("rod", law, TABLE_3, t_end=1e-3)
    monkeypatch.setenv("PAINLEVE_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(wasm, "compiler", lambda: pytest.fail("asked for a compiler"))
    assert run.explore().data["initial"]["reload"] == reload


@needs_anywidget
def test_widget_of_a_motion_begins_with_its_numbers():
    widget = motion(E=20.9e14).explore()
    assert widget.values | TABLE_3 | {"E": 20.9e14, "mu": 1.4} == widget.values
    assert widget.data["initial"]["end"] == 1e-3
    json.dumps(widget.data)
    widget.settings = {"values": {"mu": 1.2}}
    assert widget.values["mu"] == 1.2


@pytest.mark.slow
@needs_anywidget
@needs_chromium
def test_widget_draws_within_a_cell_and_reports_what_is_changed(tmp_path):
    widget = motion().explore()
    esm = re.sub(r"export default \{ render \};", "globalThis.render = render;", str(widget._esm))
    path = tmp_path / "cell.html"
    path.write_text(
        f"<!doctype html><div id='cell'></div><script type='module'>{esm}\n"
        "const state = JSON.parse(document.getElementById('state').textContent);\n"
        "const model = { get: (k) => state[k], set: (k, v) => (globalThis.changed = v),\n"
        "  save_changes() {} };\n"
        "globalThis.render({ model, el: document.getElementById('cell') });</script>"
        f"<script type='application/json' id='state'>{json.dumps({'data': widget.data})}</script>",
        "utf-8",
    )
    with chromium() as browser:
        page = browser.new_page()
        page.goto(f"file://{path}")
        page.wait_for_selector("[data-ready]")
        field = page.locator("input[name=mu]")
        field.fill("1.1")
        field.press("Tab")
        assert page.evaluate("globalThis.changed.values.mu") == 1.1
        # Within a notebook the address is not the page's own.
        assert "#" not in page.url
        assert page.locator("button", has_text="Copy link").count() == 0


def test_widget_without_anywidget_or_mechanism_is_an_error(monkeypatch, tmp_path):
    run = motion()
    run.save(tmp_path / "run.npz")
    stored = ps.Trajectory.load(tmp_path / "run.npz")
    with pytest.raises(ps.InputError, match=r"call painleve_sym\.explore"):
        stored.explore()
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ps.InputError, match=r"painleve-sym\[notebook\]"):
        run.explore()
