"""Animations of motions: the bodies, the forces on their contacts, and a magnified time."""

from __future__ import annotations

import base64
import importlib.util
import io
import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from painleve_sym.arrays import Array
from painleve_sym.checks import number, whole_number
from painleve_sym.errors import InputError, received
from painleve_sym.escape import html_text as escape
from painleve_sym.files import write_beside
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.present.film import DPI, GROUND, FilmPicture, mechanism_figure
from painleve_sym.present.page import HtmlPage
from painleve_sym.present.scene import Scene, film_times
from painleve_sym.present.style import CONTACTS, EVENT, NORMAL, REFERENCE, SLIP, STYLE, TANGENTIAL
from painleve_sym.quantities import scaled_unit

FORMATS = (".gif", ".mp4", ".html")


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
            picture = FilmPicture(self.scene, self.width, self.rate)
            return [picture.pixels(i) for i in range(len(self.scene.times))]

    def still(self) -> Figure:
        """Return a picture of the mechanism at the start, to scale, as a figure."""
        start = Scene(self.trajectory, self.mechanism, self.trajectory.t[:1])
        return mechanism_figure(start)

    def images(self) -> list[Any]:
        """Return every frame as an image of Pillow, all with one palette."""
        from PIL import Image

        palette = Image.new("P", (1, 1))
        palette.putpalette(_palette())
        pictures = map(Image.fromarray, self.frames())
        return [p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures]

    def save(self, path: str | Path) -> None:
        """Write the film as GIF, MP4 or HTML, as the suffix says: whole, or not at all.

        InputError for another suffix, a folder that cannot be written, or an MP4 where
        imageio-ffmpeg is not installed.
        """
        path = Path(path)
        suffix = path.suffix.lower()
        if suffix not in FORMATS:
            raise InputError(f"animation {path}: got {suffix!r}, need one of {', '.join(FORMATS)}.")
        check_encoder(suffix)
        if suffix == ".html":
            HtmlPage(self.title(), self.html()).write(path)
        elif suffix == ".gif":
            write_beside(path, self._write_gif)
        else:
            self._save_video(path)

    def _write_gif(self, file: BinaryIO) -> None:
        first, *others = self.images()
        options: dict[str, Any] = {"duration": round(1000 / self.rate), "loop": 0}
        first.save(file, "GIF", save_all=True, append_images=others, **options)

    def _save_video(self, path: Path) -> None:
        from imageio_ffmpeg import write_frames

        frames = self.frames()
        height, width = frames[0].shape[:2]
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "film.mp4"
            writer = write_frames(str(file), (width, height), fps=self.rate, macro_block_size=2)
            writer.send(None)
            for frame in frames:
                writer.send(np.ascontiguousarray(frame))
            writer.close()
            content = file.read_bytes()
        write_beside(path, lambda out: out.write(content))

    def title(self) -> str:
        """Return the mechanism and its law in words."""
        return f"motion of {self.trajectory.mechanism}, law {self.trajectory.law}"

    def html(self) -> str:
        """Return the film as HTML with play, pause and a slider; it needs no other file."""
        frames = []
        for image in self.images():
            content = io.BytesIO()
            # The ninth level takes twice the time, and gains a fiftieth.
            image.save(content, "PNG", compress_level=8)
            frames.append(base64.b64encode(content.getvalue()).decode())
        data = ",".join(f'"{frame}"' for frame in frames)
        times = self.scene.times
        factor, unit = scaled_unit("s", float(times[-1] - times[0]))
        clock = ",".join(f'"{t * factor:.4g} {unit}"' for t in times)
        player = _PLAYER.replace("FRAMES", data).replace("TIMES", clock)
        first = f'src="data:image/png;base64,{frames[0]}" alt="{escape(self.title())}"'
        return (
            f'<figure class="film"><img {first}>\n<div><button type="button">Play</button> '
            f'<label>Time <input type="range" min="0" max="{len(frames) - 1}" value="0"></label> '
            f"<output></output></div></figure>\n"
            f"<script>{player.replace('INTERVAL', str(round(1000 / self.rate)))}</script>"
        )

    def _repr_html_(self) -> str:
        """Return the film for notebooks."""
        return self.html()


def animated(
    trajectory: Trajectory, mechanism: Mechanism | None, duration: float, width: int
) -> Animation:
    """Return the film of a motion; see `Trajectory.animate`."""
    if mechanism is not None and not isinstance(mechanism, Mechanism):
        raise InputError(
            f"animation: mechanism: got {received(mechanism)}, need a Mechanism. "
            "Fix: to write a file, animate().save(...)."
        )
    drawn = mechanism or trajectory.subject
    if drawn is None:
        raise InputError(
            "animation: the trajectory comes from a file or another process, which do not "
            "keep the mechanism. Fix: give it, such as animate(model('rod'))."
        )
    return Animation(trajectory, drawn, duration=duration, width=width)


def check_encoder(suffix: str) -> None:
    """Raise InputError where a file of this suffix cannot be written for want of a package."""
    if suffix == ".mp4" and importlib.util.find_spec("imageio_ffmpeg") is None:
        raise InputError(
            "animation: an MP4 needs the package imageio-ffmpeg, which is not installed. "
            "Fix: pip install 'painleve-sym[film]', or name a file that ends in .gif or .html."
        )


_STYLE: Any = STYLE | {"figure.dpi": DPI, "savefig.dpi": DPI, "font.size": 8.0}


def _palette() -> list[int]:
    """Return the colours of a GIF as red, green, blue in turn: those drawn, blended with paper."""
    colours = dict.fromkeys((*CONTACTS[:3], NORMAL, TANGENTIAL, SLIP, EVENT, REFERENCE))
    drawn = [*matplotlib.colors.to_rgba_array(list(colours))[:, :3]]
    papers = [np.ones(3), np.full(3, GROUND)]
    shades = [p * (1 - k) + c * k for p in papers for c in drawn for k in np.arange(1, 7) / 6]
    greys = [np.full(3, g) for g in np.linspace(0.5, 1, 16)]
    return [round(float(v) * 255) for shade in (*papers, *shades, *greys) for v in shade]


_PLAYER = """
(() => {
  const film = document.currentScript.previousElementSibling;
  const [image, button, slider, clock] =
    ["img", "button", "input", "output"].map((n) => film.querySelector(n));
  const frames = [FRAMES], times = [TIMES];
  let timer = null;
  const show = (i) => {
    slider.value = i;
    slider.setAttribute("aria-valuetext", times[i]);
    clock.textContent = "t = " + times[i];
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
