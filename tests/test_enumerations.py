"""Enumerations are texts: compared with, printed as and written to JSON as the text of a member."""

from __future__ import annotations

import enum
import importlib
import json
import pickle
import re
from pathlib import Path

import pytest

import painleve_sym as ps
from painleve_sym.problem import Uniqueness

ROOT = Path(__file__).parents[1]
NO_TEXT: dict[str, str] = {}
"""Enumerations that have other members than texts, each with the reason."""


def enumerations() -> dict[str, type[enum.Enum]]:
    """Return every enumeration of the package; modules without one are not imported."""
    kinds = {}
    for path in (ROOT / "painleve_sym").rglob("*.py"):
        if not re.search("Enum|Explained", path.read_text("utf-8")):
            continue
        module = importlib.import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))
        for name, kind in vars(module).items():
            if isinstance(kind, enum.EnumType) and kind.__module__ == module.__name__:
                kinds[f"{module.__name__}.{name}"] = kind
    return kinds


def test_every_enumeration_is_one_of_texts():
    kinds = enumerations()
    assert len(kinds) > 20 and set(NO_TEXT) <= set(kinds)
    for name, kind in kinds.items():
        if name in NO_TEXT:
            continue
        assert issubclass(kind, enum.StrEnum), name
        for member in kind:
            assert type(member.value) is str and member == member.value == f"{member}"
            assert kind(member.value) is member and pickle.loads(pickle.dumps(member)) is member
            assert json.loads(json.dumps({member: member})) == {member.value: member.value}


@pytest.mark.parametrize("kind", [ps.EventKind, ps.ContactCase])
def test_members_keep_their_sentence(kind):
    assert all(" " in member.sentence for member in kind)


def test_reasons_and_statuses_keep_their_labels():
    from painleve_sym.motion.time_stepping.mpcc import MPCCStatus
    from painleve_sym.problem.complementarity.lemke import LemkeStatus

    for kind in (ps.StopReason, LemkeStatus, MPCCStatus):
        assert all(" " in member.sentence and member.label == member for member in kind)
    assert all(" " in m.meaning and "(" in m.reference for m in Uniqueness)


def test_table_of_the_page_has_texts_of_members():
    page = (ROOT / "docs" / "api.md").read_text("utf-8")
    rows = re.findall(r"^\| `(\w+)` \| ([^|]+) \|", page, re.M)
    assert len(rows) > 5
    for name, texts in rows:
        kind = getattr(ps, name)
        for text in re.sub(r"\([^)]*\)|…", "", texts).split(","):
            if text.strip():
                assert kind(text.strip()) == text.strip()
        if "…" not in texts:
            assert len(kind) == len([t for t in texts.split(",") if t.strip()])


def test_results_compare_with_texts():
    state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    run = ps.simulate(ps.models.rod(mu=1.5), "hertz", state, t_end=1e-2, until="slip_stop")
    assert run.stop_reason == "until" and run.stop_reason in {"until": 1}
    assert ps.classify("rod", {"theta": 0.5, "x_A_dot": -1.0}).case == "slip"
    assert f"{ps.contact([[1, 0], [0, 1]], [-1, 0], 0.5).case}" == "stick"
