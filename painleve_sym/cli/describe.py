"""The commands that list what there is: models, laws, materials, automaton."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from painleve_sym.cache import kept_entry
from painleve_sym.cli.case import chosen_law, chosen_mechanism
from painleve_sym.cli.options import checked_format
from painleve_sym.cli.output import number, print_json, show, show_table
from painleve_sym.cli.texts import AUTOMATON_FORMATS, meanings
from painleve_sym.codegen.derivation_cache import FORMULAS, entry_key
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.laws.catalogue import CHOICE_NOTES, LAWS, all_choices, choice_values, one_law
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.laws.restitution import RESTITUTIONS, RestitutionLaw
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.declarations import TIME_NAME, Parameter
from painleve_sym.mechanics.materials import (
    PAIR_PROPERTIES,
    Material,
    MaterialPair,
    MaterialValue,
    material,
)
from painleve_sym.mechanics.materials import materials as known_materials
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import NAMED, title_of
from painleve_sym.plain_data import finite, plain_fields, to_plain
from painleve_sym.quantities import counted
from painleve_sym.references import Reference, cited_works, reference

if TYPE_CHECKING:
    from painleve_sym.automata.automaton import HybridAutomaton, Transition


# ---- models ----


def models(arguments: argparse.Namespace) -> int:
    """List the mechanisms in a line each, or show the named one."""
    if arguments.json:
        names = NAMED if arguments.name is None else [arguments.name]
        print_json({"models": [model_data(model(name)) for name in names]})
    elif arguments.name is None:
        _show_list("mechanisms, the CASE of most commands", {n: title_of(n) for n in NAMED})
        show("`painleve models NAME` shows one: sketch, coordinates, parameters, source")
    else:
        _show_model(model(arguments.name))
    return 0


def _show_list(heading: str, sentences: Mapping[str, str]) -> None:
    first, *others = sentences.items()
    show(heading)
    show_table(first, others, left=(0, 1))
    show()


def model_data(mechanism: Mechanism) -> dict[str, Any]:
    """Return what there is to know of a mechanism as plain data."""
    outline = mechanism.outline
    of_row = {v.row: v for v in outline.velocities}
    velocities = [plain_fields(v, "name", "meaning", "unit") for v in outline.velocities]
    return {
        **plain_fields(mechanism, "name", "title", "source"),
        "references": references_data(mechanism.source),
        "coordinates": [
            {
                **plain_fields(c, "name", "meaning", "unit"),
                "velocity": own.name if (own := of_row.get(c.name)) else None,
                "velocity_unit": own.unit if own else None,
            }
            for c in mechanism.outline.coordinates
        ],
        **({"velocities": velocities} if outline.quaternions else {}),
        "parameters": [parameter_data(p) for p in mechanism.outline.parameters],
        "contacts": [
            plain_fields(c, "name", "gap", "slip_velocity") for c in mechanism.outline.contacts
        ],
        "domain": [plain_fields(b, "margin", "meaning") for b in mechanism.outline.domain],
        "start": dict(mechanism.start),
        "sketch": mechanism.sketch,
    }


def parameter_data(parameter: Parameter) -> dict[str, Any]:
    """Return a parameter as plain data; a bound that does not exist is None."""
    bounds = {"lower": finite(parameter.lower), "upper": finite(parameter.upper)}
    return {**to_plain(parameter), **bounds}


def _show_model(mechanism: Mechanism) -> None:
    show(f"{mechanism.name}: {mechanism.title}")
    show()
    print(mechanism.sketch)
    rows = [(c.name, c.unit, c.meaning) for c in mechanism.outline.coordinates]
    rows += [(v.name, v.unit, v.meaning) for v in mechanism.outline.velocities]
    if mechanism.depends_on_time:
        rows.append((TIME_NAME, "s", "time of what moves as prescribed, at the start"))
    show_table(("state", "unit", "meaning"), rows, left=(0, 1, 2))
    show()
    _show_parameters(mechanism.outline.parameters)
    show()
    for bound in mechanism.outline.domain:
        show(f"  valid while {bound.margin} > 0: {bound.meaning}")
    if mechanism.start:
        start = ",".join(f"{name}={number(value)}" for name, value in mechanism.start.items())
        show(f"  to begin with: --state {start}")
    _show_source(mechanism.source)


def _show_parameters(parameters: Sequence[Parameter]) -> None:
    rows = [(p.name, number(p.default), p.unit, _range(p), p.meaning) for p in parameters]
    head = ("parameter", "default", "unit", "range", "meaning")
    show_table(head, rows, left=(0, 2, 3, 4))


def _range(parameter: Parameter) -> str:
    text = parameter.range_text.removeprefix("a finite number").removeprefix(" with ")
    return text or "any"


# ---- laws ----


def laws(arguments: argparse.Namespace) -> int:
    """List the contact laws and the restitution rules in a line each, or show the named one."""
    if arguments.name is not None:
        return _one_law_or_rule(arguments.name, arguments.json)
    if arguments.json:
        print_json(laws_data())
        return 0
    _show_list("contact laws (--law NAME)", {name: one_law(name).title for name in LAWS})
    rules = {name: law.title for name, law in RESTITUTIONS.items()}
    _show_list("restitution rules (jump --rule NAME, --law rigid)", rules)
    show("`painleve laws NAME` shows one: parameters, choices, source")
    return 0


def _one_law_or_rule(name: str, as_json: bool) -> int:
    if name not in (*LAWS, *RESTITUTIONS):
        raise InputError(
            unknown_name("contact law or restitution rule", name, [*LAWS, *RESTITUTIONS])
        )
    if as_json:
        data = laws_data()
        print_json({key: [one for one in data[key] if one["name"] == name] for key in data})
    elif name in RESTITUTIONS:
        _show_rule(RESTITUTIONS[name])
    else:
        _show_law(one_law(name))
    return 0


# ---- materials ----


def materials(arguments: argparse.Namespace) -> int:
    """List the materials in a line each, or show the named one."""
    named = known_materials()
    if arguments.json:
        chosen = named.values() if arguments.name is None else [material(arguments.name)]
        print_json({"materials": [material_data(m) for m in chosen]})
    elif arguments.name is None:
        _show_list("materials (--material NAME)", {name: m.title for name, m in named.items()})
        show("`painleve materials NAME` shows one: properties, friction and their sources")
    else:
        _show_material(material(arguments.name))
    return 0


def material_data(one: Material) -> dict[str, Any]:
    """Return a material as plain data; a pair lacks what no source gives."""
    return {
        **plain_fields(one, "name", "title", "properties"),
        "pairs": [{"other": pair.other, **to_plain(_given(pair))} for pair in one.pairs],
        "references": [reference_data(reference(key)) for key in _sources(one)],
    }


def _given(pair: MaterialPair) -> dict[str, MaterialValue]:
    """Return the properties of two materials that a source gives."""
    values = {name: getattr(pair, name) for name in PAIR_PROPERTIES}
    return {name: value for name, value in values.items() if value is not None}


def _values(one: Material) -> dict[str, MaterialValue]:
    """Return every number of a material by what it is."""
    of_pairs = {f"{n} with {p.other}": v for p in one.pairs for n, v in _given(p).items()}
    return {**one.properties, **of_pairs}


def _sources(one: Material) -> list[str]:
    """Return the sources of a material, in the order in which its numbers name them."""
    return list(dict.fromkeys(key for value in _values(one).values() for key in value.sources))


def _show_material(one: Material) -> None:
    show(f"{one.name}: {one.title}")
    sources, rows = _sources(one), []
    for name, value in _values(one).items():
        spread = f"{number(value.lower)} to {number(value.upper)}" * (value.lower < value.upper)
        cited = ",".join(str(sources.index(key) + 1) for key in value.sources)
        rows.append((name, number(value.value), spread, value.unit, f"[{cited}]", value.note))
    head = ("property", "value", "range", "unit", "sources", "note")
    show_table(head, rows, left=(0, 2, 3, 4, 5))
    show("  sources:")
    for i, key in enumerate(sources, 1):
        show(f"    [{i}] {reference(key)}")


def _show_law(one: ContactLaw | RigidLaw) -> None:
    show(f"{one.name}: {one.title}")
    _show_parameters(one.parameters)
    explained = meanings()
    for name, default in all_choices(one).items():
        known = choice_values(one, name)
        values = ", ".join(v + " (default)" * (v == default) for v in known)
        meaning = explained.get(name, "").partition(":")[0]
        show(f"  {name}{f' ({meaning})' if meaning else ''}: {values}")
        for value, note in _notes(known).items():
            show(f"    {value} is {note}")
    _show_source(one.source)


def _show_source(source: str) -> None:
    show(f"  source: {source}")
    for work in cited_works(source):
        show(f"    {work}")


def _notes(values: Iterable[str]) -> dict[str, str]:
    """Return what to know about values of a choice, by value."""
    return {v: CHOICE_NOTES[v] for v in values if v in CHOICE_NOTES}


def _show_rule(rule: RestitutionLaw) -> None:
    show("restitution rules (jump): --rule NAME --restitution E")
    show()
    row = (rule.name, rule.parameter.name, number(rule.parameter.default), rule.title)
    show_table(("rule", "coefficient", "default", "law"), [row], left=(0, 1, 3))
    _show_source(rule.source)


def laws_data() -> dict[str, Any]:
    """Return all laws and rules as plain data, from the cache after the first time."""
    data = kept_entry(
        entry_key("laws", by=(*FORMULAS, "cli")),
        lambda: {
            "laws": [law_data(one_law(name)) for name in LAWS],
            "restitution_rules": [rule_data(law) for law in RESTITUTIONS.values()],
        },
    )
    # The cache does not know when the literature changes.
    for one in (*data["laws"], *data["restitution_rules"]):
        one["references"] = references_data(one["source"])
    return data


def law_data(one: ContactLaw | RigidLaw) -> dict[str, Any]:
    """Return a contact law as plain data."""
    return {
        **plain_fields(one, "name", "title", "source"),
        "parameters": [parameter_data(p) for p in one.parameters],
        "choices": {
            name: {"default": default, "values": known, "notes": _notes(known)}
            for name, default in all_choices(one).items()
            for known in [choice_values(one, name)]
        },
        "branches": [b.name for b in one.branches],
    }


def references_data(source: str) -> list[dict[str, Any]]:
    """Return the works that a source cites as plain data."""
    return [reference_data(work) for work in cited_works(source)]


def reference_data(work: Reference) -> dict[str, Any]:
    """Return a work as plain data."""
    return plain_fields(work, "key", "label", "text", "link", "unconfirmed")


def rule_data(rule: RestitutionLaw) -> dict[str, Any]:
    """Return a restitution rule as plain data."""
    return {
        **plain_fields(rule, "name", "title", "source"),
        "parameter": parameter_data(rule.parameter),
        "equation": f"{rule.equation.lhs} = {rule.equation.rhs}",
        "note": rule.note,
    }


# ---- automaton ----


def automaton(arguments: argparse.Namespace) -> int:
    """Print the modes and events of a mechanism with a law."""
    form = checked_format(arguments.format, AUTOMATON_FORMATS)
    mechanism = chosen_mechanism(arguments.model, arguments.contact)
    chosen = chosen_law(arguments.law, arguments.law_set)
    from painleve_sym.motion.simulator import Simulator

    contact = Simulator(mechanism, chosen).contact
    key = entry_key("automaton in words", contact, mechanism.name, by=(*FORMULAS, "cli"))
    data = kept_entry(key, lambda: _written(contact.automaton))
    if form == "json":
        print_json(data["json"])
    elif form == "text":
        _show_automaton(data["json"])
    else:
        print(data[form], end="")
    return 0


def _written(automaton: HybridAutomaton) -> dict[str, Any]:
    """Return what the command prints of an automaton, by the format."""
    return {
        "json": automaton_data(automaton),
        "mermaid": automaton.mermaid(),
        "graphviz": automaton.graphviz(),
    }


def automaton_data(automaton: HybridAutomaton) -> dict[str, Any]:
    """Return modes and transitions as plain data."""
    return {
        "name": automaton.name,
        "states": [str(s) for s in automaton.states],
        "memory": [str(s) for s in automaton.memory],
        "starts": [c.target for c in automaton.starts],
        "modes": [
            {
                "name": mode.name,
                "transitions": [
                    {
                        "kind": t.kind,
                        "guard": "-1" if t.immediate else str(t.guard),
                        "immediate": t.immediate,
                        "contact": t.contact,
                        "targets": _targets(t),
                    }
                    for t in mode.transitions
                ],
            }
            for mode in automaton.modes
        ],
    }


def _targets(transition: Transition) -> list[str]:
    if transition.stop is not None:
        return ["end"]
    return list(dict.fromkeys(c.target for c in transition.choices))


def _show_automaton(automaton: Mapping[str, Any]) -> None:
    show(f"{automaton['name']}: {counted(len(automaton['modes']), 'mode')}")
    show(f"starts in {', '.join(dict.fromkeys(automaton['starts']))}")
    show()
    rows = []
    for mode in automaton["modes"]:
        targets_by_kind: dict[str, list[str]] = {}
        for t in mode["transitions"]:
            targets_by_kind.setdefault(t["kind"], []).extend(t["targets"])
        names = [mode["name"]] + [""] * len(targets_by_kind)
        for name, (kind, targets) in zip(names, targets_by_kind.items(), strict=False):
            rows.append((name, kind, ", ".join(dict.fromkeys(targets))))
    show_table(("mode", "event", "next mode"), rows, left=(0, 1, 2), indent=0)
