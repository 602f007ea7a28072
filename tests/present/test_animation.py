"""Animations: the time law, the places of bodies, the files, and the page that shows them."""

from __future__ import annotations

import math
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from painleve_sym import InputError, Trajectory, load_mechanism, model, simulate
from painleve_sym.__main__ import main
from painleve_sym.mechanics.models import MODELS
from painleve_sym.present import animation
from painleve_sym.present.animation import Animation

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "animation.md").read_text("utf-8")
QUICK_FILMS = ("rod", "strut", "painleve-klein", "block-two-feet")
COMMANDS = re.findall(r"^painleve animate .*$", PAGE, re.M)


@pytest.fixture(scope="module")
def bounce() -> Trajectory:
    return simulate("rod", "bilinear-hertz", {"y_A": 0.05, "theta": 1.0}, t_end=0.2)


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=() if n in QUICK_FILMS else pytest.mark.slow) for n in MODELS],
)
def test_every_named_mechanism_has_a_film(name, tmp_path):
    run = simulate(name, "rigid", None, t_end=0.05)
    run.animate(duration=0.2, width=200).save(tmp_path / "film.gif")
    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == 2 and film.width == 200


def test_gif_has_its_frames_and_size(bounce, tmp_path):
    path = tmp_path / "film.gif"
    bounce.animate(duration=1.0).save(path)
    with Image.open(path) as film:
        assert film.n_frames == 12
        assert film.width == 480
        assert film.info["duration"] == 80  # GIF counts hundredths of a second
        first = np.asarray(film.convert("RGB"))
    assert len(np.unique(first.reshape(-1, 3), axis=0)) > 10
    assert path.stat().st_size < 200_000


def test_equal_motions_give_equal_files(bounce, tmp_path):
    for name in ("a.gif", "b.gif"):
        bounce.animate(duration=0.3).save(tmp_path / name)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()


def test_page_needs_no_other_file(bounce, tmp_path):
    path = tmp_path / "film.html"
    bounce.animate(duration=0.5).save(path)
    text = path.read_text("utf-8")
    assert not re.search(r"(src|href)=\"(?!data:)", text) and "http" not in text
    assert text.count("iVBOR") >= 6
    assert "prefers-reduced-motion" in text and "<label>Time" in text
    # A clock beside the slider, in a page with the style of all.
    assert "<output>" in text and '"0.2 s"' in text and "system-ui" in text


def test_name_of_a_mechanism_is_text_in_the_page(tmp_path):
    text = (ROOT / "examples" / "mechanisms" / "rod.toml").read_text("utf-8")
    text = text.replace('"rod-from-file"', '"<script>alert(1)</script>"')
    (tmp_path / "rod.toml").write_text(text, "utf-8")
    run = simulate(load_mechanism(str(tmp_path / "rod.toml")), "rigid", None, t_end=0.01)
    assert "<script>alert" not in run.animate(duration=0.2).html()


def test_video_has_its_frames(bounce, tmp_path):
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "film.mp4"
    bounce.animate(duration=0.5, width=240).save(path)
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert frames == 6 and seconds == pytest.approx(0.5, abs=0.01)


def test_video_without_its_package_is_one_clear_sentence(bounce, tmp_path, monkeypatch):
    monkeypatch.setattr(animation.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"needs the package imageio-ffmpeg.*painleve-sym\[film\]"):
        bounce.animate(duration=0.2).save(tmp_path / "film.mp4")
    assert not list(tmp_path.iterdir())


def test_faults_of_films(bounce, tmp_path):
    with pytest.raises(InputError, match=r"got '.bmp', need one of \.gif, \.mp4, \.html"):
        bounce.animate().save(tmp_path / "film.bmp")
    with pytest.raises(InputError, match="duration: got -1"):
        bounce.animate(duration=-1)
    with pytest.raises(InputError, match="width: got 5"):
        bounce.animate(width=5)
    with pytest.raises(InputError, match="need that of the trajectory, 'rod'"):
        Animation(bounce, model("block"))
    bounce.save(tmp_path / "run.npz")
    loaded = Trajectory.load(tmp_path / "run.npz")
    with pytest.raises(InputError, match="do not keep the mechanism"):
        loaded.animate()
    again = loaded.animate(model("rod"), duration=0.3).frames()
    same = bounce.animate(duration=0.3).frames()
    assert all((a == b).all() for a, b in zip(again, same, strict=True))


def test_motion_without_recorded_steps_is_nothing_to_draw():
    run = simulate("rod", "rigid", {"y_A": 0.1, "theta": 1.0}, t_end=0.1, record="end")
    with pytest.raises(InputError, match="holds no steps"):
        run.animate()


def test_page_of_animations_names_its_figures():
    figures = re.findall(r"\]\((figures/[\w-]+\.gif)\)", PAGE)
    assert len(set(figures)) == 6 == len(COMMANDS)
    for name in figures:
        path = ROOT / "docs" / name
        assert path.stat().st_size < 1_000_000
        assert path.name in PAGE.replace(f"]({name})", "")


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_of_the_page(command, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = shlex.split(command)[1:]
    words[words.index("--duration") + 1] = "0.2"
    assert main([*words, "--width", "200", "--json"]) == 0
    assert '"frames": 2' in capsys.readouterr().out
    (file,) = tmp_path.glob("*.gif")
    assert file.name == words[words.index("--out") + 1]


def test_command_says_what_it_wrote(tmp_path, capsys):
    out = tmp_path / "rod.html"
    words = "animate rod --law rigid --t-end 0.02 --duration 0.2 --out"
    assert main([*words.split(), str(out)]) == 0
    shown = capsys.readouterr().out
    assert "2 frames, 0.2 s at 12 per second" in shown
    assert f"film written to {out}" in " ".join(shown.split())
    assert math.isclose(out.stat().st_size, 20_000, rel_tol=0.9)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--out", "film.bmp"], "has the suffix '.bmp', need one of .gif, .mp4, .html"),
        (["--out", "film.gif", "--duration", "999"], "duration: got 999.0"),
        (["--out", "film.gif", "--width", "1e8"], "need a whole number from 200 to 2000"),
        ([], "the following arguments are required: --out"),
    ],
)
def test_bad_options_end_with_2(words, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["animate", "rod", "--law", "rigid", "--t-end", "0.02", *words]) == 2
    assert message in capsys.readouterr().err
