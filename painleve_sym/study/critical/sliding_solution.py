"""The sliding solution of the indeterminate state: its force, its rates, and its stable manifold.

Where A < 0 < B a contact of finite stiffness can slide with F_n* = −B/A. Of the normal motion
δ̈ = −(A F_n + B) that is a saddle, and the starts that lead to it separate lift-off from impact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from painleve_sym.at.cases import contact_problem
from painleve_sym.at.delassus import Delassus
from painleve_sym.at.inputs import inside
from painleve_sym.automata.model import SLIPS
from painleve_sym.codegen.evaluate import expression_function
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.motion.simulator import Simulator
from painleve_sym.plain_data import to_plain

if TYPE_CHECKING:
    import casadi as ca

SERIES_WITHIN = 0.1
"""Where the energy of the saddle is a difference of nearly equal numbers, a series replaces it."""

MAX_EXPONENT = 100.0
"""Of a law: powers of twice the compression then stay far from the largest number."""

_LINEARISED = (
    *("exponent", "slope", "growth_rate", "decay_rate"),
    *("unloading_growth_rate", "unloading_decay_rate", "conservative"),
)


@dataclass(frozen=True, eq=False)
class SlidingSolution(Compared):
    """The sliding solution at one state, with the contact law linearised about it.

    Attributes
    ----------
    slip : {-1, +1}
        Slip direction s.
    A, B : float
        g̈_N = A F_n + B, A < 0 < B; 1/kg and m/s².
    force : float
        F_n* = −B/A; N.
    force_rate, force_second_rate : float
        dF_n*/dt and d²F_n*/dt² along the sliding solution; N/s, N/s².
    A_rate : float
        dA/dt; 1/(kg s).
    rate_per_force : float
        ∂(dF_n*/dt)/∂F_n: what a force that differs from F_n* adds; 1/s.
    compression, compression_rate : float
        δ* with F_n(δ*) = F_n*, and how fast it moves; m, m/s.
    approach : float
        δ̇ = −ġ_N of the state, positive while it compresses; m/s.
    exponent : float
        n of the law; 1.
    growth_rate, decay_rate : float
        λ₊ > 0 and λ₋ < 0 of a small deviation on the loading curve; 1/s. Without damping
        λ± = ±√(n B/δ*).
    unloading_growth_rate, unloading_decay_rate : float
        The same on the curve that is followed when the contact opens from δ*; 1/s.
    conservative : bool
        Whether the law's force depends on δ alone.
    """

    slip: int
    A: float
    B: float
    force: float
    force_rate: float
    force_second_rate: float
    A_rate: float
    rate_per_force: float
    compression: float
    compression_rate: float
    approach: float
    exponent: float
    growth_rate: float
    decay_rate: float
    unloading_growth_rate: float
    unloading_decay_rate: float
    conservative: bool

    def force_of(self, compression: float) -> float:
        """Return F_n on the loading curve at rest; N."""
        ratio = max(0.0, compression) / self.compression
        return float(self.force * ratio**self.exponent)

    @property
    def barrier_speed(self) -> float:
        """√(2 n B δ*/(n + 1)): the approach that just reaches δ* from δ = 0, A and B held; m/s.

        Only without damping.
        """
        return math.sqrt(2 * self.exponent * self.B * self.compression / (self.exponent + 1))

    @property
    def predicted_force(self) -> float:
        """Critical initial force from the saddle of constant A and B, carried along with δ*; N.

        With w = δ̇₀ − δ̇* the stable manifold is the energy level of the saddle,

            (n + 1) w²/(2 B δ*) = n − (n + 1) x + xⁿ⁺¹,    x = δ₀/δ*,

        x < 1 for w > 0. For δ̇₀ = 0 this is F_n* + Ḟ_n*/λ₊ up to terms in 1/λ₊². Laws with damping
        have the tangent δ₀ = δ* + δ̇*/λ₊ − δ̇₀/|λ₋| instead. 0 where every initial force leads to
        impact.
        """
        relative = self.approach - self.compression_rate
        # The curve the motion is on; a start at rest follows δ*.
        closes = (self.approach or self.compression_rate) >= 0
        decay = self.decay_rate if closes else self.unloading_decay_rate
        if not self.conservative:
            growth = self.growth_rate if closes else self.unloading_growth_rate
            shift = self.compression_rate / growth + self.approach / decay
            return self.force_of(self.compression + shift)
        # An unloading curve is the loading curve, contracted: its energy is smaller by this part.
        contraction = (self.decay_rate / decay) ** 2
        level = (self.exponent + 1) * relative**2
        level /= 2 * self.B * self.compression * contraction
        return self.force_of(self.compression * _separatrix(level, relative, self.exponent))

    @property
    def expansion(self) -> tuple[float, float, float]:
        """Terms of the critical force F_n* + Ḟ_n*/λ + c/λ² + O(λ⁻³) of a start without ġ_N; N.

        c = F̈_n* + Ḟ_n* (r/2 − Ȧ/(4A)) − 11 (n − 1) Ḟ_n*²/(12 n F_n*) with r = `rate_per_force`.
        Where F_n* falls the contact opens along the stable manifold, with λ of its unloading.
        Laws with damping have the first two terms only; the third is nan.
        """
        rate, n = self.force_rate, self.exponent
        growth = self.growth_rate if rate >= 0 else self.unloading_growth_rate
        second = self.force_second_rate + rate * (
            self.rate_per_force / 2 - self.A_rate / self.A / 4
        )
        second -= 11 * (n - 1) * rate**2 / (12 * n * self.force)
        second = second / growth**2 if self.conservative else math.nan
        return self.force, rate / growth, second

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        return {
            **to_plain(self),
            "barrier_speed": self.barrier_speed if self.conservative else None,
        }


def _energy(x: float, n: float) -> float:
    """n − (n + 1) x + xⁿ⁺¹ without loss of digits near its double zero x = 1."""
    xi = x - 1
    if abs(xi) >= SERIES_WITHIN:
        return float(n - (n + 1) * x + x ** (n + 1))
    total, factor = 0.0, (n + 1) * xi
    for k in range(2, 24):
        factor *= (n + 2 - k) * xi / k
        total += factor
    return total


def _separatrix(level: float, relative: float, n: float) -> float:
    """Return x with `_energy` = `level`, below 1 for an approach and above for a withdrawal."""
    if relative > 0:
        if level >= n:
            return 0.0
        low, high = 1.0, 0.0
    else:
        low, high = 1.0, 2.0
        while _energy(high, n) < level:
            high *= 2
    while True:
        middle = (low + high) / 2
        if middle in (low, high):
            return middle
        low, high = (middle, high) if _energy(middle, n) < level else (low, middle)


@dataclass(frozen=True)
class SlidingAnalysis:
    """Finds the sliding solution of a mechanism on a contact law; build once, use often."""

    simulator: Simulator

    @property
    def _names(self) -> tuple[str, ...]:
        """Names of states and constants, on which everything depends."""
        return (
            *self.simulator.mechanism.outline.state_names,
            *self.simulator.outline.constant_names,
        )

    def _quantities(
        self,
        title: str,
        arguments: Sequence[str],
        derive: Callable[[], tuple[list[str], ca.Function]],
    ) -> Quantities:
        # They are evaluated too few times to be compiled.
        return quantities(
            title, self.simulator.contact.definition, arguments, derive, compiles=False
        )

    @property
    def _symbols(self) -> tuple[Any, ...]:
        """Symbols of `_names`."""
        mechanism, automaton = self.simulator.mechanism, self.simulator.automaton
        return (*mechanism.motion, *automaton.parameters, *automaton.definitions)

    @cached_property
    def _mechanical(self) -> Quantities:
        """By slip direction: dA/dt, and ∂(dF_n*/dt)/∂F."""

        def derive() -> tuple[list[str], ca.Function]:
            from painleve_sym.mechanics.coefficients import F_N
            from painleve_sym.mechanics.paradox.sliding import coefficient_rates

            c, parts = self.simulator.mechanism.coefficients, []
            for slip in SLIPS:
                A_dot, B_dot = coefficient_rates(c, slip)
                at = {F_N: c.slip_force(slip)}
                parts += [A_dot.xreplace(at), -B_dot.diff(F_N).xreplace(at) / c.A(slip)]
            names = [f"{name}_{slip}" for slip in SLIPS for name in ("A_rate", "rate_per_force")]
            return names, expression_function("rates", parts, self._symbols)

        return self._quantities("rates of A and of the sliding force", self._names, derive)

    def _drift(self, slip: int) -> Quantities:
        """Return dF_n*/dt with its gradient."""
        moving = self.simulator.mechanism.outline.state_names

        def derive() -> tuple[list[str], ca.Function]:
            from painleve_sym.mechanics.paradox.sliding import sliding_force_rate

            mechanism = self.simulator.mechanism
            rate = sliding_force_rate(mechanism.coefficients, slip)
            names = ["force_rate", *(f"force_rate_by_{name}" for name in moving)]
            return names, expression_function("drift", [rate], self._symbols, mechanism.motion)

        return self._quantities(f"drift of the sliding force, slip {slip}", self._names, derive)

    def _field(self, slip: int) -> Quantities:
        """Return the rates of the state along the sliding solution."""
        moving = self.simulator.mechanism.outline.state_names

        def derive() -> tuple[list[str], ca.Function]:
            from painleve_sym.mechanics.paradox.sliding import sliding_field

            mechanism = self.simulator.mechanism
            rates = mechanism.system.rates | sliding_field(mechanism.coefficients, slip)
            field = [rates[s] for s in mechanism.motion]
            return list(moving), expression_function("field", field, self._symbols)

        return self._quantities(f"rates of sliding, slip {slip}", self._names, derive)

    @cached_property
    def _linearised(self) -> Quantities:
        """Of the law about δ*: exponent, slope, rates of both saddles, conservative or not."""

        def derive() -> tuple[list[str], ca.Function]:
            from painleve_sym.laws import saddle

            automaton, law = self.simulator.automaton, self.simulator.contact_law
            both = saddle.loading_saddle(law), saddle.unloading_saddle(law)
            parts = [law.exponent, both[0].slope, *both[0].rates, *both[1].rates]
            parts.append(int(all(s.conservative for s in both)))
            own = (*automaton.parameters, *automaton.definitions)
            symbols = (saddle.A, saddle.B, saddle.DEPTH, *own)
            return list(_LINEARISED), expression_function("saddle", parts, symbols)

        arguments = ("A", "B", "depth", *self.simulator.outline.constant_names)
        return self._quantities("law about the sliding solution", arguments, derive)

    def at(
        self, state: Mapping[str, float], parameters: Mapping[str, float] | None = None
    ) -> SlidingSolution:
        """Return the sliding solution at a state on the surface that slips.

        Absent coordinates and velocities are 0, absent parameters of mechanism and law have their
        defaults. The gap must be 0, its rate may not be. InputError for unknown names, numbers out
        of range, an open contact, no slip, or a state that is not indeterminate.
        """
        solution, gap = self._at(state, parameters)
        if gap != 0:
            raise InputError(
                f"{self._where}: got gap = {gap:g} m, need 0: the initial force sets the "
                "compression. Fix: start on the surface."
            )
        return solution

    def along(
        self, state: Mapping[str, float], parameters: Mapping[str, float] | None = None
    ) -> SlidingSolution:
        """Return the sliding solution at a state of a run, compressed or not; see `at`."""
        return self._at(state, parameters)[0]

    @property
    def _where(self) -> str:
        return f"sliding solution of {self.simulator.where}"

    def _at(
        self, state: Mapping[str, float], parameters: Mapping[str, float] | None
    ) -> tuple[SlidingSolution, float]:
        """Return the sliding solution and the gap, 0 where it is 0 but for rounding."""
        simulator = self.simulator
        mechanism = simulator.mechanism
        place = inside(simulator.at(state, parameters))
        start, values = place.state, place.parameters
        constants = simulator.constants(values)
        problem = contact_problem(mechanism, start, values)
        numbers = {**start, **constants}
        point = [numbers[name] for name in self._names]
        own = self._mechanical.of_point(point)
        at = Delassus.of(mechanism).at(numbers)
        gap, gap_rate = float(at.gap[0]), float(at.gap_rate[0])
        B, slip = problem.B, problem.slip_direction
        if not slip:
            raise InputError(
                f"{self._where}: got slip velocity 0, need slip. Fix: give a state that slides."
            )
        A = problem.A_slip(slip)
        if not A < 0 < B:
            raise InputError(
                f"{self._where}: got A = {A:g} 1/kg and B = {B:g} m/s^2, need A < 0 and B > 0 "
                "(indeterminate). Fix: choose a state there; `painleve map` shows where."
            )
        force = -B / A
        depth = simulator.compression_of_force(force, values)
        local = self._linearised.of_point([A, B, depth, *constants.values()])
        slope, conservative = local.pop("slope"), bool(local.pop("conservative"))
        rate, *gradient = self._drift(slip).of_vector(point)
        field = self._field(slip).of_vector(point)
        second = sum(g * v for g, v in zip(gradient, field, strict=True))
        exponent, rates = local["exponent"], (local["growth_rate"], local["decay_rate"])
        # The rates of unloading are infinite where nothing is recovered.
        self._check_range((force, depth, exponent, slope, rate, second, *rates), exponent)
        solution = SlidingSolution(
            slip=slip,
            A=A,
            B=B,
            force=force,
            force_rate=rate,
            force_second_rate=second,
            A_rate=own[f"A_rate_{slip}"],
            rate_per_force=own[f"rate_per_force_{slip}"],
            compression=depth,
            compression_rate=rate / slope,
            approach=0.0 if abs(gap_rate) <= at.rate_tolerance[0] else -gap_rate,
            conservative=conservative,
            **local,
        )
        return solution, 0.0 if abs(gap) <= at.gap_tolerance[0] else gap

    def _check_range(self, numbers: tuple[float, ...], exponent: float) -> None:
        if not all(map(math.isfinite, numbers)) or exponent > MAX_EXPONENT:
            raise InputError(
                f"{self._where}: got numbers beyond the range of floating point (exponent "
                f"{exponent:g} of the law, need at most {MAX_EXPONENT:g}). Fix: give a law and a "
                "state of usual size."
            )
