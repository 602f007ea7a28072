"""Command-line parsing and lazy dispatch."""

from __future__ import annotations

import argparse
import difflib
import importlib
import re
from collections.abc import Callable, Sequence

from painleve_sym.cli.commands import COMMANDS
from painleve_sym.cli.grammar import parsers
from painleve_sym.errors import InputError, unknown_name


def read_arguments(argv: Sequence[str]) -> argparse.Namespace:
    """Return the parsed arguments; without any, those that ask for help.

    InputError for unknown commands and options (the nearest is named), missing or misplaced values.
    """
    words = list(argv) or ["--help"]
    if words[0] == "help":
        words = [*words[1:], "--help"]
    if not words[0].startswith("-") and words[0] not in COMMANDS:
        raise InputError(_no_command(words[0]))
    # Those of all commands would take a tenth of the time that a short one does.
    parser, sub = parsers(words[:1]) if words[0] in COMMANDS else parsers()
    known, rest = parser.parse_known_args(_joined(words))
    if rest:
        name = known.command
        options = (sub[name] if name else parser).options()
        raise InputError(f"{f'{name}: ' if name else ''}{_unexpected(rest[0], options)}")
    if known.command is None:
        raise InputError(f"no command, need one of {', '.join(COMMANDS)}. Fix: see `painleve -h`.")
    return known


def _no_command(word: str) -> str:
    """Return a sentence on a first word that names no command: perhaps what a command takes."""
    from painleve_sym.mechanics.models import NAMED

    if word.partition(":")[0] in NAMED or word.endswith(".toml"):
        subject = "a file" if word.endswith(".toml") else "a mechanism"
        return (
            f"{word!r} is {subject}, and a command comes first. "
            f"Fix: such as `painleve classify {word}`; `painleve -h` lists the commands."
        )
    return unknown_name("command", word, COMMANDS)


def _unexpected(word: str, options: list[str]) -> str:
    """Return a sentence on a word or option that a command does not take."""
    from painleve_sym.laws.catalogue import LAWS

    if not word.startswith("-"):
        fix = "Fix: leave it out."
        if "=" in word and "--state" in options:
            fix = (
                f"Fix: give it with an option, such as --state {word} or --set {word}; several "
                "name=value are joined by commas, without spaces."
            )
        elif word in LAWS and "--law" in options:
            fix = f"Fix: give it with --law {word}."
        elif "--state" in options:
            fix = "Fix: leave it out, or join name=value by commas without spaces."
        return f"unexpected {word!r}. {fix}"
    name = word.partition("=")[0]
    near = difflib.get_close_matches(name, options, n=1, cutoff=0.6)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    if not near and "--set" in options:
        of_law = ", those of the law with --law-set" if "--law-set" in options else ""
        hint = f" Fix: parameters are given with --set NAME=VALUE{of_law}."
    return f"unknown option {name!r}.{hint} Known: {', '.join(options)}."


_NEGATIVE = re.compile(r"-(\.?\d|inf|nan)")


def _joined(words: list[str]) -> list[str]:
    """Join an option and what begins with a negative number, which argparse takes for an option."""
    joined: list[str] = []
    for word in words:
        before = joined[-1] if joined else ""
        if before.startswith("--") and "=" not in before and _NEGATIVE.match(word):
            joined[-1] = f"{before}={word}"
        else:
            joined.append(word)
    return joined


def run_command(arguments: argparse.Namespace) -> int:
    """Import the module of the command, run it and return its exit code."""
    home = COMMANDS[arguments.command].module
    module = importlib.import_module(f"painleve_sym.cli.{home}")
    command: Callable[[argparse.Namespace], int] = getattr(module, arguments.command)
    return command(arguments)
