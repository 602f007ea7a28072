"""One call from a mechanism and a law to a motion or a batch of motions."""

from __future__ import annotations

import functools
import threading
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Unpack

from painleve_sym.automata.watch import watch_texts
from painleve_sym.checks import StateLike
from painleve_sym.choices import EngineLike, EngineName, chosen
from painleve_sym.codegen.named_mechanisms import MechanismLike, as_mechanism
from painleve_sym.laws.catalogue import Law, LawsLike, as_law
from painleve_sym.mechanics.declarations import with_fields
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.arguments import BatchArguments, RunArguments, spelled_out
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from painleve_sym.motion.batch.result import BatchResult

_KEPT = 32
"""Simulators that are kept for further calls."""


class _KeptSimulators:
    """Cache of simulators of the last calls, by mechanism, laws and engine."""

    def __init__(self) -> None:
        self._simulators: OrderedDict[Any, Simulator] = OrderedDict()
        self._lock = threading.Lock()

    def get(
        self,
        mechanism: Mechanism,
        law: Law | Mapping[str, Law],
        engine: str,
        watch: tuple[str, ...] = (),
    ) -> Simulator:
        """Return the simulator; where only defaults differ it shares the compiled engine."""
        laws = law.items() if isinstance(law, Mapping) else (("", law),)
        try:
            derived = (
                mechanism.definition,
                *((name, own.definition) for name, own in laws),
                engine,
                watch,
            )
        except TypeError:  # a formula without a definition, so that there is no key for it
            return Simulator(mechanism, law, EngineName(engine), watch)
        declared = (mechanism.outline, *(own for _, own in laws))
        defaults = tuple(p.default for owner in declared for p in owner.parameters)
        with self._lock:
            known = self._simulators.pop((derived, defaults), None)
            if known is None:
                known = Simulator(mechanism, law, EngineName(engine), watch)
                alike = next((s for (d, _), s in self._simulators.items() if d == derived), None)
                if alike is not None and not mechanism.outline.pulsed:
                    known = with_fields(known, integrator=alike.integrator)
            self._simulators[derived, defaults] = known
            while len(self._simulators) > _KEPT:
                self._simulators.popitem(last=False)
        return known


_kept = _KeptSimulators()
_law_of_name = functools.lru_cache(maxsize=64)(as_law)


def simulator_of(
    mechanism: MechanismLike,
    law: LawsLike,
    engine: EngineLike = EngineName.AUTO,
    watch: str | Sequence[str] = (),
) -> Simulator:
    """Return the simulator of a mechanism with its law; one of an earlier call where it is kept."""
    name = chosen(EngineName, engine, "engine")
    laws = _law_of_name(law) if isinstance(law, str) else as_law(law)
    return _kept.get(as_mechanism(mechanism), laws, name, watch_texts(watch))


@spelled_out(RunArguments)
def simulate(
    mechanism: MechanismLike,
    law: LawsLike,
    state: StateLike | None = None,
    *,
    engine: EngineLike = EngineName.AUTO,
    watch: str | Sequence[str] = (),
    **arguments: Unpack[RunArguments],
) -> Trajectory:
    """Integrate the motion of a mechanism with its contact law from t = 0.

    The same as `Simulator(mechanism, law, engine).run(state, ...)`; the simulator is kept for
    further calls.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
    law : ContactLaw or RigidLaw, or its name, or mapping of contact to these
        One law for all contacts, or the law of each by the contact's name.
    state : mapping of str to (float or str), Series, or array_like, optional
        Coordinates and velocities by name or symbol, SI units and rad; absent ones are 0. Or a
        number for each of the mechanism's `state_names`, in their order. The mechanism's `start`
        where no state is given. A negative gap is a compression, which only a compliant contact may
        have.
    t_end : float or str
        s, > 0; or a text with its unit, such as ``1 ms``.
    until : EventKind, its text, or several
        Kinds of events that end the run, after what else happens at that instant: a rigid contact
        that touches down has its impact, and `final` is the state after it. With ``before_`` in
        front, as ``before_touchdown``, the run ends before the first event of that kind: time is
        that of the event, state, mode and memory are those just before, as at a terminal event of
        SciPy, and `Trajectory.continued` begins with the event.
    parameters, law_parameters : mapping of str to (float or str)
        Of the mechanism, and of the law; absent ones have their defaults. Parameters of laws may
        also be among the former: a name that both have is the mechanism's there, and the law's
        has ``_law`` behind it.
    material : Material or its name, or two, optional
        Sets every parameter that stands for a property of it and is not given: one of both bodies,
        or those of the moving body and of the other, ``steel,rubber``. Natural periods of bars
        follow from it, for `Trajectory.notices`.
    initial_force : float or str
        Sets the initial compression so that the only, compliant contact carries this force; N.
        Where the gap is not a coordinate, the coordinates stay and the surface counts as raised
        by it.
    close : str, optional
        A coordinate for which gap = 0 is solved from the given state, ``CONTACT:COORDINATE`` with
        several contacts; see `at.closing.closed_state`.
    engine : EngineName or its text
    watch : str or sequence of str
        Events to record besides those of the contacts, which change nothing: ``apex`` (the rate of
        a gap falls through 0; ``apex(y)`` that of a coordinate), ``peak(normal_force)`` (a maximum
        of a state or output), ``section(theta - 0.3)`` (a formula of states, parameters and, where
        it is a state, the time falls through 0, as an event of SciPy with direction −1), and
        ``strobe(2*pi/omega, 0.1)`` (at the times offset + k period, k = 0, 1, …, by formulas of
        parameters; s). Those with which a run begins are left out.
    rtol : float
        Relative tolerance of every state, in [1e-15, 1).
    atol : ndarray, shape (nx,)
        Per state; by default scaled to the contact (see `Preparation.scales`).
    record : Record or its text
        Extent of the recorded run: ``dense``, ``events`` or ``end``.
    first_step, max_step : float or str
        s; a first step of 0 lets the engine choose it.
    max_steps, max_events : int
        Where they are reached the run stops and says so.
    phases : sequence of mapping, optional
        What changes at a known ``time``, s, and holds from then on: ``parameters``,
        ``law_parameters``, ``law``, ``contacts`` (the names of those that are present). The motion
        is that of pieces, each `Trajectory.continued` from the one before.
    inputs : mapping of str to (mapping or path), optional
        Values of an `Input` of the mechanism, or of a parameter, as a function of time: ``times``,
        s, ``values``, and ``interpolation``: ``held`` (by default), ``linear`` or ``cubic``, which
        inputs alone have. Steps end at these times. In place of times and values, ``file`` is a CSV
        file with the columns ``time``, by default t, and ``column``, by default the name of the
        input, with units in their headers; ``csv`` says how it is written (`CsvFormat`).
    start : Trajectory, optional
        A motion of the same mechanism, in place of a state: this one begins at its end and its
        time, with its parameters, and under the same laws in its mode with its memory. Phases and
        inputs that are not given are those of that motion.

    Returns
    -------
    Trajectory
        Also when it stopped early: `stop_reason` says why. Of several contacts, forces and gaps of
        each are the outputs ``normal_force_<contact>``, …; where the bodies' rigidity leaves forces
        open, contacts share them in proportion to what their friction carries.

    Raises
    ------
    InputError
        Unknown names, numbers out of range, a start outside the domain or inside the ground, a
        phase that moves a closed contact, an input that is not known up to the end.

    References
    ----------
    Impact model resolution on Painlevé's paradox, sections 2 and 3; the start below is that of
    its Table 3.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> start = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> law = ps.laws.bilinear_hertz(E=209e9)
    >>> run = ps.simulate("rod", law, start, t_end=1e-2)
    >>> run.stop_reason
    <StopReason.T_END: 't_end'>
    >>> event = run.events[0]
    >>> print(f"{event.kind} at {event.time:.6e} s, {event.normal_force:.3f} N")
    slip_stop at 1.743476e-03 s, 880.495 N
    """
    return simulator_of(mechanism, law, engine, watch).run(state, **arguments)


@spelled_out(BatchArguments)
def simulate_batch(
    mechanism: MechanismLike,
    law: LawsLike,
    states: StateLike | None = None,
    *,
    engine: EngineLike = EngineName.AUTO,
    watch: str | Sequence[str] = (),
    **arguments: Unpack[BatchArguments],
) -> BatchResult:
    """Integrate one motion for every entry of the arrays, in threads over compiled code.

    Each row is the same, bit for bit, as `simulate` on its own numbers. See `run_batch` for what
    becomes of rows that fail.

    Parameters
    ----------
    mechanism, law, engine, watch
        As for `simulate`.
    states : mapping of str to array_like, DataFrame, or array_like
        Numbers, or arrays that broadcast against each other; or one array whose last axis is that
        of the mechanism's `state_names`.
    parameters, law_parameters : mapping of str to array_like
        Numbers, or arrays that broadcast.
    initial_force : array_like
        N.
    close : str, optional
        A coordinate for which gap = 0 is solved in every row, as `simulate` does.
    t_end, until, rtol, first_step, max_step, max_steps, max_events
        As for `simulate`; the same for every row.
    phases, inputs
        As for `simulate`, the same for every row, of parameters alone. Rows then run in Python.
    start : Trajectory, optional
        A motion of the same mechanism, in place of states: every row continues it from its end on,
        under the same laws in its mode with its memory, with parameters of its own.
    threads : int
        By default the processors this process may use.
    events : int
        How many event times of each kind are kept, the first ones; all are counted.
    at_events : sequence of str
        States or outputs that are kept at the first `events` events of a kind, just before or after
        the instant: ``gap_rate_before_touchdown``; see `Trajectory.at_events`.
    maxima, minima, integrals : sequence of str
        Outputs (``normal_force``, ``compression``, …) of which the extreme over the run with its
        time, or the integral, is kept: that of ``normal_force`` is the normal impulse.

    Returns
    -------
    BatchResult
        Arrays of the shape that all the given ones broadcast to.

    Raises
    ------
    InputError
        Unknown names, shapes that do not fit, numbers that are not finite or out of range, more
        rows than memory holds: before anything runs.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> start = {"theta": [0.9, 1.0], "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> runs = ps.simulate_batch("rod", "bilinear-hertz", start, t_end=1e-2, until="separation")
    >>> runs["stop_reason"].tolist()
    ['until', 'until']
    """
    from painleve_sym.motion.batch.run import run_batch

    return run_batch(simulator_of(mechanism, law, engine, watch), states, **arguments)
