"""One mode of an automaton on CasADi's `erk` integrator, over one window of time."""

from __future__ import annotations

import contextlib
import io
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.engines.protocol import DENSE_ROWS
from painleve_sym.engines.records import dense_values

GRID = 16
"""Intervals of a window; its length is controlled so that it takes about as many steps."""
_TIGHTER = 0.05
"""Of the tolerance: steps of order 5 are many, and their errors add up."""
_TIGHTEST = 1e-14
"""Below it the error estimate of a step is round-off."""
_EVENT_TOL = 1e-14
"""Of a window: the event is located again afterwards, so this only has to be small."""
_ZERO_WIDTH = 1e-13
"""Of an interval: a zero this near is where a step is ended, and Newton continues from there."""
_KINK = 100.0
"""Second derivative over change and slopes, in an interval, that no resolved motion reaches."""
_MAX_STEPS = 1000
"""In one interval of a window, which holds about one: more means that it is far too long."""


class Call:
    """A CasADi function bound to dense arrays of its own: a call costs 1 μs instead of 20."""

    def __init__(self, function: ca.Function) -> None:
        buffer: Any = function.buffer()
        self._buffer, self._evaluate = buffer
        self._arguments = [np.zeros(function.nnz_in(i)) for i in range(function.n_in())]
        self._results = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
        binds = (self._buffer.set_arg, self._buffer.set_res)
        for bind, arrays in zip(binds, (self._arguments, self._results), strict=True):
            for i, array in enumerate(arrays):
                if array.size:
                    bind(i, array.data)

    def attempt(self, *arguments: Array) -> list[Array] | None:
        """Return the results, flat, matrices column by column; None where it failed."""
        # The remaining arguments of an integrator are zero.
        for own, given in zip(self._arguments, arguments, strict=False):
            own[:] = np.ravel(given)
        self._evaluate()
        return None if self._buffer.ret() else [r.copy() for r in self._results]

    def __call__(self, *arguments: Array) -> list[Array]:
        """Return the results of a function that does not fail (it may return nan)."""
        results = self.attempt(*arguments)
        if results is None:
            raise RuntimeError("casadi: evaluating an expression failed.")
        return results

    def statistics(self) -> dict[str, int]:
        """Return the counters of the last call of an integrator."""
        counters: dict[str, int] = self._buffer.stats()
        return counters


@dataclass(frozen=True)
class Samples:
    """A mode at n points: states x, guards g and their rates dg, ẋ and ẍ, each of n rows."""

    x: Array
    g: Array
    dg: Array
    rate: Array
    bend: Array


@dataclass(frozen=True)
class Window:
    """A smooth stretch of motion at GRID + 1 times from the start of the window, s; memory z.

    `fired` is the guard that crosses zero according to `erk`, -1 for none, and `place` where it
    did, as a part of the window; the state is constant after it.
    """

    times: Array
    at: Samples
    z: Array
    c: Array
    fired: int = -1
    place: float = 1.0

    def moved(self, more: float) -> Window:
        """Return the window with its end moved so little that the motion there is linear."""
        times, x = self.times.copy(), self.at.x.copy()
        times[-1] += more
        x[-1] += more * self.at.rate[-1]
        return replace(self, times=times, at=replace(self.at, x=x))

    @cached_property
    def rows(self) -> Array:
        """The quintic Hermite polynomials of all intervals, shape (GRID, 8, nx).

        They have the values, rates and second derivatives of both ends; see `Trajectory`.
        """
        h, at = np.diff(self.times)[:, None], self.at
        f0, f1 = h * at.rate[:-1], h * at.rate[1:]
        a0, a1 = h * h * at.bend[:-1], h * h * at.bend[1:]
        rows = np.zeros((GRID, DENSE_ROWS, at.x.shape[1]))
        rows[:, 0], rows[:, 1] = at.x[:-1], np.diff(at.x, axis=0)
        rows[:, 2] = f0 - rows[:, 1]
        rows[:, 3] = 2 * rows[:, 1] - f0 - f1
        # Where a force sets in with a kink there is no second derivative: the cubic remains.
        size = np.abs(rows[:, 1]) + np.abs(f0) + np.abs(f1)
        smooth = np.fmax(np.abs(a0), np.abs(a1)) <= _KINK * size
        rows[:, 4] = np.where(smooth, 0.5 * a0 + rows[:, 2] - rows[:, 3], 0.0)
        rows[:, 5] = np.where(smooth, 0.5 * (a1 - a0) + 3 * rows[:, 3], 0.0)
        return rows

    def roughness(self, scale: Array) -> float:
        """Estimate the error between the points of the grid, relative to scale and state.

        Every second point is compared with the quintic over both intervals beside it, whose error
        is 2⁶ times that of one interval.
        """
        h, at = 2 * float(self.times[1]), self.at
        x, f, a = at.x[::2], h * at.rate[::2], h * h * at.bend[::2]
        middle = (x[:-1] + x[1:]) / 2 + 5 / 32 * (f[:-1] - f[1:]) + (a[:-1] + a[1:]) / 64
        error = np.abs(middle - at.x[1::2]) / (scale + np.abs(at.x[1::2]))
        return float(np.max(error, initial=0.0, where=np.isfinite(error))) / 64


def _may_touch(g: Array, dg: Array, h: Any) -> Any:
    """Whether a guard may reach zero between points h apart, where it is positive at both.

    It turns upwards there, and its tangents meet at or below zero: a convex guard is above them.
    """
    lowest = g[:-1] + dg[:-1] * (g[:-1] - g[1:] + h * dg[1:]) / (dg[1:] - dg[:-1])
    return (dg[:-1] < 0) & (dg[1:] > 0) & (lowest <= 0)


class ModeRunner:
    """One mode on `erk`: time scaled to [0, 1], states scaled so that one tolerance fits all.

    CasADi has no event that ends an integration. Here the transition clears the extra state
    `alive`, which switches the field off, and notes which guard fired and when; the state at the
    end of the window is then the state at the event.
    """

    def __init__(self, functions: AutomatonFunctions, index: int, rtol: float) -> None:
        self._functions, self._mode = functions, functions.modes[index]
        self._nx, self._ng = functions.x.numel(), self._mode.guards.size1_out(0)
        self._profile = Call(self._profile_function())
        self._integrate = Call(self._integrator(rtol))
        self.field, self.jets = Call(self._mode.field), Call(self._mode.jets)
        self.events = tuple(Call(f) for f in self._mode.events)
        self.limits = {j: Call(f) for j, f in self._mode.limits.items()}

    def _profile_function(self) -> ca.Function:
        x, z, c = self._functions.x, self._functions.z, self._functions.c
        rate = self._mode.field(x, z, c)
        results = [*self._mode.guards(x, z, c), rate, ca.jtimes(rate, x, rate)]
        point = ca.Function("point", [x, z, c], ca.cse([ca.densify(r) for r in results]))
        return point.map("profile", "serial", GRID + 1, [1, 2], [])

    def _integrator(self, rtol: float) -> ca.Function:
        nx, z, c = self._nx, self._functions.z, self._functions.c
        y, extra, scale = ca.SX.sym("y", nx), ca.SX.sym("extra", 3), ca.SX.sym("scale", nx)
        length, watch, alive = ca.SX.sym("length"), ca.SX.sym("watch"), extra[0]
        state, p = ca.vertcat(y, extra), ca.vertcat(z, c, scale, length, watch)
        field = length * self._mode.field(y * scale, z, c) / scale
        rate = ca.vertcat(ca.if_else(alive > 0.5, field, 0), 0, 0, 0)
        dae = {"x": state, "p": p, "ode": ca.cse(rate)}
        # The RMS norm counts the three extra states, which have no error.
        tolerance = max(_TIGHTER * rtol, _TIGHTEST) * float(np.sqrt(nx / (nx + 3)))
        options: dict[str, Any] = {
            "reltol": tolerance,
            "abstol": tolerance,
            "step0": 1 / GRID,
            "max_num_steps": _MAX_STEPS,
            "show_eval_warnings": False,
        }
        if self._ng:
            guards = self._mode.guards(y * scale, z, c)[0]
            dae["zero"] = ca.cse(ca.if_else(alive * watch > 0.5, guards, 1))
            i, t, none = ca.SX.sym("i"), ca.SX.sym("t"), ca.SX(0, 1)
            freeze = [ca.vertcat(y, 0, i, t), none]
            options["transition"] = ca.Function(
                "freeze", [i, t, state, none, p, none], freeze, ca.event_in(), ca.event_out()
            )
            options["event_tol"] = _EVENT_TOL
        grid = [float(s) for s in np.linspace(0, 1, GRID + 1)]
        # CasADi announces on stderr that its events are experimental.
        with contextlib.redirect_stderr(io.StringIO()):
            return ca.integrator("window", "erk", dae, 0.0, grid, options)

    def samples(self, x: Array, z: Array, c: Array) -> Samples:
        """Evaluate the mode at GRID + 1 points, x of shape (GRID + 1, nx)."""
        columns = self._profile(x, z, c)
        return Samples(x, *(r.reshape(GRID + 1, -1) for r in columns))

    def window(
        self, x: Array, z: Array, c: Array, scale: Array, length: float, watch: bool
    ) -> tuple[Window | None, dict[str, int]]:
        """Integrate over `length`, s, up to the first event if `watch`; add CasADi's counters.

        None in place of the window where the motion cannot be integrated that far. Below its scale,
        shape (nx,), the error of a state counts as absolute.
        """
        start = np.concatenate([x / scale, [1.0, -1.0, 0.0]])
        p = np.concatenate([z, c, scale, [length, float(watch)]])
        result = self._integrate.attempt(start, np.empty(0), p)
        work = self._integrate.statistics()
        if result is None or not np.isfinite(result[0]).all():
            return None, work
        grid = result[0].reshape(GRID + 1, -1)
        times = np.linspace(0.0, length, GRID + 1)
        at = self.samples(grid[:, : self._nx] * scale, z, c)
        alive, fired, place = (float(v) for v in grid[-1, self._nx :])
        if alive > 0.5:
            return Window(times, at, z, c), work
        return Window(times, at, z, c, round(fired), place), work

    def first_zero(self, window: Window, j: int, armed: bool, intervals: int) -> float | None:
        """Return the time at which guard j first crosses zero from above in a window, s, or None.

        No guard fired in the window, of which `intervals` are searched. An armed guard is
        positive at the start; otherwise it is zero and should leave it upwards: if it is not seen
        to, that is a zero at time 0.
        """
        g, dg, times = window.at.g[:, j], window.at.dg[:, j], window.times
        first = 0
        if not armed:
            half = GRID // 2
            positive = np.flatnonzero(g[1 : half + 1] > 0)
            if not positive.size:
                return None if g[half] == 0 and dg[half] == 0 else 0.0
            first = int(positive[0]) + 1
        h = np.diff(times)
        for i in np.flatnonzero((g[1:] <= 0) | _may_touch(g, dg, h)):
            if first <= i < intervals:
                u = self._zero(window, j, window.rows[i], h[i])
                if u is not None:
                    return float(times[i] + u * h[i])
        return None

    def _zero(self, window: Window, j: int, rows: Array, h: float) -> float | None:
        """Return the first zero of guard j in (0, 1] on an interval's polynomial, or None."""
        a, b, crossed = 0.0, 1.0, False
        while b - a > _ZERO_WIDTH:
            u = np.linspace(a, b, GRID + 1)
            at = self.samples(dense_values(rows, u), window.z, window.c)
            g, dg = at.g[:, j], at.dg[:, j]
            below = np.flatnonzero(g[1:] <= 0)
            crossed = below.size > 0
            parts = below if crossed else np.flatnonzero(_may_touch(g, dg, h * (b - a) / GRID))
            if not parts.size:
                return None
            a, b = float(u[parts[0]]), float(u[parts[0] + 1])
        return b if crossed else None
