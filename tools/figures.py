"""Every figure of the pages and of the gallery, drawn again: `make figures`.

`python tools/figures.py NAME ...` draws those whose file contains a NAME. Studies that keep their
numbers are drawn from them; the others are computed. Commands are those that the pages show.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[1]
FIGURES, STUDIES = Path("docs/figures"), Path("examples/studies")
COLOURS = 256
"""Colours of a PNG in the repository: what is drawn has fewer, blended with paper."""

COMMANDS = {
    "rod-map.png": "map rod --over theta,theta_dot --range theta=0.1:1.5,theta_dot=-5:5 --out",
    "bead-map.png": "map examples/mechanisms/bead-in-groove.toml --over phi,phi_dot "
    "--range phi_dot=-8:8 --set mu=1.5 --slip 1 --out",
    "two-contacts-rocking.png": "simulate block-two-feet --state theta=0.1 --law rigid --t-end 2 "
    "--set beta=0,h=0.3,mu_A=1.5,mu_B=1.5 --law-set e_energetic=0 --plot",
    "robot-foot.png": "robot examples/robots/quadruped.urdf --contact LF_foot --pose standing "
    "--mu 2 --out",
    "fit-force.png": "fit examples/studies/fit/force.csv rod --law bilinear-hertz "
    "--state theta=1,theta_dot=1,x_A_dot=-1,y_A_dot=-0.02 --estimate e_energetic,mu,E "
    "--law-set E=5e10,e_energetic=0.5 --set mu=1.35 --out",
}
"""Commands of `painleve` without the name of their file, by the figure in docs/figures."""

PAGES = {"explorer-rod.png": "explore rod --out"}
"""Commands that write a page of which a figure is the picture in Chromium."""

ITEMS = {"table-3-impact.png": "fig-8", "jump-convergence.png": "jump-convergence"}
"""Items of `painleve reproduce`, by the figure in docs/figures."""


@dataclass(frozen=True)
class Script:
    """A script that draws figures, with ``{}`` in its arguments for the folder it writes to.

    `figures` are committed paths, whose names the script gives its figures.
    """

    path: str
    arguments: str
    figures: tuple[Path, ...]


def _beside(folder: str, name: str) -> tuple[Path, ...]:
    return (STUDIES / folder / f"{name}.png",)


def _of_pages(*names: str) -> tuple[Path, ...]:
    return tuple(FIGURES / f"{name}.png" for name in names)


SCRIPTS = (
    Script("bench_rod/bench_rod.py", "--draw --out {}", _beside("bench_rod", "bench-rod")),
    Script("rigid_rod/rigid_rod.py", "--draw --out {}", _beside("rigid_rod", "rigid-rod")),
    Script(
        "rigid_rod/landing.py",
        "--draw --out {}",
        (*_beside("rigid_rod", "landing"), *_beside("rigid_rod", "landing-maps")),
    ),
    Script(
        "paradox_in_space/paradox_in_space.py",
        "--draw --out {}",
        _beside("paradox_in_space", "paradox-in-space"),
    ),
    Script("singular_point/fates.py", "--draw --out {}", _beside("singular_point", "fates")),
    Script("reverse_chatter/growth.py", "--draw --out {}", _beside("reverse_chatter", "growth")),
    Script(
        "tangential_compliance.py",
        "--draw --out {}/tangential-compliance",
        _of_pages("tangential-compliance"),
    ),
    Script("sensitive_impact.py", "{}/sensitive-impact", _of_pages("sensitive-impact")),
    Script("optimal_control.py", "{}/optimal-control", _of_pages("optimal-control")),
    Script("block_on_belt.py", "{}/block-on-belt", _of_pages("block-on-belt")),
    Script("sticking_feet.py", "{}/sticking-feet", _of_pages("sticking-feet")),
    Script("woodpecker.py", "{}/woodpecker", _of_pages("woodpecker")),
    Script("impact_energy.py", "3000 1 {}/impact-energy", _of_pages("impact-energy")),
    Script("impact_in_space.py", "1000 {}/impact-in-space", _of_pages("impact-in-space")),
    Script("corrected_jump/corrected_jump.py", "{}", _of_pages("corrected-jump")),
    Script(
        "critical_force/study.py",
        "{}",
        _of_pages(
            *(f"critical-force-{n}" for n in ("convergence", "growth", "map-E", "map-approach"))
        ),
    ),
)
NUMERICS = ("error-against-cost.png", "event-times.png", "start-of-contact.png")
"""Figures of docs/numerics.md, drawn from docs/numerics.json."""


def recipes() -> Iterator[tuple[tuple[Path, ...], Callable[[Path], None]]]:
    """Yield committed figures, and what draws them into a folder by their names."""
    commands = {**COMMANDS, **dict(films())}
    for name, command in commands.items():
        yield (FIGURES / name,), partial(run_command, command, name)
    for name, command in PAGES.items():
        yield (FIGURES / name,), partial(run_screenshot, command, name)
    for name, item in ITEMS.items():
        yield (FIGURES / name,), partial(run_item, item, name)
    for script in SCRIPTS:
        yield script.figures, partial(run_script, script)
    yield tuple(FIGURES / name for name in NUMERICS), partial(run_page, "numerics_page")
    for name in ("peers", "contact-solvers"):
        yield (FIGURES / f"{name}.png",), partial(run_page, f"{name.replace('-', '_')}_page")


def films() -> Iterator[tuple[str, str]]:
    """Yield the films of docs/animation.md and of everyday mechanisms with their commands."""
    docs = ROOT / "docs"
    for page in (docs / "animation.md", *sorted((docs / "everyday").glob("*.md"))):
        folder = "everyday/" if page.parent.name == "everyday" else ""
        text = page.read_text("utf-8")
        for command, name in re.findall(r"^painleve (animate .* --out) (\S+\.gif)$", text, re.M):
            yield folder + name, command


def run_command(command: str, name: str, folder: Path) -> None:
    """Run a command of `painleve` that ends with the name of its file."""
    _python("-m", "painleve_sym", *shlex.split(command), str(folder / Path(name).name))


def run_screenshot(command: str, name: str, folder: Path) -> None:
    """Write a page and take its picture in Chromium."""
    page = folder / "page.html"
    _python("-m", "painleve_sym", *shlex.split(command), str(page))
    browser = shutil.which("chromium") or shutil.which("chromium-browser")
    if browser is None:
        raise SystemExit("figures: needs Chromium. Fix: make setup-browser.")
    options = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run")
    places = (f"--user-data-dir={folder / 'profile'}", f"--screenshot={folder / name}")
    size = ("--window-size=1200,1180", "--virtual-time-budget=8000")
    words = [browser, *options, *places, *size, page.as_uri()]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def run_item(item: str, name: str, folder: Path) -> None:
    """Reproduce an item and keep its figure."""
    _python("-m", "painleve_sym", "reproduce", "--only", item, "--out", str(folder))
    (folder / "figures" / f"{item}.png").rename(folder / name)


def run_script(script: Script, folder: Path) -> None:
    """Run a study."""
    arguments = script.arguments.format(folder).split()
    _python(str(STUDIES / script.path), *arguments)


def run_page(page: str, folder: Path) -> None:
    """Draw the kept numbers of a page of the benchmarks."""
    _python("-m", f"tests.benchmarks.{page}", "--figures", str(folder))


def _python(*words: str) -> None:
    print("python", *words, flush=True)
    subprocess.run([sys.executable, *words], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def place(drawn: Path, figure: Path) -> None:
    """Move a figure to its place; a PNG with as few colours as it has."""
    if drawn.suffix == ".png":
        with Image.open(drawn) as image:
            flat = image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
            flat.save(drawn, optimize=True, dpi=image.info.get("dpi", (96, 96)))
    shutil.move(drawn, ROOT / figure)


def main(wanted: Sequence[str]) -> None:
    """Draw the figures whose file contains one of the texts; all without any."""
    for figures, draw in recipes():
        chosen = [f for f in figures if not wanted or any(text in f.name for text in wanted)]
        if chosen:
            with tempfile.TemporaryDirectory() as folder:
                draw(Path(folder))
                for figure in chosen:
                    place(Path(folder) / figure.name, figure)


if __name__ == "__main__":
    main(sys.argv[1:])
