"""Films: the time law, the places of bodies and contacts, insets, words, units and data."""

from __future__ import annotations

import math
import re

import matplotlib
import numpy as np
import pytest

from painleve_sym import Trajectory, model, simulate
from painleve_sym.present.film import SLIP, FilmPicture, moments
from painleve_sym.present.scene import SHARES, SHORTEST, Scene, film_times
from painleve_sym.present.style import CONTACTS, NORMAL, STYLE, TANGENTIAL
from tests.support.paper_law import paper_law


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


def picture(run, duration=1.0, **options):
    film = run.animate(duration=duration, **options)
    with matplotlib.rc_context(STYLE | {"figure.dpi": 100}):
        shown = FilmPicture(film.scene, film.width, film.rate)
        pixels = shown.pixels(len(film.scene.times) // 2)
    return film.scene, shown, pixels


@pytest.fixture(scope="module")
def slow():
    run = simulate("rod", paper_law(), {"theta": 1.0, "x_A_dot": -1.0}, t_end=0.01)
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
        tops.append([line.get_xdata()[0] for line in inset.marks[0].lines])
    moved = (tops[1][0] - tops[0][0]) % (inset.width / 7)
    # The ground stands still: marks keep their places, up to one of their distances.
    assert min(moved, inset.width / 7 - moved) < 0.02 * inset.width


def test_marks_of_a_belt_move_with_it_and_an_arrow_shows_where():
    run = simulate("two-link-arm", "rigid", None, t_end=0.1, parameters={"mu": 0.8})
    scene, shown, _ = picture(run)
    (marks,) = shown.view.marks
    speed = scene.belt_speed("tip")
    assert (speed != 0).all() and marks.arrow.get_visible()
    places = []
    for i in (3, 4):
        shown.view.show(i)
        places.append(marks.lines[0].get_xdata()[0])
    step = shown.view.size[0] / marks.count
    moved = places[1] - places[0] - speed[3] * (scene.times[4] - scene.times[3])
    assert abs((moved + step / 2) % step - step / 2) < 0.01 * step
    assert np.sign(marks.arrow.U[0]) == np.sign(speed[4] * scene.tangent("tip")[4, 0])


def test_surfaces_that_stand_still_have_no_marks_in_the_view(slow):
    assert slow[1].view.marks == []


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
    scene, shown, _ = slow
    words = texts(shown.figure)
    assert "time, magnified where it is short (ms)" in words and "$F_n$ (N)" in words
    colours = {t.get_text(): t.get_color() for t in shown.figure.texts}
    assert (colours["$F_n$"], colours["$F_t$"], colours["slip"]) == (NORMAL, TANGENTIAL, SLIP)
    clock = re.fullmatch(r"time (\d\.\d+) ms    slow motion 1 : [\d,]+", shown.clock.get_text())
    assert clock and float(clock[1]) == pytest.approx(1e3 * scene.times[6], abs=0.01)


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


def test_film_of_a_page_is_told_in_words_with_its_times(slow):
    text = slow[0].trajectory.animate(duration=0.2, width=200).html()
    assert 'alt="motion of rod, law bilinear-hertz"' in text
    assert re.search(r'times = \["0 ms","10 ms"\]', text)
