"""Inputs of the fuzz campaign: command lines with the files they read, made from a seed.

An input is plain data, so that one that finds a fault is kept as it is in `corpus`.
"""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

from tests.study.sweep_cases import SMALL

ROOT = Path(__file__).resolve().parents[2]
CORPUS = Path(__file__).with_name("corpus")
CANARY = "painleve_canary"
"""A built-in function of the worker that tells when text of an input is executed."""


@dataclass(frozen=True)
class FuzzInput:
    """One call of the program.

    Attributes
    ----------
    kind : str
        What is varied: one of `KINDS`.
    arguments : tuple of str
        Of the command, run in a folder of its own.
    files : dict of str to bytes
        By name, in that folder.
    damage : tuple of (int, int, int)
        What happens to the files of a store before (`store_damaged`): a number that chooses the
        file, one that chooses the byte, and what is done to it.
    """

    kind: str
    arguments: tuple[str, ...]
    files: dict[str, bytes] = field(default_factory=dict)
    damage: tuple[tuple[int, int, int], ...] = ()

    def to_text(self) -> str:
        """Return JSON."""
        files = {}
        for name, content in self.files.items():
            try:
                files[name] = {"text": content.decode()}
            except UnicodeDecodeError:
                files[name] = {"base64": base64.b64encode(content).decode()}
        data = {"kind": self.kind, "arguments": self.arguments, "files": files}
        return json.dumps(data | ({"damage": self.damage} if self.damage else {}), indent=1)

    @classmethod
    def from_text(cls, text: str) -> FuzzInput:
        """Return the input of JSON."""
        data = json.loads(text)
        files = {
            n: f["text"].encode() if "text" in f else base64.b64decode(f["base64"])
            for n, f in data["files"].items()
        }
        damage = tuple(tuple(d) for d in data.get("damage", ()))
        return cls(data["kind"], tuple(data["arguments"]), files, damage)


def input_of(kind: str, seed: int) -> FuzzInput:
    """Return the input of a kind and a seed; always the same."""
    return KINDS[kind](Random(f"{kind} {seed}"))


# ---- pieces ----

NUMBERS = (
    *("0", "1", "-1", "0.5", "2", "1e-3", "3.14159", "0.333", "-0.0", "1e16", "1e-12"),
    *("1e100", "1e-100", "1e154", "1e200", "-1e200", "1e300", "1e-300", "1e308", "1.7e308"),
    *("5e-324", "1e309", "nan", "inf", "-inf", "1e", "1_000", "0x10", "١", "", " ", "1,2"),
    *("9" * 400, "0." + "3" * 400, "true", "1j", "--1", "+1", "1e+5", ".5", "5.", "infinity"),
)
NASTY = (
    *("\0", "\n", "\r\n", "\t", "\\", "'", '"', '"""', "'''", "#", "=", ",", ";", "%s", "{}"),
    *("[", "]", "[[", "]]", "{", "}", "(", ")", ".", "..", "../", "/dev/null", "~", "$HOME", "*"),
    *("é", "ﬀ", "\u202e", "\U0001f600", "\ufeff", "\x7f", "\x1b[31m", "\u2028", "x" * 5000),
    *(f"{CANARY}()", f"__import__('builtins').{CANARY}()", "().__class__", "lambda: 1", "9**9**9"),
    f"cbuiltins\n{CANARY}\n(tR.",
)
FORMULAS = (
    *("x**0.333", "x**2.71828", "x**40", "x**-3.7", "(x**40+x+1)**0.5", "((x+y)**20)**0.3"),
    *("2**0.333", "log(log(x**2+2))", "abs(sin(t))", "0.1234567890123456*x", "x_dot", "True"),
    *("exp(x)", "exp(1000*x)", "exp(exp(x))", "exp(-1/x**2)", "log(x)", "sqrt(x)"),
    *("sin(sin(sin(x)))", "tan(x)", "atan2(y, x)", "atan2(x, x)", "abs(x)", "abs(x*y)"),
    *("x/y", "1/(x-x)", "(x+y)/(x-y)", "x*1e90", "x*1e-90", "x*1e308"),
    *("t", "sin(1e9*t)", "t*x", "pi", "0", "1", "m", "mu", "x*y*theta", "(" * 30 + "x" + ")" * 30),
    *("x" + "+x" * 300, "*".join(["(x+y)"] * 12), "sin(x)**12*cos(y)**13", "x^2", "x.real", "2x"),
)
KEYS = ("theta", "theta_dot", "x", "y", "x_A", "y_A", "x_A_dot", "y_A_dot", "phi", "t", "mu", "m")


def number(r: Random) -> str:
    """Return a number as text: usual ones more often than extreme ones."""
    if r.random() < 0.5:
        return f"{r.uniform(-2, 2):.4g}"
    if r.random() < 0.6:
        return f"{r.choice((1, -1)) * 10 ** r.uniform(-310, 308):.3g}"
    return r.choice(NUMBERS)


def mutated(r: Random, text: str, tokens: tuple[str, ...]) -> str:
    """Return the text with a few changes: of characters, tokens, numbers or lines."""
    for _ in range(r.choice((1, 1, 1, 2, 3, 6))):
        place, end = sorted((r.randint(0, len(text)), r.randint(0, len(text))))
        end = min(end, place + r.choice((1, 1, 3, 10, 80)))
        lines = text.split("\n")
        match r.choice((*range(8), *[4] * 8)):
            case 0:
                text = text[:place] + text[end:]
            case 1:
                text = text[:place] + r.choice(NASTY) + text[place:]
            case 2:
                text = text[:place] + r.choice(tokens) + text[end:]
            case 3:
                text = text[:place] + text[place:end] * r.choice((2, 3, 50, 3000)) + text[end:]
            case 4:
                text = _with_another_number(r, text)
            case 5:
                i, j = r.randrange(len(lines)), r.randrange(len(lines))
                lines[i], lines[j] = lines[j], lines[i]
                text = "\n".join(lines)
            case 6 | 7:
                i = r.randrange(len(lines))
                lines[i : i + 1] = [lines[i]] * r.choice((0, 2, 40))
                text = "\n".join(lines)
    return text[:400_000]


def _with_another_number(r: Random, text: str) -> str:
    digits = [i for i, c in enumerate(text) if c.isascii() and c.isdigit()]
    if not digits:
        return text
    first = last = r.choice(digits)
    while last < len(text) and (text[last].isdigit() or text[last] in ".e"):
        last += 1
    return text[:first] + number(r) + text[last:]


def as_bytes(r: Random, text: str) -> bytes:
    """Return UTF-8, sometimes with a byte changed or cut."""
    content = bytearray(text.encode("utf-8", "surrogatepass"))
    if content and r.random() < 0.05:
        content[r.randrange(len(content))] ^= 1 << r.randrange(8)
    if r.random() < 0.02:
        del content[r.randrange(len(content) + 1) :]
    return bytes(content)


# ---- command lines ----

MODELS = (
    *("rod", "rod-inertia", "block", "block-two-feet", "eccentric-disc", "cart-pendulum"),
    *("two-link-arm", "pr-robot", "strut", "painleve-klein", "rod-bending:1,0"),
)
LAWS = ("bilinear-hertz", "bilinear-hertz-two-bodies", "hertz", "hunt-crossley", "linear", "rigid")
STARTS = {
    "rod": "theta=1,theta_dot=1,x_A_dot=-1",
    "rod-inertia": "theta=1,theta_dot=1,x_A_dot=-1",
    "rod-bending:1,0": "theta=1,theta_dot=1,x_A_dot=-1",
    "block": "theta=0.5,x_A_dot=-1",
    "block-two-feet": "x_A_dot=-1",
    "pr-robot": "theta=0.927295,x_dot=-1",
    "strut": "theta=0.927295",
    "two-link-arm": "theta_1=-0.6435011087932844,theta_2=-0.9272952180016122",
    "painleve-klein": "phi=1.2,x_dot=1",
    "cart-pendulum": "phi=2.5,x_dot=1",
    "eccentric-disc": "phi=0.5,x_dot=-1",
}
BOUNDS = ("--max-steps", "300", "--max-events", "40")
"""Of motions, so that an input takes long only where it should not."""


def _state(r: Random, model: str) -> str:
    pairs = dict(p.split("=") for p in STARTS.get(model, "x_dot=-1").split(","))
    for _ in range(r.choice((0, 0, 1, 1, 2, 4))):
        pairs[r.choice(tuple(pairs) if r.random() < 0.9 else KEYS)] = number(r)
    return ",".join(f"{k}={v}" for k, v in pairs.items())


def _settings(r: Random, names: tuple[str, ...]) -> str:
    return ",".join(f"{r.choice(names)}={number(r)}" for _ in range(r.choice((1, 1, 2))))


def _law(r: Random) -> list[str]:
    words = ["--law", r.choice(LAWS)]
    if r.random() < 0.4:
        names = ("E", "nu", "R", "n", "E", "n", "l_0", "e_energetic", "e_newton", "c", "k")
        words += ["--law-set", _settings(r, names)]
    return words


def _look(r: Random) -> list[str]:
    looks = (("--width", number(r)), ("--title", "none"), ("--format", "pdf"), ("--width", "page"))
    return [*r.choice(((), *looks))]


def _command_words(r: Random) -> list[str]:
    model = r.choice(("rod", "rod", "rod", *MODELS))
    words = {
        "classify": lambda: ["classify", model, "--state", _state(r, model)],
        "jump": lambda: ["jump", model, "--state", _state(r, model)],
        "simulate": lambda: [
            *("simulate", model, "--state", _state(r, model), *_law(r), *BOUNDS),
            *("--t-end", r.choice(("1e-3", "0.01", number(r)))),
        ],
        "map": lambda: [
            *("map", model, "--over", r.choice(("theta,mu", "theta,theta_dot", "mu,theta", "x,y"))),
            *("--points", r.choice(("2", "9", "21"))),
        ],
        "critical": lambda: [
            *("critical", "rod", "--state", _state(r, "rod").replace("dot=1", "dot=5")),
        ],
        "automaton": lambda: ["automaton", model, *_law(r)],
        "models": lambda: ["models"],
        "laws": lambda: ["laws"],
        "contrast": lambda: ["contrast", "rod", "--state", _state(r, "rod"), "--t-end", "1e-3"],
        "reproduce": lambda: ["reproduce", "--only", r.choice(NASTY), *_look(r)],
        "animate": lambda: [
            *("animate", model, "--state", _state(r, model), *_law(r), *BOUNDS),
            *("--t-end", r.choice(("1e-3", number(r))), "--duration", r.choice(("1", number(r)))),
            *("--width", r.choice(("200", number(r))), "--out", r.choice(("o.gif", "o.html"))),
        ],
        "explore": lambda: [
            *("explore", model, "--state", _state(r, model), *r.choice(((), _law(r)))),
            *("--t-end", number(r), "--out", r.choice(("o.html", "o.htm", r.choice(NASTY)))),
        ],
        "derive": lambda: ["derive", r.choice(("rod", "block")), *r.choice(((), ("--json",)))],
    }
    weights = {"classify": 30, "jump": 20, "simulate": 25, "map": 6, "critical": 4, "automaton": 2}
    weights |= {"animate": 2, "explore": 3}
    name = r.choices(tuple(words), [weights.get(n, 1) for n in words])[0]
    made_words = words[name]()
    plain = ("models", "laws", "automaton", "contrast", "reproduce", "derive")
    if name not in plain and r.random() < 0.4:
        made_words += ["--set", _settings(r, ("m", "l", "g", "mu") if r.random() < 0.8 else KEYS)]
    if name == "jump" and r.random() < 0.5:
        made_words += ["--restitution", number(r)]
    if name == "jump" and r.random() < 0.3:
        made_words += _law(r)
    if name == "map" and r.random() < 0.5:
        made_words += ["--range", f"{r.choice(('theta', 'mu', 'x'))}={number(r)}:{number(r)}"]
    if name == "simulate" and r.random() < 0.3:
        options = ("--rtol", "--initial-force", "--samples")
        made_words += [r.choice(options), number(r)]
    if r.random() < 0.4:
        made_words += ["--json"]
    return made_words


def command(r: Random) -> FuzzInput:
    """Return a command line without files."""
    words = _command_words(r)
    for _ in range(r.choice((0, 0, 0, 0, 0, 1, 2))):
        i = r.randrange(len(words))
        match r.randrange(4):
            case 0:
                del words[i]
            case 1:
                words.insert(i, r.choice((*NASTY, *NUMBERS, "--json", "--help", "--", "--out")))
            case 2:
                words[i] = mutated(r, words[i], NUMBERS)
            case 3:
                words[i], words[-1] = words[-1], words[i]
        words = words or ["classify"]
    # The system passes no null byte, and lines of some length.
    return FuzzInput("command", tuple(w.replace("\0", "")[:100_000] for w in words))


# ---- files ----

_MECHANISM = """\
name = "fuzz"
gravity = "9.8"
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
theta = { unit = "rad" }
[parameters]
m = { default = 2.0, unit = "kg", positive = true }
l = { default = 0.5, unit = "m", positive = true }
mu = { default = 0.5, unit = "1" }
[definitions]
c = "l*cos(theta)"
[[bodies]]
mass = "m"
centre = ["x", "y"]
inertia = "m*l**2/3"
angle = "theta"
[[springs]]
extension = "x"
stiffness = "m*10"
damping = "m"
[[contacts]]
name = "A"
point = ["x - c", "y - l*sin(theta)"]
friction = "mu"
[start]
theta = 1.0
y = 0.42073549240394825
x_dot = -1.0
"""
_SMALL_MECHANISM = """\
gravity = "9.8"
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
m = { default = 2.0, unit = "kg", positive = true }
mu = { default = 0.5, unit = "1" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[[contacts]]
name = "A"
point = ["x", "y"]
friction = "mu"
"""
_EXAMPLES = ("bead-in-groove", "belt-oscillator", "wheel-on-slope", "oscillating-table", "rod")
_TOML = (
    *("[coordinates]", "[[bodies]]", "[[contacts]]", "[start]", "[definitions]", "[forces]"),
    *("mass", "centre", "point", "friction", "curve", "slope", "disc", "gap", "slip_velocity"),
    *('"x"', '["x", "y"]', "{ unit = 'm' }", "true", "1979-05-27", "0xffffffffffffffffffff"),
    *("a.b.c", "x = 1\n", "unit = 'm'", "default = 1", "bilateral = true", "through = ['t', 0]"),
    *FORMULAS,
)


def mechanism(r: Random) -> FuzzInput:
    """Return a mechanism file that is changed, or whose formulas are."""
    choice = r.random()
    if choice < 0.4:
        text = _SMALL_MECHANISM
    elif choice < 0.8:
        text = _MECHANISM
    else:
        text = (ROOT / f"examples/mechanisms/{r.choice(_EXAMPLES)}.toml").read_text("utf-8")
    if r.random() < 0.5:
        quoted = [i for i, part in enumerate(text.split('"')) if i % 2]
        parts = text.split('"')
        for i in r.sample(quoted, r.choice((1, 1, 2))):
            form = r.choice(("{}", "{} + {}", "{}*{}", "({})**2"))
            parts[i] = form.replace("{}", r.choice(FORMULAS))
        text = '"'.join(parts)
    else:
        text = mutated(r, text, _TOML)
    state = ["--state", r.choice(("x=1,x_dot=-1", "theta=1,y=0.42073549240394825,x_dot=-1", "x=0"))]
    words = r.choices(
        (["classify", "f.toml", *state], ["jump", "f.toml", *state],
         ["map", "f.toml", "--over", "x,mu", "--points", "5"], ["derive", "f.toml"],
         ["simulate", "f.toml", *state, "--law", "hertz", "--t-end", "1e-3", *BOUNDS]),
        (70, 20, 5, 3, 2),
    )[0]  # fmt: skip
    return FuzzInput("mechanism", tuple(words), {"f.toml": as_bytes(r, text)})


_SCENARIO = """\
model = "rod"
t_end = 0.001
until = ["separation"]
state = { theta = 1.0, theta_dot = 1.0, x_A_dot = -1.0 }
parameters = { mu = 1.4 }
max_steps = 300
max_events = 40
[law]
name = "bilinear-hertz"
reload = "virgin"
parameters = { E = 20.9e14, e_energetic = 0.75 }
"""
_SCENARIO_TOKENS = (
    *("title", "contact", "initial_force = 1", "engine = 'erk'", "rtol = 1e-3", "samples = 5"),
    *("restitution = 0.5", "rule = 'newton'", "model = { name = 'rod' }", "nan", "inf", "[]", "{}"),
)


def scenario(r: Random) -> FuzzInput:
    """Return a scenario file that is changed."""
    text = mutated(r, _SCENARIO, _SCENARIO_TOKENS)
    name = r.choices(("classify", "simulate", "jump"), (2, 3, 2))[0]
    bounds = BOUNDS if name == "simulate" else ()
    return FuzzInput("scenario", (name, "f.toml", *bounds), {"f.toml": as_bytes(r, text)})


_SWEEP = SMALL.replace("points = 4", "points = 2").replace("mu = {", "# mu = {")


def sweep(r: Random) -> FuzzInput:
    """Return a sweep file that is changed; nothing in it may ask for many points."""
    text = mutated(r, _SWEEP, ("[sample]", "points = 3", "seed = 1", "events = 2", "chunk = 1"))
    text = text.replace("max_steps", "").replace("t_end = 0.01", "max_steps = 300\nt_end = 0.01")
    return FuzzInput("sweep", ("sweep", "f.toml", "--out", "o.npz"), {"f.toml": as_bytes(r, text)})


_HISTORY = "t [s],normal_force [N],theta [rad]\n# a comment\n" + "".join(
    f"{i}e-5,{5 + 2 * i},{1 + i * 1e-5}\n" for i in range(8)
)
_ROWS = "start theta [rad],start theta_dot [rad/s],end y_A_dot [m/s]\n" + "1.0,1.5,0.11\n" * 4


def csv(r: Random) -> FuzzInput:
    """Return measurements that are changed."""
    seed, estimate = r.choice(((_HISTORY, "mu"), (_HISTORY, "E,mu"), (_ROWS, "e_energetic")))
    tokens = ('"', '"1\n"', ",,", "[m]", "start ", "end ", "gap [m]", "#", *NUMBERS)
    text = mutated(r, seed, tokens)
    state = "x_A_dot=-1" if seed == _ROWS else "theta=1,theta_dot=1,x_A_dot=-1,y_A_dot=-0.02"
    words = ("fit", "f.csv", "rod", "--law", "bilinear-hertz", "--state", state)
    return FuzzInput("csv", (*words, "--estimate", estimate), {"f.csv": as_bytes(r, text)})


# ---- what the program itself wrote ----


def _damage(r: Random, most: int) -> tuple[tuple[int, int, int], ...]:
    return tuple(
        (r.randrange(1000), r.choice((r.randrange(200), r.randrange(10**6))), r.randrange(12))
        for _ in range(r.randint(1, most))
    )


def cache(r: Random) -> FuzzInput:
    """Return a command whose derivation cache is damaged."""
    words = ("classify", "rod", "--state", "theta=1,theta_dot=1,x_A_dot=-1")
    return FuzzInput("cache", words, damage=_damage(r, 3))


def chunk(r: Random) -> FuzzInput:
    """Return a sweep that resumes from damaged chunks."""
    words = ("sweep", "f.toml", "--out", "o.npz")
    return FuzzInput("chunk", words, {"f.toml": _SWEEP.encode()}, _damage(r, 3))


def damaged(content: bytes, place: int, action: int) -> bytes:
    """Return content with one change: a bit, bytes that are cut, repeated or inserted."""
    changed = bytearray(content)
    at = place % (len(changed) + 1)
    if action < 8 and changed:
        changed[at % len(changed)] ^= 1 << action
    elif action == 8:
        del changed[at:]
    elif action == 9:
        changed[at:at] = changed[:100]
    elif action == 10:
        changed[at:at] = f"cbuiltins\n{CANARY}\n(tR.".encode()
    else:
        changed[:] = b""
    return bytes(changed)


KINDS: dict[str, Any] = {
    "command": command,
    "mechanism": mechanism,
    "scenario": scenario,
    "sweep": sweep,
    "csv": csv,
    "cache": cache,
    "chunk": chunk,
}
SHARES = {
    **{"command": 35, "mechanism": 25, "scenario": 12, "sweep": 6},
    **{"csv": 14, "cache": 3, "chunk": 5},
}
"""Of every hundred inputs."""
