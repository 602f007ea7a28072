"""The figure of a film: bodies and forces, contacts magnified, the normal force over the film."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from painleve_sym.arrays import Array
from painleve_sym.escape import figure_text
from painleve_sym.mechanics.shapes import Shape, ShapeKind
from painleve_sym.present.fonts import make_legible
from painleve_sym.present.scene import Scene, film_times
from painleve_sym.present.style import (
    COLUMN,
    CONTACTS,
    DASHES,
    EVENT,
    NORMAL,
    SLIP,
    TANGENTIAL,
    event_label,
    styled,
)
from painleve_sym.quantities import axis_label, roundest, scaled_unit, text_label

DPI = 100
FLASH = 0.45
"""Time that an event is shown; s of the film."""
FORCE_DECADES = 3.0
"""Forces smaller than the largest by this many decades have arrows of no length."""
FINER = 12
"""Points per frame of the curves over the film."""
GROUND = 0.88
"""Grey of what lies behind a surface."""
INSETS = 2
"""Maximum number of contacts that are drawn magnified."""
INSET = 0.3
"""Part of the width of the view that a magnified contact takes."""
TICKS = 7
"""Marks of the surface across a magnified contact."""
SURFACE = "0.35"
_VECTOR: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1, "width": 0.009}
"""Look of an arrow with the length and direction of a vector, in m."""


class FilmPicture:
    """The mechanism with magnified contacts above, the normal forces over the film below."""

    def __init__(self, scene: Scene, width: int, rate: int) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        self.scene, self.rate = scene, rate
        self.legend = len(scene.contacts) > 1  # an only contact needs no name
        close = {c: scene.close_up(c) for c in scene.contacts}
        chosen = [(c, near) for c, near in close.items() if near is not None][:INSETS]
        frame = _Frame.of(scene, len(chosen))
        inches = width / DPI
        strip = 0.16 if self.legend else 0.0
        # Whole numbers of pixels that are even, which video needs.
        height = 2 * round((width * 0.9 * frame.ratio + 165 + strip * DPI) / 2) / DPI
        self.figure = Figure(figsize=(inches, height))
        self.canvas: Any = FigureCanvasAgg(self.figure)
        self.background: Any = None
        box = np.array([0.05, (1.18 + strip) / height, 0.9, 0.9 * inches * frame.ratio / height])
        self.view = _View(self.figure.add_axes(tuple(box)), scene, frame.corner, frame.size)
        self.insets = []
        for (contact, near), place in zip(chosen, frame.insets, strict=False):
            rectangle = np.concatenate([box[:2] + place * box[2:], frame.share * box[2:]])
            axes = self.figure.add_axes(tuple(rectangle), zorder=10)
            times = frame.share[0] * frame.size[0] / near
            name = f"{figure_text(contact)} " * self.legend
            title = f"{name}× {float(f'{times:.1e}'):,.0f}"
            self.insets.append(_Inset(axes, scene, contact, near, title))
        self.strip = self.figure.add_axes((0.14, 0.38 / height, 0.81, 0.56 / height))
        self.arrows = [_Arrows(self.view.axes, scene, c, frame.size) for c in scene.contacts]
        self.clock = self.figure.text(0.05, 0.985, "", ha="left", va="top", fontsize=9)
        self.label = self.figure.text(0.95, 0.94, "", ha="right", va="top", fontsize=8, color=EVENT)
        self._prepare_view()
        self._prepare_strip()
        moving_ground = scene.mechanism.depends_on_time and bool(scene.contacts)
        self.moves = moving_ground or bool((np.ptp(self.view.corner, axis=0) > 0).any())
        self.drawn = [*self.view.dynamic, self.cursor, self.clock, self.label]
        self.drawn += [artist for arrows in self.arrows for artist in arrows.artists]
        self.drawn += [inset.axes for inset in self.insets]
        for artist in self.drawn:
            artist.set_animated(True)

    def pixels(self, i: int) -> Array:
        """Return the pixels of the frame i, shape (height, width, 3)."""
        if self.moves or self.background is None:
            self.view.show_place(i)
            self.canvas.draw()
            self.background = self.canvas.copy_from_bbox(self.figure.bbox)
        self.canvas.restore_region(self.background)
        self._show(i)
        for artist in sorted(self.drawn, key=lambda artist: artist.get_zorder()):
            (artist.axes if artist.axes not in (None, artist) else self.figure).draw_artist(artist)
        return np.asarray(self.canvas.buffer_rgba())[..., :3].copy()

    def _prepare_view(self) -> None:
        axes, scene = self.view.axes, self.scene
        axes.tick_params(
            labelleft=False, left=False, right=False, top=False, labelsize=6.5, length=2
        )
        for side in ("left", "right", "top"):
            axes.spines[side].set_visible(False)
        axes.grid(axis="x", color="0.93", linewidth=0.6, zorder=0)
        axes.xaxis.set_major_formatter("{x:.3g} m")
        keys = (("$F_n$", NORMAL), ("$F_t$", TANGENTIAL), ("slip", SLIP))
        x = 0.05
        for text, colour in keys if scene.contacts else ():
            key = self.figure.text(x, 0.94, text, color=colour, ha="left", va="top", fontsize=8)
            x = float(key.get_window_extent(self.canvas.get_renderer()).x1) / self.figure.bbox.width
            x += 0.02

    def _prepare_strip(self) -> None:
        scene, axes = self.scene, self.strip
        film = np.linspace(0, (len(scene.times) - 1) / self.rate, FINER * len(scene.times))
        fine = scene.trajectory.outputs(film_times(scene.trajectory, len(film)))
        names = scene.trajectory.names
        forces = [fine[names.of_contact("normal_force", c)] for c in scene.contacts]
        largest = max((float(np.nanmax(np.abs(f))) for f in forces), default=0.0)
        scale, unit = scaled_unit("N", largest)
        for k, (name, force) in enumerate(zip(scene.contacts, forces, strict=True)):
            look: dict[str, Any] = {"color": NORMAL, "linewidth": 1.0}
            if self.legend:
                look |= {"color": CONTACTS[k % len(CONTACTS)], "linestyle": DASHES[k % len(DASHES)]}
            axes.plot(film, force * scale, label=figure_text(name), **look)
        self.moments = moments(self._events(), scene.times)
        rug = [moment / self.rate for moment, _ in self.moments]
        axes.vlines(
            rug, 0.86, 1.0, color=EVENT, linewidth=0.8, transform=axes.get_xaxis_transform()
        )
        self.cursor = axes.axvline(0, color="black", linewidth=0.9)
        axes.set_xlim(film[0], film[-1])
        if largest == 0:
            axes.set_ylim(0, 1)
        axes.set_ylabel(text_label("$F_n$", unit), fontsize=7.5)
        axes.tick_params(labelsize=6.5, length=2, pad=2)
        axes.locator_params(axis="y", nbins=3)
        self.factor, self.unit = scaled_unit("s", float(scene.times[-1] - scene.times[0]))
        shown = _round_times(scene.times * self.factor)
        places = np.interp(shown, scene.times * self.factor, np.arange(len(scene.times)))
        axes.set_xticks(places / self.rate, [f"{time:.4g}" for time in shown])
        words = text_label("time, magnified where it is short", self.unit)
        axes.set_xlabel(words, fontsize=7, labelpad=1)
        if self.legend:
            # Above the strip, where no curve is.
            legend = axes.legend(
                fontsize=7, loc="lower right", bbox_to_anchor=(1, 1), ncols=6, borderaxespad=0.1
            )
            for text in legend.get_texts():
                make_legible(text)

    def _events(self) -> list[tuple[float, str, str]]:
        """Return time, label and contact of every event that is shown."""
        return [
            (e.time, event_label(e.kind), e.contact)
            for e in self.scene.trajectory.events
            if e.kind != "contact"
        ]

    def _show(self, i: int) -> None:
        """Set bodies, arrows and clock to the frame i."""
        self.view.show(i)
        for inset in self.insets:
            inset.show_place(i)
            inset.show(i)
        since = FLASH * self.rate
        recent = [
            (text, contact, i - m)
            for m, events in self.moments
            if 0 <= i - m < since
            for text, contact in events
        ]
        for arrows in self.arrows:
            own = [age for _, contact, age in recent if contact in ("", arrows.contact)]
            arrows.show(i, min(own) / since if own else None)
        self.cursor.set_xdata([i / self.rate] * 2)
        self.clock.set_text(self._clock(i))
        texts = [f"{t} ({figure_text(c)})" if c and self.legend else t for t, c, _ in recent]
        self.label.set_text(", ".join(list(dict.fromkeys(texts))[-2:]))
        make_legible(self.label)

    def _clock(self, i: int) -> str:
        times = self.scene.times
        j = min(max(i, 1), len(times) - 1)
        step = max(float(times[j] - times[j - 1]), 1e-300)
        digits = int(np.clip(np.ceil(-np.log10(step * self.factor)) + 1, 0, 9))
        slower = 1 / (step * self.rate)
        # In words: a formula would be read again in each frame.
        text = f"time {times[i] * self.factor:.{digits}f} {self.unit}    "
        if slower < 1.05:
            return text + ("real time" if slower > 0.95 else f"{1 / slower:.2g} times as fast")
        ratio = "1 : {:.2g}" if slower < 10 else "1 : {:,.0f}"
        return text + f"slow motion {ratio.format(float(f'{slower:.1e}'))}"


def _round_times(times: Array) -> list[float]:
    """Return the first time, and round ones near five even places of a film."""
    last, steps = len(times) - 1, np.arange(1, 6)
    low = times[(last * (steps - 0.35) / 5).round().astype(int)]
    high = times[np.minimum(last * (steps + 0.35) / 5, last).round().astype(int)]
    later = {roundest(float(a), float(b)) for a, b in zip(low, high, strict=True)}
    return [float(times[0]), *sorted(later - {0.0})]


@styled
def mechanism_figure(scene: Scene, width: float = COLUMN) -> Figure:
    """Return the mechanism to scale at the first time of a scene, with its contacts by name."""
    corner, size = scene.window
    ratio = float(np.clip(size[1] / size[0], 0.35, 1.2))
    figure = Figure(figsize=(width, width * ratio + 0.3), layout="constrained")
    size_shown = np.array([1.0, ratio]) * max(size[0], size[1] / ratio)
    view = _View(figure.add_subplot(), scene, corner + (size - size_shown) / 2, size_shown)
    view.show_place(0)
    view.show(0)
    axes = view.axes
    for contact in scene.contacts:
        place, normal = scene.place(contact)[0], scene.normal(contact)[0]
        axes.plot(*place[:, None], "o", color=NORMAL, markersize=3.5, zorder=6)
        below = place - 0.05 * size_shown[0] * normal
        axes.text(
            below[0],
            below[1],
            figure_text(contact),
            color=NORMAL,
            ha="center",
            va="center",
            zorder=6,
        )
    axes.set_xlabel(axis_label("x", "m"))
    axes.set_ylabel(axis_label("y", "m"))
    axes.grid(color="0.93", linewidth=0.6, zorder=0)
    axes.set_axisbelow(True)
    return figure


class _View:
    """Axes with the bodies and the ground of a scene, between places that may move."""

    def __init__(self, axes: Axes, scene: Scene, corner: Array, size: Array) -> None:
        self.axes, self.scene, self.corner, self.size = axes, scene, corner, size
        axes.set_aspect("equal")
        self.ground: list[Any] = []
        self.guides = {c.name for c in scene.mechanism.outline.contacts if c.bilateral}
        before = set(axes.get_children())
        self.bodies = [_artist(axes, shape) for shape in scene.shapes]
        self.marks = [_Marks(axes, scene, c, count) for c, count in self._marked().items()]
        self.dynamic = [a for a in axes.get_children() if a not in before]

    def _marked(self) -> dict[str, int]:
        """Return the contacts whose surface has marks, with their number: belts."""
        speeds = {c: self.scene.belt_speed(c) for c in self.scene.grounds}
        return {c: 2 * TICKS for c, speed in speeds.items() if np.any(speed)}

    def show(self, i: int) -> None:
        """Set the bodies and the marks of surfaces to the frame i."""
        for k, (shape, artist) in enumerate(zip(self.scene.shapes, self.bodies, strict=True)):
            _move(shape, artist, self.scene.points(k)[i])
        for marks in self.marks:
            marks.show(i, self.corner[i] + self.size / 2, float(self.size[0]))

    def show_place(self, i: int) -> None:
        """Set limits and ground to the frame i, which are drawn once where they stand still."""
        low, high = self.corner[i], self.corner[i] + self.size
        self.axes.set_xlim(low[0], high[0])
        self.axes.set_ylim(low[1], high[1])
        for artist in self.ground:
            artist.remove()
        self.ground = []
        x, y = np.meshgrid(*(np.linspace(low[k], high[k], 41) for k in range(2)))
        for contact in self.scene.grounds:
            level = self.scene.level(contact, i, x, y)
            if level.min() < 0 < level.max():
                lowest = [float(level.min()) - 1, 0.0]
                if contact not in self.guides:
                    fill = self.axes.contourf(x, y, level, lowest, colors=[str(GROUND)], zorder=0.5)
                    self.ground.append(fill)
                line = self.axes.contour(
                    x, y, level, [0.0], colors=[SURFACE], linewidths=0.9, zorder=1
                )
                self.ground.append(line)


class _Marks:
    """Marks that stand still on the surface of a contact, so that they show slip and belts."""

    def __init__(self, axes: Axes, scene: Scene, contact: str, count: int) -> None:
        self.count = count
        self.slid = scene.slid(contact)
        self.normal, self.tangent = scene.normal(contact), scene.tangent(contact)
        self.foot = scene.place(contact) - scene.gap(contact)[:, None] * self.normal
        self.speed = scene.belt_speed(contact)
        look: dict[str, Any] = {"color": SURFACE, "linewidth": 0.7, "zorder": 1}
        self.lines = [axes.plot([], [], **look)[0] for _ in range(count + 2)]
        self.arrow = axes.quiver([0], [0], [0], [0], color=SURFACE, zorder=1.2, **_VECTOR)

    def show(self, i: int, middle: Array, width: float) -> None:
        """Set the marks across a view, and the arrow of a belt, to the frame i."""
        step, foot = width / self.count, self.foot[i]
        normal, tangent = self.normal[i], self.tangent[i]
        first = np.floor(((middle - foot) @ tangent + self.slid[i] - width / 2) / step)
        for k, line in enumerate(self.lines):
            top = foot + ((first + k) * step - self.slid[i]) * tangent
            bottom = top - 0.35 * step * (normal + tangent)
            line.set_data(*np.stack([top, bottom], axis=1))
        start = foot + ((middle - foot) @ tangent - 0.44 * width) * tangent - 0.05 * width * normal
        vector = np.sign(self.speed[i]) * 0.09 * width * tangent
        self.arrow.set_offsets([start + max(0.0, -np.sign(self.speed[i])) * 0.09 * width * tangent])
        self.arrow.set_UVC([vector[0]], [vector[1]])
        self.arrow.set_visible(bool(self.speed[i] != 0))


class _Inset(_View):
    """A contact magnified; marks that stand still on the surface show its slip."""

    def __init__(self, axes: Axes, scene: Scene, contact: str, width: float, title: str) -> None:
        self.contact, self.width = contact, width
        slid, gap = scene.slid(contact), scene.gap(contact)
        middle = (gap.min() + gap.max()) / 2 - gap
        centre = scene.place(contact) + middle[:, None] * scene.normal(contact)
        if np.ptp(slid) < width:
            away = (slid.min() + slid.max()) / 2 - slid
            centre = centre + away[:, None] * scene.tangent(contact)
        super().__init__(axes, scene, centre - width / 2, np.array([width, width]))
        axes.set(xticks=[], yticks=[])
        title_text = axes.text(
            0.04, 0.96, title, transform=axes.transAxes, ha="left", va="top", fontsize=7.5, zorder=9
        )
        title_text.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.8})
        make_legible(title_text)
        (self.tip,) = axes.plot([], [], "o", color="black", markersize=4, zorder=4)

    def _marked(self) -> dict[str, int]:
        return {self.contact: TICKS} if self.contact in self.scene.grounds else {}

    def show(self, i: int) -> None:
        """Set bodies, marks and the point that touches to the frame i."""
        super().show(i)
        self.tip.set_data(*self.scene.place(self.contact)[i][:, None])


@dataclass(frozen=True)
class _Frame:
    """View of a film: lower left corners over the frames, size, and insets.

    Corners and size are in m; places and the share of an inset are parts of the view.
    """

    corner: Array
    size: Array
    share: Array
    insets: list[Array]

    @property
    def ratio(self) -> float:
        """Height of the view in units of its width."""
        return float(self.size[1] / self.size[0])

    @classmethod
    def of(cls, scene: Scene, insets: int) -> _Frame:
        """Return the view of a scene, wider where the insets would hide bodies."""
        outline = scene.outline()
        for stretch in (1.0, 1.4, 1.8):
            corner, size = scene.window
            wanted = size * np.array([stretch, 1.0])
            ratio = float(np.clip(wanted[1] / wanted[0], 0.35, 0.9))
            shown = np.array([1.0, ratio]) * max(wanted[0], wanted[1] / ratio)
            low = corner + (size - shown) / 2
            side = min(INSET, 0.5 * ratio)
            share = np.array([side, side / ratio])
            places = (outline - low[:, None]) / shown
            corners = [np.array([x, y]) * (1 - share) for y in (1, 0) for x in (1, 0)]
            crowded = [_count_within(places, at, share) for at in corners]
            order = np.argsort(crowded, kind="stable")[:insets]
            frame = cls(low, shown, share, [corners[k] for k in order])
            if not any(crowded[k] for k in order):
                break
        return frame


def _count_within(places: Array, low: Array, size: Array) -> int:
    inside = (places >= low - 0.02) & (places <= low + size + 0.02)
    return int(inside.all(axis=2).sum())


def moments(
    events: Sequence[tuple[float, str, str]], times: Array
) -> list[tuple[int, list[tuple[str, str]]]]:
    """Return the frames at which events are first shown, each with labels and contacts."""
    shown: dict[int, list[tuple[str, str]]] = {}
    for time, label, contact in events:
        frame = int(np.clip(np.searchsorted(times, time), 0, len(times) - 1))
        entry = (label, contact)
        if entry not in shown.setdefault(frame, []):
            shown[frame].append(entry)
    return sorted(shown.items())


def _artist(axes: Axes, shape: Shape) -> Any:
    look: dict[str, Any] = {"edgecolor": "black", "facecolor": "#D9D9D9", "linewidth": 1.0}
    if shape.kind is ShapeKind.POLYGON:
        return axes.add_patch(Polygon(np.zeros((3, 2)), closed=True, zorder=3, alpha=0.9, **look))
    if shape.kind is ShapeKind.DISC:
        circle = axes.add_patch(Circle((0, 0), 1.0, zorder=3, alpha=0.9, **look))
        (mark,) = axes.plot([], [], color="black", linewidth=1.0, zorder=3.1)
        return circle, mark
    if shape.kind is ShapeKind.DOT:
        return axes.plot([], [], "o", color="black", markersize=5, zorder=4)[0]
    if shape.kind is ShapeKind.PIN:
        pin: dict[str, Any] = {"markerfacecolor": "white", "markeredgecolor": "black"}
        return axes.plot([], [], "^", markersize=9, zorder=4, **pin)[0]
    return axes.plot([], [], color="black", linewidth=3.2, solid_capstyle="round", zorder=3.5)[0]


def _move(shape: Shape, artist: Any, points: Array) -> None:
    if shape.kind is ShapeKind.POLYGON:
        artist.set_xy(points)
    elif shape.kind is ShapeKind.DISC:
        circle, mark = artist
        circle.set_center(points[0])
        circle.set_radius(float(np.linalg.norm(points[1] - points[0])))
        mark.set_data(*points.T)
    else:
        artist.set_data(*points.T)


class _Arrows:
    """Forces, slip direction and flash of one contact."""

    def __init__(self, axes: Axes, scene: Scene, contact: str, size: Array) -> None:
        self.contact, self.axes = contact, axes
        self.place, self.normal = scene.place(contact), scene.normal(contact)
        self.tangent = scene.tangent(contact)
        self.force = scene.of_contact("normal_force", contact)
        self.friction = scene.of_contact("tangential_force", contact)
        self.slip = scene.of_contact("slip_velocity", contact)
        forces = [
            scene.of_contact(f"{k}_force", c)
            for c in scene.contacts
            for k in ("normal", "tangential")
        ]
        self.largest = max(float(np.nanmax(np.abs(f))) for f in forces) or 1.0
        self.length = scene.longest_arrow
        speeds = np.abs(self.slip)
        travel = scene.reach / float(scene.times[-1] - scene.times[0])
        self.sliding = speeds > 1e-6 * max(float(np.nanmax(speeds)), travel)
        self.offset = 0.035 * float(size[0])
        look = _VECTOR | {"minlength": 0, "zorder": 5}
        self.arrows = [
            axes.quiver([0], [0], [0], [0], color=c, **look) for c in (NORMAL, TANGENTIAL, SLIP)
        ]
        (self.ring,) = axes.plot([], [], "o", markerfacecolor="none", color=EVENT, zorder=6)
        (self.stuck,) = axes.plot([], [], "s", color=SLIP, markersize=3.5, zorder=5)
        self.artists: list[Any] = [*self.arrows, self.ring, self.stuck]
        if len(scene.contacts) > 1:
            colour = CONTACTS[scene.contacts.index(contact) % len(CONTACTS)]
            self.name = axes.text(0, 0, figure_text(contact), color=colour, zorder=6, fontsize=8)
            self.name.set(ha="center", va="center")
            make_legible(self.name)
            self.artists.append(self.name)

    def _arrow_length(self, force: float) -> float:
        share = 1 + np.log10(max(abs(force) / self.largest, 1e-300)) / FORCE_DECADES
        return float(np.sign(force) * self.length * max(share, 0.0))

    def show(self, i: int, age: float | None) -> None:
        """Draw the frame i; `age` in [0, 1) is that of the last event."""
        closed = abs(self.force[i]) > 1e-12 * self.largest
        vectors = (
            (self.place[i], self.normal[i] * self._arrow_length(float(self.force[i]))),
            (self.place[i], self.tangent[i] * self._arrow_length(float(self.friction[i]))),
            (
                self.place[i] - self.normal[i] * self.offset,
                self.tangent[i] * np.sign(self.slip[i]) * 2.2 * self.offset,
            ),
        )
        shown = (closed, closed, closed and self.sliding[i])
        for arrow, (at, vector), visible in zip(self.arrows, vectors, shown, strict=True):
            arrow.set_offsets([at])
            arrow.set_UVC([vector[0]], [vector[1]])
            arrow.set_visible(bool(visible) and bool(np.linalg.norm(vector) > 0.06 * self.length))
        below = vectors[2][0]
        if len(self.artists) > len(self.arrows) + 2:
            self.name.set_position(tuple(below - 1.2 * self.offset * self.normal[i]))
        self.stuck.set_data([below[0]], [below[1]])
        self.stuck.set_visible(bool(closed and not self.sliding[i]))
        self.ring.set_visible(age is not None)
        if age is not None:
            self.ring.set_data([self.place[i, 0]], [self.place[i, 1]])
            self.ring.set_markersize(6 + 22 * age)
            self.ring.set_markeredgewidth(2.2 * (1 - age) + 0.2)
