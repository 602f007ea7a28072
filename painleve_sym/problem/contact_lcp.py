"""Planar contact problems as linear complementarity problems, and the way back to forces."""

from __future__ import annotations

import numpy as np

from painleve_sym.contact_rows import ContactRows
from painleve_sym.errors import InputError
from painleve_sym.problem.complementarity.lcp import LCP, LCPSolution
from painleve_sym.problem.complementarity.solution_sets import FloatArray
from painleve_sym.problem.rounding import rounded_difference
from painleve_sym.problem.statement import Statement


def pair_starts(problem: Statement) -> list[int]:
    """Return the first pair of each contact, and the number of pairs."""
    return [0, *np.cumsum([1 if s else 3 for s in problem.slip_directions]).tolist()]


def complementarity_of(problem: Statement) -> LCP:
    """Return the complementarity problem of all contacts; see `ContactProblem.lcp`."""
    directions, starts = problem.slip_directions, pair_starts(problem)
    matrix, offset = np.zeros((starts[-1], starts[-1])), np.zeros(starts[-1])
    pairs = ContactRows(problem.size).each()
    for j, s in enumerate(directions):
        normal, tangential = problem.W.T[list(pairs[j])]
        # An impossible sign left by rounding is removed, as in A_slip.
        slipping = rounded_difference(normal, (s or 1) * problem.mu[j] * tangential)
        for i, t in enumerate(directions):
            (k, m), (leaving, speeding) = (starts[i], starts[j]), pairs[i]
            matrix[k, m] = slipping[leaving]
            if not t:
                matrix[k + 1, m] = slipping[speeding]
            if not s:
                matrix[k, m + 1] = tangential[leaving]
            if not (s or t):
                matrix[k + 1, m + 1] = tangential[speeding]
    for i, s in enumerate(directions):
        k, (leaving, speeding) = starts[i], pairs[i]
        offset[k] = problem.b[leaving]
        if not s:
            offset[k + 1] = problem.b[speeding]
            matrix[k + 1, k + 2] = 1.0
            matrix[k + 2, k : k + 2] = 2.0 * problem.mu[i], -1.0
    return LCP(matrix, offset)


def forces_of(problem: Statement, solution: LCPSolution) -> FloatArray:
    """Translate a solution; see `ContactProblem.forces_from`."""
    rows = ContactRows(problem.size)
    starts = pair_starts(problem)
    if solution.z.size != starts[-1]:
        raise InputError(
            f"solution cannot be translated, z: got {solution.z.size} entries at "
            f"slip_velocity = {problem.slip_velocity.tolist()!r}, need {starts[-1]}. "
            "Fix: solve this problem's lcp()."
        )
    forces = np.zeros(rows.size)
    for i, (k, s) in enumerate(zip(starts, problem.slip_directions, strict=False)):
        if not solution.active[k]:
            continue
        normal, limit = solution.z[k], problem.mu[i] * solution.z[k]
        friction = -s * limit
        if not s:
            right, left = not solution.active[k + 1], solution.active[k + 2]
            edge = limit if left else -limit
            friction = edge if right or left or limit == 0 else solution.z[k + 1] - limit
        forces[rows.of(i)] = normal, friction + 0.0  # no -0.0
    return forces


def copositive(problem: Statement) -> tuple[LCP, FloatArray]:
    """Return the problem of Anitescu & Potra and the map from its z to the forces."""
    ways, rows = list[FloatArray](), ContactRows(problem.size)
    rests: list[tuple[int, float]] = []  # columns of F_n at rest, with their friction
    for i, (mu, s) in enumerate(zip(problem.mu, problem.slip_directions, strict=True)):
        axes = np.eye(rows.size)[:, rows.of(i)]
        if s or mu == 0:
            ways.append(axes[:, 0] - mu * s * axes[:, 1])
        else:
            rests.append((len(ways), float(mu)))
            ways += [axes[:, 0], axes[:, 1], -axes[:, 1], 0.0 * axes[:, 0]]
    forces = np.array(ways).T
    # A force works on the acceleration along itself; a sliding one on a_n alone.
    partners = forces.copy()
    for i, s in enumerate(problem.slip_directions):
        if s:
            partners[rows.tangent(i)] = 0.0
    matrix = partners.T @ problem.W @ forces
    for k, mu in rests:
        matrix[k + 1 : k + 3, k + 3] = 1.0
        matrix[k + 3, k : k + 3] = mu, -1.0, -1.0
    return LCP(matrix, partners.T @ problem.b), forces
