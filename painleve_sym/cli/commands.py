"""The commands: one entry each, with the module of its function, its options and its help.

The function of a command has the name of the command. Nothing that computes is imported here, since
a page of help needs none of it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from painleve_sym.checks import split_outside_brackets
from painleve_sym.cli.options import (
    read_count,
    read_names,
    read_number,
    read_positive,
    read_range,
    read_slip,
    read_velocity,
)
from painleve_sym.cli.texts import AUTOMATON_FORMATS, DERIVE_FORMATS
from painleve_sym.study.changes import read_inputs, read_phases
from painleve_sym.study.settings import SETTINGS


class Option(NamedTuple):
    """An option or argument: its name, and its settings for `argparse`."""

    name: str
    settings: dict[str, Any]


class Command(NamedTuple):
    """A command: the module of `painleve_sym.cli` with its function, its options and its help."""

    module: str
    summary: str
    options: tuple[Option, ...]
    details: str = ""
    more: str = ""


IN_SPACE = ("certify", "classify", "contrast", "derive", "jump", "map")
"""Commands that take a mechanism with contacts in space."""
OF_ROBOTS = ("classify", "contrast", "jump")
"""Commands that take the contact of a robot as that of a mechanism."""
COMMANDS: dict[str, Command] = {}
"""The commands by name, in the order of the help."""


def command(
    name: str, module: str, summary: str, *options: Option, details: str = "", more: str = ""
) -> None:
    """Add a command; its help ends with the details, and `more` follows its summary."""
    COMMANDS[name] = Command(module, summary, options, details, more)


Reader = Callable[[str, str], Any]
"""Makes a value of the name of an option and its text."""


def text(option: str, help_text: str, read: Reader | None = None, **more: Any) -> Option:
    """Return an option or argument with a text, or what a reader makes of it: ``--t-end TIME``."""
    name, _, metavar = option.partition(" ")
    return Option(name, {"metavar": metavar, "help": help_text, "read": read, **more})


def several(option: str, help_text: str, **more: Any) -> Option:
    """Return an option that may be given several times."""
    return text(option, help_text, action="append", **more)


def flag(name: str, help_text: str) -> Option:
    """Return an option without a value."""
    return Option(name, {"action": "store_true", "help": help_text})


def in_unit(read: Callable[..., Any], unit: str) -> Reader:
    """Return a reader whose numbers have a unit."""
    return lambda where, given: read(where, given, unit)


# ---- options of several commands ----

JSON = flag("--json", "print JSON with full precision")
_READ: dict[str, Reader] = {
    "int": read_count,
    "tuple[float, ...]": read_velocity,
    "Sequence[str]": lambda _where, text: split_outside_brackets(text),
    "tuple[str, ...]": read_names,
    "tuple[Mapping[str, Any], ...]": read_phases,
    "Mapping[str, Any]": read_inputs,
}


def setting(name: str, help_text: str = "") -> Option:
    """Return the option of a setting of a case; a command may describe it otherwise."""
    of = SETTINGS[name]
    make = several if of.type == "Mapping[str, float]" else text
    read = in_unit(read_number, of.unit or "") if of.type == "float" else _READ.get(of.type)
    return make(f"{of.option} {of.metavar}", help_text or of.help, read=read)


def settings(group: str) -> tuple[Option, ...]:
    """Return the options of the settings of a group."""
    return tuple(setting(name) for name, of in SETTINGS.items() if of.group == group)


SET, MATERIAL, CONTACT, CLOSE = map(setting, ("parameters", "material", "contact", "close"))
CASE = text("case CASE", "mechanism, or a scenario file (see below)"), *settings("case")
ROBOT = (
    text("--point X,Y,Z", "place of the contact in its frame, m; of a round foot its centre"),
    text("--normal X,Y,Z", "of the surface, in the world, by default 0,0,1"),
    text("--radius R", "of a round foot, m", in_unit(read_number, "m")),
    text("--pose NAME", "named pose: keyframe of MJCF, group state of SRDF"),
    text("--srdf FILE", "file with poses; by default that of the same name beside FILE"),
    text("--base KIND", "fixed or floating; by default as the file says"),
    text("--armature VALUE", "rotor inertia at the joints, kg m^2; or NAME=VALUE,..."),
    text("--locked NAME,...", "joints that hold their value, or all", read_names),
    text("--others WHAT", "other contacts: free (default), or stuck"),
)
"""Options that say where the contact of a robot is; `robot_options` reads them."""
ROBOT_OF_CASE = tuple(
    Option(o.name, o.settings | {"help": f"robot: {o.settings['help']}"}) for o in ROBOT
)
"""The same, of commands that take other mechanisms, too."""
CONTACT_VELOCITY = setting("contact_velocity")
LAW = settings("law")
RESTITUTION = setting("restitution")
ENGINE = setting("engine")
SECONDS = in_unit(read_number, "s")
MOTION = (*LAW, *settings("motion"))
MODEL = text("model MODEL", "mechanism (`painleve models`)")
PICTURE = text("--out FILE", "draw it, as PNG, SVG or PDF by the suffix")


def look(default: str = "as the suffix says") -> tuple[Option, ...]:
    """Return the options of every command that draws a figure; `read_look` reads them."""
    return (
        text("--width WIDTH", "of the figure: column, page, or a number in cm"),
        text("--title TITLE", "none leaves the titles of the figure out"),
        text("--format FORMAT", f"of the figure: png, svg or pdf; by default {default}"),
    )


def map_files(subject: str) -> tuple[Option, ...]:
    """Return the options of commands that draw a map of something."""
    help_text = "(.png, .svg, .pdf) or save it (.npz, .json); may be given several times"
    return several("--out FILE", f"draw {subject} {help_text}"), *look(), JSON


def listing(name: str, summary: str, subject: str) -> None:
    """Add a command that lists things, or shows one of them."""
    one = text("name NAME", f"show {subject}, alone; default all", nargs="?")
    command(name, "describe", summary, one, JSON)


def formats(names: tuple[str, ...]) -> tuple[Option, ...]:
    """Return the options of commands that print a text about a mechanism in several formats."""
    same = {"action": "store_const", "const": "json", "dest": "format"}
    return (
        MODEL,
        Option("--format", {"default": "text", "metavar": "FORMAT", "help": ", ".join(names)}),
        CONTACT,
        Option("--json", {**same, "help": "the same as --format json"}),
    )


# ---- longer texts ----

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

Other keys: title, material, contact, close, contact_velocity, robot,
initial_force, engine, rtol, max_steps, max_events, samples, restitution, rule,
impact_friction; [[phases]] with time, parameters, law, contacts; [inputs.F]
with file (CSV), column, time, interpolation, or times and values.
One file serves classify, simulate, jump and contrast; each takes the keys it
needs.
Options override the file, --state, --set and --law-set entry by entry; another
--law drops the law parameters of the file. Without a state the mechanism's own
start is taken."""

JUMP = """\
With a contact law the jump is also computed at its stiffness: the free normal
acceleration B is kept, and the result can be compared with a compliant motion.

"""

ROBOT_CASE = """

CASE may also be the file of a robot, URDF or MJCF. --contact is then the frame
of the contact, with others after it; --point to --others say where it is. A
state holds joint values and those of a floating base, others are those of
--pose; parameters are mu and torque_NAME. In a scenario: [robot], with pose,
joints, point, normal, radius, locked, others, floating, armature, srdf.

  painleve jump anymal.urdf --contact LF_FOOT --pose standing --set mu=0.8
      --contact-velocity 0,1,0"""

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
times, times_of_EVENT or event_times (all kinds), and values at these events,
gap_rate_before_touchdown or slip_velocity_after_impact. stop_reason is always
kept.
`painleve automaton MODEL --law LAW` lists the events.

A failed motion is a point with its stop_reason, never left out.
Chunks are written to FILE.parts as they finish. After any interruption the same
command resumes there. How to read the result: docs/sweeps.md."""

# ---- the commands ----

listing(
    "models",
    "list the mechanisms, or show one: coordinates, parameters, source",
    "the mechanism, or its TOML file",
)

listing(
    "laws",
    "list the contact laws and restitution rules, or show one",
    "the law or restitution rule",
)

listing("materials", "list the materials, or show one: modulus, density, friction", "the material")

command(
    "derive",
    "derive",
    "show the closed forms of a mechanism: text, LaTeX, Python, JSON",
    *formats(DERIVE_FORMATS),
    more=(
        "T, V, mass matrix, A and B for both slip directions, sticking, critical\n"
        "friction and the three phases of the jump. --format python prints a module of\n"
        "plain functions."
    ),
)

command(
    "classify",
    "classify",
    "solve the rigid contact at a state: every solution, or none",
    *CASE,
    CONTACT_VELOCITY,
    *ROBOT_OF_CASE,
    JSON,
    details=SCENARIO + ROBOT_CASE,
)

command(
    "jump",
    "run",
    "compute the velocity jump of an impact at a state",
    *CASE,
    CONTACT_VELOCITY,
    *ROBOT_OF_CASE,
    RESTITUTION,
    setting("rule"),
    setting("impact_friction"),
    *LAW,
    setting(
        "initial_force",
        "with a law: the contact starts compressed so that it carries this force, N",
    ),
    text(
        "--configuration NAME",
        "with a law: frozen (default), or carried along to where the impulse acts",
        default="frozen",
    ),
    JSON,
    details=JUMP + SCENARIO + ROBOT_CASE,
)

command(
    "simulate",
    "run",
    "compute a compliant or rigid motion, event by event",
    *CASE,
    *MOTION,
    ENGINE,
    setting("samples"),
    text("--save FILE", "write the whole trajectory, an NPZ file"),
    text("--plot FILE", "draw it, as PNG, SVG or PDF by the suffix"),
    text("--report FILE", "write a page about it, .html: formulas, figure, events, sources"),
    *look(),
    JSON,
    details=SCENARIO + STOPS,
)

command(
    "animate",
    "animate",
    "draw a motion as GIF, MP4 or HTML, slowed down around impacts",
    *CASE,
    *MOTION,
    text("--out FILE", "the film: .gif, .html, or .mp4 with imageio-ffmpeg", required=True),
    ENGINE,
    text("--duration TIME", "length of the film, s, by default 8", SECONDS),
    text("--width PIXELS", "from 200 to 2000, by default 480"),
    JSON,
    details=(
        "CASE and the options of the motion are those of `painleve simulate`. The film runs\n"
        "slowly where forces change fast, and its clock shows by how much. Arrows show\n"
        "normal force, friction and the direction of slip; their lengths are logarithmic.\n"
        "Shapes are those of the bodies, or [[shapes]] of a mechanism file.\n\n"
        "  painleve animate rod --law bilinear-hertz --t-end 0.01 --until liftoff \\\n"
        "      --out rod.gif"
    ),
)

command(
    "map",
    "map",
    "map slip, lift-off and the paradox over two states or parameters",
    MODEL,
    text(
        "--over NAME,NAME",
        "the axes: two coordinates, velocities (theta_dot) or parameters",
        required=True,
    ),
    several(
        "--range NAME=FROM:TO,...",
        "ends of the axes, such as theta=0.1:1.5,theta_dot=-5:5; chosen where left out",
    ),
    setting(
        "state", "coordinates and velocities that are held; by default the start of the mechanism"
    ),
    SET,
    MATERIAL,
    CONTACT,
    CLOSE,
    text(
        "--points N",
        "points along each axis, from 5 to 2000, by default 400",
        read_count,
        default=400,
    ),
    text("--slip SLIP", "sign of v_t, -1 (default) or 1; in space the angle of slip", read_slip),
    *map_files("it"),
    details="--json prints what the map holds without its grids; --out FILE.json has them too.",
)

command(
    "critical",
    "critical",
    "find the initial force that separates lift-off from impact",
    *CASE,
    *LAW,
    text("--over NAME=FROM:TO", "map the outcomes over the force and this (E, y_A_dot)"),
    text(
        "--forces FROM:TO",
        "initial forces of the map, N; chosen where left out",
        in_unit(read_range, "N"),
    ),
    text(
        "--points N", "points along each axis of the map, from 2 to 400, by default 61", read_count
    ),
    text("--gradient NAME,...", "also the derivatives of the critical force by these", read_names),
    setting("engine", "auto (default), compiled or erk"),
    *map_files("the map"),
    details=(
        "The state must be indeterminate: on the surface, slipping, A < 0 and B > 0. The law\n"
        "is bilinear-hertz unless --law or the scenario file (see `painleve simulate -h`)\n"
        "names another.\n\n"
        "  painleve critical rod --state theta=1,theta_dot=5,x_A_dot=-1 --law-set E=209e9\n"
        "  painleve critical rod --state theta=1,theta_dot=5,x_A_dot=-1 \\\n"
        "      --over E=2e9:2e12 --out map.png"
    ),
)

command(
    "sweep",
    "sweep",
    "run one motion for every point of a grid or a sampled set",
    text("file SWEEP", "the sweep, a TOML file (see below)"),
    text(
        "--out FILE",
        "the result: .nc (NetCDF), .zarr (a folder) or .npz; by default SWEEP.nc in this "
        "folder, or what the key format of SWEEP says",
    ),
    text("--threads N", "threads of this process; by default one per processor", read_count),
    text(
        "--cluster ADDRESS",
        "run on the Dask scheduler there, such as tcp://10.0.0.1:8786, or on `local` processes",
    ),
    JSON,
    details=SWEEP,
)

command(
    "contrast",
    "contrast",
    "compare all methods from one initial state",
    *CASE,
    CONTACT_VELOCITY,
    *ROBOT_OF_CASE,
    RESTITUTION,
    text(
        "--steps H,...",
        "steps of time stepping, s, by default 1/10, 1/100, 1/1000 of t-end",
        in_unit(read_positive, "s"),
    ),
    text(
        "--stiffness E,...",
        "Young's moduli, Pa, by default 20.9e12,20.9e14,20.9e16",
        in_unit(read_positive, "Pa"),
    ),
    text(
        "--solvers NAME,...",
        "of time stepping: least-impulse, largest-impulse, lemke, mpcc; in space the first two",
        read_names,
    ),
    setting(
        "t_end", "when the velocities are compared, s, by default 1e-2; in space the latest end"
    ),
    PICTURE,
    *look(),
    JSON,
    details=(
        "The least-impulse, largest-impulse and first solvers enumerate every solution of a\n"
        "step; lemke and mpcc end at one.\n\n"
        "In space the configuration is frozen: one step each, and compliant motion up to\n"
        "where the contact opens.\n\n"
        "CASE is a mechanism or a scenario file, of which model, state, parameters, t_end,\n"
        "restitution, contact, close, contact_velocity and robot are used."
        + ROBOT_CASE.replace("painleve jump", "painleve contrast")
    ),
)

command(
    "fit",
    "fit",
    "estimate parameters from measured velocities or force histories",
    text("data DATA", "CSV file; its header names NAME [unit]"),
    *CASE,
    *LAW,
    text(
        "--estimate NAME,...",
        "what to estimate: parameters, or start values of a history",
        read_names,
    ),
    setting("until", "end of each motion, by default that of the impact"),
    setting("watch", "further events, such as apex, by which a motion may end"),
    setting("t_end", "by when each motion has ended, s, by default 1"),
    text("--skip N", "lines of DATA before its header, by default none", read_count),
    text("--separator S", "of its columns: a comma (default), ;, |, tab or space"),
    text("--decimal S", "its sign before decimals: a point (default) or a comma"),
    several("--column NAME=FORMULA", "quantity by a formula of its columns; several times"),
    text("--sigma NAME=VALUE,...", "known standard deviations; by default from the residuals"),
    text("--level P", "of the confidence intervals, in (0, 1), by default 0.95", read_number),
    text(
        "--max-evaluations N", "of the model, after which the fit ends, by default 200", read_count
    ),
    setting("max_steps", "of one motion, by default 50 000"),
    setting("phases"),
    setting("inputs"),
    text("--out FILE", "draw data and model, as PNG, SVG or PDF by the suffix"),
    *look(),
    JSON,
    details=(
        "DATA is a history of one motion, with a column t [s], or one motion per row:\n\n"
        "  t [s], y_A_dot [m/s], normal_force [N]\n"
        "  start theta [rad], start x_A_dot [m/s], end y_A_dot [m/s]\n\n"
        "SI units and rad; others are converted where pint is installed. An empty cell has\n"
        "no measurement; lines that begin with # are comments. --set and --law-set give\n"
        "known values, and where the estimates start.\n\n"
        "A raw file is turned into one of these by formulas of the parameters that are known\n"
        "and of its columns: a name stands for a column in SI units, where its header has the\n"
        "unit, such as height (mm); a place, c1, c2, ..., for the numbers as they are written.\n\n"
        "  --skip 3 --separator ';' --decimal , --column 'start y=c1/100' \\\n"
        "  --column 'end y_dot=sqrt(2*g*height)'\n\n"
        "The same may stand in a table [csv] of a scenario file, with [csv.columns]."
    ),
)

command(
    "export",
    "export",
    "export the simulation as stand-alone C code or as an FMU",
    *CASE,
    *(option for option in MOTION if option.name not in ("--phases", "--inputs")),
    text("--out DIR", "folder to write, absent or empty; with --fmu a file .fmu", required=True),
    text("--name NAME", "prefix of the C names, by default the mechanism's name"),
    flag("--fmu", "write a functional mock-up unit for co-simulation"),
    text("--fmi VERSION", "version of FMI with --fmu: 3.0 (default) or 2.0"),
    text(
        "--inputs NAMES",
        "parameters that a caller gives for each step: F,u",
        read_names,
        dest="steps_inputs",
    ),
    setting("engine", "auto (default), taylor or compiled"),
    JSON,
    details=(
        "CASE, state, parameters and law are those of `painleve simulate`; they are what\n"
        "the example main.c runs. Without --state it runs the mechanism's own start,\n"
        "without --t-end 0.01 s, of a rigid motion 1 s.\n\n"
        "  painleve export rod --law bilinear-hertz --law-set E=209e9 --out rod-c\n"
        "  cd rod-c && cmake -B build && cmake --build build\n"
        "  painleve export rod --law rigid --fmu --out rod.fmu"
    ),
)

command(
    "explore",
    "explore",
    "write a page that computes contact and motion in the browser",
    *CASE,
    *LAW,
    setting("t_end", "end time of the motions at first, s"),
    setting("initial_force"),
    text("--docs ADDRESS", "documentation site that the page links to, also from the page: .."),
    text("--out FILE", "page to write, .html", required=True),
    JSON,
    details=(
        "One HTML file that opens from disk: sliders, map, contact problem, the motion with the\n"
        "law and the rigid one, animation and tables, computed by WebAssembly in it. CASE, state,\n"
        "parameters and law are those of `painleve simulate`, and what the page begins with.\n"
        "Without --law: bilinear-hertz, or rigid where a contact holds from both sides. The rod's\n"
        "page then needs no compiler; others are compiled once, with clang and wasi-libc, or with\n"
        "pip install 'painleve-sym[web]'.\n\n"
        "  painleve explore rod --out rod.html"
    ),
)

command(
    "robot",
    "robot",
    "find the friction above which a robot's contact can jam",
    text("file FILE", "the robot, a URDF or MJCF file"),
    text(
        "--contact FRAME,...",
        "frame with the contact in question, and frames with other contacts",
        required=True,
    ),
    several("--joints NAME=VALUE,...", "joint values, rad or m, others those of the pose"),
    *ROBOT,
    text("--mu MU", "friction coefficient", read_number),
    several(
        "--velocities NAME=VALUE,...",
        "of joints and base, others 0: with them or torques, every solution",
    ),
    several("--torques NAME=VALUE,...", "of joints, N m or N, others 0"),
    text("--trajectory FILE", "CSV of a motion: t, joints, NAME_dot, torque_NAME"),
    text(
        "--touching RULE",
        "when the contact of the log touches: stance, foot_force>5, or height<0.001, in m",
    ),
    text(
        "--rest SPEED",
        "of the contact in the log that counts as rest, by default 0.02 m/s",
        in_unit(read_number, "m/s"),
    ),
    text("--poses N", "random poses, by default 2000", read_count),
    text("--report FILE", "write a page about it, .html"),
    text("--export DIR", "write the function joint values to W, mu_P and sector as C"),
    flag("--certify", "prove A > 0 for every direction of slip in all poses of --over"),
    several("--over NAME=FROM:TO,...", "box of joints, base_roll, base_pitch, base_yaw, mu"),
    text("--check FILE", "verify this certificate instead of making one"),
    text(
        "--out FILE",
        "draw the distribution of mu_P over poses, as PNG, SVG or PDF; with --certify write the "
        "certificate, .json",
    ),
    *look(),
    JSON,
    details=(
        "mu_P is the friction coefficient from which the rigid contact has directions of slip\n"
        "without a unique answer (A < 0). It depends on the pose, the normal and which joints\n"
        "give way. Rows of W are n, t1, t2: t1 is the axis x of the world along the surface.\n\n"
        "  painleve robot anymal.urdf --contact LF_FOOT --pose standing --mu 0.8"
    ),
)

command(
    "certify",
    "certify",
    "prove that a contact has no paradox on a box of states",
    MODEL,
    several("--over NAME=FROM:TO,...", "the box, such as theta=0.2:1.4,mu=1:1.3", required=True),
    setting("state", "states that are held; by default the model's start"),
    SET,
    CONTACT,
    text("--out FILE", "write the certificate, .json"),
    text("--check FILE", "verify this certificate instead of making one"),
    JSON,
    details=(
        "A proof, not a sample: ball arithmetic on pieces of the box. It needs python-flint:\n"
        "pip install 'painleve-sym[certify]'. --check does not: another arithmetic verifies it.\n\n"
        "  painleve certify rod --over theta=0.2:1.4 --set mu=1.3 --out rod.json\n"
        "  painleve certify rod --over theta=0.2:1.4 --set mu=1.3 --check rod.json\n\n"
        "exit codes: 0 for proved or verified; 1 for refuted, undecided or rejected."
    ),
)

command(
    "automaton",
    "describe",
    "show the modes and events of a mechanism with a contact law",
    *formats(AUTOMATON_FORMATS),
    *LAW,
)

command(
    "cache",
    "cache",
    "show where compiled code is kept and its size, or clear it",
    flag("--clear", "remove what the cache holds"),
    JSON,
    details=(
        "The folder is PAINLEVE_CACHE, else XDG_CACHE_HOME/painleve-sym, else\n"
        "~/.cache/painleve-sym. Other files in it are left alone."
    ),
)

command(
    "reproduce",
    "reproduce",
    "redo the tables, figures and formulas of a paper",
    text("paper PAPER", "name of the paper (--list shows it); default all", nargs="?"),
    text("--out DIR", "also write a report with figures here"),
    several("--only ID,...", "only these items or groups (--list shows them)"),
    flag("--list", "list the items and end"),
    *look("png and svg; pdf comes beside these two"),
    JSON,
    details=(
        "Progress goes to standard error, the table to standard output.\n\n"
        "exit codes: 0 when every verdict is the expected one, else 1; 2 bad input.\n"
        "An item that ends with an error has the verdict failed, which is never expected."
    ),
)
