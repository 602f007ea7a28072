"""Comparisons of motions in tests: events and ends of two runs, energy with all that was lost."""

from __future__ import annotations

import pytest


def total_energy(run, times):
    """Return kinetic, potential and stored energy with everything dissipated since the start."""
    values = run.outputs(times)
    losses = [name for name in run.final if name.endswith("_dissipation")]
    stored = sum(values[f"{name}_energy"] for name in ("kinetic", "potential", "stored"))
    return stored + sum(run.values(name, times) for name in losses)


def assert_same_motion(run, expected, *, times, values):
    """The same events, at the same times and with the same end to relative tolerances."""
    kinds = [[(event.kind, event.contact) for event in r.events] for r in (run, expected)]
    assert kinds[0] == kinds[1]
    for event, other in zip(run.events, expected.events, strict=True):
        assert event.time == pytest.approx(other.time, rel=times)
    for name, value in expected.final.items():
        assert run.final[name] == pytest.approx(value, rel=values, abs=1e-13)
