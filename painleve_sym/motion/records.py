"""Parts of a motion: its events, segments and names, and what computes its outputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from painleve_sym.arrays import Array
from painleve_sym.codegen.tape import TapeOutputs
from painleve_sym.engines.protocol import Engine
from painleve_sym.equality import Compared
from painleve_sym.errors import EventKind
from painleve_sym.notebooks import Shown

PIECE = "piece"
"""Name of the last memory of a motion in pieces: in which of them a step is."""


@dataclass(frozen=True, eq=False)
class EventRecord(Shown, Compared):
    """An event of a run.

    Attributes
    ----------
    time : float
        s.
    kind : EventKind
    mode_before, mode_after : str
    state : dict of str to float
        Coordinates, velocities and further states just after the event.
    normal_force, tangential_force : float
        Just before the event; N.
    compression : float
        δ = −g_N; m.
    alternatives : tuple of str
        Rigid motion, where there were several solutions: the modes of all those of the contact
        problem, also that of an impact of several contacts by the final slip, and
        ``reverse_chatter`` where a contact at rest can also leave in growing bounces.
    contact : str
        Name of the contact; empty where all contacts are meant.
    impulses : tuple of float
        An impact of two rigid contacts: P_n and P_t of each; N s.
    quantity : str
        Of an event that is watched: its arguments, such as ``normal_force`` of
        ``peak(normal_force)``.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> run = ps.simulate("rod", "bilinear-hertz", t_end=1e-2)
    >>> event = run.events[0]
    >>> event.kind, event.mode_before, event.mode_after
    (<EventKind.SLIP_STOP: 'slip_stop'>, 'slip_neg/compression', 'stick/compression')
    >>> f"{event.time:.6f} s, {event.normal_force:.2f} N, theta = {event.state['theta']:.5f} rad"
    '0.001743 s, 880.50 N, theta = 1.00195 rad'
    """

    time: float
    kind: EventKind
    mode_before: str
    mode_after: str
    state: dict[str, float]
    normal_force: float
    tangential_force: float
    compression: float
    alternatives: tuple[str, ...] = ()
    contact: str = ""
    impulses: tuple[float, ...] = ()
    quantity: str = ""

    def __repr__(self) -> str:
        """Return kind, contact, time, modes and forces in one line."""
        of = f" of {self.contact}" if self.contact else ""
        forces = f"F_n = {self.normal_force:.6g} N, F_t = {self.tangential_force:.6g} N"
        modes = f"{self.mode_before} to {self.mode_after}"
        return f"EventRecord {self.kind}{of} at t = {self.time:.6g} s: {modes}, {forces}"


@dataclass(frozen=True)
class Segment:
    """A stretch of time in one mode: [t_start, t_end], steps first..last of the trajectory."""

    mode: str
    t_start: float
    t_end: float
    first_step: int
    last_step: int


@dataclass(frozen=True, eq=False)
class MotionNames(Compared):
    """Names that all motions of a simulator share.

    `choices` are the law's, `contacts` in the mechanism's order, `units` and `latex` those of
    coordinates, velocities and parameters, `source` the works on the mechanism, the laws and the
    integrator.
    """

    mechanism: str
    law: str
    choices: dict[str, str]
    states: tuple[str, ...]
    memory: tuple[str, ...]
    outputs: tuple[str, ...]
    engine: str
    contacts: tuple[str, ...]
    units: dict[str, str]
    latex: dict[str, str]
    source: str

    def of_contact(self, name: str, contact: str) -> str:
        """Return a name of a state or output; of several contacts, with its contact's name."""
        return f"{name}_{contact}" if len(self.contacts) > 1 and contact else name


@dataclass(frozen=True)
class EngineOutputs:
    """Outputs of a motion (forces, gaps, energies), which the engine of the run computes.

    `portable` returns the outputs of each mode as tapes; it is called where a motion is saved or
    pickled.
    """

    engine: Engine
    portable: Callable[[], TapeOutputs]

    def outputs(self, modes: Any, states: Array, memory: Array, constants: Array) -> Array:
        """Return the outputs at n points, shape (n, no)."""
        return self.engine.outputs(modes, states, memory, constants)


class Film(Protocol):
    """An animation of a motion; see `Animation` in `painleve_sym.present.animation`."""

    def save(self, path: str | Path) -> None:
        """Write it as GIF, MP4 or HTML, as the suffix says."""

    def html(self) -> str:
        """Return it as HTML with play, pause and a slider."""
