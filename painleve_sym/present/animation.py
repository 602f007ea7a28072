"""Animations of motions: the bodies, the forces on their contacts, and a magnified time."""

from __future__ import annotations

import base64
import io
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO

import matplotlib
import numpy as np
from matplotlib.animation import FFMpegWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from painleve_sym.arrays import Array
from painleve_sym.checks import number, whole_number
from painleve_sym.codegen.pointwise import Pointwise
from painleve_sym.errors import InputError
from painleve_sym.escape import html_text as escape
from painleve_sym.files import write_beside
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.shapes import (
    PLACE,
    Shape,
    ShapeKind,
    contact_geometries,
    scene_formulas,
    shapes_of,
)
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.present.style import PALETTE, REFERENCE, STYLE, event_label
from painleve_sym.quantities import text_label

FORMATS = (".gif", ".mp4", ".html")
DPI = 100
FLASH = 0.45
"""Time that an event is shown; s of the film."""
MAX_MAGNIFIED = 24
"""Maximum number of events around which the time is magnified."""
SHARES = (0.35, 0.35, 0.3)
"""Parts of the film in proportion to time, to steps of the integration, and near events."""
SHORTEST = 1e-6
"""Part of the motion below which steps and events are not magnified further."""
STEP_POWER = 0.25
"""Power of the length of a step to which its time in the film is in proportion."""
FORCE_DECADES = 3.0
"""Forces smaller than the largest by this many decades have arrows of no length."""
FINER = 12
"""Points per frame of the curves over the film."""
GROUND = 0.88
"""Grey of what lies behind a surface."""
NORMAL, TANGENTIAL, SLIP = PALETTE[1], PALETTE[2], PALETTE[3]


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
    scales: Array = np.clip(np.minimum(gaps[:-1], gaps[1:]), shortest, longest)
    return scales


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
        values = self._values
        rows = Pointwise(list(formulas.values()), list(values), engine="casadi")(values)
        return dict(zip(formulas, rows, strict=True))

    @cached_property
    def outputs(self) -> dict[str, Array]:
        """Outputs of the motion at the times by name, each of shape (frames,)."""
        return self.trajectory.outputs(self.times)

    def of_contact(self, name: str, contact: str) -> Array:
        """Return an output of one contact, shape (frames,)."""
        several = len(self.trajectory.names.contacts) > 1
        return self.outputs[f"{name}_{contact}" if several else name]

    def points(self, i: int) -> Array:
        """Return the points of a shape, shape (frames, points, 2); m."""
        count = len(self.shapes[i].points)
        names = [[f"shape_{i}_point_{k}_{axis}" for axis in "xy"] for k in range(count)]
        return np.array([[self._places[n] for n in pair] for pair in names]).transpose(2, 0, 1)

    def place(self, contact: str) -> Array:
        """Return the point of a contact, shape (frames, 2); m."""
        return np.stack([self._places[f"{contact}_{axis}"] for axis in "xy"], axis=1)

    def normal(self, contact: str) -> Array:
        """Return the unit vector of the normal force, shape (frames, 2)."""
        return np.stack([self._places[f"{contact}_normal_{axis}"] for axis in "xy"], axis=1)

    def tangent(self, contact: str) -> Array:
        """Return the unit vector of positive slip and tangential force, shape (frames, 2)."""
        normal = self.normal(contact)
        return np.stack([normal[:, 1], -normal[:, 0]], axis=1)

    @cached_property
    def _levels(self) -> dict[str, Pointwise]:
        geometries = contact_geometries(self.mechanism)
        symbols = [*PLACE, *self._values]
        return {
            name: Pointwise([geometry.surface], symbols, engine="casadi")
            for name, geometry in geometries.items()
        }

    def level(self, contact: str, frame: int, x: Array, y: Array) -> Array:
        """Return the function of a surface at places: zero on it, positive on its free side."""
        now = {s: v if np.ndim(v) == 0 else v[frame] for s, v in self._values.items()}
        values: Array = self._levels[contact](now | dict(zip(PLACE, (x, y), strict=True)))[0]
        return values

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


@dataclass(frozen=True)
class Animation:
    """A film of a motion with steps, to be saved or shown in a notebook.

    The film lasts `duration`, s, at `rate` frames per second, and is `width` pixels wide.
    """

    trajectory: Trajectory
    mechanism: Mechanism
    duration: float = 8.0
    rate: int = 12
    width: int = 480

    def __post_init__(self) -> None:
        where = "animation"
        number(self.duration, "duration", where=where, above=0.0, upper=120.0)
        whole_number(self.rate, "rate", where=where, lower=1, upper=60)
        whole_number(self.width, "width", where=where, lower=200, upper=2000)
        if not len(self.trajectory.step_time):
            raise InputError(
                "animation: the trajectory holds no steps, so there is no motion to draw. "
                "Fix: start elsewhere, or simulate with record='dense'."
            )
        missing = [s for s in self.mechanism.state_names if s not in self.trajectory.state_names]
        if missing or self.mechanism.name != self.trajectory.mechanism:
            raise InputError(
                f"animation: got the mechanism {self.mechanism.name!r}, need that of the "
                f"trajectory, {self.trajectory.mechanism!r}."
            )

    @cached_property
    def scene(self) -> Scene:
        """Places and forces at the times of the frames."""
        frames = max(2, round(self.duration * self.rate))
        return Scene(self.trajectory, self.mechanism, film_times(self.trajectory, frames))

    def frames(self) -> list[Array]:
        """Return the pixels of every frame, each of shape (height, width, 3)."""
        with matplotlib.rc_context(_STYLE):
            picture = _Picture(self.scene, self.width, self.rate)
            return [picture.pixels(i) for i in range(len(self.scene.times))]

    def still(self, frame: int = 0) -> Figure:
        """Return one frame as a figure."""
        with matplotlib.rc_context(_STYLE):
            return _Picture(self.scene, self.width, self.rate).still(frame)

    def images(self) -> list[Any]:
        """Return every frame as an image of Pillow, all with one palette."""
        from PIL import Image

        palette = Image.new("P", (1, 1))
        palette.putpalette(_palette())
        pictures = map(Image.fromarray, self.frames())
        return [p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures]

    def save(self, path: str | Path) -> None:
        """Write the film as GIF, MP4 or HTML, as the suffix says: whole, or not at all.

        InputError for another suffix, a folder that cannot be written, or no ffmpeg for an MP4.
        """
        path = Path(path)
        suffix = path.suffix.lower()
        if suffix not in FORMATS:
            raise InputError(f"animation {path}: got {suffix!r}, need one of {', '.join(FORMATS)}.")
        check_encoder(suffix)
        if suffix == ".html":
            text = self._page()
            write_beside(path, lambda file: file.write(text.encode()))
        elif suffix == ".gif":
            write_beside(path, self._write_gif)
        else:
            self._save_video(path)

    def _write_gif(self, file: BinaryIO) -> None:
        first, *others = self.images()
        options: dict[str, Any] = {"duration": round(1000 / self.rate), "loop": 0}
        first.save(file, "GIF", save_all=True, append_images=others, **options)

    def _save_video(self, path: Path) -> None:
        frames = self.frames()
        figure = Figure(figsize=(frames[0].shape[1] / DPI, frames[0].shape[0] / DPI), dpi=DPI)
        shown, writer = figure.figimage(frames[0]), FFMpegWriter(fps=self.rate)
        with tempfile.TemporaryDirectory() as folder:
            video = Path(folder) / "film.mp4"
            with writer.saving(figure, str(video), DPI):
                for frame in frames:
                    shown.set_data(frame)
                    writer.grab_frame()
            content = video.read_bytes()
        write_beside(path, lambda file: file.write(content))

    def title(self) -> str:
        """Return the mechanism and its law in words."""
        return f"motion of {self.trajectory.mechanism}, law {self.trajectory.law}"

    def _page(self) -> str:
        title = escape(self.title())
        head = f'<head><meta charset="utf-8"><title>{title}</title></head>'
        body = f"<body><main><h1>{title}</h1>{self.html()}</main></body>"
        return f'<!DOCTYPE html>\n<html lang="en">{head}{body}</html>\n'

    def html(self) -> str:
        """Return the film as HTML with play, pause and a slider; it needs no other file."""
        frames = []
        for image in self.images():
            content = io.BytesIO()
            image.save(content, "PNG", optimize=True)
            frames.append(base64.b64encode(content.getvalue()).decode())
        data = ",".join(f'"{frame}"' for frame in frames)
        clock = ",".join(f'"{t:.6g} s"' for t in self.scene.times)
        player = _PLAYER.replace("FRAMES", data).replace("TIMES", clock)
        first = f'src="data:image/png;base64,{frames[0]}" alt="{escape(self.title())}"'
        return (
            f'<figure class="film"><img {first}>\n'
            f'<p><button type="button">Play</button> <label>Frame <input type="range" min="0" '
            f'max="{len(frames) - 1}" value="0"></label></p></figure>\n'
            f"<script>{player.replace('INTERVAL', str(round(1000 / self.rate)))}</script>"
        )

    def _repr_html_(self) -> str:
        """Return the film for notebooks."""
        return self.html()


def check_encoder(suffix: str) -> None:
    """Raise InputError where a file of this suffix cannot be written for want of a program."""
    if suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise InputError(
            "animation: an MP4 needs the program ffmpeg, which is not installed. "
            "Fix: install it, or name a file that ends in .gif or .html."
        )


_STYLE: Any = STYLE | {"figure.dpi": DPI, "savefig.dpi": DPI, "font.size": 8.0}


def _palette() -> list[int]:
    """Return the colours of a GIF as red, green, blue in turn: those drawn, blended with paper."""
    drawn = [*matplotlib.colors.to_rgba_array([*PALETTE, REFERENCE])[:, :3]]
    papers = [np.ones(3), np.full(3, GROUND)]
    shades = [p * (1 - k) + c * k for p in papers for c in drawn for k in np.arange(1, 9) / 8]
    greys = [np.full(3, g) for g in np.linspace(0.5, 1, 16)]
    return [round(float(v) * 255) for shade in (*papers, *shades, *greys) for v in shade]


_PLAYER = """
(() => {
  const film = document.currentScript.previousElementSibling;
  const [image, button, slider] = ["img", "button", "input"].map((n) => film.querySelector(n));
  const frames = [FRAMES], times = [TIMES];
  let timer = null;
  const show = (i) => {
    slider.value = i;
    slider.setAttribute("aria-valuetext", times[i]);
    image.src = "data:image/png;base64," + frames[i];
  };
  const stop = () => { clearInterval(timer); timer = null; button.textContent = "Play"; };
  const play = () => {
    button.textContent = "Pause";
    timer = setInterval(() => show((Number(slider.value) + 1) % frames.length), INTERVAL);
  };
  button.addEventListener("click", () => (timer === null ? play() : stop()));
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
  show(0);
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play();
})();
"""


class _Picture:
    """The figure of a film: the mechanism above, the normal forces over the film below."""

    def __init__(self, scene: Scene, width: int, rate: int) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        self.scene, self.rate = scene, rate
        corner, size = scene.window
        inches = width / DPI
        ratio = float(np.clip(size[1] / size[0], 0.35, 0.9))
        # Whole numbers of pixels that are even, which video needs.
        height = 2 * round((width * 0.9 * ratio + 165) / 2) / DPI
        self.figure = Figure(figsize=(inches, height))
        self.canvas: Any = FigureCanvasAgg(self.figure)
        self.background: Any = None
        below = 1.02 / height
        self.view = self.figure.add_axes(
            (0.05, below + 0.16 / height, 0.9, 0.9 * inches * ratio / height)
        )
        self.strip = self.figure.add_axes((0.14, 0.38 / height, 0.81, 0.56 / height))
        self._prepare_view(corner, size, ratio)
        self._prepare_strip()
        moving_ground = scene.mechanism.depends_on_time and bool(scene.contacts)
        self.moves = moving_ground or bool((np.ptp(self.corner, axis=0) > 0).any())
        for artist in (*self.dynamic, self.cursor, self.clock, self.label):
            artist.set_animated(True)

    def still(self, i: int) -> Figure:
        """Return the figure of the frame i."""
        self._show_place(i)
        self._show(i)
        for artist in (*self.dynamic, self.cursor, self.clock, self.label):
            artist.set_animated(False)
        return self.figure

    def pixels(self, i: int) -> Array:
        """Return the pixels of the frame i, shape (height, width, 3)."""
        if self.moves or self.background is None:
            self._show_place(i)
            self.canvas.draw()
            self.background = self.canvas.copy_from_bbox(self.figure.bbox)
        self.canvas.restore_region(self.background)
        self._show(i)
        for axes in (self.view, self.strip):
            for artist in axes.get_children():
                if artist.get_animated():
                    axes.draw_artist(artist)
        for text in (self.clock, self.label):
            self.figure.draw_artist(text)
        pixels: Array = np.asarray(self.canvas.buffer_rgba())[..., :3].copy()
        return pixels

    def _prepare_view(self, corner: Array, size: Array, ratio: float) -> None:
        scene, axes = self.scene, self.view
        width = max(size[0], size[1] / ratio)
        self.size = np.array([width, width * ratio])
        self.corner = corner + (size - self.size) / 2
        axes.set_aspect("equal")
        axes.tick_params(
            labelleft=False, left=False, right=False, top=False, labelsize=6.5, length=2
        )
        for side in ("left", "right", "top"):
            axes.spines[side].set_visible(False)
        axes.grid(axis="x", color="0.93", linewidth=0.6, zorder=0)
        axes.xaxis.set_major_formatter("{x:.3g} m")
        self.ground: list[Any] = []
        self.guides = {c.name for c in scene.mechanism.outline.contacts if c.bilateral}
        before = set(axes.get_children())
        self.artists = [_artist(axes, shape) for shape in scene.shapes]
        self.arrows = [_Arrows(axes, scene, c, self.size) for c in scene.contacts]
        self.dynamic = [a for a in axes.get_children() if a not in before]
        self.clock = self.figure.text(0.05, 0.985, "", ha="left", va="top", fontsize=9)
        self.label = self.figure.text(
            0.95, 0.985, "", ha="right", va="top", fontsize=9, color=PALETTE[4]
        )
        keys = (("$F_n$", NORMAL), ("$F_t$", TANGENTIAL), ("slip", SLIP))
        for k, (text, colour) in enumerate(keys if scene.contacts else ()):
            axes.text(
                0.01,
                0.93 - 0.075 * k / ratio * 0.5,
                text,
                color=colour,
                transform=axes.transAxes,
                fontsize=8,
            )

    def _prepare_strip(self) -> None:
        scene, axes = self.scene, self.strip
        film = np.linspace(0, (len(scene.times) - 1) / self.rate, FINER * len(scene.times))
        fine = scene.trajectory.outputs(film_times(scene.trajectory, len(film)))
        several = len(scene.contacts) > 1
        scale, unit = 1.0, "N"
        end = "_{}" if len(scene.trajectory.names.contacts) > 1 else ""
        forces = [fine["normal_force" + end.format(c)] for c in scene.contacts]
        if max((float(np.max(np.abs(f))) for f in forces), default=0.0) >= 2e3:
            scale, unit = 1e-3, "kN"
        for k, (name, force) in enumerate(zip(scene.contacts, forces, strict=True)):
            look: dict[str, Any] = {
                "color": NORMAL,
                "linestyle": ("solid", (0, (3, 2)), (0, (1, 1)))[k % 3],
            }
            axes.plot(film, force * scale, linewidth=1.0, label=name if several else "_", **look)
        self.moments = _moments(self.trajectory_events(), scene.times)
        rug = [moment / self.rate for moment, _ in self.moments]
        where = axes.get_xaxis_transform()
        axes.vlines(rug, 0.86, 1.0, color=PALETTE[4], linewidth=0.8, transform=where)
        self.cursor = axes.axvline(0, color="black", linewidth=0.9)
        axes.set_xlim(film[0], film[-1])
        if not any(f.any() for f in forces):
            axes.set_ylim(0, 1)
        axes.set_ylabel(text_label("$F_n$", unit), fontsize=7.5)
        axes.tick_params(labelsize=6.5, length=2, pad=2)
        axes.locator_params(axis="y", nbins=3)
        ticks = np.linspace(0, len(scene.times) - 1, 6).round().astype(int)
        self.unit, factor = _time_unit(float(scene.times[-1] - scene.times[0]))
        self.factor = factor
        axes.set_xticks(ticks / self.rate, [f"{scene.times[i] * factor:.3g}" for i in ticks])
        axes.set_xlabel(
            text_label("time, magnified where it is short", self.unit), fontsize=7, labelpad=1
        )
        if several:
            axes.legend(fontsize=6, loc="upper right", handlelength=1.6, ncols=3)

    def trajectory_events(self) -> list[tuple[float, str, str]]:
        """Return time, label and contact of every event that is shown."""
        return [
            (e.time, event_label(e.kind), e.contact)
            for e in self.scene.trajectory.events
            if e.kind != "contact"
        ]

    def _show_place(self, i: int) -> None:
        """Set view and ground of the frame i, which are drawn once where they stand still."""
        low, high = self.corner[i], self.corner[i] + self.size
        self.view.set_xlim(low[0], high[0])
        self.view.set_ylim(low[1], high[1])
        self._show_ground(i)

    def _show(self, i: int) -> None:
        """Set bodies, arrows and clock to the frame i."""
        scene = self.scene
        for k, (shape, artist) in enumerate(zip(scene.shapes, self.artists, strict=True)):
            _move(shape, artist, scene.points(k)[i])
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
        texts = list(
            dict.fromkeys(f"{t} ({c})" if c and len(self.arrows) > 1 else t for t, c, _ in recent)
        )
        self.label.set_text(", ".join(texts[-2:]))

    def _clock(self, i: int) -> str:
        times = self.scene.times
        j = min(max(i, 1), len(times) - 1)
        step = max(float(times[j] - times[j - 1]), 1e-300)
        digits = int(np.clip(np.ceil(-np.log10(step * self.factor)) + 1, 0, 9))
        slower = 1 / (step * self.rate)
        ratio = f"1 : {slower:.2g}" if slower < 10 else f"1 : {float(f'{slower:.1e}'):,.0f}"
        text = f"$t$ = {times[i] * self.factor:.{digits}f} {self.unit}"
        return text + (
            f"    slow motion {ratio}" if slower > 1.05 else f"    {1 / slower:.2g} times as fast"
        )

    def _show_ground(self, i: int) -> None:
        for artist in self.ground:
            artist.remove()
        self.ground = []
        low, size, axes = self.corner[i], self.size, self.view
        x, y = np.meshgrid(*(np.linspace(low[k], low[k] + size[k], 41) for k in range(2)))
        for contact in self.scene.contacts:
            level = self.scene.level(contact, i, x, y)
            if level.min() < 0 < level.max():
                lowest = [float(level.min()) - 1, 0.0]
                if contact not in self.guides:
                    self.ground.append(
                        axes.contourf(x, y, level, lowest, colors=[str(GROUND)], zorder=0.5)
                    )
                self.ground.append(
                    axes.contour(x, y, level, [0.0], colors=["0.35"], linewidths=0.9, zorder=1)
                )


def _moments(
    events: Sequence[tuple[float, str, str]], times: Array
) -> list[tuple[int, list[tuple[str, str]]]]:
    """Return the frames at which events are first shown, each with labels and contacts."""
    moments: dict[int, list[tuple[str, str]]] = {}
    for time, label, contact in events:
        frame = int(np.clip(np.searchsorted(times, time), 0, len(times) - 1))
        entry = (label, contact)
        if entry not in moments.setdefault(frame, []):
            moments[frame].append(entry)
    return sorted(moments.items())


def _time_unit(length: float) -> tuple[str, float]:
    for unit, factor in (("s", 1.0), ("ms", 1e3)):
        if length * factor >= 1:
            return unit, factor
    return "μs", 1e6


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
        look: dict[str, Any] = {
            "angles": "xy",
            "scale_units": "xy",
            "scale": 1,
            "width": 0.009,
            "minlength": 0,
            "zorder": 5,
        }
        self.arrows = [
            axes.quiver([0], [0], [0], [0], color=c, **look) for c in (NORMAL, TANGENTIAL, SLIP)
        ]
        (self.ring,) = axes.plot([], [], "o", markerfacecolor="none", color=PALETTE[4], zorder=6)
        (self.stuck,) = axes.plot([], [], "s", color=SLIP, markersize=3.5, zorder=5)

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
        self.stuck.set_data([below[0]], [below[1]])
        self.stuck.set_visible(bool(closed and not self.sliding[i]))
        self.ring.set_visible(age is not None)
        if age is not None:
            self.ring.set_data([self.place[i, 0]], [self.place[i, 1]])
            self.ring.set_markersize(6 + 22 * age)
            self.ring.set_markeredgewidth(2.2 * (1 - age) + 0.2)
