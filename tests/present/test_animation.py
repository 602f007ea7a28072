"""Animations: the time law, the places of bodies, the files, and the page that shows them."""

from __future__ import annotations

import math
import re
import shlex
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from PIL import Image

from painleve_sym import InputError, Trajectory, load_mechanism, model, simulate
from painleve_sym.__main__ import main
from painleve_sym.mechanics.models import MODELS
from painleve_sym.present import animation
from painleve_sym.present.animation import Animation
from painleve_sym.present.film import SLIP, FilmPicture, moments
from painleve_sym.present.scene import SHARES, SHORTEST, Scene, film_times
from painleve_sym.present.style import CONTACTS, NORMAL, STYLE, TANGENTIAL

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


def test_parts_of_the_film_are_those_of_time_steps_and_events():
    run = simulate("block-two-feet", "rigid", {"theta": 0.3}, t_end=1.4, parameters={"beta": 0.05})
    assert len(run.events) > 10
    frames = 200
    steps = np.diff(film_times(run, frames))
    # Time alone takes its share, so that no frame is longer than that.
    assert steps.max() < 1.02 * run.final_time / SHARES[0] / (frames - 1)


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


def picture(run, duration=1.0, **options):
    film = run.animate(duration=duration, **options)
    with matplotlib.rc_context(STYLE | {"figure.dpi": 100}):
        shown = FilmPicture(film.scene, film.width, film.rate)
        pixels = shown.pixels(len(film.scene.times) // 2)
    return film.scene, shown, pixels


@pytest.fixture(scope="module")
def slow():
    run = simulate("rod", "bilinear-hertz", {"theta": 1.0, "x_A_dot": -1.0}, t_end=0.01)
    return picture(run)


@pytest.fixture(scope="module")
def feet():
    return picture(simulate("block-two-feet", "hertz", None, t_end=0.02))


def texts(figure):
    return [t.get_text() for t in figure.findobj(matplotlib.text.Text) if t.get_text()]


def test_motion_too_small_to_see_has_an_inset_with_its_magnification(slow):
    scene, shown, _ = slow
    (inset,) = shown.insets
    way = float(np.ptp(scene.gap("A")))
    assert way < 0.001 * shown.view.size[0]
    assert way > 0.05 * inset.width or np.ptp(scene.slid("A")) > 0.3 * inset.width
    ratio = shown.view.axes.bbox.width / shown.view.size[0] * inset.width / inset.axes.bbox.width
    (title,) = inset.axes.texts
    assert float(title.get_text().strip("× ").replace(",", "")) == pytest.approx(
        1 / ratio, rel=0.06
    )


def test_magnified_contact_stays_inside_its_inset(slow, feet):
    for scene, shown, _ in (slow, feet):
        for inset in shown.insets:
            place = scene.place(inset.contact)
            assert ((place > inset.corner) & (place < inset.corner + inset.size)).all()


def test_marks_of_the_surface_slide_under_a_magnified_contact(slow):
    _, shown, _ = slow
    (inset,) = shown.insets
    tops = []
    for i in (0, 4):
        inset.show(i)
        tops.append([mark.get_xdata()[0] for mark in inset.marks])
    moved = (tops[1][0] - tops[0][0]) % (inset.width / 7)
    # The ground stands still: marks keep their places, up to one of their distances.
    assert min(moved, inset.width / 7 - moved) < 0.02 * inset.width


def test_insets_hide_no_body(slow, feet):
    for scene, shown, _ in (slow, feet):
        for inset in shown.insets:
            low, high = shown.view.corner, shown.view.corner + shown.view.size
            box, view = inset.axes.get_position(), shown.view.axes.get_position()
            parts = (scene.outline() - low[:, None]) / (high - low)[:, None]
            x = view.x0 + parts[:, :, 0] * view.width
            y = view.y0 + parts[:, :, 1] * view.height
            assert not ((x > box.x0) & (x < box.x1) & (y > box.y0) & (y < box.y1)).any()


def test_motion_that_is_seen_has_no_inset():
    _, shown, _ = picture(simulate("rod", "rigid", {"y_A": 1.0, "theta": 1.0}, t_end=0.3))
    assert shown.insets == []


def test_words_and_units_of_a_film(slow):
    _, shown, _ = slow
    words = texts(shown.figure)
    assert "time, magnified where it is short (ms)" in words and "$F_n$ (N)" in words
    colours = {t.get_text(): t.get_color() for t in shown.figure.texts}
    assert (colours["$F_n$"], colours["$F_t$"], colours["slip"]) == (NORMAL, TANGENTIAL, SLIP)
    assert re.fullmatch(r"\$t\$ = \d\.\d+ ms    slow motion 1 : [\d,]+", shown.clock.get_text())


def test_strip_of_a_film_is_the_normal_force(slow):
    scene, shown, _ = slow
    curve = shown.strip.lines[0]
    places = np.asarray(curve.get_xdata()) * shown.rate
    expected = np.interp(np.arange(len(scene.times)), places, curve.get_ydata())
    largest = scene.outputs["normal_force"].max()
    assert np.abs(expected - scene.outputs["normal_force"]).max() < 0.05 * largest


def test_contacts_of_a_film_are_named_in_their_colours_off_the_curves(feet):
    _, shown, _ = feet
    legend = shown.strip.get_legend()
    assert [t.get_text() for t in legend.get_texts()] == ["A", "B"]
    assert legend.get_window_extent().y0 >= shown.strip.bbox.y1 - 1
    assert [line.get_color() for line in shown.strip.lines[:2]] == list(CONTACTS[:2])
    names = [arrows.name.get_text() for arrows in shown.arrows]
    assert names == ["A", "B"]
    assert {inset.axes.texts[0].get_text()[0] for inset in shown.insets} <= {"A", "B"}


def test_picture_of_a_film_is_the_right_way_up(slow):
    _, shown, pixels = slow
    view = shown.view.axes.bbox
    height = pixels.shape[0]
    middle = int(view.x0 + 0.9 * view.width)
    low, high = (int(height - view.y0 - part * view.height) for part in (0.02, 0.6))
    assert pixels[low, middle].max() < 240 and pixels[high, middle].min() == 255


def test_moments_of_events_are_their_frames():
    times = np.array([0.0, 1.0, 2.0])
    events = [(0.5, "slip stops", "A"), (1.0, "lift-off", "A"), (9.0, "end", "")]
    assert moments(events, times) == [
        (1, [("slip stops", "A"), ("lift-off", "A")]),
        (2, [("end", "")]),
    ]


def test_picture_of_a_mechanism_is_to_scale_with_its_contacts(bounce):
    figure = bounce.animate().still()
    (axes,) = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$x$ (m)", "$y$ (m)")
    assert axes.get_aspect() == 1.0
    rod = axes.lines[0]
    np.testing.assert_allclose(
        rod.get_xydata(), [[0, 0.05], [2 * math.cos(1), 0.05 + 2 * math.sin(1)]]
    )
    assert "A" in [t.get_text() for t in axes.texts]
    assert not any("slow" in t for t in texts(figure))


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
    assert "<output>" in text and '"200 ms"' in text and "system-ui" in text


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
