"""The path of an impact of several contacts in NumPy: the oracle of the compiled one.

It is derived in ``painleve_sym/engines/simultaneous.py``; this is a second writing of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.contact_rows import ContactRows
from painleve_sym.engines.simultaneous import (
    AtOnce,
    ImpulsePiece,
    PathEvent,
    PathRecord,
    SimultaneousImpact,
    Straight,
)
from painleve_sym.laws.restitution import restitution_law
from painleve_sym.problem.complementarity.solution_sets import BoolArray
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.impact.one_contact import ImpactEnd
from painleve_sym.problem.impact.path import binary_exponent
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.solution import ContactSolution

# Of the sum of the terms of a rate: less is the rounding of an inverse mass matrix.
_ROUNDING = 1e-12
# Of the largest force, or of the terms of a rate: what an inequality may be missed by.
_TOLERANCE = 1e-9
# Events of a piece nearer to each other than this part of it happen at once.
_COINCIDENT = 1e-12
# Of the largest velocity before. Stops may accumulate in ever smaller velocities: one nearer than
# the first to its border, or to 0 of a slip, is there, and so are all of the contacts that push
# where all are nearer than the second.
_ROUND_OFF, _ALL_ROUND_OFF = 1e-14, 1e-10
# Of a mobility with a unit diagonal: a singular value below the first is zero. Of the largest
# mobility: what is then added to tell the least of several impulses of one effect.
_SINGULAR, _REGULAR = 1e-12, 1e-8
# Of the sum of the terms of a rate: two that differ by less are one.
_EQUAL_RATES = 1e-6
_PIECE_LIMIT = 1000
"""Pieces after which a path counts as endless; a path of two contacts has about ten."""


def path_in_numpy(
    W: Array,
    mu: Array,
    velocity: Array,
    restitution: str = "energetic",
    e: float | Array = 0.75,
    *,
    final_slip: bool = False,
    load: Array | None = None,
    bilateral: BoolArray | None = None,
) -> SimultaneousImpact:
    """Return the impact of n closed contacts; see `solve_simultaneous_impact`."""
    W, mu, v = (np.asarray(a, dtype=float) for a in (W, mu, velocity))
    held = np.zeros(len(mu), dtype=bool) if bilateral is None else np.asarray(bilateral, dtype=bool)
    # Powers of two leave every digit.
    mass, speed = binary_exponent(*np.diag(W).tolist()), binary_exponent(*v.tolist())
    shares = np.broadcast_to(np.asarray(e, dtype=float), len(mu))
    path = _Path(np.ldexp(W, -mass), mu, np.ldexp(v, -speed), held, restitution, shares)
    normals = path.rows.normals
    pressing = np.zeros(len(mu)) if load is None else np.asarray(load, dtype=float)[normals]
    if final_slip:
        ended = path.take_at_once(shares if np.any(v[normals] < 0) else None)
    else:
        ended = path.follow(np.where(held, 0.0, pressing))
    pushed = (~held & (piece.impulses[normals] != 0) for piece in path.pieces)
    active = {int(i) for pushing in pushed for i in np.flatnonzero(pushing)}
    if not final_slip and restitution == "newton" and len(active) > 1 and np.any(v[normals] < 0):
        ended = path.restart_at_once()
    pieces = tuple(
        ImpulsePiece(
            np.ldexp(piece.impulses, speed - mass),
            np.ldexp(piece.velocities, speed),
            np.ldexp(piece.works, 2 * speed - mass),
        )
        for piece in path.pieces
    )
    # Of a contact that others held, rounding may be left.
    path.v = np.where(np.abs(path.v - path.rest) <= _ROUND_OFF, path.rest, path.v)
    parted = bool(np.any(path.v[normals] > 0))
    end = ImpactEnd.SEPARATION if parted else ImpactEnd.PERSISTENT
    if not ended:
        end = ImpactEnd.JAM
    steps = tuple(path.steps)
    own = path.W, mu, path.start, path.border, held
    record = PathRecord(*own, restitution_law(restitution), shares, mass, speed, steps)
    return SimultaneousImpact(end, v, np.ldexp(path.v, speed), pieces, record)


class _Local(NamedTuple):
    """One way in which a contact may push: dP/dτ = fixed + unknown directions.

    `fixed` are the parts of (dP_n/dτ, dP_t/dτ) that are known, `directions` one of (dP_n, dP_t) for
    each unknown, `vanishing` the rates, 0 of v_n and 1 of v_t, that the unknowns make vanish. A
    sign is ``(entry, sign)`` for sign · dv_entry/dτ ≥ 0; `side` is the sign of dP_n/dτ of a
    bilateral contact that slips, 0 for either.
    """

    fixed: tuple[float, float]
    directions: tuple[tuple[float, float], ...] = ()
    vanishing: tuple[int, ...] = ()
    signs: tuple[tuple[int, int], ...] = ()
    side: int = 0


class _Candidate(NamedTuple):
    """dP/dτ of one way for each contact, as in `Straight`; `missed` is by how much it fails."""

    missed: float
    push: Array
    fixed: Array
    columns: Array
    rows: tuple[int, ...]
    alone: bool = True


class _Path:
    """The path of an impact as it is followed; its numbers are of order 1."""

    def __init__(
        self, W: Array, mu: Array, v: Array, held: BoolArray, restitution: str, e: Array
    ) -> None:
        self.W, self.mu, self.held, self.restitution, self.e = W, mu, held, restitution, e
        self.v, self.start = v.copy(), v
        self.rows = ContactRows(len(mu))
        self.normals, self.tangentials = self.rows.normals, self.rows.tangentials
        self.rest = np.zeros_like(v)
        self.border = self.rest[self.normals]
        if restitution == "newton":
            rebound = -e * v[self.normals]
            self.border += np.where(rebound > _ROUND_OFF, rebound, 0.0)
        self.budget = np.zeros(len(mu))
        self.weights = np.ones(len(mu))
        self.work = 0.0
        self.pieces: list[ImpulsePiece] = []
        self.steps: list[Straight | AtOnce] = []

    def follow(self, pressing: Array) -> bool:
        """Follow the path to where no contact pushes; False where it never gets there."""
        without_collision = bool(np.all(self.v[self.normals] >= 0))
        if not without_collision:
            self._weigh()
        for _ in range(_PIECE_LIMIT):
            chosen = self._push(pressing if without_collision else None)
            if chosen is None:
                # Friction of a guide leaves no slow way: it stops the slip at once.
                if not (np.any(self.held) and self.take_at_once(None)):
                    return False
                without_collision = False
                continue
            without_collision = False
            push = chosen.push
            if not np.any(push):
                if np.all(self.v[self.normals] >= self.border):
                    return True
                self._weigh()
                continue
            rates = self._rates(push)
            events = sorted(self._events(push, rates))
            if not events or events[0].length == math.inf:
                return False
            v, budget = self.v, self.budget.copy()
            compresses = np.array([self._compresses(i, push, rates) for i in range(len(self.mu))])
            self._advance(push, rates, events[0].length)
            self.steps.append(
                Straight(
                    fixed=chosen.fixed,
                    columns=chosen.columns,
                    rows=chosen.rows,
                    velocities=v,
                    budget=budget,
                    push=push,
                    rates=rates,
                    compresses=compresses,
                    rubs=self._rubs(push),
                    event=events[0],
                    velocities_after=self.v,
                    budget_after=self.budget.copy(),
                    work_after=self.work,
                    alone=chosen.alone,
                )
            )
        return False

    def _weigh(self) -> None:
        """Set dP_n/dτ of the contacts that push, the largest 1, by what would stop them at once."""
        self.weights = np.ones(len(self.mu))
        if len(self.mu) > 1:
            none, still = np.zeros_like(self.v), np.zeros(len(self.mu))
            nothing = AtOnce(True, still, self.v, none, none, (), np.empty((len(none), 0)))
            solution = self._at_once(still, weighs=True) or nothing
            stops = np.where(self.held, 0.0, solution.impulses[self.normals])
            if np.any(stops > 0):
                self.weights = stops / np.max(stops)
            self.steps.append(solution)

    def _at_once(self, e: Array | None, weighs: bool = False) -> AtOnce | None:
        """Return impulses P and rates a = aim + W P with 0 ≤ P_n ⟂ a_n ≥ 0, friction against a_t.

        A guide has a_n = 0 and |P_n| in its friction. Those of least normal impulse of the
        contacts that open; where the bodies' rigidity leaves them open, those that a little more
        mobility of every contact selects. None where there are none.

        The aim (1 + e) v_n, v_t follows from e; None is for a stop that has to change the
        velocities. Where it `weighs` only the weights follow from it.
        """
        W, aim, moving = self.W, self.v.copy(), e is None
        aim[self.normals] -= -_share_of(e) * self.v[self.normals]
        if self._is_singular:
            W = W + _REGULAR * (float(np.max(np.diag(W))) or 1.0) * np.eye(len(aim))
        solution = self._least(W, aim, moving)
        if solution is None:
            return None
        rows, U = self._unknowns(solution)
        if not self._is_singular:
            parts = solution.normal_accelerations, solution.tangential_accelerations
            accelerations = np.ravel(parts, order="F")
            own = _forces(solution), accelerations, tuple(rows), U
            return AtOnce(weighs, e, self.v, *own)
        # The limit of ever less mobility added, in the same modes.
        impulses = np.zeros(len(aim))
        if rows:
            impulses = U @ _solution_in_range(self.W[rows] @ U, -aim[rows])
            impulses[self.normals] = np.where(
                self.held, impulses[self.normals], np.maximum(0.0, impulses[self.normals])
            )
        # Impulses of the mobility added may grow beyond all bounds: they have no limit.
        rates, share = aim + self.W @ impulses, self._share(impulses, aim)
        if self._missed(impulses, share, rows) > _TOLERANCE:
            return None
        rates[np.abs(share) <= _ROUNDING] = 0.0
        rates[rows] = 0.0
        return AtOnce(weighs, e, self.v, impulses, rates, tuple(rows), U)

    def _unknowns(self, solution: ContactSolution) -> tuple[list[int], Array]:
        """Return the rates that the modes of a solution make vanish, and directions of impulses."""
        size = self.rows.size
        rows, columns = list[int](), list[Array]()
        for i, mode in enumerate(solution.modes):
            if mode is ContactMode.LIFTOFF:
                continue
            n, t = self.rows.normal(i), self.rows.tangent(i)
            own = np.eye(size)[:, self.rows.of(i)]
            sticks = mode is ContactMode.STICK and self.mu[i] > 0
            side = -1.0 if solution.normal_forces[i] < 0 else 1.0
            friction = side * self.mu[i]
            slope = {ContactMode.SLIP_POS: -friction, ContactMode.SLIP_NEG: friction}
            columns += list(own.T) if sticks else [own @ (1.0, slope.get(mode, 0.0))]
            rows += [n, t] if sticks else [n]
        return rows, np.array(columns).reshape(-1, size).T

    def _share(self, impulses: Array, aim: Array) -> Array:
        """Return aim + W P as parts of the largest that terms of such impulses can be."""
        size = np.sqrt(np.diag(self.W))
        terms = np.abs(aim) + size * (size @ np.abs(impulses))
        share: Array = np.zeros_like(aim)
        np.divide(aim + self.W @ impulses, terms, out=share, where=terms > 0)
        return share

    def _missed(self, impulses: Array, share: Array, rows: list[int]) -> float:
        """Return by how much impulses of one mode for each contact miss the laws of the contacts.

        `share` is `_share` of the impulses, and `rows` are the rates that the modes make vanish.
        """
        size = np.sqrt(np.diag(self.W))
        largest = float(np.max(size * np.abs(impulses))) or 1.0
        normal, tangential = np.abs(impulses[self.normals]), impulses[self.tangentials]
        beyond = size[self.tangentials] * (np.abs(tangential) - self.mu * normal) / largest
        along = size[self.tangentials] * tangential / largest * share[self.tangentials]
        return float(
            max([*np.abs(share[rows]), *-share[self.normals][~self.held], *along, *beyond])
        )

    @cached_property
    def _is_singular(self) -> bool:
        """Whether rigidity leaves impulses open: of unit diagonal, W has a zero singular value."""
        root = np.sqrt(np.diag(self.W))
        size = np.outer(root, root)
        unit = np.divide(self.W, size, out=np.zeros_like(self.W), where=size > 0)
        return not np.linalg.svd(unit, compute_uv=False)[-1] > _SINGULAR

    def _least(self, W: Array, aim: Array, moving: bool) -> ContactSolution | None:
        """Return the solution of least normal impulse."""
        problem = ContactProblem(W, aim, self.mu, np.zeros(len(self.mu)), self.held)
        solutions = problem.solutions()
        if moving:
            solutions = tuple(s for s in solutions if np.any(self._rates(_forces(s))))

        def size(s: ContactSolution) -> tuple[float, float]:
            opening, guided = s.normal_forces[~self.held], np.abs(s.normal_forces[self.held])
            return round(float(opening.sum()), 9), round(float(guided.sum()), 9)

        return min(solutions, key=size, default=None)

    def restart_at_once(self) -> bool:
        """Replace the path by Newton's law for all contacts at once; False without a solution."""
        self.pieces, self.steps, self.v = [], [], self.start
        return self.take_at_once(self.e)

    def take_at_once(self, e: Array | None) -> bool:
        """Continue by Newton's law for all contacts at once; False without a solution.

        Without e it is a stop that has to change the velocities.
        """
        before, solution = self.v, self._at_once(e)
        if solution is None:
            return False
        self.v = solution.rates.copy()
        self.v[self.normals] += -_share_of(e) * before[self.normals]
        works = solution.impulses * (before + self.v) / 2
        self.pieces.append(ImpulsePiece(solution.impulses, self.v, works))
        self.steps.append(solution)
        return True

    # ---- how the contacts push ----

    def _rates(self, push: Array) -> Array:
        """Return dv/dτ, exactly 0 where it is within the rounding of its terms."""
        rates = self.W @ push
        rates[np.abs(rates) <= _ROUNDING * (np.abs(self.W) @ np.abs(push))] = 0.0
        return rates

    def _push(self, pressing: Array | None) -> _Candidate | None:
        """Return dP/dτ: of several possible ones that of least normal force.

        Parameters
        ----------
        pressing : ndarray, shape (n,), optional
            For an impact without collision: b_n. The velocities then have to change, and contacts
            with b_n < 0 push first. None where no such impact is possible.
        """
        local = [self._local(i) for i in range(len(self.mu))]
        candidates = [self._candidate(choice) for choice in product(*local)]
        if pressing is not None:
            size = float(np.max(np.abs(pressing))) or 1.0
            moving = [
                c for c in candidates if c.missed <= _TOLERANCE and np.any(self._rates(c.push))
            ]

            def pressed(c: _Candidate) -> tuple[float, float, float]:
                return round(float(c.push[self.normals] @ pressing) / size, 9), *self._order(c)

            return self._first(moving, pressed)
        # Without guides one exists, by Kakutani's theorem: where rounding hides it, the nearest is
        # taken.
        bound = _TOLERANCE
        if not np.any(self.held):
            bound = max(bound, min(c.missed for c in candidates))
        return self._first([c for c in candidates if c.missed <= bound], self._order)

    def _first(
        self, possible: list[_Candidate], order: Callable[[_Candidate], tuple[float, ...]]
    ) -> _Candidate | None:
        """Return the candidate that is least in an order, and whether all have its dv/dτ."""
        if not possible:
            return None
        least = min(possible, key=order)
        terms = np.abs(self.W) @ np.max([np.abs(c.push) for c in possible], axis=0)
        others = (np.abs(self.W @ (c.push - least.push)) for c in possible)
        return least._replace(alone=not any(np.any(d > _EQUAL_RATES * terms) for d in others))

    def _local(self, i: int) -> list[_Local]:
        """Return the ways in which contact i may push at the present velocity."""
        v_n, v_t = self.v[self.rows.of(i)]
        stuck = [_Local((0.0, 0.0), ((1.0, 0.0), (0.0, 1.0)), (0, 1))]
        if v_t != 0 or self.mu[i] == 0:
            stuck = []
        if self.held[i]:
            sides = (1, -1) if self.mu[i] > 0 else (0,)
            slips = product(self._slips(i), sides)
            return stuck + [
                _Local((0.0, 0.0), ((1.0, (side or 1) * r),), (0,), s, side)
                for (r, s), side in slips
            ]
        if v_n < self.border[i] or self.budget[i] > 0:
            return list(self._pushing(i, float(self.weights[i]), ()))
        parts = _Local((0.0, 0.0))
        if v_n > self.border[i]:
            return [parts]
        parts = _Local((0.0, 0.0), (), (), ((0, 1),))
        held = [_Local((0.0, 0.0), ((1.0, r),), (0,), s) for r, s in self._slips(i)]
        return [parts, *held, *stuck, *self._pushing(i, 1.0, ((0, -1),))]

    def _pushing(
        self, i: int, weight: float, signs: tuple[tuple[int, int], ...]
    ) -> Iterator[_Local]:
        for ratio, slip_signs in self._slips(i):
            yield _Local((weight, weight * ratio), (), (), signs + slip_signs)
        if self.v[self.rows.tangent(i)] == 0 and self.mu[i] > 0:
            yield _Local((weight, 0.0), ((0.0, 1.0),), (1,), signs)

    def _slips(self, i: int) -> list[tuple[float, tuple[tuple[int, int], ...]]]:
        """Return dP_t/dP_n of the slips that are possible, with the sign of dv_t they need."""
        mu, v_t = float(self.mu[i]), self.v[self.rows.tangent(i)]
        if mu == 0:
            return [(0.0, ())]
        if v_t != 0:
            return [(-mu if v_t > 0 else mu, ())]
        return [(-mu, ((1, 1),)), (mu, ((1, -1),))]

    def _candidate(self, choice: tuple[_Local, ...]) -> _Candidate:
        size = len(self.v)
        fixed, columns, rows = np.zeros(size), list[Array](), list[int]()
        for i, local in enumerate(choice):
            fixed[self.rows.of(i)] = local.fixed
            for direction in local.directions:
                column = np.zeros(size)
                column[self.rows.of(i)] = direction
                columns.append(column)
            rows += [self.rows.row(i, entry) for entry in local.vanishing]
        push, U = fixed, np.array(columns).reshape(-1, size).T
        if rows:
            # Of least norm where several bodies' rigidity leaves the forces open.
            matrix, right = self.W[rows] @ U, -(self.W @ fixed)[rows]
            push = fixed + U @ np.linalg.lstsq(matrix, right, rcond=_ROUNDING)[0]
            # Exactly 1 marks a full push, which one that only holds is not.
            for i, local in enumerate(choice):
                n = self.rows.normal(i)
                if 0 in local.vanishing and push[n] == 1:
                    push[n] = math.nextafter(1.0, 0.0)
        return _Candidate(self._violation(choice, rows, push), push, fixed, U, tuple(rows))

    def _violation(self, choice: tuple[_Local, ...], rows: list[int], push: Array) -> float:
        normal, tangential = push[self.normals], push[self.tangentials]
        size, free = 1.0 + float(np.max(self.mu)), normal[~self.held]
        beyond = np.abs(tangential) - self.mu * np.where(self.held, np.abs(normal), normal)
        worst = [
            float(np.max(-free, initial=-math.inf)),
            float(np.max(free - 1.0, initial=-math.inf)),
            float(np.max(beyond)) / size,
            *(-w.side * float(normal[i]) for i, w in enumerate(choice) if w.side),
        ]
        terms = np.abs(self.W) @ np.abs(push)
        share = np.divide(self.W @ push, terms, out=np.zeros_like(terms), where=terms > 0)
        worst += [abs(float(share[row])) for row in rows]
        for i, local in enumerate(choice):
            worst += [-sign * float(share[self.rows.row(i, entry)]) for entry, sign in local.signs]
        return max(worst)

    def _order(self, candidate: _Candidate) -> tuple[float, float]:
        """Return what is least in the preferred one of several pushes, but for rounding."""
        push = candidate.push
        return round(float(push[self.normals][~self.held].sum()), 9), round(float(push @ push), 9)

    # ---- one piece ----

    def _events(self, push: Array, rates: Array) -> Iterator[PathEvent]:
        """Yield what changes on the present piece."""

        def events(lengths: Iterator[float], kind: str, i: int = 0) -> Iterator[PathEvent]:
            return (PathEvent(length, kind, i) for length in lengths)

        for i, (n, t) in enumerate(self.rows.each()):
            crossing = _crossing(self.v[n] - self.border[i], rates[n])
            yield from events(crossing, "border", i)
            if self._rubs(push)[i]:
                yield from events(_crossing(self.v[t], rates[t]), "slip", i)
            yield from events(self._spent(i, push, rates), "spent", i)
        if self.restitution == "poisson":
            yield from events(self._energy_is_back(push, rates), "energy")

    def _rubs(self, push: Array) -> BoolArray:
        """Return which contacts have a normal force, shape (n,)."""
        normal = push[self.normals]
        return np.where(self.held, normal != 0, normal > 0)

    def _spent(self, i: int, push: Array, rates: Array) -> Iterator[float]:
        """Yield the length at which contact i has given back its restitution."""
        n, budget = self.rows.normal(i), self.budget[i]
        v_n, a_n, force = self.v[n], rates[n], push[n]
        if budget == 0 or force == 0 or self._compresses(i, push, rates):
            return
        if self.restitution == "poisson":
            yield budget / force
            return
        # v_n P + a_n P²/2 = budget, without the cancellation of the usual root.
        square = v_n * v_n + 2 * a_n * budget / force
        if square > 0:
            yield 2 * budget / force / (v_n + math.sqrt(square))

    def _compresses(self, i: int, push: Array, rates: Array) -> bool:
        """Return whether contact i compresses, also if it pushes fully at v_n = 0 to no effect."""
        if self.held[i]:
            return False
        n = self.rows.normal(i)
        v_n, a_n = self.v[n], rates[n]
        begins = a_n == 0 and push[n] == 1 and self.budget[i] == 0
        return bool(v_n < 0 or (v_n == 0 and (a_n < 0 or begins)))

    def _energy_is_back(self, push: Array, rates: Array) -> Iterator[float]:
        """Yield the length at which the contacts have given back all energy they took."""
        power, slope = float(push @ self.v), float(push @ rates)
        square = power * power - 2 * slope * self.work
        if self.work < 0 and square > 0 and (slope > 0 or power > 0):
            root = math.sqrt(square)
            yield -2 * self.work / (power + root) if power > 0 else (root - power) / slope

    def _advance(self, push: Array, rates: Array, length: float) -> None:
        """Follow the present piece over `length`; what vanishes there vanishes exactly."""
        before, impulses = self.v, push * length
        after = before + rates * length
        # What leaves the border under a push leaves it under a full one, and keeps it.
        self.weights[(before[self.normals] == self.border) & (self.budget == 0)] = 1.0
        budget = self.budget.copy()
        reached = length * (1 + _COINCIDENT)
        for i, (n, t) in enumerate(self.rows.each()):
            budget[i] = self._budget_after(i, length, before[n] + after[n], push, rates)
            if any(x <= reached for x in self._spent(i, push, rates)):
                budget[i] = 0.0
            if any(x <= reached for x in _crossing(before[n] - self.border[i], rates[n])):
                after[n] = self.border[i]
            if self._rubs(push)[i] and any(x <= reached for x in _crossing(before[t], rates[t])):
                after[t] = 0.0
        lapses = self.restitution == "poisson" and any(
            x <= reached for x in self._energy_is_back(push, rates)
        )
        works = impulses * (before + after) / 2
        self.pieces.append(ImpulsePiece(impulses, after, works))
        pushing = np.repeat(self._rubs(push), 1 + self.rows.n_tangents)
        off = np.abs(after - self.rest)
        small = _ALL_ROUND_OFF if np.all(off[pushing] <= _ALL_ROUND_OFF) else _ROUND_OFF
        after = np.where(pushing & (off <= small), self.rest, after)
        # Contacts that do not push may come to rest with the others, of one body.
        after[~pushing & (np.abs(after) <= _ROUND_OFF)] = 0.0
        budget[budget <= (_ROUND_OFF if self.restitution == "poisson" else _ROUND_OFF**2)] = 0.0
        self.v, self.work = after, 0.0 if lapses else self.work + math.fsum(works)
        self.budget = np.zeros_like(budget) if lapses else budget

    def _budget_after(
        self, i: int, length: float, twice_mean: float, push: Array, rates: Array
    ) -> float:
        budget, impulse = float(self.budget[i]), float(push[self.rows.normal(i)]) * length
        if self.restitution == "newton":
            return 0.0
        poisson = self.restitution == "poisson"
        given_back = impulse if poisson else impulse * twice_mean / 2
        if self._compresses(i, push, rates):
            return budget + self.e[i] * impulse if poisson else budget - self.e[i] ** 2 * given_back
        return max(0.0, budget - given_back) if budget > 0 else 0.0


def _share_of(e: Array | None) -> Array | float:
    return 0.0 if e is None else e


def _crossing(value: float, rate: float) -> Iterator[float]:
    """Yield the length after which a value that is not 0 becomes 0."""
    if value * rate < 0:
        yield -value / rate


def _solution_in_range(matrix: Array, right: Array) -> Array:
    """Return the limit for ε → 0 of the solution of (matrix + ε) x = right.

    Where the matrix is singular, it is the solution that lies in the range of the matrix.
    """
    left, stretch, ways = np.linalg.svd(matrix)
    rank = int(np.sum(stretch > _ROUNDING * stretch[0]))
    x: Array = ways[:rank].T @ (left[:, :rank].T @ right / stretch[:rank])
    if rank < len(right):
        beyond, free = left[:, rank:].T, ways[rank:].T
        x = x - free @ np.linalg.lstsq(beyond @ free, beyond @ x, rcond=_ROUNDING)[0]
    return x


def _forces(solution: ContactSolution) -> Array:
    return np.ravel([solution.normal_forces, solution.tangential_forces], order="F")
