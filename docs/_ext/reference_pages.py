"""Reference pages of the site, written from the data of the package before Sphinx reads them.

Commands, options, JSON keys, events, reasons to stop, quantities, choices, mechanisms, laws and the
public names are defined once, in the package; these pages are that data as tables.
"""

from __future__ import annotations

import contextlib
import inspect
import io
import json
import re
import tempfile
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from functools import partial, reduce
from importlib import import_module
from pathlib import Path
from typing import Any

from painleve_sym import choices
from painleve_sym.cli import main
from painleve_sym.cli.commands import COMMANDS
from painleve_sym.cli.describe import laws_data, model_data
from painleve_sym.cli.grammar import Parser, parsers
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.doors import public_names
from painleve_sym.errors import EventKind, StopReason
from painleve_sym.mechanics.models import MODELS
from painleve_sym.mechanics.models import NAMED as MECHANISMS
from painleve_sym.problem.solution import ContactCase
from painleve_sym.quantities import QUANTITIES, quantity

DOCS = Path(__file__).resolve().parents[1]
SCHEMAS = ("mechanism", "scenario", "sweep")

# ---- tables ----


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Return a Markdown table."""
    lines = [list(head), *(map(str, row) for row in rows)]
    cells = [
        " | ".join(re.sub(r"(?<!\\)\|", r"\\|", cell).replace("\n", " ") for cell in line)
        for line in lines
    ]
    return "\n".join(
        [f"| {cells[0]} |", "|---" * len(lines[0]) + "|", *(f"| {c} |" for c in cells[1:]), ""]
    )


def code(text: object) -> str:
    """Return a text as Markdown code, or nothing for an empty one."""
    return f"`{text}`" if str(text) else ""


def _bounds(parameter: Mapping[str, Any]) -> str:
    low, high = parameter["lower"], parameter["upper"]
    if low is None and high is None:
        return "any"
    left = "(−∞" if low is None else f"{'[' if parameter['lower_closed'] else '('}{low:g}"
    right = "∞)" if high is None else f"{high:g}{']' if parameter['upper_closed'] else ')'}"
    return f"{left}, {right}"


def parameters(rows: Iterable[Mapping[str, Any]]) -> str:
    """Return the table of parameters: name, default, unit, range, meaning."""
    return table(
        ("parameter", "default", "unit", "range", "meaning"),
        [(code(p["name"]), f"{p['default']:g}", p["unit"], _bounds(p), p["meaning"]) for p in rows],
    )


# ---- pages of tables ----


def events() -> str:
    """Return the table of the kinds of events."""
    return table(("kind", "meaning"), [(code(kind.value), kind.sentence) for kind in EventKind])


def stop_reasons() -> str:
    """Return the table of reasons to stop, each with its advice."""
    rows = [(code(reason.label), reason.sentence) for reason in StopReason]
    return table(("reason", "meaning, and what may help"), rows)


def quantities() -> str:
    """Return the table of the registered quantities."""
    rows = [(code(n), f"${q.latex}$" if q.latex else "", q.unit or "as the law", q.meaning)
            for n, q in QUANTITIES.items()]  # fmt: skip
    return table(("name", "symbol", "unit", "meaning"), rows)


def contact_cases() -> str:
    """Return the table of the cases of the contact problem."""
    return table(("case", "meaning"), [(code(case.value), case.sentence) for case in ContactCase])


def attribute_sentences(kind: type) -> dict[str, str]:
    """Return the text after each attribute of a class, which documents it."""
    source = inspect.getsource(kind)
    texts = re.findall(r'^    (\w+) = .*?\n    """(.*?)"""', source, re.M | re.S)
    return {name: " ".join(text.split()) for name, text in texts}


def named_choices() -> str:
    """Return one table per enumeration that a caller may give as a text."""
    parts = []
    for name in ("Restitution", "Policy", "Reload", "Friction", "Record", "EngineName"):
        kind = getattr(choices, name)
        sentences = attribute_sentences(kind)
        summary = inspect.getdoc(kind)
        rows = [(code(member.value), sentences[member.name]) for member in kind]
        parts.append(f"## `{name}`\n\n{summary}\n\n{table(('value', 'meaning'), rows)}")
    return "\n".join(parts)


def mechanisms() -> str:
    """Return one section per named mechanism: sketch, coordinates, parameters, start, source."""
    return "\n".join(_mechanism(model_data(model(name))) for name in MECHANISMS)


def _mechanism(data: Mapping[str, Any]) -> str:
    coordinates = table(
        ("coordinate", "unit", "meaning"),
        [(code(c["name"]), c["unit"], c["meaning"]) for c in data["coordinates"]],
    )
    start = ", ".join(f"`{k}` = {v:g}" for k, v in data["start"].items())
    domain = "".join(f"- valid while `{d['margin']}` > 0: {d['meaning']}\n" for d in data["domain"])
    return (
        f"## `{data['name']}`\n\n{data['title']}.\n\n```text\n{data['sketch'].rstrip()}\n```\n\n"
        f"{coordinates}\n{parameters(data['parameters'])}\n{domain}"
        f"- start: {start or 'none'}\n- source: {data['source']}\n"
    )


def laws() -> str:
    """Return one section per contact law and one for the restitution rules."""
    data, parts = laws_data(), []
    for law in data["laws"]:
        options = "".join(
            f"- `{name}`: "
            + ", ".join(f"`{v}`{' (default)' * (v == o['default'])}" for v in o["values"])
            + "\n"
            for name, o in law["choices"].items()
        )
        own = parameters(law["parameters"]) if law["parameters"] else ""
        parts.append(
            f"## `{law['name']}`\n\n{law['title']}.\n\n{own}\n{options}- source: {law['source']}\n"
        )
    rows = [
        (code(r["name"]), code(r["parameter"]["name"]), code(r["equation"]), r["note"], r["source"])
        for r in data["restitution_rules"]
    ]
    head = ("rule", "coefficient", "equation", "note", "source")
    return "\n".join([*parts, "## Restitution rules", "", table(head, rows)])


# ---- commands ----


def commands() -> str:
    """Return one section per command: its use, its options and the rest of its help."""
    _, sub = parsers()
    listed = table(("command", "purpose"), [(f"[`{n}`](#painleve-{n})", c.summary)
                                          for n, c in COMMANDS.items()])  # fmt: skip
    return "\n".join([listed, *(_command(name, sub[name]) for name in COMMANDS)])


def _command(name: str, parser: Parser) -> str:
    rows = []
    for action in parser._actions:
        if action.dest == "help":
            continue
        names = ", ".join(action.option_strings) or str(action.metavar)
        value = f" {action.metavar}" if action.option_strings and action.nargs != 0 else ""
        if action.choices and not action.metavar:
            value = " " + "|".join(map(str, action.choices))
        repeated = " (may be given several times)" * (type(action).__name__ == "_AppendAction")
        required = " (required)" * (action.required and bool(action.option_strings))
        rows.append((code(names + value), f"{action.help}{repeated}{required}"))
    epilog = f"```text\n{parser.epilog.strip()}\n```\n" if parser.epilog else ""
    return (
        f"(painleve-{name})=\n## `painleve {name}`\n\n{(parser.description or '').strip()}\n\n"
        f"{table(('argument', 'meaning'), rows)}\n{epilog}"
    )


# ---- JSON ----

TABLE_3 = "theta=1,theta_dot=1,x_A_dot=-1"
TABLE_4 = "theta=1,theta_dot=5,x_A_dot=-1"
STRIBECK = """\
model = "rod"
[law]
name = "hertz"
friction = "stribeck"
"""
SWEEP = """\
model = "rod"
t_end = 0.01
state = { theta_dot = 1.0, x_A_dot = -1.0 }
law = "bilinear-hertz"
keep = ["theta_dot"]
[axes]
theta = [0.9, 1.0]
"""
ROBOT = (
    "examples/robots/quadruped.urdf --contact LF_foot --pose standing --set mu=2 "
    "--contact-velocity 0,1,0"
)
OUTPUTS: Mapping[str, tuple[str, ...]] = {
    "models": ("models", "models examples/mechanisms/tumbling-brick.toml"),
    "laws": ("laws",),
    "materials": ("materials",),
    "derive": ("derive rod",),
    "classify": (
        f"classify rod --state {TABLE_4}",
        "classify cart-pendulum --state phi=2.9 --set F=-10",
        "classify painleve-klein",
        "classify block-two-feet",
        "classify rod-3d --state theta=1,theta_dot=5,x_A_dot=-1",
        f"classify {ROBOT}",
        "classify {folder}/stribeck.toml",
    ),
    "jump": (
        f"jump rod --state {TABLE_3} --law bilinear-hertz",
        "jump painleve-klein",
        "jump rod-3d --state theta=1,x_A_dot=-1,y_A_dot=0.1",
        f"jump {ROBOT}",
    ),
    "simulate": (
        f"simulate rod --state {TABLE_3} --law bilinear-hertz --t-end 1e-3 --samples 3",
        "simulate rod --law hertz --material steel --t-end 1e-3",
        f"simulate rod --state {TABLE_4} --law rigid --t-end 0.1",
        "simulate block-two-feet --state y_A=0.001 --law rigid --t-end 0.1",
        f"simulate rod --state {TABLE_3} --law hertz --t-end 1e-3 --phases 5e-4:mu=1",
        "simulate rod --state theta=0.9095,theta_dot=0.665,x_A_dot=0.674,y_A_dot=-1 "
        "--set mu=0.827 --law rigid --law-set restitution=newton,e_newton=0.9 --t-end 1e-3",
    ),
    "animate": ("animate rod --law rigid --t-end 0.01 --duration 1 --out {folder}/rod.gif",),
    "explore": ("explore rod --out {folder}/rod.html",),
    "map": (
        "map rod --over theta,theta_dot --points 9 --out {folder}/map.json",
        "map rod-3d --over theta,theta_dot --points 9 --out {folder}/map-3d.json",
    ),
    "critical": (f"critical rod --state {TABLE_4} --gradient mu",),
    "sweep": ("sweep {folder}/sweep.toml --out {folder}/sweep.npz",),
    "contrast": (
        f"contrast rod --state {TABLE_3}",
        f"contrast rod-3d --state {TABLE_3}",
        f"contrast {ROBOT}",
    ),
    "fit": ("fit examples/studies/fit/force.csv rod --state theta=1,theta_dot=1,x_A_dot=-1,"
            "y_A_dot=-0.02 --law bilinear-hertz --estimate mu",),
    "robot": ("robot examples/robots/quadruped.urdf --contact LF_foot --pose standing --mu 2 "
              "--poses 50",
              "robot examples/robots/desk_arm.xml --contact finger --mu 1 --poses 9 "
              "--torques yaw=1 --trajectory examples/robots/motion.csv",
              "robot examples/robots/desk_arm.xml --contact finger --mu 0.3 --certify "
              "--over pitch=0.2:0.4 --out {folder}/arm.json",
              "robot examples/robots/desk_arm.xml --contact finger --mu 9 --certify "
              "--over pitch=0.2:0.4",
              "robot examples/robots/desk_arm.xml --contact finger --mu 0.3 --certify "
              "--over pitch=0.2:0.4 --check {folder}/arm.json"),
    "certify": ("certify rod --over theta=0.2:1.4 --set mu=1.3 --out {folder}/rod.json",
                "certify rod --over theta=0.2:1.4 --set mu=1.4",
                "certify rod --over theta=0.2:1.4 --set mu=1.3 --check {folder}/rod.json"),
    "export": (
        "export rod --law rigid --t-end 1e-3 --inputs mu --out {folder}/rod-c",
        "export rod --law rigid --fmu --out {folder}/rod.fmu",
    ),
    "automaton": ("automaton rod --law hertz",),
    "cache": ("cache",),
    "reproduce": ("reproduce --only table-1",),
}  # fmt: skip
"""Calls whose output together has the keys of each command."""
NAMED = {
    **dict.fromkeys(("state", "start", "velocity", "velocities"), "STATE"),
    **dict.fromkeys(("parameters",), "PARAMETER"),
    **dict.fromkeys(("formulas",), "FORMULA"),
    **dict.fromkeys(("contacts",), "CONTACT"),
    **dict.fromkeys(("gradient", "joints", "noise", "others", "armature"), "NAME"),
    **dict.fromkeys(("cases", "counts"), "CASE"),
}
"""Keys whose value maps names of the mechanism to values, and what stands for such a name."""


def call(words: str) -> dict[str, Any]:
    """Return the JSON that a command prints; raise RuntimeError where it fails."""
    printed, faults = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(faults):
        status = main([*words.split(), "--json"])
    # A claim that is refuted is an answer, too.
    if status and not printed.getvalue():
        raise RuntimeError(f"painleve {words}: {faults.getvalue()}")
    answer: dict[str, Any] = json.loads(printed.getvalue())
    return answer


def paths(value: object, where: str = "") -> Iterator[tuple[str, object]]:
    """Yield the path and value of every key; ``[]`` marks the entries of a list."""
    if isinstance(value, dict):
        stand_in = NAMED.get(where.rpartition(".")[2])
        for key, inner in value.items():
            place = f"{where}.{stand_in or key}" if where else key
            yield place, inner
            yield from paths(inner, place)
    elif isinstance(value, list):
        for inner in value:
            if isinstance(inner, dict | list):
                yield from paths(inner, f"{where}[]")


def kind_of(value: object) -> str:
    """Return the JSON type of a value in words."""
    for kind, words in ((bool, "true or false"), (str, "text"), (dict, "object"), (list, "list")):
        if isinstance(value, kind):
            return words
    return "null" if value is None else "number"


def json_keys() -> dict[str, str]:
    """Return a page of keys for each command, from what the commands print.

    KeyError where a key has no meaning in ``docs/reference/json-meanings.toml``.
    """
    file = DOCS / "reference" / "json-meanings.toml"
    meanings: dict[str, dict[str, str]] = tomllib.loads(file.read_text("utf-8"))
    pages = {}
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(DOCS.parent):
        (Path(folder) / "sweep.toml").write_text(SWEEP, "utf-8")
        (Path(folder) / "stribeck.toml").write_text(STRIBECK, "utf-8")
        for command, calls in OUTPUTS.items():
            keys = keys_of([words.format(folder=folder) for words in calls])
            known = {**meanings["every"], **meanings.get(command, {})}
            rows = [_row(path, *entry, known) for path, entry in keys.items()]
            shown = "\n".join(f"painleve {words} --json" for words in calls)
            shown = shown.replace("{folder}/", "")
            pages[command] = (
                f"# JSON keys of `{command}`\n\nThe keys of\n\n```text\n{shown}\n```\n\n"
                + table(("key", "type", "example", "meaning"), rows)
            )
    return pages


def keys_of(calls: Iterable[str]) -> dict[str, tuple[set[str], object]]:
    """Return the types of every key that calls print, and the first plain value."""
    keys: dict[str, tuple[set[str], object]] = {}
    for words in calls:
        for path, value in paths(call(words)):
            kinds, example = keys.setdefault(path, (set(), None))
            kinds.add(kind_of(value))
            if example is None and not isinstance(value, dict | list):
                keys[path] = (kinds, value)
    return keys


def _row(
    path: str, kinds: set[str], example: object, meanings: Mapping[str, str]
) -> tuple[str, str, str, str]:
    last = path.rpartition(".")[2].removesuffix("[]")
    registered = quantity(last)
    meaning = meanings.get(last) or (
        f"{registered.meaning}, {registered.unit or 'unit of the law'}" if registered else ""
    )
    if not meaning:
        raise KeyError(f"{path}: no meaning in docs/reference/json-meanings.toml")
    text = json.dumps(example, ensure_ascii=False) if example is not None else ""
    # Long texts and places of this machine say nothing to a reader.
    if len(text) > 40 or "\\" in text or tempfile.gettempdir() in text or str(Path.home()) in text:
        text = ""
    types = sorted(kinds - {"null"}) + ["null"] * ("null" in kinds)
    return code(path), ", ".join(types), code(text), meaning


# ---- TOML ----


def schema_table(name: str) -> str:
    """Return the keys of a kind of file, from its JSON Schema."""
    schema = json.loads((DOCS / "schemas" / f"{name}.schema.json").read_text("utf-8"))
    rows = list(_schema_rows(schema, schema, ""))
    return table(("key", "value", "meaning"), rows)


def _schema_rows(schema: Any, part: Any, where: str) -> Iterator[tuple[str, str, str]]:
    part = _resolved(schema, part)
    for key, inner in part.get("properties", {}).items():
        whole = {**_resolved(schema, inner), **inner}
        place = f"{where}{key}"
        yield code(place), _schema_type(schema, whole), whole.get("description", "")
        variants = [whole, *whole.get("oneOf", []), *whole.get("anyOf", [])]
        for variant in (_resolved(schema, v) for v in variants):
            if "properties" in variant:
                yield from _schema_rows(schema, variant, f"{place}.")
            if isinstance(variant.get("additionalProperties"), dict):
                of_name = _resolved(schema, variant["additionalProperties"])
                yield from _schema_rows(schema, of_name, f"{place}.NAME.")
            if isinstance(variant.get("items"), dict):
                yield from _schema_rows(schema, variant["items"], f"{place}[].")


def _resolved(schema: Any, part: Any) -> Any:
    while "$ref" in part:
        keys = part["$ref"].split("/")[1:]
        part = reduce(lambda inner, key: inner[key], keys, schema)
    return part


def _schema_type(schema: Any, part: Any) -> str:
    if "enum" in part:
        return " or ".join(code(v) for v in part["enum"])
    variants = part.get("oneOf") or part.get("anyOf") or part.get("allOf")
    if variants:
        texts = [_schema_type(schema, _resolved(schema, v)) for v in variants]
        return " or ".join(dict.fromkeys(texts))
    if part.get("type") == ["string", "number"]:
        return "formula"
    words = {"object": "table", "string": "text", "array": "list", "boolean": "true or false"}
    return words.get(part["type"], part["type"])


# ---- the Python interface ----


def python_bases() -> str:
    """Return the bases of public classes whose members are not shown: those of Python."""
    public = [getattr(import_module(door), name) for name, door in public_names().items()]
    bases = {base for kind in public if inspect.isclass(kind) for base in kind.__mro__}
    return ", ".join(sorted(b.__name__ for b in bases if not b.__module__.startswith("painleve")))


def resolve(app: Any, env: Any, node: Any, content: Any) -> Any:
    """Link a name of the package to its public page; show other names of Python as code.

    Annotations name the module that defines a class, and docstrings name parameters, attributes
    and names of other libraries in the same way.
    """
    if node.get("refdomain") != "py":
        return None
    target = node["reftarget"].removeprefix("painleve_sym.")
    last = target.rpartition(".")[2]
    public = public_names()
    for candidate in (target, last):
        head = candidate.partition(".")[0]
        if head in public:
            domain = env.get_domain("py")
            full = f"{public[head]}.{candidate}"
            if full in domain.objects:
                page = node["refdoc"]
                return domain.resolve_xref(env, page, app.builder, "obj", full, node, content)
    return content


# ---- all of them ----

TABLES = {
    "events": events,
    "stop-reasons": stop_reasons,
    "quantities": quantities,
    "contact-cases": contact_cases,
    "choices": named_choices,
    "mechanisms": mechanisms,
    "laws": laws,
    "commands": commands,
    **{f"{name}-file": partial(schema_table, name) for name in SCHEMAS},
}


def write(folder: Path) -> None:
    """Write every generated page and table, each only where it changed."""
    for name, make in TABLES.items():
        _write(folder / f"{name}.md", make())
    for command, text in json_keys().items():
        _write(DOCS / "reference" / "json" / f"{command}.md", text)
    for name in SCHEMAS:
        text = (DOCS / "schemas" / f"{name}.schema.json").read_text("utf-8")
        _write(folder / "site" / "schemas" / f"{name}.schema.json", text)
    _write(folder / "explorer.md", explorer(folder / "site" / "explorer"))


def explorer(folder: Path) -> str:
    """Write the explorer page of every mechanism that can be compiled here; return links."""
    folder.mkdir(parents=True, exist_ok=True)
    rows, left_out = [], []
    for name in MODELS:
        try:
            answer = call(f"explore {name} --docs .. --out {folder / name}.html")
        except RuntimeError as error:
            if "no compiler for WebAssembly" not in str(error):
                raise
            left_out.append(name)
            continue
        link = f'<a href="../explorer/{name}.html">{name}</a>'
        rows.append((link, model(name).title, f"{answer['bytes'] / 1000:.0f} kB"))
    note = (
        f"\nWithout a compiler for WebAssembly these were left out: {', '.join(left_out)}.\n"
        if left_out
        else ""
    )
    return table(("page", "mechanism", "size"), rows) + note


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text("utf-8") != text:
        path.write_text(text, "utf-8")
