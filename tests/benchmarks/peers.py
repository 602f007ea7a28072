"""Solve one tangential impact with other libraries, for comparison with the package's engine.

The case is the inconsistent state of the paper's Table 3 at E = 20.9e14: theta = 1, theta_dot = 1,
x_A_dot = -1, from touching at t = 0 to separation. Every peer integrates the same phases of the
same six equations, watches the one guard that ends the phase, and returns the state at separation.

All peers solve the case in scaled variables, time included. This is in their favour: SciPy places
events to 9e-16 in the unit of time, heyoka controls one norm over all states and CasADi's ``erk``
takes one absolute tolerance.

Nothing here imports the package. Its own engine takes part as one more class with `prepare` and
`run`, see `bench_table3`.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import math
import shutil
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Protocol

import numpy as np

M, L, G, MU, N = 1.0, 1.0, 9.8, 1.4, 1.764
E_ENERGETIC = 0.75
#: K_e = 4/3 E* sqrt(R*), with E = 20.9e14, nu = 0.3, R* = R = 0.00645.
K = 4.0 / 3.0 * 20.9e14 / (2.0 * (1.0 - 0.3**2)) * math.sqrt(0.00645)
#: x_A, x_A_dot, y_A, y_A_dot, theta, theta_dot.
START = (0.0, -1.0, 0.0, 0.0, 1.0, 1.0)
NAMES = ("x_A", "x_A_dot", "y_A", "y_A_dot", "theta", "theta_dot")

#: Units of the scaled states: the slip travelled, the slip speed, the largest compression and the
#: rebound speed, rounded; angles as they are. And the unit of time, s.
SCALE = (1e-3, 1.0, 1e-6, 1e-2, 1.0, 1.0)
TIME = 1e-4
#: Later than the separation, in units of TIME.
HORIZON = 6.0

#: State at separation by heyoka's Taylor method in 80-bit floating point at tolerance 1e-19, for
#: `reverse_slip` true and false. The hand-written oracle with DOP853 agrees to 1e-12.
REFERENCE: dict[bool, dict[str, float]] = {
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
}


@dataclass(frozen=True)
class Phase:
    """Name the equations between two events and the guard that ends them.

    Attributes
    ----------
    normal : str
        ``"virgin"`` or ``"unloading"``.
    tangent : str
        ``"left"``, ``"stick"`` or ``"right"``.
    guard : str
        ``"slip"``, ``"turn"``, ``"friction"`` or ``"separation"``: what reaches zero at the end.
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


class _FloatOperators:
    """Evaluate the equations in Python floats."""

    sin = staticmethod(math.sin)
    cos = staticmethod(math.cos)

    @staticmethod
    def power(base: float) -> float:
        """Return base**N; a trial step past the contact would have a complex one."""
        return max(base, 0.0) ** N


def forces(phase: Phase, ops: Operators, gap: Any, angle: Any, rate: Any, delta_max: Any) -> Any:
    """Return F_n, F_t and the sine and cosine of the angle."""
    s, c = ops.sin(angle), ops.cos(angle)
    if phase.normal == "virgin":
        F_n = K * ops.power(-gap)
    else:
        recovered = E_ENERGETIC**2 * delta_max
        F_n = K * ops.power(delta_max) * ops.power((delta_max - recovered + gap) * (-1 / recovered))
    if phase.tangent == "stick":
        F_t = (3.0 * s * c * F_n - M * L * rate * rate * c) / (1.0 + 3.0 * s * s)
    else:
        F_t = (MU if phase.tangent == "left" else -MU) * F_n
    return F_n, F_t, s, c


def equations(phase: Phase, ops: Operators, z: Sequence[Any], delta_max: Any) -> list[Any]:
    """Return the scaled derivatives of the scaled states `z`.

    Parameters
    ----------
    phase : Phase
    ops : Operators
    z : sequence of 6
        States over SCALE.
    delta_max : expression or float
        Largest compression, m; used while unloading.
    """
    gap, rate = z[2] * SCALE[2], z[5]
    F_n, F_t, s, c = forces(phase, ops, gap, z[4], rate, delta_max)
    alpha = (3.0 / (M * L)) * (s * F_t - c * F_n)
    slip = F_t * (1.0 / M) + L * (alpha * s + rate * rate * c)
    normal = F_n * (1.0 / M) - G - L * (alpha * c - rate * rate * s)
    if phase.tangent == "stick":
        slip = 0.0 * rate
    return [
        z[1] * (SCALE[1] * TIME / SCALE[0]),
        slip * (TIME / SCALE[1]),
        z[3] * (SCALE[3] * TIME / SCALE[2]),
        normal * (TIME / SCALE[3]),
        rate * TIME,
        alpha * TIME,
    ]


def guard(phase: Phase, ops: Operators, z: Sequence[Any], delta_max: Any) -> Any:
    """Return the guard of the phase, positive until it ends."""
    if phase.guard == "slip":
        return -1.0 * z[1]
    if phase.guard == "turn":
        return -1.0 * z[3]
    if phase.guard == "separation":
        return -1.0 * z[2] - delta_max * ((1.0 - E_ENERGETIC**2) / SCALE[2])
    F_n, F_t, _, _ = forces(phase, ops, z[2] * SCALE[2], z[4], z[5], delta_max)
    return MU * F_n + F_t


def settle(phase: Phase, z: Any) -> Any:
    """Put at exact zero what the guard of the phase has brought there."""
    if phase.guard == "slip":
        z[1] = 0.0
    elif phase.guard == "turn":
        z[3] = 0.0
    return z


def unscale(z: Sequence[float], t: float) -> dict[str, float]:
    """Return the named end state in SI units."""
    end = {name: float(v) * s for name, v, s in zip(NAMES, z, SCALE, strict=True)}
    return end | {"t": float(t) * TIME}


def scaled_start() -> np.ndarray:
    """Return the scaled initial state, shape (6,)."""
    return np.array(START) / np.array(SCALE)


class Peer(Protocol):
    """Solve the impact.

    Attributes
    ----------
    name : str
        Line of the table.
    loosest, tightest : float
        Range of tolerances that make sense for this peer.
    """

    name: str
    loosest: float
    tightest: float

    def prepare(self) -> None:
        """Compile what does not depend on the tolerance."""

    def run(self, tol: float) -> dict[str, float]:
        """Return x_A_dot, y_A_dot, theta, theta_dot, y_A (SI units) and t at separation."""


@dataclass
class SciPyPeer:
    """SciPy's ``solve_ivp`` with DOP853 and one terminal event per phase."""

    reverse_slip: bool = False
    name: str = "SciPy DOP853"
    loosest: float = 1e-4
    # SciPy clips rtol below a hundred units of rounding, and warns.
    tightest: float = 2.3e-14
    requires: ClassVar[str] = "scipy"

    def prepare(self) -> None:
        """Build the callables of each phase."""
        self._phases = [(p, *self._callables(p)) for p in phases(self.reverse_slip)]

    @staticmethod
    def _callables(phase: Phase) -> tuple[Any, Any]:
        ops = _FloatOperators()

        def fun(_t: float, z: Any, delta_max: float) -> list[float]:
            return equations(phase, ops, z.tolist(), delta_max)

        def event(_t: float, z: Any, delta_max: float) -> float:
            return guard(phase, ops, z.tolist(), delta_max)

        event.terminal = True  # type: ignore[attr-defined]
        event.direction = -1.0  # type: ignore[attr-defined]
        return fun, event

    def run(self, tol: float) -> dict[str, float]:
        """Integrate phase after phase."""
        from scipy.integrate import solve_ivp

        t, z, delta_max = 0.0, scaled_start(), 1.0
        for phase, fun, event in self._phases:
            result = solve_ivp(
                fun,
                (t, HORIZON),
                z,
                method="DOP853",
                events=event,
                args=(delta_max,),
                rtol=tol,
                atol=tol,
            )
            if result.status != 1:
                raise RuntimeError(f"SciPy, tol={tol}, {phase}: {result.message}")
            t, z = float(result.t_events[0][0]), settle(phase, result.y_events[0][0])
            if phase.guard == "turn":
                delta_max = -float(z[2]) * SCALE[2]
        return unscale(z, t)


@dataclass
class SundaePeer:
    """SUNDIALS CVODE (Adams) through scikit-sundae, with one event function per phase."""

    reverse_slip: bool = False
    method: str = "Adams"
    name: str = "scikit-sundae CVODE"
    loosest: float = 1e-4
    # Below it CVODE ends with "too much accuracy requested".
    tightest: float = 1e-14
    requires: ClassVar[str] = "sksundae"

    def prepare(self) -> None:
        """Build the callables of each phase."""
        self._phases = [(p, *self._callables(p)) for p in phases(self.reverse_slip)]

    @staticmethod
    def _callables(phase: Phase) -> tuple[Any, Any]:
        ops = _FloatOperators()

        def fun(_t: float, z: Any, dz: Any, data: dict[str, float]) -> None:
            dz[:] = equations(phase, ops, z.tolist(), data["delta_max"])

        def event(_t: float, z: Any, out: Any, data: dict[str, float]) -> None:
            out[0] = guard(phase, ops, z.tolist(), data["delta_max"])

        event.terminal = [True]  # type: ignore[attr-defined]
        event.direction = [-1]  # type: ignore[attr-defined]
        return fun, event

    def run(self, tol: float) -> dict[str, float]:
        """Integrate phase after phase."""
        from sksundae.cvode import CVODE

        t, z, data = 0.0, scaled_start(), {"delta_max": 1.0}
        for phase, fun, event in self._phases:
            solver = CVODE(
                fun,
                method=self.method,
                rtol=tol,
                atol=tol,
                max_num_steps=100_000,
                eventsfn=event,
                num_events=1,
                userdata=data,
            )
            result = solver.solve(np.array([t, HORIZON]), z)
            if result.t_events is None or not len(result.t_events):
                raise RuntimeError(f"CVODE, tol={tol}, {phase}: {result.message}")
            t, z = float(result.t_events[0]), settle(phase, np.array(result.y_events[0]))
            if phase.guard == "turn":
                data["delta_max"] = -float(z[2]) * SCALE[2]
        return unscale(z, t)


class _HeyokaOperators:
    """Build the equations as heyoka expressions."""

    def __init__(self, number: Callable[[float], Any] = float) -> None:
        import heyoka

        self.sin, self.cos = heyoka.sin, heyoka.cos
        self._number = number

    def power(self, base: Any) -> Any:
        """Return base**N; heyoka's Taylor coefficients of it are nan at a zero base."""
        return base ** self._number(N)


def free_start(h: float, number: Callable[[float], Any] = float) -> tuple[list[Any], Any]:
    """Return the scaled state a time `h` (s) after touching, as if still in free flight.

    The contact force is 1e-13 N at 1e-8 s, so what it would have changed is lost in rounding.
    The formulas subtract nothing that cancels.
    """
    x, v, _, _, theta, omega = (number(value) for value in START)
    h = number(h)
    sin, cos = (math.sin, math.cos) if number is float else (np.sin, np.cos)
    half, turn = sin(omega * h / 2), omega * h
    # 1 - cos(turn), sin(theta + turn) - sin(theta), cos(theta + turn) - cos(theta).
    lag = 2 * half * half
    rise = sin(turn) * cos(theta) - lag * sin(theta)
    fall = -sin(turn) * sin(theta) - lag * cos(theta)
    # turn - sin(turn) to the order that rounding keeps for turn < 1e-7.
    bend = turn**3 / 6
    state = [
        x + (v - L * omega * sin(theta)) * h - L * fall,
        v + L * omega * rise,
        -number(G) * h * h / 2 + L * (sin(theta) * lag + cos(theta) * bend),
        -number(G) * h + L * omega * (sin(theta) * sin(turn) + cos(theta) * lag),
        theta + turn,
        omega,
    ]
    scaled = [value / number(unit) for value, unit in zip(state, SCALE, strict=True)]
    return scaled, h / number(TIME)


@dataclass
class HeyokaPeer:
    """heyoka's adaptive Taylor method with one terminal event per phase.

    The real power in the force has no Taylor series at zero compression, so the run starts
    1e-8 s after touching, from the closed form of free flight, see `free_start`.
    """

    reverse_slip: bool = False
    name: str = "heyoka Taylor"
    loosest: float = 1e-3
    tightest: float = 1e-16
    number: Callable[[float], Any] = float
    #: Time of the first state, s.
    begin: float = 1e-8
    requires: ClassVar[str] = "heyoka"

    def prepare(self) -> None:
        """Forget compiled integrators: the code of the Taylor series depends on the tolerance."""
        import heyoka

        heyoka.llvm_state.clear_memcache()
        self._compiled: dict[float, list[tuple[Phase, Any]]] = {}
        self._start, self._time = free_start(self.begin, self.number)

    def _compile(self, tol: float) -> list[tuple[Phase, Any]]:
        import heyoka as hy

        ops, built = _HeyokaOperators(self.number), []
        z = hy.make_vars(*NAMES)
        kind = {} if self.number is float else {"fp_type": self.number}
        for phase in phases(self.reverse_slip):
            rates = equations(phase, ops, z, hy.par[0])
            event = hy.t_event(
                guard(phase, ops, z, hy.par[0]), direction=hy.event_direction.negative, **kind
            )
            built.append(
                (
                    phase,
                    hy.taylor_adaptive(
                        list(zip(z, rates, strict=True)),
                        np.array(self._start, dtype=self.number),
                        pars=[self.number(1.0)] if phase.normal == "unloading" else [],
                        t_events=[event],
                        tol=self.number(tol),
                        **kind,
                    ),
                )
            )
        return built

    def solve(self, tol: float) -> tuple[Any, Any]:
        """Return the scaled state and time at separation in the peer's own number type."""
        if tol not in self._compiled:
            self._compiled[tol] = self._compile(tol)
        t, z, delta_max = self._time, self._start, 1.0
        for phase, integrator in self._compiled[tol]:
            integrator.time = t
            integrator.state[:] = z
            integrator.pars[:] = delta_max
            integrator.reset_cooldowns()
            outcome = integrator.propagate_until(self.number(HORIZON))[0]
            if int(outcome) != -1:
                raise RuntimeError(f"heyoka, tol={tol}, {phase}: ended with {outcome}")
            t, z = integrator.time, settle(phase, integrator.state)
            if phase.guard == "turn":
                delta_max = -z[2] * self.number(SCALE[2])
        return z, t

    def run(self, tol: float) -> dict[str, float]:
        """Integrate phase after phase."""
        return unscale(*self.solve(tol))


class _CasadiOperators:
    """Build the equations as CasADi expressions."""

    def __init__(self) -> None:
        import casadi

        self.sin, self.cos = casadi.sin, casadi.cos
        # No derivatives of the floored power are taken, so its kink does no harm.
        self.power = lambda base: casadi.fmax(base, 0.0) ** N


@dataclass
class ErkPeer:
    """CasADi's ``erk`` integrator, which has events but none that ends the integration.

    The phase, delta_max and the time are states of their own. The single guard is that of the
    current phase; its transition enters the next one, and in the last nothing moves any more, so
    the state at the end of the horizon is the state at separation.
    """

    reverse_slip: bool = False
    #: Whether to generate C and compile it, instead of CasADi's virtual machine.
    compiled: bool = False
    loosest: float = 1e-4
    tightest: float = 1e-15
    requires: ClassVar[str] = "casadi"
    flags: tuple[str, ...] = ("-O3", "-march=native", "-ffp-contract=off", "-fPIC", "-shared")

    @property
    def name(self) -> str:
        """Return the line of the table."""
        return "CasADi erk, generated C" if self.compiled else "CasADi erk, virtual machine"

    @property
    def scout(self) -> ErkPeer:
        """Return a peer with the same steps that needs no compiler for each tolerance."""
        return ErkPeer(self.reverse_slip)

    def prepare(self) -> None:
        """Build the equations of all phases and the transitions between them."""
        import casadi as ca

        ops, steps = _CasadiOperators(), phases(self.reverse_slip)
        z = ca.SX.sym("z", 9)
        states, delta_max = [z[k] for k in range(6)], z[6] * SCALE[2]
        rates, guards, jumps = [], [], []
        for index, phase in enumerate(steps):
            rates.append(ca.vertcat(*equations(phase, ops, states, delta_max), 0, 0, 1))
            guards.append(guard(phase, ops, states, delta_max))
            largest = -z[2] if phase.guard == "turn" else z[6]
            jumps.append(ca.vertcat(*settle(phase, list(states)), largest, index + 1, z[8]))
        rates.append(ca.SX.zeros(9))
        guards.append(ca.SX(1))
        jumps.append(z)
        x = ca.MX.sym("x", 9)

        def by_phase(name: str, cases: list[Any]) -> Any:
            made = [ca.Function(f"{name}{i}", [z], [ca.cse(e)]) for i, e in enumerate(cases)]
            return ca.Function.conditional(name, made[:-1], made[-1])(x[7], x)

        none = [ca.MX.sym(name, 0) for name in ("z", "p", "u")]
        self._transition = ca.Function(
            "transition",
            [ca.MX.sym("index"), ca.MX.sym("t"), x, *none],
            [by_phase("jump", jumps), ca.MX(0, 1)],
            ca.event_in(),
            ca.event_out(),
        )
        self._dae = {"x": x, "ode": by_phase("rate", rates), "zero": by_phase("guard", guards)}
        self._ready = {}

    def _build(self, tol: float) -> Any:
        import casadi as ca

        options = {
            "reltol": tol,
            "abstol": tol,
            "transition": self._transition,
            # Rounding of the scaled time, which is of order one.
            "event_tol": 1e-16,
            "max_num_steps": 1_000_000,
        }
        integrator = ca.integrator("impact", "erk", self._dae, 0.0, HORIZON, options)
        if not self.compiled:
            return integrator
        with tempfile.TemporaryDirectory() as folder:
            source, library = Path(folder, "impact.c"), Path(folder, "impact.so")
            generator = ca.CodeGenerator(source.name)
            generator.add(integrator)
            generator.generate(f"{folder}/")
            command = ["cc", *self.flags, str(source), "-o", str(library), "-lm"]
            subprocess.run(command, check=True, capture_output=True)
            # A loaded library outlives its file.
            return ca.external("impact", str(library))

    def run(self, tol: float) -> dict[str, float]:
        """Call the integrator once, through its buffer."""
        if tol not in self._ready:
            # CasADi announces on stderr that its events are experimental.
            with contextlib.redirect_stderr(io.StringIO()):
                function = self._build(tol)
            buffer, call = function.buffer()
            start, end = np.array([*scaled_start(), 1.0, 0.0, 0.0]), np.zeros(9)
            buffer.set_arg(0, memoryview(start))
            buffer.set_res(0, memoryview(end))
            self._ready[tol] = (function, buffer, call, start, end)
        _, buffer, call, _, end = self._ready[tol]
        call()
        if buffer.ret() or round(end[7]) != len(phases(self.reverse_slip)):
            raise RuntimeError(f"CasADi erk, tol={tol}: stopped in phase {end[7]:g}")
        return unscale(end[:6], end[8])


def peers(reverse_slip: bool = False) -> tuple[list[Peer], list[str]]:
    """Return the peers that are installed, and one line for each that is not.

    Parameters
    ----------
    reverse_slip : bool
        Passed to every peer, see `phases`.
    """
    every = [
        SciPyPeer(reverse_slip),
        SundaePeer(reverse_slip),
        HeyokaPeer(reverse_slip),
        ErkPeer(reverse_slip),
        ErkPeer(reverse_slip, compiled=True),
    ]
    found: list[Peer] = []
    skipped: list[str] = []
    for peer in every:
        if importlib.util.find_spec(peer.requires) is None:
            skipped.append(f"skipped: {peer.name} ({peer.requires} is not installed)")
        elif getattr(peer, "compiled", False) and shutil.which("cc") is None:
            skipped.append(f"skipped: {peer.name} (there is no C compiler `cc`)")
        else:
            found.append(peer)
    return found, skipped


def end_error(end: dict[str, float], reverse_slip: bool) -> float:
    """Return the largest relative error of the three velocities at separation.

    The slip velocity is zero there, or 3e-8 m/s of reverse slip: its error is relative to the
    slip velocity before the impact, 1 m/s.
    """
    reference = REFERENCE[reverse_slip]
    size = {"x_A_dot": abs(START[1])}
    return max(
        abs(end[name] - reference[name]) / size.get(name, abs(reference[name]))
        for name in ("x_A_dot", "y_A_dot", "theta_dot")
    )


def tune(peer: Any, target: float, known: dict[float, float] | None = None) -> float | None:
    """Return the loosest tolerance at which the end-state error is at most `target`.

    Tolerances are tried four to a decade. The error is no monotone function of the tolerance, so
    the next two tighter tolerances must reach the target too: a lucky hit does not count.

    Parameters
    ----------
    peer : Peer
        Prepared. Where it has a `scout`, that peer is asked in its place.
    target : float
        Largest `end_error`.
    known : dict of float to float, optional
        Errors by tolerance, read and added to, so that several targets share the runs.

    Returns
    -------
    float or None
        None if no tolerance of the peer's range reaches the target.
    """
    known = {} if known is None else known
    scout = getattr(peer, "scout", peer)
    if scout is not peer:
        scout.prepare()
    steps = math.floor(4.0 * math.log10(peer.loosest / peer.tightest) + 1e-9)
    tolerances = [peer.loosest * 10.0 ** (-k / 4.0) for k in range(steps + 1)]
    reached: list[float] = []
    for tol in tolerances:
        if tol not in known:
            # At a loose tolerance a peer may miss an event; CasADi then says so on stderr too.
            try:
                with contextlib.redirect_stderr(io.StringIO()):
                    known[tol] = end_error(scout.run(tol), peer.reverse_slip)
            except RuntimeError:
                known[tol] = math.inf
        reached = [*reached, tol] if known[tol] <= target else []
        if len(reached) == 3:
            return reached[0]
    # At the tight end of the range there may be fewer than two tolerances left to confirm with.
    return reached[0] if reached else None


def time_it(peer: Any, tol: float, repeats: int) -> float:
    """Return the median time of one run, s.

    Parameters
    ----------
    peer : Peer
        Prepared; a first run, which may compile for this tolerance, is not counted.
    tol : float
    repeats : int
        At least one.
    """
    peer.run(tol)
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        peer.run(tol)
        times.append(time.perf_counter() - start)
    return statistics.median(times)
