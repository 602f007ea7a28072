"""Drops of a table on three legs end at the end time, whatever units, side and order they have."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

from painleve_sym.errors import StopReason
from tests.properties.three_legs import LAWS, drops, fall, table

ENGINES = ("taylor", "compiled")
OTHER_UNITS = (1e-3, 39.37, 7.0)
CLOSED = 1e-8
RIGID = ("rigid",) * 3


def stopped(laws, engine, count, seed=1):
    """Return which of the motions, mirror images and motions in other units end otherwise."""
    plain, mirrored = table(laws, engine), table(laws[::-1], engine)
    ends = []
    for i, drop in enumerate(drops(laws, count, seed)):
        runs = {
            "plain": fall(plain, drop),
            "mirrored": fall(mirrored, drop.mirrored()),
            "in other units": fall(plain, drop, OTHER_UNITS),
        }
        for kind, run in runs.items():
            if run.stop_reason is not StopReason.T_END or not run.energy_residual < CLOSED:
                ends.append((i, kind, run.stop_reason.label, run.energy_residual))
    return ends


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.slow
def test_drops_on_rigid_legs_end_at_the_end_time(engine):
    assert stopped(RIGID, engine, 6) == []


@pytest.mark.slow
def test_touchdown_that_is_near_in_a_long_step_is_not_missed():
    """Two feet at one height bounce in turn, in a step a million times as long as a bounce."""
    *_, drop = drops(RIGID, 7, seed=0)
    run = fall(table(RIGID, "compiled"), drop, max_events=5000)
    assert run.stop_reason is StopReason.T_END


@pytest.mark.slow
def test_a_foot_that_touches_with_the_others_at_rest_has_no_impact():
    """It approaches with what rounding leaves of the velocity of a body that has stopped."""
    *_, drop = drops(RIGID, 27, seed=0)
    assert fall(table(RIGID, "taylor"), drop).stop_reason is StopReason.T_END


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("laws", LAWS, ids="-".join)
def test_drops_on_legs_of_every_kind_end_at_the_end_time(laws, engine):
    """60 motions of each: 2 040 in all."""
    assert stopped(laws, engine, 20) == []


@pytest.mark.slow
def test_a_slip_that_falls_from_zero_is_back_though_it_rises_within_the_step():
    """The step that begins where the foot would slip is eight times as long as its way back."""
    laws = ("bilinear-hertz", "linear", "rigid")
    *_, drop = drops(laws, 12, seed=12)
    assert fall(table(laws, "taylor"), drop).energy_residual < CLOSED


@pytest.mark.slow
@pytest.mark.parametrize(
    ("laws", "engine", "number", "units"),
    [
        # A foot that closed by rounding bears a force that is rounding, beside two feet at rest.
        (("rigid", "rigid", "linear"), "compiled", 12, (1.0, 1.0, 1.0)),
        (("rigid", "rigid", "linear"), "taylor", 12, OTHER_UNITS),
        # The foot between two that rest and stick.
        (("rigid", "bilinear-hertz", "rigid"), "taylor", 13, OTHER_UNITS),
        # A foot lands at the instant in which another leaves, a moment ahead.
        (("hertz", "rigid", "linear"), "compiled", 7, (1.0, 1.0, 1.0)),
        (("linear", "rigid", "hertz"), "compiled", 16, OTHER_UNITS),
    ],
)
def test_feet_that_rest_at_rounding_rest_however_long(laws, engine, number, units):
    *_, drop = drops(laws, number + 1, seed=1)
    run = fall(table(laws, engine), replace(drop, t_end=3.0), units)
    assert run.stop_reason is StopReason.T_END


def test_gap_between_two_closed_feet_is_constant_to_the_last_digit():
    """The feet stand on a line, so that any two that are closed keep the third."""
    laws = ("rigid", "bilinear-hertz", "rigid")
    contact = table(laws, "compiled").contact
    rates = {str(state): rate for state, rate in contact.automaton.modes[0].field.items()}
    for state in (contact.rows[1].gap, contact.rows[1].gap_rate):
        closed = [s for s in rates[state].free_symbols if str(s) in ("closed_left", "closed_right")]
        assert rates[state].xreplace(dict.fromkeys(closed, sp.Integer(1))) == 0
        for one in closed:
            assert rates[state].xreplace({one: sp.Integer(0)}) != 0


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_the_order_of_the_legs_does_not_matter(engine):
    for laws in (RIGID, ("linear",) * 3):
        for drop in drops(laws, 20, seed=2):
            ends = (fall(table(laws, engine, backwards=b), drop) for b in (False, True))
            assert [run.stop_reason for run in ends] == [StopReason.T_END] * 2
