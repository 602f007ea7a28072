"""Statements of pages that no other test reads, beside what the package does."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

import painleve_sym as ps

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"


def words(name):
    """Return the text of a page on one line."""
    return " ".join((DOCS / name).read_text("utf-8").split())


def test_stability_is_promised_in_one_place_and_linked_from_the_others():
    pages = [*DOCS.glob("*.md"), *DOCS.glob("*/*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    promise = re.compile(r"no promise|promises (no )?compatib|second name|keys? (that )?stay", re.I)
    promising = {p.name for p in pages if promise.search(" ".join(p.read_text("utf-8").split()))}
    assert promising == {"project.md"}
    for page in ("api.md", "cli.md", "reference/json-keys.md"):
        assert "project.md#stability" in words(page)
    for path in ("CONTRIBUTING.md", ".github/PULL_REQUEST_TEMPLATE.md"):
        assert "docs/project.md#stability" in (ROOT / path).read_text("utf-8")


def test_notice_on_a_body_that_is_not_rigid_has_the_numbers_of_the_page():
    run = ps.simulate("rod", "bilinear-hertz", material="steel", t_end=0.01)
    (notice,) = (n for n in run.notices if "not rigid" in n)
    contact, period = map(float, re.findall(r"([\d.]+) s\b", notice)[:2])
    shown = f"the contact lasts {1e3 * contact:g} ms and the first bending period of the bar is"
    assert f"{shown} {period:g} s" in words("mechanisms.md")


def test_limits_of_pages_are_those_of_the_package():
    limits = inspect.signature(ps.simulate).parameters
    assert (limits["max_steps"].default, limits["max_events"].default) == (1_000_000, 100_000)
    assert "`painleve simulate` ends after 10⁶ steps or 10⁵ events" in words("explorer.md")


def test_pages_on_bars_say_of_which_end_their_thresholds_are():
    opening = words("rigid-rod.md").split("## Assumptions")[0]
    assert "for an end of radius 0" in opening
    assert "end of radius 0" in words("experiments.md").split("## Assumptions")[0]
    paper = " ".join((ROOT / "paper" / "elastic-bar.md").read_text("utf-8").split())
    assert "end of radius 0" in paper.split("# Introduction")[0]


@given(
    st.tuples(*[st.floats(-1, 1)] * 4),
    st.floats(0.05, 3),
    st.floats(1.05, 3),
    st.floats(0.02, 0.98),
)
def test_static_friction_leaves_stick_and_slip_where_the_free_contact_closes(root, mu, ratio, at):
    """Sticking needs a force between μ F_n and μ_s F_n; the slip solves the problem, too."""
    A = np.array(root).reshape(2, 2)
    W = A @ A.T
    assume(W[0, 0] * W[1, 1] - W[0, 1] ** 2 > 1e-3)
    needed = mu * (1 + at * (ratio - 1))
    b = -W @ [1.0, needed]  # sticking has F_n = 1, F_t between both
    assume(b[0] < -1e-3)
    normal = -b[0] / (W[0, 0] + mu * W[0, 1])
    acceleration = W[1, 0] * normal + W[1, 1] * mu * normal + b[1]
    assert normal > 0 and acceleration < 0  # against its friction


def test_static_friction_can_leave_stick_alone_where_the_free_contact_opens():
    W = np.array([[1.0, -1.0], [-1.0, 2.0]])
    b = -W @ [1.0, 1.2]
    assert b[0] > 0 and -b[0] / (W[0, 0] + 0.8 * W[0, 1]) < 0
    assert "(b_n < 0)" in words("friction-laws.md")


def test_planar_contact_at_rest_can_have_three_solutions():
    W, b, mu = np.array([[2, 1.5], [1.5, 2]]), np.array([1, 6.5]), 1.5
    resting = ps.contact(W, b, mu).solutions()
    assert {s.mode.value for s in resting} == {"liftoff", "slip_pos", "stick"}
    normal = -b[0] / (W[0, 0] - mu * W[0, 1])  # slip along t, by hand
    assert normal > 0 and (W[1, 0] - mu * W[1, 1]) * normal + b[1] > 0
    held = -np.linalg.solve(W, b)
    assert held[0] > 0 and abs(held[1]) < mu * held[0]
    assert "up to three where the slip velocity is 0" in words("explorer.md")
