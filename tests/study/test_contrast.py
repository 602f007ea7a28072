"""Every method on the starts of the paper's tables: who finds what, and at which order."""

from __future__ import annotations

import numpy as np
import pytest

from painleve_sym.errors import InputError
from painleve_sym.mechanics.models import rod
from painleve_sym.study.compare.comparison import contrast

STEPS = (1e-3, 5e-4)
SOLVERS = ("least-impulse", "largest-impulse", "lemke")


def _contrast(**options):
    state = {"theta": options.pop("theta", 1.0), "x_A_dot": -1.0}
    state["theta_dot"] = options.pop("theta_dot")
    return contrast(rod(), state, **({"steps": STEPS, "solvers": SOLVERS} | options))


@pytest.fixture(scope="module")
def table_3():
    return _contrast(theta_dot=1.0)


@pytest.fixture(scope="module")
def table_4():
    return _contrast(theta_dot=5.0, stiffness=(20.9e14,))


def test_table_3_stepping_finds_the_plastic_jump_and_no_paradox(table_3):
    level = table_3.acceleration_level
    assert level.classification.case.value == "inconsistent"
    assert level.lemke.status.label == "ray"
    assert level.mpcc.solutions == ()
    assert table_3.plastic_jump_unnoticed
    assert not table_3.solver_dependent
    impulse = sum(p.normal_impulse for p in table_3.jumps["plastic"].phases)
    for answer in table_3.stepping:
        assert (answer.solutions_first_step, answer.first_mode) == (1, "stick")
        assert answer.first_impulse == pytest.approx(impulse, abs=10 * answer.setting)
        assert [answer.velocity[n] for n in ("x_A_dot", "y_A_dot")] == pytest.approx([0, 0])
        assert answer.reference == "newton"


def test_table_3_orders(table_3):
    for orders in table_3.step_orders.values():
        assert orders == pytest.approx([1], abs=0.05)
    assert table_3.expected_stiffness_order == pytest.approx(-1 / (2 * 1.764))
    assert np.all(np.diff([a.error for a in table_3.softened]) < 0)
    assert all(-0.3 < p < -0.15 for p in table_3.stiffness_orders)


def test_table_3_softened_impacts_are_those_of_the_reference(table_3):
    middle = table_3.softened[1]
    assert middle.setting == 20.9e14
    kinds = [kind for _, kind in middle.events]
    assert kinds[:2] == ["slip_stop", "max_compression"]
    assert "separation" in kinds
    assert middle.events[0][0] == pytest.approx(4.0886242206e-4, rel=1e-9)
    assert middle.peak_force == pytest.approx(5875.891, rel=1e-5)
    # What the rule drops is the impulse of finite forces while the slip lasts.
    jump = sum(p.normal_impulse for p in table_3.jumps["e"].phases)
    assert middle.normal_impulse == pytest.approx(jump, rel=0.05)


def test_rigid_impulse_is_that_of_the_jump_and_of_the_weight_after_it(table_3):
    energetic, newton = table_3.rigid
    assert (energetic.way, newton.way) == ("energetic", "newton")
    jumps = {name: sum(p.normal_impulse for p in j.phases) for name, j in table_3.jumps.items()}
    assert energetic.normal_impulse == pytest.approx(jumps["e"], rel=1e-9)
    assert newton.normal_impulse > jumps["plastic"]
    finest = min(table_3.stepping, key=lambda a: a.setting)
    assert newton.normal_impulse == pytest.approx(finest.normal_impulse, rel=2e-3)


def test_table_4_the_answer_depends_on_the_solver(table_4):
    assert table_4.acceleration_level.classification.case.value == "indeterminate"
    assert [len(f.solutions) for f in table_4.first_steps] == [3, 3]
    assert table_4.solver_dependent
    assert not table_4.plastic_jump_unnoticed
    found = {(a.way, a.first_mode, a.reference) for a in table_4.stepping}
    assert ("least-impulse", "liftoff", "newton, liftoff") in found
    assert any(way == "largest-impulse" and mode == "stick" for way, mode, _ in found)
    assert {a.way for a in table_4.rigid} >= {"energetic, liftoff", "energetic, impact"}
    assert all(a.normal_impulse == 0 for a in table_4.softened)


def test_unique_slip_is_found_by_all():
    found = _contrast(theta=0.5, theta_dot=1.0, stiffness=(20.9e12,), t_end=2e-3)
    assert found.acceleration_level.classification.case.value == "slip"
    assert found.jumps == {}
    assert not (found.solver_dependent or found.plastic_jump_unnoticed)
    errors = [a.error for a in found.stepping]
    assert max(errors) < 1e-4
    assert np.isnan(found.expected_stiffness_order)


def test_steps_follow_the_end_time_where_none_are_given():
    found = contrast(
        rod(),
        {"theta": 1.0, "y_A": 0.01},
        t_end=1e-3,
        stiffness=(20.9e14,),
        solvers=("lemke",),
    )
    assert [a.setting for a in found.stepping] == pytest.approx([1e-4, 1e-5, 1e-6])


def test_falling_rod_has_no_contact_problem_of_accelerations():
    state = {"theta": 1.0, "y_A": 0.01, "x_A_dot": -1.0}
    found = contrast(rod(), state, steps=STEPS, stiffness=(20.9e14,), solvers=("lemke",))
    assert found.acceleration_level is None
    assert found.first_steps == ()
    assert all(a.normal_impulse == 0 for a in (*found.rigid, *found.stepping, *found.softened))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"steps": ()}, "steps: got none"),
        ({"steps": (-1e-3,)}, "step: got -0.001"),
        ({"steps": (float("nan"),)}, "step: got nan"),
        ({"stiffness": (0.0,)}, "0 < E"),
        ({"restitution": 2.0}, "0 <= e_energetic <= 1"),
        ({"solvers": ("lemk",)}, "Did you mean 'lemke'?"),
        ({"t_end": -1.0}, "t_end: got -1.0"),
    ],
)
def test_bad_options_are_refused(options, words):
    with pytest.raises(InputError) as error:
        _contrast(theta_dot=1.0, **options)
    assert words in str(error.value)
