"""An impact with constant W, b and μ under any contact law, phase by phase.

Such an impact is a motion of the general contact, and the simulator of compliant motions computes
it. Its events divide it into phases; its impulses follow from the momentum balance.
"""

from __future__ import annotations

import enum
import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from painleve_sym.arrays import Array
from painleve_sym.automata.model import CONTACTS
from painleve_sym.choices import EngineLike, EngineName
from painleve_sym.codegen.named_mechanisms import described
from painleve_sym.engines.protocol import RawRun, RunOptions
from painleve_sym.engines.records import EventRecords
from painleve_sym.equality import Compared
from painleve_sym.errors import EventKind, InputError, StopReason, refuse_unknown
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.batch.inputs import RUNS, BatchInputs
from painleve_sym.motion.runs import simulator_of
from painleve_sym.motion.simulator import Simulator

COEFFICIENTS = ("W_nn", "W_nt", "W_tt", "b_n", "b_t")
"""What the contact feels: g̈ = W_nn F_n + W_nt F_t + b_n, v̇_t = W_nt F_n + W_tt F_t + b_t."""
START = ("slip_velocity", "compression", "compression_rate")
"""v_t (m/s), δ ≥ 0 (m) and δ̇ = −v_n (m/s) at the start."""
RTOL = 1e-14
"""A Taylor step to this tolerance costs little more than one to 1e-11."""
LONG = 1e300
"""End of every motion, later than any impact; s."""
MAX_EVENTS = 64
"""Most events of a motion: impacts have a few, a contact that is held oscillates without end."""
AT_REST = 1e-12
"""An opening with less than this part of the work of b_n over the compression is none."""

PHASE = (
    *("slip", "loading", "duration", "normal_impulse", "tangential_impulse"),
    *("compression", "compression_rate", "slip_velocity", "impulse_time"),
)
"""Numbers of a phase; see `FrozenImpacts`."""
SUMS = ("duration", "normal_impulse", "tangential_impulse")
"""Those that add up over the phases."""
_RESUMES = -1


class FrozenEnd(enum.StrEnum):
    """End of an impact with constant coefficients; `code` is its number in arrays."""

    SEPARATION = "separation"
    """The force is zero and the contact opens."""
    STAYS = "stays"
    """The motion turns before the force is zero: the contact stays closed, there is no jump."""
    NO_IMPACT = "no_impact"
    """From the start the contact opens, or stays at rest."""
    FAILED = "failed"
    """The integration stopped early: numbers left the range of floating point."""

    @property
    def code(self) -> int:
        """Its place among the ends."""
        return _CODES[self]


_ENDS = tuple(FrozenEnd)
_CODES = {end: i for i, end in enumerate(_ENDS)}


@dataclass(frozen=True, eq=False)
class FrozenImpacts(Compared):
    """Impacts with constant coefficients; arrays have the shape of the cases.

    Impulses are right to round-off of the whole impact, not of each phase.

    Attributes
    ----------
    head : mapping of str to ndarray
        ``end`` (code of a `FrozenEnd`), ``phases`` (their count), ``slip_velocity`` and
        ``normal_velocity`` at the end (m/s), ``normal_impulse`` and ``tangential_impulse`` (N s),
        ``duration`` (s), ``largest_compression`` (m).
    phase : mapping of str to ndarray, shape (*cases, phases)
        `PHASE`: ``slip`` (−1, 0, +1), ``loading`` (1 or 0), duration, impulses, and δ, δ̇, v_t at
        the end of the phase; ``impulse_time`` is ∫P_n dt over it, P_n being 0 at its start (N s²).
        There are as many phases as the longest impact has; nan after the last one.
    """

    head: Mapping[str, Array]
    phase: Mapping[str, Array]

    @property
    def ends(self) -> list[FrozenEnd]:
        """Ends of all impacts, flat."""
        return [_ENDS[int(code)] for code in np.ravel(self.head["end"])]


@dataclass(frozen=True)
class _Begin:
    """Initial values, one motion per row: states, memory, mode (−1: by the state)."""

    states: Array
    memory: Array
    mode: NDArray[np.int64]


@dataclass(frozen=True)
class _Course:
    """Phases of motions: the number of each one's motion, ascending, and its `PHASE` numbers.

    `end`, shape (motions,), is the code of a `FrozenEnd`, or `_RESUMES` where the slip has
    stopped and the motion continues: `later` has the state there.
    """

    row: NDArray[np.int64]
    numbers: Mapping[str, Array]
    end: NDArray[np.int64]
    later: _Begin


def _derived() -> Mechanism:
    from painleve_sym.mechanics.general_contact import general_contact

    return general_contact()


@cache
def _general_contact() -> Mechanism:
    """Return the general contact, one object, so that its simulators are kept."""
    return described("general contact", _derived)


@dataclass(frozen=True)
class FrozenImpactSolver:
    """The impact of one contact with constant coefficients; build once, use often.

    Parameters
    ----------
    law : ContactLaw
    engine : {"auto", "compiled", "taylor", "erk"}
        As for `Simulator`.

    Raises
    ------
    InputError
        A law with a tangential spring.
    """

    law: ContactLaw
    engine: EngineLike = EngineName.AUTO

    def __post_init__(self) -> None:
        if self.law.friction.tangential_stiffness is not None:
            raise InputError(
                f"impact with law {self.law.name!r}: friction: got 'spring', and the phases of an "
                "impact with constant coefficients are those of a contact that does not yield "
                "along its tangent. Fix: simulate the motion, or leave friction=spring out."
            )

    @cached_property
    def simulator(self) -> Simulator:
        """Of the general contact with the law."""
        return simulator_of(_general_contact(), self.law, self.engine)

    def __call__(
        self,
        contact: Mapping[str, ArrayLike],
        start: Mapping[str, ArrayLike],
        parameters: Mapping[str, ArrayLike] | None = None,
        *,
        after: Mapping[str, ArrayLike] | None = None,
    ) -> FrozenImpacts:
        """Return the impacts of the cases; all arrays broadcast against each other.

        Parameters
        ----------
        contact : mapping of str to float or ndarray
            `COEFFICIENTS` and ``mu``. W in 1/kg, positive definite; b in m/s².
        start : mapping of str to float or ndarray
            `START`; absent ones are 0.
        parameters : mapping of str to float or ndarray
            Of the law; absent ones have their defaults.
        after : mapping of str to float or ndarray, optional
            `COEFFICIENTS` once the slip has stopped, in the shape of the cases; by default those
            before it.

        Raises
        ------
        InputError
            Unknown or absent names, shapes that do not fit, numbers out of range.
        """
        rows = self._inputs(contact, start, parameters)
        starts = rows.starts(0, rows.count)
        x, names = starts.states, self._names
        depth, rate, slip = -x[:, names["x_n"]], -x[:, names["x_n_dot"]], x[:, names["x_t_dot"]]
        b_n = rows.part(rows.inputs["b_n"], 0, rows.count)
        pressed = (depth > 0) | (rate > 0) | ((rate == 0) & (b_n < 0))
        end = np.where(pressed, FrozenEnd.FAILED.code, FrozenEnd.NO_IMPACT.code)
        active = pressed & (starts.refusal == RUNS)
        n, nz = len(x), len(self.simulator.outline.memory_names)
        begin = _Begin(x, np.zeros((n, nz)), np.full(n, -1))
        given, courses = starts.parameters, []
        if after is not None:
            moving = active & (slip != 0)
            first = self._follow(
                begin, given, starts.scales, moving, (EventKind.SEPARATION, EventKind.SLIP_STOP)
            )
            end[moving] = first.end[moving]
            active &= ~moving | (end == _RESUMES)
            begin = first.later
            later = self._inputs({"mu": contact["mu"], **after}, start, parameters)
            if later.shape != rows.shape:
                raise InputError(
                    f"impact: after: got arrays for the shape {later.shape}, need {rows.shape}. "
                    "Fix: give them in the shape of the cases."
                )
            given = later.starts(0, later.count).parameters
            courses.append(first)
        course = self._follow(begin, given, starts.scales, active, (EventKind.SEPARATION,))
        end[active] = course.end[active]
        return _impacts(rows.shape, (depth, rate, slip), b_n, [*courses, course], end)

    def _inputs(
        self,
        contact: Mapping[str, ArrayLike],
        start: Mapping[str, ArrayLike],
        parameters: Mapping[str, ArrayLike] | None,
    ) -> BatchInputs:
        w = _checked("contact", contact, (*COEFFICIENTS, "mu"))
        begin = _checked("start", {**dict.fromkeys(START, 0.0), **start}, START)
        if not np.all(begin["compression"] >= 0):
            least = float(np.min(begin["compression"]))
            raise InputError(f"impact: start: compression: got {least!r}, need >= 0.")
        with np.errstate(all="ignore"):
            kappa = w["W_nt"] / w["W_tt"]
        own: dict[str, ArrayLike] = {"W_tt": w["W_tt"], "kappa": kappa}
        own["A_stick"] = w["W_nn"] - kappa * w["W_nt"]
        own |= {name: w[name] for name in ("b_t", "b_n", "mu")}
        states = {
            "x_n": 0.0 - begin["compression"],
            "x_n_dot": 0.0 - begin["compression_rate"],
            "x_t_dot": begin["slip_velocity"],
        }
        return BatchInputs.of(self.simulator, states, {**own, **(parameters or {})}, None)

    @cached_property
    def _names(self) -> dict[str, int]:
        return {n: i for i, n in enumerate(self.simulator.outline.state_names)}

    @cached_property
    def _modes(self) -> tuple[Any, ...]:
        """Slip, whether in contact, whether loading, mode of sticking: by mode."""
        names = tuple(mode.name for mode in self.simulator.outline.modes)
        return _of_modes(names, self.law.unloading)

    def _among(self, *kinds: str) -> NDArray[np.bool_]:
        """Return, by the number of a kind of events, whether it is one of these."""
        return _kinds_among(self.simulator.outline.kinds, kinds)

    def _follow(
        self,
        begin: _Begin,
        parameters: Array,
        scales: Array,
        active: NDArray[np.bool_],
        until: tuple[str, ...],
    ) -> _Course:
        """Follow the motions of the active rows until one of the events, or a held contact."""
        names = self.simulator.outline.parameter_names
        p = dict(zip(names, parameters.T, strict=True))
        # A by direction of slip: −1, 0, +1. A contact that A > 0 presses back is held: it turns
        # back before the force is zero and oscillates.
        W_nt, W_nn = p["W_tt"] * p["kappa"], p["A_stick"] + p["W_tt"] * p["kappa"] ** 2
        A = np.stack([W_nn + p["mu"] * W_nt, p["A_stick"], W_nn - p["mu"] * W_nt])
        rows = np.flatnonzero(active)
        runs = []
        engine = self.simulator.integrator
        shared: dict[str, Any] = {"t_end": LONG, "rtol": RTOL, "max_events": MAX_EVENTS}
        for k in map(int, rows):
            shared |= {"atol": RTOL * scales[k], "start_mode": int(begin.mode[k])}
            # Mostly a motion that turns back is held: only where it is not, it is followed on.
            for kinds in ((*until, EventKind.RELOAD), until):
                options = RunOptions(until=kinds, record="events", **shared)
                run = engine.run(begin.states[k], parameters[k], options, begin.memory[k])
                if not self._goes_on(run, A[:, k]):
                    break
            runs.append(run)
        nx, nz = begin.states.shape[1], begin.memory.shape[1]
        none = np.empty((0, EventRecords.width(nx, nz)))
        events = EventRecords.of(np.concatenate([none, *(r.events for r in runs)]), nx, nz)
        row = np.repeat(rows, [len(r.events) for r in runs])
        end = np.full(len(active), FrozenEnd.FAILED.code)
        end[rows] = [_unmoved_end(r).code for r in runs]
        return self._read(begin, p, A, row, events, until, end)

    def _goes_on(self, run: RawRun, A: Array) -> bool:
        """Whether the run ended where the motion turns back, but is not held."""
        events = run.event_records
        if not len(events.time) or not self._among(EventKind.RELOAD)[events.kind[-1]]:
            return False
        at_once = len(events.time) > 1 and events.time[-2] == events.time[-1]
        return bool(at_once or A[self._modes[0][events.mode_before[-1]] + 1] <= 0)

    def _read(
        self,
        begin: _Begin,
        p: Mapping[str, Array],
        A: Array,
        row: NDArray[np.int64],
        events: EventRecords,
        until: tuple[str, ...],
        end: NDArray[np.int64],
    ) -> _Course:
        """Read phases and ends off the events of the rows."""
        slip_of, in_contact, loads, sticking = self._modes
        time, mode, after = events.time, events.mode_before, events.state_after
        kind, slip = events.kind, slip_of[mode]
        first, before = _changes(row[None]), np.arange(-1, len(row) - 1)
        since = np.where(first, 0.0, time[before])
        # Next to the turning point round-off may turn the motion back and forth in no time.
        passes = time > since
        held = self._among(EventKind.RELOAD)[kind] & passes & (A[slip + 1, row] > 0)
        # A start without an unloading curve opens at once: after the flight another impact begins.
        flies = ~in_contact[mode] & passes
        over = held | flies | self._among(*until)[kind]
        earlier = np.cumsum(over) - over
        kept = earlier == np.maximum.accumulate(np.where(first, earlier, 0))
        over &= kept
        codes = np.where(held, FrozenEnd.STAYS.code, FrozenEnd.SEPARATION.code)
        end[row[over]] = np.where(self._among(EventKind.SLIP_STOP)[kind], _RESUMES, codes)[over]
        later = begin
        if EventKind.SLIP_STOP in until:
            later = _Begin(begin.states.copy(), begin.memory.copy(), begin.mode.copy())
            later.states[row[over]] = after[over]
            later.memory[row[over]] = events.memory_after[over]
            later.mode[row[over]] = sticking[mode[over]]
        # Neighbouring segments of one slip direction, both loading or both unloading, are a phase.
        real = np.flatnonzero(kept & ~flies & passes)
        new = _changes(np.array([row[real], slip[real], loads[mode[real]]]))
        opens = real[new]
        closes = real[np.concatenate([new[1:], new[:1]])]
        came = np.where(first[:, None], begin.states[row], after[before])
        turned = self._among(EventKind.MAX_COMPRESSION, EventKind.RELOAD)[kind[closes]]
        own = {name: values[row[opens]] for name, values in p.items()}
        numbers = self._numbers(
            own, slip[opens], time[closes] - since[opens], came[opens], after[closes]
        )
        numbers["loading"] = loads[mode[opens]].astype(float)
        numbers["compression_rate"] = np.where(turned, 0.0, numbers["compression_rate"])
        return _Course(row[opens], numbers, end, later)

    def _numbers(
        self, p: Mapping[str, Array], slip: Any, time: Array, before: Array, after: Array
    ) -> dict[str, Array]:
        """Return the numbers of phases: impulses and their moment from the momentum balance."""
        names = ("x_n", "x_n_dot", "x_t", "x_t_dot")
        n0, v0, s0, u0 = (before[:, self._names[name]] for name in names)
        n, v, s, u = (after[:, self._names[name]] for name in names)
        fall = p["b_n"] - p["kappa"] * p["b_t"]
        P = (v - v0 - p["kappa"] * (u - u0) - fall * time) / p["A_stick"]
        sticking = (u - u0 - p["b_t"] * time) / p["W_tt"] - p["kappa"] * P
        moved = n - n0 - v0 * time - p["kappa"] * (s - s0 - u0 * time)
        return {
            "slip": slip.astype(float),
            "duration": time,
            "normal_impulse": P,
            "tangential_impulse": np.where(slip == 0, sticking, -p["mu"] * slip * P),
            "compression": 0.0 - n,
            "compression_rate": 0.0 - v,
            "slip_velocity": u,
            "impulse_time": (moved - fall * time**2 / 2) / p["A_stick"],
        }


# The same few for all impacts.
@functools.lru_cache(maxsize=32)
def _of_modes(names: tuple[str, ...], unloading: str) -> tuple[Any, ...]:
    """Return what `FrozenImpactSolver._modes` says of modes with these names."""
    parts = [name.partition("/") for name in names]
    return (
        np.array([CONTACTS.get(contact, 0) for contact, _, _ in parts]),
        np.array([bool(branch) for _, _, branch in parts]),
        np.array([branch != unloading for _, _, branch in parts]),
        np.array([names.index(f"stick/{b}") if b else i for i, (_, _, b) in enumerate(parts)]),
    )


@functools.lru_cache(maxsize=128)
def _kinds_among(every: tuple[str, ...], kinds: tuple[str, ...]) -> NDArray[np.bool_]:
    """Return for every kind of events whether it is among some."""
    return np.array([kind in kinds for kind in every])


def _changes(values: NDArray[Any]) -> NDArray[np.bool_]:
    """Return where columns of values are not those before, the first one always; shape (k, n)."""
    changes = np.ones(values.shape[1], bool)
    np.any(values[:, 1:] != values[:, :-1], axis=0, out=changes[1:])
    return changes


def _unmoved_end(run: RawRun) -> FrozenEnd:
    """Return how a motion ends that none of the events asked for ended."""
    if run.stop_reason is StopReason.T_END:
        return FrozenEnd.STAYS
    # Without restitution there is no unloading curve, and no time passes after the turn.
    time = run.event_records.time
    turns = len(time) > 1 and time[-1] == time[-2]
    return FrozenEnd.SEPARATION if turns else FrozenEnd.FAILED


def _impacts(
    shape: tuple[int, ...],
    start: tuple[Array, Array, Array],
    b_n: Array,
    courses: Sequence[_Course],
    end: NDArray[np.int64],
) -> FrozenImpacts:
    """Join courses that follow each other; `start` holds δ, δ̇ and v_t."""
    row, numbers = courses[0].row, courses[0].numbers
    if len(courses) > 1:
        row = np.concatenate([c.row for c in courses])
        order = np.argsort(row, kind="stable")
        row = row[order]
        numbers = {n: np.concatenate([c.numbers[n] for c in courses])[order] for n in PHASE}
    counts = np.bincount(row, minlength=len(end))
    place = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    table = np.full((len(PHASE), len(end), max(1, counts.max(initial=0))), np.nan)
    for values, name in zip(table, PHASE, strict=True):
        values[row, place] = numbers[name]
    depth, rate, slip = (values.copy() for values in start)
    np.maximum.at(depth, row, numbers["compression"])
    begins = _changes(row[None])
    last = np.concatenate([begins[1:], begins[:1]])
    rate[row[last]], slip[row[last]] = (
        numbers[n][last] for n in ("compression_rate", "slip_velocity")
    )
    # A motion that begins at rest on the surface may come back to it at rest, but for rounding.
    rests = (end == FrozenEnd.SEPARATION.code) & (b_n < 0) & (rate**2 <= AT_REST * -b_n * depth)
    rests[row[last]] &= numbers["loading"][last] == 0
    end, rate = np.where(rests, FrozenEnd.STAYS.code, end), np.where(rests, 0.0, rate)
    head = {"end": end.astype(float), "phases": counts.astype(float)}
    head |= {"slip_velocity": slip, "normal_velocity": 0.0 - rate, "largest_compression": depth}
    head |= {n: np.bincount(row, numbers[n], len(end)) for n in SUMS}
    return FrozenImpacts(
        {name: values.reshape(shape) for name, values in head.items()},
        {n: v.reshape(*shape, -1) for n, v in zip(PHASE, table, strict=True)},
    )


def _checked(group: str, given: Mapping[str, ArrayLike], names: Sequence[str]) -> dict[str, Array]:
    for name in given:
        refuse_unknown("input", name, names, f"impact: {group}")
    absent = [name for name in names if name not in given]
    if absent:
        raise InputError(f"impact: {group}: no value of {', '.join(absent)}. Fix: give it.")
    return {name: np.asarray(given[name], dtype=float) for name in names}
