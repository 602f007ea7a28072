"""The formulas and numbers of docs/impacts-in-space.md."""

import re
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.problem import invariant_directions
from tests.study.study_scripts import study_script

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "impacts-in-space.md"


def test_planar_page_says_which_theorem_is_planar():
    planar = (ROOT / "docs" / "impacts.md").read_text("utf-8")
    section = re.search(r"(?s)## In the paradox an impact ends sticking.*?\n## ", planar).group()
    assert "theorem of the plane" in section and "impacts-in-space.md" in section
    row = next(line for line in PAGE.read_text("utf-8").splitlines() if "planar only" in line)
    assert "in the paradox an impact ends sticking" in row


WEDGE = np.array([[4.0, -2, 0], [-2, 1, 0], [0, 0, 1]])  # a = (-2, 0)
STARTS = {0: (-2.0, 1.0, 0.0), -1: (-2.5, 1.0, 0.0), 1: (-1.5, 1.0, 0.0)}
"""Velocities before by the sign of c = v_n + 2 v_t1."""
DISTURBANCES = (np.diag([1.0, 0, 0]), np.diag([0, 1.0, 0]), np.eye(3))


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
@pytest.mark.parametrize("sign", STARTS)
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_velocities_near_a_wedge_are_those_of_the_page(law, sign, e):
    """The limit of W + εQ where the impact has an end; else as the table of jams has it."""
    start = STARTS[sign]
    c = start[0] + 2 * start[1]
    singular = ps.solve_impact(WEDGE, 3.0, start, law, e)
    expected, exponent = singular.velocity, 0.0
    if singular.end.name == "JAM":
        assert singular.velocity[0] == pytest.approx(c, abs=1e-12)
        if law == "newton":
            expected, exponent = (-e * start[0], 0, 0), -1.0
        elif sign < 0:
            expected, exponent = (-e * c, 0, 0), -1.0
        else:
            assert sign == 0 and law == "energetic"
            exponent = -0.5
    else:
        assert sign > 0 or (sign == 0 and (e == 0 or law == "poisson"))
    for Q in DISTURBANCES:
        near, nearer = (ps.solve_impact(WEDGE + eps * Q, 3.0, start, law, e)
                        for eps in (1e-6, 1e-8))  # fmt: skip
        assert nearer.velocity == pytest.approx(expected, abs=2e-4)
        growth = np.log(nearer.impulse[0] / near.impulse[0]) / np.log(1e-2)
        assert growth == pytest.approx(exponent, abs=0.02)


def test_invariant_directions_on_the_borders_are_those_of_the_page():
    def angles(w, eigenvalues, mu):
        W = np.diag([9.0, *eigenvalues])
        W[0, 1:] = W[1:, 0] = w
        return sorted(d.angle % (2 * np.pi) for d in invariant_directions(W, mu))

    assert angles((0, 0), (1, 2), 1.0) == pytest.approx(np.arange(4) * np.pi / 2, abs=1e-12)
    assert angles((0, 0), (2, 2), 1.0) == []
    for size, count in ((0.9, 4), (1.1, 2)):
        # w^(2/3) of both parts adds up to the bound times size^(2/3).
        part = size * 0.5**1.5
        assert len(angles((part, part), (1, 2), 1.0)) == count


def test_shares_of_random_impacts_are_those_of_the_study():
    counts = study_script("impact_in_space.py").ways_to_end(1000)
    text = " ".join(PAGE.read_text("utf-8").split())
    for words, name in (
        ("{} % end sticking", "sticks"),
        ("in {} % the slip turns out of", "slides"),
        ("and in {} % it stops in the sector and begins again", "slips again"),
    ):
        assert words.format(f"{counts[name] / 10:.1f}") in text
