"""A mechanism with its contact laws, ready to run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.evaluate import power
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.contacts.classify import held_faults
from painleve_sym.contacts.contact_numbers import (
    characteristic_length,
    contact_numbers,
    contact_tolerances,
)
from painleve_sym.contacts.inputs import resolve_parameters, resolve_state
from painleve_sym.contacts.model import CONTACT, ContactModel
from painleve_sym.contacts.terms import ContactImpacts
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.factory import make_engine
from painleve_sym.engines.protocol import Engine, RawRun, RunOptions
from painleve_sym.engines.records import EventRecords
from painleve_sym.errors import InputError, StopReason, unknown_name
from painleve_sym.hybrid.signature import Outline, mode_name
from painleve_sym.laws.catalogue import Law
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.laws.rigid import RigidLaw
from painleve_sym.mechanics.declarations import TIME_NAME, Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.simulate.impact_resolver import ImpactResolver
from painleve_sym.simulate.rigid import complete_motion, with_alternatives, with_impulses
from painleve_sym.simulate.scales import compliant_scales, rigid_scales
from painleve_sym.simulate.trajectory import EventRecord, Trajectory

if TYPE_CHECKING:
    from painleve_sym.hybrid.automaton import HybridAutomaton
    from painleve_sym.simulate.sensitivity.result import SensitiveTrajectory

DEFAULT_RTOL = 1e-11
"""The reference impacts then hold eight digits through all events, energy closes to 1e-9."""
_JAM = (
    "the impact of the rigid contacts has no end: their friction carries any impulse, or leaves "
    "none possible; use one contact at a time, or a compliant law"
)
_GUIDE_MEETS = (
    "the slip meets A = 0, where the force of the guide grows without bound and rigid theory ends; "
    "end earlier, or start elsewhere"
)


@dataclass(frozen=True)
class Simulator:
    """A mechanism with its contact laws, ready to run; build once, run often.

    **One compliant contact** follows the branches of its law. **One rigid contact**: in the
    inconsistent state the impact without collision happens. In the indeterminate state the policy
    chooses, and the event of that choice lists all solutions as `alternatives`. Bounces that
    accumulate end in contact at their limit time (event ``settle``). A slip that runs into
    A = B = 0, where the contact force grows without bound, ends the run with
    StopReason.DYNAMIC_JAM, any other that meets A = 0 with SINGULAR; `Trajectory.limit` holds time
    and state it would arrive at. A contact at rest that can also leave in growing bounces lists
    ``reverse_chatter`` among its `alternatives`, and `Trajectory.reverse_chatter` tells of bounces
    that do grow. A bilateral contact keeps its gap 0; see `BilateralContact`.

    **Several contacts**, of any kinds: at an event every combination of what the closed contacts
    may do is held against their contact problem, and where several motions are possible the policy
    of the rigid law chooses; the event ``contact`` lists all. Rigid contacts that touch down, or
    for which no forces are possible, have an impact, which follows the path of
    `solve_simultaneous_impact`; the event ``impact`` has the impulses.

    Parameters
    ----------
    mechanism : Mechanism
    law : ContactLaw or RigidLaw, or mapping of str to these
        One law for all contacts, or the law of each by the contact's name. Of several contacts,
        parameters of laws that are given by contact have its name behind theirs: ``E_A``.
    engine : {"auto", "compiled", "taylor", "erk"}
        ``auto``: compiled code, or CasADi's ``erk`` with a notice where there is no compiler.

    Raises
    ------
    InputError
        A contact without a law, a law for a contact that there is not, or laws that do not go
        together.

    Examples
    --------
    >>> from painleve_sym import law, model
    >>> block = model("block-two-feet")
    >>> simulator = Simulator(block, {"A": law("rigid"), "B": law("hertz")})
    >>> [p.name for p in simulator.own_parameters]
    ['e_energetic', 'E_B', 'nu_B', 'R_B', 'n_B']
    """

    mechanism: Mechanism
    law: Law | Mapping[str, Law] = field(hash=False)
    engine: str = "auto"

    def __post_init__(self) -> None:
        _ = self.contact  # refuses laws that do not fit the contacts, or each other

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """One law for all contacts, or one for each in the mechanism's order."""
        if not isinstance(self.law, Mapping):
            return (self.law,)
        names = [c.name for c in self.mechanism.outline.contacts]
        for name in self.law:
            if name not in names:
                message = unknown_name("contact", name, names)
                raise InputError(f"mechanism {self.mechanism.name!r}: law: {message}")
        for name in names:
            if name not in self.law:
                raise InputError(
                    f"mechanism {self.mechanism.name!r}: law: contact {name!r} has none. "
                    "Fix: give each contact its law."
                )
        return tuple(self.law[name] for name in names)

    @cached_property
    def contact(self) -> ContactModel:
        """The contact or contacts, joined with their laws."""
        return ContactModel(self.mechanism, self.laws)

    @property
    def automaton(self) -> HybridAutomaton:
        """The automaton that is run."""
        return self.contact.automaton

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """Parameters besides the mechanism's: those of the laws."""
        return self.contact.parameters

    @property
    def label(self) -> str:
        """Names of the laws, for messages and results."""
        return ", ".join(law.name for law in self.laws)

    @property
    def choices(self) -> dict[str, str]:
        """Named choices of the laws; a guide alone has no restitution."""
        choices = {k: v for law in self.laws for k, v in law.choices.items()}
        if all(c.bilateral for c in self.mechanism.outline.contacts):
            choices.pop("restitution", None)
        return choices

    @property
    def contact_law(self) -> ContactLaw:
        """The compliant law of the only contact.

        Raises
        ------
        InputError
            A rigid contact, or several contacts.
        """
        law, *more = self.contact.own_laws
        if more or not isinstance(law, ContactLaw):
            raise InputError(
                f"{self.where}: need one contact with a compliant law. Fix: take such a law, and "
                "one contact of several (Mechanism.only)."
            )
        return law

    def is_compliant(self, i: int) -> bool:
        """Whether a contact may start compressed."""
        return self.contact.own_laws[i].is_compliant

    @cached_property
    def rigid(self) -> tuple[int, ...]:
        """Indices of the contacts that do not yield: rigid ones and guides."""
        return tuple(
            i
            for i, contact in enumerate(self.mechanism.outline.contacts)
            if contact.bilateral or not self.is_compliant(i)
        )

    @property
    def start_events(self) -> bool:
        """Whether what a start makes happen at once are events: where a contact is rigid."""
        return bool(self.rigid)

    @cached_property
    def impacts(self) -> ContactImpacts:
        """Impacts of the rigid contacts of several."""
        return ContactImpacts(
            self.mechanism, self.outline.state_names, self.contact.rows, self.rigid
        )

    # ---- the loading curves of compliant contacts ----

    @property
    def loading_curves(self) -> list[Any]:
        """Stiffness and exponent of each contact's loading curve, 0 of a rigid one, in turn."""
        curves = [
            (law.stiffness, law.exponent) if isinstance(law, ContactLaw) else (0, 0)
            for law in self.contact.own_laws
        ]
        return [entry for curve in curves for entry in curve]

    def loading_curve(self, values: Mapping[str, Array], i: int = 0) -> tuple[Array, Array]:
        """Return K and n of a compliant contact's loading curve K δⁿ, each of shape (n,)."""
        curve = self._loading.at(values)
        return curve[f"stiffness_{i}"], curve[f"exponent_{i}"]

    @cached_property
    def _loading(self) -> Quantities:
        laws = self.contact.own_laws

        def derive() -> tuple[dict[str, Any], tuple[Any, ...]]:
            curves = {
                f"{name}_{i}": getattr(law, name)
                for i, law in enumerate(laws)
                for name in ("stiffness", "exponent")
                if isinstance(law, ContactLaw)
            }
            return curves, (*self.automaton.parameters, *self.automaton.definitions)

        names = self.outline.constant_names
        return quantities("loading curves", self.contact.definition, names, derive)

    def compression_of_force(self, force: float, parameters: Mapping[str, float]) -> float:
        """Return δ₀ > 0 with F_n(δ₀) = `force` on the loading curve at rest; m.

        The initial surface energy of the paper, (10), is given this way.
        """
        if not (np.isfinite(force) and force >= 0):
            raise InputError(f"{self.where}: initial force: got {force!r}, need >= 0 and finite.")
        k, n = self._curve(parameters)
        return float((force / k) ** (1 / n))

    def surface_energy(self, depth: float, parameters: Mapping[str, float]) -> float:
        """Return the initial surface energy (10) of a compression δ₀ ≥ 0, K δ₀^(n+1)/(n+1); J.

        The whole work of the loading curve. Of it an elasto-plastic law counts e² as stored.
        """
        if not (np.isfinite(depth) and depth >= 0):
            raise InputError(f"{self.where}: compression: got {depth!r}, need >= 0 and finite.")
        k, n = self._curve(parameters)
        return float(k * depth ** (n + 1) / (n + 1))

    def _curve(self, parameters: Mapping[str, float]) -> tuple[float, float]:
        _ = self.contact_law  # refuses what has no loading curve
        values = {s: np.array([v]) for s, v in self.constants(parameters).items()}
        k, n = self.loading_curve(values)
        return float(k[0]), float(n[0])

    # ---- one motion ----

    def run(
        self,
        state: Mapping[str, float],
        *,
        parameters: Mapping[str, float] | None = None,
        initial_force: float | None = None,
        **options: Any,
    ) -> Trajectory:
        """Integrate the motion from t = 0.

        Parameters
        ----------
        state : mapping of str to float
            Coordinates and velocities; absent ones are 0. A negative gap is a compression, which
            only a compliant contact may have.
        parameters : mapping of str to float
            Of mechanism and laws; absent ones have their defaults.
        initial_force : float
            Sets the initial compression so that the only, compliant contact carries this force; N.
            Where the gap is not a coordinate, the coordinates stay and the surface counts as raised
            by it.
        t_end : float
            s, > 0.
        until : str or tuple of str
            Kinds of events that end the run.
        rtol : float
        atol : ndarray, shape (nx,)
            Per state; by default scaled to the contact (see `tolerances`).
        record : {"dense", "events", "end"}
        **options
            Those from t_end on, and first_step, max_step, max_steps, max_events (`RunOptions`).

        Returns
        -------
        Trajectory
            Also when it stopped early: `stop_reason` says why. Of several contacts, forces and gaps
            of each are the outputs ``normal_force_<contact>``, …; where the bodies' rigidity leaves
            forces open, contacts share them in proportion to what their friction carries.

        Raises
        ------
        InputError
            Unknown names, numbers out of range, a start outside the domain or inside the ground.
        """
        vector, values = self.start(state, parameters)
        vector = self.checked_start(vector, values, initial_force)
        checked = self.options(vector, values, **options)
        p = self._vector_of(values)
        contact = self.contact
        if not (contact.several and self.rigid):
            raw = self.integrator.run(vector, p, checked)
            return complete_motion(self, self.trajectory(raw, values, checked.rtol), values)
        compiled = isinstance(self.integrator, CompiledEngine)
        target = [m.name for m in self.outline.modes].index(CONTACT)
        scale = checked.atol / checked.rtol
        resolver = ImpactResolver(self.impacts, contact.rigid_law, target, values, scale)
        raw = self.integrator.run(vector, p, checked, resolve=None if compiled else resolver)
        trajectory = self.trajectory(raw, values, checked.rtol)
        return with_impulses(trajectory, raw, 2 * len(contact.rows), resolver.impulses)

    def checked_start(self, vector: Array, values: Mapping[str, float], force: Any) -> Array:
        """Return the start vector, compressed so that it carries `force` where that is given.

        Raises
        ------
        InputError
            A force that no contact can store, a rigid contact inside the ground, or a guide off its
            place.
        """
        if force is not None:
            fault = self.initial_force_fault()
            if fault:
                raise InputError(f"{self.where}: {fault}")
            self.compression_of_force(force, values)  # checks the force
            constants = self.integrator.constants(self._vector_of(values))
            compressed: Array = self.with_forces(vector[None], np.array([force]), constants[None])
            vector = compressed[0]
        place, several = self.outline.state_names.index, self.contact.several
        for i in self.rigid:
            row, contact = self.contact.rows[i], self.mechanism.outline.contacts[i]
            gap, rate = float(vector[place(row.gap)]), float(vector[place(row.gap_rate)])
            name = f"contact {contact.name!r}"
            if contact.bilateral:
                near, slow = self.closed_within(vector, values)[i]
                subject = f"the bilateral {name}" if several else "a bilateral contact"
                for fault in held_faults(subject, (gap, near), (rate, slow)):
                    raise InputError(f"{self.where}: {fault}")
            elif gap < 0:
                subject = f"{name} starts" if several else "the start is"
                raise InputError(
                    f"{self.where}: {subject} inside the ground, gap = {gap:g} m, and a rigid "
                    "contact has no compression. Fix: start with gap >= 0, or give a compliant law."
                )
        return vector

    def initial_force_fault(self) -> str:
        """Return why no initial force can be given, a sentence; empty where it can."""
        if len(self.contact.rows) > 1:
            return (
                "initial_force: several contacts share no force. Fix: give the compression of each "
                "by the state."
            )
        if not self.is_compliant(0):
            return (
                "initial_force: a rigid contact has no compression. Fix: leave it out, or give a "
                "compliant law."
            )
        return ""

    def with_forces(self, vectors: Array, forces: Array, constants: Array) -> Array:
        """Return states (n, nx) compressed so that the only contact carries the forces (n,); N."""
        index = self.outline.state_names.index(self.contact.rows[0].gap)
        gaps = vectors[:, index]
        if gaps.any():
            raise InputError(
                f"{self.where}: initial_force: got a start with gap "
                f"{float(gaps[gaps != 0][0])!r}, need 0. Fix: give the force or the compression, "
                "not both."
            )
        k, n = self.loading_curve(dict(zip(self.outline.constant_names, constants.T, strict=True)))
        compressed = vectors.copy()
        compressed[:, index] = -power(forces / k, 1 / n)
        return compressed

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

    # ---- numbers ----

    @cached_property
    def integrator(self) -> Engine:
        """The engine, compiled or taken from the cache on first use."""
        return make_engine(self.contact, self.engine)

    @property
    def outline(self) -> Outline:
        """Names and structure of the automaton, known without deriving it."""
        return self.integrator.outline

    @property
    def where(self) -> str:
        """What messages name as the place of a fault."""
        return f"{self.mechanism.name!r} with law {self.label!r}"

    def parameters(self, given: Mapping[str, float] | None = None) -> dict[str, float]:
        """Return all parameters of mechanism and law with `given` put in, checked."""
        declared = (*self.mechanism.parameters, *self.own_parameters)
        return resolve_parameters(self.where, declared, given or {})

    def constants(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return the values of all parameters and definitions by name."""
        c = self.integrator.constants(self._vector_of(parameters))
        return dict(zip(self.outline.constant_names, map(float, c), strict=True))

    def _vector_of(self, parameters: Mapping[str, float]) -> Array:
        return np.array([parameters[name] for name in self.outline.parameter_names])

    def initial_state(self, state: Mapping[str, float], parameters: Mapping[str, float]) -> Array:
        """Return the automaton's state vector for coordinates and velocities by name."""
        arrays = {name: np.array([v]) for name, v in {**state, **parameters}.items()}
        vector: Array = self.initial_states(arrays, self.contact_values(arrays))[0]
        return vector

    @cached_property
    def _contact_numbers(self) -> tuple[Quantities, ...]:
        return tuple(contact_numbers(self.mechanism, i) for i in range(len(self.contact.rows)))

    def contact_values(self, values: Mapping[str, Array]) -> list[dict[str, Array]]:
        """Return `contact_numbers` of each contact at n points, arrays of shape (n,).

        Parameters
        ----------
        values : mapping of str to ndarray, shape (n,)
            Of coordinates, velocities and parameters.
        """
        return [numbers.at(values) for numbers in self._contact_numbers]

    def initial_states(
        self, values: Mapping[str, Array], numbers: Sequence[Mapping[str, Array]]
    ) -> Array:
        """Return state vectors, shape (n, nx), for coordinates, velocities and parameters.

        Parameters
        ----------
        values : mapping of str to ndarray, shape (n,)
        numbers : sequence of dict
            `contact_values` there.
        """
        extra: dict[str, Array] = {}
        for row, own in zip(self.contact.rows, numbers, strict=True):
            derived = [own[name] for name in ("gap", "gap_rate", "slip_velocity")]
            extra |= dict(zip(row, derived, strict=True))
            for s, tolerance in zip((row.gap, row.gap_rate), contact_tolerances(own), strict=True):
                # Computed from q these cancel: a touching start must not become a tiny fall.
                extra[s] = np.where(np.abs(extra[s]) <= tolerance, 0.0, extra[s])
        zero = np.zeros(len(next(iter(values.values()))))
        columns = [values.get(s, extra.get(s, zero)) for s in self.outline.state_names]
        vectors: Array = np.array(columns).T.copy()
        return vectors

    def sensitivities(
        self, state: Mapping[str, float], wrt: Sequence[str], **options: Any
    ) -> SensitiveTrajectory:
        """Integrate the motion together with its first derivatives, through every event.

        Parameters
        ----------
        state : mapping of str to float
        wrt : sequence of str
            Directions: names of coordinates and velocities (their start values), of parameters of
            mechanism and law, and ``initial_force`` where that is given.
        **options
            Those of `run`.

        Returns
        -------
        SensitiveTrajectory
            A start on the surface is differentiated within the mode that it starts in.

        Raises
        ------
        InputError
            As for `run`; unknown names of directions.
        """
        from painleve_sym.simulate.sensitivity.variational import differentiated

        return differentiated(self, state, tuple(wrt), **options)

    @cached_property
    def variational_engines(self) -> dict[Any, Any]:
        """Engines of state and derivatives, by direction; filled when used."""
        return {}

    def options(
        self,
        vector: Array,
        parameters: Mapping[str, float],
        *,
        t_end: float,
        until: str | tuple[str, ...] = (),
        rtol: float = DEFAULT_RTOL,
        atol: Array | None = None,
        record: str = "dense",
        **limits: Any,
    ) -> RunOptions:
        """Return checked options of a run from the state `vector`; see `run`."""
        if not (np.isfinite(t_end) and t_end > 0):
            raise InputError(f"{self.where}: t_end: got {t_end!r}, need a finite number > 0.")
        kinds = (until,) if isinstance(until, str) else tuple(until)
        for kind in kinds:
            if kind not in self.outline.kinds:
                message = unknown_name("event", kind, self.outline.kinds)
                raise InputError(f"{self.where}: until: {message}")
        scale = self.tolerances(vector, parameters) if atol is None else np.asarray(atol) / rtol
        limits = {"start_events": self.start_events, **limits}
        return RunOptions(t_end, rtol, rtol * scale, kinds, record, **limits)

    def start(
        self, state: Mapping[str, float], parameters: Mapping[str, float] | None
    ) -> tuple[Array, dict[str, float]]:
        """Return the checked state vector and all parameters."""
        values = self.parameters(parameters)
        for name, value in self.constants(values).items():
            if not np.isfinite(value):
                raise InputError(
                    f"{self.where}: {name} comes out as {value!r}, need a finite number. "
                    "Fix: check the parameters it is made of (stiffness, curvatures)."
                )
        return self.initial_state(resolve_state(self.mechanism, state, values), values), values

    def tolerances(self, vector: Array, parameters: Mapping[str, float]) -> Array:
        """Return the scale of each state below which only its absolute error counts, shape (nx,).

        Gap and its rate have the scales of the contact; other velocities that of the kinetic
        energy plus the energy of the contact; coordinates in m the `characteristic_length`, angles
        1, and the time that length over the speed of the energy. Dissipated energies are left out
        (inf).
        """
        constants = self.integrator.constants(self._vector_of(parameters))
        vectors, constants = np.asarray(vector)[None], constants[None]
        numbers = self.contact_values(self.at_states(vectors, constants))
        scale: Array = self.all_tolerances(vectors, constants, numbers)[0]
        return scale

    def closed_within(
        self, vector: Array, parameters: Mapping[str, float]
    ) -> list[tuple[float, float]]:
        """Return gap and gap rate up to which each contact is closed (`contact_tolerances`)."""
        constants = self.integrator.constants(self._vector_of(parameters))
        numbers = self.contact_values(self.at_states(np.asarray(vector)[None], constants[None]))
        pairs = [contact_tolerances(own) for own in numbers]
        return [(float(near.item()), float(slow.item())) for near, slow in pairs]

    def at_states(self, vectors: Array, constants: Array) -> dict[str, Array]:
        """Return the values of all names, shape (n,), for n states and constants (n, nc)."""
        states = dict(zip(self.outline.state_names, vectors.T, strict=True))
        return states | dict(zip(self.outline.constant_names, constants.T, strict=True))

    def all_tolerances(
        self, vectors: Array, constants: Array, numbers: Sequence[Mapping[str, Array]]
    ) -> Array:
        """Return what `tolerances` returns for n states, constants (n, nc) and `contact_values`."""
        outline = self.mechanism.outline
        named, rows = self.at_states(vectors, constants), self.contact.rows
        scales = self.all_scales(named, numbers)
        energy = np.maximum.reduce([own[2] for own in scales])
        length, ones = characteristic_length(numbers[0]), np.ones(len(vectors))
        masses = [numbers[0][f"mass_{k}"] for k in range(len(outline.coordinates))]
        scale: dict[str, Array] = {
            c.name: length if c.unit == "m" else ones for c in outline.coordinates
        }
        scale[TIME_NAME] = length / np.sqrt(2 * energy * numbers[0]["W_nn"])
        velocities = zip(outline.velocity_names, masses, strict=True)
        scale |= {name: np.sqrt(2 * energy / m) for name, m in velocities}
        for row, own, (delta, rate, _) in zip(rows, numbers, scales, strict=True):
            slip = np.sqrt(2 * energy * own["W_tt"])
            scale[row.slip] = np.where(slip == 0, np.sqrt(2 * energy * own["W_nn"]), slip)
            scale |= {row.gap: delta, row.gap_rate: rate}
        scale |= dict.fromkeys(self.outline.uncontrolled_names, np.full(len(vectors), np.inf))
        tolerances: Array = np.array([scale[s] for s in self.outline.state_names]).T.copy()
        return tolerances

    def contact_scales(
        self, i: int, values: Mapping[str, Array], numbers: Mapping[str, Array]
    ) -> tuple[Array, ...]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a contact.

        Parameters
        ----------
        i : int
            Which of the contacts.
        values : mapping of str to ndarray, shape (n,)
            States, parameters and definitions.
        numbers : mapping of str to ndarray, shape (n,)
            What `contact_numbers` of the contact gives at them.
        """
        if not self.is_compliant(i):
            return rigid_scales(numbers)
        gap = values[self.contact.rows[i].gap]
        return compliant_scales(numbers, gap, *self.loading_curve(values, i))

    def all_scales(
        self, values: Mapping[str, Array], numbers: Sequence[Mapping[str, Array]]
    ) -> list[tuple[Array, ...]]:
        """Return `contact_scales` of every contact; several all have the largest energy of any.

        One of several that hardly anything presses yet, such as a wall, is hit by what moves or
        presses the others: its free acceleration counts as a hundredth of theirs at least.
        """
        if len(numbers) == 1:
            return [self.contact_scales(0, values, numbers[0])]
        least = 0.01 * np.max([np.abs(own["b_n"]) for own in numbers], axis=0)
        pressed = [{**own, "b_n": np.maximum(np.abs(own["b_n"]), least)} for own in numbers]
        energy = np.zeros(1)
        for i, (row, own) in enumerate(zip(self.contact.rows, pressed, strict=True)):
            idle = (own["kinetic_energy"] <= 0) & (own["b_n"] == 0)
            *_, gained = self.contact_scales(i, values, own)
            energy = np.maximum(energy, np.where(idle & (values[row.gap] >= 0), 0.0, gained))
        energy = np.where(energy > 0, energy, 1.0)
        shared = [{**own, "kinetic_energy": energy} for own in pressed]
        return [(*self.contact_scales(i, values, own)[:2], energy) for i, own in enumerate(shared)]

    def trajectory(self, raw: RawRun, values: dict[str, float], rtol: float) -> Trajectory:
        """Return the raw run as a trajectory."""
        automaton, steps = self.outline, raw.step_records
        c = self.integrator.constants(self._vector_of(values))
        memory = np.vstack([steps.memory, raw.memory])
        modes = np.append(steps.mode, raw.mode)
        names, modes = self._named(modes, memory)
        return Trajectory(
            mechanism=self.mechanism.name,
            law=self.label,
            choices=self.choices,
            parameters=values,
            state_names=automaton.state_names,
            memory_names=automaton.memory_names,
            mode_names=names,
            output_names=automaton.output_names,
            step_time=steps.time,
            step_length=steps.length,
            step_mode=modes[:-1],
            step_memory=steps.memory,
            step_rows=steps.polynomial,
            step_bend=steps.bend,
            events=tuple(
                with_alternatives(self, e, values) for e in self._events(raw.event_records, c)
            ),
            final_time=raw.time,
            final_state=raw.state,
            final_memory=raw.memory,
            final_mode=int(modes[-1]),
            stop_reason=raw.stop_reason,
            stop_detail=self._detail(raw),
            counters=raw.counters,
            engine=self.integrator.name,
            rtol=rtol,
            constants=c,
            evaluator=self.integrator,
        )

    def _named(self, modes: Array, memory: Array) -> tuple[tuple[str, ...], Array]:
        """Return names of modes, and the index of each of n modes among them."""
        automaton = self.outline
        if not automaton.parts:
            return tuple(m.name for m in automaton.modes), modes
        every = [mode_name(automaton, int(m), z) for m, z in zip(modes, memory, strict=True)]
        names = tuple(dict.fromkeys(every))
        return names, np.array([names.index(name) for name in every])

    def _events(self, rows: EventRecords, constants: Array) -> tuple[EventRecord, ...]:
        automaton = self.outline
        names = automaton.state_names
        outputs = self.integrator.outputs(
            rows.mode_before, rows.state_before, rows.memory_before, constants
        )
        at = {name: outputs[:, i] for i, name in enumerate(automaton.output_names)}
        own = [c.name for c in self.mechanism.outline.contacts]
        records = []
        for i, after in enumerate(rows.state_after.tolist()):
            place = int(rows.contact[i])
            contact = automaton.contacts[place] if place >= 0 else ""
            end = f"_{contact or own[0]}" if len(own) > 1 else ""
            # A decision for several contacts at once has no force of its own.
            decided = place < 0 and rows.transition[i] < 0
            carried = ("normal_force", "tangential_force", "gap")
            force, friction, gap = (0.0 if decided else float(at[f"{n}{end}"][i]) for n in carried)
            records.append(
                EventRecord(
                    time=float(rows.time[i]),
                    kind=automaton.kinds[rows.kind[i]],
                    mode_before=mode_name(
                        automaton, int(rows.mode_before[i]), rows.memory_before[i]
                    ),
                    mode_after=mode_name(automaton, int(rows.mode_after[i]), rows.memory_after[i]),
                    state=dict(zip(names, after, strict=True)),
                    normal_force=force,
                    tangential_force=friction,
                    compression=-gap,
                    contact=contact if len(own) > 1 else own[0],
                )
            )
        return tuple(records)

    def _detail(self, raw: RawRun) -> str:
        if raw.stop_reason is StopReason.LEFT_DOMAIN:
            mode = self.outline.modes[raw.mode]
            bound = mode.transitions[raw.stop_transition].bound
            return self.mechanism.outline.domain[bound].meaning if bound is not None else ""
        guide = all(c.bilateral for c in self.mechanism.outline.contacts)
        if guide and raw.stop_reason is StopReason.SINGULAR:
            return _GUIDE_MEETS
        if len(self.contact.rows) > 1 and raw.stop_reason is StopReason.JAM:
            return _JAM
        ordinary = (StopReason.T_END, StopReason.UNTIL)
        return "" if raw.stop_reason in ordinary else raw.stop_reason.advice


def simulate_softened(
    mechanism: Mechanism,
    law: Law | Mapping[str, Law],
    state: Mapping[str, float],
    *,
    engine: str = "auto",
    **options: Any,
) -> Trajectory:
    """Integrate a motion; see `Simulator.run` for the options."""
    return Simulator(mechanism, law, engine).run(state, **options)


def simulate_rigid(
    mechanism: Mechanism,
    state: Mapping[str, float],
    *,
    restitution: str = "energetic",
    policy: str = "liftoff",
    engine: str = "auto",
    **options: Any,
) -> Trajectory:
    """Integrate a motion with rigid contacts; see `Simulator.run` for the options."""
    return Simulator(mechanism, RigidLaw(restitution, policy), engine).run(state, **options)
