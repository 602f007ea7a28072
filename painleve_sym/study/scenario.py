"""A scenario: one case to classify, simulate or jump, as data that a TOML file can hold."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.checks import number, whole_number
from painleve_sym.choices import EngineLike, EngineName, Restitution, chosen
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.contacts.classify import Classification, classify
from painleve_sym.contacts.closing import closed_state
from painleve_sym.contacts.contact_numbers import contact_numbers
from painleve_sym.contacts.impact.jump import JumpResult, evaluate_jump
from painleve_sym.contacts.impact.tangential import TangentialImpact, tangential_impact
from painleve_sym.contacts.inputs import resolve_state, state_values
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.files import parse_toml, read_text
from painleve_sym.laws.catalogue import Law, LawsByContact, law, offered_choices
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.laws.friction import FRICTION_NOTICES
from painleve_sym.laws.restitution import RestitutionLaw, restitution_law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.declarations import resolve_parameters
from painleve_sym.mechanics.materials import material_values, two_materials
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.rigidity import body_periods, rigidity_notices
from painleve_sym.motion.simulator import DEFAULT_RTOL, Simulator
from painleve_sym.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from painleve_sym.motion.finite_stiffness import CorrectedJump

MAX_SAMPLES = 1_000_000
MAX_FILE = 1_000_000
"""Size limit of a scenario file in bytes; guards against special files."""
MAX_COUNT = 1_000_000_000
"""Of steps and events: what still fits into memory and into the engine's integers."""


@dataclass(frozen=True)
class Scenario:
    """One case: a mechanism, a state, and what the question asked of it needs.

    Attributes are those of `simulate`, by the names that a file has; None stands for its defaults,
    and for no state, law or material. `model` names the mechanism, `contact` the only one of
    several contacts to consider. A state that is not given is the mechanism's start. `law_choices`
    are named choices of the law, such as ``reload``. `samples` is the number of evenly spaced times
    to report, at least 2. `e` and `restitution` are those of the jump. `where` is what error
    messages call this scenario, such as the name of its file.
    """

    model: str
    state: Mapping[str, float] | None = None
    parameters: Mapping[str, float] = field(default_factory=dict)
    law: str | None = None
    law_parameters: Mapping[str, float] = field(default_factory=dict)
    law_choices: Mapping[str, str] = field(default_factory=dict)
    t_end: float | None = None
    until: tuple[str, ...] = ()
    initial_force: float | None = None
    engine: EngineLike = EngineName.AUTO
    rtol: float = DEFAULT_RTOL
    max_steps: int | None = None
    max_events: int | None = None
    samples: int | None = None
    e: float | None = None
    restitution: str = Restitution.ENERGETIC
    material: str | None = None
    contact: str | None = None
    close: str | None = None
    title: str = ""
    where: str = "scenario"

    # ---- from data ----

    @classmethod
    def read(cls, path: str | Path) -> Scenario:
        """Return the scenario a TOML file holds; nothing in the file is executed.

        InputError where it is not readable, not TOML, or has unknown keys or entries of a wrong
        type.
        """
        where = f"scenario file {path}"
        return cls.from_data(parse_toml(read_text(path, where, MAX_FILE), where), str(path))

    @classmethod
    def from_data(
        cls, data: Mapping[str, Any], where: str = "scenario", others: tuple[str, ...] = ()
    ) -> Scenario:
        """Return the scenario that plain data describes (see `read`).

        `others` are keys that the file may have besides; messages name them.
        """
        for key in data:
            if key not in _READERS:
                raise InputError(f"{where}: " + unknown_name("key", key, (*_READERS, *others)))
        if "model" not in data:
            raise InputError(f'{where}: no model. Fix: add a line such as model = "rod".')
        values: dict[str, Any] = {}
        for key, value in data.items():
            values |= _READERS[key](where, key, value)
        return cls(**{FIELDS.get(key, key): value for key, value in values.items()}, where=where)

    def updated(self, given: Mapping[str, Any]) -> Scenario:
        """Return a copy with the entries of `given`; mappings are merged entry by entry.

        Another law drops the parameters and choices of the one it replaces.
        """
        old = self
        if given.get("law", self.law) != self.law:
            old = dataclasses.replace(self, law_parameters={}, law_choices={})
        merged = dict(given)
        for name in ("state", "parameters", "law_parameters", "law_choices"):
            if name in given:
                merged[name] = {**(getattr(old, name) or {}), **given[name]}
        return dataclasses.replace(old, **merged)

    def from_material(
        self, varied: Collection[str] = (), mechanism: Mechanism | None = None
    ) -> Scenario:
        """Return a copy with the parameters that `material` provides; given ones keep their values.

        `varied` are further parameters to leave alone, such as the axes of a sweep; `mechanism` is
        that of `model`, where it is known already. InputError for an unknown material, a property
        that it lacks, or where nothing depends on a material.
        """
        if self.material is None:
            return self
        pair, mechanism = two_materials(self.material), mechanism or self.mechanism()
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
        provided = material_values(where, pair, declared, {*own, *varied})
        provided_to_law = material_values(law_name, pair, of_law, {*given, *varied})
        return dataclasses.replace(
            self, parameters={**provided, **own}, law_parameters={**provided_to_law, **given}
        )

    # ---- parts ----

    def mechanism(self) -> Mechanism:
        """Return the mechanism, built once; InputError suggests the nearest name."""
        return self._mechanism

    @cached_property
    def _mechanism(self) -> Mechanism:
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

    def start(self) -> Mapping[str, float]:
        """Return the state as given, or the mechanism's start; with the contact closed by `close`.

        InputError where there is neither, or the contact cannot be closed.
        """
        mechanism = self.mechanism()
        state = mechanism.start if self.state is None else self.state
        if self.state is None and not state:
            raise InputError(
                f"{self.where}: no state, and the mechanism has no start. Fix: give --state, or "
                "[state] in a file; what is not given is 0."
            )
        if self.close is None:
            return state
        given = self._given(mechanism)
        return closed_state(mechanism, state_values(mechanism, state), given, self.close)

    def _given(self, mechanism: Mechanism) -> dict[str, float]:
        declared = mechanism.outline.parameters
        return resolve_parameters(f"{mechanism.name!r}", declared, self.parameters)

    def _state(self, mechanism: Mechanism, parameters: Mapping[str, float]) -> dict[str, float]:
        given = self.start()
        try:
            return resolve_state(mechanism, given, parameters)
        except InputError as error:
            bounded = {name for b in mechanism.outline.domain for name in b.names}
            absent = sorted(bounded & set(mechanism.state_names) - set(self.state or given))
            if not absent or set(given) - set(mechanism.state_names):
                raise
            raise InputError(
                f"{error} Fix: give {', '.join(absent)} too; what is not given is 0."
            ) from error

    # ---- questions ----

    @property
    def friction_notice(self) -> str:
        """Statement on the rigid contact problem under the friction law; empty for Coulomb's."""
        kind = offered_choices(self.contact_law()).get("friction") if self.law else None
        return FRICTION_NOTICES.get(kind or "", "")

    def classify(self) -> Classification:
        """Return the rigid contact problem at the state, with every solution."""
        mechanism = self.mechanism()
        return classify(
            mechanism, self._state(mechanism, self._given(mechanism)), parameters=self.parameters
        )

    def simulate(self) -> Trajectory:
        """Return the compliant or rigid motion from the state.

        InputError, before anything is compiled, for what is missing, unknown or out of range.
        """
        mechanism, contact_law, _ = self.mechanism(), self.contact_law(), self.start()
        if self.t_end is None:
            raise InputError(
                f"{self.where}: no end time, and a motion needs one. "
                "Fix: give --t-end in s, or t_end in a file."
            )
        named = {"max_steps": self.max_steps, "max_events": self.max_events}
        limits: dict[str, Any] = {k: v for k, v in named.items() if v is not None}
        number(self.t_end, "t_end", where=self.where, above=0.0)
        if self.samples is not None and not 2 <= self.samples <= MAX_SAMPLES:
            raise InputError(f"{self.where}: samples: got {self.samples}, need 2 to {MAX_SAMPLES}.")
        chosen(EngineName, self.engine, "engine", self.where)
        # Built for its checks: the simulator makes its own once the code is compiled.
        RunOptions(self.t_end, self.rtol, np.zeros(0), **limits)
        given = self._given(mechanism)
        simulator = Simulator(mechanism, contact_law, self.engine)
        of_law = resolve_parameters(
            f"law {simulator.label!r}",
            simulator.own_parameters,
            simulator.given(law_parameters=self.law_parameters),
        )
        state = self._state(mechanism, given)
        options: dict[str, Any] = {
            "t_end": self.t_end,
            "parameters": {**given, **of_law},
            "until": self.until,
            "rtol": self.rtol,
            "material": self.material,
            **limits,
        }
        if self.initial_force is not None:
            options["initial_force"] = self.initial_force
        return simulator.run(state, **options)

    def jump(self) -> JumpResult | TangentialImpact:
        """Return the velocity jump at the state, which must be on the surface."""
        mechanism, rule = self.mechanism(), restitution_law(self.restitution)
        given = self._given(mechanism)
        mechanism.require_one_contact()
        if mechanism.outline.contacts[0].bilateral:
            if self.e is not None:
                raise InputError(
                    f"jump of {mechanism.name!r}: restitution: got {self.e!r}, need none:"
                    " a bilateral contact does not separate. Fix: leave it out."
                )
            return tangential_impact(mechanism, self._state(mechanism, given), parameters=given)
        coefficient = {rule.parameter.name: self.coefficient_of(rule)}
        given |= resolve_parameters(f"{rule.title}", [rule.parameter], coefficient)
        state = self._state(mechanism, given)
        at = contact_numbers(mechanism)({**state, **given})
        gap = at["gap"]
        if abs(gap) > at["gap_tolerance"]:
            place = "inside the ground" if gap < 0 else "above the ground"
            raise InputError(
                f"jump of {mechanism.name!r}: the contact starts {place}, gap = {gap:g} m, need 0. "
                "Fix: start on the surface, or use simulate with a law."
            )
        try:
            return evaluate_jump(mechanism, rule, state, parameters=given)
        except InputError:
            raise
        except (ValueError, ArithmeticError) as error:
            raise InputError(
                f"jump of {mechanism.name!r}: the numbers leave the range of floating point "
                f"({error}). Fix: give smaller ones."
            ) from error

    def coefficient_of(self, rule: RestitutionLaw) -> float:
        """Return the coefficient of restitution: the one given, else the law's, else default."""
        if self.e is not None:
            return self.e
        return self.law_parameters.get(rule.parameter.name, rule.parameter.default)

    def rigidity_notices(self, duration: float) -> tuple[str, ...]:
        """Return sentences on bodies that are not rigid in an impact of this duration; s."""
        mechanism = self.mechanism()
        of_body = two_materials(self.material)[0] if self.material is not None else None
        periods = body_periods(mechanism, self._given(mechanism), of_body)
        return rigidity_notices({mechanism.outline.contacts[0].name: duration}, periods)

    def corrected_jump(self, configuration: str = "frozen") -> CorrectedJump | None:
        """Return the jump at finite stiffness; None where no compliant law is named."""
        contact_law = self.contact_law() if self.law is not None else None
        if not isinstance(contact_law, ContactLaw):
            return None
        from painleve_sym.motion.finite_stiffness import evaluate_corrected_jump

        mechanism, of_law = self.mechanism(), dict(self.law_parameters)
        own = {p.name for p in contact_law.parameters}
        if self.e is not None and f"e_{self.restitution}" in own:
            of_law.setdefault(f"e_{self.restitution}", self.e)
        of_law = resolve_parameters(f"law {contact_law.name!r}", contact_law.parameters, of_law)
        given = self._given(mechanism)
        return evaluate_corrected_jump(
            mechanism,
            contact_law,
            self._state(mechanism, given),
            parameters={**given, **of_law},
            initial_force=self.initial_force or 0.0,
            configuration=configuration,
        )


# ---- reading plain data: each reader returns the fields one key sets ----

Reader = Callable[[str, str, Any], dict[str, Any]]
FIELDS = {"restitution": "e", "rule": "restitution"}
"""Fields of a scenario by the key of a file or the option, where the two differ."""


def _wrong(where: str, key: str, value: object, need: str) -> InputError:
    return InputError(f"{where}: {key}: got {value!r}, need {need}.")


def _read_float(where: str, key: str, value: Any) -> dict[str, Any]:
    return {key: number(value, key, where=where)}


def _read_count(where: str, key: str, value: Any) -> dict[str, Any]:
    return {key: whole_number(value, key, where=where, lower=1, upper=MAX_COUNT)}


def _read_text(where: str, key: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, str):
        raise _wrong(where, key, value, "text in quotes")
    return {key: value}


def _read_numbers(where: str, key: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        raise _wrong(where, key, value, f"a table of numbers, [{key}]")
    return {key: {name: number(v, f"{key}.{name}", where=where) for name, v in value.items()}}


def _read_until(where: str, key: str, value: Any) -> dict[str, Any]:
    kinds = [value] if isinstance(value, str) else value
    if not isinstance(kinds, list) or not all(isinstance(k, str) for k in kinds):
        raise _wrong(where, key, value, 'the kind of an event, or several: ["separation"]')
    return {key: tuple(kinds)}


def _read_model(where: str, key: str, value: Any) -> dict[str, Any]:
    if isinstance(value, Mapping):
        for name in value:
            if name != "name":
                raise InputError(f"{where}: [model]: " + unknown_name("key", name, ["name"]))
        value = value.get("name")
    if not isinstance(value, str):
        raise _wrong(where, key, value, 'the name of a mechanism, such as model = "rod"')
    return {key: value}


def _read_law(where: str, key: str, value: Any) -> dict[str, Any]:
    if isinstance(value, str):
        return {key: value}
    if not isinstance(value, Mapping) or not isinstance(value.get("name"), str):
        raise _wrong(where, key, value, 'a table [law] with name = "..."')
    chosen = law(value["name"])
    fields: dict[str, Any] = {"law": value["name"], "law_parameters": {}, "law_choices": {}}
    for name, entry in value.items():
        if name == "parameters":
            read = _read_numbers(where, "law.parameters", entry)
            fields["law_parameters"] = read["law.parameters"]
        elif name in offered_choices(chosen):
            fields["law_choices"] |= _read_text(where, name, entry)
        elif name in {p.name for p in chosen.parameters}:
            raise InputError(
                f"{where}: [law]: {name} is a parameter. Fix: put it in [law.parameters]."
            )
        elif name != "name":
            known = ["name", "parameters", *offered_choices(chosen)]
            raise InputError(f"{where}: [law]: " + unknown_name("key", name, known))
    return fields


_READERS: Mapping[str, Reader] = {
    "title": _read_text,
    "material": _read_text,
    "contact": _read_text,
    "close": _read_text,
    "model": _read_model,
    "state": _read_numbers,
    "parameters": _read_numbers,
    "law": _read_law,
    "t_end": _read_float,
    "until": _read_until,
    "initial_force": _read_float,
    "engine": _read_text,
    "rtol": _read_float,
    "max_steps": _read_count,
    "max_events": _read_count,
    "samples": _read_count,
    "restitution": _read_float,
    "rule": _read_text,
}
