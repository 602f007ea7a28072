"""The C of an explorer's WebAssembly module, and the names by which a page uses it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import resources
from string import Template
from typing import Any

import sympy as sp

from painleve_sym.c_export.contacts import CASES
from painleve_sym.c_export.files import MotionCode, clashing_name, code_files
from painleve_sym.codegen.c_functions import c_functions
from painleve_sym.codegen.compile import Compiler
from painleve_sym.codegen.evaluate import expression_function
from painleve_sym.contacts.contact_numbers import argument_symbols
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.protocol import ENGINE_REASONS
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.errors import InputError, NoRecurrence
from painleve_sym.explorer.prebuilt import Laws
from painleve_sym.files import finite
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.declarations import Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.shapes import (
    PLACE,
    Shape,
    contact_geometries,
    scene_formulas,
    suggested_shapes,
)
from painleve_sym.motion.simulator import Simulator
from painleve_sym.quantities import unit_of
from painleve_sym.study.maps.axes import default_range, parameter_range

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
        """The motions of the page: with the law, and rigid where the law is not."""
        first = Simulator(self.mechanism, self.law)
        rigid = [] if first.rigid else [Simulator(self.mechanism, RigidLaw())]
        return (first, *rigid)

    @cached_property
    def codes(self) -> tuple[MotionCode, ...]:
        """The motions as C, named ``motion_1`` and ``motion_2``."""
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
        if self._shapes:
            texts["scene.c"] = _filled("scene.c", values | self._scene_code)
        return texts

    @property
    def units(self) -> tuple[str, ...]:
        """Names of the files to be compiled; motions include theirs."""
        motions = (f"{code.name}.c" for code in self.codes)
        drawing = ("scene.c",) if self._shapes else ()
        return (*motions, f"{self.codes[0].name}_contact.c", "contact.c", *drawing)

    # ---- the drawing ----

    @cached_property
    def _shapes(self) -> tuple[Shape, ...]:
        """Shapes of the drawing; none where the mechanism has none."""
        return self.mechanism.shapes or suggested_shapes(self.mechanism)

    @cached_property
    def _scene_code(self) -> dict[str, Any]:
        mechanism = self.mechanism
        geometries = contact_geometries(mechanism).values()
        symbols = (*argument_symbols(mechanism), *PLACE)
        places = list(scene_formulas(mechanism, self._shapes).values())
        surfaces = [geometry.surface for geometry in geometries]
        functions = [
            expression_function("scene_places", places, symbols),
            expression_function("scene_surfaces", surfaces or [sp.Integer(1)], symbols),
        ]
        return {
            "functions": c_functions(functions),
            "own": len(mechanism.outline.parameters),
            "numbers": len(places),
            "contacts": len(surfaces),
            "work": 1 + max(f.sz_w() for f in functions),
        }

    @cached_property
    def _scene(self) -> dict[str, Any] | None:
        if not self._shapes:
            return None
        shapes = [{"kind": str(s.kind), "points": len(s.points)} for s in self._shapes]
        return {"shapes": shapes, "contacts": list(contact_geometries(self.mechanism))}

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
            "mechanism": {
                name: getattr(mechanism, name) for name in ("name", "title", "source", "sketch")
            },
            "states": [self._state(name) for name in mechanism.state_names],
            "parameters": self._parameters(),
            "over": _axes(mechanism),
            "contacts": [
                {
                    "name": c.name,
                    "bilateral": c.bilateral,
                    "friction": c.friction,
                    "gap": row.gap,
                    "gap_rate": row.gap_rate,
                    "slip": row.slip,
                }
                for c, row in zip(
                    mechanism.outline.contacts, self.simulators[0].contact.rows, strict=True
                )
            ],
            "cases": [{"name": c.value, "sentence": c.sentence} for c in CASES],
            "stops": [{"name": r.label, "sentence": r.advice} for r in ENGINE_REASONS],
            "motions": [_motion(code) for code in self.codes],
            "scene": self._scene,
        }

    def _state(self, name: str) -> dict[str, Any]:
        mechanism = self.mechanism
        meanings = {c.name: c.meaning for c in mechanism.outline.coordinates}
        meanings |= {f"{n}_dot": f"rate of {n}" for n in list(meanings)}
        return {
            "name": name,
            "unit": mechanism.state_units[name],
            "meaning": meanings.get(name, "time of what moves as prescribed"),
            "value": float(mechanism.start.get(name, 0.0)),
            "range": default_range(mechanism, name, mechanism.start, mechanism.parameters),
        }

    def _parameters(self) -> list[dict[str, Any]]:
        declared: dict[str, Parameter] = {}
        for code in self.codes:
            declared |= {n: code.declared[n] for n in code.outline.parameter_names}
        own = {p.name for p in self.mechanism.outline.parameters}
        return [_parameter(p, p.name in own) for p in declared.values()]


def _motion_code(name: str, simulator: Simulator) -> MotionCode:
    """Return the motion with Taylor series, or with Runge–Kutta steps where there are none."""
    code = MotionCode(name, simulator, TaylorEngine.name, _WEB)
    try:
        _ = code.engine
    except NoRecurrence:
        return replace(code, engine_name=CompiledEngine.name)
    return code


def _motion_values(code: MotionCode) -> Mapping[str, Any]:
    several = bool(code.outline.parts)
    return {
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
        "rigid": bool(simulator.rigid),
        "pressable": not simulator.initial_force_fault(),
        "states": list(code.states),
        "units": [unit_of(name, units) for name in code.states],
        "parameters": list(outline.parameter_names),
        "memory": list(outline.memory_names),
        "modes": [m.name for m in outline.modes],
        "outputs": [{"name": n, "unit": unit_of(n, units)} for n in outline.output_names],
        "events": [{"name": str(k), "sentence": k.sentence} for k in outline.kinds],
        "parts": [
            {
                "contact": part.name,
                "memory": outline.memory_names.index(part.memory[0]),
                "local_modes": list(part.local_modes),
            }
            for part in outline.parts
        ],
    }


def _parameter(p: Parameter, of_mechanism: bool) -> dict[str, Any]:
    stiffness = p.unit in STIFFNESSES and p.default > 0
    ends = (p.default * SOFTER, p.default * STIFFER) if stiffness else parameter_range(p)
    return {
        "name": p.name,
        "unit": p.unit,
        "meaning": p.meaning,
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


def _axes(mechanism: Mechanism) -> tuple[str, str]:
    """Return the axes of the map at first: an angle with its rate, else the first coordinate."""
    coordinates = mechanism.outline.coordinates
    first = next((c for c in coordinates if c.unit == "rad"), coordinates[0]).name
    return first, f"{first}_dot"
