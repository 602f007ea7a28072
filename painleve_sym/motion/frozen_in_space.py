"""The motion of a compliant contact in space with constant W, b and μ, up to where it opens."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.automata.frozen_in_space import COEFFICIENTS, IMPULSES, FrozenSpatialContact
from painleve_sym.automata.model import CONTACT_LOSS, FRICTION_LOSS
from painleve_sym.choices import EngineLike, EngineName
from painleve_sym.engines.factory import make_engine
from painleve_sym.engines.protocol import Engine, RawRun, RunOptions
from painleve_sym.engines.records import dense_values
from painleve_sym.errors import EventKind, InputError, StopReason
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.mechanics.declarations import ParameterSet
from painleve_sym.problem.risk import holding_forces
from painleve_sym.units import Value

RTOL = 1e-12
TURNING = 1e-10
"""Speed of the slip below which it turns at a finite rate, by that of the start."""
UNRESOLVED = 1e-12
"""Of the forces of a contact: what they are known to."""
MAX_EVENTS = 64
"""Of a motion: an impact has a few, a contact that is held oscillates without end."""
MAX_STEPS = 500
"""Of a motion, about as many as are kept of its course."""
_IDLE = 0.01
"""Where nothing presses: the part that counts of what the energy can compress."""
_POINTS = 8
"""Of a step, at which its motion is recorded."""


@dataclass(frozen=True)
class FrozenSpatialMotion:
    """A motion of a compliant contact in space with constant coefficients.

    Attributes
    ----------
    stop_reason : StopReason
        UNTIL where the event asked for ended it; EVENT_LIMIT where it oscillates: it is held.
    duration : float
        s.
    velocity, impulse : ndarray, shape (3,)
        n, t1, t2 at the end; m/s, N s.
    peak_force : float
        Largest normal force; N.
    friction_loss, contact_loss : float
        Energy that friction and the contact law have dissipated; J.
    stored_energy : float
        Energy that the contact can still return at the end; J.
    events : tuple of (float, str)
        Times, s, and kinds.
    times : ndarray, shape (k,)
        s.
    velocities : ndarray, shape (k, 3)
        At these times; m/s.
    """

    stop_reason: StopReason
    duration: float
    velocity: Array
    impulse: Array
    peak_force: float
    friction_loss: float
    contact_loss: float
    stored_energy: float
    events: tuple[tuple[float, str], ...]
    times: Array = field(repr=False)
    velocities: Array = field(repr=False)


@dataclass(frozen=True)
class FrozenSpatialSolver:
    """Motions of a contact in space with constant coefficients; build once, use often.

    Parameters
    ----------
    law : ContactLaw
        With Coulomb's friction.
    engine : {"auto", "compiled", "taylor", "erk"}
        As for `Simulator`.

    Raises
    ------
    InputError
        A law with another friction than Coulomb's.

    Examples
    --------
    >>> from painleve_sym import laws
    >>> from painleve_sym.motion.frozen_in_space import FrozenSpatialSolver
    >>> solver = FrozenSpatialSolver(laws.bilinear_hertz(E=20.9e14))
    >>> W = [[1.0, -1.0, 0.0], [-1.0, 6.0, 2.0], [0.0, 2.0, 1.0]]
    >>> motion = solver(W, [0.0, 0.0, 0.0], 2.4, [-0.1, -0.5, 0.9], t_end=1.0)
    >>> [kind for _, kind in motion.events]
    ['max_compression', 'slip_stop', 'separation']
    >>> motion.velocity.round(6).tolist()
    [0.144369, 0.0, 0.0]
    """

    law: ContactLaw
    engine: EngineLike = EngineName.AUTO

    def __post_init__(self) -> None:
        if not self.law.friction.is_coulomb:
            raise InputError(
                f"contact in space with law {self.law.name!r}: friction: got "
                f"{self.law.friction.kind.value!r}, need 'coulomb'. Fix: leave it out."
            )

    @cached_property
    def integrator(self) -> Engine:
        """The engine, compiled or taken from the cache on first use."""
        return make_engine(FrozenSpatialContact(self.law), self.engine)

    def __call__(
        self,
        W: ArrayLike,
        b: ArrayLike,
        mu: float,
        velocity: ArrayLike,
        parameters: Mapping[str, Value] | None = None,
        *,
        t_end: float,
        until: tuple[EventKind, ...] = (EventKind.SEPARATION,),
    ) -> FrozenSpatialMotion:
        """Return the motion from a contact that is closed and not compressed.

        Parameters
        ----------
        W : array_like, shape (3, 3)
            Mobility with the rows n, t1, t2, positive semidefinite; 1/kg.
        b, velocity : array_like, shape (3,)
            Accelerations without contact force, and velocity at the start; m/s², m/s.
        mu : float
        parameters : mapping of str to float
            Of the law; absent ones have their defaults.
        t_end : float
            s.
        until : tuple of EventKind
            Events that end it.

        Raises
        ------
        InputError
            Unknown names of parameters, numbers out of range.
        """
        W, b, v = (np.asarray(x, float) for x in (W, b, velocity))
        where = f"contact in space with law {self.law.name!r}"
        of_law = ParameterSet(*self.law.parameters).values(where, parameters)
        gain, free = holding_forces(W, b, 1)
        of_contact = (*W[np.triu_indices(3)], *gain[:, 0], *free, *b, mu, 0.0, 0.0)
        values = {**dict(zip(COEFFICIENTS, of_contact, strict=True)), **of_law}
        names = self.integrator.outline
        given = np.array([values[name] for name in names.parameter_names])
        law = dict(zip(names.constant_names, self.integrator.constants(given), strict=True))
        scales, speed, force = self._scales(W, b, v, law)
        for name, value in zip(
            COEFFICIENTS[-2:], (TURNING * speed, UNRESOLVED * force), strict=True
        ):
            given[names.parameter_names.index(name)] = value
        start = np.zeros(len(scales))
        start[1:4] = v
        options = RunOptions(
            t_end=t_end,
            rtol=RTOL,
            atol=RTOL * scales,
            until=until,
            max_events=MAX_EVENTS,
        )
        raw = self.integrator.run(start, given, options, np.zeros(len(names.memory_names)))
        return self._motion(raw, given)

    def _scales(
        self, W: Array, b: Array, v: Array, law: Mapping[str, float]
    ) -> tuple[Array, float, float]:
        """Return the scales of the states, as in the plane, of speeds, m/s, and of forces, N.

        A speed counts by that of the start, or by what b gives while the contact is compressed.
        """
        from painleve_sym.codegen.evaluate import numbers

        K, n = (float(numbers([x], law)[0]) for x in (self.law.stiffness, self.law.exponent))
        speed, pressed = float(np.linalg.norm(v)), float(abs(b[0]) / W[0, 0])
        impact = ((n + 1) * speed**2 / (2 * W[0, 0] * K)) ** (1 / (n + 1))
        depth, rate, time = _IDLE * impact, _IDLE * speed, impact / (speed or 1.0)
        if pressed > 0:
            depth = (pressed / K) ** (1 / n)
            rate, time = math.sqrt(depth * abs(b[0])), math.sqrt(depth / abs(b[0]))
        speed = max(speed, float(np.linalg.norm(b)) * time) or 1.0
        energy, impulse = speed**2 / (2 * W[0, 0]), speed / float(np.trace(W))
        # Without motion and load nothing happens, on any scale.
        scales = [depth or 1.0, rate or 1.0, *[speed] * 3, 1.0, *[impulse] * 3, energy, energy]
        return np.array(scales), speed, K * impact**n + pressed

    def _motion(self, raw: RawRun, given: Array) -> FrozenSpatialMotion:
        outline, steps, events = self.integrator.outline, raw.step_records, raw.event_records
        place = {name: i for i, name in enumerate(outline.state_names)}
        # Slip that begins or stops takes thousands of steps, of which a part is kept.
        every = np.arange(0, len(steps.time), 1 + len(steps.time) // MAX_STEPS)
        u = np.linspace(0.0, 1.0, _POINTS + 1)
        count = len(u)
        curve = dense_values(np.repeat(steps.polynomial[every], count, 0), np.tile(u, len(every)))
        passed = u * (1 + steps.bend[every, None] * (u - 1))
        times = (steps.time[every, None] + steps.length[every, None] * passed).ravel()
        # The force is largest at an event, and what falls to 0 at the end does so within rounding.
        outputs = self.integrator.outputs(*events.before, self.integrator.constants(given))
        of_events = {name: outputs[:, i] for i, name in enumerate(outline.output_names)}
        velocities = ("gap_rate", "slip_velocity_1", "slip_velocity_2")
        stored = of_events["stored_energy"][-1] if len(events.time) else 0.0
        return FrozenSpatialMotion(
            stop_reason=raw.stop_reason,
            duration=float(raw.time),
            velocity=raw.state[[place[name] for name in velocities]],
            impulse=raw.state[[place[name] for name in IMPULSES]],
            peak_force=float(of_events["normal_force"].max(initial=0.0)),
            friction_loss=float(raw.state[place[FRICTION_LOSS]]),
            contact_loss=float(raw.state[place[CONTACT_LOSS]]),
            stored_energy=float(stored),
            events=tuple(
                (float(t), str(outline.kinds[k]))
                for t, k in zip(events.time, events.kind, strict=True)
            ),
            times=times,
            velocities=curve[:, [place[name] for name in velocities]],
        )
