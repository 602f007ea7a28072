"""When does a bar jam that slides? Motion of its modes at a frozen angle, for many bars at once.

A bar touches the ground, unloaded, and slides. The least friction from which its slip stops before
it first separates is its *landing*: an impact without collision. Modes of free ends with closed
wavenumbers, a contact F = K δⁿ, Runge–Kutta's method; nothing of it is shared with the package.

Run: python examples/studies/rigid_rod/landing.py [--quick] [--draw] [--out FOLDER]
Writes landing.json (all numbers), landing.png, landing.svg, landing-maps.png and landing-maps.svg.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from painleve_sym.present.style import COLUMN, DASHES, PAGE, PALETTE, REFERENCE, STYLE, save

G = 9.8
FINEST = 0.5
"""Largest ω h of a step, with ω the fastest mode."""
LONGEST = 0.03
"""A contact that neither stops nor separates within this time is none of both; s."""


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


@dataclass(frozen=True)
class Contact:
    """A contact F = K δⁿ whose unloading gives back e² of the work, by default all of it."""

    K: float
    n: float = 1.5
    e: float = 1.0

    def force(self, depth: Any, deepest: Any) -> Any:
        """Return the force at a compression; the largest one before is `deepest`."""
        loading = self.K * np.maximum(depth, 0.0) ** self.n
        if self.e == 1.0:
            return loading
        plastic = deepest * (1 - self.e**2)
        back = self.K * (np.maximum(depth - plastic, 0.0) / self.e**2) ** self.n
        return np.where(depth < deepest, back, loading)


class Modes:
    """Rigid motion and natural modes of a bar with free ends: frequencies and values of the end.

    Across the bar the first is rigid, of end value 2, since turning takes part; along it 1.
    """

    def __init__(self, bar: Any, bending: int, axial: int) -> None:
        across, along = bar.frequencies(bending, axial)
        self.mass = bar.mass
        self.rates = np.concatenate([[0.0], across, [0.0], along])
        self.across = np.arange(len(self.rates)) <= bending
        self.ends = np.where(self.across, 2.0, math.sqrt(2))
        self.ends[1 + bending] = 1.0

    def rows(self, theta: Any, mu: Any) -> tuple[Any, Any, Any]:
        """Return, by case, how the end moves up and to the right, and how its force acts.

        Its slip is to the left, so that friction acts to the right.
        """
        sin, cos, mu = (np.atleast_1d(x)[:, None] for x in (np.sin(theta), np.cos(theta), mu))
        normal = np.where(self.across, cos, sin) * self.ends
        along = np.where(self.across, -sin, cos) * self.ends
        return normal, along, normal + mu * along


def slide(
    modes: Modes,
    contact: Contact,
    theta: Any,
    mu: Any,
    speed: Any,
    *,
    approach: float = 0.0,
    damping: float = 0.0,
    window: float = LONGEST,
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
    window : float
        s.
    bounces : bool
        Whether a motion continues after the first separation.

    Returns
    -------
    dict of str to ndarray
        ``stop`` and ``separation`` (s, nan where there is none) and ``peak`` (N).
    """
    theta, mu, speed = (np.array(x, float).ravel() for x in np.broadcast_arrays(theta, mu, speed))
    normal, along, push = modes.rows(theta, mu)
    count = len(theta)
    stop, leave = np.full(count, np.nan), np.full(count, np.nan)
    peak, live = np.zeros(count), np.arange(count)
    q, p = np.zeros_like(normal), np.zeros_like(normal)
    deepest, square = np.zeros(count), modes.rates**2
    step = fineness / modes.rates.max() if modes.rates.max() > 0 else 1e-6
    step = min(step, window / 2000)

    def depth(t: float, q: Any) -> Any:
        return approach * t + G * t * t / 2 - np.einsum("ij,ij->i", q, normal)

    def rate(t: float, q: Any, p: Any) -> Any:
        force = contact.force(depth(t, q), deepest)
        pull = push * (force / modes.mass)[:, None] - square * q
        return pull - 2 * damping * modes.rates * p if damping else pull

    t, slip = 0.0, -speed
    touched = np.zeros(count, bool)
    while t < window and len(live):
        a = rate(t, q, p)
        q2, p2 = q + step / 2 * p, p + step / 2 * a
        b = rate(t + step / 2, q2, p2)
        q3, p3 = q + step / 2 * p2, p + step / 2 * b
        c = rate(t + step / 2, q3, p3)
        q4, p4 = q + step * p3, p + step * c
        d = rate(t + step, q4, p4)
        q, p = q + step / 6 * (p + 2 * p2 + 2 * p3 + p4), p + step / 6 * (a + 2 * b + 2 * c + d)
        t += step
        now = depth(t, q)
        deepest = np.where(now > 0, np.maximum(deepest, now), 0.0)
        force = contact.force(now, deepest)
        peak[live] = np.maximum(peak[live], force)
        new = -speed + np.einsum("ij,ij->i", p, along)
        stopped = (new >= 0) & (force > 0)
        stop[live[stopped]] = t - step * new[stopped] / (new - slip)[stopped]
        touched |= force > 0
        parted = touched & (force == 0) & np.isnan(leave[live])
        leave[live[parted]] = t
        slip = new
        ended = stopped | (parted & (not bounces))
        if ended.any():
            keep = ~ended
            live, q, p, speed, slip = live[keep], q[keep], p[keep], speed[keep], slip[keep]
            normal, along, push = normal[keep], along[keep], push[keep]
            deepest, touched = deepest[keep], touched[keep]
    return {"stop": stop, "separation": leave, "peak": peak}


def landing(
    modes: Modes, contact: Contact, theta: Any, speed: Any, steps: int = 15, **options: Any
) -> Any:
    """Return, by case, the least friction from which the slip stops in the first contact.

    By bisection between 0.02 and 4, to 4/2^steps.
    """
    theta, speed = (np.array(x, float) for x in np.broadcast_arrays(theta, speed))
    low, high = np.full(theta.shape, 0.02), np.full(theta.shape, 4.0)
    for _ in range(steps):
        middle = (low + high) / 2
        times = slide(modes, contact, theta, middle, speed, **options)["stop"]
        stops = ~np.isnan(times).reshape(theta.shape)
        low, high = np.where(stops, low, middle), np.where(stops, middle, high)
    return high
