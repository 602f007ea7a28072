"""A limit on the time that deriving closed forms may take, in any thread and on any system."""

from __future__ import annotations

import ctypes
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TypeVar

from painleve_sym.errors import DerivationTimeout, InputError

VARIABLE = "PAINLEVE_DERIVE_SECONDS"
"""Environment variable that replaces `DEFAULT_SECONDS`."""
DEFAULT_SECONDS = 300.0
"""Of processor time: five coordinates take ten seconds, six a minute; what takes longer is not
readable."""
_AGAIN = 0.5
"""Seconds after which a thread that continued is interrupted once more."""

Result = TypeVar("Result")
_active = threading.local()
_deriving = set[int]()


class _Expired(BaseException):
    """The time is over; no handler of ordinary exceptions on the way may take it."""


def seconds_allowed() -> float:
    """Return the limit in force; InputError where the environment variable is not a number > 0."""
    text = os.environ.get(VARIABLE, "").strip()
    try:
        seconds = float(text) if text else DEFAULT_SECONDS
    except ValueError:
        seconds = 0.0
    if not 0 < seconds <= threading.TIMEOUT_MAX:
        raise InputError(
            f"environment variable {VARIABLE}: got {text!r}, need seconds, a number > 0."
        )
    return seconds


def is_deriving(thread: int) -> bool:
    """Whether a thread is within `within_time`."""
    return thread in _deriving


def within_time(label: str, derive: Callable[[], Result]) -> Result:
    """Return what `derive` returns, within the time allowed; a call within another adds nothing.

    The time is the processor's, so that a busy machine changes nothing. A second thread interrupts
    this one between two steps of the Python interpreter, so that the limit also holds outside the
    main thread and where there is no SIGALRM. Another interpreter than CPython has no limit.
    DerivationTimeout, with the label of the derivation, where the time is over.
    """
    if getattr(_active, "on", False) or not hasattr(ctypes, "pythonapi"):
        return derive()
    seconds = seconds_allowed()
    watch = _Watch(threading.get_ident(), seconds)
    try:
        _active.on = True
        _deriving.add(threading.get_ident())
        try:
            return derive()
        finally:
            watch.end()
    except _Expired:
        # It may have come while the watch was being ended.
        watch.end()
    finally:
        _active.on = False
        _deriving.discard(threading.get_ident())
    raise DerivationTimeout(
        f"{label}: deriving its closed forms was not done within {seconds:g} s of processor time. "
        "Fix: use shorter formulas, lower powers or fewer coordinates, or set "
        f"{VARIABLE} to more seconds."
    )


class _Watch:
    """Raises `_Expired` in a thread when its time is over, until the watch is ended."""

    def __init__(self, thread: int, seconds: float) -> None:
        self.thread, self.seconds = thread, seconds
        self.lock, self.ended = threading.Lock(), threading.Event()
        self.interrupted = False
        threading.Thread(target=self._wait, name="painleve time limit", daemon=True).start()

    def _wait(self) -> None:
        begun, left = time.process_time(), self.seconds
        while not self.ended.wait(max(left, _AGAIN if left <= 0 else 0.0)):
            left = self.seconds - (time.process_time() - begun)
            with self.lock:
                if left <= 0 and not self.ended.is_set():
                    self._interrupt()

    def end(self) -> None:
        """Stop interrupting, and take an interruption that has not arrived yet."""
        self.ended.set()
        with self.lock:
            interrupted = self.interrupted
        if not interrupted:
            return
        # Cancelled instead, with a null pointer, it would leave CPython 3.11 with a mark that makes
        # the next profiler or debugger of the process wait without end.
        with suppress(_Expired):
            self._interrupt()  # takes the place of one that has not arrived
            while True:
                time.sleep(0)

    def _interrupt(self) -> None:
        self.interrupted = True
        exception = ctypes.py_object(_Expired)
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self.thread), exception)
