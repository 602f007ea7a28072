"""The motions that the benchmarks solve: hand-written equations in scaled variables.

Two are impacts with the same four phases: slip to the left under growing compression, sticking,
sticking restitution, and, in the last 4e-8 s, slip to the right. The third is a block on a belt
that runs to and fro, with 21 changes between sticking and slip. Nothing here imports the package.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

import numpy as np

G, N = 9.8, 1.764
E_ENERGETIC = 0.75
#: Slip velocity with which a slip begins, m/s.
BEGINNING = 1e-18
#: K_e = 4/3 E* sqrt(R*), with E = 20.9e14, nu = 0.3, R* = R = 0.00645.
K = 4.0 / 3.0 * 20.9e14 / (2.0 * (1.0 - 0.3**2)) * math.sqrt(0.00645)


@dataclass(frozen=True)
class Phase:
    """Name the equations between two events and the guard that ends them.

    Attributes
    ----------
    normal : str
        ``"virgin"``, ``"unloading"`` or ``"rigid"``.
    tangent : str
        ``"left"``, ``"stick"`` or ``"right"``.
    guard : str
        ``"slip"``, ``"turn"``, ``"friction"``, ``"separation"`` or ``"time"``: what reaches zero at
        the end. Rigid sticking ends in slip to the ``"left"`` or to the ``"right"``.
    """

    normal: str
    tangent: str
    guard: str


def phases(reverse_slip: bool) -> list[Phase]:
    """List the phases of the impact.

    Parameters
    ----------
    reverse_slip : bool
        Whether the last 4e-8 s, in which the vanishing normal force no longer holds the end, are
        slip to the right; otherwise the end sticks up to separation.
    """
    first = [Phase("virgin", "left", "slip"), Phase("virgin", "stick", "turn")]
    if not reverse_slip:
        return [*first, Phase("unloading", "stick", "separation")]
    return [
        *first,
        Phase("unloading", "stick", "friction"),
        Phase("unloading", "right", "separation"),
    ]


class Operators(Protocol):
    """Name what an expression system must offer for the equations."""

    sin: Callable[[Any], Any]
    cos: Callable[[Any], Any]
    #: Raise a base to the constant power N; floors it at zero where the system can.
    power: Callable[[Any], Any]
    inverse_root: Callable[[Any], Any]


class FloatOperators:
    """Evaluate the equations in Python floats."""

    sin = staticmethod(math.sin)
    cos = staticmethod(math.cos)

    @staticmethod
    def power(base: float) -> float:
        """Return base**N; a trial step past the contact would have a complex one."""
        return max(base, 0.0) ** N

    @staticmethod
    def inverse_root(base: float) -> float:
        """Return 1/√base."""
        return 1.0 / math.sqrt(base)


@dataclass(frozen=True)
class Case:
    """An impact from touching at t = 0 to separation.

    Attributes
    ----------
    name : str
    states : tuple of str
    start : tuple of float
    scale : tuple of float
        Units of the scaled states: largest compression, rebound speed and such, rounded.
    gap, gap_rate, slip : int
        Which states these are.
    compared : dict of str to float
        Velocities whose relative errors count, and the size of those that vanish at separation.
    reference : dict of bool to dict of str to float
        State at separation by heyoka's Taylor method in 80-bit floating point at tolerance 1e-19,
        for `reverse_slip` true and, for the rod, false.
    """

    name: str
    states: tuple[str, ...]
    start: tuple[float, ...]
    scale: tuple[float, ...]
    gap: int
    gap_rate: int
    slip: int
    compared: dict[str, float | None]
    reference: dict[bool, dict[str, float]] = field(repr=False)

    mu: ClassVar[float]
    #: Unit of time, s.
    time: ClassVar[float] = 1e-4
    #: Later than the separation, in units of time.
    horizon: ClassVar[float] = 6.0
    #: For peers that compare the sign of a guard at the ends of long steps, in units of time:
    #: between them it may be negative for less than a step.
    longest_step: ClassVar[float] = math.inf

    def phases(self, reverse_slip: bool) -> list[Phase]:
        """List the phases of the motion, see `phases`."""
        return phases(reverse_slip)

    def normal_force(self, phase: Phase, ops: Operators, gap: Any, delta_max: Any) -> Any:
        """Return F_n; `gap` in metres."""
        if phase.normal == "virgin":
            return K * ops.power(-gap)
        recovered = E_ENERGETIC**2 * delta_max
        return (
            K * ops.power(delta_max) * ops.power((delta_max - recovered + gap) * (-1 / recovered))
        )

    def rates(
        self, phase: Phase, ops: Operators, x: Sequence[Any], delta_max: Any
    ) -> tuple[list[Any], Any, Any]:
        """Return the derivatives of the states, both in SI units, then F_n and F_t."""
        raise NotImplementedError

    def equations(
        self, phase: Phase, ops: Operators, z: Sequence[Any], delta_max: Any
    ) -> list[Any]:
        """Return the scaled derivatives of the scaled states `z`.

        Parameters
        ----------
        phase : Phase
        ops : Operators
        z : sequence
            States over `scale`.
        delta_max : expression or float
            Largest compression, m; used while unloading.
        """
        # A state that is itself the rate of another keeps its own scale: no needless products.
        x = [v * s if s != 1.0 else v for v, s in zip(z, self.scale, strict=True)]
        rates, _, _ = self.rates(phase, ops, x, delta_max)
        return [r * (self.time / s) for r, s in zip(rates, self.scale, strict=True)]

    def guard(self, phase: Phase, ops: Operators, z: Sequence[Any], delta_max: Any) -> Any:
        """Return the guard of the phase, positive until it ends."""
        if phase.guard == "slip":
            return -1.0 * z[self.slip]
        if phase.guard == "turn":
            return -1.0 * z[self.gap_rate]
        if phase.guard == "separation":
            return -1.0 * z[self.gap] - delta_max * ((1.0 - E_ENERGETIC**2) / self.scale[self.gap])
        x = [v * s if s != 1.0 else v for v, s in zip(z, self.scale, strict=True)]
        _, F_n, F_t = self.rates(phase, ops, x, delta_max)
        return self.mu * F_n + F_t

    def settle(self, phase: Phase, z: Any) -> Any:
        """Put at exact zero what the guard of the phase has brought there."""
        if phase.guard == "slip":
            z[self.slip] = 0.0
        elif phase.guard == "turn":
            z[self.gap_rate] = 0.0
        elif phase.guard in ("left", "right"):
            # A velocity of exactly zero could be taken for the end of the slip that begins.
            z[self.slip] = BEGINNING if phase.guard == "right" else -BEGINNING
        return z

    def unscale(self, z: Sequence[float], t: float) -> dict[str, float]:
        """Return the named end state in SI units."""
        end = {n: float(v) * s for n, v, s in zip(self.states, z, self.scale, strict=True)}
        return end | {"t": float(t) * self.time}

    @property
    def scaled_start(self) -> np.ndarray:
        """The scaled initial state."""
        return np.array(self.start) / np.array(self.scale)

    def free_start(self, h: float, number: Callable[[float], Any] = float) -> tuple[list[Any], Any]:
        """Return the scaled state a time `h` (s) after touching, as if still in free flight.

        The contact force is 1e-13 N at 1e-8 s, so what it would have changed is lost in rounding.
        """
        raise NotImplementedError

    def end_error(self, end: dict[str, float], reverse_slip: bool) -> float:
        """Return the largest relative error of the compared velocities at separation."""
        reference = self.reference[reverse_slip]
        return max(
            abs(end[name] - reference[name]) / (size or abs(reference[name]))
            for name, size in self.compared.items()
        )


def _elementary(number: Callable[[float], Any]) -> tuple[Any, Any]:
    return (math.sin, math.cos) if number is float else (np.sin, np.cos)


@dataclass(frozen=True)
class Rod(Case):
    """The inconsistent state of the paper's Table 3: theta = 1, theta_dot = 1, x_A_dot = -1."""

    mu = 1.4
    mass: ClassVar[float] = 1.0
    half: ClassVar[float] = 1.0

    def rates(
        self, phase: Phase, ops: Operators, x: Sequence[Any], delta_max: Any
    ) -> tuple[list[Any], Any, Any]:
        """Return the derivatives of the states, then F_n and F_t."""
        rate, m, l = x[5], self.mass, self.half
        F_n = self.normal_force(phase, ops, x[2], delta_max)
        s, c = ops.sin(x[4]), ops.cos(x[4])
        if phase.tangent == "stick":
            F_t = (3.0 * s * c * F_n - m * l * rate * rate * c) / (1.0 + 3.0 * s * s)
        else:
            F_t = (self.mu if phase.tangent == "left" else -self.mu) * F_n
        alpha = (3.0 / (m * l)) * (s * F_t - c * F_n)
        slip = F_t * (1.0 / m) + l * (alpha * s + rate * rate * c)
        normal = F_n * (1.0 / m) - G - l * (alpha * c - rate * rate * s)
        if phase.tangent == "stick":
            slip = 0.0 * rate
        return [x[1], slip, x[3], normal, rate, alpha], F_n, F_t

    def free_start(self, h: float, number: Callable[[float], Any] = float) -> tuple[list[Any], Any]:
        """Return the scaled state shortly after touching; nothing cancels in the formulas."""
        x, v, _, _, theta, omega = (number(value) for value in self.start)
        h, l = number(h), self.half
        sin, cos = _elementary(number)
        half, turn = sin(omega * h / 2), omega * h
        # 1 - cos(turn), sin(theta + turn) - sin(theta), cos(theta + turn) - cos(theta).
        lag = 2 * half * half
        rise = sin(turn) * cos(theta) - lag * sin(theta)
        fall = -sin(turn) * sin(theta) - lag * cos(theta)
        # turn - sin(turn) to the order that rounding keeps for turn < 1e-7.
        bend = turn**3 / 6
        state = [
            x + (v - l * omega * sin(theta)) * h - l * fall,
            v + l * omega * rise,
            -number(G) * h * h / 2 + l * (sin(theta) * lag + cos(theta) * bend),
            -number(G) * h + l * omega * (sin(theta) * sin(turn) + cos(theta) * lag),
            theta + turn,
            omega,
        ]
        scaled = [value / number(unit) for value, unit in zip(state, self.scale, strict=True)]
        return scaled, h / number(self.time)


@dataclass(frozen=True)
class Arm(Case):
    """Two uniform links at rest, the tip on a belt: an inconsistent state, A = -0.32, B = -4.8."""

    mu = 1.0
    mass: ClassVar[float] = 1.0
    length: ClassVar[float] = 0.5

    def rates(
        self, phase: Phase, ops: Operators, x: Sequence[Any], delta_max: Any
    ) -> tuple[list[Any], Any, Any]:
        """Return the derivatives of the states, then F_n and F_t.

        Both angles count from the x axis: the kinetic energy is I_1 ω_1²/2 + I_2 ω_2²/2 +
        k cos(θ_1 - θ_2) ω_1 ω_2.
        """
        m, l = self.mass, self.length
        one, two, w_1, w_2 = x[0], x[1], x[2], x[3]
        I_1, I_2, k = m * l * l / 3.0 + m * l * l, m * l * l / 3.0, 0.5 * m * l * l
        s_1, c_1, s_2, c_2 = ops.sin(one), ops.cos(one), ops.sin(two), ops.cos(two)
        C, S = k * (c_1 * c_2 + s_1 * s_2), k * (s_1 * c_2 - c_1 * s_2)
        F_n = self.normal_force(phase, ops, x[4], delta_max)
        v_1, v_2 = w_1 * w_1, w_2 * w_2
        free_1 = -1.5 * m * G * l * c_1 - S * v_2
        free_2 = -0.5 * m * G * l * c_2 + S * v_1
        det = 1.0 / (I_1 * I_2 - C * C)

        def solve(q_1: Any, q_2: Any) -> tuple[Any, Any]:
            return (I_2 * q_1 - C * q_2) * det, (I_1 * q_2 - C * q_1) * det

        if phase.tangent == "stick":
            b_1, b_2 = solve(free_1 + l * c_1 * F_n, free_2 + l * c_2 * F_n)
            u_1, u_2 = solve(s_1, s_2)
            # Of the tangential acceleration: without F_t, and per unit of it.
            without = s_1 * b_1 + s_2 * b_2 + c_1 * v_1 + c_2 * v_2
            per_unit = l * (s_1 * u_1 + s_2 * u_2)
            F_t = without / per_unit
        else:
            F_t = (self.mu if phase.tangent == "left" else -self.mu) * F_n
        a_1, a_2 = solve(free_1 + l * (c_1 * F_n - s_1 * F_t), free_2 + l * (c_2 * F_n - s_2 * F_t))
        slip = -l * (s_1 * a_1 + s_2 * a_2 + c_1 * v_1 + c_2 * v_2)
        normal = l * (c_1 * a_1 + c_2 * a_2 - s_1 * v_1 - s_2 * v_2)
        if phase.tangent == "stick":
            slip = 0.0 * w_1
        return [w_1, w_2, a_1, a_2, x[5], normal, slip], F_n, F_t

    def free_start(self, h: float, number: Callable[[float], Any] = float) -> tuple[list[Any], Any]:
        """Return the scaled state shortly after touching: from rest, to third order in h."""

        class Numbers:
            sin, cos = (staticmethod(f) for f in _elementary(number))
            power = staticmethod(lambda base: base * 0)
            inverse_root = staticmethod(lambda base: 1 / np.sqrt(base))

        x = [number(value) for value in self.start]
        h = number(h)
        rates, _, _ = self.rates(Phase("virgin", "left", "slip"), Numbers, x, number(1.0))
        _, _, a_1, a_2, _, normal, slip = rates
        # At rest every rate of an acceleration vanishes: the next terms are of order h⁴ and h³.
        state = [
            x[0] + a_1 * h * h / 2,
            x[1] + a_2 * h * h / 2,
            a_1 * h,
            a_2 * h,
            normal * h * h / 2,
            normal * h,
            x[6] + slip * h,
        ]
        scaled = [value / number(unit) for value, unit in zip(state, self.scale, strict=True)]
        return scaled, h / number(self.time)


@dataclass(frozen=True)
class Belt(Case):
    """A block on a belt that runs to and fro, held by an inclined spring: ``shaken_belt.toml``.

    The states are the position, the slip velocity and the phase of the belt.
    """

    mu = 0.4
    time = 0.05
    horizon = 50.0
    longest_step = 1.5
    mass: ClassVar[float] = 1.0
    spring: ClassVar[tuple[float, float, float]] = (150.0, 2.0, 0.5)
    joint: ClassVar[tuple[float, float]] = (0.3, 0.4)
    speed: ClassVar[float] = 0.4
    omega: ClassVar[float] = 16.0
    #: Time at the end of the motion, s.
    duration: ClassVar[float] = 2.0

    def phases(self, reverse_slip: bool) -> list[Phase]:
        """List the phases up to `duration`."""
        right, left = Phase("rigid", "right", "slip"), Phase("rigid", "left", "slip")
        period = [Phase("rigid", "stick", "right"), right, Phase("rigid", "stick", "left"), left]
        return [right, left, *(5 * period)[:-1], Phase("rigid", "left", "time")]

    def rates(
        self, phase: Phase, ops: Operators, x: Sequence[Any], delta_max: Any
    ) -> tuple[list[Any], Any, Any]:
        """Return the derivatives of the states, then F_n and F_t."""
        (k, c, relaxed), (a, h), m = self.spring, self.joint, self.mass
        belt, turn = self.speed * ops.sin(x[2]), self.speed * self.omega * ops.cos(x[2])
        velocity, level = x[1] + belt, x[0] + a
        squared = level * level + h * h
        # In units of the spring's length: its rate is level · velocity over that length.
        pull = k * (1.0 - relaxed * ops.inverse_root(squared)) + c * level * velocity / squared
        F_n, spring = m * G - h * pull, -1.0 * level * pull
        if phase.tangent == "stick":
            return [belt, 0.0 * x[1], self.omega + 0.0 * x[1]], F_n, m * turn - spring
        F_t = (self.mu if phase.tangent == "left" else -self.mu) * F_n
        return [velocity, (spring + F_t) * (1.0 / m) - turn, self.omega + 0.0 * x[1]], F_n, F_t

    def guard(self, phase: Phase, ops: Operators, z: Sequence[Any], delta_max: Any) -> Any:
        """Return the guard of the phase, positive until it ends."""
        if phase.guard == "slip":
            return (1.0 if phase.tangent == "right" else -1.0) * z[self.slip]
        x = [v * s if s != 1.0 else v for v, s in zip(z, self.scale, strict=True)]
        if phase.guard == "time":
            return self.omega * self.duration - x[2]
        _, F_n, F_t = self.rates(phase, ops, x, delta_max)
        return self.mu * F_n + (1.0 if phase.guard == "right" else -1.0) * F_t

    def free_start(self, h: float, number: Callable[[float], Any] = float) -> tuple[list[Any], Any]:
        """Return the start itself: all functions have series there."""
        scaled = [number(v) / number(s) for v, s in zip(self.start, self.scale, strict=True)]
        return scaled, number(0.0)


ROD = Rod(
    name="Table 3, rod",
    states=("x_A", "x_A_dot", "y_A", "y_A_dot", "theta", "theta_dot"),
    start=(0.0, -1.0, 0.0, 0.0, 1.0, 1.0),
    scale=(1e-3, 1.0, 1e-6, 1e-2, 1.0, 1.0),
    gap=2,
    gap_rate=3,
    slip=1,
    # The slip velocity is zero at the end, or 3e-8 m/s of reverse slip.
    compared={"x_A_dot": 1.0, "y_A_dot": None, "theta_dot": None},
    # The hand-written oracle with DOP853 agrees to 1e-12.
    reference={
        True: {
            "x_A": -0.0003513203907596878996,
            "x_A_dot": 3.493651282849119475e-08,
            "y_A": -6.1692008543773274275e-07,
            "y_A_dot": 0.06561146794473226641,
            "theta": 1.0004765555831951191,
            "theta_dot": 1.6029856063339738937,
            "t": 0.0004281634640972055375,
        },
        False: {
            "x_A": -0.00035132039076019405435,
            "x_A_dot": 0.0,
            "y_A": -6.1692008543773274275e-07,
            "y_A_dot": 0.065611483184048066065,
            "theta": 1.0004765555831893158,
            "theta_dot": 1.6029855781079026812,
            "t": 0.00042816346409384050922,
        },
    },
)

ARM = Arm(
    name="two-link arm",
    states=(
        "theta_1",
        "theta_2",
        "theta_1_dot",
        "theta_2_dot",
        "gap",
        "gap_dot",
        "slip_velocity",
    ),
    start=(-1.3, -1.8, 0.0, 0.0, 0.0, 0.0, -1.0),
    scale=(1.0, 1.0, 1.0, 1.0, 1e-6, 1e-2, 1.0),
    gap=4,
    gap_rate=5,
    slip=6,
    compared={"slip_velocity": 1.0, "gap_dot": None, "theta_1_dot": None, "theta_2_dot": None},
    reference={
        True: {
            "theta_1": -1.2999548079732199394,
            "theta_2": -1.799929107427535617,
            "theta_1_dot": 1.6141386829955773188,
            "theta_2_dot": 0.45663816330949818544,
            "gap": -2.0073478092257435919e-06,
            "gap_dot": 0.16406643654383043056,
            "slip_velocity": 1.8661100538141554431e-07,
            "t": 3.783251024178599945e-04,
        }
    },
)

BELT = Belt(
    name="block on a shaken belt",
    states=("x", "slip_velocity", "belt_phase"),
    start=(0.0, 0.1, 0.0),
    scale=(0.1, 1.0, 1.0),
    gap=0,
    gap_rate=0,
    slip=1,
    compared={"x": 0.1, "slip_velocity": 1.0},
    reference={
        True: {
            "x": -0.011312995898303671998,
            "slip_velocity": -0.08384250940658787555,
            "belt_phase": 32.0,
            "t": 2.0,
        }
    },
)

CASES = (ROD, ARM)
"""The impacts."""

MOTIONS = (*CASES, BELT)
"""All motions: the impacts, and one of many events."""
