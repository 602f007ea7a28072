"""In which pieces of their laws a run begins, against the kernel on one generator.

A mechanism of r freedoms, M = 1, has contacts along any rows L of its coordinates on surfaces that
move: W = L Lᵀ, and b and the slip velocities are parameters.
"""

from __future__ import annotations

import functools
from collections import Counter

import numpy as np
import pytest

from painleve_sym.errors import EventKind, StopReason
from painleve_sym.laws.catalogue import law
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.simulator import Simulator
from tests.problem import problems
from tests.problem.problems import verdict
from tests.scenes import parameter

ENDS = {EventKind.TANGENTIAL_IMPACT, EventKind.JAM, EventKind.SINGULAR}
"""What states that no forces are possible, beside the events of impacts."""
STALLED = {StopReason.ACCUMULATION, StopReason.EVENT_LIMIT}


def made_up(r, held):
    """Return the file of a mechanism of r freedoms with a contact for each of `held`."""
    rows, freedoms = range(2 * len(held)), range(r)
    lines = ['name = "made-up"', "[coordinates]"]
    lines += [f'q_{k} = {{ unit = "m", meaning = "place" }}' for k in freedoms]
    lines += ["[parameters]"]
    lines += [
        parameter(f"l_{i}_{k}", 1 + i - 0.3 * k, "1", "a row") for i in rows for k in freedoms
    ]
    lines += [parameter(f"b_{i}", 0.5, "m/s^2", "acceleration of a surface") for i in rows]
    square = " + ".join(f"q_{k}_dot**2" for k in freedoms)
    lines += [parameter("m", 1.0, "kg", "mass", "positive = true")]
    contacts = ["[energy]", f'kinetic = "m*({square})/2"', 'potential = "0"']
    for i, is_held in enumerate(held):
        lines += [parameter(f"mu_{i}", 0.5, "1", "friction coefficient")]
        lines += [parameter(f"u_{i}", 1.0, "m/s", "speed of a surface")]
        gap = " + ".join(f"l_{2 * i}_{k}*q_{k}" for k in freedoms)
        slip = " + ".join(f"l_{2 * i + 1}_{k}*q_{k}_dot" for k in freedoms)
        contacts += ["[[contacts]]", f'name = "c{i}"', f'friction = "mu_{i}"']
        contacts += [f'gap = "{gap} + b_{2 * i}*t**2/2"']
        contacts += [f'slip_velocity = "{slip} + b_{2 * i + 1}*t + u_{i}"']
        contacts += ["bilateral = true"] * is_held
    return "\n".join([*lines, *contacts, "[start]", "t = 0.0"])


@functools.cache
def simulator(r, held, policy):
    mechanism = mechanism_from_text(made_up(r, held), "made-up.toml")
    return Simulator(mechanism, law("rigid", policy=policy))


def begun(L, problem, policy, t_end=1e-6):
    """Return a run, by default its first moment."""
    n, r = len(problem.mu), L.shape[1]
    given = {f"l_{i}_{k}": float(L[i, k]) for i in range(2 * n) for k in range(r)}
    given |= {f"b_{i}": float(b) for i, b in enumerate(problem.b)}
    given |= {f"mu_{i}": float(mu) for i, mu in enumerate(problem.mu)}
    given |= {f"u_{i}": float(v) for i, (v,) in enumerate(problem.slip)}
    start = {f"q_{k}{dot}": 0.0 for k in range(r) for dot in ("", "_dot")}
    mechanism = simulator(r, tuple(problem.closed), policy)
    return mechanism.run(start, parameters=given, t_end=t_end, max_events=40)


def forces(run, n, t=0.0):
    """Return the forces of a run at a time, row by row."""
    ends = [f"_c{i}" for i in range(n)] if n > 1 else [""]
    out = run.outputs(np.array([t]))
    names = [f"{row}_force{end}" for end in ends for row in ("normal", "tangential")]
    return np.array([out[name][0] for name in names])


def difference(L, problem, policy):
    """Return in a word how a run differs from the kernel; empty where it does not."""
    run, answers = begun(L, problem, policy), problem.answers()
    kinds, stated = [event.kind for event in run.events[:2]], verdict(answers)
    says_it = run.stop_reason in (StopReason.JAM, StopReason.SINGULAR) or any(
        kind in ENDS or kind.startswith("impact") for kind in kinds
    )
    stalled = run.stop_reason in STALLED
    if stated.case == "inconsistent":
        word = "" if says_it else "stalled" if stalled else "inconsistent"
    elif says_it:
        # Rigidity that leaves forces open ends a run; of several motions a policy takes an impact.
        chosen = policy == "impact" and stated.case == "indeterminate"
        word = "" if chosen or any(stated.is_open) else "no motion"
    elif not len(run.step_mode):
        word = "stalled"
    else:
        word = motion_of(forces(run, len(problem.mu)), problem, answers, stated.motions)
    return f"{word} on a border" if word and answers.borders else word


def motion_of(F, problem, answers, motions):
    a, size = problem.W @ F + problem.b, max(1.0, np.max(np.abs(problem.b)))
    if any(np.allclose(a, other, rtol=1e-6, atol=1e-7 * size) for other in motions):
        return ""
    moves = any(answer.moves for answer in answers.all)
    return "" if moves and answers.law.check((F / answers.law.unit).tolist()) else "other motion"


def differences(r, held, policy, count):
    rng, counts = np.random.default_rng(r), Counter()
    while counts.total() < count:
        L = rng.integers(-2, 3, size=(2 * len(held), r))
        if np.linalg.matrix_rank(L) == r and np.all(np.any(L, axis=1)):
            problem = problems.with_root(rng, L)._replace(closed=list(held))
            counts[difference(L, problem, policy)] += 1
    return counts


@pytest.mark.parametrize(
    ("r", "held", "policy", "count"),
    [
        (2, (False,), "liftoff", 300),
        (1, (False,), "liftoff", 300),
        (2, (True,), "slip", 300),
        pytest.param(2, (False,), "liftoff", 4000, marks=pytest.mark.slow),
        pytest.param(2, (False,), "slip", 2000, marks=pytest.mark.slow),
        pytest.param(1, (False,), "slip", 2000, marks=pytest.mark.slow),
        pytest.param(2, (True,), "liftoff", 2000, marks=pytest.mark.slow),
    ],
)
def test_a_run_of_one_contact_begins_as_the_kernel_says(r, held, policy, count):
    counts = differences(r, held, policy, count)
    border = sum(counts[word] for word in counts if word.endswith("border"))
    assert counts[""] + border == count and border <= count / 20


@pytest.mark.slow
@pytest.mark.parametrize(
    ("r", "held", "policy"),
    [
        (4, (False, False), "liftoff"),
        (3, (False, False), "slip"),
        (2, (False, False), "liftoff"),
        (1, (False, False), "liftoff"),
        (4, (False, True), "liftoff"),
        (3, (False, True), "liftoff"),
        (4, (True, True), "liftoff"),
    ],
)
def test_a_run_of_two_contacts_begins_as_the_kernel_says(r, held, policy):
    """A guide that needs no force may turn its side by rounding until the run stalls."""
    counts = differences(r, held, policy, 300)
    border = sum(counts[word] for word in counts if word.endswith("border"))
    assert counts[""] + counts["stalled"] + border == 300
    assert counts["stalled"] <= 3 and border <= 15


# ---- after a slip has stopped ----


def after_stop(L, problem):
    """Return whether a run after a stop of slip is a motion of the kernel; None without a stop.

    W and b are constant, so that nothing happens before. 'stalled' where the run ends there.
    """
    stated = verdict(problem.answers())
    if stated.case != "unique" or stated.borders or np.any(np.abs(stated.motions[0][::2]) > 1e-9):
        return None
    rates, v = stated.motions[0][1::2], np.array(problem.slip, float).ravel()
    slowing = v * rates < -1e-9
    if not np.any(slowing):
        return None
    time = np.min(-v[slowing] / rates[slowing])
    v = v + rates * time
    after = problem._replace(slip=np.where(np.abs(v) > 1e-9, v, 0.0)[:, None].tolist())
    answers = after.answers()
    if answers.borders or problems.case_of(answers) not in ("unique", "indeterminate"):
        return None
    run = begun(L, problem, "liftoff", 1.001 * time)
    if run.stop_reason is not StopReason.T_END:
        return "stalled" if run.stop_reason in STALLED else False
    F = forces(run, len(v), 1.0005 * time)
    return not motion_of(F, after, answers, verdict(answers).motions)


def stops(r, held, count):
    rng, counts = np.random.default_rng(r), Counter()
    while counts[True] + counts[False] < count:
        L = rng.integers(-2, 3, size=(2 * len(held), r))
        if np.linalg.matrix_rank(L) == r and np.all(np.any(L, axis=1)):
            problem = problems.with_root(rng, L)._replace(closed=list(held))
            counts[after_stop(L, problem)] += 1
    return counts


@pytest.mark.parametrize(
    ("r", "held", "count"),
    [
        (2, (False,), 40),
        (2, (True,), 40),
        pytest.param(2, (False,), 1000, marks=pytest.mark.slow),
        pytest.param(2, (True,), 1000, marks=pytest.mark.slow),
        pytest.param(4, (False, False), 100, marks=pytest.mark.slow),
        pytest.param(3, (False, True), 100, marks=pytest.mark.slow),
    ],
)
def test_a_slip_that_stops_is_followed_as_the_kernel_says(r, held, count):
    """A guide that needs no force may turn its side by rounding until the run stalls."""
    counts = stops(r, held, count)
    assert not counts[False] and counts["stalled"] <= count / 50
