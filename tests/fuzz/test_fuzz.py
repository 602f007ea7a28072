"""Inputs that once had a fault are answered well, and new ones of each kind."""

from __future__ import annotations

import time

import pytest

from tests.fuzz.calls import call, make_store
from tests.fuzz.inputs import CORPUS, KINDS, SHARES, FuzzInput, input_of

KEPT = sorted(CORPUS.glob("*.json"))
# Long powers of sines, whose closed forms take half a minute, and runs of 50 000 steps.
SLOW = {"state-in-which-the-contact-does-not-slide", "long-fit"}


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("store")
    make_store(folder)
    return folder


@pytest.mark.parametrize(
    "path",
    [pytest.param(p, id=p.stem, marks=pytest.mark.slow if p.stem in SLOW else ()) for p in KEPT],
)
def test_a_kept_input_has_no_fault_and_does_not_hang(store, path):
    start = time.process_time()
    outcome = call(FuzzInput.from_text(path.read_text("utf-8")), store)
    assert outcome.faults == ()
    assert time.process_time() - start < 30


@pytest.mark.parametrize("kind", [k for k in KINDS if k not in ("mechanism", "sweep")])
def test_some_new_inputs_have_no_fault(store, kind):
    for seed in range(5):
        given = input_of(kind, seed)
        assert given == FuzzInput.from_text(given.to_text())
        if "simulate" not in given.arguments:  # may compile
            assert call(given, store).faults == ()


def test_every_kind_has_a_share():
    assert set(SHARES) == set(KINDS) and sum(SHARES.values()) == 100


def test_executed_text_is_noticed(store, monkeypatch):
    monkeypatch.setattr("tests.fuzz.calls.main", lambda words: eval(words[0]) or 0)
    outcome = call(FuzzInput("command", ("painleve_canary(1)",)), store)
    assert outcome.faults == ("text of the input was executed",)


@pytest.mark.parametrize(
    ("answer", "fault"),
    [
        ("raise KeyError('mass')", "traceback: KeyError"),
        ("code = 7", "exit code 7"),
        ("code = 2", "exit code 2 with 0 error lines"),
        ("print('x' * 20_000, file=sys.stderr)", "on standard error"),
        ("warnings.warn('overflow', RuntimeWarning)", "RuntimeWarning: overflow"),
        ("code = 2; print('painleve: error: no', file=sys.stderr); print(1)", "but output: 1"),
        ("print('{\"a\": NaN}')", "not JSON"),
        ("os.write(2, b'from compiled code')", "from compiled code"),
    ],
)
def test_a_wrong_answer_is_a_fault(store, monkeypatch, answer, fault):
    def wrong(_):
        names = {"code": 0}
        exec(f"import os, sys, warnings\n{answer}", names)
        return names["code"]

    monkeypatch.setattr("tests.fuzz.calls.main", wrong)
    outcome = call(FuzzInput("command", ("models", "--json")), store)
    assert any(fault in f for f in outcome.faults), outcome
