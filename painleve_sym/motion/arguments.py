"""Keyword arguments of runs, each named once: types for editors, and what is read from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import lru_cache
from inspect import Parameter, signature
from typing import TYPE_CHECKING, Any, Required, TypedDict, TypeVar

from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.choices import RecordLike
from painleve_sym.engines.protocol import RunSettings
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.materials import MaterialsLike
from painleve_sym.units import Value

if TYPE_CHECKING:
    from painleve_sym.motion.timetable import InputValues, Phase
    from painleve_sym.motion.trajectory import Trajectory

INITIAL_FORCE = "initial_force"
"""Of all arguments the one by which a motion can be differentiated."""


class SharedArguments(TypedDict, total=False):
    """Settings that runs and batches have; see `painleve_sym.simulate`."""

    until: str | Sequence[str]
    rtol: float
    first_step: Value
    max_step: Value
    max_steps: int
    max_events: int


class ContinuationArguments(SharedArguments, total=False):
    """Keyword arguments of the rest of a run; see `Trajectory.continued`."""

    parameters: Mapping[str, Value] | None
    law_parameters: Mapping[str, Value] | None
    material: MaterialsLike | None
    initial_force: Value | None
    close: str | None
    atol: Array | None
    record: RecordLike
    phases: Sequence[Phase] | None
    inputs: Mapping[str, InputValues] | None


class RunArguments(ContinuationArguments, total=False):
    """Keyword arguments of one run; see `painleve_sym.simulate`."""

    t_end: Required[Value]
    start: Trajectory | None


class BatchOptions(SharedArguments, total=False):
    """Keyword arguments of a batch besides its parameters; see `painleve_sym.simulate_batch`."""

    t_end: Required[Value]
    law_parameters: Mapping[str, ArrayLike] | None
    initial_force: ArrayLike | None
    close: str | None
    threads: int | None
    events: int
    maxima: Sequence[str]
    minima: Sequence[str]
    integrals: Sequence[str]
    phases: Sequence[Phase] | None
    inputs: Mapping[str, InputValues] | None
    start: Trajectory | None
    at_events: Sequence[str]


class BatchArguments(BatchOptions, total=False):
    """Keyword arguments of a batch; see `painleve_sym.simulate_batch`."""

    parameters: Mapping[str, ArrayLike] | None


OF_SCIPY = {
    "t_eval": "leave it out and ask the run, run.values(name, times) or run(times)",
    "t_span": "the motion begins at t = 0; give its end, t_end=",
    "y0": "give the state by names, as the third argument",
    "args": "give parameters by names, parameters= and law_parameters=",
    "fun": "the equations of motion are those of the mechanism",
    "method": "give the integrator, engine=",
    "events": "give the events to record, watch=, and those that end the motion, until=",
    "dense_output": "give record='dense', which is the default",
    "jac": "leave it out: derivatives are derived",
    "tol": "give rtol=",
}
"""Arguments of SciPy's integrators, and what has their place here."""
_SETTINGS = frozenset(f.name for f in fields(RunSettings))
_KNOWN = {kind: frozenset(kind.__annotations__) for kind in (RunArguments, BatchArguments)}
_Kind = type[RunArguments] | type[BatchArguments]
_F = TypeVar("_F", bound=Callable[..., Any])


def separated(
    where: str, kind: _Kind, given: Mapping[str, Any]
) -> tuple[RunSettings, dict[str, Any]]:
    """Return the checked settings among keyword arguments, and the other arguments.

    Raises
    ------
    InputError
        An unknown argument, no end time, a number out of range.
    """
    if not given.keys() <= _KNOWN[kind]:
        unknown = next(name for name in given if name not in _KNOWN[kind])
        if unknown in OF_SCIPY:
            raise InputError(
                f"{where}: argument {unknown!r} is one of SciPy. Fix: {OF_SCIPY[unknown]}."
            )
        raise InputError(f"{where}: {unknown_name('argument', unknown, sorted(_KNOWN[kind]))}")
    if "t_end" not in given:
        raise InputError(f"{where}: t_end: got none, need the end of the motion. Fix: t_end=0.1.")
    settings, others = dict[str, Any](), dict[str, Any]()
    for name, value in given.items():
        (settings if name in _SETTINGS else others)[name] = value
    try:
        return _checked(where, **settings), others
    except TypeError:  # a list or an array
        return RunSettings.of(where, settings), others


# Calls in a loop mostly have the settings of the one before.
@lru_cache(maxsize=64, typed=True)
def _checked(where: str, /, **settings: Any) -> RunSettings:
    return RunSettings.of(where, settings)


def spelled_out(kind: _Kind) -> Callable[[_F], _F]:
    """Let the signature of a function name the keyword arguments of `kind`, as `help` shows it."""
    usual = {f.name: f.default for f in fields(RunSettings)}
    usual |= {"t_end": Parameter.empty, "events": 1}
    usual |= dict.fromkeys(("maxima", "minima", "integrals", "at_events"), ())

    def decorate(function: _F) -> _F:
        own = signature(function)
        named = [p for p in own.parameters.values() if p.kind is not Parameter.VAR_KEYWORD]
        for name, annotation in kind.__annotations__.items():
            text = annotation.__forward_arg__.removeprefix("Required[")
            text = text if text == annotation.__forward_arg__ else text.removesuffix("]")
            given: Any = {"default": usual.get(name), "annotation": text}
            named.append(Parameter(name, Parameter.KEYWORD_ONLY, **given))
        described: Any = function
        described.__signature__ = own.replace(parameters=named)
        return function

    return decorate
