"""Figures and films are read by the labels of their axes: each number shown is that of its data."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_hex
from PIL import Image

import painleve_sym as ps
from painleve_sym.present.figure_of_map import map_figure
from painleve_sym.present.figure_of_risk import risk_figure
from painleve_sym.present.figure_of_risk_trajectory import risk_trajectory_figure
from painleve_sym.present.film import FilmPicture, _Arrows
from painleve_sym.present.risk_page import risk_page
from painleve_sym.present.style import NORMAL, PALETTE, STYLE, event_label
from painleve_sym.problem import Sector
from painleve_sym.problem.case_codes import LEGEND
from painleve_sym.robots.contact_risk import LeastRisk
from painleve_sym.robots.report import RiskReport
from painleve_sym.robots.trajectory import RiskTrajectory
from painleve_sym.study.maps.region_map import RegionMap
from tests.present.reading import assert_upright, drawn_values, legend_names, size_of

ROD = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
BOUNCE = {"theta": 1.0, "y_A": 0.05, "x_A_dot": -1.0}


# ---- a motion ----

MOTIONS = {
    "N": lambda: ps.simulate("rod", "bilinear-hertz", ROD, t_end=0.02),
    "kN": lambda: ps.simulate("rod", "bilinear-hertz", BOUNCE, t_end=0.12, parameters={"m": 50.0}),
    "mN": lambda: ps.simulate("rod", "hertz", ROD, t_end=0.02, parameters={"m": 1e-7}),
    "two contacts": lambda: ps.simulate("block-two-feet", "rigid", None, t_end=0.3),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_every_curve_and_mark_of_a_motion_is_its_number(name):
    run = MOTIONS[name]()
    figure = run.plot()
    assert_upright(figure)
    contacts = run.names.contacts
    outputs = {"F_n": "normal_force", "F_t": "tangential_force"}
    seen = set()
    for axes in figure.axes:
        symbol = re.match(r"\$(F_[nt])\$", axes.get_ylabel())
        if not symbol and not axes.get_ylabel().startswith("force"):
            continue
        if name in ("kN", "mN"):
            assert axes.get_ylabel() == f"force ({name})"
        for line in axes.lines:
            label = str(line.get_label()).strip("$")
            kind, contact = (symbol[1], label) if symbol else (label, contacts[0])
            if kind not in outputs or contact not in contacts:
                continue
            t, force = drawn_values(axes, line)
            kept = np.isfinite(force) & (t < run.final_time * (1 - 1e-9))
            # An event is drawn with a force on either side, a rounding apart.
            apart = np.min(np.abs(t[:, None] - [e.time for e in run.events] + [1e9]), axis=1)
            kept &= apart > 1e-9 * run.final_time
            own = run.outputs(t[kept])[run.names.of_contact(outputs[kind], contact)]
            np.testing.assert_allclose(force[kept], own, rtol=1e-6, atol=1e-6 * np.abs(own).max())
            seen.add((kind, contact))
    assert seen == {(kind, contact) for kind in outputs for contact in contacts}


def test_marks_and_ticks_of_a_motion_stand_at_its_events():
    start = {"theta": 1.5, "y_A": 0.01, "x_A_dot": -1.0}
    run = ps.simulate("rod", "bilinear-hertz", start, t_end=0.25, parameters={"m": 50.0})
    assert len(run.events_of("touchdown")) > 2
    figure = run.plot()
    factor = size_of(figure.axes[0].get_xlabel())
    marks = {str(line.get_label()): line for line in figure.axes[0].lines}
    for kind in dict.fromkeys(e.kind for e in run.events):
        events = run.events_of(kind)
        label = event_label(kind) + (f" ({len(events)})" if len(events) > 1 else "")
        t, force = drawn_values(figure.axes[0], marks[label])
        np.testing.assert_allclose(t, [e.time for e in events])
        np.testing.assert_allclose(force, [e.normal_force for e in events], atol=1e-9)
    for axes in figure.axes[:1] + figure.axes[-2:]:
        at = [s[0][0] for c in axes.collections for s in c.get_segments() if len(s) == 2]
        np.testing.assert_allclose(
            np.unique(np.round(np.array(at) * factor, 12)),
            np.unique(np.round([e.time for e in run.events], 12)),
        )


def test_a_magnified_panel_says_by_what():
    run = MOTIONS["N"]()
    whole, near, *_ = run.plot().axes
    (times,) = re.fullmatch(r"time magnified ([\d,]+) times", near.get_title(loc="left")).groups()
    start, end = (v * size_of(near.get_xlabel()) for v in near.get_xlim())
    expected = run.final_time / (end - start)
    assert float(times.replace(",", "")) == pytest.approx(expected, rel=0.01, abs=0.5)
    assert start < min(e.time for e in run.events) < max(e.time for e in run.events) < end
    assert whole.get_xlabel().startswith("time")


# ---- a film ----


@pytest.fixture(scope="module")
def film():
    run = ps.simulate("rod", "bilinear-hertz", {**BOUNCE, "y_A": 0.01}, t_end=0.06)
    own = run.animate(duration=2.0, width=300)
    with matplotlib.rc_context(STYLE | {"figure.dpi": 100}):
        return run, own, FilmPicture(own.scene, own.width, own.rate)


def test_a_film_lasts_what_it_says_in_every_form(film, tmp_path):
    _, own, _ = film
    assert len(own.scene.times) == round(own.duration * own.rate)
    own.save(tmp_path / "film.gif")
    with Image.open(tmp_path / "film.gif") as gif:
        lasted = gif.n_frames * gif.info["duration"] / 1000
    assert lasted == pytest.approx(own.duration, rel=0.05)
    page = own.html()
    (interval,) = re.findall(r"frames\.length\), (\d+)\);", page)
    assert page.count('"iVBOR') * float(interval) / 1000 == pytest.approx(own.duration, rel=0.02)
    listed = re.search(r"times = \[([^]]*)\]", page)[1].replace('"', "").split(",")
    values = [float(t.split()[0]) * size_of(f"({t.split()[1]})") for t in listed]
    np.testing.assert_allclose(values, own.scene.times, rtol=1e-3, atol=1e-6)


def test_a_video_has_the_rate_of_its_film(film, monkeypatch, tmp_path):
    _, own, _ = film
    asked = {}

    def write_frames(file, size, fps, **_):
        asked["fps"] = fps
        open(file, "wb").close()
        while True:
            yield

    monkeypatch.setitem(
        __import__("sys").modules, "imageio_ffmpeg", SimpleNamespace(write_frames=write_frames)
    )
    own._save_video(tmp_path / "film.mp4")
    assert asked["fps"] == own.rate


def test_clock_and_strip_of_a_film_are_those_of_its_motion(film):
    run, own, shown = film
    times = own.scene.times
    curve = shown.strip.lines[0]
    for i in (1, 7, 12, 20):
        shown.pixels(i)
        said = re.match(r"time ([\d.]+) (\S+)", shown.clock.get_text())
        value = float(said[1]) * size_of(f"({said[2]})")
        assert value == pytest.approx(times[i], abs=2 * np.diff(times).max() * 0.1 + 1e-6)
        rate = (times[i] - times[i - 1]) * own.rate
        pace = shown.clock.get_text().rpartition("    ")[2]
        if match := re.fullmatch(r"slow motion 1 : ([\d,.]+)", pace):
            assert float(match[1].replace(",", "")) == pytest.approx(1 / rate, rel=0.06)
        elif match := re.fullmatch(r"([\d.]+) times as fast", pace):
            assert float(match[1]) == pytest.approx(rate, rel=0.06)
        else:
            assert pace == "real time" and rate == pytest.approx(1, abs=0.06)
        assert shown.cursor.get_xdata()[0] == pytest.approx(i / own.rate)
    factor = size_of(shown.strip.get_ylabel())
    at = np.asarray(curve.get_xdata()) * own.rate
    forces = np.interp(np.arange(len(times)), at, curve.get_ydata()) * factor
    largest = run.outputs(run.fine_times())["normal_force"].max()
    assert np.max(curve.get_ydata()) * factor == pytest.approx(largest, rel=0.1)
    own_force = own.scene.outputs["normal_force"]
    assert np.corrcoef(forces, own_force)[0, 1] > 0.9
    unit = size_of(shown.strip.get_xlabel())
    for place, text in zip(shown.strip.get_xticks(), shown.strip.get_xticklabels(), strict=True):
        time = np.interp(place * own.rate, np.arange(len(times)), times)
        assert float(text.get_text()) * unit == pytest.approx(time, rel=1e-3, abs=1e-9)
    assert_upright(SimpleNamespace(axes=[shown.strip, shown.view.axes]))


def test_arrows_of_a_film_point_along_their_forces_and_grow_with_them(film):
    _, own, _ = film
    scene = own.scene
    figure = matplotlib.figure.Figure()
    arrows = _Arrows(figure.add_subplot(), scene, "A", scene.window[1])
    closed = np.flatnonzero(np.abs(arrows.force) > 1e-3 * arrows.largest)
    assert len(closed) > 3
    sizes = []
    for i in closed:
        arrows.show(int(i), None)
        normal, tangential, slip = (
            np.array([a.U[0], a.V[0]]) if a.get_visible() else np.zeros(2) for a in arrows.arrows
        )
        # The ground is level: F_n > 0 is up, F_t > 0 and positive slip are to the right.
        assert normal[0] == 0 and normal[1] > 0
        if tangential.any():
            assert tangential[1] == 0
            assert np.sign(tangential[0]) == np.sign(scene.outputs["tangential_force"][i])
        if slip.any():
            assert np.sign(slip[0]) == np.sign(scene.outputs["slip_velocity"][i])
        sizes.append(normal[1])
        np.testing.assert_allclose(arrows.arrows[0].get_offsets()[0], scene.place("A")[i])
    order = np.argsort(arrows.force[closed])
    assert (np.diff(np.array(sizes)[order]) >= -1e-12).all()
    assert to_hex(arrows.arrows[0].get_facecolor()[0]) == to_hex(NORMAL)


def test_bodies_of_a_film_stand_where_they_are(film):
    run, own, shown = film
    for i in (0, 10, 23):
        shown.pixels(i)
        state = dict(zip(run.state_names, run(own.scene.times[i])[0], strict=True))
        foot = np.array([state["x_A"], state["y_A"]])
        end = foot + 2 * np.array([math.cos(state["theta"]), math.sin(state["theta"])])
        drawn = shown.view.bodies[0].get_xydata()
        np.testing.assert_allclose(drawn, [foot, end], atol=1e-12)


def test_belt_of_a_film_moves_the_way_it_does():
    run = ps.simulate("two-link-arm", "rigid", None, t_end=0.02)
    scene = run.animate(duration=0.5, width=200).scene
    (contact,) = scene.contacts
    speed = scene.belt_speed(contact)
    # Slip is that of the arm's tip less that of the belt.
    x = scene.place(contact)[:, 0]
    tip = np.gradient(x, scene.times)
    middle = slice(1, -1)
    slip = scene.outputs["slip_velocity"]
    expected = (tip * scene.tangent(contact)[:, 0] - slip)[middle]
    np.testing.assert_allclose(speed[middle], expected, atol=0.02 * np.abs(speed).max())


# ---- a map ----


def a_map(**changes):
    """Return a map of made-up numbers that is symmetric in nothing."""
    x, mu = np.linspace(0.0, 1.0, 21), np.linspace(0.0, 2.0, 11)
    grid = np.meshgrid(x, mu, indexing="ij")
    case = np.where(grid[1] > 1.5, LEGEND["inconsistent"], LEGEND["slip"]).astype(np.int8)
    case[grid[0] > 0.8] = LEGEND["indeterminate"]
    given = {
        "mechanism": "rod",
        "over": ("theta", "mu"),
        "labels": (r"\theta", r"\mu"),
        "units": ("rad", "1"),
        "values": (x, mu),
        "slip": -1.0,
        "case": case,
        "A": grid[0],
        "B": grid[1],
        "A_stick": grid[0],
        "B_stick": grid[1],
        "stick_feasible": grid[0] > 2,
        "flow": np.stack([1 + 0 * grid[0], 0.3 + 0 * grid[0]]),
        "curves": {
            "A": np.array([[[0.2, 0.1], [0.3, 1.9]]]),
            "B": np.array([[[0.1, 0.5], [0.9, 0.7]]]),
        },
        "crossings": np.array([[0.25, 1.2]]),
        "thresholds": {"mu_P": 1.25},
        "state": {"theta_dot": 3.0},
        "parameters": {},
        "state_units": {"theta_dot": "rad/s"},
        "close": "",
        "A_pull": None,
        "shared_zeros": [],
    }
    return RegionMap(**(given | changes))


def test_curves_crossings_and_thresholds_of_a_map_stand_at_their_numbers():
    given = a_map()
    (axes,) = map_figure(given).axes
    assert_upright(map_figure(given))
    segments = [c for c in axes.collections if hasattr(c, "get_segments")]
    for name, colour in (("A", PALETTE[0]), ("B", PALETTE[1])):
        (own,) = (c for c in segments if to_hex(c.get_colors()[0]) == colour.lower())
        (line,) = own.get_segments()
        np.testing.assert_array_equal(line[np.argsort(line[:, 0])], given.curves[name][0])
    words = {t.get_text(): t for t in axes.texts}
    for name, colour in (("$A = 0$", PALETTE[0]), ("$B = 0$", PALETTE[1])):
        assert words[name].get_color() == colour
        near = given.curves[name[1]][0].mean(axis=0)
        np.testing.assert_allclose(words[name].get_position(), near)
    crossings = [line for line in axes.lines if line.get_marker() == "o"]
    np.testing.assert_array_equal(crossings[0].get_xydata(), given.crossings)
    (threshold,) = (line for line in axes.lines if line.get_marker() != "o")
    assert set(threshold.get_ydata()) == {1.25} and words[r"$\mu_P$"].get_position()[1] == 1.25
    assert r"$\dot{\theta} = 3$ rad/s" in axes.get_title(loc="left")
    turned = a_map(over=("mu", "theta"), values=given.values[::-1], case=given.case.T, flow=None)
    (axes,) = map_figure(turned).axes
    assert any(set(np.atleast_1d(line.get_xdata())) == {1.25} for line in axes.lines)


@pytest.mark.parametrize("sign", [1, -1])
def test_flow_of_a_map_goes_the_way_of_its_numbers(sign):
    given = a_map(curves={}, crossings=np.empty((0, 2)), flow=sign * a_map().flow)
    (axes,) = map_figure(given).axes
    heads = [p for p in axes.patches if isinstance(p, matplotlib.patches.FancyArrowPatch)]
    assert len(heads) > 3
    for head in heads:
        (x, y), (x_2, y_2) = head._posA_posB
        assert sign * (x_2 - x) > 0 and sign * (y_2 - y) > 0


def test_each_fill_of_a_map_has_the_name_of_its_case():
    given = a_map()
    figure = map_figure(given)
    (axes,) = figure.axes
    (image,) = axes.images
    handles = dict(zip(legend_names(figure), figure.legends[0].legend_handles, strict=True))
    names = {"slip": "slip", "inconsistent": "no solution", "indeterminate": "several"}
    for case, word in names.items():
        (handle,) = (h for n, h in handles.items() if word in n and not n.startswith("flow"))
        colour = image.cmap(image.norm(LEGEND[case]))
        assert to_hex(handle.get_facecolor()) == to_hex(colour)


# ---- a robot's risk ----


def risk_of(values, mu, half_angle=0.3):
    risk = SimpleNamespace(
        mu=mu, mu_P=0.9, W=np.diag([1.0, 2.0, 3.0]), direction=(math.cos(0.5), math.sin(0.5)),
        sector=None if half_angle is None else Sector((1.0, 0.0), half_angle),
        worst_direction=np.array([1.0, 0.0, 0.0]), least_over_normals=0.1, gradient={"knee": 0.25},
        impact=None,
    )  # fmt: skip
    share = float(np.mean(values < mu)) if mu is not None else None
    return RiskReport(
        title="foot",
        subject=SimpleNamespace(rows=[("frame", "sole")]),
        risk=risk,
        least=LeastRisk(0.2, {"knee": 0.75}),
        distribution=values,
        share_at_risk=share,
        units={"knee": "rad"},
        notices=(),
    )


def test_distribution_of_a_risk_is_the_share_of_poses_below_each_number():
    values = np.array([0.4, 3.0, 0.2, np.nan, 1.0, 0.6, np.inf, 2.0])
    axes = risk_figure(risk_of(values, 0.7)).axes[0]
    assert axes.get_ylabel().endswith("(%)")
    curve = axes.lines[0]
    for x, share in curve.get_xydata():
        assert share == pytest.approx(100 * np.mean(values <= x))
    marks = {str(line.get_label()): line.get_xdata()[0] for line in axes.lines[1:]}
    assert marks == {"this pose": 0.9, "least of all poses": 0.2, r"$\mu$": 0.7}
    (shade,) = axes.collections
    assert shade.get_paths()[0].vertices[:, 0].max() <= 0.7


def cells(page, text):
    """Return the cells of the row of a page that begins with this text."""
    row = re.search(rf"<tr><t[hd][^>]*>{re.escape(text)}</t[hd]>(.*?)</tr>", page, re.S)
    return re.findall(r"<td[^>]*>(.*?)</td>", row[1], re.S)


def test_numbers_of_a_risk_page_are_those_of_its_report():
    values = np.array([0.4, 3.0, 0.2, 1.0, 0.6, 2.0, 0.1, 5.0])
    report = risk_of(values, 1.5)
    page = risk_page(report).html()
    said = {
        "μ_P at this pose": report.risk.mu_P,
        "least μ_P of all surface normals": 0.1,
        "least μ_P that a search over joint limits reached": 0.2,
        "share of random poses with μ_P &lt; μ": 5 / 8,
        "worst direction of slip, from t1 towards t2, rad": 0.5,
    }
    for text, value in said.items():
        assert float(cells(page, text)[0]) == pytest.approx(value)
    assert cells(page, "n") == ["1", "0", "0"] and float(cells(page, "t2")[2]) == 3.0
    assert cells(page, "knee")[0] in ("0.25", "0.75")
    assert f"within {math.degrees(0.3):.3g}°" in page and "8 random poses" in page
    assert "coefficient of 0.9 " in page


def test_time_at_risk_is_shaded_and_no_other():
    t = np.linspace(0, 4, 41)
    mu_P, closed = np.where((t < 1.05) | (t > 2.95), 0.4, 2.0), t < 2.05
    motion = RiskTrajectory(t, 0.8, mu_P, mu_P / 0.8, closed, (), 0.02)
    axes = risk_trajectory_figure(motion).axes[0]
    curve = axes.lines[0].get_xydata()
    np.testing.assert_array_equal(curve[closed], np.stack([t, mu_P], 1)[closed])
    assert not np.isfinite(curve[~closed, 1]).any()
    lines = {str(line.get_label()): line for line in axes.lines}
    assert set(lines[r"$\mu$"].get_ydata()) == {0.8}
    np.testing.assert_array_equal(lines["no contact"].get_xydata(), np.stack([t, mu_P], 1))
    shaded = axes.collections[0].get_paths()[0].vertices
    assert shaded[:, 0].min() == 0 and shaded[:, 0].max() == pytest.approx(1.0)
    assert shaded[:, 1].min() == pytest.approx(0.4) and shaded[:, 1].max() == pytest.approx(0.8)
    page = risk_page(risk_of(np.array([0.4, 1.0]), 0.8), motion).html()
    assert float(cells(page, "share of the time at risk")[0]) == pytest.approx(0.2625, abs=0.02)
    touching = "share of the time in which the contact touches"
    assert float(cells(page, touching)[0]) == pytest.approx(0.5125, abs=0.02)
    assert cells(page, "samples") == ["41"]
    assert float(cells(page, "least μ_P while it touches")[0]) == 0.4
