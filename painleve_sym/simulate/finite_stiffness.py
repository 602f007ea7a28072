"""The velocity jump at finite stiffness: an impact with constant W, b, μ under any contact law.

Such an impact is a motion of the general contact, so the simulator of compliant motions computes it.
Its events divide it into phases; its impulses follow from the momentum balance.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from painleve_sym.arrays import Array
from painleve_sym.codegen.pointwise import Pointwise
from painleve_sym.contacts.contact_states import CONTACTS
from painleve_sym.contacts.inputs import resolve_parameters, resolve_state
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.errors import InputError, StopReason, unknown_name
from painleve_sym.laws.chatter import general_contact
from painleve_sym.laws.compliance import ContactLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.simulate.batch.inputs import ManyInputs
from painleve_sym.simulate.batch.starts import RUNS, starts_of
from painleve_sym.simulate.compliant import SoftenedSimulator

COEFFICIENTS = ("W_nn", "W_nt", "W_tt", "b_n", "b_t")
"""What the contact feels: g̈ = W_nn F_n + W_nt F_t + b_n, v̇_t = W_nt F_n + W_tt F_t + b_t."""
START = ("slip_velocity", "compression", "compression_rate")
"""v_t (m/s), δ ≥ 0 (m) and δ̇ = −v_n (m/s) at the start."""
CONFIGURATIONS = ("frozen", "carried")
"""Coefficients of the start throughout, or moved to the mean time of the impulse of each part."""
METHOD = "integration"
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


class FrozenEnd(enum.Enum):
    """How an impact with constant coefficients ends.

    SEPARATION
        The force is zero and the contact opens.
    STAYS
        The motion turns before the force is zero: the contact stays closed, there is no jump.
    NO_IMPACT
        From the start the contact opens, or stays at rest.
    FAILED
        The integration stopped early: numbers left the range of floating point.
    """

    SEPARATION = 0
    STAYS = 1
    NO_IMPACT = 2
    FAILED = 3


@dataclass(frozen=True)
class FrozenImpacts:
    """Impacts with constant coefficients; arrays have the shape of the cases.

    Impulses are right to round-off of the whole impact, not of each phase.

    Attributes
    ----------
    head : mapping of str to ndarray
        ``end`` (number of a `FrozenEnd`), ``phases`` (their count), ``slip_velocity`` and
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
        """How each impact ends, flat."""
        return [FrozenEnd(int(code)) for code in np.ravel(self.head["end"])]


@dataclass(frozen=True)
class _Begin:
    """Where motions begin, one per row: states, memory of the law, mode (−1: the state decides)."""

    states: Array
    memory: Array
    mode: NDArray[np.int64]


@dataclass(frozen=True)
class _Course:
    """Phases of motions.

    Attributes
    ----------
    row : ndarray of int, shape (phases,)
        Number of the motion of each phase, ascending.
    numbers : mapping of str to ndarray, shape (phases,)
        `PHASE`.
    end : ndarray of int, shape (motions,)
        Number of a `FrozenEnd`; `_RESUMES` where the slip has stopped and the motion goes on.
    later : _Begin
        There the state at which the slip has stopped.
    """

    row: NDArray[np.int64]
    numbers: Mapping[str, Array]
    end: NDArray[np.int64]
    later: _Begin


@dataclass(frozen=True)
class FrozenImpactSolver:
    """The impact of one contact with constant coefficients; build once, use often.

    Parameters
    ----------
    law : ContactLaw
    engine : {"auto", "compiled", "taylor", "erk"}
        As for `SoftenedSimulator`.
    """

    law: ContactLaw
    engine: str = "auto"

    @cached_property
    def simulator(self) -> SoftenedSimulator:
        """Of the general contact with the law."""
        return SoftenedSimulator(general_contact(), self.law, self.engine)

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
            `COEFFICIENTS` once the slip has stopped; by default those before it.

        Raises
        ------
        InputError
            Unknown or absent names, shapes that do not fit, numbers out of range.
        """
        rows = self._inputs(contact, start, parameters)
        starts = starts_of(self.simulator, rows, 0, rows.count)
        x, names = starts.states, self._names
        depth, rate, slip = -x[:, names["x_n"]], -x[:, names["x_n_dot"]], x[:, names["x_t_dot"]]
        b_n = rows.part(rows.inputs["b_n"], 0, rows.count)
        pressed = (depth > 0) | (rate > 0) | ((rate == 0) & (b_n < 0))
        end = np.where(pressed, FrozenEnd.FAILED.value, FrozenEnd.NO_IMPACT.value)
        active = pressed & (starts.refusal == RUNS)
        n, nz = len(x), len(self.simulator.outline.memory)
        begin = _Begin(x, np.zeros((n, nz)), np.full(n, -1))
        given, courses = starts.parameters, []
        if after is not None:
            moving = active & (slip != 0)
            first = self._follow(begin, given, starts.scales, moving, ("separation", "slip_stop"))
            end[moving] = first.end[moving]
            active &= ~moving | (end == _RESUMES)
            begin = first.later
            later = self._inputs({**after, "mu": contact["mu"]}, start, parameters)
            given = starts_of(self.simulator, later, 0, later.count).parameters
            courses.append(first)
        course = self._follow(begin, given, starts.scales, active, ("separation",))
        end[active] = course.end[active]
        return _impacts(rows.shape, (depth, rate, slip), b_n, [*courses, course], end)

    def _inputs(
        self,
        contact: Mapping[str, ArrayLike],
        start: Mapping[str, ArrayLike],
        parameters: Mapping[str, ArrayLike] | None,
    ) -> ManyInputs:
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
        return ManyInputs.of(self.simulator, states, {**own, **(parameters or {})}, None)

    @cached_property
    def _names(self) -> dict[str, int]:
        return {s.name: i for i, s in enumerate(self.simulator.outline.states)}

    @cached_property
    def _modes(self) -> tuple[Any, ...]:
        """Of every mode: direction of slip, whether it loads, its mode of sticking, its events."""
        outline = self.simulator.outline
        names = [m.name for m in outline.modes]
        parts = [name.partition("/") for name in names]
        most = max(len(m.transitions) for m in outline.modes)
        kinds = [[t.kind for t in m.transitions] for m in outline.modes]
        return (
            np.array([CONTACTS.get(contact, 0) for contact, _, _ in parts]),
            np.array([branch != self.law.unloading for _, _, branch in parts]),
            np.array([names.index(f"stick/{b}") if b else i for i, (_, _, b) in enumerate(parts)]),
            np.array([row + [""] * (most - len(row)) for row in kinds]),
        )

    def _follow(
        self,
        begin: _Begin,
        parameters: Array,
        scales: Array,
        active: NDArray[np.bool_],
        until: tuple[str, ...],
    ) -> _Course:
        """Follow the motions of the active rows until one of the events, or a held contact."""
        rows = np.flatnonzero(active)
        runs = [
            self.simulator.integrator.run(
                begin.states[k],
                parameters[k],
                RunOptions(
                    t_end=LONG,
                    rtol=RTOL,
                    atol=RTOL * scales[k],
                    until=until,
                    record="events",
                    max_events=MAX_EVENTS,
                    start_mode=int(begin.mode[k]),
                ),
                begin.memory[k],
            )
            for k in rows
        ]
        nx, nz = begin.states.shape[1], begin.memory.shape[1]
        events = np.concatenate([np.empty((0, 4 + 2 * (nx + nz))), *(r.events for r in runs)])
        counts = [len(r.events) for r in runs]
        rests = [r.stop_reason is StopReason.T_END for r in runs]
        end = np.full(len(active), FrozenEnd.FAILED.value)
        end[rows[rests]] = FrozenEnd.STAYS.value
        return self._read(begin, parameters, np.repeat(rows, counts), events, until, end)

    def _read(
        self,
        begin: _Begin,
        parameters: Array,
        row: NDArray[np.int64],
        events: Array,
        until: tuple[str, ...],
        end: NDArray[np.int64],
    ) -> _Course:
        """Read phases and ends off the events of the rows."""
        nx, nz = begin.states.shape[1], begin.memory.shape[1]
        slip_of, loads, sticking, kinds = self._modes
        time, mode = events[:, 0], events[:, 1].astype(int)
        kind, slip = kinds[mode, events[:, 2].astype(int)], slip_of[mode]
        after = events[:, 4 + nx + nz : 4 + 2 * nx + nz]
        p = dict(zip((s.name for s in self.simulator.outline.parameters), parameters.T, strict=True))
        # A contact that is pressed back by A > 0 in the mode of the event is held: it oscillates.
        push = p["A_stick"][row] + p["W_tt"][row] * p["kappa"][row] * (
            p["kappa"][row] - p["mu"][row] * slip
        )
        first = np.diff(row, prepend=-1) != 0
        since = np.where(first, 0.0, np.roll(time, 1))
        # Next to the turning point round-off may turn the motion back and forth in no time.
        held = (kind == "reload") & (time > since) & ((slip == 0) | (push > 0))
        over = held | np.isin(kind, until)
        earlier = np.cumsum(over) - over
        kept = earlier == np.maximum.accumulate(np.where(first, earlier, 0))
        over &= kept
        codes = np.where(held, FrozenEnd.STAYS.value, FrozenEnd.SEPARATION.value)
        end[row[over]] = np.where(kind == "slip_stop", _RESUMES, codes)[over]
        later = _Begin(begin.states.copy(), begin.memory.copy(), begin.mode.copy())
        later.states[row[over]], later.memory[row[over]] = after[over], events[over, 4 + 2 * nx + nz :]
        later.mode[row[over]] = sticking[mode[over]]
        # Neighbouring segments of one slip direction, both loading or both unloading, are a phase.
        real = np.flatnonzero(kept & (time > since))
        key = np.stack([row[real], slip[real], loads[mode[real]]])
        new = np.any(np.diff(key, axis=1, prepend=-2) != 0, axis=0)
        opens = real[new]
        closes = real[np.append(new[1:], True)[: len(real)]]
        came = np.where(first[:, None], begin.states[row], np.roll(after, 1, axis=0))
        turned = np.isin(kind[closes], ("max_compression", "reload"))
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


def _impacts(
    shape: tuple[int, ...],
    start: tuple[Array, Array, Array],
    b_n: Array,
    courses: Sequence[_Course],
    end: NDArray[np.int64],
) -> FrozenImpacts:
    """Join courses that follow each other; `start` holds δ, δ̇ and v_t."""
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
    last = np.append(np.diff(row) != 0, True)[: len(row)]
    rate[row[last]], slip[row[last]] = (
        numbers[n][last] for n in ("compression_rate", "slip_velocity")
    )
    # A motion that begins at rest on the surface may come back to it at rest, but for rounding.
    rests = (end == FrozenEnd.SEPARATION.value) & (b_n < 0) & (rate**2 <= AT_REST * -b_n * depth)
    rests[row[last]] &= numbers["loading"][last] == 0
    end, rate = np.where(rests, FrozenEnd.STAYS.value, end), np.where(rests, 0.0, rate)
    head = {"end": end.astype(float), "phases": counts.astype(float)}
    head |= {"slip_velocity": slip, "normal_velocity": 0.0 - rate, "largest_compression": depth}
    head |= {n: np.bincount(row, numbers[n], len(end)) for n in SUMS}
    return FrozenImpacts(
        {name: values.reshape(shape) for name, values in head.items()},
        {n: v.reshape(*shape, -1) for n, v in zip(PHASE, table, strict=True)},
    )


def _checked(what: str, given: Mapping[str, ArrayLike], names: Sequence[str]) -> dict[str, Array]:
    for name in given:
        if name not in names:
            raise InputError(f"impact: {what}: {unknown_name('input', name, names)}")
    absent = [name for name in names if name not in given]
    if absent:
        raise InputError(f"impact: {what}: no value of {', '.join(absent)}. Fix: give it.")
    return {name: np.asarray(given[name], dtype=float) for name in names}


@dataclass(frozen=True)
class CorrectedJumps:
    """Jumps at finite stiffness; every array has the shape of the cases.

    Attributes
    ----------
    impacts : FrozenImpacts
        The contact: phases, impulses, v_t and v_n at the end, how it ends.
    velocity : mapping of str to ndarray
        Velocities of the mechanism after the impact, by state name.
    configuration : str
    """

    impacts: FrozenImpacts
    velocity: Mapping[str, Array]
    configuration: str


@dataclass(frozen=True)
class CorrectedJumpRule:
    """The jump rule of a mechanism with a contact law at finite stiffness; build once, use often.

    Parameters
    ----------
    mechanism : Mechanism
        With exactly one contact.
    law : ContactLaw
    engine : {"auto", "compiled", "taylor", "erk"}
        As for `SoftenedSimulator`.

    References
    ----------
    docs/corrected-jump.md; Zhao, Liu & Chen, section 4, for the limit K → ∞.
    """

    mechanism: Mechanism
    law: ContactLaw
    engine: str = "auto"

    @cached_property
    def solver(self) -> FrozenImpactSolver:
        """Of the contact with constant coefficients."""
        return FrozenImpactSolver(self.law, self.engine)

    @cached_property
    def _symbols(self) -> tuple[Any, ...]:
        system = self.mechanism.system
        return (*system.q, *system.q_dot, *(p.symbol for p in system.parameters))

    @cached_property
    def _evaluate(self) -> Pointwise:
        c, system = self.mechanism.coefficients, self.mechanism.system
        contact = self.mechanism.contact
        normal, tangential = c.force_directions
        rows = [c.W_nn, c.W_nt, c.W_tt, c.b_n, c.b_t, c.mu]
        rows += [contact.slip_velocity, contact.gap_rate]
        rows += [*normal, *tangential, *system.free_acceleration]
        return Pointwise(rows, self._symbols, engine="casadi" if self.engine == "erk" else "auto")

    def __call__(
        self,
        state: Mapping[str, ArrayLike],
        parameters: Mapping[str, ArrayLike],
        compression: ArrayLike = 0.0,
        configuration: str = "frozen",
    ) -> CorrectedJumps:
        """Return the jumps from the states.

        The contact counts as touching, or compressed by δ₀ = `compression`.

        Parameters
        ----------
        state : mapping of str to float or ndarray
            Coordinates and velocities; absent ones are 0.
        parameters : mapping of str to float or ndarray
            Every parameter of the mechanism and of the law.
        compression : float or ndarray
            δ₀ ≥ 0; m. Its surface energy is K δ₀^(n+1)/(n+1).
        configuration : {"frozen", "carried"}
        """
        if configuration not in CONFIGURATIONS:
            raise InputError(
                f"corrected jump: configuration: got {configuration!r}, need one of "
                f"{', '.join(CONFIGURATIONS)}."
            )
        given = {**state, **parameters}
        point = {s: np.asarray(given.get(str(s), 0.0), float) for s in self._symbols}
        start = self._coefficients(point)
        inputs = (
            {name: start[name] for name in (*COEFFICIENTS, "mu")},
            {
                "slip_velocity": start["slip_velocity"],
                "compression": compression,
                "compression_rate": 0.0 - start["normal_velocity"],
            },
            {p.name: parameters[p.name] for p in self.law.parameters},
        )
        impacts = self.solver(*inputs)
        sets = (start, start)
        if configuration == "carried":
            sets = self._carried(point, start, impacts)
            inputs[0].update({name: sets[0][name] for name in COEFFICIENTS})
            impacts = self.solver(*inputs, after={name: sets[1][name] for name in COEFFICIENTS})
        return self._jumps(point, sets, impacts, configuration)

    def coefficients(
        self, state: Mapping[str, ArrayLike], parameters: Mapping[str, ArrayLike]
    ) -> dict[str, Array]:
        """Return what the impact needs of the mechanism at the states.

        The keys are W_nn, W_nt, W_tt, b_n, b_t, mu, slip_velocity, normal_velocity, and by
        velocity of the mechanism ``normal`` and ``tangential`` (M⁻¹J_Nᵀ, M⁻¹J_Tᵀ) and ``free``.
        """
        given = {**state, **parameters}
        return self._coefficients({s: np.asarray(given.get(str(s), 0.0), float) for s in self._symbols})

    def _coefficients(self, point: Mapping[Any, Array]) -> dict[str, Array]:
        rows = self._evaluate(point)
        size = len(self.mechanism.system.q_dot)
        names = (*COEFFICIENTS, "mu", "slip_velocity", "normal_velocity")
        found = dict(zip(names, rows, strict=False))
        for k, name in enumerate(("normal", "tangential", "free")):
            found[name] = rows[8 + k * size : 8 + (k + 1) * size]
        return found

    def _moved(
        self, coefficients: Mapping[str, Array], P: Array, P_t: Array, t: Array
    ) -> list[Array]:
        """Return M⁻¹(J_Nᵀ P_n + J_Tᵀ P_t) + f t, one array per velocity."""
        c = coefficients
        rows = zip(c["normal"], c["tangential"], c["free"], strict=True)
        return [n * P + d * P_t + f * t for n, d, f in rows]

    def _jumps(
        self,
        point: Mapping[Any, Array],
        sets: tuple[Mapping[str, Array], Mapping[str, Array]],
        impacts: FrozenImpacts,
        configuration: str,
    ) -> CorrectedJumps:
        parts = _halves(impacts, sets[0]["slip_velocity"] != 0)
        velocity = {}
        moved = [
            self._moved(c, p["normal_impulse"], p["tangential_impulse"], p["duration"])
            for c, p in zip(sets, parts, strict=True)
        ]
        for k, symbol in enumerate(self.mechanism.system.q_dot):
            velocity[str(symbol)] = point[symbol] + moved[0][k] + moved[1][k]
        return CorrectedJumps(impacts, velocity, configuration)

    def _carried(
        self,
        point: Mapping[Any, Array],
        start: Mapping[str, Array],
        impacts: FrozenImpacts,
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """Return the coefficients at the means of both parts of the impact.

        W belongs to the mean time of the impulse, T − ∫P dt/P; b to the mean time and velocities.
        """
        system = self.mechanism.system
        now, found = dict(point), []
        for part in _halves(impacts, start["slip_velocity"] != 0):
            t, P, P_t = part["duration"], part["normal_impulse"], part["tangential_impulse"]
            moment = part["impulse_time"]
            ratio = np.divide(P_t, P, out=np.zeros_like(P), where=P != 0)
            mean = t - np.divide(moment, P, out=np.zeros_like(P), where=P != 0)
            share = np.divide(moment, t, out=np.zeros_like(P), where=t != 0)
            by_impulse, by_time, end = dict(now), dict(now), dict(now)
            whole = self._moved(start, P, P_t, t)
            partly = self._moved(start, share, ratio * share, t / 2)
            for q, v, jump, half in zip(system.q, system.q_dot, whole, partly, strict=True):
                by_impulse[q] = now[q] + now[v] * mean
                by_time[q], by_time[v] = now[q] + now[v] * t / 2, now[v] + half
                end[q], end[v] = now[q] + (now[v] + half) * t, now[v] + jump
            mobile, free = self._coefficients(by_impulse), self._coefficients(by_time)
            found.append(mobile | {name: free[name] for name in ("b_n", "b_t", "free")})
            now = end
        return found[0], found[1]


def _halves(impacts: FrozenImpacts, moving: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return time, impulses and ∫P dt of the part until the slip stops, and of the rest."""
    phase = {name: np.nan_to_num(values) for name, values in impacts.phase.items()}
    slip, real = impacts.phase["slip"], ~np.isnan(impacts.phase["slip"])
    first = np.logical_and.accumulate((slip == slip[..., :1]) & moving[..., None], axis=-1)
    found = []
    for part in (first & real, ~first & real):
        own = np.where(part, phase["normal_impulse"], 0.0)
        # The impulse of the earlier phases of this part acts throughout a phase.
        moment = phase["impulse_time"] + (np.cumsum(own, axis=-1) - own) * phase["duration"]
        sums = {n: phase[n] for n in SUMS}
        sums["impulse_time"] = moment
        found.append({n: np.where(part, v, 0.0).sum(axis=-1) for n, v in sums.items()})
    return found[0], found[1]


@dataclass(frozen=True)
class CorrectedPhase:
    """One phase of a jump at finite stiffness.

    Attributes
    ----------
    name : str
        ``slip``, ``sticking`` or ``reverse slip``, then ``compression`` or ``restitution``.
    duration : float
        s.
    normal_impulse, tangential_impulse : float
        N s.
    compression : float
        δ at the end; m.
    slip_velocity, normal_velocity : float
        Of the contact at the end; m/s.
    """

    name: str
    duration: float
    normal_impulse: float
    tangential_impulse: float
    compression: float
    slip_velocity: float
    normal_velocity: float


@dataclass(frozen=True)
class CorrectedJump:
    """A jump at finite stiffness.

    Attributes
    ----------
    mechanism, law : str
        Names.
    configuration : {"frozen", "carried"}
    method : str
        ``integration``.
    stiffness, exponent : float
        K (N/mⁿ) and n.
    initial_compression : float
        δ₀; m.
    end : FrozenEnd
    phases : tuple of CorrectedPhase
    velocity, velocity_before : mapping of str to float
        Of the mechanism, by state name.
    """

    mechanism: str
    law: str
    configuration: str
    method: str
    stiffness: float
    exponent: float
    initial_compression: float
    end: FrozenEnd
    phases: tuple[CorrectedPhase, ...]
    velocity: Mapping[str, float]
    velocity_before: Mapping[str, float]

    @property
    def largest_compression(self) -> float:
        """Largest δ at the end of a phase; m."""
        return max([self.initial_compression, *(p.compression for p in self.phases)])

    @property
    def duration(self) -> float:
        """Of the whole impact; s."""
        return float(sum(p.duration for p in self.phases))


def evaluate_corrected_jump(
    mechanism: Mechanism,
    law: ContactLaw,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
    *,
    initial_force: float = 0.0,
    configuration: str = "frozen",
    engine: str = "auto",
) -> CorrectedJump:
    """Evaluate the jump at finite stiffness from one state.

    Parameters
    ----------
    mechanism : Mechanism
        With one contact.
    law : ContactLaw
        Any, with a dashpot or without.
    state : mapping of str to float
        Coordinates and velocities by name, those absent are 0; SI units, rad. The contact counts
        as closed whatever its gap.
    parameters : mapping of str to float, optional
        Of the mechanism and of the law; those absent keep their default.
    initial_force : float
        Surface energy at the start as the force of the initial compression; N.
    configuration : {"frozen", "carried"}
    engine : {"auto", "compiled", "taylor", "erk"}

    Raises
    ------
    InputError
        Unknown or invalid entries.
    """
    where = f"corrected jump of {mechanism.name!r}"
    declared = (*mechanism.system.parameters, *law.parameters)
    given = resolve_parameters(where, declared, parameters or {})
    start = resolve_state(mechanism, state, given)
    if not (np.isfinite(initial_force) and initial_force >= 0):
        raise InputError(f"{where}: initial force: got {initial_force!r}, need >= 0 and finite.")
    if configuration not in CONFIGURATIONS:
        known = ", ".join(CONFIGURATIONS)
        raise InputError(f"{where}: configuration: got {configuration!r}, need one of {known}.")
    rule = CorrectedJumpRule(mechanism, law, engine)
    simulator = rule.solver.simulator
    constants = simulator.constants(
        simulator.parameters({p.name: given[p.name] for p in law.parameters})
    )
    curve = simulator.loading_curve({s: np.array([v]) for s, v in constants.items()})
    K, n = (float(values[0]) for values in curve)
    delta = (initial_force / K) ** (1 / n)
    jump = rule(start, given, delta, configuration)
    numbers = {name: values.tolist() for name, values in jump.impacts.phase.items()}
    phases = []
    for k in range(int(jump.impacts.head["phases"])):
        of_phase = {name: values[k] for name, values in numbers.items()}
        name = _name(of_phase["slip"], of_phase["loading"], numbers["slip"][0])
        velocity = 0.0 - of_phase["compression_rate"]
        of_phase = {f: of_phase[f] for f in _PHASE_FIELDS}
        phases.append(CorrectedPhase(name=name, normal_velocity=velocity, **of_phase))
    return CorrectedJump(
        mechanism=mechanism.name,
        law=law.name,
        configuration=configuration,
        method=METHOD,
        stiffness=K,
        exponent=n,
        initial_compression=delta,
        end=jump.impacts.ends[0],
        phases=tuple(phases),
        velocity={name: float(value) for name, value in jump.velocity.items()},
        velocity_before={str(v): start[str(v)] for v in mechanism.system.q_dot},
    )


_PHASE_FIELDS = (*SUMS, "compression", "slip_velocity")


def _name(slip: float, loading: float, first: float) -> str:
    kind = "sticking" if slip == 0 else ("slip" if slip == first else "reverse slip")
    return f"{kind} {'compression' if loading else 'restitution'}"
