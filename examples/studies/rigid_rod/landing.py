"""When does a bar jam that slides? Motion of its modes at a frozen angle, for many bars at once.

A bar touches the ground, unloaded, and slides. The least friction from which its slip stops before
it first separates is its *landing*: an impact without collision. Modes of free ends with closed
wavenumbers, a contact F = K δⁿ, Runge–Kutta's method in slide.c, for which a C compiler is needed;
nothing of the motion is shared with the package.

Run: python examples/studies/rigid_rod/landing.py [--quick] [--draw] [--out FOLDER]
Writes landing.json (all numbers), landing.png, landing.svg, landing-maps.png and landing-maps.svg.
"""

from __future__ import annotations

import argparse
import ctypes
import importlib.util
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, ScalarFormatter
from scipy.linalg import eigh
from scipy.special import beta

import painleve_sym as ps
from painleve_sym.mechanics.materials import materials
from painleve_sym.present.style import COLUMN, DASHES, PAGE, PALETTE, REFERENCE, STYLE, save

G = 9.8
FINEST = 0.5
"""Largest ω h of a step, with ω the fastest mode."""
PERIODS = 8
"""Number of contact times within which a slip stops, or a contact separates, or neither."""


def theory() -> Any:
    """Return the study `rigid_rod`, which has bars and their receptances."""
    if "rigid_rod" not in sys.modules:
        path = Path(__file__).with_name("rigid_rod.py")
        spec = importlib.util.spec_from_file_location("rigid_rod", path)
        assert spec and spec.loader
        module = importlib.util.module_from_spec(spec)
        sys.modules[spec.name] = module
        spec.loader.exec_module(module)
    return sys.modules["rigid_rod"]


@cache
def kernel() -> Any:
    """Return `slide` of slide.c, compiled."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "slide.so"
        source = Path(__file__).with_name("slide.c")
        options = ["-O3", "-march=native", "-shared", "-fPIC"]
        subprocess.run(["cc", *options, str(source), "-o", str(library), "-lm"], check=True)
        function = ctypes.CDLL(str(library)).slide
    row, number = np.ctypeslib.ndpointer(np.float64, flags="C"), ctypes.c_double
    function.argtypes = [ctypes.c_int, *[row] * 4, number, row, *[number] * 5, ctypes.c_int, row]
    return function


@dataclass(frozen=True)
class Contact:
    """A contact F = K δⁿ whose unloading gives back e² of the work, by default all of it."""

    K: float
    n: float = 1.5
    e: float = 1.0


class Modes:
    """Rigid motion and natural modes of a bar with free ends: frequencies and motion of the end.

    Across the bar the first is rigid, of end value 2, since turning takes part; along it 1. A ball
    of a radius at the end touches the ground one radius below the axis, so that the turning of the
    end moves the point of contact, too; the rigid motion across is then two, drift and turning. It
    is without mass: `loaded` gives the end a mass.
    """

    def __init__(self, bar: Any, bending: int, axial: int, radius: float = 0.0) -> None:
        waves = theory().wavenumbers(bending)
        rates = bar.frequencies(bending, axial)
        rigid, turning = ([1.0, math.sqrt(3)], [0.0, -math.sqrt(3)]) if radius else ([2.0], [0.0])
        slopes = -waves * (np.cosh(waves) - np.cos(waves)) / (np.sinh(waves) - np.sin(waves))
        self.mass = bar.mass
        self.rates = np.concatenate([np.zeros(len(rigid)), rates[0], [0.0], rates[1]])
        self.across = np.concatenate([rigid, [2.0] * bending, np.zeros(1 + axial)])
        self.along = np.concatenate([0 * self.across[: len(rigid) + bending], [1.0],
                                     [math.sqrt(2)] * axial])  # fmt: skip
        self.swing = (
            radius * 2 / bar.length * np.concatenate([turning, slopes, np.zeros(1 + axial)])
        )
        """How the end moves across and along the bar, and its contact as the end turns, by mode."""

    def loaded(self, mass: float) -> Modes:
        """Return the modes of the bar with a point mass at its end."""
        inertia = self.mass * np.eye(len(self.rates))
        inertia += mass * sum(np.outer(x, x) for x in (self.across, self.along))
        squares, shapes = eigh(self.mass * np.diag(self.rates**2), inertia)
        modes = copy(self)
        modes.rates = np.sqrt(np.where(squares > 1e-9 * squares.max(), squares, 0.0))
        for name in ("across", "along", "swing"):
            setattr(modes, name, math.sqrt(self.mass) * getattr(self, name) @ shapes)
        return modes

    def rows(self, theta: Any, mu: Any) -> tuple[Any, Any, Any]:
        """Return, by case, how the point of contact moves up and to the right, and how force acts.

        Its slip is to the left, so that friction acts to the right.
        """
        sin, cos, mu = (np.atleast_1d(x)[:, None] for x in (np.sin(theta), np.cos(theta), mu))
        normal = cos * self.across + sin * self.along
        along = cos * self.along - sin * self.across + self.swing
        return normal, along, normal + mu * along


def contact_time(modes: Modes, contact: Contact) -> float:
    """Return the period of the rigid bar across its axis on the contact that its weight presses, s.

    2π √(m/(4k)) with k the slope of K δⁿ at the force m g.
    """
    weight = modes.mass * G
    k = contact.n * contact.K * (weight / contact.K) ** (1 - 1 / contact.n)
    return 2 * math.pi * math.sqrt(modes.mass / (4 * k))


def slide(
    modes: Modes,
    contact: Contact,
    theta: Any,
    mu: Any,
    speed: Any,
    *,
    approach: float = 0.0,
    damping: float = 0.0,
    window: float | None = None,
    bounces: bool = False,
    fineness: float = FINEST,
) -> dict[str, Any]:
    """Return when the slip stops, when the end first separates, and the largest force, by case.

    Parameters
    ----------
    theta, mu, speed : array_like
        Angle in rad, friction, slip velocity to the left in m/s; they broadcast.
    approach : float
        Velocity into the ground at the touch, m/s.
    window : float, optional
        s; `PERIODS` contact times when left out.
    bounces : bool
        Whether a motion continues after the first separation.

    Returns
    -------
    dict of str to ndarray
        ``stop`` and ``separation`` (s, nan where there is none) and ``peak`` (N).
    """
    theta, mu, speed = (np.array(x, float).ravel() for x in np.broadcast_arrays(theta, mu, speed))
    window = PERIODS * contact_time(modes, contact) if window is None else window
    rows = [np.ascontiguousarray(row) for row in modes.rows(theta, mu)]
    fastest = modes.rates.max()
    step = min(fineness / fastest, window / 2000) if fastest > 0 else window / 4000
    law, ends = np.array([contact.K, contact.n, contact.e]), np.empty((len(theta), 3))
    for i, (normal, along, push) in enumerate(zip(*rows, strict=True)):
        fault = kernel()(
            len(modes.rates), modes.rates, normal, along, push / modes.mass, damping, law, G,
            approach, speed[i], step, window, bounces, ends[i],
        )  # fmt: skip
        assert not fault
    return dict(zip(("stop", "separation", "peak"), ends.T, strict=True))


def landing(
    modes: Modes, contact: Contact, theta: Any, speed: Any, steps: int = 18, **options: Any
) -> Any:
    """Return, by case, the least friction from which the slip stops in the first contact.

    By bisection between 0.02 and 4, to 4/2^steps: 1.5e-5.
    """
    theta, speed = (np.array(x, float) for x in np.broadcast_arrays(theta, speed))
    low, high = np.full(theta.shape, 0.02), np.full(theta.shape, 4.0)
    for _ in range(steps):
        middle = (low + high) / 2
        times = slide(modes, contact, theta, middle, speed, **options)["stop"]
        stops = ~np.isnan(times).reshape(theta.shape)
        low, high = np.where(stops, low, middle), np.where(stops, middle, high)
    return high


def slip_of_a_bounce(modes: Modes, contact: Contact, theta: Any, mu: Any) -> Any:
    """Return by how much friction slows a rigid rod from its touch until the force is zero again.

    Its compression obeys δ̈ = g - A F from rest, so that the force is zero again at the depth 0
    after √(2δ/g) B(1/(2n), 1/2)/n, with δ the largest depth, and takes g of its time as impulse;
    infinite where A ≤ 0. The end touches the ground then without leaving it: an elastic contact of
    a rigid rod begins again, and a motion has no separation.
    """
    normal, along, push = modes.rows(theta, mu)
    A, slowing = ((x * push).sum(axis=1) / modes.mass for x in (normal, along))
    held = np.where(A > 0, A, 1.0)
    deepest = ((contact.n + 1) * G / (held * contact.K)) ** (1 / contact.n)
    time = np.sqrt(2 * deepest / G) * beta(1 / (2 * contact.n), 0.5) / contact.n
    return np.where(A > 0, slowing / held * G * time, np.inf)


def rigid_landing(modes: Modes, contact: Contact, theta: Any, speed: Any, steps: int = 30) -> Any:
    """Return, by case, the least friction from which a rigid rod's slip stops in its first contact.

    By bisection, as `landing`.
    """
    theta, speed = (np.array(x, float).ravel() for x in np.broadcast_arrays(theta, speed))
    low, high = np.full(theta.shape, 0.02), np.full(theta.shape, 8.0)
    for _ in range(steps):
        middle = (low + high) / 2
        stops = slip_of_a_bounce(modes, contact, theta, middle) >= speed
        low, high = np.where(stops, low, middle), np.where(stops, middle, high)
    return high


# ---- the study ----

GRID = 4 / 2**14
"""What bisection leaves of a landing in a map."""
MANY = (24, 12)
"""Numbers of modes of maps; the table of convergence has their error."""
MAX_COUNTS = (80, 40)
ANGLES = (0.8, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5)
SPEEDS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
SLENDER = (20, 30, 50, 100, 200, 500)
SHORT = (10, 20, 50, 100, 222)
BALL = (0.006, 7800.0)
"""Radius and density of a ball of steel at the tip of the bench rod; m, kg/m³."""
MAP_ANGLES = tuple(np.round(np.arange(0.7, 1.53, 0.1), 2).tolist())
PAPER_EXPONENT = 1.764  # of the paper's law, that of no material
FRICTION = (0.7, 0.9, 1.1, 1.4)
BENCH_RADIUS = 0.003
"""Of the bench rod and its tip, m."""
HARDNESS = 2.8
"""Pressure of full plasticity over the yield strength, Tabor; Johnson (1985), section 6.3."""


def hertz(bar: Any, radius: float = 0.00645, **others: float) -> Contact:
    """Return the elastic contact of a bar's round end with a plane of the same material."""
    return Contact(theory().contact(1.0, bar.modulus, radius, bar.poisson, n=1.5, **others)[0])


def plastic(bar: Any, radius: float, strength: float, e: float) -> Contact:
    """Return the fully plastic contact F = 2π R H δ of a round end, H = 2.8 yield strengths."""
    return Contact(2 * math.pi * radius * HARDNESS * strength, 1.0, e)


def first_yield(bar: Any, radius: float, strength: float) -> float:
    """Return the force from which a Hertz contact yields, N; Johnson (1985), section 6.1."""
    effective = bar.modulus / (2 * (1 - bar.poisson**2))
    return math.pi**3 * radius**2 * (1.6 * strength) ** 3 / (6 * effective**2)


def divergence(bar: Any, counts: tuple[int, int] | None, theta: Any, k: float = math.inf) -> Any:
    """Return the least friction with a real root, by angle; all modes where none are counted."""
    t = theory()
    form = t.euler_bernoulli(bar) if counts is None else t.modal(bar, *counts)
    return np.array([t.threshold(form, x, k)[0] for x in np.ravel(theta)])


def over_angles(angles: Sequence[float], counts: Sequence[tuple[int, int]]) -> list[dict[str, Any]]:
    """Return the thresholds of the paper's rod of steel by angle."""
    t, bar = theory(), theory().Bar()
    contact, k, theta = hertz(bar), theory().contact(G)[1], np.array(angles)
    columns: dict[str, Any] = {
        "theta": theta,
        "cot": 1 / np.tan(theta),
        "coupling": [t.flutter_threshold(bar, MANY, x, k, 0.01) for x in theta],
    }
    for count in counts:
        columns[f"landing {count[0]},{count[1]}"] = landing(Modes(bar, *count), contact, theta, 1.0)
    columns |= {
        "landing at 100 m/s": landing(Modes(bar, *MANY), contact, theta, 100.0),
        "divergence 24,12": divergence(bar, MANY, theta),
        "divergence": divergence(bar, None, theta),
        "divergence at 9.8 N": divergence(bar, None, theta, k),
        "landing of the rigid rod": rigid_landing(Modes(bar, 0, 0), contact, theta, 1.0),
        "rigid rod, 6 ms": landing(Modes(bar, 0, 0), contact, theta, 1.0, window=6e-3),
        "rigid rod": [t.threshold(t.rigid(bar), x)[0] for x in theta],
    }
    return [dict(zip(columns, map(float, row), strict=True)) for row in zip(*columns.values())]  # noqa: B905


def over_speeds(angles: Sequence[float], speeds: Sequence[float]) -> list[dict[str, Any]]:
    """Return the landing by speed and angle, of the bar and of the rigid rod."""
    bar = theory().Bar()
    theta, speed = (x.ravel() for x in np.meshgrid(angles, speeds, indexing="ij"))
    columns = {
        "theta": theta,
        "speed": speed,
        "landing": landing(Modes(bar, *MANY), hertz(bar), theta, speed),
        "divergence": divergence(bar, MANY, theta),
        "rigid": rigid_landing(Modes(bar, 0, 0), hertz(bar), theta, speed),
    }
    return [dict(zip(columns, map(float, row), strict=True)) for row in zip(*columns.values())]  # noqa: B905


def variants() -> list[dict[str, Any]]:
    """Return the landing at θ = 1 and 1 m/s with one thing changed."""
    bar = theory().Bar()
    modes, contact = Modes(bar, *MANY), hertz(bar)
    cases: dict[str, dict[str, Any]] = {
        "as it stands": {},
        "approach of 0.1 m/s": {"approach": 0.1},
        "modal damping ζ = 0.02": {"damping": 0.02},
        "steps half as long": {"fineness": FINEST / 2},
    }
    rows = [{"case": n, "landing": float(landing(modes, contact, 1.0, 1.0, **o))}
            for n, o in cases.items()]  # fmt: skip
    # What follows a bounce does not rise with friction: the least of a grid.
    grid = np.arange(0.640, 0.710, 0.001)
    for window in (0.03, 0.1):
        stop = slide(modes, contact, 1.0, grid, 1.0, window=window, bounces=True)["stop"]
        rows.append({"case": f"after bounces too, within {1e3 * window:.0f} ms",
                     "landing": float(grid[np.isfinite(stop)].min())})  # fmt: skip
    for e in (0.1, 0.4, 0.7):
        law = plastic(bar, 0.00645, ps.material("steel").yield_strength, e)
        rows.append({"case": f"fully plastic contact, e = {e}",
                     "landing": float(landing(modes, law, 1.0, 1.0))})  # fmt: skip
    return rows


def fast(speeds: Sequence[float]) -> list[dict[str, Any]]:
    """Return the landing of slip without end, by speed: modes, angles and what multiplies K."""
    bar, rows = theory().Bar(), []
    cases = [(1.0, counts, 1.0) for counts in ((8, 4), MANY, (48, 24), MAX_COUNTS)]
    cases += [(1.0, MANY, 0.01), (1.0, MANY, 100.0), (1.4, MANY, 1.0), (1.4, (48, 24), 1.0)]
    for theta, counts, factor in cases:
        contact = Contact(factor * hertz(bar).K)
        least = landing(Modes(bar, *counts), contact, theta, np.array(speeds), window=0.02,
                        fineness=0.1)  # fmt: skip
        rows.append({"theta": theta, "modes": f"{counts[0]},{counts[1]}", "factor": factor,
                     "landing": least.tolist(), "speed": list(speeds),
                     "divergence": float(divergence(bar, counts, theta)[0])})  # fmt: skip
    return rows


def convergence(counts: Sequence[tuple[int, int]]) -> list[dict[str, Any]]:
    """Return landing, and slip stops of the contact that yields, by number of modes."""
    bar = theory().Bar()
    law = Contact(hertz(bar).K, 1.5, 0.75)
    rows = []
    for count in counts:
        modes = Modes(bar, *count)
        ends = slide(modes, law, 1.0, FRICTION, 1.0, window=0.03, bounces=True)
        row: dict[str, Any] = {"modes": f"{count[0]},{count[1]}"}
        for theta in (1.0, 1.4):
            row[f"landing {theta}"] = float(landing(modes, hertz(bar), theta, 1.0))
        for mu, stop, peak in zip(FRICTION, ends["stop"], ends["peak"], strict=True):
            row[f"stop {mu}"] = None if math.isnan(stop) else float(stop)
            row[f"peak {mu}"] = float(peak)
        rows.append(row)
    return rows


def approaching(counts: Sequence[tuple[int, int]]) -> list[dict[str, Any]]:
    """Return slip stops, and peak forces up to them, of a bar that approaches its yielding contact.

    By approach velocity and friction, for each number of modes, at θ = 1 and 1 m/s.
    """
    law = Contact(hertz(theory().Bar()).K, 1.5, 0.75)
    rows = []
    for approach in (0.01, 0.1, 1.0):
        for mu in (0.7, 1.4):
            row: dict[str, Any] = {"approach": approach, "mu": mu}
            for count in counts:
                ends = slide(Modes(theory().Bar(), *count), law, 1.0, mu, 1.0, approach=approach,
                             window=0.03, bounces=True)  # fmt: skip
                name, stop = f"{count[0]},{count[1]}", float(ends["stop"][0])
                row[f"stop {name}"] = None if math.isnan(stop) else stop
                row[f"peak {name}"] = float(ends["peak"][0])
            rows.append(row)
    return rows


def with_the_papers_law(angles: Sequence[float]) -> list[dict[str, float]]:
    """Return the landing at 1 m/s by the law of the paper, within 30 ms."""
    bar = theory().Bar()
    K = theory().contact(1.0, n=PAPER_EXPONENT)[0]
    law, theta = Contact(K, PAPER_EXPONENT, 0.75), np.array(angles)
    least = landing(Modes(bar, *MANY), law, theta, 1.0, window=0.03)
    return [{"theta": float(x), "landing": float(y)} for x, y in zip(theta, least, strict=True)]


def round_ends(angles: Sequence[float]) -> list[dict[str, float]]:
    """Return the landing of the paper's rod at 1 m/s with an end of radius 0 and with its ball."""
    bar, theta, radius = theory().Bar(), np.array(angles), 0.00645
    columns: dict[str, Any] = {"theta": theta}
    for counts in (MANY, (48, 24)):
        name = f"{counts[0]},{counts[1]}"
        columns |= {
            f"point {name}": landing(Modes(bar, *counts), hertz(bar), theta, 1.0),
            f"ball {name}": landing(Modes(bar, *counts, radius), hertz(bar), theta, 1.0),
        }
    columns["ball, rigid rod"] = rigid_landing(Modes(bar, 0, 0, radius), hertz(bar), theta, 1.0)
    return [dict(zip(columns, map(float, row), strict=True)) for row in zip(*columns.values())]  # noqa: B905


def by_slenderness(slender: Sequence[float]) -> list[dict[str, float]]:
    """Return the least landing over the angles at 1 m/s, of round steel bars of 1 kg.

    With the divergence on a rigid contact at its angle and the landing of the rigid rod there, and
    by which part the landing exceeds the divergence at three angles.
    """
    rows = []
    for ratio in slender:
        bar = theory().round_bar(ratio)
        contact, theta = hertz(bar, bar.radius), np.arange(1.0, 1.5, 0.02)
        least = landing(Modes(bar, *MANY), contact, theta, 1.0)
        at = theta[np.argmin(least)]
        (rigid,) = rigid_landing(Modes(bar, 0, 0), contact, at, 1.0)
        three = np.array([1.0, 1.2, 1.4])
        excess = landing(Modes(bar, *MANY), contact, three, 1.0) / divergence(bar, MANY, three) - 1
        rows.append({
            "slenderness": float(ratio), "theta": float(at), "landing": float(least.min()),
            "divergence": float(divergence(bar, MANY, at)[0]),
            "landing of the rigid rod": float(rigid),
            **{f"excess {x}": float(y) for x, y in zip(three, excess, strict=True)},
        })  # fmt: skip
    return rows


def uniform_friction(theta: float, mu: float, speeds: Sequence[float]) -> list[dict[str, Any]]:
    """Return when slips below cot θ stop: by friction of uniform sliding, bounces included."""
    bar = theory().Bar()
    stops = slide(Modes(bar, 8, 2), hertz(bar), theta, mu, np.array(speeds), window=1.0,
                  bounces=True)["stop"]  # fmt: skip
    return [{"theta": theta, "mu": mu, "speed": v, "stop": float(t)}
            for v, t in zip(speeds, stops, strict=True)]  # fmt: skip


def belt(angles: Sequence[float]) -> list[dict[str, float]]:
    """Return the landing of the bench rod of aluminium that approaches its belt with 0.1 m/s.

    The rod has 1 m and 6 mm. Its end has the radius 0 or is round; or it bears a ball of steel on
    a belt of steel, once without its mass and once with it, in either case as a point on the axis.
    """
    given = ps.material("aluminium")
    mass = given.density * math.pi * BENCH_RADIUS**2
    bar = theory().Bar(mass, 1.0, given.density, given.young_modulus, given.poisson_ratio)
    soft, theta = hertz(bar, BENCH_RADIUS), np.array(angles)
    radius, density = BALL
    hard = hertz(theory().Bar(modulus=200e9), radius)
    columns: dict[str, Any] = {"theta": theta}
    for counts in (MANY, (48, 24)):
        name, modes = f"{counts[0]},{counts[1]}", Modes(bar, *counts)
        heavy = modes.loaded(density * 4 / 3 * math.pi * radius**3)
        columns |= {
            f"{end} {name}": landing(m, contact, theta, 1.0, approach=0.1)
            for end, m, contact in (
                ("landing", modes, soft),
                ("round end", Modes(bar, *counts, BENCH_RADIUS), soft),
                ("hard tip", modes, hard),
                ("heavy tip", heavy, hard),
            )
        }
    columns["landing of the rigid rod"] = landing(Modes(bar, 0, 0), soft, theta, 1.0, approach=0.1)
    return [dict(zip(columns, map(float, row), strict=True)) for row in zip(*columns.values())]  # noqa: B905


def maps(slender: Sequence[float], angles: Sequence[float], names: Sequence[str]) -> Any:
    """Return the landing at 1 m/s over angle and slenderness, by material; round ends, 1 kg.

    ``truncation`` is by how much the least over angles falls with 48,24 modes.
    """
    grids: dict[str, Any] = {}
    truncation: dict[str, list[float]] = {}
    for name in names:
        given, rows, left = ps.material(name), [], []
        for ratio in slender:
            bar = theory().round_bar(
                ratio, density=given.density, modulus=given.young_modulus,
                poisson=given.poisson_ratio,
            )  # fmt: skip
            modes = Modes(bar, *MANY)
            contact = hertz(bar, bar.radius)
            least = landing(modes, contact, np.array(angles), 1.0, steps=14)
            rows.append(least.tolist())
            at = int(np.argmin(least))
            finer = landing(Modes(bar, 48, 24), contact, angles[at], 1.0, steps=14)
            left.append(float(least[at] - finer))
        grids[name], truncation[name] = rows, left
    return {"slenderness": list(slender), "angle": list(angles), "landing": grids,
            "truncation": truncation}  # fmt: skip


def study(quick: bool) -> dict[str, Any]:
    """Return all numbers of the study."""
    counts = ((2, 1),) if quick else ((1, 0), (4, 1), (8, 2), (24, 12), (48, 24), MAX_COUNTS)
    angles, speeds = ((1.0,), (1.0,)) if quick else (ANGLES, SPEEDS)
    return {
        "computed": {
            "version": ps.__version__, "law": "Hertz, elastic", "n": Contact(1.0).n,
            "modes": "those named, at a held angle",
        },
        "belt": belt((0.6, 1.2)),
        "round ends": round_ends(angles),
        "slenderness": by_slenderness((20,) if quick else SHORT),
        "below cot": uniform_friction(1.0, 0.6, (1.0, 2.0)),
        "angles": over_angles(angles, counts[-1:] if quick else (MANY, (48, 24))),
        "speeds": over_speeds((1.0,) if quick else (1.0, 1.2, 1.4), speeds),
        "convergence": convergence(counts),
        "approach": [] if quick else approaching(((8, 2), (20, 10), (48, 24), MAX_COUNTS)),
        "variants": [] if quick else variants(),
        "fast": [] if quick else fast((1.0, 1e2, 1e4, 1e6)),
        "paper": [] if quick else with_the_papers_law((1.0, 1.2, 1.3, 1.4)),
        "maps": maps((50,) if quick else SLENDER, (1.0, 1.4) if quick else MAP_ANGLES,
                     ("steel",) if quick else tuple(n for n in materials() if n != "rubber")),
    }  # fmt: skip


# ---- tables and figures ----


def tables(data: dict[str, Any]) -> list[str]:
    """Return the tables of the page."""
    table, milli = theory().table, theory().milli
    columns = ("cot", "coupling", "landing 48,24", "landing at 100 m/s", "divergence",
               "divergence at 9.8 N", "landing of the rigid rod", "rigid rod")  # fmt: skip
    angles = [[f"{r['theta']:.1f}", *(f"{r[c]:.4f}" for c in columns)] for r in data["angles"]]
    by_speed: dict[float, list[dict[str, float]]] = {}
    for r in data["speeds"]:
        by_speed.setdefault(r["speed"], []).append(r)
    speeds = [
        [f"{v:g}", *(f"{r['landing']:.4f}" for r in rows), f"{rows[0]['rigid']:.4f}"]
        for v, rows in by_speed.items()
    ]
    last = next(iter(by_speed.values()))
    rigid = next(r["rigid rod"] for r in data["angles"] if r["theta"] == 1.0)
    limit = ["divergence", *(f"{r['divergence']:.4f}" for r in last), f"{rigid:.4f}"]
    modes = [
        [r["modes"], f"{r['landing 1.0']:.4f}", f"{r['landing 1.4']:.4f}",
         *(f"{milli(r[f'stop {mu}'])}" for mu in FRICTION)]
        for r in data["convergence"]
    ]  # fmt: skip
    fastest = [
        [f"{r['theta']:g}", r["modes"], f"{r['factor']:g}", *(f"{x:.5f}" for x in r["landing"]),
         f"{r['divergence']:.5f}"]
        for r in data["fast"]
    ]  # fmt: skip
    changes = [[r["case"], f"{r['landing']:.4f}"] for r in data["variants"]]
    stops = [n.removeprefix("stop ") for n in data["approach"][0] if n.startswith("stop ")]
    approach = [
        [f"{r['approach']:g}", f"{r['mu']}", *(milli(r[f"stop {n}"]) for n in stops)]
        for r in data["approach"]
    ]
    grid = data["maps"]
    least = []
    for name, rows in grid["landing"].items():
        errors = (max(abs(e), GRID) for e in grid["truncation"][name])
        cells = [
            f"{min(row):.3f} ± {error:.1g}, {grid['angle'][int(np.argmin(row))]:g}"
            for row, error in zip(rows, errors, strict=True)
        ]
        least.append([name, *cells])
    return [
        table(["θ, rad", "(a) cot θ", "(b) coupling", "(c) landing, 1 m/s", "100 m/s",
               "(d) divergence, rigid contact", "Hertz, 9.8 N", "rigid rod, 1 m/s",
               "rigid rod"], angles),
        table(["speed, m/s", *(f"θ = {r['theta']:g}" for r in last), "rigid rod, θ = 1"],
              [*speeds, limit]),
        table(["modes", "landing, θ = 1", "landing, θ = 1.4", *(f"μ = {m}" for m in FRICTION)],
              modes),
        table(["landing at θ = 1 and 1 m/s", "least μ"], changes),
        table(["θ", "modes", "K over Hertz's", *(f"{v:g} m/s" for v in data["fast"][0]["speed"]),
               "divergence, rigid contact"], fastest),
        table(["material", *(f"L/d = {x:g}" for x in grid["slenderness"])], least),
        table(["approach, m/s", "μ", *(f"{n}, ms" for n in stops)], approach),
        table(["θ, rad", "radius 0", "ball of 6.45 mm", "lower by", "rigid rod, radius 0",
               "rigid rod with the ball"], round_end_rows(data)),
        table(["L/d", "least landing", "at θ", "divergence there", "excess at θ = 1.0", "1.2",
               "1.4", "rigid rod, landing"], slenderness_rows(data)),
    ]  # fmt: skip


def round_end_rows(data: dict[str, Any]) -> list[list[str]]:
    """Return the lines of the table of round ends."""
    rigid = {r["theta"]: r["landing of the rigid rod"] for r in data["angles"]}
    return [
        [f"{r['theta']:.1f}", f"{r['point 48,24']:.4f}", f"{r['ball 48,24']:.4f}",
         f"{100 * (1 - r['ball 48,24'] / r['point 48,24']):.1f} %", f"{rigid[r['theta']]:.4f}",
         f"{r['ball, rigid rod']:.4f}"]
        for r in data["round ends"]
    ]  # fmt: skip


def slenderness_rows(data: dict[str, Any]) -> list[list[str]]:
    """Return the lines of the table of landings and divergence by slenderness."""
    return [
        [f"{r['slenderness']:g}", f"{r['landing']:.4f}", f"{r['theta']:.2f}",
         f"{r['divergence']:.4f}",
         *(f"{100 * r[f'excess {x}']:+.0f} %".replace("-", "−") for x in (1.0, 1.2, 1.4)),
         f"{r['landing of the rigid rod']:.4f}"]
        for r in data["slenderness"]
    ]  # fmt: skip


def belt_table(data: dict[str, Any]) -> str:
    """Return the table of the bench rod's landing, of the page on experiments."""
    names = ("landing", "round end", "hard tip", "heavy tip")
    rows = [
        [f"{r['theta']:g}", *(f"{r[f'{n} 48,24']:.3f}" for n in names),
         f"{r['landing of the rigid rod']:.3f}"]
        for r in data["belt"]
    ]  # fmt: skip
    head = ["θ, rad", "end of radius 0", "round end of 3 mm", "hard tip without mass",
            "hard tip with its mass", "rigid rod"]  # fmt: skip
    return str(theory().table(head, rows))


def figure(data: dict[str, Any]) -> Figure:
    """Return the four thresholds over the angle, and the landing over the speed."""
    rows = data["angles"]
    theta = [r["theta"] for r in rows]
    with rc_context(STYLE):
        drawn = Figure(figsize=(PAGE, COLUMN * 0.9), layout="constrained")
        left, right = drawn.subplots(1, 2)
        shown = {"(a) cot θ": "cot", "(b) coupling": "coupling", "(c) landing at 1 m/s": 0,
                 "(d) divergence, rigid contact": "divergence",
                 "rigid rod": "rigid rod"}  # fmt: skip
        key = next(n for n in rows[0] if n.startswith("landing "))
        for (name, column), color, dash in zip(shown.items(), PALETTE, DASHES * 2, strict=False):
            left.plot(theta, [r[column or key] for r in rows], color=color, linestyle=dash,
                      label=name)  # fmt: skip
        left.set(ylim=(0, 1.6), xlabel=r"$\theta$ (rad)", ylabel=r"friction $\mu$")
        left.set_title("(i) four thresholds of the paper's rod of steel")
        left.legend(loc="lower left")
        for angle, color, dash in zip(
            dict.fromkeys(r["theta"] for r in data["speeds"]), PALETTE, DASHES, strict=False
        ):
            own = [r for r in data["speeds"] if r["theta"] == angle]
            right.plot([r["speed"] for r in own], [r["landing"] for r in own], color=color,
                       linestyle=dash, label=rf"$\theta$ = {angle:g}")  # fmt: skip
            right.axhline(own[0]["divergence"], color=REFERENCE, linewidth=0.8)
        right.set(xscale="log", ylim=(0, 0.8), xlabel="slip velocity (m/s)")
        right.set(ylabel="landing", title="(ii) landing, and divergence on a rigid contact")
        right.legend(loc="lower right")
    return drawn


def map_figure(data: dict[str, Any]) -> Figure:
    """Return the landing over angle and slenderness of steel, and its least value by material."""
    m = data["maps"]
    with rc_context(STYLE):
        drawn = Figure(figsize=(PAGE, COLUMN * 0.9), layout="constrained")
        left, right = drawn.subplots(1, 2)
        steel = np.array(m["landing"]["steel"])
        if min(steel.shape) > 1:
            levels = np.arange(0.2, 1.01, 0.1)
            # Without the yellow end of the colours, which paper hides.
            colours = colormaps["viridis"](np.linspace(0, 0.8, len(levels)))
            curves = left.contour(m["angle"], m["slenderness"], steel, levels, colors=colours)
            left.set(yscale="log")
            longest = [max(lines, key=len) for lines in curves.allsegs if lines]
            places = [line[len(line) // 2] for line in longest if len(line)]
            left.clabel(curves, fontsize="small", manual=places)
            left.set(yticks=[20, 50, 100, 200, 500])
            left.set_yticks(m["slenderness"], [f"{x:g}" for x in m["slenderness"]])
            left.minorticks_off()
        left.set(xlabel=r"$\theta$ (rad)", ylabel="length over diameter")
        left.set_title("(i) landing of steel at 1 m/s")
        for (name, grid), color, dash in zip(
            m["landing"].items(), PALETTE * 2, DASHES * 2, strict=False
        ):
            least = np.min(grid, axis=1)
            right.plot(m["slenderness"], least, color=color, linestyle=dash, label=name)
        right.set(xscale="log", xlabel="length over diameter", ylabel="least landing over angles")
        right.set_xticks(m["slenderness"], [f"{x:g}" for x in m["slenderness"]])
        right.minorticks_off()
        right.set_title("(ii) least of all angles at 1 m/s")
        right.set_xticks([20, 50, 100, 200, 500])
        for axis in (left.yaxis, right.xaxis):
            axis.set_major_formatter(ScalarFormatter())
            axis.set_minor_formatter(NullFormatter())
        right.legend(loc="upper right")
    return drawn


def draw(data: dict[str, Any], folder: Path) -> None:
    """Write both figures."""
    save(figure(data), folder / "landing")
    save(map_figure(data), folder / "landing-maps")


def main() -> None:
    """Compute, write the files, print the main numbers."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few and short runs")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder")
    parser.add_argument("--draw", action="store_true", help="only draw the kept numbers")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    kept = Path(__file__).with_name("landing.json")
    if options.draw:
        draw(json.loads(kept.read_text("utf-8")), options.out)
        return
    data = study(options.quick)
    text = json.dumps(data, indent=1, allow_nan=False) + "\n"
    (options.out / "landing.json").write_text(text, "utf-8")
    draw(data, options.out)
    if not options.quick:
        (options.out / "landing-tables.md").write_text("\n\n".join(tables(data)) + "\n", "utf-8")
    for row in data["angles"]:
        print(" ".join(f"{name} {value:.4f}" for name, value in row.items()))


if __name__ == "__main__":
    main()
