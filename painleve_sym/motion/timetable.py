"""Times known in advance at which a motion changes: phases, and the pieces of its inputs."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.checks import by_name, names_of, number
from painleve_sym.choices import InterpolationLike
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, received, refuse_unknown, unknown_name
from painleve_sym.laws.catalogue import LawsLike, as_law, law_text
from painleve_sym.mechanics.declarations import TIME_NAME
from painleve_sym.mechanics.inputs import derivative_names, inputs_of, instant_name
from painleve_sym.motion.signals import Signal
from painleve_sym.units import Value

if TYPE_CHECKING:
    from painleve_sym.mechanics.pulses import pulse
    from painleve_sym.motion.simulator import Simulator

MAX_PIECES = 50_000
"""Of a motion: each keeps a record of its own."""
_TABLES = ("parameters", "law_parameters")
_KEYS = ("time", *_TABLES, "law", "contacts")
_EXAMPLE = "{'time': 0.5, 'parameters': {'mu': 0.2}}"


class Phase(TypedDict, total=False):
    """Changes at a time of a motion; see `painleve_sym.simulate`.

    `contacts` are the names of those that are present from then on.
    """

    time: Value
    parameters: Mapping[str, Value]
    law_parameters: Mapping[str, Value]
    law: LawsLike
    contacts: Sequence[str]


class InputValues(TypedDict, total=False):
    """Values of an input at given times, or the file of them; see `painleve_sym.simulate`.

    The file is a CSV file with a column for the `time`, by default ``t``, and one for the values,
    by default of the name of the input, each with its unit in its header: ``t [ms]``. `csv` says
    how it is written (`CsvFormat`).
    """

    times: ArrayLike
    values: ArrayLike
    interpolation: InterpolationLike
    file: str
    time: str
    column: str
    csv: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Timetable(Compared):
    """Times at which a motion changes.

    Attributes
    ----------
    phases : tuple of mapping
        In the order of their times, which are those of the motion; see `Phase`.
    signals : mapping of str to Signal
        Functions of time, by the input or the parameter that they give.
    pulses : mapping of str to pulse
        Of the formulas, by the parameter that has its value.
    ahead : float
        By how much the time `t` in the formulas is ahead of that of the motion; s.
    """

    phases: tuple[Mapping[str, Any], ...] = ()
    signals: Mapping[str, Signal] = field(default_factory=dict)
    pulses: Mapping[str, pulse] = field(default_factory=dict)
    ahead: float = 0.0

    @classmethod
    def of(
        cls,
        simulator: Simulator,
        phases: Any,
        inputs: Any,
        before: Timetable | None = None,
        begin: float = 0.0,
    ) -> Timetable:
        """Return the timetable of the arguments of a run; what is None is that of the run before.

        InputError for unknown names, times before the one at which the motion begins, and values
        out of range.
        """
        before = before or cls()
        own = before.phases
        if phases is not None:
            own = tuple(checked_phases(simulator.where, phases))
            if own and own[0]["time"] < begin:
                raise InputError(
                    f"{simulator.where}: phases: got the time {own[0]['time']:g} s, need times "
                    f"from {begin:g} s on, where the motion begins. Fix: leave the phase out, or "
                    "give what it changes as parameters."
                )
        signals = {**before.signals, **_signals(simulator, inputs)}
        return cls(own, signals, simulator.pulses, before.ahead)

    def __bool__(self) -> bool:
        """Whether anything changes."""
        return bool(self.phases or self.signals or self.pulses)

    def beginning(self, state: Mapping[str, float], time: float) -> Timetable:
        """Return the timetable of a motion that is in a state at a time."""
        return replace(self, ahead=state[TIME_NAME] - time) if TIME_NAME in state else self

    def after(self, time: float) -> float:
        """Return the next time of a phase or an input, s; inf where nothing changes."""
        following = self._times[bisect_right(self._times, time) :][:1]
        return min([math.inf, *following, *(s.after(time) for s in self.signals.values())])

    @cached_property
    def _times(self) -> list[float]:
        """Times of the phases, in order; s."""
        return [float(phase["time"]) for phase in self.phases]

    def since(self, time: float) -> Timetable:
        """Return the timetable without the phases before a time."""
        return replace(self, phases=self.phases[bisect_left(self._times, time) :])

    def pulsed(
        self, where: str, time: float, end: float, values: Mapping[str, float]
    ) -> tuple[float, dict[str, float]]:
        """Return the next edge of a pulse up to an end, s, and the pulses until then.

        InputError for pulses whose edges are not finite, or too many.
        """
        from painleve_sym.mechanics.pulses import edges_of

        edges = {n: edges_of(where, own, values) for n, own in self.pulses.items()}
        clock, last = time + self.ahead, end + self.ahead
        for name, own in edges.items():
            if own.period is not None and (last - clock) / own.period > MAX_PIECES / 2:
                raise InputError(
                    f"{where}: {self.pulses[name]}: got the period {own.period:g} s, with more "
                    f"than {MAX_PIECES:,} edges up to t = {last:g} s. Fix: give a longer one."
                )
        stop = min([last, *(own.after(clock) for own in edges.values())])
        within = (clock + stop) / 2
        now = {name: own.value(within) for name, own in edges.items()}
        return (end if stop == last else stop - self.ahead), now

    def changes(self, time: float, since: float, begins: bool = False) -> dict[str, Any]:
        """Return all that changes after one time up to another; see `Phase`.

        Where a motion `begins`, inputs have their values whether they change or not.
        """
        total: dict[str, Any] = {name: {} for name in _TABLES}
        first, end = (bisect_right(self._times, t) for t in (since, time))
        for phase in self.phases[first:end]:
            tables = {name: {**total[name], **phase.get(name, {})} for name in _TABLES}
            total = {**total, **phase, **tables}
        total.pop("time", None)
        for name, signal in self.signals.items():
            place = signal.piece(time)
            if begins or place != signal.piece(since):
                total["parameters"].update(self._values(name, signal, place))
        return {name: value for name, value in total.items() if value or name not in _TABLES}

    def _values(self, name: str, signal: Signal, place: int) -> dict[str, float]:
        """Return the parameters that give a piece of a signal."""
        values = signal.derivatives[place].tolist()
        named = dict(zip(derivative_names(name, len(values) - 1), values, strict=True))
        if signal.order:
            named[instant_name(name)] = float(signal.times[place]) + self.ahead
        return named

    def to_data(self) -> dict[str, Any]:
        """Return phases and inputs as plain data, which `simulate` takes."""
        phases = [
            {k: law_text(as_law(v)) if k == "law" else v for k, v in phase.items()}
            for phase in self.phases
        ]
        inputs = {name: dict(signal.given) for name, signal in self.signals.items()}
        return {n: v for n, v in (("phases", phases), ("inputs", inputs)) if v}

    def check(self, where: str, begin: float, end: float) -> None:
        """Raise InputError where an input is not known during a whole motion, or much changes."""
        times = [self._times, *(signal.times for signal in self.signals.values())]
        count = sum(int(np.sum((np.array(t) > begin) & (np.array(t) < end))) for t in times)
        if count >= MAX_PIECES:
            raise InputError(
                f"{where}: got {count:,} times of changes from {begin:g} s to {end:g} s, need "
                f"fewer than {MAX_PIECES:,}. Fix: end earlier, or continue from there."
            )
        for name, signal in self.signals.items():
            first, last = float(signal.times[0]), signal.end
            if first > begin or last < end:
                raise InputError(
                    f"{where}: input {name}: got values from {first:g} s to {last:g} s, need them "
                    f"from {begin:g} s to {end:g} s. Fix: give more of them, or hold the last one."
                )


def checked_phases(where: str, given: Any) -> list[dict[str, Any]]:
    """Return phases with their times in s, in order."""
    if isinstance(given, Mapping | str) or not isinstance(given, Sequence):
        raise InputError(f"{where}: phases: got {received(given)}, need a list of {_EXAMPLE}.")
    read = [_phase(f"{where}: phases[{k}]", phase) for k, phase in enumerate(given)]
    return sorted(read, key=lambda phase: float(phase["time"]))


def _phase(where: str, given: Any) -> dict[str, Any]:
    if not isinstance(given, Mapping) or "time" not in given:
        raise InputError(f"{where}: got {received(given)}, need what changes when: {_EXAMPLE}.")
    for key in given:
        if key not in _KEYS:
            raise InputError(f"{where}: {unknown_name('key', str(key), _KEYS)}")
    phase: dict[str, Any] = {
        "time": number(given["time"], "time", where=where, unit="s", lower=0.0)
    }
    for name in _TABLES:
        if given.get(name) is not None:
            phase[name] = dict(by_name(given[name], f"{where}: {name}", "{'mu': 0.5}"))
    if given.get("law") is not None:
        phase["law"] = given["law"]
    if given.get("contacts") is not None:
        phase["contacts"] = list(names_of(given["contacts"], f"{where}: contacts", "A,B"))
    return phase


def _signals(simulator: Simulator, given: Any) -> dict[str, Signal]:
    """Return the signals of inputs and parameters by name."""
    where = f"{simulator.where}: inputs"
    named = by_name(given, where, "{'F': {'times': [0, 1], 'values': [0, 2]}}")
    declared = simulator.declared.by_name
    orders = inputs_of(declared.values())
    signals = {}
    for name, values in named.items():
        refuse_unknown("input or parameter", name, declared, where)
        here, parameter = f"{where}: {name}", declared[name]
        signal = Signal.of(here, values, name, parameter.unit)
        order = orders.get(name, 0)
        if signal.order > order:
            raise InputError(
                f"{here}: got {signal.given['interpolation']} values, and its own formulas hold it "
                "between its times. Fix: hold them, or declare it as an input with this "
                "interpolation, in [inputs] of the mechanism or with Input."
            )
        for extreme in (min(signal.derivatives[:, 0]), max(signal.derivatives[:, 0])):
            if fault := parameter.fault(float(extreme)):
                raise InputError(f"{here}: {fault}")
        signals[name] = signal.of_order(order)
    return signals
