"""The commands of the program, and the longer texts of its help."""

from __future__ import annotations

PROGRAM = "painleve"
DERIVE_FORMATS = ("text", "latex", "python", "json")
AUTOMATON_FORMATS = ("text", "mermaid", "graphviz", "json")

# Command → module and summary; the function in the module has the name of the command.
COMMANDS: dict[str, tuple[str, str]] = {
    "models": ("describe", "list the mechanisms, or show one: coordinates, parameters, source"),
    "laws": ("describe", "list the contact laws and restitution rules, or show one"),
    "materials": (
        "describe",
        "list the materials, or show one: modulus, density, friction",
    ),
    "derive": ("derive", "show the closed forms of a mechanism: text, LaTeX, Python, JSON"),
    "classify": ("classify", "solve the rigid contact at a state: every solution, or none"),
    "jump": ("run", "compute the velocity jump of an impact at a state"),
    "simulate": ("run", "compute a compliant or rigid motion, event by event"),
    "animate": ("animate", "draw a motion as GIF, MP4 or HTML, slowed down around impacts"),
    "map": ("map", "map slip, lift-off and the paradox over two states or parameters"),
    "critical": ("critical", "find the initial force that separates lift-off from impact"),
    "sweep": ("sweep", "run one motion for every point of a grid or a sampled set"),
    "contrast": ("contrast", "compare all methods from one initial state"),
    "fit": ("fit", "estimate parameters from measured velocities or force histories"),
    "export": ("export", "export the simulation as stand-alone C code"),
    "explore": ("explore", "write a page that computes contact and motion in the browser"),
    "automaton": ("describe", "show the modes and events of a mechanism with a contact law"),
    "cache": ("cache", "show where compiled code is kept and its size, or clear it"),
    "reproduce": ("reproduce", "redo the tables, figures and formulas of a paper"),
}

OPENING = """\
Contact with dry friction where rigid bodies have no answer, or two.

commands:
"""

EXAMPLES = """\
examples:
  painleve classify rod --state theta=1,theta_dot=1,x_A_dot=-1
  painleve simulate rod --state theta=1,theta_dot=1,x_A_dot=-1 \\
      --law bilinear-hertz --law-set E=209e9 --t-end 0.01 --until separation
  painleve jump rod --state theta=1,theta_dot=1,x_A_dot=-1 --restitution 0.75

`painleve COMMAND --help` shows the options of a command. SI units and radians;
with pint installed values may have others: --state theta=30deg --set m=200g.

exit codes: 0 done; 1 failure; 2 bad input; 3 the run stopped early (see
simulate); 130 interrupted; 141 the reader of the output went away (a broken
pipe, as in `| head`)."""

SCENARIO = """\
CASE is the name of a mechanism (`painleve models`) or a scenario, a TOML file:

  model = "rod"
  t_end = 0.01
  until = ["separation"]
  state = { theta = 1.0, theta_dot = 1.0, x_A_dot = -1.0 }
  parameters = { mu = 1.4 }

  [law]
  name = "bilinear-hertz"
  reload = "elastic"
  parameters = { E = 209e9, e_energetic = 0.75 }

Other keys: title, material, contact, close, initial_force, engine, rtol,
max_steps, max_events, samples, restitution, rule. One file serves classify,
simulate and jump; each takes the keys it needs. Options override the file,
--state, --set and --law-set entry by entry; another --law drops the law
parameters of the file. Without a state the mechanism's own start is taken."""

JUMP = """\
With a contact law the jump is also computed at its stiffness: the free normal
acceleration B is kept, and the result can be compared with a compliant motion.

"""

STOPS = """

exit codes: 0 for a run that ended at t_end, at --until or where the mechanism
left its domain; 3 for one that stopped early (step_limit, event_limit,
accumulation, non_finite, step_underflow or another such reason), or whose
energy balance does not close, after what it has was printed; 2 bad input."""

SWEEP = """\
SWEEP is a scenario file (see `painleve simulate -h`) with the points to run:

  model = "rod"
  t_end = 0.01
  until = ["separation"]
  state = { x_A_dot = -1.0 }
  law = { name = "bilinear-hertz", parameters = { E = 209e9 } }
  keep = ["theta_dot", "time_of_separation", "max_normal_force", "case"]

  [axes]                            # every combination
  theta = { from = 0.9, to = 1.1, points = 21 }
  theta_dot = [0.5, 1.0, 2.0]
  mu = { from = 1.35, to = 2.0, points = 10, scale = "log" }

or, instead of [axes], a sampled set:

  [sample]
  points = 1000
  seed = 1
  [sample.ranges]
  theta = [0.95, 1.2]
  mu = { from = 1.35, to = 2.0, scale = "log" }

Axes: coordinates, velocities, parameters of mechanism and law, initial_force.
keep: final states, time, mode, case (of the rigid contact at the start),
time_of_EVENT, count_of_EVENT, max_OUTPUT, min_OUTPUT (and ..._time),
integral_OUTPUT (of normal_force: the impulse); with events = N the first N
times, times_of_EVENT or event_times (all kinds). stop_reason is always kept.
`painleve automaton MODEL --law LAW` lists the events.

A failed motion is a point with its stop_reason, never left out.
Chunks are written to FILE.parts as they finish. After any interruption the same
command resumes there. How to read the result: docs/sweeps.md."""

WORDS = ("policy", "reload", "virgin curve", "yield", "settle")
"""Words of options that the help explains."""


def meanings() -> dict[str, str]:
    """Return the meaning of `WORDS`, as in the glossary."""
    import tomllib
    from importlib.resources import files

    text = files("painleve_sym.explorer").joinpath("words.toml").read_text("utf-8")
    every = tomllib.loads(text)
    return {word: every[word] for word in WORDS}
