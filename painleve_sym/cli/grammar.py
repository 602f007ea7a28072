"""The options of every command."""

from __future__ import annotations

import argparse
import textwrap
from typing import Any, NoReturn

import painleve_sym
from painleve_sym.cli.texts import (
    AUTOMATON_FORMATS,
    COMMANDS,
    DERIVE_FORMATS,
    EXAMPLES,
    JUMP,
    OPENING,
    PROGRAM,
    SCENARIO,
    STOPS,
    SWEEP,
    meanings,
)
from painleve_sym.errors import InputError

SHELLS = ("bash", "zsh", "tcsh")


class Parser(argparse.ArgumentParser):
    """A parser whose errors are exceptions, so that all are shown in one way."""

    def __init__(self, **options: Any) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(allow_abbrev=False, **options)

    def error(self, message: str) -> NoReturn:
        """Raise `InputError` with the command, what is wrong, and where its options are shown."""
        command = self.prog.removeprefix(PROGRAM).strip()
        problem = message.removeprefix("argument ")
        raise InputError(
            f"{f'{command}: ' if command else ''}{problem}. Fix: see `{self.prog} -h`."
        )

    explains = False
    """Whether the help ends with the meaning of words of laws and events."""

    def format_help(self) -> str:
        """Return the help."""
        text = super().format_help()
        return f"{text}\n{_words()}\n" if self.explains else text

    def options(self) -> list[str]:
        """Return the long options."""
        return [o for a in self._actions for o in a.option_strings if o.startswith("--")]


class _Completion(argparse.Action):
    """Prints the completion of a shell, which shtab writes, and ends."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> NoReturn:
        try:
            import shtab
        except ImportError:
            raise InputError(
                "--print-completion: needs shtab. Fix: pip install 'painleve-sym[completion]'."
            ) from None
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                action.help = "command"  # shtab leaves out what the help does not show
        print(shtab.complete(parser, shell=values))
        parser.exit()


class _Read(argparse.Action):
    """Stores what the reader of an option makes of its text, else the text.

    Argparse would hide the message of an InputError that a ``type`` raises.
    """

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        # Loaded here, since a page of help needs no reader.
        from painleve_sym.cli.options import READERS

        name = self.option_strings[0]
        setattr(namespace, self.dest, READERS[name](name, values) if name in READERS else values)


def _texts(parser: argparse.ArgumentParser, *options: tuple[str, str, str], **more: Any) -> None:
    """Add options that take a text, or what `READERS` makes of it: name, metavar and help."""
    for option, metavar, text in options:
        parser.add_argument(option, metavar=metavar, help=text, **{"action": _Read, **more})


def _lists(parser: argparse.ArgumentParser, *options: tuple[str, str, str]) -> None:
    """Add options that may be given several times."""
    _texts(parser, *options, action="append")


_CONTACT = ("--contact", "NAME", "of several contacts, consider this one alone")
_MATERIAL = ("--material", "NAME", "sets what it provides (`painleve materials`): steel, or two")
_SET = ("--set", "NAME=VALUE,...", "parameters of the mechanism, such as mu=1.2,m=0.2")

_ENGINE = ("--engine", "NAME", "auto (default), compiled, taylor or erk")
_INITIAL_FORCE = (
    "--initial-force",
    "N",
    "start compressed so that the contact carries this force, N",
)
_RESTITUTION = ("--restitution", "E", "coefficient in [0, 1], by default 0.75")
_CLOSE = ("--close", "COORDINATE", "solve gap = 0 for it; of several contacts CONTACT:COORDINATE")


def _case(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("case", metavar="CASE", help="mechanism, or a scenario file (see below)")
    text = "such as theta=1,theta_dot=5, others 0; by default the mechanism's own start"
    _lists(parser, ("--state", "NAME=VALUE,...", text), _SET)
    _texts(parser, _MATERIAL, _CONTACT, _CLOSE)


def _law(parser: argparse.ArgumentParser) -> None:
    _texts(parser, ("--law", "NAME", "contact law (`painleve laws` lists them)"))
    text = "parameters and choices of the law, such as E=209e9,reload=elastic"
    _lists(parser, ("--law-set", "NAME=VALUE,...", text))


def _json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print JSON with full precision")


def _look(parser: argparse.ArgumentParser, default: str = "as the suffix says") -> None:
    """Add the options of every command that draws a figure; `read_look` reads them."""
    _texts(
        parser,
        ("--width", "WIDTH", "of the figure: column, page, or a number in cm"),
        ("--title", "TITLE", "none leaves the titles of the figure out"),
        ("--format", "FORMAT", f"of the figure: png, svg or pdf; by default {default}"),
    )


def _map_files(parser: argparse.ArgumentParser, subject: str) -> None:
    text = "(.png, .svg, .pdf) or save it (.npz, .json); may be given several times"
    _lists(parser, ("--out", "FILE", f"draw {subject} {text}"))
    _look(parser)
    _json(parser)


def _describe_options(sub: dict[str, Parser]) -> None:
    shown = {
        "models": "the mechanism, or its TOML file",
        "laws": "the law or restitution rule",
        "materials": "the material",
    }
    for name, text in shown.items():
        help_text = f"show {text}, alone; default all"
        sub[name].add_argument("name", nargs="?", metavar="NAME", help=help_text)
        _json(sub[name])
    derive, automaton = sub["derive"], sub["automaton"]
    for parser, formats in ((derive, DERIVE_FORMATS), (automaton, AUTOMATON_FORMATS)):
        parser.add_argument("model", metavar="MODEL", help="mechanism (`painleve models`)")
        parser.add_argument("--format", default="text", metavar="FORMAT", help=", ".join(formats))
        _texts(parser, _CONTACT)
        parser.add_argument(
            "--json",
            action="store_const",
            const="json",
            dest="format",
            help="the same as --format json",
        )
    derive.description = (
        f"{derive.description}\n\nT, V, mass matrix, A and B for both slip directions, sticking, "
        "critical\nfriction and the three phases of the jump. --format python prints a module "
        "of\nplain functions."
    )
    _law(automaton)


def _run_options(sub: dict[str, Parser]) -> None:
    for name in ("classify", "jump", "simulate"):
        _case(sub[name])
        sub[name].epilog = SCENARIO + (STOPS if name == "simulate" else "")
    jump, simulate = sub["jump"], sub["simulate"]
    _texts(
        jump,
        _RESTITUTION,
        ("--rule", "RULE", "energetic (default), poisson or newton"),
    )
    _law(jump)
    force = "with a law: the contact starts compressed so that it carries this force, N"
    _texts(jump, ("--initial-force", "N", force))
    text = "with a law: frozen (default), or carried along to where the impulse acts"
    _texts(jump, ("--configuration", "NAME", text), default="frozen")
    jump.epilog = JUMP + SCENARIO
    _motion(simulate)
    _texts(
        simulate,
        _ENGINE,
        ("--samples", "N", "also give state and forces at N evenly spaced times"),
        ("--save", "FILE", "write the whole trajectory, an NPZ file"),
        ("--plot", "FILE", "draw it, as PNG, SVG or PDF by the suffix"),
        ("--report", "FILE", "write a page about it, .html: formulas, figure, events, sources"),
    )
    _look(simulate)
    for name in ("classify", "jump", "simulate"):
        _json(sub[name])


def _animate_options(parser: Parser) -> None:
    _case(parser)
    _motion(parser)
    _texts(
        parser,
        ("--out", "FILE", "the film: .gif, .html, or .mp4 with imageio-ffmpeg"),
        required=True,
    )
    _texts(
        parser,
        _ENGINE,
        ("--duration", "TIME", "length of the film, s, by default 8"),
        ("--width", "PIXELS", "from 200 to 2000, by default 480"),
    )
    _json(parser)
    parser.epilog = (
        "CASE and the options of the motion are those of `painleve simulate`. The film runs\n"
        "slowly where forces change fast, and its clock shows by how much. Arrows show\n"
        "normal force, friction and the direction of slip; their lengths are logarithmic.\n"
        "Shapes are those of the bodies, or [[shapes]] of a mechanism file.\n\n"
        "  painleve animate rod --law bilinear-hertz --t-end 0.01 --until liftoff \\\n"
        "      --out rod.gif"
    )


def _motion(parser: Parser) -> None:
    _law(parser)
    _texts(
        parser,
        ("--t-end", "TIME", "end time, s"),
        ("--until", "EVENT,...", "end at the first event of these kinds, such as separation"),
        _INITIAL_FORCE,
        ("--rtol", "X", "relative tolerance, from 1e-15 up to 1"),
        ("--max-steps", "N", "stop after N steps, by default 1e6"),
        ("--max-events", "N", "stop after N events, by default 1e5"),
    )


def _export_options(parser: Parser) -> None:
    _case(parser)
    _motion(parser)
    _texts(parser, ("--out", "DIR", "folder to write, absent or empty"), required=True)
    _texts(
        parser,
        ("--name", "NAME", "prefix of the C names, by default the mechanism's name"),
        ("--engine", "NAME", "auto (default), taylor or compiled"),
    )
    _json(parser)
    parser.epilog = (
        "CASE, state, parameters and law are those of `painleve simulate`; they are what\n"
        "the example main.c runs. Without --state it runs the mechanism's own start,\n"
        "without --t-end 0.01 s, of a rigid motion 1 s.\n\n"
        "  painleve export rod --law bilinear-hertz --law-set E=209e9 --out rod-c\n"
        "  cd rod-c && cmake -B build && cmake --build build"
    )


def _explore_options(parser: Parser) -> None:
    _case(parser)
    _law(parser)
    _texts(
        parser,
        ("--t-end", "TIME", "end time of the motions at first, s"),
        _INITIAL_FORCE,
        ("--docs", "ADDRESS", "documentation site that the page links to, also from the page: .."),
    )
    _texts(parser, ("--out", "FILE", "page to write, .html"), required=True)
    _json(parser)
    parser.epilog = (
        "One HTML file that opens from disk: sliders, map, contact problem, the motion with the\n"
        "law and the rigid one, animation and tables, computed by WebAssembly in it. CASE, state,\n"
        "parameters and law are those of `painleve simulate`, and what the page begins with.\n"
        "Without --law: bilinear-hertz, or rigid where a contact holds from both sides. The rod's\n"
        "page then needs no compiler; others are compiled once, with clang and wasi-libc, or with\n"
        "pip install 'painleve-sym[web]'.\n\n"
        "  painleve explore rod --out rod.html"
    )


def _map_options(parser: Parser) -> None:
    parser.add_argument("model", metavar="MODEL", help="mechanism (`painleve models`)")
    text = "the axes: two coordinates, velocities (theta_dot) or parameters"
    _texts(parser, ("--over", "NAME,NAME", text), required=True)
    ranges = "ends of the axes, such as theta=0.1:1.5,theta_dot=-5:5; chosen where left out"
    held = "coordinates and velocities that are held; by default the start of the mechanism"
    _lists(
        parser,
        ("--range", "NAME=FROM:TO,...", ranges),
        ("--state", "NAME=VALUE,...", held),
        _SET,
    )
    _texts(parser, _MATERIAL, _CONTACT, _CLOSE)
    points = "points along each axis, from 5 to 2000, by default 400"
    _texts(parser, ("--points", "N", points), default=400)
    slip = "sign of the slip velocity, -1 (default) or 1"
    _texts(parser, ("--slip", "SIGN", slip), default=-1)
    _map_files(parser, "it")
    parser.epilog = (
        "--json prints what the map holds without its grids; --out FILE.json has them too."
    )


def _critical_options(parser: Parser) -> None:
    _case(parser)
    _law(parser)
    _texts(
        parser,
        ("--over", "NAME=FROM:TO", "map the outcomes over the force and this (E, y_A_dot)"),
        ("--forces", "FROM:TO", "initial forces of the map, N; chosen where left out"),
        ("--points", "N", "points along each axis of the map, from 2 to 400, by default 61"),
        ("--gradient", "NAME,...", "also the derivatives of the critical force by these"),
        ("--engine", "NAME", "auto (default), compiled or erk"),
    )
    _map_files(parser, "the map")
    parser.epilog = (
        "The state must be indeterminate: on the surface, slipping, A < 0 and B > 0. The law\n"
        "is bilinear-hertz unless --law or the scenario file (see `painleve simulate -h`)\n"
        "names another.\n\n"
        "  painleve critical rod --state theta=1,theta_dot=5,x_A_dot=-1 --law-set E=209e9\n"
        "  painleve critical rod --state theta=1,theta_dot=5,x_A_dot=-1 \\\n"
        "      --over E=2e9:2e12 --out map.png"
    )


def _contrast_options(parser: Parser) -> None:
    _case(parser)
    _texts(
        parser,
        _RESTITUTION,
        ("--steps", "H,...", "steps of time stepping, s, by default 1/10, 1/100, 1/1000 of t-end"),
        ("--stiffness", "E,...", "Young's moduli, Pa, by default 20.9e12,20.9e14,20.9e16"),
        ("--solvers", "NAME,...", "of time stepping: least-impulse, largest-impulse, lemke, mpcc"),
        ("--t-end", "TIME", "when the velocities are compared, s, by default 1e-2"),
        ("--out", "FILE", "draw it, as PNG, SVG or PDF by the suffix"),
    )
    _look(parser)
    _json(parser)
    parser.epilog = (
        "The least-impulse, largest-impulse and first solvers enumerate every solution of a\n"
        "step; lemke and mpcc end at one.\n\n"
        "CASE is a mechanism or a scenario file, of which model, state, parameters, t_end\n"
        "and restitution are used."
    )


def _fit_options(parser: Parser) -> None:
    parser.add_argument("data", metavar="DATA", help="CSV file; its header names NAME [unit]")
    _case(parser)
    _law(parser)
    _texts(
        parser,
        ("--estimate", "NAME,...", "what to estimate: parameters, or start values of a history"),
        ("--until", "EVENT,...", "event that ends each motion, by default separation"),
        ("--t-end", "TIME", "by when each motion has ended, s, by default 1"),
        ("--sigma", "NAME=VALUE,...", "known standard deviations; by default from the residuals"),
        ("--level", "P", "of the confidence intervals, in (0, 1), by default 0.95"),
        ("--max-evaluations", "N", "of the model, after which the fit ends, by default 200"),
        ("--max-steps", "N", "of one motion, by default 50 000"),
        ("--out", "FILE", "draw data and model, as PNG, SVG or PDF by the suffix"),
    )
    _look(parser)
    _json(parser)
    parser.epilog = (
        "DATA is a history of one motion, with a column t [s], or one motion per row:\n\n"
        "  t [s], y_A_dot [m/s], normal_force [N]\n"
        "  start theta [rad], start x_A_dot [m/s], end y_A_dot [m/s]\n\n"
        "SI units and rad; others are converted where pint is installed. An empty cell has\n"
        "no measurement; lines that begin with # are comments. --set and --law-set give\n"
        "known values, and where the estimates start."
    )


def _sweep_options(parser: Parser) -> None:
    parser.add_argument("file", metavar="SWEEP", help="the sweep, a TOML file (see below)")
    _texts(
        parser,
        (
            "--out",
            "FILE",
            "the result: .nc (NetCDF), .zarr (a folder) or .npz; by default SWEEP.nc in this "
            "folder, or what the key format of SWEEP says",
        ),
        ("--threads", "N", "threads of this process; by default one per processor"),
        (
            "--cluster",
            "ADDRESS",
            "run on the Dask scheduler there, such as tcp://10.0.0.1:8786, or on `local` processes",
        ),
    )
    _json(parser)
    parser.epilog = SWEEP


def _cache_options(parser: Parser) -> None:
    parser.add_argument("--clear", action="store_true", help="remove what the cache holds")
    _json(parser)
    parser.epilog = (
        "The folder is PAINLEVE_CACHE, else XDG_CACHE_HOME/painleve-sym, else\n"
        "~/.cache/painleve-sym. Other files in it are left alone."
    )


def _reproduce_options(parser: Parser) -> None:
    parser.add_argument(
        "paper", nargs="?", metavar="PAPER", help="name of the paper (--list shows it); default all"
    )
    _texts(parser, ("--out", "DIR", "also write a report with figures here"))
    _lists(parser, ("--only", "ID,...", "only these items or groups (--list shows them)"))
    parser.add_argument("--list", action="store_true", help="list the items and end")
    _look(parser, "png and svg; pdf comes beside these two")
    _json(parser)
    parser.epilog = (
        "Progress goes to standard error, the table to standard output.\n\n"
        "exit codes: 0 when every verdict is the expected one, else 1; 2 bad input.\n"
        "An item that ends with an error has the verdict failed, which is never expected."
    )


def parsers() -> tuple[Parser, dict[str, Parser]]:
    """Return the parser of the command line and those of its commands by name."""
    parser = Parser(
        prog=PROGRAM,
        usage=f"{PROGRAM} [-h] [--version] [--print-completion SHELL] COMMAND ...",
        description=OPENING + "\n".join(f"  {n:10s} {t}" for n, (_, t) in COMMANDS.items()),
        epilog=EXAMPLES,
    )
    parser.add_argument("--version", action="version", version=painleve_sym.__version__)
    parser.add_argument(
        "--print-completion",
        action=_Completion,
        choices=SHELLS,
        help="print what completes commands and options in this shell, and end",
    )
    group = parser.add_subparsers(
        dest="command", metavar="COMMAND", prog=PROGRAM, help=argparse.SUPPRESS
    )
    sub: dict[str, Parser] = {}
    for name, (_, text) in COMMANDS.items():
        sub[name] = group.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.")
    _describe_options(sub)
    _run_options(sub)
    _animate_options(sub["animate"])
    _export_options(sub["export"])
    _explore_options(sub["explore"])
    _map_options(sub["map"])
    _critical_options(sub["critical"])
    _sweep_options(sub["sweep"])
    _contrast_options(sub["contrast"])
    _fit_options(sub["fit"])
    _cache_options(sub["cache"])
    _reproduce_options(sub["reproduce"])
    for name, one in sub.items():
        one.explains = "--law" in one.options() or name == "sweep"
    return parser, sub


def _words() -> str:
    """Return the words of laws and events with their meaning."""
    explained = meanings()
    width = max(map(len, explained)) + 4
    lines = ["words:"]
    for word, meaning in explained.items():
        rows = textwrap.wrap(meaning, 80 - width)
        lines += [f"  {word:{width - 2}}{rows[0]}", *(" " * width + row for row in rows[1:])]
    return "\n".join(lines)
