"""Faces of singular blocks: the deepest point against nearest points, and known faces."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.problem.complementarity.solution_sets import affine_face
from painleve_sym.problem.faces import ForceSet
from tests.support.drawn import integers


@st.composite
def singular_faces(draw):
    """Draw a block of zeros but for at most one row, and inequalities that bound some of it."""
    k, m = draw(st.integers(2, 4)), draw(st.integers(1, 5))
    drawn = np.array(draw(integers([range(-4, 5)] * ((m + 1) * (k + 1))))) / 4
    first, *rest = drawn.reshape(m + 1, k + 1)
    block, goal = np.zeros((k, k)), np.zeros(k)
    block[0] = first[:k]
    goal[0] = first[k] if block[0].any() else 0.0
    rows, start = np.split(np.array(rest), [k], axis=1)
    # x >= -1 keeps out whole lines, as forces that push do.
    return block, goal, np.vstack([rows, np.eye(k)]), np.append(start, np.ones(k))


@settings(max_examples=100)
@given(singular_faces())
def test_point_of_a_face_solves_and_is_missing_where_nearest_points_say_so(face):
    block, goal, rows, start = face
    deepest = affine_face(*face, len(goal))
    _, stretch, right = np.linalg.svd(block)
    rank = int(np.sum(stretch > 1e-12))
    base = np.linalg.pinv(block) @ goal
    convex = ForceSet(base, right[rank:].T, rows, start).inside()
    assert (deepest is None) == (convex is None)
    if deepest is None:
        return
    assert np.allclose(block @ deepest[0], goal, atol=1e-9)
    assert np.min(rows @ deepest[0] + start) >= -1e-9
    assert np.array_equal(deepest[1], np.any(np.abs(convex.span) > 1e-8, axis=1))


@pytest.mark.parametrize(
    ("rows", "start", "moving"),
    [
        ([[1, 0], [0, 1]], [0, 0], [True, True]),  # a quadrant
        ([[1, 0], [-1, 0], [0, 1]], [0, 0, 0], [False, True]),  # a ray without inside
        ([[1, 0], [0, 1], [-1, -1]], [0, 0, 0], [False, False]),  # the origin
    ],
)
def test_affine_face_tells_what_varies(rows, start, moving):
    zeros = np.zeros((2, 2))
    face = affine_face(zeros, np.zeros(2), np.array(rows, float), np.array(start, float), 2)
    assert face[1].tolist() == moving


def test_affine_face_is_none_where_it_is_empty():
    rows, start = np.array([[1.0, 1.0], [-1.0, -1.0]]), np.array([-1.0, 0.5])
    zeros = np.zeros((2, 2))
    assert affine_face(zeros, np.zeros(2), rows, start, 2) is None
    assert affine_face(zeros, np.array([1.0, 0.0]), rows, start, 2) is None
