"""When does a real bar jam? Painlevé's rod as an elastic bar: friction from which sliding diverges.

Sliding over a contact of stiffness k is unstable if a real p > 0 solves

    1/k + cos²θ G_b(p) + sin²θ G_a(p) = μ sinθ cosθ (G_b(p) - G_a(p))

with G_b and G_a the displacement of the end per force across and along the bar (receptances) as
functions of the growth rate p. A rigid rod has G_b = 4/(m p²), G_a = 1/(m p²).

Run: python examples/studies/rigid_rod/rigid_rod.py [--quick] [--out FOLDER]
Writes rigid-rod.json (all numbers), thresholds.csv, rigid-rod.png and rigid-rod.svg.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

import painleve_sym as ps
from painleve_sym.mechanics.materials import materials
from painleve_sym.present.style import COLUMN, DASHES, PAGE, PALETTE, REFERENCE, STYLE, save
from painleve_sym.tables import markdown_table as table

Pair = tuple[Any, Any]
Receptances = Callable[[Any], Pair]

SLIDING = {"theta": 1.0, "x_A_dot": -1.0}
FRICTION = (0.5, 0.7, 0.9, 1.1, 1.4)
MODELS = ("rod", "1,0", "4,1", "8,2", "20,10")
"""Rigid, and numbers of bending and axial modes; the last is the most, which leaves the least."""
RATES = np.geomspace(0.1, 1e9, 2001)
G = 9.8


@dataclass(frozen=True)
class Bar:
    """A solid round bar with free ends, by default the paper's rod; m, kg, Pa."""

    mass: float = 1.0
    length: float = 2.0
    density: float = 7850.0
    modulus: float = 209e9
    poisson: float = 0.3

    @property
    def area(self) -> float:
        return self.mass / (self.density * self.length)

    @property
    def radius(self) -> float:
        return math.sqrt(self.area / math.pi)

    @property
    def stiffness(self) -> float:
        """E I of bending; N m²."""
        return self.modulus * self.area**2 / (4 * math.pi)

    def frequencies(self, bending: int, axial: int) -> tuple[Any, Any]:
        """Return the natural circular frequencies of both kinds; rad/s."""
        across = wavenumbers(bending) ** 2
        along = math.pi * np.arange(1, axial + 1)
        return (
            across * math.sqrt(self.stiffness / (self.mass * self.length**3)),
            along * math.sqrt(self.modulus / self.density) / self.length,
        )


def wavenumbers(count: int) -> Any:
    """Return the roots β of cos β cosh β = 1 after 0: bending of a bar with free ends."""
    return np.array([
        brentq(lambda b: math.cos(b) - 1 / math.cosh(b), x - 0.5, x + 0.5)
        for x in (np.arange(1, count + 1) + 0.5) * math.pi
    ])  # fmt: skip


# ---- receptances of the end: displacement per force, across and along the bar ----


def rigid(bar: Bar) -> Receptances:
    """Return the receptances of the rigid rod."""
    return lambda p: (4 / (bar.mass * p**2), 1 / (bar.mass * p**2))


def modal(bar: Bar, bending: int, axial: int, damping: float = 0.0) -> Receptances:
    """Return the receptances with a number of modes of each kind, as `rod-bending` has them."""
    across, along = bar.frequencies(bending, axial)

    def total(p: Any, rigid_part: float, square: float, frequencies: Any) -> Any:
        p = np.asarray(p)[..., None]
        terms = square / (p**2 + 2 * damping * frequencies * p + frequencies**2)
        return (rigid_part / p[..., 0] ** 2 + terms.sum(axis=-1)) / bar.mass

    return lambda p: (total(p, 4, 4, across), total(p, 1, 2, along))


def axial_wave(bar: Bar, p: Any) -> Any:
    """Return G_a of the bar with all its modes: coth(pL/c)/(A √(Eρ) p)."""
    speed = math.sqrt(bar.modulus / bar.density)
    return 1 / (
        bar.area * math.sqrt(bar.modulus * bar.density) * p * np.tanh(p * bar.length / speed)
    )


def euler_bernoulli(bar: Bar) -> Receptances:
    """Return the receptances with all modes: bending by Euler and Bernoulli, waves along the bar.

    With 4 b⁴ = m L³ p²/(E I): G_b = L³/(2 E I b³) (sinh 2b - sin 2b)/(cosh 2b + cos 2b - 2).
    """

    def across(p: Any) -> Any:
        b = np.sqrt(p) * (bar.mass * bar.length**3 / (4 * bar.stiffness)) ** 0.25
        decay = np.exp(-2 * b)
        # The quotient cancels for small b: its series there.
        quotient = (1 - decay**2 - 2 * decay * np.sin(2 * b)) / (
            1 + decay**2 + 2 * decay * (np.cos(2 * b) - 2)
        )
        series = (2 / b) * (1 + b**4 / 105)
        return (
            bar.length**3 / (2 * bar.stiffness * b**3) * np.where(abs(b) < 0.05, series, quotient)
        )

    return lambda p: (across(p), axial_wave(bar, p))


def half_infinite(bar: Bar) -> Receptances:
    """Return the receptances of a bar without a far end: waves leave and never return."""
    line = bar.density * bar.area
    across = math.sqrt(2) / (bar.stiffness**0.25 * line**0.75)
    along = 1 / (bar.area * math.sqrt(bar.modulus * bar.density))
    return lambda p: (across / p**1.5, along / p)


def timoshenko(bar: Bar) -> Receptances:
    """Return the receptances of Timoshenko's bar, with shear and rotary inertia of its sections."""
    shear = 6 * (1 + bar.poisson) / (7 + 6 * bar.poisson)
    k = shear * bar.modulus / (2 * (1 + bar.poisson)) * bar.area
    line, turn = bar.density * bar.area, bar.density * bar.area**2 / (4 * math.pi)
    stiff, length = bar.stiffness, bar.length

    def across(p: float) -> float:
        square = stiff * line * p**2 + turn * p**2 * k
        root = np.sqrt(complex(square**2 - 4 * stiff * k * (k + turn * p**2) * line * p**2))
        rates = np.sqrt((square + np.array([root, -root])) / (2 * stiff * k))
        s = np.concatenate([-rates, rates])
        slope = (k * s**2 - line * p**2) / (k * s)
        # Waves from either end, each of size 1 where it starts.
        at = [np.exp(-rates * x) for x in (0, length)]
        near, far = np.concatenate([at[0], at[1]]), np.concatenate([at[1], at[0]])
        moment, force = stiff * s * slope, k * (s - slope)
        rows = np.array([force * near, moment * near, force * far, moment * far])
        scale = abs(rows).max(axis=1)
        weights = np.linalg.solve(rows / scale[:, None], [-1 / scale[0], 0, 0, 0])
        return float((weights @ near).real)

    return lambda p: (np.vectorize(across)(p), axial_wave(bar, p))


def threshold(receptances: Receptances, theta: float, stiffness: float = math.inf) -> Pair:
    """Return the least friction at which sliding diverges, and the growth rate there in 1/s."""
    sin, cos = math.sin(theta), math.cos(theta)

    def friction(p: Any) -> Any:
        across, along = receptances(p)
        lag = sin * cos * (across - along)
        load = 1 / stiffness + cos**2 * across + sin**2 * along
        return np.where(lag > 0, load / np.where(lag > 0, lag, 1), np.inf)

    values = friction(RATES)
    i = int(np.argmin(values))
    if not math.isfinite(values[i]):
        return math.inf, math.nan
    low, high = (math.log(RATES[max(0, min(j, len(RATES) - 1))]) for j in (i - 1, i + 1))
    best = minimize_scalar(
        lambda u: float(friction(np.array([math.exp(u)]))[0]), bounds=(low, high),
        method="bounded", options={"xatol": 1e-10},
    )  # fmt: skip
    return (float(best.fun), math.exp(best.x)) if best.fun < values[i] else (
        float(values[i]), float(RATES[i])
    )  # fmt: skip


def growth(
    bar: Bar, counts: tuple[int, int], theta: float, mu: float, k: float, damping: float = 0.0
) -> complex:
    """Return the growth rate p of largest real part of a bar with modes that slides; 1/s."""
    across, along = bar.frequencies(*counts)
    sin, cos = math.sin(theta), math.cos(theta)
    # Rigid motions across and along count as modes of frequency 0, of end values 2 and 1.
    rates = np.concatenate([[0.0], across, [0.0], along])
    n, split = len(rates), 1 + len(across)
    ends = np.where(np.arange(n) < split, 2.0, math.sqrt(2))
    ends[split] = 1.0
    normal = np.where(np.arange(n) < split, cos, sin) * ends
    push = np.where(np.arange(n) < split, cos - mu * sin, sin + mu * cos) * ends
    below = -np.diag(rates**2) - k / bar.mass * np.outer(push, normal)
    matrix = np.block([[np.zeros((n, n)), np.eye(n)], [below, -2 * damping * np.diag(rates)]])
    roots = np.linalg.eigvals(matrix)
    return complex(roots[np.argmax(roots.real)])


def flutter_threshold(
    bar: Bar, counts: tuple[int, int], theta: float, k: float, damping: float = 0.0
) -> float:
    """Return the least friction, to 1e-4, from which deviations grow faster than 1/s.

    Friction rises in steps of 0.005; the step in which they begin to grow is then halved.
    """

    def grows(mu: float) -> bool:
        return growth(bar, counts, theta, mu, k, damping).real > 1

    high = next(mu for mu in 0.005 * np.arange(1, 1000) if grows(mu))
    low = high - 0.005
    while high - low > 1e-4:
        middle = (low + high) / 2
        low, high = (low, middle) if grows(middle) else (middle, high)
    return float(high)


def rigid_up_to(bar: Bar) -> float:
    """Return the contact stiffness up to which the threshold is the rigid rod's at every angle.

    1/k = L³/(315 E I) - 4 L/(9 E A), from the compliance of the end beyond rigid motion, p → 0:
    L³/(105 E I) across and L/(3 E A) along. Infinite where the right side is not positive. N/m.
    """
    across = bar.length**3 / (315 * bar.stiffness)
    along = 4 * bar.length / (9 * bar.modulus * bar.area)
    return 1 / (across - along) if across > along else math.inf


def peak_ratio(bar: Bar) -> dict[str, float]:
    """Return the largest G_b/G_a, its growth rate, and the least threshold over all angles."""

    def negative(u: float) -> float:
        across, along = euler_bernoulli(bar)(np.array([math.exp(u)]))
        return -float(across[0] / along[0])

    unit = math.log(math.sqrt(bar.modulus / bar.density) / bar.length)
    best = minimize_scalar(negative, bounds=(unit - 4, unit + 4), method="bounded")
    r = -float(best.fun)
    return {"ratio": r, "rate": math.exp(best.x), "friction": 2 * math.sqrt(r) / (r - 1),
            "angle": math.atan(math.sqrt(r))}  # fmt: skip


# ---- motion of the whole bar ----


@cache
def simulator(counts: str) -> ps.Simulator:
    """Return the rigid rod or `rod-bending` on a Hertz contact that yields, made once."""
    name = "rod" if counts == "rod" else f"rod-bending:{counts}"
    return ps.Simulator(ps.model(name), ps.law("bilinear-hertz"))


def contact(
    force: float,
    modulus: float = 209e9,
    radius: float = 0.00645,
    poisson: float = 0.3,
    **others: float,
) -> Pair:
    """Return K and the slope dF/dδ at a force on the loading curve K δⁿ of the contact law."""
    given = {"E": modulus, "R": radius, "nu": poisson} | others
    law = ps.law("bilinear-hertz").with_parameters(**given)
    values = {p.symbol: p.default for p in law.parameters}
    constant = law.stiffness.subs(dict(law.definitions)).subs(values)
    n = float(law.exponent.subs(values))
    return float(constant), n * float(constant) * (force / float(constant)) ** (1 - 1 / n)


def motion(counts: str, mu: float, t_end: float = 0.03, **change: float) -> dict[str, Any]:
    """Return slip stop, peak force, rebound and vibration of one run of sliding rod."""
    parameters = {
        n: v for n, v in change.items() if n not in ("x_A_dot", "y_A_dot", "theta", "y_A")
    }
    state = SLIDING | {n: v for n, v in change.items() if n not in parameters}
    run = simulator(counts).run(state, t_end=t_end, parameters={"mu": mu, **parameters})
    stops = run.events_of("slip_stop")
    after = stops[0].time if stops else 0.0
    leaves = [e for e in run.events_of("separation") if e.time > after]
    numbers = {
        "model": counts,
        "mu": mu,
        "slip_stop": stops[0].time if stops else None,
        "peak_force": float(max(run.values("normal_force", run.fine_times()))),
        "separation": leaves[0].time if leaves else None,
        "rebound": float(run.values("gap_rate", [leaves[0].time])[0]) if leaves else None,
        "vibration": vibration(counts, run.state(leaves[0].time)) if leaves else None,
        "friction": run.state(leaves[0].time)["friction_dissipation"] if leaves else None,
        "plastic": run.state(leaves[0].time)["contact_dissipation"] if leaves else None,
        "kinetic_energy": float(run.values("kinetic_energy", [0.0])[0]),
        "energy_residual": run.energy_residual,
        "bounces": len(run.events_of("separation")),
        "end": float(run.t[-1]),
    }
    return numbers


def vibration(counts: str, state: dict[str, float], bar: Bar | None = None) -> float:
    """Return kinetic and elastic energy in the modes of `rod-bending`; J."""
    if counts == "rod":
        return 0.0
    bar = bar or Bar()
    bending, axial = map(int, counts.split(","))
    names = [f"w_{i + 1}" for i in range(bending)] + [f"u_{i + 1}" for i in range(axial)]
    rates = np.concatenate(bar.frequencies(bending, axial))
    energies = (
        bar.mass / 2 * (state[f"{n}_dot"] ** 2 + (w * state[n]) ** 2)
        for n, w in zip(names, rates, strict=True)
    )
    return float(sum(energies))


@dataclass(frozen=True)
class Chain:
    """An elastic rod without modes and without a frame: a line of particles.

    Half a particle is at either end. Springs along the links and torsion springs between them turn
    and stretch without limit; SciPy integrates the positions. Error of order 1/elements².

    Attributes
    ----------
    bar : Bar
    elements : int
    mu : float
    law : mapping of str to float
        Parameters of `bilinear-hertz` other than the bar's modulus and Poisson's ratio.
    """

    bar: Bar
    elements: int
    mu: float
    law: Mapping[str, float]

    @cached_property
    def masses(self) -> Any:
        """Masses of the particles, kg."""
        masses = np.full(self.elements + 1, self.bar.mass / self.elements)
        masses[[0, -1]] /= 2
        return masses

    @cached_property
    def curve(self) -> tuple[float, float, float]:
        """K and n of the loading curve K δⁿ, and the energetic restitution."""
        constant, _ = contact(1.0, self.bar.modulus, poisson=self.bar.poisson, **self.law)
        values = {p.name: p.default for p in ps.law("bilinear-hertz").parameters} | self.law
        return constant, values["n"], values["e_energetic"]

    def plastic(self, deepest: float) -> float:
        """Return the permanent compression after unloading from the deepest one, m."""
        return deepest * (1 - self.curve[2] ** 2)

    def normal_force(self, depth: float, deepest: float) -> float:
        """Return the force of the contact, N; `deepest` is 0 while the first loading lasts."""
        constant, n, e = self.curve
        if depth >= deepest:
            return constant * max(depth, 0.0) ** n
        return constant * (max(depth - self.plastic(deepest), 0.0) / e**2) ** n

    def forces(self, place: Any) -> Any:
        """Return the forces of springs and weight on the particles, N."""
        bar, h = self.bar, self.bar.length / self.elements
        taut, bent = bar.modulus * bar.area / h, bar.stiffness / h
        link = np.diff(place, axis=0)
        size = np.hypot(link[:, 0], link[:, 1])
        along = link / size[:, None]
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        a, b = along[:-1], along[1:]
        moment = np.zeros(self.elements + 1)
        moment[1:-1] = bent * np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))
        pull = (taut * (size - h))[:, None] * along
        pull += ((moment[:-1] - moment[1:]) / size)[:, None] * across
        total = np.zeros_like(place)
        total[:-1] += pull
        total[1:] -= pull
        total[:, 1] -= G * self.masses
        return total

    def field(self, _: float, y: Any, deepest: float, slip: int) -> Any:
        """Return the rates; the tip slips to the left (-1) or right (1), or sticks (0)."""
        place, speed = y.reshape(2, -1, 2)
        total = self.forces(place)
        normal = self.normal_force(-place[0, 1], deepest)
        total[0, 0] = total[0, 0] - slip * self.mu * normal if slip else 0.0
        total[0, 1] += normal
        return np.concatenate([speed, total / self.masses[:, None]]).ravel()

    def events(self, loading: bool, slip: int) -> dict[str, Any]:
        """Return the events of a phase of the contact, by their names."""
        tip = 2 * (self.elements + 1)

        def room(_: float, y: Any, deepest: float, __: int) -> float:
            pull = abs(self.forces(y.reshape(2, -1, 2)[0])[0, 0])
            return float(self.mu * self.normal_force(-y[1], deepest) - pull)

        events: dict[str, Any] = {}
        if loading:
            events["turn"] = lambda _, y, *a: y[tip + 1]
        else:
            events["reload"] = lambda _, y, deepest, __: -y[1] - deepest
            events["separation"] = lambda _, y, deepest, __: y[1] + self.plastic(deepest)
        if slip:
            events["slip_stop"] = lambda _, y, *a: -slip * y[tip]
        else:
            events["slip_start"] = lambda *a: -room(*a)
        for event in events.values():
            event.terminal, event.direction = True, 1
        return events

    def impact(
        self, t_end: float, speed: float, theta: float, approach: float, until: str
    ) -> list[dict[str, Any]]:
        """Return the events of one contact: time, kind, force, motion of the mass centre, spin."""
        place = np.linspace(0, self.bar.length, self.elements + 1)[:, None]
        place = place * np.array([math.cos(theta), math.sin(theta)])
        y = np.concatenate([place, np.tile([-speed, -approach], (self.elements + 1, 1))]).ravel()
        t, deepest, slip, rows = 0.0, 0.0, -1, list[dict[str, Any]]()
        while t < t_end and (not rows or rows[-1]["kind"] not in (until, "separation")):
            events = self.events(deepest == 0.0, slip)
            part = solve_ivp(
                self.field, (t, t_end), y, method="DOP853", rtol=1e-9, atol=1e-13,
                args=(deepest, slip), events=list(events.values()),
            )  # fmt: skip
            t, y = float(part.t[-1]), part.y[:, -1]
            if part.status == 0:
                break
            (kind,) = [k for k, times in zip(events, part.t_events, strict=True) if len(times)]
            force = float(self.normal_force(-y[1], deepest))
            rows.append({"time": t, "kind": kind, "force": force, **self.rigid_motion(y)})
            if kind == "slip_start":
                slip = 1 if self.forces(y.reshape(2, -1, 2)[0])[0, 0] > 0 else -1
            slip = 0 if kind == "slip_stop" else slip
            deepest = {"turn": -y[1], "reload": 0.0}.get(kind, deepest)
        return rows

    def rigid_motion(self, y: Any) -> dict[str, float]:
        """Return velocity of the mass centre, and angular momentum over the straight inertia."""
        place, speed = y.reshape(2, -1, 2)
        m = self.masses
        centre, drift = (m @ v / self.bar.mass for v in (place, speed))
        x, v = place - centre, speed - drift
        momentum = m @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])
        inertia = self.bar.mass * self.bar.length**2 / 12
        return {"v_x": float(drift[0]), "v_y": float(drift[1]), "spin": float(momentum / inertia)}


def chain(
    mu: float, elements: int, t_end: float, bar: Bar | None = None, speed: float = 1.0
) -> dict[str, Any]:
    """Return slip stop, and the force then, of a chain of particles that slides without load."""
    rows = Chain(bar or Bar(), elements, mu, {}).impact(
        t_end, speed, SLIDING["theta"], 0.0, until="slip_stop"
    )
    stops = [r for r in rows if r["kind"] == "slip_stop"]
    return {
        "elements": elements,
        "mu": mu,
        "slip_stop": stops[0]["time"] if stops else None,
        "force": stops[0]["force"] if stops else None,
    }


def critical_force(counts: str, mu: float, **state: float) -> float | None:
    """Return the least initial force, 0.01 N to 3000 N, from which the slip stops in contact."""

    def impacts(force: float) -> bool:
        run = simulator(counts).run(
            SLIDING | state, t_end=0.05, parameters={"mu": mu}, initial_force=force,
            until=("slip_stop", "separation"),
        )  # fmt: skip
        return bool(run.events_of("slip_stop"))

    low, high = 0.01, 3000.0
    if impacts(low) or not impacts(high):
        return None
    while high / low > 1 + 1e-7:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if impacts(middle) else (middle, high)
    return high


# ---- the study ----

COUNTS = ((1, 0), (2, 0), (4, 0), (1, 1), (4, 1), (8, 2), (20, 20))
COUPLED = (24, 12)
"""Modes of the threshold of coupling."""
ANGLES = (0.6, 0.8, 1.0, 1.2, 1.3, 1.4, 1.5)
WEIGHT = 9.8


def models(bar: Bar) -> dict[str, Receptances]:
    """Return the receptances that are compared, by name."""
    finite = {f"{b},{a}": modal(bar, b, a) for b, a in COUNTS}
    return {
        "rigid": rigid(bar),
        **finite,
        "all": euler_bernoulli(bar),
        "Timoshenko": timoshenko(bar),
    }


def round_bar(slenderness: float, mass: float = 1.0, **material: float) -> Bar:
    """Return the round bar of a mass whose length is a number of diameters."""
    density = material.get("density", 7850.0)
    return Bar(mass, (4 * mass * slenderness**2 / (math.pi * density)) ** (1 / 3), **material)


def bench(name: str) -> Bar:
    """Return the bar of half a metre and 10 mm of a material of the table."""
    given = ps.material(name)
    mass = given.density * math.pi / 4 * 0.01**2 * 0.5
    return Bar(mass, 0.5, given.density, given.young_modulus, given.poisson_ratio)


def parameters_of(bar: Bar) -> dict[str, float]:
    """Return the parameters of `rod-bending` and of the contact law for a bar."""
    return {
        "m": bar.mass, "l": bar.length / 2, "rho": bar.density, "Y": bar.modulus,
        "E": bar.modulus, "nu": bar.poisson,
    }  # fmt: skip


def thresholds() -> dict[str, Any]:
    """Return threshold friction over angle, modes, stiffness, slenderness, material and damping."""
    steel = Bar()
    _, k = contact(WEIGHT)
    names = models(steel)
    over_angle = [
        {"theta": angle, **{n: threshold(g, angle, k)[0] for n, g in names.items()}}
        for angle in ANGLES
    ]
    over_force = []
    for force in (0.1, 1.0, 10.0, 100.0, 1000.0, 10000.0, math.inf):
        slope = contact(force)[1] if math.isfinite(force) else math.inf
        row: dict[str, Any] = {"force": str(force), "stiffness": str(slope)}
        for name in ("1,0", "4,1", "all", "Timoshenko"):
            row[name], row[f"rate {name}"] = threshold(names[name], 1.0, slope)
        over_force.append(row)
    over_slenderness = []
    for ratio in (10, 20, 50, 100, 200, 500, 1000):
        bar = round_bar(ratio)
        slope = contact(WEIGHT, radius=bar.radius)[1]
        row = {"slenderness": ratio, "length": bar.length, "frequency": bar.frequencies(1, 0)[0][0]}
        row["all"], row["rate"] = threshold(euler_bernoulli(bar), 1.0, slope)
        row["Timoshenko"] = threshold(timoshenko(bar), 1.0, slope)[0]
        row["coupling"] = flutter_threshold(bar, COUPLED, 1.0, slope, 0.01)
        row |= {"stiffness": slope, "rigid up to": rigid_up_to(bar)}
        over_slenderness.append(row | {f"peak {n}": v for n, v in peak_ratio(bar).items()})
    over_material = []
    for name in materials():
        bar = bench(name)
        slope = contact(bar.mass * G, bar.modulus, 0.005, bar.poisson)[1]
        mu, rate = threshold(euler_bernoulli(bar), 1.0, slope)
        over_material.append(
            {"material": name, "mass": bar.mass, "stiffness": slope, "all": mu, "rate": rate,
             "coupling": flutter_threshold(bar, COUPLED, 1.0, slope, 0.01),
             "frequency": bar.frequencies(1, 0)[0][0], "rigid up to": rigid_up_to(bar)}
        )  # fmt: skip
    over_damping = [
        {"damping": z, "divergence": threshold(modal(steel, *COUPLED, z), 1.0, k)[0],
         "coupling": flutter_threshold(steel, COUPLED, 1.0, k, z)}
        for z in (0.0, 0.005, 0.01, 0.02, 0.05, 0.1)
    ]  # fmt: skip
    return {
        "stiffness": k, "angle": over_angle, "force": over_force, "slenderness": over_slenderness,
        "material": over_material, "damping": over_damping, "peak": peak_ratio(steel),
        "half-infinite": half_infinite_error(steel),
    }  # fmt: skip


def half_infinite_error(bar: Bar) -> list[dict[str, float]]:
    """Return the relative difference of a finite and a half-infinite bar over the growth rate."""
    rows = []
    for p in (10.0, 100.0, 1000.0, 1e4, 1e5):
        near, far = euler_bernoulli(bar)(np.array([p])), half_infinite(bar)(np.array([p]))
        across, along = (float(f[0] / n[0] - 1) for n, f in zip(near, far, strict=True))
        rows.append({"rate": p, "across": across, "along": along})
    return rows


def runs(names: Sequence[str], frictions: Sequence[float]) -> dict[str, Any]:
    """Return nonlinear runs over modes and friction, approach velocity and damping."""
    table = [motion(n, mu) for n in names for mu in frictions]
    last = names[-1]
    approach = [
        {"y_A_dot": -v, **motion(n, mu, y_A_dot=-v)}
        for v in (0.01, 0.1, 1.0) for mu in (0.7, 1.4) for n in ("rod", *names[-2:])
    ]  # fmt: skip
    damped = [{"zeta": z, **motion(last, 0.9, zeta=z)} for z in (0.0, 0.01, 0.05)]
    critical = [
        {"model": n, "mu": mu, "force": critical_force(n, mu, theta_dot=5.0)}
        for mu in (0.9, 1.1, 1.4) for n in names
    ]  # fmt: skip
    return {"friction": table, "approach": approach, "damping": damped, "critical": critical}


def oracle(elements: Sequence[int], names: Sequence[str], mu: float = 1.2) -> dict[str, Any]:
    """Return slip stops of the chain of particles and of `rod-bending`, half a metre of steel."""
    bar = bench("steel")
    rows: dict[str, Any] = {"mu": mu, "chain": [], "modes": []}
    for speed in (1.0, 0.05):
        for n in elements:
            rows["chain"].append({"speed": speed, **chain(mu, n, 0.003, bar=bar, speed=speed)})
        for name in names:
            run = simulator(name).run(
                SLIDING | {"x_A_dot": -speed}, t_end=0.003, until="slip_stop",
                parameters={"mu": mu, **parameters_of(bar)},
            )  # fmt: skip
            stops = [e.time for e in run.events_of("slip_stop")]
            row = {"speed": speed, "model": name, "slip_stop": stops[0] if stops else None}
            rows["modes"].append(row)
    return rows


def study(quick: bool) -> dict[str, Any]:
    """Return all numbers of the study."""
    names, frictions = (("rod", "1,0"), (0.9,)) if quick else (MODELS, FRICTION)
    elements = (8,) if quick else (8, 16, 32, 64)
    law = ps.law("bilinear-hertz")
    n = next(p.default for p in law.parameters if p.name == "n")
    return {
        "computed": {
            "version": ps.__version__,
            "law": law.name,
            "n": float(n),
            "modes": "all where not named",
        },
        "thresholds": thresholds(),
        "runs": runs(names, frictions),
        "oracle": oracle(elements, ("1,0",) if quick else ("2,0", "4,1", "8,2", "8,4", "16,2")),
    }


def milli(value: float | None) -> str:
    return "none" if value is None else f"{1e3 * value:.3f}"


def threshold_tables(data: dict[str, Any]) -> list[str]:
    """Return the page's tables of linear results."""
    names = ["rigid", "1,0", "4,1", "8,2", "20,20", "all", "Timoshenko"]
    angle = [[f"{r['theta']:.1f}", *(f"{r[n]:.4f}" for n in names)] for r in data["angle"]]
    force = [
        [r["force"], f"{float(r['stiffness']):.2e}",
         *(f"{r[n]:.4f}" for n in ("1,0", "4,1", "all")), f"{r['rate all']:.0f}"]
        for r in data["force"]
    ]  # fmt: skip
    slender = [
        [f"{r['slenderness']}", f"{r['length']:.2f}", f"{r['stiffness']:.2e}",
         f"{r['rigid up to']:.2e}", f"{r['all']:.4f}", f"{r['Timoshenko']:.4f}",
         f"{r['coupling']:.4f}", f"{r['peak ratio']:.2f}", f"{r['peak friction']:.4f}"]
        for r in data["slenderness"]
    ]  # fmt: skip
    material = [
        [r["material"], f"{r['mass']:.3f}", f"{r['stiffness']:.2e}", f"{r['rigid up to']:.2e}",
         f"{r['frequency'] / (2 * math.pi):.0f}", f"{r['all']:.4f}", f"{r['coupling']:.4f}"]
        for r in data["material"]
    ]  # fmt: skip
    damping = [
        [f"{r['damping']:g}", f"{r['divergence']:.4f}", f"{r['coupling']:.4f}"]
        for r in data["damping"]
    ]
    return [
        table(["θ, rad", "rigid", "1,0", "4,1", "8,2", "20,20", "all modes", "Timoshenko"], angle),
        table(["force, N", "k, N/m", "1,0", "4,1", "all modes", "its p, 1/s"], force),
        table(["L/d", "L, m", "k, N/m", "k*, N/m", "divergence", "Timoshenko", "coupling",
               "largest G_b/G_a", "least of all"], slender),
        table(["material", "m, kg", "k, N/m", "k*, N/m", "ω₁/2π, Hz", "divergence",
               "coupling"], material),
        table(["ζ", "divergence", "coupling"], damping),
    ]  # fmt: skip


def run_tables(data: dict[str, Any]) -> list[str]:
    """Return the page's tables of nonlinear runs."""

    def cells(r: dict[str, Any]) -> list[str]:
        return [milli(r["slip_stop"]), f"{r['peak_force']:.0f}"]

    def both(stop: str, peak: str) -> str:
        return f"{stop}, {peak} N" if stop == "none" else f"{stop} ms, {peak} N"

    models = list(dict.fromkeys(r["model"] for r in data["friction"]))
    frictions = list(dict.fromkeys(r["mu"] for r in data["friction"]))
    by_case = {(r["model"], r["mu"]): cells(r) for r in data["friction"]}
    friction = [[n, *(both(*by_case[n, mu]) for mu in frictions)] for n in models]
    balance = [
        [r["model"], milli(r["slip_stop"]), milli(r["separation"]), f"{r['rebound']:.4f}",
         *(f"{r[n]:.4f}" for n in ("friction", "plastic", "vibration"))]
        for r in data["friction"] if r["mu"] == 1.4
    ]  # fmt: skip
    approach = [
        [f"{-r['y_A_dot']:g}", f"{r['mu']}", r["model"], *cells(r), f"{r['rebound']:.4f}"]
        for r in data["approach"]
    ]
    force = {(r["model"], r["mu"]): r["force"] for r in data["critical"]}
    critical = [
        [n, *("none" if force[n, mu] is None else f"{force[n, mu]:.2f}" for mu in (0.9, 1.1, 1.4))]
        for n in models
    ]
    return [
        table(["modes", *(f"μ = {mu}" for mu in frictions)], friction),
        table(["modes", "slip stop, ms", "separation, ms", "rebound, m/s", "friction, J",
               "plastic, J", "vibration, J"], balance),
        table(["approach, m/s", "μ", "modes", "slip stop, ms", "peak, N", "rebound, m/s"],
              approach),
        table(["modes", "μ = 0.9", "μ = 1.1", "μ = 1.4"], critical),
    ]  # fmt: skip


def oracle_table(data: dict[str, Any]) -> str:
    """Return the page's table of the oracle: slip stops in ms for both slip velocities."""
    rows: dict[str, list[str]] = {}
    for kind in ("chain", "modes"):
        for r in data[kind]:
            name = f"chain of {r['elements']} links" if kind == "chain" else f"modes {r['model']}"
            rows.setdefault(name, [name]).append(f"{1e3 * r['slip_stop']:.5f}")
    return table(["model", "1 m/s", "0.05 m/s"], list(rows.values()))


def figure() -> Figure:
    """Return the figure: ratio of mobilities over the growth rate, and threshold over the angle."""
    steel = Bar()
    with rc_context(STYLE):
        drawn = Figure(figsize=(PAGE, COLUMN * 0.9), layout="constrained")
        left, right = drawn.subplots(1, 2)
        p = np.geomspace(3, 3e7, 200)
        curves = {"rigid": rigid, "Euler–Bernoulli, all modes": euler_bernoulli,
                  "half-infinite": half_infinite, "Timoshenko": timoshenko}  # fmt: skip
        for (name, form), color, dash in zip(curves.items(), PALETTE, DASHES, strict=False):
            across, along = form(steel)(p)
            left.plot(p, across / along, color=color, linestyle=dash, label=name)
        left.set(xscale="log", yscale="log", ylim=(0.3, 300), xlabel="growth rate $p$ (1/s)")
        left.set(ylabel="$G_b/G_a$", title="(a) mobility across over mobility along")
        left.legend(loc="upper right")
        k = contact(WEIGHT)[1]
        angles = np.linspace(0.5, 1.52, 60)
        forms = {"rigid": rigid(steel), "1 bending mode": modal(steel, 1, 0),
                 "4 bending, 1 axial": modal(steel, 4, 1),
                 "all modes": euler_bernoulli(steel)}  # fmt: skip
        for (name, g), color, dash in zip(forms.items(), PALETTE, DASHES, strict=False):
            values = [threshold(g, x, k)[0] for x in angles]
            right.plot(angles, values, color=color, linestyle=dash, label=name)
        limit = [threshold(euler_bernoulli(steel), x)[0] for x in angles]
        right.plot(angles, limit, color=REFERENCE, linewidth=0.8, label="all modes, rigid contact")
        right.plot(angles, 1 / np.tan(angles), ":", color=REFERENCE, label=r"$\cot\theta$")
        right.set(ylim=(0, 4.6), xlabel=r"$\theta$ (rad)", ylabel=r"threshold friction $\mu$")
        right.set_title("(b) friction from which sliding diverges")
        right.legend(loc="upper left")
    return drawn


def main() -> None:
    """Compute, write the files, print the main numbers."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few and short runs")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder")
    parser.add_argument("--draw", action="store_true", help="only draw the figure")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    if options.draw:
        save(figure(), options.out / "rigid-rod")
        return
    data = study(options.quick)
    text = json.dumps(data, indent=1, allow_nan=False) + "\n"
    (options.out / "rigid-rod.json").write_text(text, "utf-8")
    rows = data["thresholds"]["angle"]
    with (options.out / "thresholds.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    save(figure(), options.out / "rigid-rod")
    if not options.quick:
        texts = [*threshold_tables(data["thresholds"]), *run_tables(data["runs"])]
        (options.out / "tables.md").write_text(
            "\n\n".join([*texts, oracle_table(data["oracle"])]) + "\n", "utf-8"
        )
    print("theta   rigid    all modes   Timoshenko")
    for row in rows:
        print(
            f"{row['theta']:5.2f} {row['rigid']:8.4f} {row['all']:10.4f} {row['Timoshenko']:10.4f}"
        )
    peak = data["thresholds"]["peak"]
    print(f"largest ratio {peak['ratio']:.3f}: nothing diverges below mu = {peak['friction']:.4f}")


if __name__ == "__main__":
    main()
