"""An impact with frozen coefficients and a dashpot: exact for a linear one, else integrated."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from painleve_sym.arrays import Array
from painleve_sym.simulate.finite_stiffness.frozen_impact import FrozenEnd

MATRIX_EXPONENTIAL = "matrix exponential"
INTEGRATION = "integration"
RTOL, MAX_PHASES, MAX_STEPS = 1e-12, 12, 4000

Force = Callable[[float, float], float]
"""F_n(δ, δ̇); N."""
Guard = Callable[[float, Array], float]
"""Of the time since the start of the phase and (δ, δ̇, ∫F_n dt)."""
Guards = Mapping[str, Guard]
Start = tuple[float, float]
Found = tuple[str, float, Array]


@dataclass(frozen=True)
class DampedPhase:
    """One phase: ``slip`` −1, 0 (sticking) or +1; the rest at its end or over it, SI units."""

    slip: int
    loading: bool
    duration: float
    normal_impulse: float
    tangential_impulse: float
    compression: float
    compression_rate: float
    slip_velocity: float


@dataclass(frozen=True)
class DampedImpact:
    """Phases of the impact, how it ended, and ``matrix exponential`` or ``integration``."""

    phases: tuple[DampedPhase, ...]
    end: FrozenEnd
    method: str


@dataclass(frozen=True)
class _Ray:
    """δ̈ = −(a F + b), v̇_t = c F + d, F_t = ratio F + offset."""

    a: float
    b: float
    c: float
    d: float
    ratio: float
    offset: float


def _ray(w: Mapping[str, float], mode: int) -> _Ray:
    W_nn, W_nt, W_tt, b_n, b_t = (w[k] for k in ("W_nn", "W_nt", "W_tt", "b_n", "b_t"))
    if mode:
        ratio = -w["mu"] * mode
        return _Ray(W_nn + ratio * W_nt, b_n, W_nt + ratio * W_tt, b_t, ratio, 0.0)
    ratio, offset = -W_nt / W_tt, -b_t / W_tt
    return _Ray(W_nn + ratio * W_nt, b_n + offset * W_nt, 0.0, 0.0, ratio, offset)


def _departure(w: Mapping[str, float], F: float) -> int:
    pull = w["W_nt"] * F + w["b_t"]
    return 0 if abs(pull) <= w["mu"] * w["W_tt"] * F else (pull > 0) - (pull < 0)


class _Linear:
    """F = k δ + c δ̇: (δ, δ̇, P) is a matrix exponential of the time."""

    method = MATRIX_EXPONENTIAL

    def __init__(self, k: float, c: float) -> None:
        self.k, self.c = k, c

    def force(self, delta: float, rate: float) -> float:
        return self.k * delta + self.c * rate

    def first(self, ray: _Ray, start: Start, guards: Guards) -> Found | None:
        """Return the first guard that goes from + to −, when, and the motion there."""
        matrix = np.zeros((4, 4))
        matrix[0, 1] = 1.0
        matrix[1] = [-ray.a * self.k, -ray.a * self.c, 0.0, -ray.b]
        matrix[2] = [self.k, self.c, 0.0, 0.0]
        begin = np.array([*start, 0.0, 1.0])

        def along(guard: Guard) -> Callable[[float], float]:
            return lambda t: guard(t, (expm(matrix * t) @ begin)[:3])

        # Fine for the fastest motion at first; the slower ones come later.
        t, step = 0.0, 0.05 / float(np.abs(np.linalg.eigvals(matrix[:2, :2])).max())
        for _ in range(MAX_STEPS):
            to, hit = t + step, {}
            for name, guard in guards.items():
                at = along(guard)
                low = t if at(t) > 0 else 1e-6 * to
                if at(to) < 0 and (t == 0 or low == t) and at(low) > 0:
                    hit[name] = float(brentq(at, low, to, xtol=1e-300, rtol=1e-14))
            if hit:
                kind = min(hit, key=lambda name: hit[name])
                return kind, hit[kind], (expm(matrix * hit[kind]) @ begin)[:3]
            t, step = to, step * 1.1
            if not np.all(np.isfinite(expm(matrix * (t + step)))):
                break
        return None


class _Integrated:
    """Any F(δ, δ̇): integrated by DOP853 with located events."""

    method = INTEGRATION

    def __init__(self, force: Force, scale: tuple[float, float]) -> None:
        self.force, self.scale = force, scale

    def first(self, ray: _Ray, start: Start, guards: Guards) -> Found | None:
        """Return the first guard that goes from + to −, when, and the motion there."""

        def rate(_: float, y: Array) -> list[float]:
            F = self.force(y[0], y[1])
            return [y[1], -(ray.a * F + ray.b), F]

        events = [_terminal(guard) for guard in guards.values()]
        length, speed = self.scale
        found = solve_ivp(
            rate,
            (0.0, 1e6 * length / speed),
            [*start, 0.0],
            "DOP853",
            rtol=RTOL,
            atol=[1e-14 * length, 1e-14 * speed, 1e-300],
            events=events,
            first_step=1e-6 * length / speed,
        )
        for name, times in zip(guards, found.t_events, strict=True):
            if len(times):
                return name, float(times[0]), found.y[:, -1]
        return None


def _terminal(guard: Guard) -> Guard:
    def event(t: float, y: Array) -> float:
        return guard(t, y)

    event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
    return event


def damped_impact(
    coefficients: Mapping[str, float],
    slip_velocity: float,
    start: tuple[float, float],
    *,
    linear: tuple[float, float] | None = None,
    force: Force | None = None,
    scale: tuple[float, float] = (1.0, 1.0),
) -> DampedImpact:
    """Return an impact with frozen coefficients whose force has a dashpot.

    Parameters
    ----------
    coefficients : mapping
        W_nn, W_nt, W_tt (1/kg), b_n, b_t (m/s²), mu.
    slip_velocity : float
        m/s.
    start : (float, float)
        δ₀ ≥ 0 (m) and δ̇₀ (m/s).
    linear : (float, float), optional
        k and c of F = k δ + c δ̇: exact. Else `force` F(δ, δ̇) is integrated.
    scale : (float, float)
        Compression and its rate that the impact reaches, about; for the tolerances of integration.
    """
    law = _Linear(*linear) if linear is not None else _Integrated(_given(force), scale)
    w, (delta, rate), v = coefficients, start, slip_velocity
    F = law.force(delta, rate)
    mode = (v > 0) - (v < 0) if v else _departure(w, max(F, 0.0))
    phases: list[DampedPhase] = []
    if delta == 0 and rate <= 0 and (rate < 0 or -_ray(w, mode).b <= 0):
        return DampedImpact((), FrozenEnd.NO_IMPACT, law.method)
    end = FrozenEnd.STAYS
    while len(phases) < MAX_PHASES:
        ray = _ray(w, mode)
        push = -(ray.a * max(law.force(delta, rate), 0.0) + ray.b)
        loading = rate > 0 or (rate == 0 and push > 0)
        kind, phase = _phase(law, ray, w, (delta, rate, v), mode, loading)
        if phase is None:
            end = FrozenEnd.NO_END
            break
        phases.append(phase)
        delta, rate, v = phase.compression, phase.compression_rate, phase.slip_velocity
        F = max(law.force(delta, rate), 0.0)
        if kind == "release":
            end = FrozenEnd.SEPARATION
            break
        if kind == "slip":
            mode = _departure(w, F) if mode else _pull(w, F)
        elif mode == 0:
            mode = _departure(w, F)
    return DampedImpact(tuple(phases), end, law.method)


def _given(force: Force | None) -> Force:
    if force is None:
        raise ValueError("damped_impact: give linear or force")
    return force


def _pull(w: Mapping[str, float], F: float) -> int:
    pull = w["W_nt"] * F + w["b_t"]
    return (pull > 0) - (pull < 0)


def _phase(
    law: _Linear | _Integrated,
    ray: _Ray,
    w: Mapping[str, float],
    start: tuple[float, float, float],
    mode: int,
    loading: bool,
) -> tuple[str, DampedPhase | None]:
    """Follow one ray to its first event: ``release``, ``turn`` or ``slip``."""
    delta, rate, v = start

    def slip(t: float, y: Array) -> float:
        return v + ray.c * float(y[2]) + ray.d * t

    def margin(t: float, y: Array) -> float:
        if mode:
            return mode * slip(t, y)
        F = law.force(*y[:2])
        return w["mu"] * w["W_tt"] * F - abs(w["W_nt"] * F + w["b_t"])

    guards: dict[str, Guard] = {
        "release": lambda t, y: law.force(*y[:2]),
        "turn": lambda t, y: (1 if loading else -1) * float(y[1]),
        "slip": margin,
    }
    found = law.first(ray, (delta, rate), guards)
    if found is None:
        return "", None
    kind, t, y = found
    delta, rate, P = (float(x) for x in y)
    rate = 0.0 if kind == "turn" else rate
    v = 0.0 if mode == 0 or kind == "slip" else slip(t, y)
    P_t = ray.ratio * P + ray.offset * t
    return kind, DampedPhase(mode, loading, t, P, P_t, delta, rate, v)


def separating_rate(a: float, b: float, k: float, c: float, compression: float) -> float:
    """Return δ̇₀ on the separating surface of the indeterminate state, a < 0 < b, F = k δ + c δ̇.

    The stable direction of the equilibrium F = −b/a: faster approaches end in an impact without
    collision, slower ones lift off. With c = 0 and a force K δⁿ the energy integral says the same.

    References
    ----------
    Hogan & Kristiansen, Proc. R. Soc. A 473 (2017) 20160773.
    """
    root = math.sqrt((a * c) ** 2 - 4 * a * k)
    return (-a * c - root) / 2 * (compression + b / (a * k))
