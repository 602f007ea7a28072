"""Parameters from measured motions: least squares with derivatives through every event."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares
from scipy.special import stdtrit

from painleve_sym.arrays import Array
from painleve_sym.checks import StateLike, by_name, names_of, number
from painleve_sym.choices import EngineLike, EngineName
from painleve_sym.codegen.named_mechanisms import MechanismLike
from painleve_sym.equality import Compared
from painleve_sym.errors import EventKind, InputError, StopReason, refuse_unknown
from painleve_sym.files import CsvFormat
from painleve_sym.laws.catalogue import LawsLike
from painleve_sym.mechanics.declarations import Parameter
from painleve_sym.motion.runs import simulator_of
from painleve_sym.motion.sensitivity.result import SensitiveTrajectory
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.timetable import InputValues, Phase
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.progress import Advance, progress
from painleve_sym.study.fitting.data import FitData, read_fit_data
from painleve_sym.study.fitting.result import FitResult
from painleve_sym.units import Value, in_si

RTOL = 1e-10
"""Of the motions: far below any measurement, and the derivatives then hold eight digits."""
TOLERANCE = 1e-10
"""Relative change of cost, step and gradient at which the least squares end."""
MAX_EVALUATIONS = 200
"""Of the model; a fit from usual start values takes ten to fifty."""
MAX_STEPS = 50_000
"""Of one motion; those that are measured take hundreds, and one near an accumulation any number."""
REWEIGHTINGS = 12
"""Rounds in which unknown noise levels are estimated; they converge in three to five."""
SETTLED = 1e-4
"""Relative change of the noise levels at which no further round is needed."""
DIFFERENCE = 1e-4
"""Relative change of an unknown for differences: slopes then hold five digits at `RTOL`."""
RANK_TOLERANCE = 1e-7
"""Ratio of the singular values of the scaled Jacobian below which the data leave a combination of
the parameters open: its error would be a million times that of the others."""


_ENDINGS = {
    0: "not converged: the limit of evaluations was reached",
    1: "converged (gradient)",
    2: "converged (cost)",
    3: "converged (step)",
    4: "converged (cost and step)",
}


@dataclass(frozen=True, eq=False)
class FitProblem(Compared):
    """Parameter estimation: the unknowns, the data and the model; see `fit` for the fields.

    Motions with `phases`, `inputs` or pulses have differences in place of derivatives.
    No `sigma`, or an empty one, stands for standard deviations that are estimated, no `until` for
    the end of the impact by the law, `contact_ends`.
    """

    simulator: Simulator
    data: FitData
    estimate: tuple[str, ...]
    state: Mapping[str, float]
    parameters: Mapping[str, float]
    until: tuple[str, ...] = ()
    t_end: float = 1.0
    sigma: Mapping[str, float] | None = None
    level: float = 0.95
    max_evaluations: int = MAX_EVALUATIONS
    max_steps: int = MAX_STEPS
    phases: Sequence[Mapping[str, Any]] = ()
    inputs: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        where, data = f"fit of {self.simulator.where}", self.data
        states = self.simulator.mechanism.state_names
        known = [*self._declared, *states]
        if not self.estimate:
            raise InputError(f"{where}: nothing to estimate. Fix: name parameters.")
        for name in self.estimate:
            refuse_unknown("parameter", name, known, where)
            if name in data.starts:
                raise InputError(f"{where}: start {name} is given by the data. Fix: drop one.")
            if self.estimate.count(name) > 1:
                raise InputError(f"{where}: got {name!r} twice. Fix: name it once.")
        for name in data.starts:
            refuse_unknown("state", name, states, f"{data.where}: start")
            if name in self.state:
                raise InputError(f"{data.where}: start {name} is given twice. Fix: drop one.")
        for name, value in (self.sigma or {}).items():
            refuse_unknown("column", name, data.measured, f"{where}: sigma")
            number(value, f"sigma of {name}", where=where, above=0.0)
        missing = set(data.measured) - set(self.sigma or {})
        if self.sigma and missing:
            raise InputError(f"{where}: sigma of {sorted(missing)[0]} is missing. Fix: give all.")
        number(self.level, "level", where=where, above=0.0, below=1.0)
        number(self.max_evaluations, "max_evaluations", where=where, lower=1)
        if data.count <= len(self.estimate):
            raise InputError(
                f"{data.where}: too few rows: got {data.count} measured values, need more than "
                f"the number of unknowns, {len(self.estimate)}. Fix: measure more."
            )

    @property
    def _declared(self) -> dict[str, Parameter]:
        return self.simulator.declared.by_name

    @cached_property
    def _ends_by(self) -> tuple[str, ...]:
        """Events that end each motion of a row."""
        kinds = self.simulator.stepped.outline.kinds
        ends = self.until or contact_ends(kinds)
        if not ends:
            raise InputError(
                f"fit of {self.simulator.where}: until: no contact of these laws separates. "
                f"Fix: name one of the events {', '.join(map(str, kinds))}."
            )
        return ends

    # ---- the model ----

    def predict(self, values: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        """Return the model at all rows (n,) and its derivatives (n, k), by measured quantity."""
        if self.phases or self.inputs or self.simulator.pulses:
            return self._by_differences(values)
        state, parameters = self._start_of(values)
        if self.data.times is not None:
            return self._history(state, parameters)
        return self._ends(state, parameters)

    def _start_of(self, values: Array) -> tuple[dict[str, float], dict[str, float]]:
        """Return state and parameters with the unknowns."""
        given = dict(zip(self.estimate, map(float, values), strict=True))
        own = {n: v for n, v in given.items() if n in self._declared}
        states = {n: v for n, v in given.items() if n not in self._declared}
        return {**self.state, **states}, {**self.parameters, **own}

    def _by_differences(self, values: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        """Return the model and its central differences, one-sided at the end of a range."""
        model, low, high = self._model(values), *self._bounds(np.zeros(len(values), bool))
        slopes = {n: np.empty((len(v), len(values))) for n, v in model.items()}
        for j, value in enumerate(values):
            step = DIFFERENCE * (abs(value) or 1.0)
            ends = []
            for sign in (1, -1):
                moved = values.copy()
                moved[j] = np.clip(value + sign * step, low[j], high[j])
                ends.append((moved[j], self._model(moved)))
            (after, later), (before, earlier) = ends
            for n, column in slopes.items():
                column[:, j] = (later[n] - earlier[n]) / (after - before)
        return model, slopes

    def _model(self, values: Array) -> dict[str, Array]:
        """Return the measured quantities at all rows, of motions with what changes on the way."""
        state, parameters = self._start_of(values)
        common: dict[str, Any] = {"parameters": parameters, "rtol": RTOL}
        common |= {"max_steps": self.max_steps, "phases": self.phases, "inputs": self.inputs}
        times, names = self.data.times, self.data.measured
        if times is not None:
            run = self.simulator.run(state, t_end=self._history_end, **common)
            self._check_history(run)
            return {n: run.values(n, times) for n in names}
        ends = []
        for i in range(len(next(iter(names.values())))):
            start = {**state, **{n: float(v[i]) for n, v in self.data.starts.items()}}
            run = self.simulator.run(
                start, t_end=self.t_end, until=self._ends_by, record="events", **common
            )
            self._check_end(run, i)
            ends.append(run.final)
        return {n: np.array([end[n] for end in ends]) for n in self._state_columns()}

    @property
    def _history_end(self) -> float:
        """End of a history, s."""
        assert self.data.times is not None
        return float(self.data.times[-1]) * (1 + 1e-12) or 1e-12

    def _check_history(self, run: Trajectory) -> None:
        """Raise InputError where a motion ends before the last row."""
        assert self.data.times is not None
        last = float(self.data.times[-1])
        if run.final_time < last:
            raise InputError(
                f"fit: the motion stops at t = {run.final_time:g} s ({run.stop_reason.label}), "
                f"before the last row at {last:g} s. Fix: give other start values, or fewer rows."
            )

    def _check_end(self, run: Trajectory, row: int) -> None:
        """Raise InputError where the motion of a row ends otherwise than by an event."""
        if run.stop_reason is not StopReason.UNTIL:
            raise InputError(
                f"fit, row {row + 1}: the motion ends by {run.stop_reason.label} at t = "
                f"{run.final_time:g} s, not at {' or '.join(self._ends_by)}. Fix: give another "
                "event, a later end time or other start values."
            )

    def _run(
        self, state: Mapping[str, float], parameters: Mapping[str, float], row: str, **options: Any
    ) -> SensitiveTrajectory:
        sensitivities = self.simulator.sensitivities(
            state, self.estimate, parameters=parameters, rtol=RTOL, max_steps=self.max_steps,
            **options,
        )  # fmt: skip
        if sensitivities.singular is not None or sensitivities.valid_until < math.inf:
            kind = sensitivities.singular.event.kind if sensitivities.singular else "the start"
            raise InputError(
                f"fit, {row}: derivatives are singular at {kind}, "
                f"t = {sensitivities.valid_until:g} s. "
                "Fix: leave this row out, or start from other values."
            )
        return sensitivities

    def _history(
        self, state: Mapping[str, float], parameters: Mapping[str, float]
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        times = self.data.times
        assert times is not None
        sensitivities = self._run(state, parameters, "history", t_end=self._history_end)
        run = sensitivities.trajectory
        self._check_history(run)
        names = self.data.measured
        return (
            {n: run.values(n, times) for n in names},
            {n: sensitivities.gradient(n, times) for n in names},
        )

    def _ends(
        self, state: Mapping[str, float], parameters: Mapping[str, float]
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        rows = len(next(iter(self.data.measured.values())))
        names = self._state_columns()
        values = {n: np.empty(rows) for n in names}
        slopes = {n: np.empty((rows, len(self.estimate))) for n in names}
        for i in range(rows):
            start = {**state, **{n: float(v[i]) for n, v in self.data.starts.items()}}
            sensitivities = self._run(
                start, parameters, f"row {i + 1}",
                t_end=self.t_end, until=self._ends_by, record="events",
            )  # fmt: skip
            run = sensitivities.trajectory
            self._check_end(run, i)
            for n in names:
                j = run.state_names.index(n)
                values[n][i] = run.final_state[j]
                slopes[n][i] = sensitivities.final_jacobian[j]
        return values, slopes

    def _state_columns(self) -> Sequence[str]:
        names = tuple(self.data.measured)
        known = [s.name for s in self.simulator.stepped.automaton.states]
        for n in names:
            refuse_unknown("state", n, known, f"{self.data.where}: end")
        return names

    # ---- the least squares ----

    def _start(self) -> Array:
        known = {**self.state, **self.simulator.declared.defaults, **self.parameters}
        values = [known.get(n, 0.0) for n in self.estimate]
        for name, value in zip(self.estimate, values, strict=True):
            fault = self._declared[name].fault(value) if name in self._declared else None
            if fault:
                raise InputError(f"fit: {fault}")
        return np.array(values, dtype=float)

    def _logarithmic(self) -> Any:
        """Return which quantities are positive by nature, and so fitted by logarithm."""
        declared = [self._declared.get(n) for n in self.estimate]
        return np.array([p is not None and p.lower == 0 and not p.lower_closed for p in declared])

    def _bounds(self, logarithmic: Any) -> tuple[Array, Array]:
        declared = [self._declared.get(n) for n in self.estimate]
        low = np.array([p.lower if p else -np.inf for p in declared])
        high = np.array([p.upper if p else np.inf for p in declared])
        low, high = np.where(logarithmic, -np.inf, low), np.where(logarithmic, np.inf, high)
        return low, high

    def solve(self) -> FitResult:
        """Estimate.

        Raises
        ------
        InputError
            The model cannot follow the data from these start values, or the data leave a
            combination of the unknowns open.
        """
        with progress("fit", self.max_evaluations, "evaluations") as advance:
            return self._solved(advance)

    def _solved(self, advance: Advance) -> FitResult:
        start, logarithmic = self._start(), self._logarithmic()
        low, high = self._bounds(logarithmic)
        memory: dict[bytes, Any] = {}
        evaluations = 0
        measured = self.data.measured
        filled = {n: np.isfinite(v) for n, v in measured.items()}
        noise = dict(self.sigma or {n: _spread(v[filled[n]]) for n, v in measured.items()})

        def values_of(x: Array) -> Array:
            with np.errstate(over="ignore"):  # infinite values are rejected like others
                return np.where(logarithmic, np.exp(np.where(logarithmic, x, 0.0)), x)

        def predicted(x: Array) -> Any:
            nonlocal evaluations
            key = x.tobytes()
            if key not in memory:
                evaluations += 1
                advance(1)
                memory[key] = self.predict(values_of(x))
            return memory[key]

        def residuals(x: Array) -> Array:
            try:
                model = predicted(x)[0]
            except InputError:
                if not memory:
                    raise
                # The optimiser takes a shorter step from where the motions could be followed.
                return np.full(self.data.count, np.inf)
            return np.concatenate([v / noise[n] for n, v in self._misses(model).items()])

        def jacobian(x: Array) -> Array:
            slopes = predicted(x)[1]
            rows = np.vstack([slopes[n][filled[n]] / noise[n] for n in measured])
            return rows * np.where(logarithmic, values_of(x), 1.0)

        x = np.where(logarithmic, np.log(np.where(logarithmic, start, 1.0)), start)
        x = np.clip(x, *_inside(low, high))
        for _ in range(1 if self.sigma else REWEIGHTINGS):
            fit = least_squares(
                residuals, x, jac=jacobian, bounds=(low, high), x_scale="jac",
                xtol=TOLERANCE, ftol=TOLERANCE, gtol=TOLERANCE,
                max_nfev=max(1, self.max_evaluations - evaluations),
            )  # fmt: skip
            x = fit.x
            if self.sigma or evaluations >= self.max_evaluations:
                break
            misses = self._misses(predicted(x)[0])
            new = {n: _rms(v) or noise[n] for n, v in misses.items()}
            change = max(abs(new[n] / noise[n] - 1) for n in noise)
            noise = new
            if change < SETTLED:
                break
        plain = jacobian(x) / np.where(logarithmic, values_of(x), 1.0)
        return self._result(
            start, values_of(x), plain, residuals(x), predicted(x)[0], evaluations,
            _ENDINGS.get(int(fit.status), str(fit.message)),
        )  # fmt: skip

    def _result(
        self,
        start: Array,
        estimate: Array,
        jacobian: Array,
        residuals: Array,
        model: Mapping[str, Array],
        evaluations: int,
        message: str,
    ) -> FitResult:
        freedom = len(residuals) - len(estimate)
        lengths = np.linalg.norm(jacobian, axis=0)
        singular, vt = self._identified(jacobian, lengths)
        inverse = (vt.T / singular) / lengths[:, None]
        covariance = inverse @ inverse.T
        error = np.sqrt(np.diag(covariance))
        # Before the noise is in it, which is 0 where the model meets every value.
        correlation = covariance / np.outer(error, error)
        noise = dict(self.sigma or {})
        if not noise:
            error = error * math.sqrt(float(residuals @ residuals) / freedom)
            misses = self._misses(model)
            noise = {n: _rms(v) * math.sqrt(len(residuals) / freedom) for n, v in misses.items()}
        # Standard deviations that are known have the normal distribution's quantile.
        known = math.inf if self.sigma else freedom
        reach = float(stdtrit(known, 0.5 + self.level / 2)) * error
        return FitResult(
            names=self.estimate,
            units=tuple(self.simulator.units[n] for n in self.estimate),
            start=start,
            estimate=estimate,
            standard_error=error,
            interval=np.column_stack([estimate - reach, estimate + reach]),
            level=self.level,
            freedom=freedom,
            correlation=correlation,
            noise=noise,
            noise_given=bool(self.sigma),
            measured=self.data.measured,
            model=model,
            times=self.data.times,
            evaluations=evaluations,
            condition=float(singular[0] / singular[-1]),
            message=message,
        )

    def _misses(self, model: Mapping[str, Array]) -> dict[str, Array]:
        """Return the residuals, model less data, of each measured quantity."""
        return {n: (model[n] - v)[np.isfinite(v)] for n, v in self.data.measured.items()}

    def _identified(self, jacobian: Array, lengths: Array) -> tuple[Array, Array]:
        """Return singular values and right vectors of the Jacobian with columns of length one.

        InputError where it is rank deficient.
        """
        for name, length in zip(self.estimate, lengths, strict=True):
            if not length > 0:
                raise InputError(f"fit: the data do not depend on {name}. Fix: do not estimate it.")
        _, singular, vt = np.linalg.svd(jacobian / lengths, full_matrices=False)
        if singular[-1] > RANK_TOLERANCE * singular[0]:
            return singular, vt
        share = np.abs(vt[-1])
        names = [n for n, w in zip(self.estimate, share, strict=True) if w > 0.1 * share.max()]
        raise InputError(
            f"fit: the data determine only a combination of {', '.join(names)} (singular values "
            f"of the Jacobian down to {singular[-1] / singular[0]:.1e} of the largest). "
            "Fix: estimate fewer of them, or measure something else."
        )


def fit(
    mechanism: MechanismLike,
    law: LawsLike,
    data: FitData | str | Path | Mapping[str, ArrayLike],
    estimate: str | Sequence[str],
    *,
    state: StateLike | None = None,
    parameters: Mapping[str, Value] | None = None,
    law_parameters: Mapping[str, Value] | None = None,
    csv: CsvFormat | Mapping[str, Any] | None = None,
    until: str | Sequence[str] = (),
    t_end: Value = 1.0,
    sigma: Mapping[str, Value] | None = None,
    level: float = 0.95,
    max_evaluations: int = MAX_EVALUATIONS,
    max_steps: int = MAX_STEPS,
    engine: EngineLike = EngineName.AUTO,
    phases: Sequence[Phase] = (),
    inputs: Mapping[str, InputValues] | None = None,
    watch: str | Sequence[str] = (),
) -> FitResult:
    """Estimate parameters, or start values, from measured motions by least squares.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
    law : ContactLaw or RigidLaw, or its name, or mapping of contact to these
    data : FitData, or the path of a CSV file, or mapping of str to array_like
        See `read_fit_data` for the columns; a pandas data frame is such a mapping.
    estimate : sequence of str
        Parameters of mechanism and law, or start values of a history.
    state : mapping of str to float, optional
        Start values that the data do not give; those of the mechanism's `start` where no state is
        given.
    parameters, law_parameters : mapping of str to float
        Known parameters, and from where the estimated ones start.
    csv : CsvFormat, or mapping of its settings, optional
        How the file is written: lines to skip, separator, decimal sign, columns by formulas.
    until : EventKind, its text, or several
        Events that end each motion, where every row is a motion; by default `separation`,
        `impact_end` of one rigid contact, `impact` of several.
    t_end : float
        By when it has ended; s.
    sigma : mapping of str to float, optional
        Known standard deviations of all measured quantities; they are estimated where none are
        given.
    level : float
        Of the confidence intervals, in (0, 1).
    max_evaluations : int
        Evaluations of the model after which the least squares end, converged or not; the result's
        `message` says which.
    max_steps : int
        Of one motion.
    engine : EngineName or its text
    phases, inputs
        Of each motion, as for `painleve_sym.simulate`.
    watch : str or sequence of str
        Further events by which a motion may end, as for `simulate`: heights of rebounds are those
        at ``until="apex"`` with ``watch="apex"``.

    Raises
    ------
    InputError
        Unreadable data, unknown names, fewer measured values than unknowns.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> measured = "examples/studies/fit/impacts.csv"
    >>> result = ps.fit("rod", "bilinear-hertz", measured, ["e_energetic", "mu"])
    >>> result.names
    ('e_energetic', 'mu')
    """
    simulator = simulator_of(mechanism, law, engine, watch)
    known, units = simulator.mechanism, simulator.units
    estimate = names_of(estimate, "fit: estimate", "mu,E")
    parameters = in_si(simulator.given(parameters, law_parameters), units, "fit: parameters")
    rows = data
    if not isinstance(rows, FitData):
        constants = known_constants(simulator, parameters, estimate)
        rows = read_fit_data(rows, known, csv, constants)
    elif csv is not None:
        raise InputError("fit: csv: got it with FitData, which are read. Fix: leave it out.")
    if state is not None:
        given = known.outline.named_state("fit: state", state)
    else:
        given = {name: value for name, value in known.start.items() if name not in rows.starts}
    return FitProblem(
        simulator=simulator,
        data=rows,
        estimate=estimate,
        state=in_si(given, units, "fit: state"),
        parameters=parameters,
        until=names_of(until, "fit: until", "separation") if until else (),
        t_end=number(t_end, "t_end", where="fit", unit="s", above=0.0),
        sigma=in_si(by_name(sigma, "fit: sigma"), units | rows.units, "fit: sigma"),
        level=level,
        max_evaluations=max_evaluations,
        max_steps=max_steps,
        phases=phases,
        inputs=inputs or {},
    ).solve()


def known_constants(
    simulator: Simulator, parameters: Mapping[str, float], estimate: Sequence[str]
) -> dict[str, float]:
    """Return the parameters of mechanism and laws that are not estimated, for formulas of data."""
    values = simulator.parameters(parameters)
    return {name: value for name, value in values.items() if name not in estimate}


def contact_ends(kinds: Sequence[EventKind]) -> tuple[str, ...]:
    """Return the kinds of events that end a contact, among the kinds of the laws."""
    if EventKind.IMPACT_END in kinds:
        return (str(EventKind.IMPACT_END),)
    return tuple(str(k) for k in (EventKind.SEPARATION, EventKind.IMPACT) if k in kinds)


def _spread(values: Array) -> float:
    """Return a first guess of a column's scale."""
    return float(np.std(values)) or float(np.max(np.abs(values), initial=0.0)) or 1.0


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _inside(low: Array, high: Array) -> tuple[Array, Array]:
    """Return bounds a little inside: the optimiser needs a start that is not on them."""
    room = np.where(np.isfinite(high - low), 1e-9 * (high - low), 1e-12)
    return low + room, high - room
