"""Ctrl-C where libraries lose it."""

from __future__ import annotations

import os
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

_PATIENCE = 1.0
"""Seconds that the main thread has to notice Ctrl-C."""


@contextmanager
def noted_interrupts() -> Iterator[Callable[[], None]]:
    """Yield a function that raises KeyboardInterrupt where Ctrl-C was pressed in this context.

    A KeyboardInterrupt may not arrive: CasADi's solvers end with an ordinary status or error when
    one is raised within them, and callbacks of weak references drop it.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield lambda: None
        return
    came: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        came.append(number)
        before(number, frame)

    def check() -> None:
        if came:
            raise KeyboardInterrupt

    signal.signal(signal.SIGINT, note)
    try:
        yield check
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def ended_by_interrupts(
    code: int, say: Callable[[], None], deriving: Callable[[int], bool]
) -> Iterator[None]:
    """End the process with this exit code where Ctrl-C meets a main thread that is in a library.

    A library that computes for long without a step of the interpreter, such as CasADi on long
    formulas, keeps the main thread from noticing Ctrl-C, or drops what its handler raises. A second
    thread learns of it at once. Where a second later the handler has not run, or the main thread,
    whose number `deriving` takes, still derives formulas, it calls `say` and ends the process. For
    commands alone: a session of Python would be lost.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield
        return
    noticed = threading.Event()

    def note(number: int, frame: FrameType | None) -> None:
        noticed.set()
        before(number, frame)

    def watch() -> None:
        while signals := bell.recv(1):
            if signals[0] != signal.SIGINT:
                continue
            ended.wait(_PATIENCE)
            if not ended.is_set() and (not noticed.is_set() or deriving(main)):
                say()
                os._exit(code)
            noticed.clear()

    main, ended = threading.get_ident(), threading.Event()
    bell, ringing = socket.socketpair()
    ringing.setblocking(False)
    signal.signal(signal.SIGINT, note)
    former = signal.set_wakeup_fd(ringing.fileno(), warn_on_full_buffer=False)
    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        ended.set()
        signal.set_wakeup_fd(former)
        signal.signal(signal.SIGINT, before)
        ringing.close()
        watcher.join()
        bell.close()
