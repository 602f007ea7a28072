"""Which measurement decides whether a sliding rod is rigid? Predictions with error bars.

Three models predict two experiments: steel bars dropped on a floor, and a rod of aluminium dropped
half a millimetre onto a moving belt. Every quantity with a tolerance is drawn from its interval;
medians and 95 % intervals of measurable quantities result. The two-link arm shows how its rebound
grows with the speed of its belt.

Run: python examples/studies/bench_rod/bench_rod.py [--quick] [--out FOLDER]
Writes bench-rod.json (all numbers), bench-rod.png, bench-rod.svg and tables.md.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp
from matplotlib.figure import Figure

import painleve_sym as ps
from painleve_sym.mechanics.bars import bending_modes
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.present.style import DASHES, PAGE, PALETTE, legend_entries, save, styled
from painleve_sym.tables import markdown_table as table

Interval = tuple[float, float]

SAMPLE = 400
SEED = 20
MODES, HALF = "16,8", "8,4"
"""Bending and axial modes of rods and bars, and half as many: what changes from half to all is the
error of truncation, printed beside a number. The chain of particles has a limit of its own."""
ORACLE_MODES = ("4,2", "8,4", "16,8")
G = 9.8

SPRUNG_TIP = """
name = "rod-sprung-tip"
title = "rod whose tip is held by a spring along the ground"
gravity = "g"

[coordinates]
x_A = { unit = "m", meaning = "position of the end A along the ground" }
y_A = { unit = "m", meaning = "height of the end A above the ground" }
theta = { unit = "rad", meaning = "angle from the ground to the rod" }
s = { unit = "m", meaning = "deflection of the tip along the ground" }

[parameters]
m = { default = 0.1, unit = "kg", meaning = "mass of the rod", positive = true }
l = { default = 0.5, unit = "m", meaning = "half length of the rod", positive = true }
m_tip = { default = 1e-4, unit = "kg", meaning = "mass of the tip", positive = true }
k_t = { default = 1e6, unit = "N/m", meaning = "stiffness along the ground", positive = true }
g = { default = 9.8, unit = "m/s^2", meaning = "gravity", lower = 0 }
mu = { default = 0.6, unit = "1", meaning = "friction coefficient", lower = 0 }

[[bodies]]
mass = "m"
inertia = "m*l**2/3"
angle = "theta"
centre = ["x_A + l*cos(theta)", "y_A + l*sin(theta)"]

[[bodies]]
mass = "m_tip"
centre = ["x_A + s", "y_A"]

[[springs]]
extension = "s"
stiffness = "k_t"

[[contacts]]
name = "A"
point = ["x_A + s", "y_A"]
friction = "mu"
"""
"""The hypothesis of a tangential spring in the contact; its tip has a thousandth of the mass."""
TIP = 1e-3

# ---- the bench rod: aluminium on an aluminium belt ----

ROD: Mapping[str, Interval] = {
    "length": (0.999, 1.001),
    "diameter": (5.95e-3, 6.05e-3),
    "theta": (1.19, 1.21),
    "theta_dot": (-0.1, 0.1),
    "gap": (4e-4, 6e-4),
    "belt": (0.98, 1.02),
    "restitution": (0.5, 0.9),
    "damping": (0.0, 0.01),
}
"""Intervals of what the bench sets; m, rad, rad/s, m/s. Restitution has no source for aluminium."""
FRICTION: Mapping[str, Interval] = {
    "0.3 ± 10 %": (0.27, 0.33),
    "0.6 ± 10 %": (0.54, 0.66),
    "0.9 ± 10 %": (0.81, 0.99),
    "1.2 ± 10 %": (1.08, 1.32),
}
WINDOW = 0.06
"""Time that is watched after the touchdown; s."""

# ---- dropped bars: steel on steel ----

BAR: Mapping[str, Interval] = {
    "diameter": (9.95e-3, 10.05e-3),
    "speed": (0.98, 1.02),
    "restitution": (0.55, 0.65),
}
LENGTHS = (0.06, 0.1, 0.2, 0.4)
ANGLES = tuple(np.round(np.arange(0.2, 1.51, 0.1), 1).tolist())
TABLE_ANGLES = (0.3, 0.6, 0.9, 1.2, 1.5)
"""Angles of the page's tables."""
EVENTS = 60


def pair_friction(name: str, other: str) -> Interval:
    """Return the range of sliding friction of two materials in the table."""
    pairs = ps.material(name).pairs
    (value,) = (p.sliding_friction for p in pairs if p.other == other)
    return value.lower, value.upper


class Draws:
    """Seeded draws from intervals, the same for every model that is compared.

    Parameters
    ----------
    material : str
        Its modulus and density are drawn from the ranges of the table.
    size : int
        Number of draws.
    """

    def __init__(self, material: str, size: int) -> None:
        self.random, self.size = np.random.default_rng(SEED), size
        values = ps.material(material).properties
        self.modulus, self.density = (
            self(values[n].lower, values[n].upper) for n in ("young_modulus", "density")
        )
        self.poisson = values["poisson_ratio"].value

    def __call__(self, low: float, high: float) -> Any:
        """Return draws that are uniform from `low` to `high`."""
        return self.random.uniform(low, high, self.size)

    def mass(self, length: Any, diameter: Any) -> Any:
        """Return masses of round bars, kg."""
        return self.density * np.pi / 4 * diameter**2 * length

    def parameters(self, model: str, length: Any, diameter: Any, damping: Any) -> dict[str, Any]:
        """Return the parameters of a model of a round bar with a hemispherical end."""
        mass = self.mass(length, diameter)
        common = {
            "m": mass, "l": length / 2, "E": self.modulus, "nu": self.poisson, "R": diameter / 2,
        }  # fmt: skip
        if model == "tangential":
            return common | {"m_tip": TIP * mass, "k_t": self.tangential_stiffness(diameter)}
        if model == "rigid":
            return common
        return common | {"rho": self.density, "Y": self.modulus, "zeta": damping}

    def tangential_stiffness(self, diameter: Any, force: float = 100.0) -> Any:
        """Return the stiffness of a Hertz contact along its surface without slip, N/m.

        2(1 - nu)/(2 - nu) of the normal one at the force, Johnson (1985), section 7.2.
        """
        effective = self.modulus / (2 * (1 - self.poisson**2))
        normal = (6 * effective**2 * diameter / 2 * force) ** (1 / 3)
        return 2 * (1 - self.poisson) / (2 - self.poisson) * normal


@cache
def mechanism(model: str) -> ps.Mechanism:
    """Return the mechanism of a hypothesis: rigid, tangential, or modes such as ``8,4``."""
    if model == "tangential":
        return mechanism_from_text(SPRUNG_TIP)
    return ps.model("rod" if model == "rigid" else f"rod-bending:{model}")


def law() -> ps.ContactLaw:
    """Return Hertz's law (n = 1.5) with the loss of an energetic restitution."""
    return ps.laws.bilinear_hertz()


def quantiles(values: Any) -> list[float] | None:
    """Return 2.5 %, 50 % and 97.5 % of finite values; None where a half or more is not finite."""
    finite = np.asarray(values, float)[np.isfinite(values)]
    if 2 * len(finite) <= np.size(values):
        return None
    return [float(q) for q in np.percentile(finite, (2.5, 50.0, 97.5))]


PLASTIC: Mapping[str, Interval] = {"strength": (95e6, 276e6), "restitution": (0.1, 0.7)}
"""Yield strength of the table's aluminium to that of a hard alloy, Pa, and what a yielding contact
gives back."""
HARDNESS = 2.8
"""Pressure of full plasticity over the yield strength; Johnson (1985), section 6.3."""


def with_plastic_contact(parameters: dict[str, Any], draws: Draws) -> dict[str, Any]:
    """Return the parameters with a plastic contact in place of Hertz's of aluminium on aluminium.

    Its force is 2π R H δ: the law K δⁿ with n = 1 and the length l_0 that makes K so large.
    """
    own = {name: draws(*interval) for name, interval in PLASTIC.items()}
    R, E, nu = (parameters[name] for name in ("R", "E", "nu"))
    K, elastic = 2 * np.pi * R * HARDNESS * own["strength"], 4 / 3 * E / (2 * (1 - nu**2)) * R**0.5
    return parameters | {"n": 1.0, "l_0": (K / elastic) ** 2, "e_energetic": own["restitution"]}


def first_yield(radius: float, modulus: float, poisson: float, strength: float) -> float:
    """Return the force from which a Hertz contact yields, N; Johnson (1985), section 6.1."""
    effective = modulus / (2 * (1 - poisson**2))
    return math.pi**3 * radius**2 * (1.6 * strength) ** 3 / (6 * effective**2)


def drag(
    model: str, friction: Interval, size: int = SAMPLE, plastic: bool = False, **change: Interval
) -> dict[str, Any]:
    """Return what a laboratory sees of the bench rod: quantiles over the draws.

    Parameters
    ----------
    model : str
        See `mechanism`.
    friction : tuple of float
        Interval of μ.
    plastic : bool
        Whether the contact is that of `with_plastic_contact`.
    **change : tuple of float
        Other intervals than those of `ROD`.
    """
    draws = Draws("aluminium", size)
    bench = {name: draws(*interval) for name, interval in (ROD | change).items()}
    parameters = draws.parameters(model, bench["length"], bench["diameter"], bench["damping"])
    parameters |= {"mu": draws(*friction), "e_energetic": bench["restitution"]}
    if plastic:
        parameters = with_plastic_contact(parameters, draws)
    runs = ps.simulate_batch(
        mechanism(model),
        law(),
        {
            "theta": bench["theta"], "theta_dot": bench["theta_dot"], "x_A_dot": -bench["belt"],
            "y_A_dot": -np.sqrt(2 * G * bench["gap"]),
        },
        parameters=parameters,
        t_end=WINDOW,
        maxima=("normal_force", "gap"),
        events=1,
    )  # fmt: skip
    leaves, stops = (runs[f"times_of_{kind}"][:, 0] for kind in ("separation", "slip_stop"))
    first = stops < leaves
    return {
        "model": model,
        "stops": float(np.mean(first)),
        "slip_stop": quantiles(np.where(first, stops, np.nan)),
        "contact": quantiles(leaves),
        "peak_force": quantiles(runs["max_normal_force"]),
        "rise": quantiles(runs["max_gap"]),
        "spin": quantiles(runs["theta_dot"]),
        "completed": runs.counts().get("t_end", 0),
    }  # fmt: skip


def with_round_end(model: str, radius: float) -> ps.Mechanism:
    """Return `rod-bending` whose end is a ball without mass: it touches one radius below the axis.

    The turning of the end, that of the rod and the slopes of its modes, moves the point of contact.
    """
    rod, theory = mechanism(model), rigid_rod()
    (contact,), rates = rod.contacts, {str(symbol): symbol for symbol in rod.system.q_dot}
    length = 2 * next(p.symbol for p in rod.system.parameters if p.name == "l")
    turning = rates["theta_dot"]
    for i, wave in enumerate(theory.wavenumbers(int(model.split(",")[0])), 1):
        ratio = (math.cosh(wave) - math.cos(wave)) / (math.sinh(wave) - math.sin(wave))
        turning -= sp.Float(2 * ratio * wave) / length * rates[f"w_{i}_dot"]
    slip = contact.slip_velocity + sp.Float(radius) * turning
    ball = ps.Contact(contact.name, rod.system, contact.gap, slip, contact.friction)
    return replace(rod, name="rod-with-round-end", contacts=(ball,), shapes=())


def round_end(model: str, mu: float = 0.6) -> list[dict[str, Any]]:
    """Return the bench rod at its middle values, with an end of radius 0 and with its round end."""
    middle = {name: sum(interval) / 2 for name, interval in ROD.items()}
    aluminium, radius = ps.material("aluminium"), middle["diameter"] / 2
    parameters = {
        "m": aluminium.density * math.pi * radius**2 * middle["length"], "l": middle["length"] / 2,
        "rho": aluminium.density, "Y": aluminium.young_modulus, "E": aluminium.young_modulus,
        "nu": aluminium.poisson_ratio, "R": radius, "e_energetic": middle["restitution"],
        "zeta": middle["damping"], "mu": mu,
    }  # fmt: skip
    start = {
        "theta": middle["theta"], "x_A_dot": -middle["belt"],
        "y_A_dot": -math.sqrt(2 * G * middle["gap"]),
    }  # fmt: skip
    rows = []
    for end, rod in (("radius 0", mechanism(model)), ("round", with_round_end(model, radius))):
        runs = ps.simulate_batch(
            rod, law(), {name: np.array([value]) for name, value in start.items()},
            parameters=parameters, t_end=WINDOW, maxima=("normal_force", "gap"), events=1,
        )  # fmt: skip
        rows.append({
            "end": end, "model": model, "slip_stop": float(runs["times_of_slip_stop"][0, 0]),
            "contact": float(runs["times_of_separation"][0, 0]),
            "peak_force": float(runs["max_normal_force"][0]), "rise": float(runs["max_gap"][0]),
        })  # fmt: skip
    return rows


def bending_period(length: float, diameter: float = 0.01) -> float:
    """Return the first bending period of a round bar of steel with free ends, s."""
    (mode,) = bending_modes(("free", "free"), 1)
    steel = ps.material("steel")
    speed = math.sqrt(steel.young_modulus / steel.density)
    return 2 * math.pi * length**2 / (float(mode.wavenumber) ** 2 * speed * diameter / 4)


def drop(model: str, length: float, theta: float, size: int = SAMPLE) -> dict[str, Any]:
    """Return restitution and contacts of a steel bar that falls without turning.

    Restitution is that of the tip of the rigid motion: of the velocity of the mass centre and the
    spin at the end, at the angle of the impact, without the fall since the touchdown.
    """
    draws = Draws("steel", size)
    diameter, speed, e = (draws(*BAR[name]) for name in ("diameter", "speed", "restitution"))
    lengths, angle = draws(length - 5e-4, length + 5e-4), draws(theta - 0.01, theta + 0.01)
    parameters = draws.parameters(model, lengths, diameter, np.zeros(size))
    mu = draws(*pair_friction("steel", "steel"))
    t_end = max(4 * bending_period(length), 1e-3)
    runs = ps.simulate_batch(
        mechanism(model), law(), {"theta": angle, "y_A_dot": -speed},
        parameters=parameters | {"mu": mu, "e_energetic": e}, t_end=t_end, events=EVENTS,
    )  # fmt: skip
    half = lengths / 2
    centre = runs["y_A_dot"] + half * np.cos(runs["theta"]) * runs["theta_dot"]
    tip = centre + G * t_end - half * np.cos(angle) * runs["theta_dot"]
    far = runs["y_A"] + lengths * np.sin(runs["theta"])
    leaves = runs["times_of_separation"]
    contacts = np.sum(np.isfinite(leaves), axis=1)
    return {
        "model": model,
        "length": length,
        "theta": theta,
        "restitution": quantiles(tip / speed),
        "contacts": quantiles(contacts),
        "duration": quantiles(np.nanmax(leaves, axis=1)),
        "far end": float(far.min()),
        "completed": runs.counts().get("t_end", 0),
    }


def arm(mu: float, belt: float) -> dict[str, float | None]:
    """Return the impact without collision of the two-link arm of steel on its belt.

    Lengths, masses and configuration are the named model's; those of the experiment are not public.
    """
    run = simulator().run(
        {"theta_1": -0.643501, "theta_2": -0.927295},
        t_end=0.1, until="separation", close="theta_1",
        parameters={"mu": mu, "u": -belt, "E": ps.material("steel").young_modulus},
    )  # fmt: skip
    stops = run.events_of("slip_stop")
    return {
        "mu": mu,
        "belt": belt,
        "slip_stop": stops[0].time if stops else None,
        "separation": float(run.t[-1]),
        "rebound": run.final["gap_dot"],
        "peak_force": float(max(run.values("normal_force", run.fine_times()))),
    }


@cache
def simulator() -> ps.Simulator:
    """Return the arm on a steel belt, made once."""
    return ps.Simulator(ps.model("two-link-arm"), ps.law("bilinear-hertz"))


@cache
def rigid_rod() -> Any:
    """Return the study `rigid_rod`, whose chain of particles is the oracle."""
    path = Path(__file__).parents[1] / "rigid_rod" / "rigid_rod.py"
    spec = importlib.util.spec_from_file_location("rigid_rod", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules.setdefault(spec.name, module)
    spec.loader.exec_module(module)
    return module


def oracle(elements: Sequence[int], counts: Sequence[str], mu: float = 0.6) -> list[dict[str, Any]]:
    """Return the first contact of the bench rod at its middle values: particles, and modes."""
    theory, aluminium = rigid_rod(), ps.material("aluminium")
    middle = {name: sum(interval) / 2 for name, interval in ROD.items()}
    length, diameter, theta = (middle[n] for n in ("length", "diameter", "theta"))
    approach = math.sqrt(2 * G * middle["gap"])
    mass = aluminium.density * math.pi / 4 * diameter**2 * length
    bar = theory.Bar(
        mass, length, aluminium.density, aluminium.young_modulus, aluminium.poisson_ratio
    )
    given = {"R": diameter / 2, "e_energetic": middle["restitution"]}
    rows = []
    for n in elements:
        events = theory.Chain(bar, n, mu, given).impact(
            1e-3, middle["belt"], theta, approach, until="separation"
        )
        (stop,) = (e["time"] for e in events if e["kind"] == "slip_stop")
        rows.append(
            {"model": f"chain of {n} links", "slip_stop": stop, "contact": events[-1]["time"],
             "peak_force": max(e["force"] for e in events), "v_y": events[-1]["v_y"],
             "spin": events[-1]["spin"]}
        )  # fmt: skip
    for count in counts:
        run = ps.simulate(
            mechanism(count), law(),
            {"theta": theta, "x_A_dot": -middle["belt"], "y_A_dot": -approach},
            parameters={**theory.parameters_of(bar), **given, "mu": mu},
            t_end=1e-3, until="separation",
        )  # fmt: skip
        end = run.final
        rows.append(
            {"model": name_of(count), "slip_stop": run.events_of("slip_stop")[0].time,
             "contact": run.final_time, "peak_force": max(e.normal_force for e in run.events),
             "v_y": end["y_A_dot"] + length / 2 * math.cos(end["theta"]) * end["theta_dot"],
             "spin": end["theta_dot"]}
        )  # fmt: skip
    return rows


def study(quick: bool) -> dict[str, Any]:
    """Return all numbers of the study."""
    size = 40 if quick else SAMPLE
    modes = "2,1" if quick else MODES
    half = "1,0" if quick else HALF
    models = ("rigid", "tangential", modes)
    full = pair_friction("aluminium", "aluminium")
    ranges = {"0.6 ± 10 %": FRICTION["0.6 ± 10 %"]} if quick else {
        f"{full[0]} to {full[1]}": full, **FRICTION
    }  # fmt: skip
    middle = FRICTION["0.6 ± 10 %"]
    # Modes of the short piece are 600 times as fast.
    controls: dict[str, tuple[dict[str, Interval], tuple[str, ...]]] = {
        "θ = 0.6": ({"theta": (0.59, 0.61)}, (half, modes)),
        "length 40 mm": ({"length": (0.0399, 0.0401)}, (half,) if quick else ("4,2", half)),
    }
    grid = np.array([0.3, 0.6]) if quick else np.round(np.arange(0.2, 1.41, 0.1), 1)
    lengths, angles = ((0.1,), (0.5, 1.5)) if quick else (LENGTHS, ANGLES)
    most = (half, modes) if quick else ("4,2", HALF, MODES, "20,10")
    shown_angles = angles if quick else TABLE_ANGLES
    counts = (half, modes) if quick else ("2,1", "4,2", HALF, "12,6", MODES)
    n = next(p.default for p in law().parameters if p.name == "n")
    return {
        "computed": {"version": ps.__version__, "law": law().name, "n": float(n), "modes": modes},
        "sample": size,
        "rod": [{"friction": n, **drag(m, f, size)} for n, f in ranges.items() for m in models],
        "controls": [
            {"control": name, **drag(m, middle, size, **change)}
            for name, (change, own) in controls.items() for m in (*models[:2], *own)
        ],
        "contacts": [
            {"contact law": "plastic", **drag(m, middle, size, plastic=True)}
            for m in ("rigid", modes)
        ],
        "modes": [drag(n, middle, size) for n in counts],
        "curve": [
            {"mu": float(mu), **drag(m, (mu, mu), size)}
            for m in models for mu in grid
        ],
        "bars": [
            drop(m, length, theta, size)
            for m in ("rigid", half, modes) for length in lengths for theta in angles
        ],
        "bar modes": [
            drop(m, LENGTHS[-1], theta, size) for m in most for theta in shown_angles
        ],
        "round end": [] if quick else round_end(HALF),
        "oracle": oracle((16,), (modes,)) if quick else oracle((32, 64, 128), ORACLE_MODES),
        "arm": [arm(mu, u) for mu in (0.6, 0.8, 1.0) for u in (0.25, 0.5, 1.0, 2.0)],
    }  # fmt: skip


# ---- tables and figure ----


def interval(values: Sequence[float] | None, unit: float = 1.0, digits: int = 2) -> str:
    """Return a median and its interval in a unit."""
    if values is None:
        return "none"
    low, middle, high = (f"{v / unit:.{digits}f}" for v in values)
    return f"{middle} ({low} to {high})"


def name_of(model: str) -> str:
    """Return what the page calls a model."""
    return model if model in ("rigid", "tangential") else f"bending {model}"


def rod_rows(rows: Sequence[Mapping[str, Any]], key: str, left: Any = None) -> list[list[str]]:
    """Return the lines of a table of the bench rod.

    `left` are the factors of `truncation`, by which intervals of bending rods are made longer.
    """

    def wider(row: Mapping[str, Any], name: str) -> Any:
        values = row[name]
        if not left or values is None or row["model"] != MODES:
            return values
        low, middle, high = values
        return min(low, low * left[name]), middle, max(high, high * left[name])

    return [
        [*([r[key]] if key else []), name_of(r["model"]), f"{100 * r['stops']:.0f} %",
         interval(wider(r, "slip_stop"), 1e-3), interval(wider(r, "contact"), 1e-3),
         interval(wider(r, "peak_force"), 1, 0), interval(wider(r, "rise"), 1e-3)]
        for r in rows
    ]  # fmt: skip


def truncation(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return by what results change from `MODES` to the chain's limit, as factors.

    The limit is that of order 2 from the two finest chains; a rise grows with the square of the
    velocity of the centre.
    """
    chains = [r for r in rows if r["model"].startswith("chain")][-2:]
    (own,) = [r for r in rows if r["model"] == name_of(MODES)]

    def of(name: str) -> float:
        coarse, fine = (r[name] for r in chains)
        return float((fine + (fine - coarse) / 3) / own[name])

    return {n: of(n) for n in ("slip_stop", "contact", "peak_force")} | {"rise": of("v_y") ** 2}


def tolerances() -> str:
    """Return the table of what the bench sets, with its tolerances."""
    aluminium = ps.material("aluminium").properties
    lines = [
        ("length", "length", "1 m", 1e3, "mm"),
        ("diameter, ends round", "diameter", "6 mm", 1e3, "mm"),
        ("angle θ to the belt", "theta", "1.2 rad", 1e3, "mrad"),
        ("turning rate", "theta_dot", "0 rad/s", 1.0, "rad/s"),
        ("gap before the fall", "gap", "0.5 mm", 1e3, "mm"),
        ("speed of the belt", "belt", "1 m/s", 1e3, "mm/s"),
        ("restitution of the contact", "restitution", "0.7", 1.0, ""),
        ("modal damping ζ", "damping", "0.005", 1.0, ""),
    ]
    rows = [
        [title, f"{value} ± {(ROD[name][1] - ROD[name][0]) / 2 * unit:.3g} {text}".strip()]
        for title, name, value, unit, text in lines
    ]
    for title, name, unit, text in (
        ("Young's modulus", "young_modulus", 1e9, "GPa"), ("density", "density", 1.0, "kg/m³"),
    ):  # fmt: skip
        value = aluminium[name]
        rows.append([title, f"{value.lower / unit:g} to {value.upper / unit:g} {text}"])
    return table(["quantity", "value and tolerance"], rows)


def tables(data: Mapping[str, Any]) -> list[str]:
    """Return the tables of the page."""
    head = ["model", "slip stops", "slip stop, ms", "first contact, ms", "peak force, N",
            "rise of the tip, mm"]  # fmt: skip
    left = truncation(data["oracle"])
    rows = {(r["model"], r["length"], r["theta"]): r for r in (*data["bars"], *data["bar modes"])}

    def bar(model: str, length: float, theta: float) -> str:
        """Return restitution, for all modes with the error of truncation, and contacts."""
        r = rows[model, length, theta]
        error = truncation_of_bar(rows, length, theta) if model == MODES else None
        text = interval(r["restitution"]) + ("" if error is None else f" ± {error:.3f}")
        return f"{text}; {r['contacts'][1]:.0f}"

    angles = [f"θ = {a}" for a in TABLE_ANGLES]
    drops = [["rigid", *(bar("rigid", LENGTHS[-1], a) for a in TABLE_ANGLES)]]
    drops += [[f"{1e3 * n:.0f} mm", *(bar(MODES, n, a) for a in TABLE_ANGLES)] for n in LENGTHS]
    counts = list(dict.fromkeys(r["model"] for r in data["bar modes"]))
    converging = [[name_of(m), *(bar(m, LENGTHS[-1], a) for a in TABLE_ANGLES)] for m in counts]
    checked = [
        [r["model"], f"{1e3 * r['slip_stop']:.4f}", f"{1e3 * r['contact']:.4f}",
         f"{r['peak_force']:.1f}", f"{r['v_y']:.4f}", f"{r['spin']:.4f}"]
        for r in data["oracle"]
    ]  # fmt: skip
    belts = [
        [f"{r['mu']}", f"{r['belt']:g}",
         "none" if r["slip_stop"] is None else f"{1e3 * r['slip_stop']:.2f}",
         f"{1e3 * r['separation']:.2f}", f"{r['rebound']:.5f}", f"{r['rebound'] / r['belt']:.4f}",
         f"{r['peak_force']:.0f}"]
        for r in data["arm"]
    ]  # fmt: skip
    return [
        table(["bar", *angles], drops),
        table(["model", *angles], converging),
        table(["μ", "belt, m/s", "slip stop, ms", "separation, ms", "rebound, m/s",
               "rebound/belt", "peak force, N"], belts),
        table(["μ", *head], rod_rows(data["rod"], "friction", left)),
        table(["control", *head], rod_rows(data["controls"], "control", left)),
        table(["contact", *head], rod_rows(data["contacts"], "contact law", left)),
        table(head, rod_rows(data["modes"], "")),
        tolerances(),
        table(["end", "model", "slip stop, ms", "first contact, ms", "peak force, N",
               "rise of the tip, mm"], [
            [r["end"], name_of(r["model"]), f"{1e3 * r['slip_stop']:.3f}",
             f"{1e3 * r['contact']:.3f}", f"{r['peak_force']:.0f}", f"{1e3 * r['rise']:.2f}"]
            for r in data["round end"]
        ]),
        table(["model", "slip stop, ms", "contact, ms", "peak force, N", "centre upwards, m/s",
               "spin, rad/s"], checked),
    ]  # fmt: skip


def truncation_of_bar(rows: Mapping[Any, Any], length: float, theta: float) -> float:
    """Return by how much the median restitution changes from `HALF` its modes to `MODES`."""
    half, all_modes = (rows[m, length, theta]["restitution"][1] for m in (HALF, MODES))
    return float(abs(all_modes - half))


@styled
def figure(data: Mapping[str, Any]) -> Figure:
    """Return the figure: restitution of bars over the angle, rise of the rod over friction.

    Each model has a panel of its own: the median, and a band with 95 % of the samples.
    """
    series: dict[tuple[str, float], list[Any]] = {}
    for r in data["bars"]:
        series.setdefault((r["model"], r["length"]), []).append(r)
    most = data["bars"][-1]["model"]
    bars = {key: rows for key, rows in series.items() if key[0] == most}
    rigid = series["rigid", max(length for _, length in series)]
    models = list(dict.fromkeys(r["model"] for r in data["curve"]))
    drawn = Figure(figsize=(PAGE, 4.4), layout="constrained")
    above, below = drawn.subfigures(2, 1)
    top = above.subplots(1, len(bars), sharey=True, squeeze=False)[0]
    bottom = below.subplots(1, len(models), sharey=True, squeeze=False)[0]

    def band(axes: Any, x: Any, rows: Sequence[Any], color: str, label: str) -> None:
        low, middle, high = np.array(rows).T
        axes.fill_between(
            x, low, high, color=color, alpha=0.25, linewidth=0, label="95 % of samples"
        )
        axes.plot(x, middle, color=color, label=label)

    for axes, rows in zip(top, bars.values(), strict=True):
        angles = [r["theta"] for r in rigid]
        level = [np.mean(part) for part in np.array([r["restitution"] for r in rigid]).T]
        for value, dash in zip(level, (DASHES[3], DASHES[1], DASHES[3]), strict=True):
            name = "rigid bar, median and 95 %" if dash == DASHES[1] else "_"
            axes.plot([angles[0], angles[-1]], [value] * 2, color="black", linewidth=0.8,
                      linestyle=dash, label=name)  # fmt: skip
        values = [r["restitution"] for r in rows]
        band(axes, [r["theta"] for r in rows], values, PALETTE[1], "elastic bar, median")
        axes.set(xlabel=r"$\theta$ (rad)", ylim=(0, 1))
    top[0].set_ylabel("coefficient of restitution")
    for letter, axes, (_, length) in zip("abcd", top, bars, strict=False):
        axes.set_title(f"({letter}) bar of {1e3 * length:.0f} mm")
    legend = dict(reversed(legend_entries([top[0]]).items()))
    above.legend(legend.values(), legend.keys(), loc="outside lower center", ncols=3)
    for letter, axes, model in zip("efg", bottom, models, strict=False):
        rows = [r for r in data["curve"] if r["model"] == model]
        values = [np.array(r["rise"]) * 1e3 for r in rows]
        band(axes, [r["mu"] for r in rows], values, PALETTE[1], "median")
        axes.set(yscale="log", xlabel=r"$\mu$", title=f"({letter}) rod on a belt, {name_of(model)}")
    bottom[0].set_ylabel("rise of the tip (mm)")
    return drawn


def main() -> None:
    """Compute, write the files, print the main numbers."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few and short runs")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder")
    parser.add_argument("--draw", action="store_true", help="draw the kept numbers again")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    if options.draw:
        kept = json.loads(Path(__file__).with_name("bench-rod.json").read_text("utf-8"))
        save(figure(kept), options.out / "bench-rod")
        return
    data = study(options.quick)
    (options.out / "bench-rod.json").write_text(
        json.dumps(data, indent=1, allow_nan=False) + "\n", "utf-8"
    )
    save(figure(data), options.out / "bench-rod")
    if not options.quick:
        (options.out / "tables.md").write_text("\n\n".join(tables(data)) + "\n", "utf-8")
    print("rise of the bench rod's tip in mm: median and 95 % interval at μ = 0.6 ± 10 %")
    for row in data["rod"]:
        if row["friction"] == "0.6 ± 10 %":
            print(f"{name_of(row['model']):12s} {interval(row['rise'], 1e-3)}")


if __name__ == "__main__":
    main()
