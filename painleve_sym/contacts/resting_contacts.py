"""Forces of several contacts of which some rest in space: Newton's method from many starts.

Normal and friction forces solve a nonlinear complementarity problem, written with projections::

    F_n = max(0, F_n - r a_n),    F_t = P(F_t - r a_t),    a = W F + b

where P projects on the disc (or interval) of radius μ max(0, F_n - r a_n). The equations have
kinks, and Newton's method with one-sided derivatives converges locally as fast as on smooth ones
(Alart & Curnier 1991). The starts are the solutions of the same contacts with pyramids instead of
cones: each contact lifts off, sticks, or slips along one of the edges, and every choice is one
linear system. No finite number of starts proves that nothing was missed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from painleve_sym.complementarity.solution_sets import RANK, FloatArray
from painleve_sym.contacts.ball_law import BallLaw
from painleve_sym.contacts.disc_at_rest import forces_at_rest
from painleve_sym.contacts.friction_set import Disc
from painleve_sym.contacts.local_mode import ContactMode, IntArray, Vector
from painleve_sym.errors import InputError

MAX_STARTS = 1500
"""Of one search: some seconds at most."""

_SIDES = (12, 8, 6, 4)  # of the pyramids, as many as the number of starts allows
_ITERATIONS = 40
_PIECES = {ContactMode.LIFTOFF: 0, ContactMode.SLIP: 1, ContactMode.STICK: 3}
_STEPS = (1.0, 0.5, 0.25, 0.1, 0.01)  # parts of a Newton step
_CONVERGED = 1e-11  # of the forces; the law's own residual is checked later
_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


class _Contact:
    """One contact of the search: its rows, friction, direction of slip, and step lengths."""

    def __init__(self, law: BallLaw, i: int) -> None:
        W, (self.n, *self.t), way = law.W, law.rows[i], law.ways[i]
        self.mu, self.kind = law.mu[i], law.friction[i]
        self.way = np.array(way) if way else None
        if not self.mu and self.way is None:
            self.way = np.zeros(len(self.t))  # no friction: no force along the tangents
        block = W[np.ix_(self.t, self.t)]
        stretch = float(np.linalg.norm(block, 2))
        self.r_n = 1 / W[self.n, self.n] if W[self.n, self.n] > 0 else 1.0
        self.r_t = 1 / stretch if stretch > 0 else 1.0

    def choices(self, sides: int) -> list[tuple[FloatArray, list[int]]]:
        """Return force directions (columns) and vanishing rows: lift-off, slips, sticking."""
        size = 1 + len(self.t)
        offered = [(np.zeros((size, 0)), list[int]())]
        ways = [self.way] if self.way is not None else list(map(np.array, self.kind.sampled(sides)))
        for way in ways:
            column = np.concatenate([[1.0], -self.mu * way])[:, None]
            offered.append((column, [self.n]))
        if self.way is None:
            offered.append((np.eye(size), [self.n, *self.t]))
        return offered


def search(law: BallLaw) -> list[Vector]:
    """Return forces to which Newton's method converged, each start's; still to be checked.

    Raises
    ------
    InputError
        For contacts with more than `MAX_STARTS` starts. Fix: ask about fewer contacts.
    """
    contacts = [_Contact(law, i) for i in range(law.count)]
    for sides in _SIDES:
        choices = [c.choices(sides) for c in contacts]
        count = math.prod(map(len, choices))
        if count <= MAX_STARTS:
            break
    else:
        resting = sum(isinstance(c.kind, Disc) and c.way is None for c in contacts)
        raise InputError(
            f"solutions() searches from too many starts: got {len(contacts)} contacts, {resting} "
            f"of them in space at rest, which make {count} starts, need at most {MAX_STARTS}. "
            "Fix: ask about fewer contacts."
        )
    starts, pieces = _starts(law, contacts, choices)
    # The second method continues with the pieces of its start, and reaches solutions that the first
    # one leaves for others.
    ends = [
        force
        for method in (_Projections, _Pieces)
        for force in _newton(method(law.W, law.b, contacts), starts, pieces)
    ]
    settled = np.array([_settled(law, contacts, force) for force in ends]).reshape(-1, len(law.b))
    _, first = np.unique(np.round(settled, 10), axis=0, return_index=True)
    return [force.tolist() for force in settled[np.sort(first)]]


def solve_one(law: BallLaw, resting: int) -> list[tuple[Vector, bool]] | None:
    """Return the forces of all choices, where one disc rests and the other contacts have pieces.

    Each choice of pieces of the others makes their forces follow from those of the disc, and
    leaves its own problem, with all its solutions. `resting` is the disc. Forces still are to be
    checked; with each whether it is isolated. None where a choice does not determine the other
    forces, or there are too many choices.
    """
    W, b, contacts = law.W, law.b, [_Contact(law, i) for i in range(law.count)]
    others = [c for i, c in enumerate(contacts) if i != resting]
    choices = [c.choices(0) for c in others]
    if math.prod(map(len, choices)) > MAX_STARTS:
        return None
    own, forces = list(law.rows[resting]), list[tuple[Vector, bool]]()
    method = _Pieces(W, b, contacts)
    for chosen in itertools.product(*choices):
        free, vanish = _columns(len(b), others, chosen)
        block, rates = (W @ free)[vanish], (W @ free)[own]
        if vanish and np.linalg.svd(block, compute_uv=False)[-1] <= RANK * len(b):
            return None
        tied = np.linalg.solve(block, np.column_stack([W[vanish][:, own], b[vanish]]))
        reduced, offset = W[np.ix_(own, own)] - rates @ tied[:, :3], b[own] - rates @ tied[:, 3]
        for rest in forces_at_rest(reduced.tolist(), offset.tolist(), law.mu[resting]):
            whole = -free @ (tied @ [*rest.force, 1.0])
            whole[own] = rest.force
            pieces = [len(v) for _, v in chosen]
            pieces.insert(resting, _PIECES[rest.mode])
            polished = _newton(method, whole[None], np.array([pieces]))
            forces += [(f.tolist(), rest.isolated) for f in (*polished, whole)]
    return forces


def _columns(
    size: int, contacts: Sequence[_Contact], chosen: Sequence[tuple[FloatArray, list[int]]]
) -> tuple[FloatArray, list[int]]:
    """Return the directions of the forces of a choice, as columns, and the rows that vanish."""
    ways = np.zeros((size, sum(g.shape[1] for g, _ in chosen)))
    column = 0
    for contact, (way, _) in zip(contacts, chosen, strict=True):
        end = column + way.shape[1]
        ways[[contact.n, *contact.t], column:end] = way
        column = end
    return ways, [row for _, rows in chosen for row in rows]


def _starts(
    law: BallLaw,
    contacts: Sequence[_Contact],
    choices: Sequence[list[tuple[FloatArray, list[int]]]],
) -> tuple[FloatArray, IntArray]:
    """Return the forces of every choice of pieces of the pyramids, shape (starts, r).

    With them the piece of each contact, shape (starts, n): how many of its rows vanish.
    """
    starts, pieces = [], []
    for chosen in itertools.product(*choices):
        ways, vanish = _columns(len(law.b), contacts, chosen)
        block = (law.W @ ways)[vanish]
        x = np.linalg.lstsq(block, -law.b[vanish], rcond=1e-10)[0] if vanish else np.zeros(0)
        starts.append(ways @ x)
        pieces.append([len(rows) for _, rows in chosen])
    return np.array(starts), np.array(pieces)


def _newton(method: _Projections | _Pieces, starts: FloatArray, pieces: IntArray) -> FloatArray:
    """Return the ends of those starts that converge."""
    ends, forces = [np.zeros((0, starts.shape[1]))], starts
    left = method.defects(forces, pieces)
    for _ in range(_ITERATIONS):
        slopes = method.slopes(forces, pieces)
        try:
            step = np.linalg.solve(slopes, -left[..., None])[..., 0]
        except np.linalg.LinAlgError:  # one of them is singular
            step = -(np.linalg.pinv(slopes) @ left[..., None])[..., 0]
        tried = np.array([forces + part * step for part in _STEPS])
        sizes = np.array([_size(method.defects(f, pieces)) for f in tried])
        sizes[~np.isfinite(sizes)] = np.inf
        pick = np.argmin(sizes, axis=0)
        better = sizes.min(axis=0) < _size(left)
        ends.append(forces[~better & (_size(left) <= _CONVERGED * (1 + _size(forces)))])
        forces, pieces = tried[pick, np.arange(len(forces))][better], pieces[better]
        if not len(forces):
            break
        left = method.defects(forces, pieces)
    return np.concatenate(ends)


def _size(vectors: FloatArray) -> FloatArray:
    size: FloatArray = np.linalg.norm(vectors, axis=-1)
    return size


@dataclass(frozen=True)
class _Projections:
    """The equations with projections, with a derivative from one side."""

    W: FloatArray
    b: FloatArray
    contacts: Sequence[_Contact]

    def defects(self, forces: FloatArray, _: IntArray) -> FloatArray:
        """Return the defects, shape (m, r)."""
        a, left = forces @ self.W + self.b, np.empty_like(forces)
        for c in self.contacts:
            pressed = np.maximum(forces[:, c.n] - c.r_n * a[:, c.n], 0.0)
            left[:, c.n] = forces[:, c.n] - pressed
            if c.way is not None:
                left[:, c.t] = forces[:, c.t] + c.mu * forces[:, [c.n]] * c.way
                continue
            pulled = forces[:, c.t] - c.r_t * a[:, c.t]
            way, length = _directions(pulled)
            radius = c.mu * pressed[:, None]
            left[:, c.t] = forces[:, c.t] - np.where(length <= radius, pulled, radius * way)
        return left

    def slopes(self, forces: FloatArray, _: IntArray) -> FloatArray:
        """Return the derivatives of the defects, shape (m, r, r)."""
        W = self.W
        a, unit = forces @ W + self.b, np.eye(len(W))
        slope = np.empty((*forces.shape, len(W)))
        for c in self.contacts:
            pressed = forces[:, c.n] - c.r_n * a[:, c.n]
            active = (pressed > 0)[:, None]
            d_pressed = np.where(active, unit[c.n] - c.r_n * W[c.n], 0.0)
            slope[:, c.n] = unit[c.n] - d_pressed
            if c.way is not None:
                slope[:, c.t] = unit[c.t] + c.mu * c.way[:, None] * unit[c.n]
                continue
            pulled = forces[:, c.t] - c.r_t * a[:, c.t]
            d_pulled = unit[c.t] - c.r_t * W[c.t]
            radius = c.mu * np.maximum(pressed, 0.0)[:, None]
            way, length = _directions(pulled)
            part = radius / np.where(length > 0, length, 1.0)
            across = d_pulled - way[:, :, None] * (way[:, None, :] @ d_pulled)
            edge = way[:, :, None] * (c.mu * d_pressed)[:, None, :] + part[:, :, None] * across
            slope[:, c.t] = unit[c.t] - np.where((length <= radius)[:, :, None], d_pulled, edge)
        return slope


@dataclass(frozen=True)
class _Pieces:
    """The equations of given pieces of the law, without its inequalities: smooth ones."""

    W: FloatArray
    b: FloatArray
    contacts: Sequence[_Contact]

    def defects(self, forces: FloatArray, pieces: IntArray) -> FloatArray:
        """Return the defects, shape (m, r)."""
        a, left = forces @ self.W + self.b, np.empty_like(forces)
        for i, c in enumerate(self.contacts):
            off, stuck = (pieces[:, i] == 0)[:, None], (pieces[:, i] > 1)[:, None]
            left[:, c.n] = np.where(off[:, 0], forces[:, c.n], a[:, c.n])
            pull, speed = forces[:, c.t], a[:, c.t]
            slipping = np.empty_like(pull)
            if c.way is not None:
                slipping[:] = pull + c.mu * forces[:, [c.n]] * c.way
            else:
                way, length = _directions(pull)
                slipping[:, :1] = length - c.mu * forces[:, [c.n]]
                if len(c.t) > 1:  # no acceleration across the friction
                    slipping[:, 1] = ((way @ _TURN) * speed).sum(axis=1)
            left[:, c.t] = np.where(off, pull, np.where(stuck, speed, slipping))
        return left

    def slopes(self, forces: FloatArray, pieces: IntArray) -> FloatArray:
        """Return the derivatives of the defects, shape (m, r, r)."""
        W, a = self.W, forces @ self.W + self.b
        unit, slope = np.eye(len(W)), np.empty((*forces.shape, len(W)))
        for i, c in enumerate(self.contacts):
            off, stuck = (pieces[:, i] == 0)[:, None], (pieces[:, i] > 1)[:, None]
            slope[:, c.n] = np.where(off, unit[c.n], W[c.n])
            pull, speed = forces[:, c.t], a[:, c.t]
            edge = np.empty((*pull.shape, len(W)))
            if c.way is not None:
                edge[:] = unit[c.t] + c.mu * c.way[:, None] * unit[c.n]
            else:
                way, length = _directions(pull)
                edge[:, 0] = way @ unit[c.t] - c.mu * unit[c.n]
                if len(c.t) > 1:
                    part = (speed @ _TURN.T) / np.where(length > 0, length, 1.0)
                    part -= way * (part * way).sum(axis=1)[:, None]
                    edge[:, 1] = (way @ _TURN) @ W[c.t] + part @ unit[c.t]
            kinds = np.where(stuck[..., None], W[c.t], edge)
            slope[:, c.t] = np.where(off[..., None], unit[c.t], kinds)
        return slope


def _directions(vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the directions of vectors, shape (m, k), and their lengths, shape (m, 1)."""
    length = _size(vectors)[:, None]
    return vectors / np.where(length > 0, length, 1.0), length


def _settled(law: BallLaw, contacts: Sequence[_Contact], force: FloatArray) -> FloatArray:
    """Return a force with zeros where contacts lift off, and on the cone where they slip."""
    a, settled = law.W @ force + law.b, force.copy()
    for c in contacts:
        if force[c.n] - c.r_n * a[c.n] <= 0:
            settled[[c.n, *c.t]] = 0.0
            continue
        limit = c.mu * force[c.n]
        if c.way is not None:
            settled[c.t] = -limit * c.way
            continue
        pulled = force[c.t] - c.r_t * a[c.t]
        length = math.hypot(*pulled.tolist())
        if length > limit:
            settled[c.t] = limit * pulled / length
    return settled
