"""The command ``painleve``: one module per group of commands, loaded when the command is used."""

from __future__ import annotations

import io
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from typing import Any, TextIO

from painleve_sym.cli.commands import IN_SPACE, OF_ROBOTS
from painleve_sym.cli.memory import require_address_space
from painleve_sym.cli.parser import read_arguments, run_command
from painleve_sym.errors import (
    InputError,
    NoFormulas,
    NotPlanar,
    PainleveError,
    PainleveWarning,
    shortened,
)
from painleve_sym.escape import terminal_text
from painleve_sym.interrupts import ended_by_interrupts, noted_interrupts
from painleve_sym.progress import show_progress
from painleve_sym.time_limit import is_deriving

EXIT_FAILURE, EXIT_USAGE = 1, 2
# As a shell reports a program that ended by SIGINT or SIGPIPE.
EXIT_INTERRUPTED, EXIT_BROKEN_PIPE = 130, 141


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; the arguments are by default the process's.

    0 success; 1 failure; 2 bad input; 3 a run that stopped early; 130 interrupted; 141 the reader
    of standard output went away.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    with _standard_error():
        if sys.stdout is None:
            return _fail("standard output is closed.", EXIT_FAILURE)
        # A name outside the terminal's alphabet must not end the run.
        for stream in (sys.stdout, sys.stderr):
            if hasattr(stream, "reconfigure"):
                stream.reconfigure(errors="backslashreplace")
        with _notices():
            return _guarded(arguments)


@contextmanager
def _standard_error() -> Iterator[None]:
    """Discard messages where standard error is closed: `print` would use standard output."""
    _occupy_closed_streams()
    if sys.stderr is not None:
        yield
        return
    with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stderr(nowhere):
        yield


def _guarded(arguments: list[str]) -> int:
    try:
        output = redirect_stdout(_NamedOutput(sys.stdout))
        ended = ended_by_interrupts(EXIT_INTERRUPTED, _say_interrupted, is_deriving)
        with output, show_progress(), ended, noted_interrupts() as check:
            given = read_arguments(arguments)
            require_address_space()
            code = run_command(given)
            sys.stdout.flush()
            check()
        return code
    except SystemExit as ending:  # argparse ends so after --help and --version
        return ending.code if isinstance(ending.code, int) else EXIT_FAILURE
    except NotPlanar as error:
        offered = f"Commands that take contacts in space: {', '.join(IN_SPACE)}."
        return _fail(f"{error} {offered}", EXIT_USAGE)
    except NoFormulas as error:
        offered = f"Commands that take robots: robot, and with --contact {', '.join(OF_ROBOTS)}."
        return _fail(f"{error} {offered}", EXIT_USAGE)
    except InputError as error:
        return _fail(str(error), EXIT_USAGE)
    except PainleveError as error:
        return _fail(str(error), EXIT_FAILURE)
    except BrokenPipeError:
        _abandon_output()
        return EXIT_BROKEN_PIPE
    except KeyboardInterrupt:
        _say_interrupted()
        return EXIT_INTERRUPTED
    except MemoryError as error:
        return _fail(str(error) or "out of memory.", EXIT_FAILURE)
    except OSError as error:
        _abandon_output()
        reason = error.strerror or str(error)
        place = f"{error.filename}: " if error.filename else ""
        return _fail(shortened(f"{place}{reason}."), EXIT_FAILURE)


class _NamedOutput(io.TextIOBase):
    """Standard output whose errors say that they are its own: a full disk may be another one."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        with self._named():
            self._stream.write(terminal_text(text))
        return len(text)

    def flush(self) -> None:
        with self._named():
            self._stream.flush()

    def fileno(self) -> int:
        return self._stream.fileno()

    def isatty(self) -> bool:
        return self._stream.isatty()

    @contextmanager
    def _named(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise OSError(error.errno, error.strerror, "standard output") from error


def _say_interrupted() -> None:
    _say("interrupted.")


def _say(text: str) -> None:
    with suppress(OSError):
        print("painleve:", terminal_text(" ".join(text.split())), file=sys.stderr)


def _fail(message: str, code: int) -> int:
    _say(f"error: {message}")
    return code


def _occupy_closed_streams() -> None:
    """Open what is closed of the three standard streams, so that no file takes its number."""
    with suppress(OSError):
        while (handle := os.open(os.devnull, os.O_RDWR)) <= 2:
            pass
        os.close(handle)


def _abandon_output() -> None:
    """Point standard output to nowhere, so that the interpreter's last flush cannot fail."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


@contextmanager
def _notices() -> Iterator[None]:
    """Show each `PainleveWarning` as one line on standard error."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", PainleveWarning)
        others, said = warnings.showwarning, set[str]()

        def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> Any:
            if issubclass(category, PainleveWarning):
                # Several engines of one command have the same to say.
                if str(message) not in said:
                    said.add(str(message))
                    _say(f"note: {message}")
                return None
            return others(message, category, *place, **more)

        warnings.showwarning = show
        yield
