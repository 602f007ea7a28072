"""The critical initial force of the indeterminate state, between lift-off and impact.

Started with little compression a sliding contact with A < 0 < B lifts off; with much it compresses
until the slip stops. Between lies the stable manifold of the sliding solution F_n* = −B/A. At
finite stiffness the sliding solution ends, so two borders enclose it: the least force from which
the slip stops at all, and the least from which it stops before the maximum compression. They draw
together like exp(−∫λ dt).
"""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from painleve_sym.arrays import Array
from painleve_sym.automata.signature import mode_name
from painleve_sym.checks import StateLike, number
from painleve_sym.choices import EngineLike, EngineName
from painleve_sym.codegen.named_mechanisms import MechanismLike
from painleve_sym.engines.protocol import RunOptions, RunSettings
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, StopReason
from painleve_sym.laws.catalogue import LawLike
from painleve_sym.motion.runs import simulator_of
from painleve_sym.motion.simulator import Simulator
from painleve_sym.plain_data import plain_fields
from painleve_sym.study.critical.sliding_solution import SlidingAnalysis, SlidingSolution
from painleve_sym.units import Value

ENDS = ("separation", "slip_stop")
"""Kinds of events that decide a run."""
RTOL = 1e-13
"""Of the runs: two digits above round-off, where the error no longer falls."""
LOOSENING_FACTOR = 100.0
"""By this the tolerance is loosened to see how much the force depends on it."""
T_END = 1.0
"""By when a run is decided, s: contacts last milliseconds and less."""
MAX_EVENTS = 2000
"""A contact that neither opens nor stops within this number of events keeps sliding."""
RESTING = 1e-12
"""Relative width below which a run that is not decided rests on the sliding solution."""
LEAST_FACTOR, LARGEST_FACTOR = 1e-9, 1e6
"""Forces from and up to these multiples of F_n* are tried."""


class Outcome(enum.StrEnum):
    """Outcome of a motion from an initial force."""

    LIFTS_OFF = "lifts_off"
    """The contact opens while it slips."""
    STOPS_IN_RESTITUTION = "stops_in_restitution"
    """The slip stops, after the maximum compression: a weak impact."""
    STOPS_IN_COMPRESSION = "stops_in_compression"
    """The slip stops while the contact is compressed: the impact of the inconsistent state."""
    UNDECIDED = "undecided"
    """Neither by the end time, or the mechanism left its domain."""


class Border(enum.StrEnum):
    """Which border between outcomes is sought."""

    SLIP_STOP = "slip_stop"
    """The least force from which the slip stops at all: impact rather than lift-off."""
    COMPRESSION = "compression"
    """The least force from which it stops before the maximum compression."""

    def beyond(self, outcome: Outcome) -> bool:
        """Whether the outcome lies above this border."""
        if self is Border.COMPRESSION:
            return outcome is Outcome.STOPS_IN_COMPRESSION
        return outcome in (Outcome.STOPS_IN_RESTITUTION, Outcome.STOPS_IN_COMPRESSION)


@dataclass(frozen=True, eq=False)
class CriticalForce(Compared):
    """A critical initial force.

    Attributes
    ----------
    border : Border
    value : float
        The least force beyond the border; N.
    bracket : tuple of float
        Below and beyond; N. Neighbouring floating point numbers, or a few times 1e-16 of the force
        apart where the start between them rests on the sliding solution to round-off.
    outcome_below, outcome_above : Outcome
        At the ends of the bracket.
    runs : int
        How many were needed.
    tolerance_effect : float
        By how much `value` changes when the tolerance is loosened a hundredfold; N. nan where
        that was not tried.
    sliding : SlidingSolution
        At the same state; its `force` is the limit F_n* = −B/A of infinite stiffness where the
        state has no approach velocity.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> state = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
    >>> border = ps.critical_force("rod", "bilinear-hertz", state)
    >>> f"{border.value:.4f} N", border.border
    ('306.1992 N', <Border.SLIP_STOP: 'slip_stop'>)
    """

    border: Border
    value: float
    bracket: tuple[float, float]
    outcome_below: Outcome
    outcome_above: Outcome
    runs: int
    tolerance_effect: float
    sliding: SlidingSolution

    def __repr__(self) -> str:
        """Return the force, its border and the outcomes on both sides in one line."""
        sides = f"{self.outcome_below.value} below, {self.outcome_above.value} above"
        return f"CriticalForce {self.value:.10g} N ({self.border.value}): {sides}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        own = ("border", "value", "bracket", "outcome_below", "outcome_above", "runs")
        return {
            **plain_fields(self, *own, "tolerance_effect"),
            "limit": self.sliding.force,
            "predicted": self.sliding.predicted_force,
        }


@dataclass(frozen=True)
class _Start:
    """A state with its numbers, ready to be started with any compression."""

    simulator: Simulator
    vector: Array
    parameters: Array
    options: RunOptions
    stiffness: float
    exponent: float

    def run(self, force: float) -> tuple[Outcome, StopReason]:
        """Return the outcome of an initial force, and the reason why the run ended."""
        outline, contact = self.simulator.outline, self.simulator.contact.rows[0]
        vector = self.vector.copy()
        if force == 0 and vector[outline.state_names.index(contact.gap_rate)] >= 0:
            # B > 0 opens it at once: a flight, which no separation precedes.
            return Outcome.LIFTS_OFF, StopReason.UNTIL
        vector[outline.state_names.index(contact.gap)] = -(
            (force / self.stiffness) ** (1 / self.exponent)
        )
        raw = self.simulator.integrator.run(vector, self.parameters, self.options)
        if raw.stop_reason is not StopReason.UNTIL:
            return Outcome.UNDECIDED, raw.stop_reason
        # What follows in the same instant, such as the gap's opening, is recorded after it.
        events = raw.event_records
        kinds = [outline.kinds[code] for code in events.kind]
        end = next(i for i, kind in enumerate(kinds) if kind in ENDS)
        mode = mode_name(outline, events.mode_before[end], events.memory_before[end])
        if kinds[end] == "separation":
            return Outcome.LIFTS_OFF, raw.stop_reason
        loading = mode.endswith(f"/{self.simulator.contact_law.loading_name}")
        outcome = Outcome.STOPS_IN_COMPRESSION if loading else Outcome.STOPS_IN_RESTITUTION
        return outcome, raw.stop_reason


@dataclass(frozen=True)
class CriticalForceFinder:
    """Finds critical forces of a mechanism on a contact law; build once, use often.

    Parameters
    ----------
    simulator : Simulator
    rtol : float
        Relative tolerance of the runs.
    t_end : float
        By when each run has to be decided; s.
    """

    simulator: Simulator
    rtol: float = RTOL
    t_end: float = T_END

    @cached_property
    def analysis(self) -> SlidingAnalysis:
        """The sliding solution in closed form."""
        return SlidingAnalysis(self.simulator)

    @property
    def where(self) -> str:
        """Place of a fault, as messages name it."""
        return f"critical force of {self.simulator.where}"

    def _start(
        self, state: Mapping[str, float], parameters: Mapping[str, float] | None, rtol: float
    ) -> _Start:
        simulator = self.simulator
        start = simulator.start(simulator.at(state, parameters))
        given = {"t_end": self.t_end, "until": ENDS, "rtol": rtol}
        given |= {"record": "events", "max_events": MAX_EVENTS}
        options = simulator.options(start.scale, RunSettings.of(simulator.where, given))
        options = replace(options, start_events=True)
        curve = simulator.loading_constants(start.place.parameters)
        return _Start(simulator, start.state, start.parameters, options, *curve)

    def outcomes(
        self,
        state: Mapping[str, float],
        forces: Array,
        parameters: Mapping[str, float] | None = None,
    ) -> list[Outcome]:
        """Return the outcome of each initial force ≥ 0, N; see `find` for the arguments."""
        for force in forces.tolist():
            number(force, "initial force", where=self.where, lower=0.0)
        start = self._start(state, parameters, self.rtol)
        return [start.run(float(force))[0] for force in forces]

    def find(
        self,
        state: Mapping[str, float],
        parameters: Mapping[str, float] | None = None,
        *,
        border: Border = Border.SLIP_STOP,
        guess: float | None = None,
        width: float = 0.05,
        check_tolerance: bool = True,
    ) -> CriticalForce:
        """Return the critical initial force by bisection down to neighbouring numbers.

        Parameters
        ----------
        state : mapping of str to float
            Coordinates and velocities; absent ones are 0. Gap 0, slipping, A < 0 < B.
        parameters : mapping of str to float
            Of mechanism and law; absent ones have their defaults.
        border : Border
        guess : float, optional
            Near which to look first; N. By default the predicted force.
        width : float
            Relative half width of the first bracket; it grows until it holds the border.
        check_tolerance : bool
            Whether to search again with a looser tolerance, for `tolerance_effect`.

        Raises
        ------
        InputError
            Not an indeterminate state; no border because even the uncompressed contact impacts;
            a run that is not decided by `t_end`.
        """
        sliding = self.analysis.at(state, parameters)
        first = sliding.predicted_force if guess is None else guess
        runs = _Bisection(self, border, self._start(state, parameters, self.rtol))
        low, high = runs.solve(first, width, sliding.force)
        effect = math.nan
        count = runs.count
        if check_tolerance:
            looser = min(LOOSENING_FACTOR * self.rtol, 1e-6)
            check = _Bisection(self, border, self._start(state, parameters, looser))
            effect = abs(high - check.solve(high, 1e-7, sliding.force)[1])
            count += check.count
        return CriticalForce(
            border=border,
            value=high,
            bracket=(low, high),
            outcome_below=runs.outcome(low),
            outcome_above=runs.outcome(high),
            runs=count,
            tolerance_effect=effect,
            sliding=sliding,
        )


class _Bisection:
    """One search; every force is run once."""

    def __init__(self, finder: CriticalForceFinder, border: Border, start: _Start) -> None:
        self.finder, self.border, self.start = finder, border, start
        self.known: dict[float, Outcome] = {}
        self.reason = StopReason.UNTIL

    @property
    def count(self) -> int:
        return len(self.known)

    def outcome(self, force: float) -> Outcome:
        if force not in self.known:
            self.known[force], self.reason = self.start.run(force)
        return self.known[force]

    def beyond(self, force: float) -> bool:
        outcome = self.outcome(force)
        if outcome is Outcome.UNDECIDED:
            raise InputError(
                f"{self.finder.where}: from {force:g} N the contact neither opens nor stops "
                f"slipping by t = {self.finder.t_end:g} s: {self.reason.sentence}. "
                "Fix: give a later t_end, or a state farther from A = 0 and B = 0."
            )
        return self.border.beyond(outcome)

    def solve(self, guess: float, width: float, scale: float) -> tuple[float, float]:
        """Return neighbouring numbers on both sides of the border; `scale` is F_n*."""
        low, high = self._bracket(max(guess, 1e-3 * scale), width, scale)
        while True:
            middle = (low + high) / 2
            resting = self.outcome(middle) is Outcome.UNDECIDED and high - low < RESTING * high
            if middle in (low, high) or resting:
                return low, high
            low, high = (low, middle) if self.beyond(middle) else (middle, high)

    def _bracket(self, guess: float, width: float, scale: float) -> tuple[float, float]:
        # Not symmetric: a guess of F_n* would be met again, where no run is decided.
        low, high = guess * (1 - min(width, 1.0)), guess * (1 + 0.9 * width)
        part = width
        while self.beyond(low):
            if low == 0:
                raise InputError(
                    f"{self.finder.where}: the contact impacts whatever the initial force: it "
                    "approaches too fast. Fix: give a slower approach."
                )
            part *= 8
            lower = guess * (1 - part) if part < 1 else low / 8
            low, high = (lower if lower > LEAST_FACTOR * scale else 0.0), low
        part = width
        while not self.beyond(high):
            if high > LARGEST_FACTOR * scale:
                raise InputError(
                    f"{self.finder.where}: no impact up to an initial force of {high:g} N. "
                    "Fix: check the state; its slip grows, or it leaves the indeterminate region."
                )
            part *= 8
            low, high = high, guess * (1 + part)
        return low, high


def critical_force(
    mechanism: MechanismLike,
    law: LawLike,
    state: StateLike,
    *,
    parameters: Mapping[str, Value] | None = None,
    law_parameters: Mapping[str, Value] | None = None,
    border: Border = Border.SLIP_STOP,
    engine: EngineLike = EngineName.AUTO,
) -> CriticalForce:
    """Return the critical initial force of an indeterminate state; see `CriticalForceFinder`.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
        With one contact.
    law : ContactLaw or its name
    state, parameters, law_parameters : mapping of str to (float or str)
        As for `simulate`. Gap 0, slipping, A < 0 < B.
    border : Border
    engine : EngineName or its text

    Raises
    ------
    InputError
        Input that `CriticalForceFinder.find` rejects.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> state = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
    >>> force = ps.critical_force("rod", ps.laws.bilinear_hertz(E=209e9), state)
    >>> force.value < force.sliding.force
    True
    """
    simulator = simulator_of(mechanism, law, engine)
    place = simulator.at(state, parameters, law_parameters)
    return CriticalForceFinder(simulator).find(place.state, place.parameters, border=border)
