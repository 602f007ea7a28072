"""The laws of contacts in space, by which forces are checked; `scaled_law` has the plane's."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from painleve_sym.complementarity.solution_sets import FloatArray
from painleve_sym.contact_rows import ContactRows
from painleve_sym.contacts.friction_set import FrictionSet
from painleve_sym.contacts.local_mode import ContactMode, Vector
from painleve_sym.contacts.scaled_law import DISTINCT, SIGN, ratio


class BallLaw:
    """The laws of all contacts on scaled forces: friction within a ball of radius μ F_n.

    All measures are free of units and of the choice of the tangents: forces and accelerations of
    the tangents count by their length. W, b and μ are scaled to order one, so that μ is not that of
    `friction`; `ways` are the unit vectors of slip, empty at rest, and `rows` the rows of each
    contact, the normal one first.
    """

    def __init__(
        self,
        W: FloatArray,
        b: FloatArray,
        mu: Vector,
        friction: Sequence[FrictionSet],
        ways: Sequence[tuple[float, ...]],
        rows: Sequence[tuple[int, ...]],
    ) -> None:
        self.W, self.b, self.mu = W, b, mu
        self.friction, self.ways, self.rows = friction, ways, rows
        self.parts = [part for own in rows for part in ([own[0]], list(own[1:]))]
        self.count = len(rows)
        self.at = ContactRows(self.count)  # of the parts: normals, and tangents by their length
        entries: list[Vector] = W.tolist()
        self.sizes = [
            [math.hypot(*(entries[i][j] for i in p for j in q)) for q in self.parts]
            for p in self.parts
        ]
        self.offsets = self._lengths(b)

    def _lengths(self, vector: npt.NDArray[np.float64]) -> Vector:
        return [math.hypot(*vector[p].tolist()) for p in self.parts]

    def _terms(self, lengths: Vector) -> Vector:
        return [
            sum(map(operator.mul, row, lengths)) + offset
            for row, offset in zip(self.sizes, self.offsets, strict=True)
        ]

    def residual(self, forces: Vector) -> float:
        """Return the largest violation of a law, as a fraction of its terms."""
        point = np.array(forces)
        if not np.isfinite(point).all():
            return math.inf
        a, lengths = self.W @ point + self.b, self._lengths(point)
        terms, worst = self._terms(lengths), 0.0
        for i in range(self.count):
            n, t = self.at.normal(i), self.at.tangent(i)
            normal, (a_n,) = float(point[self.parts[n][0]]), a[self.parts[n]].tolist()
            friction, a_t = point[self.parts[t]].tolist(), a[self.parts[t]].tolist()
            leaving = ratio(a_n, terms[n])
            weight = max(
                ratio(self.sizes[k][n] * abs(normal), terms[k]) for k in range(self.at.size)
            )
            held = max(weight if normal < 0 else min(weight, abs(leaving)), -leaving, 0.0)
            if normal == 0 and leaving < -SIGN:
                return 1.0
            limit = self.mu[i] * max(normal, 0.0)
            span = lengths[t] + limit
            outside = ratio(lengths[t] - limit, span)
            if self.ways[i]:
                missed = math.hypot(
                    *(f + limit * e for f, e in zip(friction, self.ways[i], strict=True))
                )
                opposing = ratio(missed, span)
            else:
                size = terms[t] * lengths[t]
                along = ratio(sum(map(operator.mul, friction, a_t)), size)
                across = 0.0
                if len(friction) == 2:
                    across = ratio(abs(friction[0] * a_t[1] - friction[1] * a_t[0]), size)
                inside = min(
                    max(-outside, 0.0), ratio(math.hypot(*a_t), terms[t])
                )  # less than the limit only without acceleration
                opposing = max(inside, across, along if along > SIGN else 0.0)
            worst = max(worst, held, outside, opposing)
        return worst

    def modes(self, forces: Vector) -> list[ContactMode]:
        """Return the modes that forces show."""
        point, modes = np.array(forces), []
        lengths = self._lengths(point)
        for i, e in enumerate(self.ways):
            normal = float(point[self.parts[self.at.normal(i)][0]])
            size = lengths[self.at.tangent(i)]
            if normal == 0:
                modes.append(ContactMode.LIFTOFF)
            elif e or size >= self.mu[i] * normal * (1 - 1e-9):
                modes.append(ContactMode.SLIP)
            else:
                modes.append(ContactMode.STICK)
        return modes

    def same(self, first: Vector, second: Vector) -> bool:
        """Return whether two forces are equal, or with several contacts their accelerations."""
        if self.near(first, second):
            return True
        step, terms = self._step(first, second)
        moved = self._lengths(self.W @ step)
        return self.count > 1 and all(map(lambda s, size: s <= DISTINCT * size, moved, terms))

    def near(self, first: Vector, second: Vector) -> bool:
        """Return whether the step between two forces is negligible for every acceleration."""
        step, terms = self._step(first, second)
        lengths = self._lengths(step)
        return all(
            ratio(w * s, size) <= DISTINCT
            for row, size in zip(self.sizes, terms, strict=True)
            for w, s in zip(row, lengths, strict=True)
        )

    def _step(self, first: Vector, second: Vector) -> tuple[FloatArray, Vector]:
        """Return the step between two forces, and the terms of accelerations by the larger ones."""
        p, q = np.array(first), np.array(second)
        return p - q, self._terms(list(map(max, self._lengths(p), self._lengths(q))))

    def order(self, forces: Vector) -> Vector:
        """Return by what solutions are ordered: the normal forces, then the others."""
        point = np.array(forces)
        return [*point[[p[0] for p in self.parts[self.at.normals]]].tolist(), *forces]
