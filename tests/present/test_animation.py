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
from painleve_sym.present.animation import (
    SHORTEST,
    Animation,
    Scene,
    film_times,
)

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "animation.md").read_text("utf-8")
COMMANDS = re.findall(r"^painleve animate .*$", PAGE, re.M)


@pytest.fixture(scope="module")
def bounce() -> Trajectory:
    return simulate("rod", "bilinear-hertz", {"y_A": 0.05, "theta": 1.0}, t_end=0.2)


def test_time_of_the_film_increases_from_start_to_end(bounce):
    times = film_times(bounce, 100)
    assert times[0] == bounce.t[0] and times[-1] == bounce.final_time
    assert (np.diff(times) > 0).all()


def test_impact_is_magnified(bounce):
    times = film_times(bounce, 200)
    events = [e.time for e in bounce.events]
    within = (times > events[0]) & (times < events[-1])
    share = (events[-1] - events[0]) / bounce.final_time
    assert np.mean(within) > 5 * share
    assert np.diff(times).min() > 0.01 * SHORTEST * bounce.final_time


def test_motion_without_events_keeps_its_pace():
    run = simulate("rod", "rigid", {"y_A": 1.0, "theta": 1.0, "theta_dot": 0.1}, t_end=0.1)
    steps = np.diff(film_times(run, 50))
    assert steps.max() < 10 * steps.min()


def test_places_are_those_of_the_kinematics(bounce):
    times = np.linspace(0, bounce.final_time, 7)
    scene = Scene(bounce, model("rod"), times)
    states = bounce(times)
    x, y, theta = states[:, :3].T
    upper = np.stack([x + 2 * np.cos(theta), y + 2 * np.sin(theta)], axis=1)
    assert abs(scene.points(0)[:, 0] - states[:, :2]).max() == 0
    assert abs(scene.points(0)[:, 1] - upper).max() < 1e-14
    assert abs(scene.place("A") - states[:, :2]).max() == 0
    assert abs(scene.normal("A") - [0, 1]).max() == 0
    assert abs(scene.tangent("A") - [1, 0]).max() == 0
    assert scene.level("A", 3, np.array([5.0]), np.array([0.25]))[0] == pytest.approx(0.25)


def test_view_holds_everything(bounce):
    film = bounce.animate(duration=1.0)
    corner, size = film.scene.window
    for points in (film.scene.points(0), film.scene.place("A")[:, None]):
        assert (points >= corner[:, None]).all()
        assert (points <= (corner + size)[:, None]).all()


def test_view_follows_what_travels_far():
    run = simulate("rod", "rigid", {"y_A": 1.0, "theta": 1.0, "x_A_dot": -200.0}, t_end=0.1)
    corner, size = run.animate(duration=1.0).scene.window
    assert np.ptp(corner[:, 0]) > 10
    assert size[0] < 5


@pytest.mark.parametrize("name", MODELS)
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
    assert "prefers-reduced-motion" in text and "<label>" in text


def test_name_of_a_mechanism_is_text_in_the_page(tmp_path):
    text = (ROOT / "examples" / "mechanisms" / "rod.toml").read_text("utf-8")
    text = text.replace('"rod-from-file"', '"<script>alert(1)</script>"')
    (tmp_path / "rod.toml").write_text(text, "utf-8")
    run = simulate(load_mechanism(str(tmp_path / "rod.toml")), "rigid", None, t_end=0.01)
    assert "<script>alert" not in run.animate(duration=0.2).html()


def test_video_needs_ffmpeg(bounce, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="MP4 needs the program ffmpeg"):
        bounce.animate(duration=0.2).save(tmp_path / "film.mp4")


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
