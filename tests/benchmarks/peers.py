"""Solve one tangential impact with other libraries, for comparison with the package's engines.

The cases are those of `cases`. Every peer integrates the same phases of the same equations, watches
the one guard that ends the phase, and returns the state at separation.

All peers solve the case in scaled variables, time included. This is in their favour: SciPy places
events to 9e-16 in the unit of time, heyoka controls one norm over all states and CasADi's ``erk``
takes one absolute tolerance.

Nothing here imports the package. Its own engines take part as one more class with `prepare`
and `run`, see `bench_table3`.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib.util
import io
import math
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Protocol

import numpy as np

from tests.benchmarks.cases import BEGINNING, ROD, Case, FloatOperators, N, Phase


class Peer(Protocol):
    """Solve the impact.

    Attributes
    ----------
    case : Case
    name : str
        Line of the table.
    loosest, tightest : float
        Range of tolerances that make sense for this peer.
    """

    case: Case
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

    case: Case = ROD
    reverse_slip: bool = False
    name: str = "SciPy DOP853"
    loosest: float = 1e-4
    # SciPy clips rtol below a hundred units of rounding, and warns.
    tightest: float = 2.3e-14
    requires: ClassVar[str] = "scipy"

    def prepare(self) -> None:
        """Build the callables of each phase."""
        self._phases = [(p, *self._callables(p)) for p in self.case.phases(self.reverse_slip)]

    def _callables(self, phase: Phase) -> tuple[Any, Any]:
        ops, case = FloatOperators(), self.case

        def fun(_t: float, z: Any, delta_max: float) -> list[float]:
            return case.equations(phase, ops, z.tolist(), delta_max)

        def event(_t: float, z: Any, delta_max: float) -> float:
            return case.guard(phase, ops, z.tolist(), delta_max)

        event.terminal = True  # type: ignore[attr-defined]
        event.direction = -1.0  # type: ignore[attr-defined]
        return fun, event

    def run(self, tol: float) -> dict[str, float]:
        """Integrate phase after phase."""
        from scipy.integrate import solve_ivp

        case, t, z, delta_max = self.case, 0.0, self.case.scaled_start, 1.0
        self.times: list[float] = []
        for phase, fun, event in self._phases:
            result = solve_ivp(
                fun,
                (t, case.horizon),
                z,
                method="DOP853",
                events=event,
                args=(delta_max,),
                rtol=tol,
                atol=tol,
                max_step=case.longest_step,
            )
            if result.status != 1:
                raise RuntimeError(f"SciPy, tol={tol}, {phase}: {result.message}")
            t, z = float(result.t_events[0][0]), case.settle(phase, result.y_events[0][0])
            self.times.append(t * case.time)
            if phase.guard == "turn":
                delta_max = -float(z[case.gap]) * case.scale[case.gap]
        return case.unscale(z, t)


@dataclass
class SundaePeer:
    """SUNDIALS CVODE (Adams) through scikit-sundae, with one event function per phase."""

    case: Case = ROD
    reverse_slip: bool = False
    method: str = "Adams"
    name: str = "scikit-sundae CVODE"
    loosest: float = 1e-4
    # Below it CVODE ends with "too much accuracy requested".
    tightest: float = 1e-14
    requires: ClassVar[str] = "sksundae"

    def prepare(self) -> None:
        """Build the callables of each phase."""
        self._phases = [(p, *self._callables(p)) for p in self.case.phases(self.reverse_slip)]

    def _callables(self, phase: Phase) -> tuple[Any, Any]:
        ops, case = FloatOperators(), self.case

        def fun(_t: float, z: Any, dz: Any, data: dict[str, float]) -> None:
            dz[:] = case.equations(phase, ops, z.tolist(), data["delta_max"])

        def event(_t: float, z: Any, out: Any, data: dict[str, float]) -> None:
            out[0] = case.guard(phase, ops, z.tolist(), data["delta_max"])

        event.terminal = [True]  # type: ignore[attr-defined]
        event.direction = [-1]  # type: ignore[attr-defined]
        return fun, event

    def run(self, tol: float) -> dict[str, float]:
        """Integrate phase after phase."""
        from sksundae.cvode import CVODE

        case, t, z = self.case, 0.0, self.case.scaled_start
        data = {"delta_max": 1.0}
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
            result = solver.solve(np.array([t, case.horizon]), z)
            if result.t_events is None or not len(result.t_events):
                raise RuntimeError(f"CVODE, tol={tol}, {phase}: {result.message}")
            t, z = float(result.t_events[0]), case.settle(phase, np.array(result.y_events[0]))
            if phase.guard == "turn":
                data["delta_max"] = -float(z[case.gap]) * case.scale[case.gap]
        return case.unscale(z, t)


class _HeyokaOperators:
    """Build the equations as heyoka expressions."""

    def __init__(self, number: Callable[[float], Any] = float) -> None:
        import heyoka

        self.sin, self.cos = heyoka.sin, heyoka.cos
        self._number = number

    def power(self, base: Any) -> Any:
        """Return base**N; heyoka's Taylor coefficients of it are nan at a zero base."""
        return base ** self._number(N)

    def inverse_root(self, base: Any) -> Any:
        """Return 1/√base."""
        return base ** self._number(-0.5)


@dataclass
class HeyokaPeer:
    """heyoka's adaptive Taylor method with one terminal event per phase.

    The real power in the force has no Taylor series at zero compression, so the run starts
    1e-8 s after touching, from the closed form of free flight, see `free_start`.
    """

    case: Case = ROD
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
        self._start, self._time = self.case.free_start(self.begin, self.number)

    def _compile(self, tol: float) -> list[tuple[Phase, Any]]:
        import heyoka as hy

        ops, built, case = _HeyokaOperators(self.number), [], self.case
        z = hy.make_vars(*case.states)
        kind = {} if self.number is float else {"fp_type": self.number}
        for phase in self.case.phases(self.reverse_slip):
            rates = case.equations(phase, ops, z, hy.par[0])
            event = hy.t_event(
                case.guard(phase, ops, z, hy.par[0]), direction=hy.event_direction.negative, **kind
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

    @staticmethod
    def advance(integrator: Any, horizon: Any) -> Any:
        """Integrate up to the event that ends the phase; return what ended it."""
        return integrator.propagate_until(horizon)[0]

    def solve(self, tol: float) -> tuple[Any, Any]:
        """Return the scaled state and time at separation in the peer's own number type."""
        if tol not in self._compiled:
            self._compiled[tol] = self._compile(tol)
        case, t, z, delta_max = self.case, self._time, self._start, 1.0
        self.times: list[float] = []
        for phase, integrator in self._compiled[tol]:
            integrator.time = t
            integrator.state[:] = z
            integrator.pars[:] = delta_max
            integrator.reset_cooldowns()
            outcome = self.advance(integrator, self.number(case.horizon))
            if int(outcome) != -1:
                raise RuntimeError(f"heyoka, tol={tol}, {phase}: ended with {outcome}")
            t, z = integrator.time, case.settle(phase, integrator.state)
            self.times.append(float(t) * case.time)
            if phase.guard in ("left", "right"):
                # The root is that of a truncated series: the slip's first acceleration is of the
                # size of the tolerance, of either sign, and must not end the slip.
                least = max(BEGINNING, 10.0 * float(tol) ** 2)
                z[case.slip] = self.number(math.copysign(least, float(z[case.slip])))
            if phase.guard == "turn":
                delta_max = -z[case.gap] * self.number(case.scale[case.gap])
        return z, t

    def run(self, tol: float) -> dict[str, float]:
        """Integrate phase after phase."""
        return self.case.unscale(*self.solve(tol))


class HeyokaGlue(HeyokaPeer):
    """The Python of `HeyokaPeer` between the calls of heyoka, without these calls."""

    @staticmethod
    def advance(integrator: Any, horizon: Any) -> Any:
        """Do nothing."""
        return -1

    def run(self, tol: float) -> dict[str, float]:
        """Go through the phases."""
        super().solve(tol)
        return {}


class _CasadiOperators:
    """Build the equations as CasADi expressions."""

    def __init__(self) -> None:
        import casadi

        self.sin, self.cos = casadi.sin, casadi.cos
        # No derivatives of the floored power are taken, so its kink does no harm.
        self.power = lambda base: casadi.fmax(base, 0.0) ** N
        self.inverse_root = lambda base: 1 / casadi.sqrt(base)


SUNDIALS_METHODS = {"Adams": 0, "BDF": 1, "ERK": 2}
"""In the order of `sundials_loop.c`."""

FLAGS = ("-O3", "-march=native", "-ffp-contract=off", "-fPIC", "-shared")


@dataclass
class SundialsPeer:
    """SUNDIALS called from C: rates, guards and transitions are C that CasADi generates.

    `sundials_loop.c` goes from phase to phase; a run is one call of C from Python. Methods are
    CVODE's Adams with fixed-point iteration, its BDF with Newton's method and dense difference
    Jacobians, and ERKStep of ARKODE with the pair of Fehlberg of orders 8 and 7.
    """

    case: Case = ROD
    reverse_slip: bool = False
    method: str = "Adams"
    loosest: float = 1e-4
    tightest: float = 1e-14
    requires: ClassVar[str] = "casadi"

    @property
    def name(self) -> str:
        """Return the line of the table."""
        return {
            "Adams": "SUNDIALS CVODE Adams, C",
            "BDF": "SUNDIALS CVODE BDF, C",
            "ERK": "SUNDIALS ARKODE ERK 8(7), C",
        }[self.method]

    @staticmethod
    def available() -> bool:
        """Return whether there is a C compiler with the headers of SUNDIALS."""
        if shutil.which("cc") is None:
            return False
        test = "#include <arkode/arkode_erkstep.h>\n#include <cvode/cvode.h>\n"
        command = ["cc", "-fsyntax-only", "-x", "c", "-"]
        return subprocess.run(command, input=test.encode(), capture_output=True).returncode == 0

    def prepare(self) -> None:
        """Generate and compile the phases and the loop."""
        import casadi as ca

        ops, case = _CasadiOperators(), self.case
        steps = case.phases(self.reverse_slip)
        n = len(case.states)
        z, memory = ca.SX.sym("z", n), ca.SX.sym("memory")
        states, delta_max = [z[k] for k in range(n)], memory * case.scale[case.gap]
        functions: dict[str, list[Any]] = {"rates": [], "guard": [], "jump": []}
        for i, phase in enumerate(steps):
            rate = ca.vertcat(*case.equations(phase, ops, states, delta_max))
            guard = case.guard(phase, ops, states, delta_max)
            largest = -z[case.gap] if phase.guard == "turn" else memory
            jump = [ca.vertcat(*case.settle(phase, list(states))), largest]
            for name, values in (("rates", [rate]), ("guard", [guard]), ("jump", jump)):
                functions[name].append(ca.Function(f"{name}_{i}", [z, memory], ca.cse(values)))
        generator = ca.CodeGenerator("phases.c")
        every = [f for row in functions.values() for f in row]
        for function in every:
            generator.add(function)
        work = max(f.sz_w() for f in every)
        tables = [
            f"enum {{ PHASES = {len(steps)}, STATES = {n}, WORK = {work} }};",
            f"static const double LONGEST_STEP = {min(case.longest_step, 1e300)!r};",
            "typedef int (*function)(const double **, double **, casadi_int *, double *, int);",
        ]
        for table, row in zip(("RATES", "GUARDS", "JUMPS"), functions.values(), strict=True):
            names = ", ".join(f.name() for f in row)
            tables.append(f"static const function {table}[PHASES] = {{{names}}};")
        loop = Path(__file__).with_name("sundials_loop.c").read_text("utf-8")
        with tempfile.TemporaryDirectory() as folder:
            source, library = Path(folder, "loop.c"), Path(folder, "loop.so")
            source.write_text("\n".join([generator.dump(), *tables, loop]), "utf-8")
            command = ["cc", *FLAGS, str(source), "-o", str(library), *SUNDIALS_LIBRARIES, "-lm"]
            subprocess.run(command, check=True, capture_output=True)
            # A loaded library outlives its file.
            self._library = ctypes.CDLL(str(library))
        self._library.loop_open.restype = ctypes.c_void_p
        self._library.loop_open.argtypes = [ctypes.c_int, ctypes.c_double]
        array = ctypes.c_void_p
        self._library.loop_run.argtypes = [array, array, ctypes.c_double, array, array]
        self._library.loop_close.argtypes = [ctypes.c_void_p]
        self._start = np.array(case.scaled_start)
        self._end, self._times = np.zeros(n), np.zeros(len(steps))
        self._places = [a.ctypes.data for a in (self._start, self._end, self._times)]
        self._loops: dict[float, int] = {}

    def run(self, tol: float) -> dict[str, float]:
        """Integrate phase after phase, in one call."""
        if tol not in self._loops:
            loop = self._library.loop_open(SUNDIALS_METHODS[self.method], tol)
            if not loop:
                raise RuntimeError(f"{self.name}, tol={tol}: not prepared")
            self._loops[tol] = loop
        start, end, times = self._places
        failed = self._library.loop_run(self._loops[tol], start, self.case.horizon, end, times)
        if failed:
            raise RuntimeError(f"{self.name}, tol={tol}: no event in phase {failed - 1}")
        return self.case.unscale(self._end.tolist(), self._times[-1])

    @property
    def times(self) -> list[float]:
        """Times at which the phases of the last run ended, s."""
        return (self._times * self.case.time).tolist()


SUNDIALS_LIBRARIES = (
    "-lsundials_arkode",
    "-lsundials_cvode",
    "-lsundials_nvecserial",
    "-lsundials_sunlinsoldense",
    "-lsundials_sunmatrixdense",
    "-lsundials_sunnonlinsolfixedpoint",
)


@dataclass
class ErkPeer:
    """CasADi's ``erk`` integrator, which has events but none that ends the integration.

    The phase, delta_max and the time are states of their own. The single guard is that of the
    current phase; its transition enters the next one, and in the last nothing moves any more, so
    the state at the end of the horizon is the state at separation.
    """

    case: Case = ROD
    reverse_slip: bool = False
    #: Whether to generate C and compile it, instead of CasADi's virtual machine.
    compiled: bool = False
    loosest: float = 1e-4
    tightest: float = 1e-15
    requires: ClassVar[str] = "casadi"

    @property
    def name(self) -> str:
        """Return the line of the table."""
        return "CasADi erk, generated C" if self.compiled else "CasADi erk, virtual machine"

    @property
    def scout(self) -> ErkPeer:
        """Return a peer with the same steps that needs no compiler for each tolerance."""
        return ErkPeer(self.case, self.reverse_slip)

    def prepare(self) -> None:
        """Build the equations of all phases and the transitions between them."""
        import casadi as ca

        ops, steps, case = _CasadiOperators(), self.case.phases(self.reverse_slip), self.case
        n = len(case.states)
        z = ca.SX.sym("z", n + 3)
        states, delta_max = [z[k] for k in range(n)], z[n] * case.scale[case.gap]
        rates, guards, jumps = [], [], []
        for index, phase in enumerate(steps):
            rates.append(ca.vertcat(*case.equations(phase, ops, states, delta_max), 0, 0, 1))
            guards.append(case.guard(phase, ops, states, delta_max))
            largest = -z[case.gap] if phase.guard == "turn" else z[n]
            settled = case.settle(phase, list(states))
            jumps.append(ca.vertcat(*settled, largest, index + 1, z[n + 2]))
        rates.append(ca.SX.zeros(n + 3))
        guards.append(ca.SX(1))
        jumps.append(z)
        x = ca.MX.sym("x", n + 3)

        def by_phase(name: str, cases: list[Any]) -> Any:
            functions = [ca.Function(f"{name}{i}", [z], [ca.cse(e)]) for i, e in enumerate(cases)]
            return ca.Function.conditional(name, functions[:-1], functions[-1])(x[n + 1], x)

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
            "max_events": 1000,
        }
        integrator = ca.integrator("impact", "erk", self._dae, 0.0, self.case.horizon, options)
        if not self.compiled:
            return integrator
        with tempfile.TemporaryDirectory() as folder:
            source, library = Path(folder, "impact.c"), Path(folder, "impact.so")
            generator = ca.CodeGenerator(source.name)
            generator.add(integrator)
            generator.generate(f"{folder}/")
            command = ["cc", *FLAGS, str(source), "-o", str(library), "-lm"]
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
            start = np.array([*self.case.scaled_start, 1.0, 0.0, 0.0])
            end = np.zeros(len(start))
            buffer.set_arg(0, memoryview(start))
            buffer.set_res(0, memoryview(end))
            self._ready[tol] = (function, buffer, call, start, end)
        _, buffer, call, _, end = self._ready[tol]
        call()
        if buffer.ret() or round(end[-2]) != len(self.case.phases(self.reverse_slip)):
            raise RuntimeError(f"CasADi erk, tol={tol}: stopped in phase {end[-2]:g}")
        return self.case.unscale(end[:-3], end[-1])


def peers(case: Case = ROD, reverse_slip: bool = False) -> tuple[list[Peer], list[str]]:
    """Return the peers that are installed, and one line for each that is not.

    Parameters
    ----------
    case : Case
    reverse_slip : bool
        Both passed to every peer, see `phases`.
    """
    every = [
        SciPyPeer(case, reverse_slip),
        SundaePeer(case, reverse_slip),
        HeyokaPeer(case, reverse_slip),
        *(SundialsPeer(case, reverse_slip, method) for method in SUNDIALS_METHODS),
        ErkPeer(case, reverse_slip),
        ErkPeer(case, reverse_slip, compiled=True),
    ]
    sundials = SundialsPeer.available()
    available: list[Peer] = []
    skipped: list[str] = []
    for peer in every:
        if importlib.util.find_spec(peer.requires) is None:
            skipped.append(f"skipped: {peer.name} ({peer.requires} is not installed)")
        elif getattr(peer, "compiled", False) and shutil.which("cc") is None:
            skipped.append(f"skipped: {peer.name} (there is no C compiler `cc`)")
        elif isinstance(peer, SundialsPeer) and not sundials:
            skipped.append(f"skipped: {peer.name} (no `cc` with the headers of SUNDIALS)")
        else:
            available.append(peer)
    return available, skipped


PER_DECADE, CONFIRMED = 8, 4
"""Tolerances that `tune` tries, and how many tighter ones must reach the target as well."""


def tune(
    peer: Any, target: float, known: dict[float, float] | None = None
) -> tuple[float, float | None] | None:
    """Return the loosest tolerance with an end-state error of at most `target`, and the one before.

    The error is not a monotone function of the tolerance, so the tolerances of the next half decade
    must reach the target too: a lucky hit does not count.

    Parameters
    ----------
    peer : Peer
        Prepared. Where it has a `scout`, that peer is asked in its place.
    target : float
        Largest `Case.end_error`.
    known : dict of float to float, optional
        Errors by tolerance, read and added to, so that several targets share the runs.

    Returns
    -------
    tuple of float or None
        The tolerance and the next looser one, whose error is above the target; None for the latter
        where the peer failed there, or where it is beyond the peer's range. None alone if no
        tolerance of the range reaches the target.
    """
    known = {} if known is None else known
    scout = getattr(peer, "scout", peer)
    if scout is not peer:
        scout.prepare()
    steps = math.floor(PER_DECADE * math.log10(peer.loosest / peer.tightest) + 1e-9)
    tolerances = [peer.loosest * 10.0 ** (-k / PER_DECADE) for k in range(steps + 1)]
    reached: list[float] = []
    before: float | None = None
    for tol in tolerances:
        if tol not in known:
            # At a loose tolerance a peer may miss an event; CasADi then says so on stderr too.
            try:
                with contextlib.redirect_stderr(io.StringIO()):
                    known[tol] = peer.case.end_error(scout.run(tol), peer.reverse_slip)
            except RuntimeError:
                known[tol] = math.inf
        if known[tol] <= target:
            reached.append(tol)
        else:
            reached, before = [], tol if math.isfinite(known[tol]) else None
        if len(reached) == 1 + CONFIRMED:
            break
    # At the tight end of the range there may be fewer tolerances left to confirm with.
    return (reached[0], before) if reached else None


def at_error(target: float, loose: tuple[float, float] | None, tight: tuple[float, float]) -> float:
    """Return the time that a peer takes for an error.

    Orders come in whole numbers and steps in whole steps, so the error jumps from one tolerance to
    the next, by ten with some peers. Between the two that enclose the target the time is
    interpolated, both in logarithms.

    Parameters
    ----------
    target : float
    loose, tight : tuple of float
        Error, above the target and at most the target, and time; None where nothing is above.
    """
    if loose is None:
        return tight[1]
    # An error of 0 is round-off as well.
    (above, quick), (below, slow) = loose, (max(tight[0], 1e-16), tight[1])
    part = math.log(above / target) / math.log(above / below)
    return float(quick * (slow / quick) ** part)


def time_all(tuned: Sequence[tuple[Any, float]], repeats: int) -> list[float]:
    """Return the least processor time of one run of each peer, s.

    Processor time, in turns and its minimum: on a machine that does other work as well, all peers
    then meet the same conditions, and the least disturbed run of each counts.

    Parameters
    ----------
    tuned : sequence of (Peer, float)
        Prepared peers and their tolerances; a first run, which may compile, is not counted.
    repeats : int
        Rounds; a quick peer runs up to a hundred times in each, with warm caches.
    """
    bunches = []
    for peer, tol in tuned:
        peer.run(tol)
        start = time.process_time_ns()
        peer.run(tol)
        took = max(time.process_time_ns() - start, 1)
        bunches.append(int(min(max(10_000_000 // took, 1), 100)))
    best = [math.inf] * len(tuned)
    for _ in range(repeats):
        for i, ((peer, tol), bunch) in enumerate(zip(tuned, bunches, strict=True)):
            for _ in range(bunch):
                start = time.process_time_ns()
                peer.run(tol)
                best[i] = min(best[i], time.process_time_ns() - start)
    return [b * 1e-9 for b in best]
