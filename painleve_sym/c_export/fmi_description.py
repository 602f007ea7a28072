"""The model description of an FMU, in FMI 2.0 and 3.0."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from painleve_sym.c_export.files import StartedCode
from painleve_sym.c_export.fmi_variables import Variable
from painleve_sym.escape import one_line
from painleve_sym.version import __version__

VERSIONS = ("3.0", "2.0")
"""Versions of FMI, the first by default."""
_TOKEN = {"3.0": "instantiationToken", "2.0": "guid"}
_STATES = {"3.0": "FMUState", "2.0": "FMUstate"}
_BASE = {
    "1": {},
    "m": {"m": 1},
    "kg": {"kg": 1},
    "s": {"s": 1},
    "rad": {"rad": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "Hz": {"s": -1},
}
"""Exponents of the base units in units of mechanics."""
_FACTOR = re.compile(r"([A-Za-z]+|1)(?:\^(-?\d+))?")


def description(
    case: StartedCode, version: str, every: Sequence[Variable], token: str, sources: Sequence[str]
) -> bytes:
    """Return the file ``modelDescription.xml``; `sources` are the C files to compile."""
    title = case.simulator.mechanism.title
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": version,
            "modelName": case.name,
            _TOKEN[version]: token,
            "description": one_line("; ".join(filter(None, (title, case.subject)))),
            "generationTool": f"painleve-sym {__version__}",
            "variableNamingConvention": "flat",
        },
    )
    _co_simulation(root, case.name, version, sources)
    _units(root, {v.unit for v in every if not v.whole})
    _types(root, version, every)
    categories = SubElement(root, "LogCategories")
    SubElement(categories, "Category", name="logStatusError", description="why a call failed")
    end, rtol = repr(case.t_end), repr(case.rtol)
    SubElement(root, "DefaultExperiment", startTime="0.0", stopTime=end, tolerance=rtol)
    listed = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(every):
        (_variable_3 if version == "3.0" else _variable_2)(listed, reference, variable)
    _structure(root, version, every)
    return _text(root)


def build_description(name: str, sources: Iterable[str]) -> bytes:
    """Return the file ``sources/buildDescription.xml`` of FMI 3.0."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    build = SubElement(root, "BuildConfiguration", modelIdentifier=name)
    files = SubElement(
        build, "SourceFileSet", language="C99", compilerOptions="-O2 -ffp-contract=off"
    )
    for source in sources:
        SubElement(files, "SourceFile", name=source)
    SubElement(build, "Library", name="m")
    return _text(root)


def _text(root: Element) -> bytes:
    indent(root)
    text: bytes = tostring(root, "UTF-8", xml_declaration=True)
    return text + b"\n"


def _co_simulation(root: Element, name: str, version: str, sources: Sequence[str]) -> None:
    own = SubElement(root, "CoSimulation", modelIdentifier=name)
    own.set("canHandleVariableCommunicationStepSize", "true")
    own.set(f"canGetAndSet{_STATES[version]}", "true")
    own.set(f"canSerialize{_STATES[version]}", "true")
    if version == "2.0":
        own.set("canNotUseMemoryManagementFunctions", "true")
        files = SubElement(own, "SourceFiles")
        for source in sources:
            SubElement(files, "File", name=source)


def unit_name(unit: str) -> str:
    """Return a unit as Modelica writes it.

    >>> unit_name("kg m^2"), unit_name("N s/m")
    ('kg.m2', 'N.s/m')
    """
    return unit.replace("^", "").replace(" ", ".")


def base_units(unit: str) -> dict[str, int] | None:
    """Return the exponents of the base units; None where a part of the unit is not known.

    >>> base_units("N s/m")
    {'kg': 1, 's': -1}
    """
    total: dict[str, int] = {}
    above, slash, below = unit.partition("/")
    parts = [(part, 1) for part in above.split(" ")] + ([(below, -1)] if slash else [])
    for part, sign in parts:
        match = _FACTOR.fullmatch(part)
        known = _BASE.get(match[1]) if match else None
        if match is None or known is None:
            return None
        for base, exponent in known.items():
            power = sign * int(match[2] or 1) * exponent
            total[base] = total.get(base, 0) + power
    return {base: power for base, power in total.items() if power}


def _units(root: Element, units: Iterable[str]) -> None:
    listed = SubElement(root, "UnitDefinitions")
    for name, unit in sorted({unit_name(u): u for u in units}.items()):
        own = SubElement(listed, "Unit", name=name)
        known = base_units(unit)
        if known is not None:
            SubElement(own, "BaseUnit", {base: str(power) for base, power in known.items()})


def _type_name(variable: Variable) -> str:
    return f"{variable.name}_type"


def _types(root: Element, version: str, every: Iterable[Variable]) -> None:
    listed = SubElement(root, "TypeDefinitions")
    for v in every:
        if not v.items:
            continue
        name = _type_name(v)
        if version == "3.0":
            own = SubElement(listed, "EnumerationType", name=name)
        else:
            own = SubElement(SubElement(listed, "SimpleType", name=name), "Enumeration")
        for i, item in enumerate(v.items, 1):
            SubElement(own, "Item", name=item, value=str(i))


def _common(reference: int, v: Variable) -> dict[str, str]:
    common = {"name": v.name, "valueReference": str(reference), "causality": v.causality}
    common["variability"] = v.variability
    if v.causality in ("output", "local"):
        common["initial"] = "calculated" if v.start is None else "exact"
    if v.meaning:
        common["description"] = one_line(v.meaning)
    return common


def _typed(v: Variable) -> dict[str, str]:
    """Return what a number has besides: unit, range, start."""
    own = {} if v.whole else {"unit": unit_name(v.unit)}
    ends = {"min": v.least, "max": v.most}
    own |= {name: repr(end) for name, end in ends.items() if math.isfinite(end)}
    if v.start is not None:
        own["start"] = repr(v.start)
    return own


def _variable_3(listed: Element, reference: int, v: Variable) -> None:
    common = _common(reference, v)
    if v.items:
        SubElement(listed, "Enumeration", common, declaredType=_type_name(v))
    elif v.whole:
        SubElement(listed, "Int64", common)
    else:
        SubElement(listed, "Float64", common | _typed(v))


def _variable_2(listed: Element, reference: int, v: Variable) -> None:
    if v.causality == "independent":
        return
    own = SubElement(listed, "ScalarVariable", _common(reference, v))
    if v.items:
        SubElement(own, "Enumeration", declaredType=_type_name(v))
    else:
        SubElement(own, "Integer" if v.whole else "Real", _typed(v))


def _structure(root: Element, version: str, every: Sequence[Variable]) -> None:
    own = SubElement(root, "ModelStructure")
    outputs = [i for i, v in enumerate(every) if v.causality == "output"]
    unknown = [i for i in outputs if every[i].start is None]
    if version == "3.0":
        for i in outputs:
            SubElement(own, "Output", valueReference=str(i))
        for i in unknown:
            SubElement(own, "InitialUnknown", valueReference=str(i))
        return
    # The independent variable is not listed, so that an index from 1 on is the reference.
    for name, indices in (("Outputs", outputs), ("InitialUnknowns", unknown)):
        listed = SubElement(own, name)
        for i in indices:
            SubElement(listed, "Unknown", index=str(i))
