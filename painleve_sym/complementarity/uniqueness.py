"""What the matrix of several frictional contacts promises before anything is solved.

The consistent forces and accelerations of contacts with ``v_n = 0`` form a piecewise linear map
from (force, acceleration) pairs that obey the contact laws to ``b = a - W F``: one linear piece for
each choice of branches (lift-off, slip, stick). The problem has one solution for every b exactly
when that map is one-to-one and onto.

- All contacts sliding: the pieces are the complementary cones of an LCP, their determinants the
  principal minors of its matrix, and the condition is the P-property (Samelson, Thrall & Wesler).
- Some at rest: the condition is the same, every determinant > 0. The law of a contact at rest has
  four pieces around one point, a product of laws at most four around a face of codimension two,
  and a map coherently oriented on such pieces is a homeomorphism (Scholtes, codimension-k theorem).
- Existence: let the columns of G be the edges of the friction cones (at rest) or the directions of
  the sliding forces, and those of H the same at rest, but the normal where sliding. If
  ``x'(H'WG)x > 0`` for every ``x >= 0, x != 0``, then no nonzero forces solve the problem with
  b = 0, for W and for every W on the way from it to the identity, where the solution is unique; so
  the degree of the map is one, and no b is left without a solution.

References
----------
Samelson, Thrall & Wesler (1958), A partition theorem for Euclidean n-space. Proc. Amer. Math. Soc.
    9, 805-807.
Scholtes (1996), Homeomorphism conditions for coherently oriented piecewise affine mappings. Math.
    Oper. Res. 21, 955-978.
Cottle, Pang & Stone (1992), The Linear Complementarity Problem. Academic Press.
"""

from __future__ import annotations

import enum
from collections.abc import Sequence

import numpy as np

from painleve_sym.complementarity.branches import Branch, branch_blocks
from painleve_sym.complementarity.faces import FloatArray
from painleve_sym.complementarity.matrix_class import determinant_signs, is_copositive


class Uniqueness(enum.Enum):
    """Say what W, mu and the slip directions promise for every b; `meaning` and `reference` follow.

    UNIQUE_FOR_ALL
        Every branch determinant is positive; all sliding: the LCP has a P-matrix.
    SOLVABLE_FOR_ALL
        Not that, but ``x'(H'WG)x > 0`` for every ``x >= 0, x != 0``.
    NOT_GUARANTEED
        Neither.
    """

    UNIQUE_FOR_ALL = (
        "unique_for_all",
        "whatever the accelerations b, there is exactly one set of forces. All contacts sliding: "
        "the matrix is a P-matrix; otherwise all branch determinants are positive",
        "Cottle, Pang & Stone (1992), theorem 3.3.7; Scholtes (1996) for contacts at rest",
    )
    SOLVABLE_FOR_ALL = (
        "solvable_for_all",
        "whatever b, there is at least one set of forces, since the matrix is strictly copositive "
        "on the friction cones; for some b there are several or a continuum, so ask solutions()",
        "Cottle, Pang & Stone (1992), section 3.8; the module's degree argument at rest",
    )
    NOT_GUARANTEED = (
        "not_guaranteed",
        "for some b the forces are not unique, and for some there may be none (Painlevé's "
        "paradox): nothing is promised, so ask solutions() at the b of interest",
        "Painlevé (1895), C. R. Acad. Sci. 121, 112-115",
    )

    def __init__(self, label: str, meaning: str, reference: str) -> None:
        self.label = label
        self.meaning = meaning
        self.reference = reference


def uniqueness_of(W: FloatArray, branches: Sequence[Sequence[Branch]]) -> Uniqueness:
    """Classify contacts by their mobility and the branches of their laws.

    Parameters
    ----------
    W : ndarray, shape (2 n, 2 n)
        Mobility, scaled to order one.
    branches : sequence of n sequences of Branch
        What each contact may do. A determinant or minor within rounding of zero counts as zero.
    """
    signs = (determinant_signs(blocks, terms) for blocks, terms in branch_blocks(W, branches))
    if all(np.all(sign > 0) for sign in signs):
        return Uniqueness.UNIQUE_FOR_ALL
    return (
        Uniqueness.SOLVABLE_FOR_ALL
        if is_copositive(_power_form(W, branches), strict=True)
        else Uniqueness.NOT_GUARANTEED
    )


def _power_form(W: FloatArray, branches: Sequence[Sequence[Branch]]) -> FloatArray:
    """Return ``H'WG``: the power of forces on the accelerations that the law ties them to."""
    forces, partners = [], []
    for i, given in enumerate(branches):
        slips = [branch for branch in given if branch.directions.shape[1] == 1]
        for branch in slips:
            force = np.zeros(len(W))
            force[2 * i : 2 * i + 2] = branch.directions[:, 0]
            partner = force
            if len(slips) == 1:  # sliding, or without friction: only F_n a_n = 0 is known
                partner = np.zeros(len(W))
                partner[2 * i] = branch.directions[0, 0]
            forces.append(force)
            partners.append(partner)
    form: FloatArray = np.array(partners) @ W @ np.array(forces).T
    return form
