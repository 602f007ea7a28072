"""Impacts of several contacts at once: the path of the impulse, followed piece by piece.

The configuration is frozen, and the impulses P of the contacts change their velocities by
dv = W dP. Each contact either pushes or does not, and friction opposes the slip it has at that
moment, as in Routh's construction for one contact. With the path parameter τ, in N s, contact i

- pushes with dP_n/dτ = w_i while it approaches (v_n < 0) or has restitution left to give;
- does not push where it parts (v_n > 0) and has no restitution left;
- on the border, at v_n = 0 without restitution, pushes with 0 ≤ dP_n/dτ ≤ 1: it is held or let go,
  or pressed in against a full push, and then w_i = 1.

dP_t = −μ sign(v_t) dP_n in slip, and |dP_t| ≤ μ dP_n in sticking. The weights w_i are otherwise
constant: the normal impulses that would stop all approaches at once, 0 ≤ P_n ⟂ v_n⁺ ≥ 0 with
friction against v_t⁺ (Glocker & Pfeiffer 1995), in parts of the largest, or all 1 where there
are none. Rigid bodies do not tell the ratio of two contact forces; with these, all contacts end
compression together where no slip stops or turns. A weight may be 0: what would be stopped by the
others does not push until it is on the border. So only contacts with w_i > 0 store energy, and a
path that ends has given back all that is due.

The right side is a bounded, convex and upper semicontinuous function of v (Filippov), so that a
path begins at every v; it is made of straight pieces. Each contact has its own budget of
restitution: the part e² of the energy that its own normal force took (energetic law), or the part e
of its own impulse of compression (Poisson's), which lapses where the energy of all would grow.
The weights and budgets are this package's rule for several contacts; Stronge's and Poisson's laws
are of one.

Newton's law has no path of several contacts: where more than one of them pushes, it is one
complementarity problem, 0 ≤ P_n ⟂ v_n⁺ + e v_n⁻ ≥ 0 with friction against v_t⁺ (Moreau). Where only
one pushes, the border is −e v_n⁻ in place of 0. By the choice `ImpactFriction.FINAL_SLIP` every
impact is that problem, also of one contact.

A guide holds from both sides: its v_n is 0 all along the path, and its dP_n, of either sign, is
what keeps it there, with |dP_t| ≤ μ |dP_n|. It takes no energy but by friction. With friction such
a dP need not exist: then what slips stops at once, 0 ≤ P_n ⟂ v_n⁺ ≥ 0 of the contacts that open
and v_n⁺ = 0 of the guides with friction against v_t⁺, as in the tangential impact of one guide.

References
----------
Keller (1986) for the path of one contact; Glocker & Pfeiffer (1995) and Moreau (1988) for impulses
of several contacts; Liu, Zhao & Brogliato (2008) for an energy budget at each; Filippov (1988), §7,
for the beginning of a path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.contact_rows import ContactRows
from painleve_sym.equality import Compared
from painleve_sym.laws.restitution import RestitutionLaw
from painleve_sym.problem.complementarity.solution_sets import BoolArray
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.impact.energy_gain import least_energy_notice
from painleve_sym.problem.impact.one_contact import ImpactEnd
from painleve_sym.problem.law import EQUAL


@dataclass(frozen=True, eq=False)
class ImpulsePiece(Compared):
    """A straight piece of the path of an impact; arrays of shape (2 n,), two numbers a contact.

    Impulses P_n, P_t of the piece, N s; velocities v_n, v_t at its end, m/s; works ∫v_n dP_n and
    ∫v_t dP_t ≤ 0, J.
    """

    impulses: Array
    velocities: Array
    works: Array


class PathEvent(NamedTuple):
    """End of a straight piece of this length, N s.

    By its kind v_n reaches its ``border``, v_t reaches 0 (``slip``), the restitution of a contact
    is ``spent``, or the ``energy`` of all contacts (contact 0) is given back.
    """

    length: float
    kind: str
    contact: int


class Straight(NamedTuple):
    """A straight piece with its inputs; the numbers are the values before it.

    `fixed` is dP/dτ but for its unknowns, `columns` are their directions, shape (2 n, len(rows)),
    and `rows` the rates that they make vanish; `push` and `rates` are dP/dτ and dv/dτ. The event
    ends it. It is `alone` where no other dv/dτ was possible. Other arrays have two entries for each
    contact, or one: `budget`, `compresses`, `rubs`.
    """

    fixed: Array
    columns: Array
    rows: tuple[int, ...]
    velocities: Array
    budget: Array
    push: Array
    rates: Array
    compresses: BoolArray
    rubs: BoolArray
    event: PathEvent
    velocities_after: Array
    budget_after: Array
    work_after: float
    alone: bool


class AtOnce(NamedTuple):
    """Impulses of one local mode for each contact, which make the rates of `rows` vanish.

    Where it `weighs` only the weights follow from it; else it continues the path. The coefficients
    of restitution, shape (n,), are None for a stop. The rates are the velocities before, without
    what rebounds, + W impulses, all of shape (2 n,); `columns` are the directions of the impulses,
    shape (2 n, len(rows)).
    """

    weighs: bool
    e: Array | None
    velocities: Array
    impulses: Array
    rates: Array
    rows: tuple[int, ...]
    columns: Array

    @property
    def rebound(self) -> Array | float:
        """Coefficients of restitution, 0 for a stop."""
        return 0.0 if self.e is None else self.e

    def is_alone(self, W: Array, mu: Array, bilateral: BoolArray) -> bool:
        """Return whether no other impulses of the law were possible."""
        aim = self.velocities.copy()
        aim[ContactRows(len(mu)).normals] *= 1 + self.rebound
        problem = ContactProblem(W, aim, mu, np.zeros(len(mu)), bilateral)
        solutions = problem.solutions()
        if self.e is None:  # a stop has to change the velocities
            least = EQUAL * float(np.max(np.abs(aim)))
            solutions = tuple(
                s for s in solutions if s.moves or np.max(np.abs(s.accelerations - aim)) > least
            )
        return len(solutions) <= 1 and not any(s.moves for s in solutions)


class PathRecord(NamedTuple):
    """Course of an impact, in numbers of order 1.

    2**mass of W are 1 kg⁻¹, and 2**speed of the velocity at its start are 1 m/s. Shapes are
    (2 n, 2 n), (2 n,), and (n,) of `mu`, `bilateral`, `e` and `border` (v_n without restitution to
    give). The steps are in order.
    """

    W: Array
    mu: Array
    velocity: Array
    border: Array
    bilateral: BoolArray
    law: RestitutionLaw
    e: Array
    mass: int
    speed: int
    steps: tuple[Straight | AtOnce, ...]


@dataclass(frozen=True, eq=False)
class SimultaneousImpact(Compared):
    """An impact of several contacts.

    Attributes
    ----------
    end : ImpactEnd
        ``SEPARATION`` where a contact opens, ``PERSISTENT`` where all stay closed, ``JAM`` where
        the path has no end or, without collision, no beginning.
    velocities_before, velocities : ndarray, shape (2 n,)
        v_n, v_t of each contact before and after, or up to where the path jams; m/s.
    pieces : tuple of ImpulsePiece
        In order.
    path : PathRecord
        What led to it.
    """

    end: ImpactEnd
    velocities_before: Array
    velocities: Array
    pieces: tuple[ImpulsePiece, ...]
    path: PathRecord

    @property
    def impulses(self) -> Array:
        """P_n, P_t of each contact, shape (2 n,); N s."""
        return sum((piece.impulses for piece in self.pieces), np.zeros_like(self.velocities))

    @property
    def works(self) -> Array:
        """∫v_n dP_n and ∫v_t dP_t of each contact, shape (2 n,); J."""
        return sum((piece.works for piece in self.pieces), np.zeros_like(self.velocities))

    @property
    def _rows(self) -> ContactRows:
        return ContactRows(len(self.path.mu))

    @property
    def normal_work(self) -> float:
        """Energy that the normal impulses give to the mechanism; J."""
        return math.fsum(self.works[self._rows.normals])

    @property
    def tangential_work(self) -> float:
        """Energy that friction gives to the mechanism, never positive; J."""
        return math.fsum(self.works[self._rows.tangentials])

    @property
    def is_unique(self) -> bool:
        """Whether no other continuation was possible on the way; else that of least push is taken.

        It says nothing of paths that begin another way and were not followed. Of impulses at once
        the motions count, not the forces that rigidity leaves open.
        """
        path = self.path
        given = path.W, path.mu, path.bilateral
        return all(
            step.is_alone(*given) if isinstance(step, AtOnce) else step.alone for step in path.steps
        )

    @property
    def energy_change(self) -> float:
        """Work of the contacts; J. The change of kinetic energy over ground at rest."""
        return math.fsum(self.works)

    @property
    def notice(self) -> str:
        """One sentence where the impact adds energy, which Newton's law can do; else empty.

        Its percentage is that of the least kinetic energy with these contact velocities.
        """
        W, before = np.ldexp(self.path.W, self.path.mass), self.velocities_before
        return least_energy_notice(self.energy_change, W, before, self.path.law.name)
