"""A scenario: one case to classify, simulate or jump, as data that a TOML file can hold."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from painleve_sym.at.cases import classify_at
from painleve_sym.at.classification import Classification
from painleve_sym.at.closing import closing_hint
from painleve_sym.at.delassus import Delassus
from painleve_sym.at.inputs import border_notices, inside, place_of
from painleve_sym.at.jump import JumpResult, jump_at
from painleve_sym.at.tangential import TangentialImpact, tangential_impact_at
from painleve_sym.automata.watch import read_watch, watch_texts
from painleve_sym.checks import number, whole_number
from painleve_sym.choices import EngineName, ImpactFriction, Restitution, chosen
from painleve_sym.codegen.named_mechanisms import is_robot_file, model
from painleve_sym.engines.protocol import BEFORE, RunSettings
from painleve_sym.errors import EventKind, InputError, refuse_unknown, unknown_name
from painleve_sym.files import CsvFormat, parse_toml, read_text
from painleve_sym.laws.catalogue import LAWS, Law, LawsByContact, all_choices, law
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.laws.friction import FRICTION_NOTICES, friction_notice
from painleve_sym.laws.restitution import RestitutionLaw, restitution_law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.declarations import Parameter, ParameterSet, with_fields
from painleve_sym.mechanics.materials import material_values, two_materials
from painleve_sym.mechanics.mechanism import Mechanism, Place
from painleve_sym.mechanics.models import NAMED
from painleve_sym.mechanics.toml.faults import Faults
from painleve_sym.mechanics.toml.lines import TomlLines, toml_lines
from painleve_sym.motion.rigidity import body_periods, rigidity_notices
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.timetable import checked_phases
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.study.settings import SETTINGS, CaseSettings, Setting

if TYPE_CHECKING:
    from painleve_sym.motion.finite_stiffness import CorrectedJump

MAX_SAMPLES = 1_000_000
MAX_FILE = 1_000_000
"""Size limit of a scenario file in bytes; guards against special files."""
MAX_COUNT = 1_000_000_000
"""Of steps and events: what still fits into memory and into the engine's integers."""


@dataclass(frozen=True)
class Scenario(CaseSettings):
    """One case: a mechanism, a state, and the settings of a question.

    Attributes are those of `simulate`, by the names that a file has; None stands for its defaults,
    and for no state, law or material. `model` names the mechanism, `contact` the only one of
    several contacts to consider. Where `model` is the file of a robot, `contact` is the frame of
    the contact in question, with those of others after it, and `robot` holds the arguments of
    `robot` and `Robot.contact` that say where it is. A state that is not given is the mechanism's
    start. `contact_velocity` is that of the only contact, for which the velocities of the state are
    changed (see `moving_place`). `law_choices` are named choices of the law, such as ``reload``.
    `samples` is the number of evenly spaced times to report, at least 2. `restitution` and `rule`
    are those of the jump. `where` is what error messages call this scenario, such as the name of
    its file.
    """

    where: str = "scenario"

    # ---- from data ----

    @classmethod
    def read(cls, path: str | Path) -> Scenario:
        """Return the scenario a TOML file holds; nothing in the file is executed.

        InputError where it is not readable, not TOML, or has unknown keys or names, or entries of a
        wrong type or out of range: all of them, each with its line.
        """
        # A file that is not there may be of a mechanism, too.
        text = read_text(path, f"mechanism or scenario file {path}", MAX_FILE)
        where = f"scenario file {path}"
        return cls.from_data(parse_toml(text, where), str(path), toml_lines(text))

    @classmethod
    def from_data(
        cls, data: Mapping[str, Any], where: str = "scenario", lines: TomlLines | None = None
    ) -> Scenario:
        """Return the scenario that plain data describes (see `read`); `lines` are those of a file.

        Numbers with a unit may be given as texts; they are converted to SI units.
        """
        faults = Faults(where, lines)
        scenario = cls.described(faults, data)
        faults.raise_if_faulty()
        return scenario

    @classmethod
    def described(
        cls,
        faults: Faults,
        data: Mapping[str, Any],
        others: Sequence[str] = (),
        mechanism: Callable[[str], Mechanism] | None = None,
    ) -> Scenario:
        """Return the scenario that data describe; their faults are recorded.

        `others` are keys that the file may have besides. `mechanism` makes that of a name.
        """
        values: dict[str, Any] = {}
        for key, value in data.items():
            if key not in _READERS:
                faults.fault((key,), unknown_name("key", key, (*_READERS, *others)))
                continue
            with faults.at(key):
                values |= _READERS[key](faults, key, value)
        if "model" not in data:
            faults.fault((), 'no model. Fix: add a line such as model = "rod".')
        whole = None
        if "model" in values:
            with faults.at("robot" if values.get("robot") else "model"):
                whole = _whole(values, mechanism or model)
        if whole is not None:
            _read_names(faults, whole, values)
        scenario = cls(**{"model": "", **values}, where=faults.where)
        if whole is not None and (scenario.contact is None or is_robot_file(scenario.model)):
            return with_fields(scenario, _mechanism=whole)
        return scenario

    def updated(self, given: Mapping[str, Any]) -> Scenario:
        """Return a copy with the entries of `given`; mappings are merged entry by entry.

        Another law drops the parameters and choices of the one it replaces.
        """
        old = self
        if given.get("law", self.law) != self.law:
            old = self._with(law_parameters={}, law_choices={})
        merged = dict(given)
        for name in (
            "state",
            "parameters",
            "law_parameters",
            "law_choices",
            "robot",
            "csv",
            "inputs",
        ):
            if name in given:
                merged[name] = {**(getattr(old, name) or {}), **given[name]}
        return old._with(**merged)

    def _with(self, **fields: Any) -> Scenario:
        """Return a copy with other fields, and with the mechanism where it is the same."""
        copy = dataclasses.replace(self, **fields)
        same = all(getattr(copy, n) == getattr(self, n) for n in ("model", "contact", "robot"))
        known = same and "_mechanism" in vars(self)
        return with_fields(copy, _mechanism=self._mechanism) if known else copy

    @property
    def named_parameters(self) -> set[str]:
        """Parameters of a named mechanism; none of a file, which is read later."""
        named = self.model.partition(":")[0] in NAMED
        return {p.name for p in model(self.model).outline.parameters} if named else set()

    def with_owned_parameters(self) -> Scenario:
        """Return it; InputError where a parameter of the law is given to a named mechanism."""
        own = self.named_parameters
        of_law = self.contact_law().parameters if own and self.law is not None else None
        for name in self.parameters:
            if own and name not in own and (fault := misplaced(name, of_law)):
                raise InputError(fault)
        return self

    def from_material(self, varied: Collection[str] = ()) -> Scenario:
        """Return a copy with the parameters that `material` provides; given ones keep their values.

        `varied` are further parameters to leave alone, such as the axes of a sweep. InputError for
        an unknown material, a property that it lacks, or where nothing depends on a material.
        """
        if self.material is None:
            return self
        pair, mechanism = two_materials(self.material), self.mechanism()
        declared = mechanism.outline.parameters
        of_law = self.contact_law().parameters if self.law is not None else ()
        compliant = self.law is not None and not isinstance(self.contact_law(), RigidLaw)
        has_bars = compliant and any(p.of_material for p in mechanism.outline.periods)
        if not (has_bars or any(p.material for p in (*declared, *of_law))):
            raise InputError(
                f"{self.where}: material {self.material}: nothing here depends on a material. "
                "Fix: leave it out, or name a compliant law such as --law bilinear-hertz."
            )
        own, given = self.parameters, self.law_parameters
        where, law_name = f"mechanism {mechanism.name!r}", f"law {self.law!r}"
        axes = dict.fromkeys(varied)
        provided = material_values(where, pair, declared, {**axes, **own})
        provided_to_law = material_values(law_name, pair, of_law, {**axes, **given})
        return self._with(
            parameters={**provided, **own}, law_parameters={**provided_to_law, **given}
        )

    # ---- parts ----

    def mechanism(self) -> Mechanism:
        """Return the mechanism, built once; InputError suggests the nearest name."""
        return self._mechanism

    @cached_property
    def _mechanism(self) -> Mechanism:
        if self.robot or is_robot_file(self.model):
            return _of_robot(self.model, self.contact, self.robot, self.where)
        whole = model(self.model)
        return whole if self.contact is None else whole.only(self.contact)

    def contact_law(self) -> Law | LawsByContact:
        """Return the contact law with its choices; InputError where none is named."""
        if self.law is None:
            raise InputError(
                f"{self.where}: no contact law, and a motion needs one. "
                "Fix: give --law, such as bilinear-hertz, or [law] in a file; `painleve laws` "
                "lists them."
            )
        return law(self.law, **self.law_choices)

    @cached_property
    def place(self) -> Place:
        """The state with the mechanism's parameters, checked, with the contact closed by `close`.

        InputError where there is no state and no start, or the contact cannot be closed.
        """
        return self._place()

    def _place(self, *laws: Parameter, **of_laws: float) -> Place:
        """Return the place with parameters of laws, where they are needed."""
        mechanism = self.mechanism()
        if self.state is None and not mechanism.start:
            raise InputError(
                f"{self.where}: no state, and the mechanism has no start. Fix: give --state, or "
                "[state] in a file; what is not given is 0."
            )
        declared = ParameterSet(*mechanism.outline.parameters, *laws)
        given = {**self.parameters, **of_laws}
        solved = self.close, self.contact_velocity
        return place_of(mechanism, self.state, given, *solved, declared=declared)

    def start(self) -> dict[str, float]:
        """Return the state as given, or the mechanism's start; with the contact closed by `close`.

        InputError where there is neither, or the contact cannot be closed.
        """
        return {name: self.place.state[name] for name in self.place.given}

    # ---- questions ----

    @property
    def contact_notices(self) -> tuple[str, ...]:
        """Sentences on the rigid contact problem: friction law, modes of bodies, lost digits."""
        kind = all_choices(self.contact_law()).get("friction") if self.law else None
        of_friction = FRICTION_NOTICES.get(kind or "")
        outline = self.mechanism().outline
        of_contacts = [notice for c in outline.contacts if (notice := friction_notice(c))]
        own = (*((of_friction,) if of_friction else ()), *of_contacts)
        return (*own, *self.mechanism().notices, *border_notices(self.place))

    def classify(self) -> Classification:
        """Return the rigid contact problem at the state, with every solution."""
        return classify_at(self.place)

    @property
    def settings(self) -> RunSettings:
        """The settings of a motion, checked; InputError where there is no end time."""
        if self.t_end is None:
            raise InputError(
                f"{self.where}: no end time, and a motion needs one. "
                "Fix: give --t-end in s, or t_end in a file."
            )
        return RunSettings.of(self.where, self.of_run)

    @property
    def of_run(self) -> dict[str, Any]:
        """Settings of a motion that are given, by their names in `RunSettings`."""
        own = {f.name: getattr(self, f.name) for f in fields(RunSettings) if f.name in SETTINGS}
        return {name: value for name, value in own.items() if value is not None}

    def simulate(self) -> Trajectory:
        """Return the compliant or rigid motion from the state.

        InputError, before anything is compiled, for what is missing, unknown or out of range.
        """
        contact_law, place = self.contact_law(), inside(self.place)
        settings = self.settings
        if self.samples is not None and not 2 <= self.samples <= MAX_SAMPLES:
            raise InputError(f"{self.where}: samples: got {self.samples}, need 2 to {MAX_SAMPLES}.")
        chosen(EngineName, self.engine, "engine", self.where)
        simulator = Simulator(place.mechanism, contact_law, self.engine, self.watch)
        if self.phases or self.inputs or place.mechanism.outline.pulsed:
            return self._in_pieces(simulator, place)
        whole = simulator.with_laws(place, self.law_parameters, self.material)
        start = simulator.start(whole, self.initial_force, self.material)
        simulator, start = simulator.moving(start)
        return simulator.follow(start, settings)

    def _in_pieces(self, simulator: Simulator, place: Place) -> Trajectory:
        """Return the motion with what changes at known times."""
        given: dict[str, Any] = {
            "parameters": place.parameters,
            "law_parameters": self.law_parameters,
            "material": self.material,
            "initial_force": self.initial_force,
            "phases": self.phases,
            "inputs": self.inputs,
        }
        return simulator.run(place.state, **given, **self.of_run)

    def jump(self) -> JumpResult | TangentialImpact:
        """Return the velocity jump at the state, which must be on the surface."""
        mechanism, rule = self.mechanism(), restitution_law(self.rule)
        mechanism.require_one_contact()
        if mechanism.outline.contacts[0].bilateral:
            if self.restitution is not None:
                raise InputError(
                    f"jump of {mechanism.name!r}: restitution: got {self.restitution!r}, need none:"
                    " a bilateral contact does not separate. Fix: leave it out."
                )
            return tangential_impact_at(inside(self.place))
        coefficient = {rule.parameter.name: self.coefficient_of(rule)}
        place = inside(self._place(rule.parameter, **coefficient))
        at = Delassus.of(mechanism).at(place.values)
        gap = float(at.gap[0])
        if abs(gap) > at.gap_tolerance[0]:
            side = "inside the ground" if gap < 0 else "above the ground"
            raise InputError(
                f"jump of {mechanism.name!r}: the contact starts {side}, gap = {gap:g} m, need 0. "
                f"{closing_hint(mechanism, 0)}; or use simulate with a law."
            )
        try:
            return jump_at(place, rule, ImpactFriction(self.impact_friction))
        except InputError:
            raise
        except (ValueError, ArithmeticError) as error:
            raise InputError(
                f"jump of {mechanism.name!r}: the numbers leave the range of floating point "
                f"({error}). Fix: give smaller ones."
            ) from error

    def coefficient_of(self, rule: RestitutionLaw) -> float:
        """Return the coefficient of restitution: the one given, else the law's, else default."""
        if self.restitution is not None:
            return self.restitution
        return self.law_parameters.get(rule.parameter.name, rule.parameter.default)

    def rigidity_notices(self, duration: float) -> tuple[str, ...]:
        """Return sentences on bodies that are not rigid in an impact of this duration; s."""
        mechanism = self.mechanism()
        of_body = two_materials(self.material)[0] if self.material is not None else None
        periods = body_periods(mechanism, self.place.parameters, of_body)
        return rigidity_notices({mechanism.outline.contacts[0].name: duration}, periods)

    def corrected_jump(self, configuration: str = "frozen") -> CorrectedJump | None:
        """Return the jump at finite stiffness; None where no compliant law is named."""
        contact_law = self.contact_law() if self.law is not None else None
        if not isinstance(contact_law, ContactLaw):
            return None
        if self.mechanism().outline.in_space:
            raise InputError(
                f"{self.where}: law: got {contact_law.name!r}, and the jump at finite stiffness is "
                "planar so far. Fix: leave the law out, or use contrast, which has compliant "
                "contacts in space."
            )
        from painleve_sym.motion.finite_stiffness import evaluate_corrected_jump

        of_law, own = dict(self.law_parameters), {p.name for p in contact_law.parameters}
        if self.restitution is not None and f"e_{self.rule}" in own:
            of_law.setdefault(f"e_{self.rule}", self.restitution)
        place = inside(self._place(*contact_law.parameters, **of_law))
        return evaluate_corrected_jump(
            place.mechanism,
            contact_law,
            place.state,
            parameters=place.parameters,
            initial_force=self.initial_force or 0.0,
            configuration=configuration,
        )


# ---- reading plain data: each reader returns the fields one key sets ----

Reader = Callable[[Faults, str, Any], dict[str, Any]]


def _value(unit: str | None, **bounds: float) -> Reader:
    def read(faults: Faults, key: str, value: Any) -> dict[str, Any]:
        return {key: number(value, key, where=faults.where, unit=unit, **bounds)}

    return read


def _wrong(key: str, value: object, need: str) -> InputError:
    return InputError(f"{key}: got {value!r}, need {need}.")


def _read_count(faults: Faults, key: str, value: Any) -> dict[str, Any]:
    return {key: whole_number(value, key, where=faults.where, lower=1, upper=MAX_COUNT)}


def _read_velocity(faults: Faults, key: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, list) or len(value) not in (2, 3):
        raise _wrong(key, value, "numbers along n and t, in space along n, t1, t2, such as [0, 1]")
    read = (number(v, key, where=faults.where, unit="m/s") for v in value)
    return {key: tuple(read)}


def _read_text(_faults: Faults, key: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, str):
        raise _wrong(key, value, "text in quotes")
    return {key: value}


def _read_choice(kind: type[StrEnum]) -> Reader:
    def read(faults: Faults, key: str, value: Any) -> dict[str, Any]:
        _read_text(faults, key, value)
        return {key: chosen(kind, value, key)}

    return read


def _read_table(_faults: Faults, key: str, value: Any) -> dict[str, Any]:
    """Read numbers by name; `_read_names` knows which there are."""
    if not isinstance(value, Mapping):
        raise _wrong(key, value, f"a table of numbers, [{key}]")
    return {key: dict(value)}


def _read_until(_faults: Faults, key: str, value: Any) -> dict[str, Any]:
    kinds = [value] if isinstance(value, str) else value
    if not isinstance(kinds, list) or not all(isinstance(k, str) for k in kinds):
        raise _wrong(key, value, 'the kind of an event, or several: ["separation"]')
    for kind in kinds:
        chosen(EventKind, kind.removeprefix(BEFORE), "event")
    return {key: tuple(kinds)}


def _read_watch(_faults: Faults, key: str, value: Any) -> dict[str, Any]:
    texts = watch_texts(value)
    for text in texts:
        read_watch(text, (), key)
    return {key: texts}


def _read_model(_faults: Faults, key: str, value: Any) -> dict[str, Any]:
    if isinstance(value, Mapping):
        for name in value:
            if name != "name":
                raise InputError("[model]: " + unknown_name("key", name, ["name"]))
        value = value.get("name")
    if not isinstance(value, str):
        raise _wrong(key, value, 'the name of a mechanism, such as model = "rod"')
    return {key: value}


_OF_FILE = ("floating", "armature", "srdf")
_OF_CONTACT = ("point", "normal", "radius", "joints", "pose", "locked", "others")
"""Arguments of `robot` and of `Robot.contact` that a table [robot] may hold."""


def _read_robot(faults: Faults, key: str, value: Any) -> dict[str, Any]:
    """Read the settings of the contact of a robot; `Robot.contact` knows their names."""
    if not isinstance(value, Mapping):
        raise _wrong(key, value, "a table [robot]")
    known, read = (*_OF_FILE, *_OF_CONTACT), dict(value)
    for name, entry in value.items():
        with faults.at(key, name):
            refuse_unknown("key", name, known)
            if name == "floating" and not isinstance(entry, bool):
                raise _wrong(name, entry, "true or false")
            if name in ("srdf", "pose", "others"):
                _read_text(faults, name, entry)
            if name in ("armature", "radius"):
                unit = "m" if name == "radius" else None
                read[name] = number(entry, name, where=faults.where, unit=unit)
    return {key: read}


def _read_csv(_faults: Faults, key: str, value: Any) -> dict[str, Any]:
    """Read how the data of a fit are written."""
    if not isinstance(value, Mapping):
        raise _wrong(key, value, "a table [csv]")
    CsvFormat.of(value)
    return {key: dict(value)}


def _whole(values: Mapping[str, Any], make: Callable[[str], Mechanism]) -> Mechanism:
    """Return the mechanism of a scenario with all its contacts, or the contact of a robot."""
    name, of_robot = values["model"], values.get("robot", {})
    if of_robot or is_robot_file(name):
        return _of_robot(name, values.get("contact"), of_robot, "robot")
    return make(name)


def _of_robot(path: str, contact: str | None, given: Mapping[str, Any], where: str) -> Mechanism:
    """Return a contact of a robot as a mechanism."""
    from painleve_sym.robots.robot_model import robot

    if not is_robot_file(path):
        raise InputError(
            f"{where}: got {', '.join(given)} with the mechanism {path!r}, need the file of a "
            "robot, URDF or MJCF. Fix: leave it out."
        )
    if contact is None:
        raise InputError(
            f"{where}: no contact of the robot. Fix: name its frame, such as --contact LF_FOOT."
        )
    one = robot(path, **{k: v for k, v in given.items() if k in _OF_FILE})
    return one.contact(contact, **{k: v for k, v in given.items() if k in _OF_CONTACT}).mechanism


def _read_law(faults: Faults, key: str, value: Any) -> dict[str, Any]:
    if isinstance(value, str):
        law(value)
        return {key: value}
    if not isinstance(value, Mapping) or not isinstance(value.get("name"), str):
        raise _wrong(key, value, 'a table [law] with name = "..."')
    of_name = law(value["name"])
    fields: dict[str, Any] = {"law": value["name"], "law_parameters": {}, "law_choices": {}}
    known = ["name", "parameters", *all_choices(of_name)]
    for name, entry in value.items():
        with faults.at(key, name):
            if name == "parameters":
                fields["law_parameters"] = _read_table(faults, f"{key}.{name}", entry)[
                    f"{key}.{name}"
                ]
            elif name in all_choices(of_name):
                fields["law_choices"] |= _read_text(faults, name, entry)
            elif name in {p.name for p in of_name.parameters}:
                raise InputError(f"{name} is a parameter. Fix: put it in [law.parameters].")
            elif name != "name":
                raise InputError(unknown_name("key", name, known))
    return fields


def _read_names(faults: Faults, mechanism: Mechanism, values: dict[str, Any]) -> None:
    """Check names against the mechanism, and convert numbers to SI units."""
    of_law: Sequence[Parameter] | None = None
    if "law" in values:
        with faults.at("law"):
            of_law = law(values["law"], **values.get("law_choices", {})).parameters
    with_units = {
        name: Parameter(name, 0.0, unit, name) for name, unit in mechanism.state_units.items()
    }
    own = {p.name: p for p in mechanism.outline.parameters}
    for field_name, path, kind, declared in (
        ("state", ("state",), "state", with_units),
        ("parameters", ("parameters",), "parameter", own),
        ("law_parameters", ("law", "parameters"), "parameter", {p.name: p for p in of_law or ()}),
    ):
        # Of a law that could not be made, parameters are not known.
        given: dict[str, Any] = values.get(field_name, {}) if of_law or path[0] != "law" else {}
        for name, value in given.items():
            with faults.at(*path, name):
                if name not in declared:
                    raise InputError(misplaced(name, of_law) or unknown_name(kind, name, declared))
                at = ".".join((*path, name))
                given[name] = number(value, at, where=faults.where, unit=declared[name].unit)
                if fault := declared[name].fault(given[name]):
                    raise InputError(fault)
    known = [*own, *(p.name for p in of_law or ())]
    for name in values.get("inputs", {}):
        with faults.at("inputs", name):
            refuse_unknown("input or parameter", name, known)
    if "contact" in values and not is_robot_file(values["model"]):
        with faults.at("contact"):
            mechanism.only(values["contact"])
    if "material" in values:
        with faults.at("material"):
            two_materials(values["material"])


def misplaced(name: str, of_law: Sequence[Parameter] | None) -> str:
    """Return a sentence on a parameter of the law that is given to the mechanism, else nothing.

    Without a law (None), the named ones are asked.
    """
    if of_law is None:
        owners = (n for n in LAWS if name in {p.name for p in law(n).parameters})
        owner = next(owners, None)
        if owner is None:
            return ""
        return (
            f"parameter {name} belongs to a contact law, such as {owner}, and there is no law. "
            "Fix: name the law with --law and give the parameter with --law-set, or both in "
            "[law] of a file."
        )
    if name not in {p.name for p in of_law}:
        return ""
    return (
        f"parameter {name} belongs to the law. Fix: give it with --law-set, or in "
        "[law.parameters] of the file."
    )


_OF_TYPE: Mapping[str, Reader] = {
    "EngineLike": _read_choice(EngineName),
    "Mapping[str, float]": _read_table,
    "ImpactFrictionLike": _read_choice(ImpactFriction),
    "RestitutionLike": _read_choice(Restitution),
    "Sequence[str]": _read_watch,
    "int": _read_count,
    "str": _read_text,
    "tuple[float, ...]": _read_velocity,
    "tuple[str, ...]": _read_until,
}


def _reader(of: Setting) -> Reader:
    return _value(of.unit, **of.bounds) if of.type == "float" else _OF_TYPE[of.type]


def _read_phases(faults: Faults, key: str, value: Any) -> dict[str, Any]:
    return {key: tuple(checked_phases(faults.where, value))}


def _read_inputs(_faults: Faults, key: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        raise _wrong(key, value, 'a table of inputs, such as [inputs] with F = "record.csv"')
    return {key: dict(value)}


_OWN = {
    "model": _read_model,
    "law": _read_law,
    "robot": _read_robot,
    "csv": _read_csv,
    "phases": _read_phases,
    "inputs": _read_inputs,
}
_READERS = {
    name: _OWN.get(name) or _reader(of)
    for name, of in SETTINGS.items()
    if name not in ("law_parameters", "law_choices")
}
