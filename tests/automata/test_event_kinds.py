"""Kinds of events: texts that stay, each with a sentence, all in the documentation."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from painleve_sym.errors import EventKind

DOCS = Path(__file__).parents[2] / "docs" / "cli.md"


@pytest.mark.parametrize("kind", list(EventKind))
def test_event_kind_is_its_text_and_has_a_sentence(kind):
    assert kind == kind.value == kind.name.lower() == json.loads(json.dumps(kind))
    assert EventKind(kind.value) is kind
    assert (kind.sentence and kind.sentence[0].islower()) or kind.sentence.startswith("A = 0")


def test_command_line_page_names_every_kind_of_event():
    text = DOCS.read_text("utf-8")
    named = set(re.findall(r"`(\w+)`", text[text.index("Kinds of events:") :]))
    assert set(map(str, EventKind)) <= named
