"""The scene of a film: its times, and the places of bodies, contacts and forces at them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.evaluate import at_arrays, expression_function
from painleve_sym.mechanics.drawing import (
    contact_geometries,
    ground_surfaces,
    scene_formulas,
    shapes_of,
)
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.shapes import PLACE, Shape, ShapeKind
from painleve_sym.motion.trajectory import Trajectory

MAX_MAGNIFIED = 24
"""Maximum number of events around which the time is magnified."""
SHARES = (0.35, 0.35, 0.3)
"""Parts of the film in proportion to time, to steps of the integration, and near events."""
SHORTEST = 1e-6
"""Part of the motion below which steps and events are not magnified further."""
STEP_POWER = 0.25
"""Power of the length of a step to which its time in the film is in proportion."""

SMALL, SMALLEST = 0.03, 1e-6
"""Part of the view below which a motion is not seen, and part of that below which there is none."""
FOLLOWED = 10.0
"""Slip in units of the opening of a contact above which its close-up follows it."""


def film_times(trajectory: Trajectory, frames: int) -> Array:
    """Return the times of the frames, increasing from start to end, shape (frames,); s.

    The film runs slowly where forces change fast: a part of it is in proportion to the time, a part
    is spent on the steps of the integration, in proportion to a small power of their lengths, and a
    part near events, about which the time is magnified logarithmically. There are at least 2
    frames.
    """
    start, end = float(trajectory.t[0]), float(trajectory.t[-1])
    shortest = max(SHORTEST * (end - start), np.finfo(float).tiny)
    ends = np.append(np.unique(np.floor((trajectory.t - start) / shortest)) * shortest, end - start)
    ends = np.unique(np.clip(start + ends, start, end))
    events = np.unique([e.time for e in trajectory.events if start < e.time < end])
    scales = _local_scales(events, start, end)
    if len(events) > MAX_MAGNIFIED:
        chosen = np.sort(np.argsort(-scales, kind="stable")[:MAX_MAGNIFIED])
        events, scales = events[chosen], scales[chosen]
    near = np.concatenate([[0.0], *(s * np.geomspace(1e-2, 1e4, 80) for s in scales[:, None])])
    around = (events[:, None] + np.concatenate([-near, near])).ravel() if len(events) else []
    grid = np.unique(np.concatenate([ends, np.linspace(start, end, 400), around]))
    grid = grid[(grid >= start) & (grid <= end)]
    uniform = (grid - start) / (end - start)
    lengths = np.append(0.0, np.cumsum(np.diff(ends) ** STEP_POWER))
    steps = np.interp(grid, ends, lengths / lengths[-1])
    film = SHARES[0] * uniform + SHARES[1] * steps
    for time, scale in zip(events, scales, strict=True):
        away = grid - time
        part = np.sign(away) * np.log1p(np.abs(away) / scale)
        film += SHARES[2] / len(events) * (part - part[0]) / (part[-1] - part[0])
    times: Array = np.interp(np.linspace(0, film[-1], frames), film, grid)
    return times


def _local_scales(events: Array, start: float, end: float) -> Array:
    """Return the time about each event that is magnified, shape (events,); s."""
    gaps = np.diff(np.concatenate([[start], events, [end]])) / 4
    shortest, longest = SHORTEST * (end - start), (end - start) / 60
    return np.clip(np.minimum(gaps[:-1], gaps[1:]), shortest, longest)


@dataclass(frozen=True)
class Scene:
    """Places of bodies and contacts of a motion, and the forces on the contacts, at times in s."""

    trajectory: Trajectory
    mechanism: Mechanism
    times: Array

    @cached_property
    def shapes(self) -> tuple[Shape, ...]:
        """The shapes that are drawn."""
        return shapes_of(self.mechanism)

    @cached_property
    def contacts(self) -> tuple[str, ...]:
        """Names of the contacts with a place."""
        return tuple(contact_geometries(self.mechanism))

    @cached_property
    def _values(self) -> dict[Any, Any]:
        """States at the times and parameters, by symbol."""
        run, mechanism = self.trajectory, self.mechanism
        states = dict(zip(run.state_names, run(self.times).T, strict=True))
        values = {s: states[s.name] for s in mechanism.motion}
        return values | {p.symbol: run.parameters[p.name] for p in mechanism.outline.parameters}

    @cached_property
    def _places(self) -> dict[str, Array]:
        formulas = scene_formulas(self.mechanism, self.shapes)
        return dict(zip(formulas, self._at_times(*formulas.values()), strict=True))

    def _at_times(self, *formulas: Any) -> Array:
        """Return formulas at the times, shape (formulas, frames)."""
        function = expression_function("scene", formulas, list(self._values))
        return at_arrays(function, list(self._values.values()))

    def _vector(self, name: str) -> Array:
        return np.stack([self._places[f"{name}_{axis}"] for axis in "xy"], axis=1)

    @cached_property
    def outputs(self) -> dict[str, Array]:
        """Outputs of the motion at the times by name, each of shape (frames,)."""
        return self.trajectory.outputs(self.times)

    def of_contact(self, name: str, contact: str) -> Array:
        """Return an output of one contact, shape (frames,)."""
        return self.outputs[self.trajectory.names.of_contact(name, contact)]

    def points(self, i: int) -> Array:
        """Return the points of a shape, shape (frames, points, 2); m."""
        count = len(self.shapes[i].points)
        return np.stack([self._vector(f"shape_{i}_point_{k}") for k in range(count)], axis=1)

    def place(self, contact: str) -> Array:
        """Return the point of a contact, shape (frames, 2); m."""
        return self._vector(contact)

    def normal(self, contact: str) -> Array:
        """Return the unit vector of the normal force, shape (frames, 2)."""
        return self._vector(f"{contact}_normal")

    def tangent(self, contact: str) -> Array:
        """Return the unit vector of positive slip and tangential force, shape (frames, 2)."""
        normal = self.normal(contact)
        return np.stack([normal[:, 1], -normal[:, 0]], axis=1)

    def belt_speed(self, contact: str) -> Array:
        """Return the speed of the surface of a belt along positive slip, shape (frames,); m/s."""
        return np.broadcast_to(self._places[f"{contact}_surface_speed"], self.times.shape)

    @cached_property
    def _levels(self) -> dict[str, Any]:
        """Functions of place, states and parameters, by the contact."""
        symbols = [*PLACE, *self._values]
        grounds = ground_surfaces(self.mechanism)
        return {c: expression_function("level", [s], symbols) for c, s in grounds.items()}

    @property
    def grounds(self) -> tuple[str, ...]:
        """Names of the contacts with a surface that is drawn as ground."""
        return tuple(self._levels)

    def level(self, contact: str, frame: int, x: Array, y: Array) -> Array:
        """Return the function of a surface at places: zero on it, positive on its free side."""
        now = (v if np.ndim(v) == 0 else v[frame] for v in self._values.values())
        level: Array = at_arrays(self._levels[contact], (x, y, *now))[0]
        return level

    def gap(self, contact: str) -> Array:
        """Return the gap of a contact, shape (frames,); m."""
        formula = next(c.gap for c in self.mechanism.contacts if c.name == contact)
        gap: Array = self._at_times(formula)[0]
        return gap

    def slid(self, contact: str) -> Array:
        """Return the way that a contact has slid since the start, shape (frames,); m."""
        speed = self.of_contact("slip_velocity", contact)
        means = (speed[1:] + speed[:-1]) / 2
        return np.append(0.0, np.cumsum(means * np.diff(self.times)))

    def close_up(self, contact: str) -> float | None:
        """Return the width of a view in which the motion of a contact shows; m.

        None where the whole view shows it, or nothing moves: what is drawn as large as a line is
        not seen. A gap too small against a long slip has a view that follows the contact.
        """
        small = SMALL * float(self.window[1].max())
        opens, slides = float(np.ptp(self.gap(contact))), float(np.ptp(self.slid(contact)))
        if opens >= small or max(opens, min(slides, small)) < SMALLEST * small:
            return None
        if slides <= FOLLOWED * opens or opens < SMALLEST * small:
            return 1.7 * max(opens, slides) if slides < small else None
        return 4.0 * opens

    @cached_property
    def _everything(self) -> Array:
        """All points of shapes and contacts, shape (frames, points, 2)."""
        parts = [self.points(i) for i in range(len(self.shapes))]
        for i, shape in enumerate(self.shapes):
            if shape.kind is ShapeKind.DISC:
                centre, rim = parts[i][:, :1], parts[i][:, 1:]
                radius = np.linalg.norm(rim - centre, axis=2, keepdims=True)
                parts[i] = np.concatenate([centre - radius, centre + radius], axis=1)
        parts += [self.place(c)[:, None] for c in self.contacts]
        return np.concatenate(parts, axis=1)

    def outline(self) -> Array:
        """Return points along every shape, and the contacts, shape (frames, points, 2); m."""
        parts = [self.place(c)[:, None] for c in self.contacts]
        for i, shape in enumerate(self.shapes):
            own = self.points(i)
            if shape.kind is ShapeKind.DISC:
                across = own[:, 1:] - own[:, :1]
                turned = across[:, :, ::-1] * np.array([-1.0, 1.0])
                own = own[:, :1] + np.concatenate([across, turned, -across, -turned], axis=1)
            ends = np.concatenate([own, own[:, :1]], axis=1)
            along = np.linspace(0, 1, 9)[:, None]
            sides = ends[:, :-1, None] + along * (ends[:, 1:, None] - ends[:, :-1, None])
            parts.append(sides.reshape(len(own), -1, 2))
        return np.concatenate(parts, axis=1)

    @cached_property
    def reach(self) -> float:
        """Size of the mechanism; m."""
        low, high = self._everything.min(axis=1), self._everything.max(axis=1)
        travel = float((high.max(axis=0) - low.min(axis=0)).max())
        return max(float((high - low).max()), 1e-2 * travel, 1e-6)

    @property
    def longest_arrow(self) -> float:
        """Length of the arrow of the largest force; m."""
        return 0.42 * self.reach

    @cached_property
    def window(self) -> tuple[Array, Array]:
        """Lower left corners of the view, shape (frames, 2), and its size, shape (2,); m.

        The view stands still where it shows the whole motion, else it follows the mechanism.
        """
        heads = [
            (self.place(c) + direction * self.longest_arrow)[:, None]
            for c in self.contacts
            for direction in (self.normal(c), self.tangent(c), -self.tangent(c))
        ]
        points = np.concatenate([self._everything, *heads], axis=1)
        low, high = points.min(axis=1), points.max(axis=1)
        own, reach = np.max(high - low, axis=0), self.reach
        total = high.max(axis=0) - low.min(axis=0)
        size, corner = np.empty(2), np.empty_like(low)
        for k in range(2):
            still = total[k] <= 2.5 * reach
            size[k] = (total[k] if still else own[k]) + 0.5 * reach
            middle = (
                (low.min(axis=0) + high.max(axis=0))[k] / 2 if still else (low + high)[:, k] / 2
            )
            corner[:, k] = middle - size[k] / 2
        return corner, size
