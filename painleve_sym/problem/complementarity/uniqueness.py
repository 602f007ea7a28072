"""Existence and uniqueness of solutions, from the matrix of several frictional contacts.

The consistent forces and accelerations of contacts with ``v_n = 0`` form a piecewise linear map
from (force, acceleration) pairs that obey the contact laws to ``b = a - W F``: one linear piece for
each choice of local modes (lift-off, slip, stick). The problem has one solution for every b exactly
when that map is one-to-one and onto.

- All contacts sliding: the pieces are the complementary cones of an LCP, their determinants the
  principal minors of its matrix, and the condition is the P-property (Samelson, Thrall & Wesler).
- Some at rest: the condition is the same, every determinant > 0. The law of a contact at rest has
  four pieces around one point, a product of laws at most four around a face of codimension two,
  and a map coherently oriented on such pieces is a homeomorphism (Scholtes, codimension-k theorem).
- Some bilateral: the determinant of a choice is affine in the friction of each bilateral contact,
  with opposite slopes on its two sides. Determinants that are positive on both sides stay so while
  this friction fades to zero; the degree of the map does not change on the way, and at its end the
  contact is an equation that leaves a smaller problem of the kinds above.
- Existence: let the columns of G be the edges of the friction cones (at rest) or the directions of
  the sliding forces, and those of H the same at rest, but the normal where sliding. If
  ``x'(H'WG)x > 0`` for every ``x >= 0, x != 0``, then no nonzero forces solve the problem with
  b = 0, for W and for every W on the way from it to the identity, where the solution is unique; so
  the degree of the map is one, and no b is left without a solution. A bilateral contact pushes or
  pulls: the condition is asked of each choice of sides, with the edges of that side.

References
----------
Samelson, Thrall & Wesler (1958); Scholtes (1996); Cottle, Pang & Stone (1992).
"""

from __future__ import annotations

import enum
from collections.abc import Iterable

import numpy as np

from painleve_sym.problem.complementarity.matrix_class import determinant_signs, is_copositive
from painleve_sym.problem.complementarity.solution_sets import FloatArray


class Uniqueness(enum.StrEnum):
    """Say what W, mu and the slip directions promise for every b; `meaning` and `reference` follow.

    UNIQUE_FOR_ALL
        The determinants of all choices of local modes are positive; all sliding: the LCP has a
        P-matrix.
    SOLVABLE_FOR_ALL
        Not that, but ``x'(H'WG)x > 0`` for every ``x >= 0, x != 0``.
    NOT_GUARANTEED
        Neither.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> W, b = [[4.0, 1.0], [1.0, 2.0]], [-9.8, 0.0]
    >>> problem = ps.ContactProblem(W, b, [0.5], slip_velocity=[-1.0])
    >>> problem.uniqueness().name
    'UNIQUE_FOR_ALL'
    """

    UNIQUE_FOR_ALL = (
        "unique_for_all",
        "there is exactly one solution for every load",
        "Cottle, Pang & Stone (1992), theorem 3.3.7; Scholtes (1996) for contacts at rest",
    )
    SOLVABLE_FOR_ALL = (
        "solvable_for_all",
        "there is at least one solution for every load, and several for some loads; solutions() "
        "lists those of this load",
        "Cottle, Pang & Stone (1992), section 3.8; the module's degree argument at rest",
    )
    NOT_GUARANTEED = (
        "not_guaranteed",
        "this contact matrix does not guarantee a unique solution for every load, nor any at all "
        "(Painlevé's paradox); solutions() lists those of this load",
        "Painlevé (1895)",
    )

    label: str
    meaning: str
    reference: str

    def __new__(cls, label: str, meaning: str = "", reference: str = "") -> Uniqueness:
        """Return the member that is the text `label`."""
        member = str.__new__(cls, label)
        member._value_ = member.label = label
        member.meaning = meaning
        member.reference = reference
        return member


def uniqueness_of(
    pieces: Iterable[tuple[FloatArray, FloatArray]], forms: Iterable[FloatArray]
) -> Uniqueness:
    """Classify a piecewise linear problem by its pieces.

    A piece has the matrices of all choices with k unknowns, shape (m, k, k), and the sizes of the
    terms of each entry: a determinant within rounding of zero counts as zero. The forms are the
    matrices ``H'WG`` of the existence test, shape (p, p), one for each choice of the sides of
    bilateral contacts.
    """
    if all(np.all(determinant_signs(blocks, terms) > 0) for blocks, terms in pieces):
        return Uniqueness.UNIQUE_FOR_ALL
    if all(is_copositive(form, strict=True) for form in forms):
        return Uniqueness.SOLVABLE_FOR_ALL
    return Uniqueness.NOT_GUARANTEED
