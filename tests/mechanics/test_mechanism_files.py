"""Mechanism files: the same mechanisms as named ones, and every fault with its line."""

from __future__ import annotations

import math
import time
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from painleve_sym.at.cases import classify
from painleve_sym.at.delassus import Delassus
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, ModelError
from painleve_sym.laws.catalogue import law
from painleve_sym.mechanics import models
from painleve_sym.mechanics.toml.faults import MAX_FAULTS_READ
from painleve_sym.mechanics.toml.mechanism_file import (
    MAX_BYTES,
    MAX_COORDINATES,
    load_mechanism,
    mechanism_from_text,
)
from painleve_sym.motion.simulator import Simulator
from tests.mechanics.catalogue import by_symbol, derived, random_numbers

EXAMPLES = Path(__file__).parents[2] / "examples" / "mechanisms"
EVERYDAY = Path(models.__file__).parent / "everyday"
PATHS = {p.name: p for folder in (EXAMPLES, EVERYDAY) for p in sorted(folder.glob("*.toml"))}
FILES = list(PATHS)
OPEN = ("dropped-ball.toml", "newtons-cradle.toml", "rocking-block.toml", "woodpecker.toml")
"""They begin with an open contact."""
RANK_ONE = ("drum-brake.toml", "dropped-ball.toml", "newtons-cradle.toml")
"""The point of contact moves along one line."""
# Those that are derived for longest.
LONG = ("three", "wheel", "elastic", "rod-on-ball", "chalk")

SHORT = """\
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
m = { default = 2.0, unit = "kg", positive = true }
mu = { default = 0.5, unit = "1" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[[contacts]]
name = "A"
point = ["x", "y"]
friction = "mu"
"""


def faults_of(text):
    with pytest.raises(ModelError) as caught:
        mechanism_from_text(text, "file")
    assert str(caught.value).startswith("file: line ")
    return caught.value.faults


# ---- what files give ----


@pytest.fixture(scope="module")
def examples():
    return {name: load_mechanism(path) for name, path in PATHS.items()}


def test_examples_are_at_least_six():
    assert len(FILES) >= 6


@pytest.mark.parametrize("file", FILES)
def test_example_has_what_named_mechanisms_have(examples, file):
    mechanism = examples[file]
    for entry in (*mechanism.system.coordinates, *mechanism.system.parameters):
        assert entry.meaning != entry.name and entry.unit
    assert mechanism.title and mechanism.source
    assert set(mechanism.start) <= set(mechanism.state_names)


@pytest.mark.parametrize(
    "file",
    [pytest.param(f, marks=pytest.mark.slow if f.startswith(LONG) else ()) for f in FILES],
)
def test_example_starts_in_contact_and_has_positive_mobility(examples, file):
    mechanism = examples[file]
    if mechanism.outline.in_space:
        at = Delassus.of(mechanism).at(mechanism.at().values)
        assert np.all(np.abs([*at.gap, *at.gap_rate]) < 1e-12)
        assert np.all(np.linalg.eigvalsh(at.W) > 0)
        assert classify(mechanism, mechanism.start).solutions is not None
        return
    values = {p.name: p.default for p in mechanism.system.parameters}
    values |= dict.fromkeys(mechanism.state_names, 0.0) | mechanism.start
    at = by_symbol(mechanism, values)
    for c in mechanism.all_coefficients:
        gap, rate, *W = numbers(
            [c.contact.gap, c.contact.gap_rate, c.W_nn, c.W_nt, c.W_nt, c.W_tt], at
        )
        assert (abs(gap) < 1e-12 and abs(rate) < 1e-12) or (file in OPEN and gap > 1e-6)
        least, greatest = np.linalg.eigvalsh(np.reshape(W, (2, 2)))
        assert W[0] > 0 and least > (-1e-12 * greatest if file in RANK_ONE else 0)
    if len(mechanism.contacts) == 1 and not mechanism.contact.bilateral and file not in OPEN:
        assert classify(mechanism, mechanism.start).solutions is not None


def test_example_rod_is_the_named_rod(examples):
    ours, named = examples["rod.toml"].coefficients, derived("rod").coefficients
    for form in ("W_nn", "W_nt", "W_tt", "b_n", "b_t", "A_stick", "B_stick", "sticking_force"):
        assert str(getattr(ours, form)) == str(getattr(named, form))
    assert str(ours.A(-1)) == str(named.A(-1))


@pytest.mark.parametrize(
    "file", ["belt-oscillator.toml", pytest.param("rod-in-bowl.toml", marks=pytest.mark.slow)]
)
def test_example_moves_softened_and_keeps_its_energy(examples, file):
    mechanism = examples[file]
    run = Simulator(mechanism, law("hertz")).run(mechanism.start, t_end=3e-3)
    assert run.energy_residual < 1e-8
    assert max(e.compression for e in run.events) > 0


def test_model_takes_the_path_of_a_file():
    assert model(str(EXAMPLES / "rod-in-bowl.toml")).name == "rod-in-bowl"


def test_file_with_bodies_springs_and_loads_is_the_named_mechanism():
    text = """
    gravity = "g"
    [coordinates]
    x = { unit = "m" }
    theta = { unit = "rad" }
    [parameters]
    m_1 = { default = 1.0, unit = "kg", positive = true }
    m_2 = { default = 1.0, unit = "kg", positive = true }
    l = { default = 0.5, unit = "m", positive = true }
    h = { default = 0.8, unit = "m" }
    F = { default = 0.0, unit = "N" }
    tau = { default = 0.0, unit = "N m" }
    c_j = { default = 0.0, unit = "N m s", lower = 0 }
    g = { default = 9.8, unit = "m/s^2", lower = 0 }
    mu = { default = 1.2, unit = "1" }
    [definitions]
    x_C = "x - l*cos(theta)"
    y_C = "h - l*sin(theta)"
    [[bodies]]
    mass = "m_1"
    centre = ["x", "h"]
    [[bodies]]
    mass = "m_2"
    centre = ["x_C", "y_C"]
    inertia = "m_2*l**2/3"
    angle = "theta"
    [[springs]]
    extension = "theta"
    damping = "c_j"
    [[loads]]
    point = ["x", "h"]
    force = ["F", 0]
    [[loads]]
    angle = "theta"
    torque = "tau"
    [[contacts]]
    name = "tip"
    point = ["2*x_C - x", "2*y_C - h"]
    friction = "mu"
    """
    ours, named = mechanism_from_text(text), derived("pr-robot")
    values = random_numbers(named, np.random.default_rng(3))
    for form in ("W_nn", "W_nt", "W_tt", "b_n", "b_t"):
        pair = [
            numbers([getattr(m.coefficients, form)], by_symbol(m, values))[0] for m in (ours, named)
        ]
        assert math.isclose(*pair, rel_tol=1e-12), form


def test_file_keeps_defaults_ranges_and_names(tmp_path):
    path = tmp_path / "slider.toml"
    path.write_text(SHORT)
    mechanism = load_mechanism(path)
    assert mechanism.name == "slider" and mechanism.title == "slider"
    assert mechanism.source == f"mechanism file {path}"
    assert mechanism.state_names == ("x", "y", "x_dot", "y_dot")
    m, mu = mechanism.system.parameters
    assert (m.default, m.lower, m.lower_closed) == (2.0, 0.0, False)
    # A friction coefficient is never negative, whether the file says so or not.
    assert (mu.lower, mu.lower_closed) == (0.0, True)


def test_file_with_a_byte_order_mark_and_windows_line_ends_is_read(tmp_path):
    path = tmp_path / "a.toml"
    path.write_bytes(b"\xef\xbb\xbf" + SHORT.replace("\n", "\r\n").encode())
    assert load_mechanism(path).contacts[0].name == "A"


def test_file_with_energies_and_a_formula_of_several_lines():
    text = SHORT.replace('[[bodies]]\nmass = "m"\ncentre = ["x", "y"]\n', "") + (
        '[energy]\nkinetic = """\nm*x_dot**2/2\n + m*y_dot**2/2"""\npotential = "9.8*m*y"\n'
    )
    mechanism = mechanism_from_text(text)
    m = sp.Symbol("m", positive=True)
    assert mechanism.system.mass_matrix == sp.diag(m, m)
    assert mechanism.coefficients.b_n == -sp.Rational(98, 10)


# ---- what files get wrong ----


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("[coordinates]", "[cordinates]", "line 1, cordinates: unknown key 'cordinates'. Did you"),
        ('x = { unit = "m" }', "x = {}", "line 2, coordinates.x: unit is missing. Fix: add unit"),
        ('x = { unit = "m" }', "x = 1", "line 2, coordinates.x: got 1, need a table [coordinates"),
        ('unit = "kg"', 'unit = " "', "line 5, parameters.m: unit is missing."),
        ("default = 2.0, ", "", "line 5, parameters.m: default is missing. Fix: add default = ..."),
        ("default = 2.0", 'default = "2"', "line 5, parameters.m.default: got '2', need a number."),
        ("default = 2.0", "default = nan", "line 5, parameters.m.default: got nan, need a finite"),
        (
            "default = 2.0",
            "default = -2.0",
            "line 5, parameters.m.default: parameter m (m): got -2",
        ),
        ("positive = true", "positive = 1", "line 5, parameters.m.positive: got 1, need true or"),
        ("positive = true", "positive = true, lower = 1", "'positive' and 'lower' are mutually"),
        ("positive = true", "meanin = 1", "unknown key 'meanin'. Did you mean 'meaning'?"),
        ("\nmu =", "\nx =", "line 6, parameters.x: name 'x' is declared twice."),
        ("\nmu =", "\nx_dot =", "line 6, parameters.x_dot: name 'x_dot' is declared twice."),
        ("\nmu =", "\nF_n =", "line 6, parameters.F_n: name 'F_n' is reserved."),
        ("\nmu =", "\nclass =", "line 6, parameters.class: name 'class' is not usable."),
        ("\nmu =", '\n"a b" =', "line 6, parameters.a b: name 'a b' is not usable."),
        ('mass = "m"', 'mass = "mm"', "line 8, bodies[1].mass: unknown name 'mm'. Did you mean 'm"),
        ('mass = "m"', "", "line 7, bodies[1]: mass is missing."),
        ('mass = "m"', 'mass = "m"\nangle = "x"', "inertia and angle belong together."),
        ('centre = ["x", "y"]', 'centre = ["x"]', "line 9, bodies[1].centre: got ['x'], need two"),
        ('centre = ["x", "y"]', 'centre = ["x", "x"]', "the mass matrix is singular."),
        ("[[bodies]]", "[bodies]", "line 7, bodies: got {'mass': 'm', 'centre': ['x', 'y']}, need"),
        ('mass = "m"', 'mass = "-m"', "kinetic energy is negative for some velocities."),
        ('point = ["x", "y"]', "", "line 10, contacts[1]: got none, need one of point, disc, gap."),
        ('point = ["x", "y"]', 'point = ["x", "m"]', "line 10, contacts[1]: gap depends on no coo"),
        ('friction = "mu"', 'friction = "nu"', "line 13, contacts[1].friction: unknown parameter"),
        ('friction = "mu"', "friction = 0.5", "line 13, contacts[1].friction: got 0.5, need text"),
        ('friction = "mu"', 'friction = "mu"\ngap = "y"', "got point and gap, need one of point"),
        (
            'friction = "mu"',
            'friction = "mu"\nslip_velocity = "x_dot"',
            "line 14, contacts[1].slip_velocity: slip_velocity does not belong to a contact with",
        ),
        (
            'friction = "mu"',
            'friction = "mu"\ncurve = "y - h*x"\nslope = 0.1',
            "line 15, contacts[1].slope: a curve says this. Fix: leave out slope or curve.",
        ),
        (
            'friction = "mu"',
            'friction = "mu"\ncurve = "y - h*x"',
            "line 14, contacts[1].curve: unk",
        ),
        ('friction = "mu"', 'friction = "mu"\ncurve = "m"', "line 10, contacts[1]: gap depends on"),
        ('friction = "mu"', 'friction = "mu"\n[start]\nz = 1', "line 15, start.z: unknown state"),
        ('friction = "mu"', 'friction = "mu"\n[start]\nx = "1"', "line 15, start.x: got '1', need"),
        ('friction = "mu"', 'friction = "mu"\n[forces]\nz = 1', "line 15, forces.z: unknown coor"),
        ('friction = "mu"', 'friction = "mu"\n[[domain]]\nmargin = "x"', "meaning is missing."),
        ('friction = "mu"', 'friction = "mu"\n[[loads]]\nangle = "x"', "line 14, loads[1]: need p"),
    ],
)
def test_file_with_a_fault_tells_line_and_fix(old, new, fault):
    assert old in SHORT
    faults = faults_of(SHORT.replace(old, new, 1))
    assert any(fault in f for f in faults), faults


def test_file_faults_are_told_together_in_the_order_of_lines():
    text = (
        SHORT.replace('unit = "kg"', 'unit = ""')
        .replace('x = { unit = "m" }', "x = { }")
        .replace('centre = ["x", "y"]', 'centre = ["x", "x"]')
        .replace('point = ["x", "y"]', 'point = ["x", "m"]')
    )
    faults = faults_of(text)
    assert [f.split(":")[0] for f in faults] == [
        "line 2, coordinates.x",
        "line 5, parameters.m",
        "line 7, bodies",
        "line 10, contacts[1]",
    ]


def test_file_fault_in_a_long_formula_names_its_own_line():
    text = SHORT + '[energy]\npotential = """\n9.8*m*y\n + k*x**2/2"""\n'
    assert faults_of(text)[0].startswith("line 17, energy.potential: unknown name 'k'.")


def test_file_fault_of_a_definition_is_not_repeated_where_it_is_used():
    text = SHORT.replace('mass = "m"', 'mass = "big"') + '[definitions]\nbig = "2*n"\n'
    faults = faults_of(text)
    assert len(faults) == 1 and faults[0].startswith("line 15, definitions.big: unknown name 'n'")


def test_file_without_anything_says_what_is_needed():
    faults = faults_of("name = 'empty'")
    assert [f.split(". ")[0] for f in faults] == [
        "line 1, contacts: no contact",
        "line 1: no coordinates",
        "line 1: no mass",
    ]


def test_file_with_many_faults_is_refused_quickly_and_shortly():
    names = "\n".join(f"name_{i} = {{ default = 1, unit = '1' }}" for i in range(2000))
    wrong = "\n".join(f"[[loads]]\nangle = 'nam_{i}*z'\ntorque = 1" for i in range(2000))
    start = time.process_time()
    with pytest.raises(ModelError) as caught:
        mechanism_from_text(f"{SHORT}{wrong}\n[parameters.more]\n{names}", "file")
    assert time.process_time() - start < 10
    assert len(caught.value.faults) == MAX_FAULTS_READ + 1
    assert caught.value.faults[-1] == f"Reading stopped after {MAX_FAULTS_READ} faults."
    assert len(str(caught.value)) < 15_000 and str(caught.value).count("nam_") <= 20


def test_contact_that_no_motion_slides_has_the_normal_mobility_in_sticking():
    """A ball that only moves up and down: A' = 1/m and B' = -g by hand."""
    text = SHORT.replace('x = { unit = "m" }\n', "").replace('"x"', '"0"')
    c = mechanism_from_text('gravity = "9.8"\n' + text).coefficients
    m = sp.Symbol("m", positive=True)
    assert (c.A_stick, c.B_stick, c.sticking_force) == (1 / m, sp.Rational(-49, 5), 0)
    assert (c.slides, c.sticking_ratio) == (False, 0)


def test_file_with_a_key_of_thousands_of_letters_is_refused_shortly():
    text = SHORT.replace('x = { unit = "m" }', f"x.{'a' * 5000} = 1")
    with pytest.raises(ModelError, match=r"line 2, coordinates\.x\.aaa.*characters left") as caught:
        mechanism_from_text(text, "file")
    assert len(str(caught.value)) < 800


def test_file_with_too_many_coordinates_is_refused():
    more = "\n".join(f"q_{i} = {{ unit = 'm' }}" for i in range(MAX_COORDINATES))
    faults = faults_of(SHORT.replace("[parameters]", f"{more}\n[parameters]"))
    assert f"got {MAX_COORDINATES + 2} coordinates, need at most {MAX_COORDINATES}" in faults[0]


def test_file_with_two_contacts_of_one_name_is_refused():
    again = SHORT[SHORT.index("[[contacts]]") :]
    assert "name 'A' is declared twice" in faults_of(SHORT + again)[0]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"a = [1,\n b", "not valid TOML: Invalid value (at line 2, column 2)"),
        (b'name = "x"\n\nname = "\xff"', "line 3: not UTF-8 text"),
        (b"a = " + b"[" * 5000, "nested too deeply"),
        (b"a = " + b"[" * 40 + b"]" * 40, "nested too deeply"),
        (b"a" + b".a" * 90_000 + b" = 1", "nested too deeply"),
        (b"[coordinates]\nx = { a" + b" . a" * 40_000 + b" = 1 }", "nested too deeply"),
        (b"gravity = 0x" + b"f" * 5000, "more than the 64 bits"),
        (b"[[bodies]]\nmass = 1" + b"0" * 4000, "more than the 64 bits"),
        (b"#" * (MAX_BYTES + 1), f"more than {MAX_BYTES} bytes"),
    ],
    ids=[
        "broken",
        "not text",
        "open brackets",
        "brackets",
        "dots",
        "dots inside",
        "hexadecimal",
        "digits",
        "too long",
    ],
)
def test_file_that_is_no_toml_is_refused(tmp_path, data, message):
    path = tmp_path / "bad.toml"
    path.write_bytes(data)
    with pytest.raises(InputError, match="mechanism file") as caught:
        load_mechanism(path)
    assert message in str(caught.value)


def test_file_that_is_a_folder_or_missing_is_refused(tmp_path):
    for path in (tmp_path, tmp_path / "none.toml"):
        with pytest.raises(InputError, match="Fix: name a readable TOML file"):
            load_mechanism(path)


def test_file_executes_nothing(tmp_path):
    mark = tmp_path / "mark"
    call = f"__import__('pathlib').Path('{mark}').touch()"
    for text in (f'"{call}"', f"'''{call.replace(chr(39), '')}'''"):
        faults_of(SHORT.replace('mass = "m"', f"mass = {text}"))
    assert not mark.exists()
