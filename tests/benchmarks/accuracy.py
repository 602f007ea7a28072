"""Orders of accuracy: of event times, at grazing, from δ = 0, of every scheme and of jump rules.

No time is measured here; the numbers depend on the machine by round-off only.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.engines.protocol import RawRun, RunOptions
from painleve_sym.errors import StopReason
from painleve_sym.laws.catalogue import law
from painleve_sym.mechanics.toml.mechanism_file import load_mechanism
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.time_stepping.stepping import TimeStepper
from painleve_sym.papers.impact_resolution.beyond import compute_corrected
from painleve_sym.papers.impact_resolution.runs import Workbench
from tests.benchmarks.cases import MOTIONS, Case, K, N
from tests.benchmarks.package_peer import NAMES, STIFF, PackagePeer
from tests.benchmarks.peers import HeyokaPeer, SciPyPeer, SundialsPeer
from tests.support.paper_law import paper_law

ENGINES = tuple(NAMES)
TOLERANCES = tuple(10.0**-k for k in (3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14))
EVENTS = ("slip stops", "largest compression", "reverse slip", "separation")
TABLE_1 = {"theta": 0.5, "theta_dot": 1.0, "x_A_dot": -1.0}
TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
APPROACH = {**TABLE_3, "y_A_dot": -0.1}
ROUND_OFF = 1e-14
"""Relative errors below it say nothing about an exponent."""
HIDDEN = 1e-13
"""Errors below it say nothing about the order between two steps."""


def slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Return the exponent p of the power y = c xᵖ that fits best, nan with fewer than three."""
    kept = [(a, b) for a, b in zip(x, y, strict=True) if b > ROUND_OFF]
    if len(kept) < 3:
        return math.nan
    logs = np.log(np.array(kept)).T
    return float(np.polyfit(logs[0], logs[1], 1)[0])


def orders(steps: Sequence[float], errors: Sequence[float]) -> list[float | None]:
    """Return the orders between neighbouring steps; None where round-off hides them."""
    between: list[float | None] = [None]
    for (h, e), (k, f) in itertools.pairwise(zip(steps, errors, strict=True)):
        hidden = min(e, f) <= HIDDEN
        between.append(None if hidden else math.log(e / f) / math.log(h / k))
    return between


# ---- events ----


def reference_times(case: Case) -> list[float]:
    """Return the times of the events by heyoka's Taylor method in 80-bit arithmetic, s."""
    peer = HeyokaPeer(case, True, number=np.longdouble, begin=1e-9)
    peer.prepare()
    peer.run(1e-19)
    return peer.times


def event_times(case: Case) -> dict[str, Any]:
    """Return the relative error of every event's time over the tolerance, and its exponent.

    Returns
    -------
    dict
        ``reference``: times, s; ``engines``: name → {``errors``: one list per tolerance,
        ``slopes``: one per event, ``largest``: one error per tolerance, ``slope``: of these}.
    """
    reference = reference_times(case)
    timed = reference[:-1] if case.name not in (c.name for c in MOTIONS[:2]) else reference
    engines: dict[str, Any] = {}
    runs: list[tuple[str, Callable[[float], Sequence[float]]]] = []
    for engine in ENGINES:
        own = PackagePeer(case, engine)
        own.prepare()
        runs.append((own.name, own.event_times))
    peers = [HeyokaPeer(case, True), SciPyPeer(case, True)]
    if SundialsPeer.available():
        peers += [SundialsPeer(case, True, method) for method in ("Adams", "ERK")]
    for peer in peers:
        peer.prepare()

        def times(tol: float, peer: Any = peer) -> Sequence[float]:
            peer.run(tol)
            return list(peer.times)

        runs.append((peer.name, times))
    for name, run in runs:
        errors: list[list[float] | None] = []
        for tol in TOLERANCES:
            if "SciPy" in name and tol < SciPyPeer.tightest:
                errors.append(None)
                continue
            try:
                row = run(tol)[: len(timed)]
            except RuntimeError:
                errors.append(None)
                continue
            same = len(row) == len(timed)
            errors.append(
                [abs(a - b) / b for a, b in zip(row, timed, strict=True)] if same else None
            )
        at = [tol for tol, e in zip(TOLERANCES, errors, strict=True) if e is not None]
        kept = [e for e in errors if e is not None]
        largest = [None if e is None else max(e) for e in errors]
        engines[name] = {
            "errors": errors,
            "slopes": [slope(at, column) for column in zip(*kept, strict=True)],
            "largest": largest,
            "slope": slope(at, [max(e) for e in kept]),
        }
    return {"reference": timed, "tolerances": list(TOLERANCES), "engines": engines}


# ---- grazing ----

GRAZING_SPEEDS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 3e-8)
MISSES = (1e-4, 1e-8, 1e-12, 1e-14)
"""Distances at which the mass passes the ground, m."""


def grazing(rtol: float = 1e-11) -> dict[str, Any]:
    """Return the error of the touchdown's time as its speed goes to 0, and near misses."""
    mechanism = load_mechanism(Path(__file__).with_name("grazing.toml"))
    result: dict[str, Any] = {"rtol": rtol, "rows": [], "misses": []}
    simulators = {e: Simulator(mechanism, law("rigid"), e) for e in ENGINES}

    def touchdown(engine: str, c: float) -> float | None:
        run = simulators[engine].run(
            {"y": 1.0 + c}, t_end=4.0, parameters={"c": c}, rtol=rtol, until="touchdown"
        )
        return float(run.final_time) if run.stop_reason is StopReason.UNTIL else None

    for speed in GRAZING_SPEEDS:
        c = math.sqrt((1.0 - speed) * (1.0 + speed))
        # Of the rounded c, and of the rounded start 1 + c: 1 - c is exact.
        amplitude = (1.0 + c) - c
        exact = math.pi - 2.0 * math.asin(math.sqrt((amplitude - c) / (2.0 * amplitude)))
        row: dict[str, Any] = {"speed": math.sqrt((amplitude - c) * (amplitude + c))}
        for engine in ENGINES:
            time = touchdown(engine, c)
            row[engine] = None if time is None else abs(time - exact)
        result["rows"].append(row)
    for distance in MISSES:
        c = 1.0 + distance
        result["misses"].append(
            {"distance": distance} | {e: touchdown(e, c) is not None for e in ENGINES}
        )
    return result


HERTZ_SPEEDS = (1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10)


def soft_touch(rtol: float = 1e-11) -> dict[str, Any]:
    """Return the error of the time to the largest compression of an elastic Hertz impact.

    A mass meets the ground with v and nothing else acts: δ_max = ((n + 1) m v²/(2 K))^(1/(n+1)) is
    reached after (δ_max/v) √π Γ(1 + 1/(n+1))/Γ(1/2 + 1/(n+1)).
    """
    mechanism = load_mechanism(Path(__file__).with_name("grazing.toml"))
    result: dict[str, Any] = {"rtol": rtol, "rows": []}
    simulators = {e: Simulator(mechanism, law("hertz"), e) for e in ENGINES}
    for speed in HERTZ_SPEEDS:
        row: dict[str, Any] = {"speed": speed}
        for engine, simulator in simulators.items():
            parameters = {"k_s": 0.0, "n": N} | STIFF
            m = 1.0 / (N + 1.0)
            depth = (speed**2 / (2.0 * m * K)) ** m
            exact = depth / speed * math.sqrt(math.pi) * math.gamma(1 + m) / math.gamma(0.5 + m)
            run = simulator.run(
                {"y_dot": -speed},
                t_end=4.0 * exact,
                parameters=parameters,
                rtol=rtol,
                until="separation",
            )
            turn = next(e for e in run.events if e.kind == "max_compression")
            row[engine] = {
                "time": abs(turn.time / exact - 1.0),
                "depth": abs(-turn.state["y"] / depth - 1.0),
                "rebound": abs(run.final["y_dot"] / speed - 1.0),
            }
        result["rows"].append(row)
    return result


# ---- steps of one length, and the start at δ = 0 ----


@dataclass(frozen=True)
class SlipStart:
    """Start of a slip under growing compression begins, at E = 20.9e14 Pa.

    Attributes
    ----------
    state : dict of str to float
    force : float or None
        That of the compression at the start, N.
    span : float
        A time before the slip stops, s.
    """

    state: dict[str, float]
    force: float | None
    span: float


STARTS: Mapping[str, SlipStart] = {
    "compressed by 100 N": SlipStart(TABLE_3, 100.0, 2.8e-4),
    "at rest on the ground": SlipStart(TABLE_3, None, 3.6e-4),
    "approach at 0.1 m/s": SlipStart(APPROACH, None, 2.8e-5),
}
STEPS = (2, 4, 8, 16, 32, 64, 128)
TAYLOR_STEPS = (4, 8, 16, 32, 64, 128)
TAYLOR_ORDERS = (5, 7, 9, 11)
SHARE = 0.05
"""Of the tolerance, for one step of the Taylor engine: `PS_SHARE`."""


def _slip(engine: str, start: str) -> tuple[Simulator, Callable[[RunOptions], RawRun], Any]:
    state, force = STARTS[start].state, STARTS[start].force
    simulator = Simulator(model("rod"), paper_law(reload="virgin"), engine)
    full = {n: state.get(n, 0.0) for n in simulator.mechanism.state_names}
    begin = simulator.start(simulator.at(full, STIFF), force)

    def run(options: RunOptions) -> RawRun:
        return simulator.integrator.run(begin.state, begin.parameters, options)

    return simulator, run, begin


def _rebound(simulator: Simulator, raw: RawRun) -> float:
    assert raw.counters["events"] == 0, raw.counters
    index = simulator.outline.state_names.index("y_A_dot")
    return float(raw.state[index])


def exact_slip(start: str) -> float:
    """Return the normal velocity at the end of a start's span, by the Taylor engine at 1e-15."""
    simulator, run, begin = _slip("taylor", start)
    atol = 1e-15 * begin.scale
    return _rebound(simulator, run(RunOptions(STARTS[start].span, 1e-15, atol, record="end")))


def fixed_steps() -> dict[str, Any]:
    """Return errors and orders of Runge–Kutta steps of one length from the three starts."""
    result: dict[str, Any] = {"steps": list(STEPS), "starts": {}}
    for start in STARTS:
        simulator, run, begin = _slip("compiled", start)
        exact, span, errors = exact_slip(start), STARTS[start].span, []
        for count in STEPS:
            h = span / count
            loose = np.full(len(begin.scale), 1e90)
            o = RunOptions(span, 1e-3, loose, record="end", first_step=h, max_step=h)
            errors.append(abs(_rebound(simulator, run(o)) / exact - 1.0))
        lengths = [span / count for count in STEPS]
        result["starts"][start] = {"errors": errors, "orders": orders(lengths, errors)}
    return result


def taylor_orders() -> dict[str, Any]:
    """Return errors and orders of Taylor steps of one length, from the compressed start."""
    start = next(iter(STARTS))
    simulator, run, begin = _slip("taylor", start)
    exact, span = exact_slip(start), STARTS[start].span
    result: dict[str, Any] = {"steps": list(TAYLOR_STEPS), "orders": {}}
    for order in TAYLOR_ORDERS:
        rtol, errors = math.exp(-2.0 * (order - 1.5)) / SHARE, []
        for count in TAYLOR_STEPS:
            h = span / count
            loose = np.full(len(begin.scale), 1e90)
            o = RunOptions(span, rtol, loose, record="end", first_step=h, max_step=h)
            errors.append(abs(_rebound(simulator, run(o)) / exact - 1.0))
        lengths = [span / count for count in TAYLOR_STEPS]
        result["orders"][str(order)] = {"errors": errors, "orders": orders(lengths, errors)}
    return result


def adaptive_starts() -> dict[str, Any]:
    """Return errors and steps over the tolerance from the three starts, for every engine."""
    result: dict[str, Any] = {"tolerances": list(TOLERANCES), "starts": {}}
    for start in STARTS:
        exact, span = exact_slip(start), STARTS[start].span
        result["starts"][start] = {}
        for engine in ENGINES:
            simulator, run, begin = _slip(engine, start)
            errors, steps = [], []
            for tol in TOLERANCES:
                raw = run(RunOptions(span, tol, tol * begin.scale, record="end"))
                errors.append(abs(_rebound(simulator, raw) / exact - 1.0))
                steps.append(raw.counters["accepted_steps"])
            line = {"errors": errors, "steps": steps, "slope": slope(TOLERANCES, errors)}
            result["starts"][start][NAMES[engine]] = line
    return result


# ---- time stepping, and the jump rules ----

LENGTHS = (1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5)
STEPPED: Mapping[str, tuple[dict[str, float], float]] = {
    "one solution, slip (Table 1)": (TABLE_1, 1e-2),
    "no solution (Table 3)": (TABLE_3, 1e-2),
    "touchdown after flight": ({**TABLE_1, "y_A": 3.3e-4, "y_A_dot": -0.1}, 1e-2),
}
COMPARED = ("x_A_dot", "y_A_dot", "theta_dot")


def time_stepping() -> dict[str, Any]:
    """Return the error of the velocities at 0.01 s, and its order in h, of both schemes.

    The reference is the rigid motion with Newton's restitution: e = 0.5 for Moreau–Jean, 0 for
    Stewart–Trinkle, whose impacts are plastic.
    """
    result: dict[str, Any] = {"steps": list(LENGTHS), "schemes": {}}
    mechanism = model("rod")
    for scheme, e in (("moreau-jean", 0.5), ("stewart-trinkle", 0.0)):
        rigid = Simulator(mechanism, law("rigid", restitution="newton"))
        stepper = TimeStepper(mechanism, scheme)
        result["schemes"][scheme] = {}
        for name, (state, t_end) in STEPPED.items():
            exact = rigid.run(state, t_end=t_end, parameters={"e_newton": e})
            errors = []
            for h in LENGTHS:
                run = stepper.run(state, step=h, t_end=t_end, e=e)
                errors.append(max(abs(run.final[n] - exact.final[n]) for n in COMPARED))
            line = {"errors": errors, "orders": orders(LENGTHS, errors)}
            result["schemes"][scheme][name] = line
    return result


def jump_rules() -> dict[str, Any]:
    """Return the errors of the three jump rules over the modulus, and their local orders in K."""
    table = compute_corrected(Workbench()).data["table"]
    rows = [row[1:] for row in table["rows"] if row[0] == "y_A_dot"]
    names = ("E", "compliant", "classical", "frozen", "carried")
    kept = [dict(zip(names, row, strict=False)) for row in rows]
    for row, full in zip(kept, rows, strict=True):
        row |= dict(
            zip(("order_classical", "order_frozen", "order_carried"), full[5:], strict=True)
        )
    return {"rows": kept, "limit": -1.0 / (2.0 * 1.764), "carried_limit": -1.0 / (1.764 + 1.0)}


def measure() -> dict[str, Any]:
    """Return all tables."""
    return {
        "event_times": {case.name: event_times(case) for case in MOTIONS},
        "grazing": grazing(),
        "soft_touch": soft_touch(),
        "fixed_steps": fixed_steps(),
        "taylor_orders": taylor_orders(),
        "adaptive_starts": adaptive_starts(),
        "time_stepping": time_stepping(),
        "jump_rules": jump_rules(),
    }
