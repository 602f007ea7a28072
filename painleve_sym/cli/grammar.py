"""The parsers of the command line, made from the commands."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Iterable
from typing import Any, NoReturn

from painleve_sym.cli.commands import COMMANDS, Option, Reader
from painleve_sym.cli.texts import EXAMPLES, OPENING, PROGRAM, meanings
from painleve_sym.errors import InputError
from painleve_sym.version import __version__

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


def _print_completion(parser: Parser, shell: str) -> NoReturn:
    """Print the completion of a shell, which shtab writes, and end."""
    try:
        import shtab
    except ImportError:
        raise InputError(
            "--print-completion: needs shtab. Fix: pip install 'painleve-sym[completion]'."
        ) from None
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            action.help = "command"  # shtab leaves out what the help does not show
    print(shtab.complete(parser, shell=shell))
    parser.exit()


class _Read(argparse.Action):
    """Stores what the reader of an option makes of its text.

    Argparse would hide the message of an InputError that a ``type`` raises.
    """

    def __init__(self, read: Reader, **settings: Any) -> None:
        super().__init__(**settings)
        self._read = read

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        setattr(namespace, self.dest, self._read(self.option_strings[0], values))


def _add(parser: Parser, option: Option) -> None:
    settings = dict(option.settings)
    read = settings.pop("read", None)
    reading = {} if read is None else {"action": _Read, "read": read}
    parser.add_argument(option.name, **settings, **reading)


def parsers(names: Iterable[str] = COMMANDS) -> tuple[Parser, dict[str, Parser]]:
    """Return the parser of the command line and those of commands by name: all, or these alone."""
    parser = Parser(
        prog=PROGRAM,
        usage=f"{PROGRAM} [-h] [--version] [--print-completion SHELL] COMMAND ...",
        description=OPENING + "\n".join(f"  {n:10s} {c.summary}" for n, c in COMMANDS.items()),
        epilog=EXAMPLES,
    )
    parser.add_argument("--version", action="version", version=__version__)
    parser.add_argument(
        "--print-completion",
        action=_Read,
        read=lambda _where, shell: _print_completion(parser, shell),
        choices=SHELLS,
        help="print what completes commands and options in this shell, and end",
    )
    group = parser.add_subparsers(
        dest="command", metavar="COMMAND", prog=PROGRAM, help=argparse.SUPPRESS
    )
    sub: dict[str, Parser] = {}
    for name in names:
        command = COMMANDS[name]
        summary = command.summary
        description = f"{summary[0].upper()}{summary[1:]}."
        sub[name] = group.add_parser(name, help=summary, description=description)
        if command.more:
            sub[name].description = f"{description}\n\n{command.more}"
        sub[name].epilog = command.details or None
        for option in command.options:
            _add(sub[name], option)
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
