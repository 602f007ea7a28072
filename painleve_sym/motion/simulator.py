"""A mechanism with its contact laws, ready to run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.at.delassus import Delassus
from painleve_sym.at.inputs import closed_place
from painleve_sym.checks import StateLike, by_name, names_of
from painleve_sym.codegen.mode_equations import (
    ModeEquations,
    casadi_equations,
    lambdified_equations,
)
from painleve_sym.engines.protocol import BEFORE, ENDLESS, RawRun, RunOptions, RunSettings
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, StopReason, received, refuse_unknown, unknown_name
from painleve_sym.hooks import upper
from painleve_sym.mechanics.declarations import ParameterSet, with_fields
from painleve_sym.mechanics.materials import MaterialsLike, two_materials
from painleve_sym.mechanics.mechanism import Mechanism, Place
from painleve_sym.motion.arguments import RunArguments, separated, spelled_out
from painleve_sym.motion.continuation import (
    at_its_time,
    carried,
    check_origin,
    check_watches,
    first_state,
    has_states_of,
    options_of_rest,
    same_parameters,
)
from painleve_sym.motion.force_jumps import integrated
from painleve_sym.motion.joined import timetable_of
from painleve_sym.motion.locate_limit import with_limit
from painleve_sym.motion.mechanism_with_laws import MechanismWithLaws, Start
from painleve_sym.motion.pieces import run_in_pieces
from painleve_sym.motion.records import EngineOutputs
from painleve_sym.motion.refusals import checked_force, end_detail, refuse, refuse_plastic
from painleve_sym.motion.run_record import RunRecord
from painleve_sym.motion.still_contacts import with_still_contacts
from painleve_sym.motion.timetable import Timetable
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.units import Value

if TYPE_CHECKING:
    from painleve_sym.motion.sensitivity.result import SensitiveTrajectory

NO_FORCE = -1.0
"""Initial force that stands for none."""


@dataclass(frozen=True, init=False, repr=False, eq=False)
class Simulator(Compared, MechanismWithLaws):
    """A mechanism with its contact laws, ready to run; build once, run often.

    **One compliant contact** follows the branches of its law. **One rigid contact**: in the
    inconsistent state the impact without collision happens. In the indeterminate state the policy
    chooses, and the event of that choice lists all solutions as `alternatives`. Bounces that
    accumulate end in contact at their limit time (event ``settle``). A slip that runs into
    A = B = 0, where the contact force grows without bound, ends the run with
    StopReason.DYNAMIC_JAM, any other that meets A = 0 with SINGULAR; `Trajectory.limit` holds time
    and state it would arrive at. A contact at rest that can also leave in growing bounces lists
    ``reverse_chatter`` among its `alternatives`, and `Trajectory.reverse_chatter` tells of bounces
    that do grow. A bilateral contact keeps its gap 0. Where its slip
    has two forces, the policy takes that with A > 0 (liftoff), that with A < 0 (slip), or the
    tangential impact.

    **Several contacts**, of any kinds: at an event every combination of what the closed contacts
    may do is held against their contact problem, and where several motions are possible the policy
    of the rigid law chooses; the event ``contact`` lists all. Rigid contacts that touch down, or
    for which no forces are possible, have an impact, which follows the path of
    `solve_simultaneous_impact`; the event ``impact`` has the impulses.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
    law : ContactLaw or RigidLaw, or its name, or mapping of contact to these
        One law for all contacts, or the law of each by the contact's name. Of several contacts,
        parameters of laws that are given by contact have its name behind theirs: ``E_A``.
    engine : {"auto", "compiled", "taylor", "erk"}
        ``auto``: compiled code, or CasADi's ``erk`` with a notice where there is no compiler;
        several contacts need one.
    watch : str or sequence of str
        Events to record besides those of the contacts; see `simulate`.

    Raises
    ------
    InputError
        A mechanism in space, a contact without a law, a law for a contact that there is not, or
        laws that do not go together.

    Examples
    --------
    >>> from painleve_sym import law, model
    >>> block = model("block-two-feet")
    >>> simulator = Simulator(block, {"A": law("rigid"), "B": law("hertz")})
    >>> [p.name for p in simulator.own_parameters]
    ['e_energetic_A', 'E_B', 'nu_B', 'R_B', 'n_B', 'l_0_B']
    """

    def __repr__(self) -> str:
        """Return mechanism, laws and engine in one line."""
        return f"Simulator of {self.where}, engine {self.engine}"

    def casadi(self, mode: str) -> ModeEquations:
        """Return the equations of a mode as CasADi functions of states, memory and parameters.

        They are those that `run` integrates, for other integrators, optimal control, derivatives.

        Parameters
        ----------
        mode : str
            One of `automaton.modes`; events and segments of a run name those that it was in.

        Returns
        -------
        ModeEquations
            Field, guards, resets, choices and outputs.

        Raises
        ------
        InputError
            An unknown mode.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> simulator = ps.Simulator("rod", "rigid")
        >>> slip = simulator.casadi("slip_neg")
        >>> slip.guard_labels
        ('slip_stop', 'liftoff', 'singular', 'domain_0', 'domain_1')
        """
        return casadi_equations(self.automaton, mode)

    def lambdify(self, mode: str, modules: str = "numpy") -> ModeEquations:
        """Return the equations of a mode as Python functions that SymPy writes.

        Parameters
        ----------
        mode : str
            As for `casadi`.
        modules : {"numpy", "math", "jax", "mpmath"}
            Library whose functions they call.

        Returns
        -------
        ModeEquations
            With Python functions of three sequences.

        Raises
        ------
        InputError
            An unknown mode or library; several contacts, whose forces solve linear systems.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> simulator = ps.Simulator("rod", "bilinear-hertz")
        >>> flight = simulator.lambdify("flight", "math")
        >>> start = simulator.begin({"theta": 1.0, "y_A": 0.1})
        >>> float(flight.field(start.state, [0.0], start.parameters)[4])
        -9.8
        """
        return lambdified_equations(self.automaton, mode, modules)

    def given(
        self,
        parameters: Mapping[str, Any] | None = None,
        law_parameters: Mapping[str, Any] | None = None,
    ) -> dict[str, Any]:
        """Return parameters of mechanism and laws as one mapping; see `simulate` for names.

        Raises
        ------
        InputError
            Unknown names of parameters of the laws.
        """
        if parameters is None and law_parameters is None:
            return {}
        given = dict(by_name(parameters, f"{self.where}: parameters", "{'mu': 0.5}"))
        if law_parameters is None:
            return given
        own = [p.name for p in self.own_parameters]
        where = f"law {self.label!r}"
        of_laws = by_name(law_parameters, f"{where}: law_parameters", "{'E': 2e11}")
        for name, value in of_laws.items():
            here = f"{name}_law" if f"{name}_law" in own else name
            if here not in own:
                raise InputError(f"{where}: {unknown_name('parameter', name, own)}")
            given[here] = value
        return given

    @spelled_out(RunArguments)
    def run(self, state: StateLike | None = None, **arguments: Unpack[RunArguments]) -> Trajectory:
        """Integrate the motion from t = 0.

        Arguments, result and errors are those of `painleve_sym.simulate`.

        Examples
        --------
        >>> from painleve_sym import Simulator, laws, models
        >>> simulator = Simulator(models.rod(), laws.bilinear_hertz(E=209e9))
        >>> run = simulator.run({"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}, t_end=1e-2)
        >>> [str(event.kind) for event in run.events[:2]]
        ['slip_stop', 'max_compression']
        """
        settings, begins = separated(self.where, RunArguments, arguments)
        origin = begins.pop("start", None)
        changes = begins.pop("phases", None), begins.pop("inputs", None)
        timetable: Timetable | None = None if origin is None else timetable_of(origin)
        pulsed = self.mechanism.outline.pulsed
        if timetable is not None or pulsed or any(c is not None for c in changes):
            if timetable is not None and origin.record.simulator is not self:
                timetable = timetable.since(origin.final_time)
            begin = 0.0 if origin is None else origin.final_time
            timetable = Timetable.of(self, *changes, before=timetable, begin=begin)
            return run_in_pieces(self, timetable, settings, {"state": state, **begins}, origin)
        if origin is None:
            return self.fresh(state, settings, begins)
        return self.rest(origin, settings, {"state": state, **begins})

    @cached_property
    def stepped(self) -> Simulator:
        """The simulator with a parameter in place of each pulse of the formulas."""
        mechanism = self._without_pulses[0]
        if mechanism is self.mechanism:
            return self
        return with_fields(Simulator(mechanism, self.law, self.engine, self.watch), whole=self)

    @cached_property
    def whole(self) -> Simulator:
        """The simulator of which this one is `stepped`."""
        return self

    @property
    def pulses(self) -> Mapping[str, Any]:
        """The pulses of the formulas, by the parameters of `stepped` that have their values."""
        return self._without_pulses[1]

    @cached_property
    def _without_pulses(self) -> tuple[Mechanism, Mapping[str, Any]]:
        if not self.mechanism.outline.pulsed:
            return self.mechanism, {}
        from painleve_sym.mechanics.pulses import without_pulses

        return without_pulses(self.mechanism)

    def fresh(
        self, state: StateLike | None, settings: RunSettings, begins: Mapping[str, Any]
    ) -> Trajectory:
        """Integrate the motion from t = 0 with checked settings."""
        simulator, start = self.moving(self.begin(state, **begins))
        return simulator.follow(start, settings)

    def rest(self, origin: Any, settings: RunSettings, given: Mapping[str, Any]) -> Trajectory:
        """Integrate the motion from the end of another one on with checked settings."""
        origin = check_origin(self.where, origin, given, float(settings.t_end))
        simulator, start = self.after(origin, given)
        return simulator.follow(start, settings)

    def after(
        self, origin: Trajectory, given: Mapping[str, Any], varied: Sequence[str] = ()
    ) -> tuple[Simulator, Start]:
        """Return what runs from the end of a motion, and its start; see `moving`."""
        parameters = same_parameters(self, origin)
        parameters |= self.given(given.get("parameters"), given.get("law_parameters"))
        check_watches(self, origin)
        place = self.at(first_state(self, origin), parameters)
        known = has_states_of(self, origin)
        start = self.prepared(place)[0] if known else self.start(place)
        simulator, start = self.moving(start, varied)
        return simulator, carried(simulator, start, origin)

    def follow(self, start: Start, settings: RunSettings) -> Trajectory:
        """Integrate the motion from a start with checked settings."""
        checked = self.options(start.scale, settings)
        if not checked.until:
            refuse_plastic(self, start.place.parameters)
        if start.time or start.mode >= 0:
            raw = integrated(self, start, options_of_rest(checked, start))
            raw = at_its_time(raw, checked, start.time)
        else:
            raw = integrated(self, start, checked)
        trajectory = self.trajectory(raw, start, checked)
        if raw.stop_reason is StopReason.SINGULAR and self.contact.can_open:
            return with_limit(self.contact, trajectory, start.place.parameters)
        return trajectory

    def moving(self, start: Start, varied: Sequence[str] = ()) -> tuple[Simulator, Start]:
        """Return simulator and start of a run: another simulator where parameters make a slip 0.

        They are not among the varied ones, by which the motion is differentiated.
        """
        parameters = start.place.parameters
        if 0 not in parameters.values() or all(start.state[i] != 0 for i in self._slip_places):
            return self, start
        zeros = (n for n, value in parameters.items() if value == 0 and n not in varied)
        simulator = self.without_slip(start.place.values, zeros)
        if simulator is self:
            return self, start
        own, _ = simulator.prepared(start.place, start.force)
        return simulator, own._replace(materials=start.materials)

    @cached_property
    def _slip_places(self) -> list[int]:
        """Places of the slip velocities among the states."""
        return [self.outline.state_names.index(row.slip) for row in self.contact.rows]

    def without_slip(self, values: Mapping[str, float], zeros: Iterable[str]) -> Simulator:
        """Return the simulator in which slips that zeros of parameters make 0 are 0."""
        mechanism = with_still_contacts(self.mechanism, self._numbers, values, zeros)
        if mechanism is None:
            return self
        known = self._of_still_contacts
        if mechanism.definition not in known:
            known[mechanism.definition] = Simulator(mechanism, self.law, self.engine, self.watch)
        return known[mechanism.definition]

    @cached_property
    def _numbers(self) -> Delassus:
        return Delassus.of(self.mechanism)

    @cached_property
    def _of_still_contacts(self) -> dict[str, Simulator]:
        """Simulators of mechanisms whose parameters make a slip 0; filled when used."""
        return {}

    def at(
        self,
        state: StateLike | None = None,
        parameters: Mapping[str, Value] | None = None,
        law_parameters: Mapping[str, Value] | None = None,
        material: MaterialsLike | None = None,
        close: str | None = None,
    ) -> Place:
        """Return the checked place of a start, with the laws' parameters too; see `simulate`."""
        if law_parameters is not None or material is not None:
            parameters = given = self.given(parameters, law_parameters)
            if material is not None:
                parameters = {**self.values_of_materials(material, given), **given}
        place = self.mechanism.at(state, parameters, declared=self.declared, where=self.where)
        return place if close is None else closed_place(place, close)

    def begin(
        self,
        state: StateLike | None = None,
        *,
        parameters: Mapping[str, Value] | None = None,
        law_parameters: Mapping[str, Value] | None = None,
        material: MaterialsLike | None = None,
        initial_force: Value | None = None,
        close: str | None = None,
    ) -> Start:
        """Return the start of a run from the arguments of `simulate` besides its settings."""
        place = self.at(state, parameters, law_parameters, material, close)
        return self.start(place, initial_force, material)

    def with_laws(
        self,
        place: Place,
        law_parameters: Mapping[str, Value] | None = None,
        material: MaterialsLike | None = None,
    ) -> Place:
        """Return a checked place of the mechanism with the parameters of the laws, checked too."""
        given = self.given({}, law_parameters)
        if material is not None:
            given |= self.values_of_materials(material, {**place.parameters, **given})
        own = ParameterSet(*self.own_parameters).values(self.where, given)
        return replace(place, parameters={**place.parameters, **own})

    def start(
        self,
        place: Place,
        initial_force: Value | None = None,
        material: MaterialsLike | None = None,
    ) -> Start:
        """Return the start of a run; InputError where the laws or the domain do not admit it."""
        force = NO_FORCE if initial_force is None else checked_force(self, initial_force)
        start, admits = self.prepared(place, force)
        if 0.0 in admits:
            refuse(self, start)
        return start if material is None else start._replace(materials=two_materials(material))

    def prepared(self, place: Place, force: float = NO_FORCE) -> tuple[Start, list[float]]:
        """Return the start of a run, unchecked, and `Prepared.admits` of it."""
        p, motion = self._vector_of(place.parameters), np.array([*place.state.values()])
        prepared = self.integrator.prepare(p[None], motion[None], np.array([force]))
        admits: list[float] = prepared.admits[0].tolist()
        return Start(place, prepared.states[0], p, prepared.scales[0], force), admits

    def start_expressions(self, forced: bool) -> dict[Any, Any]:
        """Return the start values that follow from other ones: states to SymPy expressions.

        Where `forced`, the compression is the one that carries the symbol ``initial_force``.
        """
        from sympy import Symbol

        own, rows = set(self.mechanism.motion), self.contact.builder.rows
        known = {
            symbol: expr
            for row in rows
            for symbol, expr in zip(row.symbols, row.expressions, strict=True)
            if symbol not in own
        }
        if not forced:
            return known
        law, force = self.contact_law, Symbol("initial_force", positive=True)
        return known | {rows[0].gap: -((force / law.stiffness) ** (1 / law.exponent))}

    @spelled_out(RunArguments)
    def sensitivities(
        self,
        state: StateLike | None,
        wrt: Sequence[str],
        **arguments: Unpack[RunArguments],
    ) -> SensitiveTrajectory:
        """Integrate the motion together with its first derivatives, through every event.

        Parameters
        ----------
        state : mapping of str to float
        wrt : sequence of str
            Directions: names of coordinates and velocities (their start values), of parameters of
            mechanism and law, and ``initial_force`` where that is given.
        **arguments
            As for `run`.

        Returns
        -------
        SensitiveTrajectory
            A start on the surface is differentiated within the mode that it starts in. A motion
            that continues another one (``start=``) is differentiated by the state at the cut, what
            it remembers there held, and by parameters from there on.

        Raises
        ------
        InputError
            As for `run`; unknown names of directions.
        """
        directions = names_of(wrt, f"{self.where}: wrt", "mu,theta")
        result: SensitiveTrajectory = upper("sensitivities")(self, state, directions, arguments)
        return result

    @cached_property
    def directions(self) -> dict[Any, Any]:
        """`Directions` by their names and by whether a force is given; filled when used."""
        return {}

    @cached_property
    def _last_options(self) -> list[tuple[RunSettings, RunOptions]]:
        """The settings of the last run with their options, which the next one mostly shares."""
        return []

    def options(self, scale: Array, settings: RunSettings) -> RunOptions:
        """Return the options of a run with checked settings; `scale` is that of its start."""
        last = self._last_options[-1:]
        if not last or last[0][0] is not settings:
            last = [(settings, self._shared_options(settings))]
            self._last_options[:] = last
        shared = last[0][1]
        rtol, atol = shared.rtol, settings.atol
        own = rtol * scale if atol is None else self._tolerances(atol, scale)
        return shared.with_tolerances(own)

    def _shared_options(self, settings: RunSettings) -> RunOptions:
        """Return the options of runs with checked settings, but for the absolute tolerances."""
        until = settings.until
        asked = type(until) is not tuple or until
        kinds = names_of(until, f"{self.where}: until", "slip_stop") if asked else ()
        for kind in kinds:
            known: Sequence[str] = self.outline.kinds
            if kind.startswith(BEFORE):
                known = [BEFORE + k for k in known if k not in ENDLESS]
            refuse_unknown("event", kind, known, f"{self.where}: until")
        own: dict[str, Any] = {
            "t_end": float(settings.t_end),
            "rtol": float(settings.rtol),
            "until": kinds,
            "start_events": self.start_events,
        }
        return RunOptions(**settings.arguments(**own))

    def _tolerances(self, atol: Any, scale: Array) -> Array:
        """Return the absolute tolerance of each state, in the shape that the engine reads."""
        try:
            values = np.broadcast_to(np.asarray(atol, np.float64), scale.shape)
        except (TypeError, ValueError):
            values = np.zeros(0)
        if values.shape != scale.shape or not (values >= 0).all():
            raise InputError(
                f"{self.where}: atol: got {received(atol)}, need {len(scale)} numbers >= 0, one "
                "for each state."
            )
        return values

    def trajectory(self, raw: RawRun, start: Start, options: RunOptions) -> Trajectory:
        """Return a run as a trajectory."""
        return Trajectory(
            names=self.names,
            parameters=start.place.parameters,
            rtol=options.rtol,
            record=RunRecord(self, start, raw, options),
            final_time=raw.time,
            final_state=raw.state,
            final_memory=raw.memory,
            stop_reason=raw.stop_reason,
            stop_detail=end_detail(self, raw, options.until),
            counters=raw.counters,
            evaluator=self._evaluator,
            subject=self.mechanism,
        )

    @cached_property
    def _evaluator(self) -> EngineOutputs:
        return EngineOutputs(self.integrator, lambda: self.output_tapes)
