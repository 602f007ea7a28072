"""Progress of long computations: a line that is replaced, on a terminal or in a notebook."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from painleve_sym.escape import terminal_text

_IS_SHOWN = ContextVar("progress is shown", default=False)


@contextmanager
def show_progress() -> Iterator[None]:
    """Show the progress of what runs in this context on standard error.

    Bars of tqdm, on a terminal or in a notebook; elsewhere, such as in a file or a pipe, nothing
    is written.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> with ps.show_progress():
    ...     runs = ps.reproduce(["eq-1"])
    """
    terminal = getattr(sys.stderr, "isatty", lambda: False)()
    token = _IS_SHOWN.set(terminal or "ipykernel" in sys.modules)
    try:
        yield
    finally:
        _IS_SHOWN.reset(token)


Advance = Callable[[float], object]
"""Called with the number of steps that are newly done."""


@contextmanager
def progress(
    text: str, total: int | None = None, unit: str = "", done: int = 0
) -> Iterator[Advance]:
    """Yield a function that is called with the number of steps newly done, `total` in all.

    Without a total the line says what runs. `done` steps were done before. The line disappears
    at the end; nothing is shown outside of `show_progress`.
    """
    if not _IS_SHOWN.get():
        yield lambda _: None
        return
    from tqdm.auto import tqdm

    form = None if total is not None else "{desc} ..."
    with tqdm(
        total=total,
        initial=done,
        desc=f"painleve: {terminal_text(text)}",
        unit=f" {unit}" if unit else " steps",
        bar_format=form,
        leave=False,
        dynamic_ncols=True,
    ) as bar:
        yield bar.update
