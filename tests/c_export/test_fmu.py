"""FMUs: FMPy validates and runs them, and their motions are those of `simulate`."""

from __future__ import annotations

import functools
import zipfile
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.c_export import export_fmu
from painleve_sym.codegen.compile import find_compiler
from painleve_sym.laws.catalogue import LAWS
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from tests.scenes import SLED
from tests.support.exports import run
from tests.support.units import Unit, fmpy

VERSIONS = ("2.0", "3.0")
CUT = 1.8e-3
"""Where the rod sticks and its contact unloads, s."""
SLIDING = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
CRATE = """
name = "crate"
title = "a crate & a <motor>"
gravity = "g"

[coordinates]
x = { unit = "m", meaning = "place along the \\"floor\\" < here" }
y = { unit = "m", meaning = "height" }

[parameters]
m = { default = 2.0, unit = "kg", meaning = "mass", positive = true }
g = { default = 9.81, unit = "m/s^2", meaning = "gravity", lower = 0 }
mu = { default = 0.3, unit = "1", meaning = "friction coefficient" }
F = { default = 0.0, unit = "N", meaning = "force of the motor" }

[[bodies]]
mass = "m"
centre = ["x", "y"]

[[loads]]
point = ["x", "y"]
force = ["F", 0]

[[contacts]]
name = "floor"
point = ["x", "y"]
friction = "mu"
"""


@pytest.fixture(scope="module")
def crate(tmp_path_factory):
    path = tmp_path_factory.mktemp("mechanism") / "crate.toml"
    path.write_text(CRATE, "utf-8")
    return str(path)


@pytest.fixture(scope="module")
def unit(tmp_path_factory, crate):
    """Return a function that writes an FMU, each once, and opens an instance of it."""

    @functools.cache
    def written(name, version):
        file = tmp_path_factory.mktemp("fmu") / f"{name}.fmu"
        cases = {
            "rod": ("rod", "bilinear-hertz", SLIDING, {"t_end": 0.01}),
            "light": ("rod", "bilinear-hertz", SLIDING, {"parameters": {"m": 1e-9}}),
            "falls": ("rod", "rigid", {"y_A": 0.1, "theta": 0.9}, {"t_end": 0.5}),
            "feet": ("block-two-feet", {"A": "rigid", "B": "hertz"}, FEET, {"t_end": 0.1}),
            "crate": (crate, "rigid", {"x": 0.0}, {"inputs": ["F"], "t_end": 1.0}),
        }
        mechanism, law, state, more = cases[name]
        return export_fmu(mechanism, law, state, file=file, fmi_version=version, **more)

    def instance(name, version):
        return Unit(written(name, version).file, tmp_path_factory.mktemp("instance"))

    instance.written = written
    return instance


FEET = {"y_A": 0.01, "theta": 0.02, "x_A_dot": 1.0}


def followed(file, t_end, interval, names):
    """Return the results of FMPy's own loop."""
    return fmpy.simulate_fmu(
        str(file), stop_time=t_end, output_interval=interval, output=list(names)
    )


@pytest.mark.parametrize("version", VERSIONS)
def test_fmpy_validates_a_unit_and_runs_the_motion_of_simulate(unit, version):
    from fmpy.validation import validate_fmu

    done = unit.written("rod", version)
    assert validate_fmu(str(done.file)) == []
    whole = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=0.01)
    names = ("theta", "theta_dot", "x_A_dot", "y_A", "normal_force", "tangential_force", "gap")
    names = tuple(n for n in names if n in done.variables)
    rows = followed(done.file, 0.01, 2.5e-3, (*names, "events", "mode"))
    for name in names:
        known = whole.values(name, rows["time"])
        assert rows[name] == pytest.approx(known, rel=1e-7, abs=1e-7 * np.max(np.abs(known)))
    # All five events are inside the second of four steps.
    assert rows["events"].tolist()[-1] == len(whole.events) == 5
    assert [v.unit for v in fmpy.read_model_description(str(done.file)).modelVariables
            if v.name == "E"] == ["Pa"]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(
    ("name", "t_end"), [("falls", 0.5), ("feet", 0.1), ("light", 0.01)], ids=str
)
def test_other_motions_are_those_of_simulate(unit, version, name, t_end):
    done = unit.written(name, version)
    arguments = {
        "falls": ("rod", "rigid", {"y_A": 0.1, "theta": 0.9}),
        "feet": ("block-two-feet", {"A": "rigid", "B": "hertz"}, FEET),
        "light": ("rod", "bilinear-hertz", SLIDING),
    }[name]
    own = {"parameters": {"m": 1e-9}} if name == "light" else {}
    whole = ps.simulate(*arguments, t_end=t_end, **own)
    states = whole.names.states
    rows = followed(done.file, t_end, t_end / 7, states)
    for state in states:
        known = whole.values(state, rows["time"])
        size = max(np.max(np.abs(known)), 1e-3 if name != "light" else 1e-12)
        assert np.max(np.abs(rows[state] - known)) < 1e-7 * size, state


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_a_motion_under_every_law_is_that_of_simulate(name, tmp_path):
    """Through an impact of the rod, in seven steps: each cuts what contacts remember."""
    start, t_end = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -0.5, "y_A": 1e-3}, 0.02
    law = ps.law(name)
    file = export_fmu("rod", law, start, file=tmp_path / "rod.fmu", t_end=t_end).file
    whole = ps.simulate("rod", law, start, t_end=t_end)
    assert len(whole.events) >= 2
    states = whole.names.states
    rows = followed(file, t_end, t_end / 7, states)
    for state in states:
        known = whole.values(state, rows["time"])
        size = max(np.max(np.abs(known)), 1e-3)
        assert np.max(np.abs(rows[state] - known)) < 1e-7 * size, state


@pytest.mark.parametrize("version", VERSIONS)
def test_an_input_is_held_over_a_step(unit, version, crate):
    """A sampled controller by an FMU and by pieces of Python are one motion."""
    simulator = ps.Simulator(crate, "rigid")
    with unit("crate", version) as own:
        own.begin()
        piece, modes = None, []
        for k in range(20):
            t, size = 0.05 * k, 0.05
            force = 400.0 * (0.1 - own.get("x")) - 40.0 * own.get("x_dot")
            own.set(F=force)
            end = t + size
            piece = (
                simulator.run({"x": 0.0}, t_end=end, parameters={"F": force})
                if piece is None
                else piece.continued(end, parameters={"F": force})
            )
            own.step(t, size)
            assert own.get("x") == pytest.approx(piece.final["x"], rel=1e-9)
            assert own.get("x_dot") == pytest.approx(piece.final["x_dot"], rel=1e-7, abs=1e-12)
            modes.append(own.mode())
        assert own.mode() == "stick" and {"slip_pos", "stick"} <= set(modes)
        # Friction holds the crate where the force is below mu m g = 5.886 N.
        assert abs(own.get("tangential_force")) == pytest.approx(abs(force))
        assert abs(force) < 0.3 * 2.0 * 9.81
        assert own.get("normal_force") == pytest.approx(2.0 * 9.81)


def test_inputs_that_vary_within_a_step_have_rates(tmp_path):
    """A table that moves on, by its place and velocity, and a force: as `simulate` with inputs."""
    sled = mechanism_from_text(SLED)
    done = export_fmu(sled, "rigid", {"x_dot": 1.0}, file=tmp_path / "sled.fmu", t_end=1.0)
    assert done.inputs == ("F", "F_dot", "u", "u_dot") and "u_t0" not in done.variables
    times = np.linspace(0.0, 1.0, 6)
    force = np.array([0.0, 8.0, -8.0, 12.0, 0.0, 0.0])
    place = 0.2 * times  # its velocity must not jump while the block sticks to it
    inputs = {
        name: {"times": times.tolist(), "values": values.tolist(), "interpolation": "linear"}
        for name, values in (("F", force), ("u", place))
    }
    whole = ps.simulate(sled, "rigid", {"x_dot": 1.0}, t_end=1.0, inputs=inputs)
    with Unit(done.file, tmp_path / "unit") as own:
        own.set(F=force[0], F_dot=40.0, u=0.0, u_dot=0.2)
        own.begin()
        for k, t in enumerate(times[:-1]):
            own.set(F=force[k], F_dot=(force[k + 1] - force[k]) / 0.2, u=place[k], u_dot=0.2)
            own.step(t, 0.2)
            for name in ("x", "x_dot", "tangential_force"):
                # The force is that before the step that begins there.
                known = whole.values(name, times[k + 1] - 1e-9)
                assert own.get(name) == pytest.approx(known, rel=1e-6, abs=1e-7)
    assert len(whole.events) >= 3


@pytest.mark.parametrize("version", VERSIONS)
def test_a_state_is_restored_also_from_bytes_in_another_instance(unit, version):
    """Memory and mode are part of it: the cut is within an impact."""
    names = ("theta_dot", "x_A_dot", "normal_force", "delta_max", "events", "mode")
    with unit("rod", version) as first, unit("rod", version) as second:
        first.begin()
        first.step(0.0, CUT)
        kept = first.state("get")
        assert first.get("delta_max") > 0 and first.mode() == "stick_restitution"
        first.step(CUT, 1e-4)
        between = [first.get(name) for name in names]
        first.step(CUT + 1e-4, 8e-3)
        end = [first.get(name) for name in names]
        first.state("set", kept)
        first.step(CUT, 1e-4)
        assert [first.get(name) for name in names] == between != end
        second.state("set", second.state("deserialize", first.state("serialize", kept)))
        second.step(CUT, 1e-4)
        assert [second.get(name) for name in names] == between
        second.step(CUT + 1e-4, 8e-3)
        assert [second.get(name) for name in names] == end
        other = first.state("serialize", kept)[:-8]
        with pytest.raises(Exception, match=r"(?i)status|failed"):
            second.state("deserialize", other)
        assert "the bytes are of another FMU" in second.said[-1]
        first.state("free", kept)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_reset_instance_begins_again_at_any_time(unit, version):
    with unit("rod", version) as own:
        own.begin(theta_dot=2.0)
        assert own.get("theta_dot") == 2.0
        own.step(0.0, 1e-3)
        own.fmu.reset()
        own.begin(start_time=5.0)
        assert own.get("theta_dot") == 1.0 and own.get("events") == 0
        own.step(5.0, 0.01)
        whole = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=0.01)
        assert own.get("theta_dot") == pytest.approx(whole.final["theta_dot"], rel=1e-9)


@pytest.mark.parametrize("version", VERSIONS)
def test_wrong_use_is_one_sentence_in_the_log(unit, version):
    raised = fmpy.fmi1.FMICallException if version == "2.0" else Exception
    with unit("falls", version) as own:
        with pytest.raises(raised):
            own.set(mu=-1.0)
        with pytest.raises(raised):
            own.set(theta=float("nan"))
        with pytest.raises(raised):
            own.begin(y_A=-0.1)
        own.begin(y_A=0.1)
        with pytest.raises(raised):
            own.set(theta=1.0)
        with pytest.raises(raised):
            own.step(0.2, 0.1)
        own.step(0.0, 0.1)
    assert len(own.said) == 5 and all(text.endswith(".") for text in own.said)
    for text, part in zip(
        own.said,
        (
            "parameter mu: got -1, need a finite number with 0 <= mu.",
            "theta: got nan, need a finite number.",
            "a rigid contact starts with gap >= 0",
            "theta cannot be set here.",
            "got the communication point 0.2",
        ),
        strict=True,
    ):
        assert part in text


@pytest.mark.parametrize("version", VERSIONS)
def test_a_change_that_moves_a_closed_contact_is_one_sentence(unit, version, tmp_path_factory):
    belt = Path(__file__).parents[2] / "examples" / "mechanisms" / "belt-oscillator.toml"
    folder = tmp_path_factory.mktemp("belt")
    file = export_fmu(
        str(belt), "rigid", {"x_dot": 0.2}, file=folder / "belt.fmu", fmi_version=version
    ).file
    with Unit(file, folder / "unit") as own:
        own.begin()
        own.step(0.0, 0.01)  # it sticks to the belt
        own.set(k_s=20.0)
        own.step(0.01, 0.01)
        own.set(u=0.4)
        with pytest.raises(Exception, match=r"(?i)status|failed"):
            own.step(0.02, 0.01)
        assert "moves contact belt while it is closed" in own.said[-1]


@pytest.mark.parametrize("version", VERSIONS)
def test_a_motion_that_ends_asks_for_the_end(crate, version, tmp_path):
    until = {"F": 40.0}
    done = export_fmu(
        crate, "rigid", {"x_dot": 1.0}, parameters=until | {"F": 0.0}, until="slip_stop",
        file=tmp_path / "crate.fmu", fmi_version=version, t_end=1.0,
    )  # fmt: skip
    rows = followed(done.file, 1.0, 0.25, ["x", "x_dot"])
    stop = 1.0 / (0.3 * 9.81)
    assert rows["x"][-1] == pytest.approx(stop / 2) and rows["x_dot"][-1] == 0
    assert len(rows) == 3
    if version == "2.0":
        assert rows["time"][-1] == pytest.approx(stop)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_unit_is_reproducible_and_fits_the_official_headers(unit, version, tmp_path):
    first = unit.written("rod", version)
    again = export_fmu(
        "rod", "bilinear-hertz", SLIDING, file=tmp_path / "rod.fmu", fmi_version=version, t_end=0.01
    )
    assert again.file.read_bytes() == first.file.read_bytes()
    fmpy.extract(str(again.file), str(tmp_path / "rod"))
    headers = Path(fmpy.__file__).parent / "c-code"
    assert (headers / f"fmi{version[0]}Functions.h").exists()
    strict = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-fsyntax-only")
    cc, official = find_compiler().command, ("-include", f"fmi{version[0]}Functions.h")
    where = tmp_path / "rod" / "sources"
    # The declarations of the standard may not be as strict as the code.
    run(*cc, *strict, "-isystem", headers, *official, "rod_fmu.c", cwd=where)
    run(*cc, *strict, "rod_fmu.c", cwd=where)


def test_words_and_names_of_a_mechanism_are_fit_for_fmi(crate, unit):
    done = unit.written("crate", "3.0")
    about = fmpy.read_model_description(str(done.file))
    assert about.modelName == "crate" and "a crate & a <motor>" in about.description
    own = {v.name: v for v in about.modelVariables}
    assert own["x"].description == 'place along the "floor" < here'
    assert own["F"].causality == "input" and own["mu"].causality == "parameter"
    assert all(name.isidentifier() and name.isascii() for name in own)
    with zipfile.ZipFile(done.file) as archive:
        names = archive.namelist()
    assert {"modelDescription.xml", "sources/buildDescription.xml"} <= set(names)
    assert any(name.startswith("binaries/") for name in names)


def test_taken_names_get_an_underscore():
    from painleve_sym.c_export.fmi_variables import _fit

    assert _fit(["a/b", "a_b", "2x", "λ"]) == ("a_b", "a_b_", "v_2x", "u3bb")


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ({"file": "rod.zip"}, "need a name that ends in .fmu"),
        ({"fmi_version": "1.0"}, "unknown version of FMI '1.0'"),
        ({"engine": "erk"}, "got 'erk'"),
        ({"inputs": ["nu_"]}, "unknown parameter 'nu_'"),
        ({"file": "no/such/folder/rod.fmu"}, "Fix: name a folder that exists"),
        ({"state": {"theta": 1.0, "y_A": -1.0}}, "inside the ground"),
        ({"until": "slip_stp"}, "Did you mean 'slip_stop'"),
    ],
)
def test_units_that_cannot_be_are_one_sentence(more, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = {"state": {"theta": 1.0}, "file": "rod.fmu"} | more
    state = given.pop("state")
    with pytest.raises(ps.InputError, match=sentence):
        export_fmu("rod", "rigid", state, **given)
    assert list(tmp_path.iterdir()) == []


def test_no_compiler_is_one_sentence(tmp_path, monkeypatch):
    from painleve_sym.errors import CompilerMissing

    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(CompilerMissing, match="no working C compiler"):
        export_fmu("rod", "rigid", {"theta": 1.0}, file=tmp_path / "rod.fmu")
    assert list(tmp_path.iterdir()) == []
