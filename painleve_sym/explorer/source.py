"""The C of an explorer's WebAssembly module, and the names by which a page uses it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import resources
from string import Template
from typing import TYPE_CHECKING, Any

from painleve_sym.at.delassus import argument_symbols
from painleve_sym.automata.model import ENERGIES, LOSSES
from painleve_sym.c_export.contacts import CASES
from painleve_sym.c_export.files import MotionCode, clashing_name, code_files
from painleve_sym.codegen.c_functions import c_functions
from painleve_sym.codegen.compile import Compiler
from painleve_sym.codegen.evaluate import expression_function
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.protocol import ENGINE_REASONS
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.errors import InputError, NoRecurrence
from painleve_sym.explorer.first_map import FirstMap, first_map
from painleve_sym.explorer.prebuilt import Laws, alternatives
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.declarations import Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.energy_balance import ENERGY_ROUNDING
from painleve_sym.motion.refusals import initial_force_fault
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.small_events import RATES
from painleve_sym.plain_data import finite, plain_fields, to_plain
from painleve_sym.quantities import unit_of
from painleve_sym.study.maps.axes import default_range, parameter_range

if TYPE_CHECKING:
    from painleve_sym.mechanics.shapes import Shape

STIFFNESSES = ("Pa", "N/m")
"""Units of the parameters that a slider changes by orders of magnitude."""
SOFTER, STIFFER = 1e-2, 1e8
"""Ends of their sliders, in parts of the default: to the stiffness of the paper's Table 6."""

_WEB = Compiler((), "clang --target=wasm32-wasi")


@dataclass(frozen=True)
class ModuleSource:
    """A mechanism with a contact law, and with the rigid law beside a compliant one."""

    mechanism: Mechanism
    law: Laws

    @cached_property
    def simulators(self) -> tuple[Simulator, ...]:
        """The motions of the page: with the law or its alternatives, and rigid where it is not."""
        laws = alternatives(self.mechanism, self.law)
        own = tuple(Simulator(self.mechanism, law) for law in laws)
        return own if own[0].rigid else (*own, Simulator(self.mechanism, RigidLaw()))

    @property
    def definition(self) -> str:
        """Everything that the module and its description are made of, as one text.

        Raises
        ------
        TypeError
            The mechanism or its drawing has no such text.
        """
        mechanism, simulators = self.mechanism, self.simulators
        names = ("name", "title", "source", "sketch", "start", "outline")
        plain = [getattr(mechanism, name) for name in names]
        plain += [(s.label, s.choices, s.own_parameters) for s in simulators]
        made_of = [s.contact.definition for s in simulators]
        return "\n".join((json.dumps(to_plain(plain)), mechanism.drawing_definition, *made_of))

    @cached_property
    def codes(self) -> tuple[MotionCode, ...]:
        """The motions as C, with ``motion_1``, ``motion_2`` and so on as their names."""
        pairs = enumerate(self.simulators, 1)
        return tuple(_motion_code(f"motion_{i}", simulator) for i, simulator in pairs)

    @cached_property
    def files(self) -> dict[str, str]:
        """The C by file name; those of `units` are compiled."""
        texts: dict[str, str] = {}
        for code in self.codes:
            own = code_files(code)
            if clash := clashing_name(code, own):
                raise InputError(
                    f"explorer of {self.mechanism.name!r}: the generated code has a name {clash} "
                    "already. Fix: rename the coordinate or parameter of that name."
                )
            texts |= own | {f"{code.name}.c": _filled("motion.c", _motion_values(code))}
        first = self.codes[0]
        values = {"name": first.name, "NAME": first.name.upper(), "motion": first.motion_count}
        values["mechanism"] = first.title
        texts["contact.c"] = _filled("contact.c", values)
        texts["scene.c"] = _filled("scene.c", values | self._scene_code)
        return texts

    @property
    def units(self) -> tuple[str, ...]:
        """Names of the files to be compiled; motions include theirs."""
        motions = (f"{code.name}.c" for code in self.codes)
        return (*motions, f"{self.codes[0].name}_contact.c", "contact.c", "scene.c")

    # ---- the drawing ----

    @cached_property
    def _shapes(self) -> tuple[Shape, ...]:
        """Shapes of the drawing; none where the mechanism has none."""
        from painleve_sym.mechanics.drawing import drawn_shapes

        return drawn_shapes(self.mechanism)

    @cached_property
    def _scene_code(self) -> dict[str, Any]:
        from sympy import Integer

        from painleve_sym.mechanics.drawing import ground_surfaces, scene_formulas
        from painleve_sym.mechanics.shapes import PLACE

        mechanism = self.mechanism
        symbols = (*argument_symbols(mechanism), *PLACE)
        formulas = {
            "places": list(scene_formulas(mechanism, self._shapes).values()),
            "surfaces": list(ground_surfaces(mechanism).values()),
            "margins": [bound.margin for bound in mechanism.domain],
        }
        functions = [
            expression_function(f"scene_{name}", rows or [Integer(1)], symbols)
            for name, rows in formulas.items()
        ]
        return {
            "functions": c_functions(functions),
            "own": len(mechanism.outline.parameters),
            "numbers": len(formulas["places"]),
            "grounds": len(formulas["surfaces"]),
            "bounds": len(formulas["margins"]),
            "work": 1 + max(f.sz_w() for f in functions),
        }

    @cached_property
    def _scene(self) -> dict[str, Any] | None:
        from painleve_sym.mechanics.drawing import contact_geometries, ground_surfaces

        if not self._shapes:
            return None
        modes = [mode for body in self.mechanism.system.bodies for mode in body.modes]
        return {
            "shapes": [{"kind": str(s.kind), "points": len(s.points)} for s in self._shapes],
            "declared": bool(self.mechanism.shapes),
            "contacts": list(contact_geometries(self.mechanism)),
            "grounds": list(ground_surfaces(self.mechanism)),
            "deflections": [str(mode.coordinate) for mode in modes],
        }

    @cached_property
    def digest(self) -> str:
        """Hash of the C, without the headers, whose comments name a compiler's flags."""
        text = "\n".join(t for name, t in sorted(self.files.items()) if name.endswith(".c"))
        return hashlib.sha256(text.encode()).hexdigest()

    @cached_property
    def description(self) -> dict[str, Any]:
        """Names, units, meanings and ranges with which a page uses the module, as plain data."""
        mechanism = self.mechanism
        return {
            "mechanism": plain_fields(mechanism, "name", "title", "source", "sketch"),
            "states": [self._state(name) for name in mechanism.state_names],
            "parameters": self._parameters(),
            "over": list(self._first_map.ranges),
            "contact": self._first_map.contact,
            "domain": [bound.meaning for bound in mechanism.domain],
            "contacts": [
                {
                    **plain_fields(c, "name", "bilateral", "friction"),
                    **plain_fields(row, "gap", "gap_rate", "slip"),
                }
                for c, row in zip(
                    mechanism.outline.contacts, self.simulators[0].contact.rows, strict=True
                )
            ],
            "cases": [{"name": c.value, "sentence": c.sentence} for c in CASES],
            "stops": [{"name": r.label, "sentence": r.sentence} for r in ENGINE_REASONS],
            "motions": [_motion(code) for code in self.codes],
            "scene": self._scene,
        }

    @cached_property
    def _first_map(self) -> FirstMap:
        """The map at first, for the slip of each contact at the start, to the left at rest."""
        first, mechanism = self.simulators[0], self.mechanism
        start, _ = first.prepared(first.at())
        state = dict(zip(first.outline.state_names, start.state.tolist(), strict=True))
        slips = (state[row.slip] for row in first.contact.rows)
        return first_map(mechanism, [1 if slip > 0 else -1 for slip in slips])

    def _state(self, name: str) -> dict[str, Any]:
        mechanism = self.mechanism
        meanings = {c.name: c.meaning for c in mechanism.outline.coordinates}
        meanings |= {f"{n}_dot": f"rate of {n}" for n in list(meanings)}
        shown = self._first_map.ranges
        usual = default_range(mechanism, name, mechanism.start, mechanism.parameters)
        return {
            "name": name,
            "unit": mechanism.state_units[name],
            "meaning": meanings.get(name, "time of what moves as prescribed"),
            "value": float(mechanism.start.get(name, 0.0)),
            "range": shown.get(name, usual),
            "leading": name in shown or bool(mechanism.start.get(name)),
        }

    def _parameters(self) -> list[dict[str, Any]]:
        declared: dict[str, Parameter] = {}
        for code in self.codes:
            declared |= {n: code.declared[n] for n in code.outline.parameter_names}
        own = {p.name for p in self.mechanism.outline.parameters}
        shown = self._first_map.ranges
        leading = {c.friction for c in self.mechanism.outline.contacts} | set(shown)
        speeds = (c.surface_speed.free_symbols for c in self.mechanism.contacts)
        leading |= {symbol.name for symbols in speeds for symbol in symbols}
        return [
            {
                **_parameter(p, p.name in own, shown.get(p.name)),
                "leading": p.name in leading or (p.name not in own and _leads(p)),
            }
            for p in declared.values()
        ]


def _leads(p: Parameter) -> bool:
    """Return whether a parameter of a law is among the few that teach first."""
    return p.unit in STIFFNESSES or p.name.startswith("e_")


def _motion_code(name: str, simulator: Simulator) -> MotionCode:
    """Return the motion with Taylor series, or with Runge–Kutta steps where there are none."""
    code = MotionCode(name, simulator, TaylorEngine.name, _WEB)
    try:
        _ = code.engine
    except NoRecurrence:
        return replace(code, engine_name=CompiledEngine.name)
    return code


def _motion_values(code: MotionCode) -> Mapping[str, Any]:
    outline, several = code.outline, bool(code.outline.parts)
    states, outputs = list(outline.state_names), list(outline.output_names)
    works = [str(states.index(name)) for name in LOSSES if name in states]
    return {
        "energies": ", ".join(str(outputs.index(name)) for name in ENERGIES),
        "potential": outputs.index("potential_energy"),
        "dissipations": ", ".join(works),
        "rounding": repr(float(ENERGY_ROUNDING)),
        "name": code.name,
        "title": code.title,
        "event_contact": "e->contact" if several else "-1",
        "event_memory": "put(rest, e->memory_after, PS_NZ);" if several else "(void)rest;",
    }


def _filled(name: str, values: Mapping[str, Any]) -> str:
    text = resources.files(__package__).joinpath("c", name).read_text("utf-8")
    return Template(text).substitute(values)


def _motion(code: MotionCode) -> dict[str, Any]:
    outline, simulator = code.outline, code.simulator
    units = simulator.mechanism.units
    return {
        "name": code.name,
        "law": simulator.label,
        "choices": simulator.choices,
        "engine": code.engine_name,
        "rigid": list(simulator.rigid),
        "pressable": not initial_force_fault(simulator),
        "states": list(code.states),
        "units": [unit_of(name, units) for name in code.states],
        "parameters": list(outline.parameter_names),
        "memory": list(outline.memory_names),
        "modes": [m.name for m in outline.modes],
        "outputs": [{"name": n, "unit": unit_of(n, units)} for n in outline.output_names],
        "events": [
            {"name": str(k), "sentence": k.sentence, "rate": RATES.get(k)} for k in outline.kinds
        ],
        "parts": [
            {
                "contact": part.name,
                "memory": outline.memory_names.index(part.memory[0]),
                "local_modes": list(part.local_modes),
            }
            for part in outline.parts
        ],
    }


def _parameter(
    p: Parameter, of_mechanism: bool, ends: tuple[float, float] | None
) -> dict[str, Any]:
    stiffness = p.unit in STIFFNESSES and p.default > 0
    if ends is None:
        ends = (p.default * SOFTER, p.default * STIFFER) if stiffness else parameter_range(p)
    return {
        **plain_fields(p, "name", "unit", "meaning"),
        "value": p.default,
        "range": ends,
        "logarithmic": stiffness,
        "of": "mechanism" if of_mechanism else "law",
        "lower": finite(p.lower),
        "upper": finite(p.upper),
        "lower_closed": p.lower_closed,
        "upper_closed": p.upper_closed,
        "need": p.range_text,
    }
