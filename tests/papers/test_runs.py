"""The runs that the items share, and how they are drawn."""

import numpy as np
import pytest

from painleve_sym.at.cases import classify
from painleve_sym.papers.impact_resolution.claims import CLAIMS, SOFT
from painleve_sym.papers.impact_resolution.runs import IMPACT, SLIDING, Workbench, first, needed
from painleve_sym.papers.panels import events_as_marks, window


@pytest.fixture(scope="module")
def bench():
    return Workbench()


def test_parameters_are_those_of_the_paper(bench):
    # The paper has no reference length: its numbers hold in metres.
    printed = CLAIMS.data["inputs"]["parameters"]
    assert bench.simulator().parameters() == printed | {"l_0": 1.0}


def test_runs_are_made_once(bench):
    assert bench.run(IMPACT) is bench.run(IMPACT)


def test_sliding_force_is_that_of_the_rigid_problem(bench):
    rigid = classify(bench.rod, bench.state(1))
    force = bench.sliding_force(np.array([0.5]), np.array([1.0]))[0]
    assert force == pytest.approx(-rigid.B / rigid.A, rel=1e-13)


def test_window_draws_a_jump_of_the_force_as_one(bench):
    run = bench.run(SLIDING[SOFT])
    times = window(run, 0.0, 0.01)
    assert times[0] == 0
    assert times[-1] == 0.01
    assert np.all(np.diff(times) > 0)
    reload = needed(run, "reload").time
    at = int(np.searchsorted(times, reload))
    assert times[at] == reload
    forces = run.values("normal_force", times[at - 1 : at + 1])
    # From the unloading curve, nearly zero, to the virgin one.
    assert forces[0] < 0.01
    assert forces[1] > 3.5


def test_marks_lie_on_the_curve_before_the_event(bench):
    run = bench.run(SLIDING[SOFT])
    marks = events_as_marks(run, "normal_force", 0.004, ("reload", "max_compression"))
    assert [m.kind for m in marks] == ["max_compression", "reload"]
    assert marks[0].y == pytest.approx(needed(run, "max_compression").normal_force, rel=1e-9)
    assert marks[1].y == pytest.approx(needed(run, "reload").normal_force, rel=1e-6)


def test_needed_event_that_is_missing_is_an_error(bench):
    run = bench.run(SLIDING[SOFT])
    assert first(run, "slip_stop") is None
    with pytest.raises(LookupError, match="slip_stop"):
        needed(run, "slip_stop")
