"""Inputs of a contact problem: friction, slip velocities, and the constraints that they state."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.checks import mobility_faults
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, received
from painleve_sym.problem.array_checks import finite_array, mobility_matrix_faults
from painleve_sym.problem.complementarity.solution_sets import BoolArray, FloatArray
from painleve_sym.problem.constraints import Ball, Constraint
from painleve_sym.problem.friction_set import Brake, Disc, FrictionSet, Interval, unit_vector
from painleve_sym.problem.law import ScaledLaw
from painleve_sym.problem.modes import sign_of

STATED = "ContactProblem cannot be stated, "


# The same few for all states of a mechanism.
@functools.lru_cache(maxsize=512)
def planar(i: int, mu: float, slip: int, bilateral: bool) -> Constraint:
    """Return the constraint of the i-th contact in the plane, with rows n, t."""
    ball = Ball((2 * i + 1,), mu, (float(slip),) if slip else ())
    return Constraint(2 * i, (ball,), not bilateral, (1, -1) if bilateral else (1,))


def pressed(
    W: list[list[float]], b: list[float], brake: FrictionSet, row: int, slip: Sequence[float]
) -> Constraint:
    """Append the row that presses a brake by a known force, and return its constraint.

    Uncoupled, with W_vv F_v + b_v = 0: then no law but that of a contact is needed.
    """
    mobility = W[row][row] or 1.0
    for line in W:
        line.append(0.0)
    W.append([0.0] * len(b) + [mobility])
    b.append(-mobility * brake.mu)
    friction = 1.0 if brake.mu else 0.0
    ball = Ball((row,), friction, unit_vector(slip))
    return Constraint(len(b) - 1, (ball,), False, (1,))


@functools.lru_cache(maxsize=256)
def interval(mu: float) -> tuple[FrictionSet, ...]:
    """Return the friction of a planar contact."""
    return (Interval(mu),)


@functools.lru_cache(maxsize=256)
def disc(mu: float) -> tuple[FrictionSet, ...]:
    """Return the friction of a contact in space."""
    return (Disc(mu),)


def is_brake(own: tuple[FrictionSet, ...]) -> bool:
    """Return whether a contact is a brake alone, without a normal row."""
    return len(own) == 1 and isinstance(own[0], Brake)


def shape_fault(name: str, given: tuple[int, ...], needed: tuple[int, ...], n: int) -> str:
    """Return a sentence for an array that does not fit the contacts."""
    return (
        f"{name}: got shape {given}, need {needed} for {n} contacts. Fix: give rows n, t of W and "
        "b for each contact in the plane, n, t1, t2 in space, and its velocity along the tangents."
    )


def joined(slips: Any) -> tuple[FloatArray, str]:
    """Return slip velocities, which may be sequences of different lengths, as one array."""
    parts = list(slips) if isinstance(slips, list | tuple) else [slips]
    values: list[Any] = []
    for part in parts:
        values += (
            list(part) if isinstance(part, list | tuple | np.ndarray) and np.ndim(part) else [part]
        )
    if any(np.ndim(v) for v in values):
        values = list(np.concatenate([np.ravel(v) for v in values]))
    array, fault = finite_array(values, "slip_velocity")
    return array, fault


def friction_sets(given: Any) -> tuple[tuple[FrictionSet, ...], ...] | None:
    """Return the balls of each contact; None where numbers are given.

    Raises
    ------
    InputError
        For entries that are not sets, and a `Brake` beside another ball.
    """
    if isinstance(given, FrictionSet):
        return ((given,),)
    if not isinstance(given, list | tuple):
        return None
    if not any(isinstance(own, FrictionSet | tuple | list) for own in given):
        return None
    sets = tuple(tuple(own) if isinstance(own, list | tuple) else (own,) for own in given)
    flat = [ball for own in sets for ball in own]
    if not all(isinstance(ball, FrictionSet) for ball in flat):
        raise InputError(
            f"{STATED}friction: got {received(given)}, need an Interval, a Disc, a Brake or a "
            "tuple of balls for each contact. Fix: friction=[Disc(0.5)]."
        )
    if any(len(own) > 1 and any(isinstance(ball, Brake) for ball in own) for own in sets):
        raise InputError(
            f"{STATED}friction: got a Brake beside another ball of one contact. Fix: give it as a "
            "contact of its own, with one row of W."
        )
    return sets


@dataclass(frozen=True, eq=False)
class Statement(Compared):
    """The numbers of a contact problem, checked; `ContactProblem` has their meaning."""

    W: FloatArray
    b: FloatArray
    friction: Any
    slip_velocity: Any
    bilateral: BoolArray = field(default_factory=lambda: np.zeros((), np.bool_))

    def __post_init__(self) -> None:
        """Check every array and keep read-only copies."""
        fields = vars(self)
        fields["W"], first = finite_array(self.W, "W")
        fields["b"], second = finite_array(self.b, "b")
        faults = [fault for fault in (first, second) if fault]
        sets = friction_sets(self.friction)
        if sets is None:
            faults += self._state_numbers()
        else:
            fields["friction"] = sets
            fields["slip_velocity"], fault = joined(self.slip_velocity)
            faults += [fault] * bool(fault)
        sides = np.array(self.bilateral, dtype=bool)
        fields["bilateral"] = np.full(len(self.friction), sides) if sides.ndim == 0 else sides
        faults = faults or self._shape_faults() or self._physical_faults()
        if faults:
            raise InputError(STATED + " Also, ".join(faults))
        rows = self.W.tolist()
        if rows != list(map(list, zip(*rows, strict=True))):
            fields["W"] = (self.W + self.W.T) / 2
        for array in (self.W, self.b, self.slip_velocity, self.bilateral):
            array.setflags(write=False)

    def _state_numbers(self) -> list[str]:
        """Take friction coefficients for intervals or discs; return the faults."""
        fields = vars(self)
        mu, first = finite_array(self.friction, "mu")
        slip, second = finite_array(self.slip_velocity, "slip_velocity")
        mu = mu if mu.ndim else mu.reshape(1)
        slip = slip if slip.ndim else slip.reshape(1)
        fields["friction"], fields["slip_velocity"] = (), slip
        if first or second:
            return [fault for fault in (first, second) if fault]
        values = mu.tolist() if mu.ndim == 1 else []
        n = len(values)
        if values and min(values) < 0:
            given = values[0] if n == 1 else values
            fault = f"mu: got {given!r}, need mu >= 0. Fix: give the direction by slip_velocity."
            return [fault, *self._mobility_faults()]
        if slip.shape == mu.shape == (n,):
            fields["friction"] = tuple(map(interval, values))
            fields["in_plane"] = True
            return []
        if n and self.W.shape[:1] == (3 * n,) and slip.shape in ((n, 2), (2 * n,)):
            fields["friction"] = tuple(map(disc, values))
            fields["slip_velocity"] = slip.ravel()
            return []
        n = slip.size
        need: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {
            "mu": (mu.shape, (n,)),
            "slip_velocity": (slip.shape, (max(n, 1),)),
            "W": (self.W.shape, (2 * n, 2 * n)),
            "b": (self.b.shape, (2 * n,)),
        }
        return [shape_fault(name, *pair, n) for name, pair in need.items() if pair[0] != pair[1]]

    def _shape_faults(self) -> list[str]:
        """Return a sentence for each array that does not fit the contacts."""
        n = len(self.friction)
        plane = (2 * n, 2 * n), (2 * n,), (n,), (n,)
        given = self.W.shape, self.b.shape, self.slip_velocity.shape, self.bilateral.shape
        if n and given == plane and self.in_plane:
            return []
        tangents = sum(self.tangents)
        size = sum(not is_brake(own) for own in self.friction) + tangents
        need = {"W": (size, size), "b": (size,), "slip_velocity": (tangents,), "bilateral": (n,)}
        if not n:
            need["slip_velocity"] = (1,)
        return [
            shape_fault(name, getattr(self, name).shape, shape, n)
            for name, shape in need.items()
            if getattr(self, name).shape != shape
        ]

    def _physical_faults(self) -> list[str]:
        """Return a sentence for each entry that no mechanism can have."""
        held = itertools.compress(self.friction, self.bilateral.tolist())
        if not self.in_plane and any(map(is_brake, held)):
            return ["bilateral: got a Brake that holds from both sides, which has no normal row."]
        return self._mobility_faults()

    def _mobility_faults(self) -> list[str]:
        if self.W.shape == (2, 2):
            (nn, nt), (tn, tt) = self.W.tolist()
            return mobility_faults(nn, nt, tn, tt)
        square = self.W.ndim == 2 and len(set(self.W.shape)) == 1
        return mobility_matrix_faults(self.W, self._row_names) if square else []

    @property
    def _row_names(self) -> str:
        if self.in_plane:
            return "n1, t1, n2, t2, ..."
        return "n, t1, t2 of each disc, n, t of each interval"

    @property
    def size(self) -> int:
        """Return n, the number of contacts."""
        return len(self.friction)

    @cached_property
    def mu(self) -> FloatArray:
        """The first friction coefficient of each contact, 0 without one; shape (n,)."""
        return np.array([own[0].mu if own else 0.0 for own in self.friction])

    @cached_property
    def tangents(self) -> tuple[int, ...]:
        """The number of tangential rows of each contact."""
        return tuple([sum([ball.n_tangents for ball in own]) for own in self.friction])

    @cached_property
    def in_plane(self) -> bool:
        """Whether every contact has the rows n, t."""
        return all(len(own) == 1 and type(own[0]) is Interval for own in self.friction)

    @cached_property
    def rows(self) -> tuple[tuple[int, ...], ...]:
        """The rows of each contact, the normal one first; a `Brake` has none."""
        starts, rows = 0, []
        for own, tangents in zip(self.friction, self.tangents, strict=True):
            end = starts + tangents + (not is_brake(own))
            rows.append(tuple(range(starts, end)))
            starts = end
        return tuple(rows)

    @cached_property
    def slips(self) -> tuple[tuple[float, ...], ...]:
        """The slip velocity of each contact along its tangential rows."""
        values = iter(self.slip_velocity.tolist())
        return tuple(tuple(itertools.islice(values, count)) for count in self.tangents)

    @cached_property
    def slip_directions(self) -> tuple[int, ...]:
        """Return the sign of each slip velocity: -1, 0 or +1."""
        return tuple(map(sign_of, self.slip_velocity.tolist()))

    @cached_property
    def _law(self) -> ScaledLaw:
        W, b = self.W.tolist(), self.b.tolist()
        if self.in_plane:
            slips, closed = self.slip_velocity.tolist(), self.bilateral.tolist()
            planes = [
                planar(i, own[0].mu, sign_of(slips[i]), closed[i])
                for i, own in enumerate(self.friction)
            ]
            return ScaledLaw(W, b, planes)
        constraints = []
        for i, (own, rows, slip) in enumerate(
            zip(self.friction, self.rows, self.slips, strict=True)
        ):
            if is_brake(own):
                constraints.append(pressed(W, b, own[0], rows[0], slip))
                continue
            balls, start = [], 1
            for ball in own:
                end = start + ball.n_tangents
                way = unit_vector(slip[start - 1 : end - 1])
                balls.append(Ball(rows[start:end], ball.mu, way))
                start = end
            both = bool(self.bilateral[i])
            constraints.append(
                Constraint(rows[0], tuple(balls), not both, (1, -1) if both else (1,))
            )
        return ScaledLaw(W, b, constraints)
