"""Simulate Painlevé's rod with a compliant contact, by hand and with SciPy alone.

This module is the test oracle: it shares no code with the package it checks. The motion is written
as Newton-Euler equations about the centre of mass, integrated by SciPy's DOP853 one step at a time,
and every change of mode is located on the step and then polished by integrating up to it.

Conventions
-----------
The rod has length 2 l, mass m, J = m l^2 / 3 and makes the angle theta with the ground y = 0. The
contact end is A = (x - l cos(theta), y - l sin(theta)). F_n >= 0 pushes the rod up; F_t acts along
+x, so slipping left (x_A_dot < 0) means F_t = +mu F_n. The compression is delta = -y_A where that
is positive.

References
----------
Impact model resolution on Painlevé's paradox, equations (4)-(6) for the contact
force and the sticking friction of section 3.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853
from scipy.optimize import brentq

Array = NDArray[np.float64]
Guard = Callable[[Array], float]

# The order of the integrated states. The centre of mass carries Newton-Euler; the four contact
# states repeat its information so that the gap never comes from a difference of large numbers.
X, Y, TH, VX, VY, OM, X_A, V_T, Y_A, V_N = range(10)

#: What `RodEvent.kind` can be.
KINDS = (
    "slip_stop",
    "slip_start",
    "max_compression",
    "reload",
    "yield",
    "separation",
    "touchdown",
)

# Points of the dense output at which guards are looked at in each step: two crossings closer than a
# sixteenth of a step, which the error control keeps well inside one oscillation, would be missed.
_SAMPLES = 16


@dataclass(frozen=True)
class Rod:
    """Hold the parameters of the rod and of its contact.

    The stiffness is ``K = 4/3 E_star sqrt(R)`` with ``1/E_star = 2 (1 - nu^2) / E``.

    Attributes
    ----------
    m, l, g : float
        Mass (kg), half length (m), gravity (m/s^2).
    mu : float
        Friction coefficient, static and kinetic alike.
    n : float
        Exponent of the compression law.
    K : float
        Contact stiffness, N/m^n.
    e : float
        Energetic coefficient of restitution, in (0, 1].
    reload : str
        ``"virgin"`` or ``"elastic"``.
    """

    m: float
    l: float
    g: float
    mu: float
    n: float
    K: float
    e: float
    reload: str

    @property
    def J(self) -> float:
        """Return the moment of inertia about the centre of mass, kg m^2."""
        return self.m * self.l**2 / 3.0


@dataclass(frozen=True)
class RodEvent:
    """Record one change of mode.

    Attributes
    ----------
    time : float
        Seconds.
    kind : str
        One of `KINDS`. ``slip_stop``: the slip velocity reaches zero, to stick or to reverse.
        ``reload``: the compression starts to grow again after unloading. ``yield``: an elastic
        reload passes the old maximum and rejoins the virgin curve. ``touchdown``: contact made
        from flight, at zero gap or, under the elastic rule, at delta_p of the indentation.
    state : dict of str to float
        ``x_A``, ``x_A_dot``, ``y_A``, ``y_A_dot``, ``theta``, ``theta_dot``.
    F_n, F_t : float
        Contact forces just after the event, N.
    F_n_before, F_t_before : float
        Contact forces just before the event, N.
    delta : float
        Compression, m; 0 where the gap is open.
    mode : tuple of str
        Normal branch and tangential mode just after the event.
    """

    time: float
    kind: str
    state: dict[str, float]
    F_n: float
    F_t: float
    F_n_before: float
    F_t_before: float
    delta: float
    mode: tuple[str, str]


class RodRun(NamedTuple):
    """Return value of `simulate`.

    Attributes
    ----------
    events : list of RodEvent
        In order of time.
    final : dict of str to float
        The state where the run stopped, with ``t``, ``F_n``, ``F_t`` and ``delta``, and the
        centre of mass as ``x``, ``x_dot``, ``y``, ``y_dot``.
    mode : tuple of str
        Normal branch and tangential mode of the final state.
    stop : str
        ``"t_end"``, ``"max_events"`` or the kind of event asked for by `until`.
    """

    events: list[RodEvent]
    final: dict[str, float]
    mode: tuple[str, str]
    stop: str


@dataclass(frozen=True)
class Mode:
    """Name the equations that hold between two events.

    Attributes
    ----------
    normal : str
        ``"virgin"`` (F_n = K delta^n), ``"unloading"`` (equation (5), in either direction under
        the elastic rule) or ``"free"`` (F_n = 0).
    tangent : str
        ``"left"``, ``"right"``, ``"stick"``; ``"free"`` without contact.
    delta_max : float
        Largest compression of the current indentation, m; 0 on a virgin surface.
    """

    normal: str
    tangent: str
    delta_max: float = 0.0


def stiffness(E: float, nu: float, R: float) -> float:
    """Return the contact stiffness K_e of the rod's end on a ground of the same material.

    Parameters
    ----------
    E : float
        Elastic modulus, N/m^2.
    nu : float
        Poisson's ratio.
    R : float
        Radius of the contact end, m; it is R* too, as the paper's initial forces require.

    Returns
    -------
    float
        K_e in N/m^n.
    """
    return 4.0 / 3.0 * E / (2.0 * (1.0 - nu**2)) * math.sqrt(R)


def compression_for_force(F_n: float, E: float, nu: float, R: float, n: float) -> float:
    """Return the virgin compression that carries the normal force `F_n`.

    Parameters
    ----------
    F_n : float
        Normal force, N.
    E, nu, R, n : float
        As in `simulate`.

    Returns
    -------
    float
        delta in m.
    """
    return (F_n / stiffness(E, nu, R)) ** (1.0 / n)


def permanent(rod: Rod, mode: Mode) -> float:
    """Return the permanent compression delta_p of equation (6), m."""
    return mode.delta_max * (1.0 - rod.e**2)


def normal_force(rod: Rod, mode: Mode, y_A: float) -> float:
    """Return F_n of equation (4) or (5), or zero without contact, N."""
    if mode.normal == "free":
        return 0.0
    if mode.normal == "virgin":
        return rod.K * max(-y_A, 0.0) ** rod.n
    delta_p = permanent(rod, mode)
    ratio = max(-y_A - delta_p, 0.0) / (mode.delta_max - delta_p)
    return rod.K * mode.delta_max**rod.n * ratio**rod.n


def sticking_friction(rod: Rod, theta: float, omega: float, F_n: float) -> float:
    """Return the friction that keeps the acceleration of A along the ground at zero, N."""
    s, c = math.sin(theta), math.cos(theta)
    return (3.0 * s * c * F_n - rod.m * rod.l * omega**2 * c) / (1.0 + 3.0 * s * s)


def friction(rod: Rod, mode: Mode, u: Array, F_n: float) -> float:
    """Return F_t of the current tangential mode, N."""
    if mode.tangent == "left":
        return rod.mu * F_n
    if mode.tangent == "right":
        return -rod.mu * F_n
    if mode.tangent == "stick":
        return sticking_friction(rod, float(u[TH]), float(u[OM]), F_n)
    return 0.0


def field(rod: Rod, mode: Mode, u: Array) -> Array:
    """Return the time derivative of the ten states in one mode.

    Parameters
    ----------
    rod : Rod
    mode : Mode
    u : ndarray, shape (10,)

    Returns
    -------
    ndarray, shape (10,)
    """
    theta, omega = float(u[TH]), float(u[OM])
    s, c = math.sin(theta), math.cos(theta)
    F_n = normal_force(rod, mode, float(u[Y_A]))
    F_t = friction(rod, mode, u, F_n)
    ax = F_t / rod.m
    ay = F_n / rod.m - rod.g
    # The lever arm from the centre of mass to A is (-l c, -l s).
    alpha = rod.l * (s * F_t - c * F_n) / rod.J
    slip_acceleration = ax + rod.l * (alpha * s + omega * omega * c)
    gap_acceleration = ay - rod.l * (alpha * c - omega * omega * s)
    v_t = float(u[V_T])
    if mode.tangent == "stick":
        # Zero by the choice of F_t; written as zero so that rounding cannot make A creep.
        v_t, slip_acceleration = 0.0, 0.0
    return np.array(
        [
            u[VX],
            u[VY],
            omega,
            ax,
            ay,
            alpha,
            v_t,
            slip_acceleration,
            u[V_N],
            gap_acceleration,
        ]
    )


def guards(rod: Rod, mode: Mode) -> list[tuple[str, Guard]]:
    """List the conditions that must stay non-negative for the mode to hold.

    Parameters
    ----------
    rod : Rod
    mode : Mode

    Returns
    -------
    list of (str, callable)
        The name of the guard and its value as a function of the state.
    """
    margins: list[tuple[str, Guard]] = []
    if mode.tangent == "left":
        margins.append(("slip_stop", lambda u: -float(u[V_T])))
    elif mode.tangent == "right":
        margins.append(("slip_stop", lambda u: float(u[V_T])))
    elif mode.tangent == "stick":

        def margin(u: Array, sign: float) -> float:
            F_n = normal_force(rod, mode, float(u[Y_A]))
            return rod.mu * F_n - sign * friction(rod, mode, u, F_n)

        margins.append(("slip_left", lambda u: margin(u, 1.0)))
        margins.append(("slip_right", lambda u: margin(u, -1.0)))
    delta_p = permanent(rod, mode)
    if mode.normal == "virgin":
        margins.append(("max_compression", lambda u: -float(u[V_N])))
    elif mode.normal == "unloading":
        margins.append(("separation", lambda u: -float(u[Y_A]) - delta_p))
        if rod.reload == "elastic":
            margins.append(("yield", lambda u: float(u[Y_A]) + mode.delta_max))
        else:
            margins.append(("reload", lambda u: float(u[V_N])))
    elif mode.delta_max > 0.0:
        # The end is inside the indentation it has left.
        margins.append(("clear", lambda u: -float(u[Y_A])))
        if rod.reload == "elastic":
            margins.append(("touchdown", lambda u: float(u[Y_A]) + delta_p))
        else:
            margins.append(("reload", lambda u: float(u[V_N])))
    else:
        margins.append(("touchdown", lambda u: float(u[Y_A])))
    return margins


def watched(rod: Rod, mode: Mode) -> list[tuple[str, Guard]]:
    """List the quantities whose change of sign is recorded but changes no equation."""
    if mode.normal == "unloading" and rod.reload == "elastic":
        return [("turn", lambda u: float(u[V_N]))]
    return []


def tangent_at(rod: Rod, mode: Mode, u: Array) -> str:
    """Return the tangential mode of a touching state, from the slip or, at rest, the friction."""
    v_t = float(u[V_T])
    if v_t != 0.0:
        return "left" if v_t < 0.0 else "right"
    F_n = normal_force(rod, mode, float(u[Y_A]))
    needed = sticking_friction(rod, float(u[TH]), float(u[OM]), F_n)
    if abs(needed) <= rod.mu * F_n:
        return "stick"
    # More friction along +x needed than there is: the end is left behind, towards -x.
    return "left" if needed > 0.0 else "right"


def contact_from_turn(rod: Rod, u: Array) -> Mode:
    """Return the mode of a touching state at rest in the normal direction.

    The virgin curve holds if the compression grows from here; otherwise this is its largest
    compression and restitution starts.
    """
    delta = -float(u[Y_A])
    virgin = Mode("virgin", "free", 0.0)
    virgin = Mode("virgin", tangent_at(rod, virgin, u))
    if field(rod, virgin, u)[V_N] < 0.0:
        return virgin
    return Mode("unloading", virgin.tangent, delta) if delta > 0.0 else Mode("free", "free")


def initial_mode(rod: Rod, u: Array) -> Mode:
    """Return the mode that starts from an initial state."""
    delta, v_n = -float(u[Y_A]), float(u[V_N])
    if delta < 0.0:
        return Mode("free", "free")
    if v_n == 0.0:
        return contact_from_turn(rod, u)
    if v_n < 0.0:
        return Mode("virgin", tangent_at(rod, Mode("virgin", "free"), u))
    if delta == 0.0:
        return Mode("free", "free")
    unloading = Mode("unloading", "free", delta)
    return Mode("unloading", tangent_at(rod, unloading, u), delta)


def after(rod: Rod, mode: Mode, name: str, u: Array) -> tuple[Mode, str, Array]:
    """Apply the event `name`: return the next mode, the public kind and the state.

    A state that the event puts at zero is put there exactly; the polished root already is within
    rounding of it.
    """
    u = u.copy()
    if name in ("slip_left", "slip_right"):
        return Mode(mode.normal, name[5:], mode.delta_max), "slip_start", u
    if name == "slip_stop":
        u[V_T] = 0.0
        return Mode(mode.normal, tangent_at(rod, mode, u), mode.delta_max), name, u
    if name == "max_compression":
        u[V_N] = 0.0
        return Mode("unloading", mode.tangent, -float(u[Y_A])), name, u
    if name == "reload":
        u[V_N] = 0.0
        return contact_from_turn(rod, u), name, u
    if name == "yield":
        u[Y_A] = -mode.delta_max
        return Mode("virgin", mode.tangent), name, u
    if name == "separation":
        u[Y_A] = -permanent(rod, mode)
        return Mode("free", "free", mode.delta_max), name, u
    if name == "clear":
        return Mode("free", "free"), "", u
    if name == "turn":
        kind = "reload" if field(rod, mode, u)[V_N] < 0.0 else "max_compression"
        u[V_N] = 0.0
        return mode, kind, u
    # Touchdown: on the virgin surface, or at delta_p of an indentation under the elastic rule.
    u[Y_A] = -permanent(rod, mode)
    touched = Mode("unloading" if mode.delta_max > 0.0 else "virgin", "free", mode.delta_max)
    return Mode(touched.normal, tangent_at(rod, touched, u), mode.delta_max), name, u


def _along(dense: Callable[[float], Array], g: Guard, sign: float) -> Callable[[float], float]:
    """Return a guard as a function of time on one step."""
    return lambda t: sign * g(dense(t))


def _bracket(
    value: Callable[[float], float], a: float, b: float, armed: bool
) -> tuple[float, float] | None:
    """Return two times in [a, b] between which a guard falls below zero, or None.

    A guard that starts at zero is armed by the first positive value. If the first sample is
    negative already, ever smaller times are tried, since it may have risen and fallen before; a
    guard that never rises fires at `a` itself.
    """
    before = a
    for k in range(1, _SAMPLES + 1):
        t = b if k == _SAMPLES else a + (b - a) * k / _SAMPLES
        now = value(t)
        if now < 0.0:
            if armed:
                return before, t
            for shrink in range(1, 40):
                early = a + (t - a) * 0.5**shrink
                if value(early) > 0.0:
                    return early, t
            return a, a
        armed = armed or now > 0.0
        before = t
    return None


def _root(value: Callable[[float], float], a: float, b: float) -> float:
    """Return the crossing on the dense output, or an end where rounding hides the change."""
    at_a, at_b = value(a), value(b)
    if a == b or at_a <= 0.0 or at_b >= 0.0:
        return a if abs(at_a) <= abs(at_b) else b
    return float(brentq(value, a, b, xtol=1e-300, rtol=1e-15))


class _Integrator:
    """Advance one mode until a guard fires."""

    def __init__(self, rod: Rod, rtol: float) -> None:
        self.rod = rod
        self.rtol = rtol
        # Scales of a resting contact: compression under the weight and the speed of its
        # oscillation. The atol sits a thousand times below rtol times them, so rtol decides.
        delta = (rod.m * rod.g / rod.K) ** (1.0 / rod.n)
        speed = math.sqrt(rod.n * rod.g * delta)
        scale = np.ones(10)
        scale[Y_A], scale[V_N] = delta, speed
        self.atol = 1e-3 * rtol * scale

    def _advance(self, mode: Mode, t0: float, u0: Array, t1: float) -> Array:
        """Return the state at `t1`, without dense output in between."""
        if t1 <= t0:
            return u0.copy()
        solver = self._solver(mode, t0, u0, t1, first_step=t1 - t0)
        while solver.status == "running":
            solver.step()
        if solver.status == "failed":
            raise RuntimeError(f"rod oracle, mode {mode}, t={solver.t}: step size underflow")
        return np.array(solver.y)

    def _solver(
        self, mode: Mode, t0: float, u0: Array, t1: float, first_step: float | None = None
    ) -> DOP853:
        return DOP853(
            lambda _t, u: field(self.rod, mode, u),
            t0,
            u0,
            t1,
            rtol=self.rtol,
            atol=self.atol,
            first_step=first_step,
        )

    def segment(
        self, mode: Mode, t0: float, u0: Array, t_end: float
    ) -> tuple[float, Array, str | None]:
        """Integrate `mode` from `t0`: return the time, the state and the guard that fired."""
        checks = [(name, g, 1.0) for name, g in guards(self.rod, mode)]
        for name, g in watched(self.rod, mode):
            start = g(u0) or float(field(self.rod, mode, u0)[V_N])
            checks.append((name, g, math.copysign(1.0, start)))
        armed = [sign * g(u0) > 0.0 for _, g, sign in checks]
        solver = self._solver(mode, t0, u0, t_end)
        while solver.status == "running":
            t_old, u_old = float(solver.t), np.array(solver.y)
            solver.step()
            if solver.status == "failed":
                raise RuntimeError(f"rod oracle, mode {mode}, t={solver.t}: step size underflow")
            # Every guard is sampled at the same times.
            t_new, dense = float(solver.t), cache(solver.dense_output())
            roots = []
            for index, (name, g, sign) in enumerate(checks):
                value = _along(dense, g, sign)
                bracket = _bracket(value, t_old, t_new, armed[index])
                if bracket is not None:
                    roots.append((_root(value, *bracket), name, g))
                armed[index] = armed[index] or value(t_new) > 0.0
            if roots:
                root, name, g = min(roots, key=lambda item: item[0])
                return *self._polish(mode, dense, g, root, t_old, u_old, t_new), name
        return float(solver.t), np.array(solver.y), None

    def _polish(
        self,
        mode: Mode,
        dense: Callable[[float], Array],
        g: Guard,
        root: float,
        t_old: float,
        u_old: Array,
        t_new: float,
    ) -> tuple[float, Array]:
        """Replace the dense output's root by the integrator's own, by Newton's method.

        The dense output is one order lower than the steps, and its error would dominate.
        """
        width = 1e-3 * (t_new - t_old)
        a, b = max(root - width, t_old), min(root + width, t_new)
        slope = (g(dense(b)) - g(dense(a))) / (b - a) if b > a else 0.0
        t, u = root, self._advance(mode, t_old, u_old, root)
        for _ in range(4):
            if slope == 0.0:
                break
            step = -g(u) / slope
            if abs(step) <= 2e-16 * t or abs(step) > 0.1 * (t_new - t_old):
                break
            t = min(max(t + step, t_old), t_new)
            u = self._advance(mode, t_old, u_old, t)
        return t, u


def _public(u: Array) -> dict[str, float]:
    names = {"x_A": X_A, "x_A_dot": V_T, "y_A": Y_A, "y_A_dot": V_N, "theta": TH, "theta_dot": OM}
    return {name: float(u[index]) for name, index in names.items()}


def _forces(rod: Rod, mode: Mode, u: Array) -> tuple[float, float]:
    F_n = normal_force(rod, mode, float(u[Y_A]))
    return F_n, friction(rod, mode, u, F_n)


def simulate(
    theta: float,
    theta_dot: float,
    x_A_dot: float,
    y_A: float = 0.0,
    y_A_dot: float = 0.0,
    x_A: float = 0.0,
    *,
    m: float = 1.0,
    l: float = 1.0,
    g: float = 9.8,
    mu: float = 1.4,
    n: float = 1.764,
    nu: float = 0.3,
    R: float = 0.00645,
    E: float = 20.9e14,
    e: float = 0.75,
    reload: str = "virgin",
    t_end: float,
    until: str | None = None,
    rtol: float = 1e-12,
    max_events: int = 1000,
) -> RodRun:
    """Simulate the rod with the compliant bilinear contact, from event to event.

    In contact ``F_n = K delta^n`` while compressing and equation (5) while restoring; the friction
    is Coulomb's, and at zero slip the end sticks if and only if ``|F_t_stick| <= mu F_n``.

    Parameters
    ----------
    theta, theta_dot : float
        Angle to the ground (rad) and its rate.
    x_A_dot : float
        Slip velocity, m/s.
    y_A, y_A_dot : float
        Gap (m) and its rate. A gap below zero at rest starts in compression if it deepens,
        otherwise in restitution from delta_max = delta.
    x_A : float
        Place of the contact end, m.
    m, l, g, mu, n, nu, R, E, e : float
        Parameters of the paper, SI units; `e` is the energetic coefficient, in (0, 1].
    reload : {"virgin", "elastic"}
        Curve followed when the compression grows again before the gap opens. ``"virgin"``:
        K delta^n at once, and it jumps there. ``"elastic"``: back along the unloading curve up to
        delta_max, then K delta^n; after a separation contact is made again at delta_p.
        A surface whose gap has opened above zero is virgin again.
    t_end : float
        Last time, s.
    until : str, optional
        Kind of event at whose first occurrence to stop.
    rtol : float
        Relative tolerance of DOP853, at least 2.3e-14.
    max_events : int
        Stop after this many events: chattering has infinitely many.

    Returns
    -------
    RodRun
        Events, final state, final mode and the reason for stopping.

    Raises
    ------
    ValueError
        For an unknown `reload` or `until`.
    RuntimeError
        If the integrator cannot take a step.
    """
    if reload not in ("virgin", "elastic"):
        raise ValueError(f"reload: got {reload!r}, need 'virgin' or 'elastic'")
    if until is not None and until not in KINDS:
        raise ValueError(f"until: got {until!r}, need one of {KINDS}")
    rod = Rod(m, l, g, mu, n, stiffness(E, nu, R), e, reload)
    s, c = math.sin(theta), math.cos(theta)
    centre = [x_A + l * c, y_A + l * s, theta]
    rates = [x_A_dot - l * theta_dot * s, y_A_dot + l * theta_dot * c, theta_dot]
    u = np.array([*centre, *rates, x_A, x_A_dot, y_A, y_A_dot], dtype=float)
    mode, t, events, stop = initial_mode(rod, u), 0.0, [], "t_end"
    integrator = _Integrator(rod, rtol)
    while t < t_end:
        t, u, name = integrator.segment(mode, t, u, t_end)
        if name is None:
            break
        before = _forces(rod, mode, u)
        mode, kind, u = after(rod, mode, name, u)
        if not kind:
            continue
        # A jump of the normal force can end sticking without any guard passing through zero.
        if mode.tangent == "stick" and tangent_at(rod, mode, u) != "stick":
            mode = Mode(mode.normal, tangent_at(rod, mode, u), mode.delta_max)
        forces = _forces(rod, mode, u)
        delta = max(-float(u[Y_A]), 0.0)
        events.append(
            RodEvent(t, kind, _public(u), *forces, *before, delta, (mode.normal, mode.tangent))
        )
        if kind == until or len(events) >= max_events:
            stop = kind if kind == until else "max_events"
            break
    F_n, F_t = _forces(rod, mode, u)
    final = _public(u) | {"t": t, "F_n": F_n, "F_t": F_t, "delta": max(-float(u[Y_A]), 0.0)}
    final |= {"x": float(u[X]), "y": float(u[Y]), "x_dot": float(u[VX]), "y_dot": float(u[VY])}
    return RodRun(events, final, (mode.normal, mode.tangent), stop)
