"""Mechanisms of many tests, and simulators that share their compiled libraries.

A library is compiled for a mechanism, the laws of its contacts and an engine: what one test has
compiled serves all others that take the same three. So tests take mechanisms and laws from here,
differ in states and parameters, and leave the engine open unless they are about engines.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.laws.catalogue import Law, law
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.simulator import Simulator

EXAMPLES = Path(__file__).parents[1] / "examples" / "mechanisms"
FEET, LADDER = "block-two-feet", "ladder"
TABLE = EXAMPLES / "three-legged-table.toml"

SLED = """
name = "sled"
gravity = "g"
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
m = { default = 2.0, unit = "kg", positive = true }
g = { default = 9.8, unit = "m/s^2" }
mu = { default = 0.3, unit = "1" }
[inputs]
F = { unit = "N", interpolation = "linear" }
u = { unit = "m", meaning = "place of the table", interpolation = "linear" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[forces]
x = "F"
[[contacts]]
name = "table"
point = ["x", "y"]
through = ["u", 0]
friction = "mu"
"""
"""A block that a force pushes on a table that moves, both as inputs."""


@cache
def simulator(
    mechanism: str | Path, laws: str = "rigid", engine: str = "auto", **choices: str
) -> Simulator:
    """Return a simulator, made once in each process.

    `laws` is one name, or names by contact as in ``A=hertz,B=rigid``. Behind a name stands the
    friction where it is not Coulomb's, as in ``linear/static``; `choices` are those of every law.
    """

    def of(text: str) -> Law:
        name, _, friction = text.partition("/")
        return law(name, **choices, **({"friction": friction} if friction else {}))

    pairs = [pair.split("=") for pair in laws.split(",")]
    own = {contact: of(text) for contact, text in pairs} if "=" in laws else of(laws)
    return Simulator(model(str(mechanism)), own, engine)


# ---- mechanism files ----


def parameter(name: str, default: float, unit: str, meaning: str, rule: str = "") -> str:
    """Return the line of a parameter."""
    rule = f", {rule}" if rule else ""
    return f'{name} = {{ default = {default}, unit = "{unit}", meaning = "{meaning}"{rule} }}\n'


def point_mass(
    *, name: str = "block", contact: str = "", parameters: str = "", more: str = ""
) -> str:
    """Return the file of a mass point at x, y whose contact with the ground has friction mu.

    `contact`, `parameters` and `more` are further lines: of the contact, of the parameters, and at
    the end of the file.
    """
    return f"""
name = "{name}"
title = "mass point on level ground"
source = "a test"
gravity = "g"

[coordinates]
x = {{ unit = "m", meaning = "position along the ground" }}
y = {{ unit = "m", meaning = "height" }}

[parameters]
{parameter("m", 2.0, "kg", "mass", "positive = true")}\
{parameter("g", 9.8, "m/s^2", "gravity", "lower = 0")}\
{parameter("mu", 0.4, "1", "friction coefficient")}\
{parameters}
[[bodies]]
name = "block"
mass = "m"
centre = ["x", "y"]

[[contacts]]
name = "ground"
point = ["x", "y"]
friction = "mu"
{contact}
{more}"""


def standing_body(
    feet: Mapping[str, tuple[str, str]],
    *,
    contacts: Mapping[str, str] | None = None,
    parameters: str = "",
    more: str = "",
    **defaults: float,
) -> Mechanism:
    """Return a body on the ground whose contacts have places in its frame and friction mu.

    Its mass centre is at x and y + h; `feet` are the places from there, along the ground and up.
    Parameters are m, J, a (half its width), h, g and mu; `defaults` are other values of theirs.
    `contacts` are further lines of a contact by its name, `parameters` and `more` of the file.
    """
    values = {"m": 2.0, "J": 0.3, "a": 0.4, "h": 0.3, "g": 9.8, "mu": 0.3, **defaults}
    declared = (
        ("m", "kg", "mass", "positive = true"),
        ("J", "kg m^2", "moment of inertia", "positive = true"),
        ("a", "m", "half width", "positive = true"),
        ("h", "m", "height of the mass centre", ""),
        ("g", "m/s^2", "gravity", "lower = 0"),
        ("mu", "1", "friction coefficient", ""),
    )
    own = "".join(parameter(n, values[n], *words) for n, *words in declared)
    lines = _contact_lines(feet, contacts or {})
    text = f"""
gravity = "g"
[coordinates]
x = {{ unit = "m", meaning = "place" }}
y = {{ unit = "m", meaning = "height" }}
theta = {{ unit = "rad", meaning = "tilt" }}
[parameters]
{own}{parameters}
[[bodies]]
name = "body"
mass = "m"
inertia = "J"
angle = "theta"
centre = ["x", "y + h"]
{more}{"".join(lines)}"""
    return mechanism_from_text(text, name="body")


def _contact_lines(feet: Mapping[str, tuple[str, str]], more: Mapping[str, str]) -> Iterable[str]:
    for name, (along, up) in feet.items():
        at = f'point = {{ body = "body", at = ["{along}", "{up}"] }}'
        yield f'[[contacts]]\nname = "{name}"\n{at}\nfriction = "mu"\n{more.get(name, "")}\n'
