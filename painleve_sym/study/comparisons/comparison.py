"""Comparison of all methods from one state: accelerations, rigid and compliant motion, stepping.

The methods are asked the same question, the velocities at one time shortly after the start, and
are measured by one ruler: the distance to a rigid motion in the metric of the kinetic energy.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby, pairwise

import numpy as np

from painleve_sym.at.inputs import inside, place_of
from painleve_sym.at.jump import JumpResult
from painleve_sym.checks import StateLike, number
from painleve_sym.choices import EngineLike, EngineName
from painleve_sym.codegen.named_mechanisms import MechanismLike, as_mechanism
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.problem.impact.one_contact import ImpactEnd
from painleve_sym.problem.solution import ContactCase
from painleve_sym.study.comparisons.case import AccelerationLevel, Answer, Case, FirstStep
from painleve_sym.study.comparisons.frozen import FrozenCase
from painleve_sym.study.comparisons.motions import MotionCase
from painleve_sym.units import Value

STEPS_TO_END = (10, 100, 1000)
"""How many steps time stepping takes where no steps are given."""
STIFFNESS = (20.9e12, 20.9e14, 20.9e16)
"""Young's moduli; Pa. The middle one is the paper's."""
T_END = 1e-2
"""s. The default stiffest and softest impacts of the paper's rod end well before."""
_NO_ORDER = 0.1
"""Order of errors that do not fall."""
ROUND_OFF = 1e-9
"""Relative errors below this are those of the reference, integrated at 1e-11: no order in them."""


@dataclass(frozen=True, repr=False, eq=False)
class Comparison(Compared):
    """Every method's answer for one state.

    Attributes
    ----------
    mechanism : str
    state, parameters : dict of str to float
        Complete.
    e, t_end : float
        Coefficient of restitution of the compliant and of both rigid rules; s.
    acceleration_level : AccelerationLevel or None
        None where the contact is open or closing: there is nothing to solve.
    jumps : dict of str to JumpResult
        ``e`` and ``plastic`` (e = 0), by the energetic rule; empty where no jump is possible.
    first_steps : tuple of FirstStep
        Those where the contact is closed.
    rigid, stepping, softened : tuple of Answer
    exponent : float
        n of the contact law.
    frozen : bool
        Whether the configuration is frozen, as it is of a contact in space. Then the answers are
        those of an impact: rigid jumps by all rules, one time step of each length, and compliant
        motion up to where the contact opens.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> comparison = ps.compare("rod", state, steps=(1e-4,), t_end=1e-3)
    >>> len(comparison.acceleration_level.classification.solutions)
    0
    >>> list(comparison.jumps)
    ['e', 'plastic']
    """

    mechanism: str
    state: dict[str, float]
    parameters: dict[str, float]
    e: float
    t_end: float
    acceleration_level: AccelerationLevel | None
    jumps: dict[str, JumpResult]
    first_steps: tuple[FirstStep, ...]
    rigid: tuple[Answer, ...]
    stepping: tuple[Answer, ...]
    softened: tuple[Answer, ...]
    exponent: float
    frozen: bool = False

    @cached_property
    def step_orders(self) -> dict[str, tuple[float, ...]]:
        """p of error ∝ stepᵖ between neighbouring steps, by solver; nan where errors vanish."""
        return {way: _orders(list(group)) for way, group in groupby(self.stepping, lambda a: a.way)}

    @cached_property
    def stiffness_orders(self) -> tuple[float, ...]:
        """p of error ∝ Eᵖ between neighbouring moduli; nan where errors vanish."""
        return _orders(list(self.softened))

    def __repr__(self) -> str:
        """Return mechanism and the number of answers of each kind in one line."""
        counts = (len(self.rigid), len(self.stepping), len(self.softened))
        kinds = zip(counts, ("rigid", "time stepping", "compliant"), strict=True)
        answers = ", ".join(f"{count} {kind}" for count, kind in kinds)
        return f"Comparison of methods for {self.mechanism!r}: answers {answers}"

    @property
    def expected_stiffness_order(self) -> float:
        """−1/(2n), of an impact without collision; nan elsewhere, and where it jams.

        Where the configuration is frozen, −1/(n + 1) of an impact with an approach: what
        the jump drops is the impulse of b over the duration of the impact.
        """
        if self.impact_without_collision:
            return -1 / (2 * self.exponent)
        collides = self.frozen and self.acceleration_level is None and self.jumps
        return -1 / (self.exponent + 1) if collides and not self.jams else float("nan")

    @property
    def impact_without_collision(self) -> bool:
        """Whether accelerations have no solution and the rigid jump is the answer."""
        level = self.acceleration_level
        none = level is not None and level.classification.case is ContactCase.INCONSISTENT
        return none and not self.jams

    @property
    def jams(self) -> bool:
        """Whether the impulse of the rigid jump has no end."""
        return any(jump.end is ImpactEnd.JAM for jump in self.jumps.values())

    @cached_property
    def solver_dependent(self) -> bool:
        """Whether solvers took different impulses in the first step, at any step length."""
        for step in {a.setting for a in self.stepping}:
            taken = [a.first_impulse for a in self.stepping if a.setting == step]
            taken = [x for x in taken if np.isfinite(x)]
            if taken and max(taken) - min(taken) > 1e-6 * max(map(abs, taken)):
                return True
        return False

    @cached_property
    def steps_miss_turn(self) -> bool:
        """Whether a frozen time step differs from the jump however short it is.

        Its friction is that of the slip velocity after the step, that of the impact turns with the
        slip: errors that do not fall with the step are the difference.
        """
        last = [orders[-1] for orders in self.step_orders.values() if orders]
        return self.frozen and any(abs(order) < _NO_ORDER for order in last)

    @cached_property
    def plastic_jump_unnoticed(self) -> bool:
        """Whether accelerations have no solution, and every first step one: to rest in contact."""
        level = self.acceleration_level
        if level is None or level.classification.solutions or not self.first_steps:
            return False
        return all(
            len(first.solutions) == 1 and first.solutions[0].mode.value == "stick"
            for first in self.first_steps
        )


def compare(
    mechanism: MechanismLike,
    state: StateLike | None = None,
    *,
    parameters: Mapping[str, Value] | None = None,
    e: float = 0.75,
    steps: Sequence[Value] | None = None,
    stiffness: Sequence[Value] = STIFFNESS,
    t_end: Value = T_END,
    solvers: Sequence[str] | None = None,
    engine: EngineLike = EngineName.AUTO,
    close: str | None = None,
    contact_velocity: Sequence[float] | None = None,
) -> Comparison:
    """Ask every method what follows from one state.

    In space the configuration is frozen, so that W and b are those of the state: the answers are
    those of an impact, not of motions up to a time; see `Comparison`.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
        With one contact that can open; in space closed. `RobotContact.mechanism` is one.
    state, parameters : mapping of str to float
        Absent coordinates and velocities are 0, absent parameters have their defaults. The
        mechanism's `start` where no state is given.
    e : float
        In [0, 1]: energetic for rigid and compliant motion, Newton's for rigid motion and stepping.
    steps : sequence of float, optional
        s, in (0, t_end]; a tenth, hundredth and thousandth of t_end when not given.
    stiffness : sequence of float
        Young's moduli E > 0 of the paper's contact law; Pa.
    t_end : float
        When the velocities are compared, in space by when a compliant impact must have ended; s.
    solvers : sequence of str, optional
        Of the time steps; names in `SOLVERS`, in space ``least-impulse`` and ``largest-impulse``.
    engine : {"auto", "compiled", "taylor", "erk"}
    close, contact_velocity
        As for `evaluate_jump`.

    Raises
    ------
    InputError
        Unknown names, numbers out of range, a start inside the ground, in space an open contact.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> answers = ps.compare("rod", state, solvers=("lemke",), steps=(1e-3,), stiffness=(2e15,))
    >>> answers.impact_without_collision
    True
    """
    mechanism = as_mechanism(mechanism)
    where = f"contrast of {mechanism.name!r}"
    t_end = number(t_end, "t_end", where=where, unit="s", above=0.0)
    _refuse(mechanism)
    place = place_of(mechanism, state, parameters, close, contact_velocity)
    of = FrozenCase if mechanism.outline.in_space else MotionCase
    case: Case = of(inside(place), e, t_end, engine)
    steps = [t_end / n for n in STEPS_TO_END] if steps is None else steps
    times = _in_si(where, "steps", steps, "s")
    moduli = _in_si(where, "stiffness", stiffness, "Pa")[::-1]
    solvers = list(dict.fromkeys(case.contrasted if solvers is None else solvers))
    case.check(times, moduli, solvers)
    level = case.acceleration_level()
    rigid = case.rigid_answers(level)
    stepped = groupby(case.stepping(times, solvers), lambda a: a.way)
    softened, exponent = case.softened_answers(moduli)
    return Comparison(
        mechanism=mechanism.name,
        state=case.place.state,
        parameters=case.place.parameters,
        e=e,
        t_end=t_end,
        acceleration_level=level,
        jumps=case.jumps(),
        first_steps=case.first_steps(times),
        rigid=tuple(rigid),
        stepping=tuple(a for _, way in stepped for a in case.measured(list(way), rigid)),
        softened=tuple(case.measured(softened, rigid)),
        exponent=exponent,
        frozen=isinstance(case, FrozenCase),
    )


def _in_si(where: str, name: str, values: Sequence[Value], unit: str) -> list[float]:
    """Return the numbers in an SI unit, each once, the largest first."""
    return sorted({number(v, name, where=where, unit=unit) for v in values}, reverse=True)


def _refuse(mechanism: Mechanism) -> None:
    """Raise InputError for several contacts, and for one that cannot open."""
    names = [contact.name for contact in mechanism.outline.contacts]
    if len(names) > 1:
        raise InputError(
            f"contrast of {mechanism.name!r}: got {len(names)} contacts, need one, since time "
            "stepping and the jump rules take one. Fix: choose one of "
            f"{', '.join(map(repr, names))} (--contact, Mechanism.only; the others stay open), or "
            "use classify and simulate."
        )
    fix = "use classify, jump and simulate --law rigid"
    mechanism.require_opening(f"contrast of {mechanism.name!r}", fix)


def _orders(answers: list[Answer]) -> tuple[float, ...]:
    orders = []
    for a, b in pairwise(answers):
        # False with nan, too. Where the first steps took different solutions there is no order.
        usable = min(a.error, b.error) > ROUND_OFF and a.first_mode == b.first_mode
        ratios = b.error / a.error if usable else np.nan, b.setting / a.setting
        orders.append(float(np.log(ratios[0]) / np.log(ratios[1])))
    return tuple(orders)
