"""A sweep: one motion for every point of a grid or a sampled set, as data that a file can hold."""

from __future__ import annotations

import functools
import hashlib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.codegen.quantities import quantities
from painleve_sym.codegen.source import ENGINE_REASONS
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.laws.rigid import RigidLaw
from painleve_sym.mechanics.files import mechanism_from_text
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.simulate.compliant import SoftenedSimulator
from painleve_sym.simulate.inputs import CONTACT_TOLERANCE
from painleve_sym.simulate.many import simulate_many
from painleve_sym.simulate.many_result import unit_of
from painleve_sym.simulate.rigid import rigid_simulator
from painleve_sym.simulate.simulator import ContactSimulator
from painleve_sym.study.map_cases import LEGEND, opening_case
from painleve_sym.study.scenario import MAX_FILE, Scenario
from painleve_sym.study.sweep_space import Grid, Sample, read_space

OWN_KEYS = ("axes", "sample", "keep", "chunk")
UNUSED_KEYS = ("samples", "restitution", "rule")
DEFAULT_CHUNK = 20_000
MAX_CHUNK = 10_000_000
CASES: dict[str, int] = {**LEGEND, "apart": -2, "no_slip": -3}
"""Codes of ``case``: the rigid contact problem at the start; apart: the contact is not closed."""


@dataclass(frozen=True)
class Sweep:
    """A scenario, the points it is run at, and what is kept of each run.

    Attributes
    ----------
    scenario : Scenario
        What all points share.
    space : Grid or Sample
    keep : tuple of str
        Names of `ManyResult`, and ``case``.
    chunk : int
        Points computed and written at a time.
    text : str
        The sweep's own file.
    mechanism_text : str or None
        Content of the mechanism's file, where the model is one.
    """

    scenario: Scenario
    space: Grid | Sample
    keep: tuple[str, ...]
    chunk: int
    text: str
    mechanism_text: str | None = None

    @classmethod
    def read(cls, path: str | Path) -> Sweep:
        """Return the sweep a TOML file describes; nothing in the file is executed.

        Raises
        ------
        InputError
            Not readable, not TOML, unknown keys or names, empty axes, numbers that are not finite.
        """
        text = _content(f"sweep file {path}", path)
        return cls.from_text(text, str(path))

    @classmethod
    def from_text(cls, text: str, where: str, mechanism_text: str | None = None) -> Sweep:
        """Return the sweep of a text; see `read`."""
        try:
            data = tomllib.loads(text)
        except (ValueError, RecursionError) as error:
            raise InputError(
                f"sweep file {where}: not valid TOML ({error}). Fix: correct that place."
            ) from error
        own = {key: data.pop(key) for key in OWN_KEYS if key in data}
        for key in UNUSED_KEYS:
            if key in data:
                raise InputError(f"{where}: {key} plays no part in a sweep. Fix: leave it out.")
        scenario = Scenario.from_data(data, where)
        if mechanism_text is None and scenario.model.endswith(".toml"):
            mechanism_text = _content(f"{where}: model {scenario.model}", scenario.model)
        space = read_space(where, own.get("axes"), own.get("sample"))
        chunk = own.get("chunk", DEFAULT_CHUNK)
        if isinstance(chunk, bool) or not isinstance(chunk, int) or not 1 <= chunk <= MAX_CHUNK:
            raise InputError(
                f"{where}: chunk: got {chunk!r}, need a whole number from 1 to {MAX_CHUNK}."
            )
        keep = own.get("keep", [])
        if not isinstance(keep, list) or not all(isinstance(k, str) for k in keep):
            raise InputError(f"{where}: keep: got {keep!r}, need a list of names in quotes.")
        sweep = cls(scenario, space, tuple(dict.fromkeys(keep)), chunk, text, mechanism_text)
        return sweep._checked()

    @property
    def fingerprint(self) -> str:
        """Hash of the texts: the same for the same sweep, wherever it runs."""
        return hashlib.sha256(f"{self.text}\n{self.mechanism_text or ''}".encode()).hexdigest()

    @cached_property
    def mechanism(self) -> Mechanism:
        """The mechanism, with the chosen contact alone where one is named."""
        if self.mechanism_text is None:
            return self.scenario.mechanism()
        path = Path(self.scenario.model)
        whole = mechanism_from_text(self.mechanism_text, str(path), path.stem)
        return whole if self.scenario.contact is None else whole.only(self.scenario.contact)

    @cached_property
    def simulator(self) -> ContactSimulator:
        """The simulator of the mechanism with the law."""
        law, engine = self.scenario.contact_law(), self.scenario.engine
        if isinstance(law, RigidLaw):
            return rigid_simulator(self.mechanism, law.restitution, law.policy, engine)
        return SoftenedSimulator(self.mechanism, law, engine)

    @property
    def starts(self) -> range:
        """First points of the chunks."""
        return range(0, self.space.points, self.chunk)

    @property
    def kept(self) -> tuple[str, ...]:
        """Everything that is written of a point, besides the point itself."""
        system = self.mechanism.system
        final = tuple(s.name for s in (*system.q, *system.q_dot))
        named = self.keep or ("time", *final)
        return tuple(dict.fromkeys(("stop_reason", *named)))

    # ---- checks, before anything runs ----

    def _checked(self) -> Sweep:
        where, scenario = self.scenario.where, self.scenario
        parameters = (*self.mechanism.system.parameters, *self.simulator.own_parameters)
        states, names = self.mechanism.state_names, [p.name for p in parameters]
        given = {*(scenario.state or {}), *scenario.parameters, *scenario.law_parameters}
        given |= {"initial_force"} if scenario.initial_force is not None else set()
        known = (*states, *names, "initial_force")
        for name in self.space.names:
            if name not in known:
                raise InputError(f"{where}: " + unknown_name("axis", name, known))
            if name in given:
                raise InputError(
                    f"{where}: {name} is both given and varied. Fix: leave it out of one."
                )
        declared = {p.name: p for p in parameters}
        for name in self.space.names:
            for value in self.space.ends(name):
                fault = declared[name].fault(value) if name in declared else None
                if name == "initial_force" and value < 0:
                    fault = f"initial_force: got {value!r}, need >= 0."
                if fault:
                    raise InputError(f"{where}: {fault}")
        if scenario.t_end is None:
            raise InputError(f"{where}: no end time. Fix: add t_end, in s.")
        if scenario.engine == "erk" and any(map(_is_watched, self.keep)):
            raise InputError(f"{where}: keep: extremes and integrals need the compiled engine.")
        self._check_law_parameters()
        return self

    def _check_law_parameters(self) -> None:
        own = [p.name for p in self.simulator.own_parameters]
        for name in self.scenario.law_parameters:
            if name not in own:
                message = unknown_name("parameter of the law", name, own)
                raise InputError(f"{self.scenario.where}: {message}")

    def check_run(self) -> None:
        """Compile what is needed and run one point, so that faults show before the sweep.

        Raises
        ------
        InputError
            What `simulate_many` refuses, unknown names to keep.
        """
        self.compute(0, 1, threads=1)
        last = self.space.points - 1
        self.compute(last, last + 1, threads=1)

    # ---- the work ----

    def compute(self, start: int, stop: int, threads: int | None = None) -> dict[str, NDArray[Any]]:
        """Return what is kept of the points start..stop − 1, each name of shape (stop − start,).

        Stop reasons and cases are codes (`codes`).
        """
        scenario, varied = self.scenario, self.space.values(start, stop)
        force: Any = varied.get("initial_force", scenario.initial_force)
        states: dict[str, Any] = dict(scenario.state or {})
        states |= {n: v for n, v in varied.items() if n in self.mechanism.state_names}
        parameters: dict[str, Any] = {**scenario.parameters, **scenario.law_parameters}
        others = {"initial_force", *states}
        parameters |= {n: v for n, v in varied.items() if n not in others}
        limits = {n: getattr(scenario, n) for n in ("max_steps", "max_events")}
        assert scenario.t_end is not None
        found = simulate_many(
            self.simulator,
            states,
            parameters,
            t_end=scenario.t_end,
            until=scenario.until,
            initial_force=force,
            rtol=scenario.rtol,
            threads=threads,
            **self._wish(),
            **{n: v for n, v in limits.items() if v is not None},
        )
        kept: dict[str, NDArray[Any]] = {}
        for name in self.kept:
            if name == "stop_reason":
                kept[name] = found.rows.reason.astype(np.int8)
            elif name == "mode":
                kept[name] = found.rows.mode.astype(np.int16)
            elif name == "case":
                kept[name] = self._case({**found.inputs}, stop - start)
            else:
                kept[name] = np.ascontiguousarray(found[name])
        return kept

    def _wish(self) -> dict[str, Any]:
        wish: dict[str, Any] = {"events": 1, "maxima": (), "minima": (), "integrals": ()}
        for name in self.keep:
            name = name.removesuffix("_time")
            for prefix, kind in _WATCHED.items():
                if name.startswith(prefix):
                    wish[kind] = tuple(dict.fromkeys((*wish[kind], name.removeprefix(prefix))))
        return wish

    def _case(self, inputs: Mapping[str, Any], n: int) -> NDArray[np.int8]:
        mechanism = self.mechanism
        if len(mechanism.contacts) > 1 or mechanism.contact.bilateral:
            raise InputError(
                f"{self.scenario.where}: keep: case needs one contact that can open. "
                "Fix: leave it out, or name one contact."
            )
        system, c = mechanism.system, mechanism.coefficients
        contact = mechanism.contact
        symbols = (*system.q, *system.q_dot, *(p.symbol for p in system.parameters))
        numbers = quantities(
            "case of a start",
            mechanism.definition,
            symbols,
            lambda: {
                "gap": contact.gap,
                "rate": contact.gap_rate,
                "slip": contact.slip_velocity,
                "A_pos": c.A(1),
                "A_neg": c.A(-1),
                "B": c.B,
            },
        )
        with np.errstate(all="ignore"):
            values = {s: np.broadcast_to(inputs[s.name], (n,)) for s in symbols}
            at = numbers.at(values)
            codes = opening_case(np.where(at["slip"] > 0, at["A_pos"], at["A_neg"]), at["B"])
        codes = np.where(np.isfinite(at["A_pos"] + at["A_neg"] + at["B"]), codes, CASES["outside"])
        closed = np.abs([at["gap"], at["rate"]]).max(axis=0) <= CONTACT_TOLERANCE
        codes = np.where(at["slip"] == 0, CASES["no_slip"], codes)
        return np.where(closed, codes, CASES["apart"]).astype(np.int8)

    def codes(self, name: str) -> dict[str, int] | None:
        """Return text → code of a quantity that is written as codes, None for others."""
        if name == "stop_reason":
            return {r.label: i for i, r in enumerate(ENGINE_REASONS)}
        if name == "mode":
            return {m.name: i for i, m in enumerate(self.simulator.outline.modes)}
        return dict(CASES) if name == "case" else None

    def unit(self, name: str) -> str:
        """Return the SI unit of a quantity; "1" where it has none."""
        if name == "initial_force":
            return "N"
        own = {p.name: p.unit for p in self.simulator.own_parameters}
        return own.get(name) or unit_of(self.mechanism, name)


_WATCHED = {"max_": "maxima", "min_": "minima", "integral_": "integrals"}


def _is_watched(name: str) -> bool:
    return name.startswith(tuple(_WATCHED))


def _content(where: str, path: str | Path) -> str:
    try:
        with Path(path).open("rb") as file:
            content = file.read(MAX_FILE + 1)
        if len(content) > MAX_FILE:
            raise InputError(f"{where}: got more than {MAX_FILE} bytes.")
        return content.decode("utf-8")
    except OSError as error:
        raise InputError(f"{where}: {error.strerror}. Fix: name a readable TOML file.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{where}: not UTF-8 text. Fix: name a TOML file.") from error


@functools.lru_cache(maxsize=4)
def sweep_of_texts(text: str, where: str, mechanism_text: str | None) -> Sweep:
    """Return the sweep of a text, built once per process: what a distant worker starts from."""
    return Sweep.from_text(text, where, mechanism_text)
