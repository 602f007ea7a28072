"""Exported C: built without the package, it gives the package's numbers to the last bit."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from painleve_sym.automata.compliant import CompliantContact
from painleve_sym.c_export import export
from painleve_sym.c_export.export import export_scenario, write_folder
from painleve_sym.c_export.files import NUMERIC_FLAGS, MotionCode, code_files, expected
from painleve_sym.c_export.text import enum
from painleve_sym.codegen.compile import find_compiler
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.laws.catalogue import law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.scenario import Scenario
from tests.support.exports import (
    SLEDGE,
    address,
    built_by_cmake,
    built_by_compiler,
    library,
    needs_cmake,
    run,
)

ROOT = Path(__file__).parents[2]
# clang contracts by default.
STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-march=native")
STRICT += ("-ffp-contract=off",)
SANITIZE = ("-fsanitize=undefined", "-fno-sanitize-recover=undefined")


@pytest.fixture(scope="module")
def sledge_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("mechanism") / "sledge.toml"
    path.write_text(SLEDGE, "utf-8")
    return str(path)


@pytest.fixture(scope="module")
def bouncing(sledge_file, tmp_path_factory):
    """A rigid export whose bounces die out, after which it slides and sticks."""
    scenario = Scenario(sledge_file, law="rigid", t_end=3.0)
    return export_scenario(scenario, tmp_path_factory.mktemp("rigid") / "c")


@pytest.fixture(scope="module")
def compressed(sledge_file):
    """A compliant scenario that starts compressed."""
    state = {"x": 0.0, "x_dot": 1.0}
    return Scenario(sledge_file, state, law="linear", initial_force=60.0, t_end=0.02)


@pytest.fixture(scope="module")
def pressed(compressed, tmp_path_factory):
    return export_scenario(compressed, tmp_path_factory.mktemp("softened") / "c", "spring")


def test_second_export_derives_nothing_and_writes_the_same(
    pressed, compressed, tmp_path, monkeypatch
):
    def refuse(*_):
        raise AssertionError("this should have come from the cache")

    monkeypatch.setattr(CompliantContact, "automaton", property(refuse))
    monkeypatch.setattr(Mechanism, "coefficients", property(refuse))
    again = export_scenario(compressed, tmp_path / "c", "spring")
    assert again.files == pressed.files
    for name in again.files:
        assert (again.folder / name).read_bytes() == (pressed.folder / name).read_bytes()


@pytest.mark.slow
def test_export_built_by_cmake_gives_the_packages_numbers(pressed):
    needs_cmake()
    text = built_by_cmake(pressed)
    assert text == (pressed.folder / "expected.txt").read_text("utf-8")
    assert text == expected(pressed.trajectory)
    assert len(pressed.trajectory.events) >= 2
    # No name of the library may meet one of another export, or of the reader's program.
    listed = run("nm", "-g", "--defined-only", "build/libspring_model.a", cwd=pressed.folder)
    names = [line.split()[-1] for line in listed.splitlines() if " " in line]
    assert len(names) >= 15 and all(n.lstrip("_").startswith("spring_") for n in names)


def test_export_compiles_without_warnings_and_follows_bounces_into_rest(bouncing):
    text = built_by_compiler(bouncing, *STRICT, "-O0")
    assert text == expected(bouncing.trajectory)
    kinds = [line.split()[2] for line in text.splitlines() if line.startswith("event")]
    assert kinds.count("settle:") == 1 and kinds.count("touchdown:") > 20
    # What follows from the closed contact comes after its closing.
    assert kinds[kinds.index("settle:") + 1] == "contact:"


def test_export_without_memory_returns_null_and_keeps_none(bouncing):
    """Each allocation of a run fails in turn; what was allocated before it is freed."""
    (bouncing.folder / "allocate.h").write_text(
        """
#include <stdlib.h>
extern long allocated, fail_at;
void *allocate(void *old, size_t size);
static inline void *zeros(size_t n, size_t size) {
  char *block = (char *)allocate(NULL, n * size);
  for (size_t i = 0; block && i < n * size; i++) block[i] = 0;
  return block;
}
static inline void release(void *block) { if (block) allocated--; free(block); }
#define malloc(size) allocate(NULL, size)
#define calloc(n, size) zeros(n, size)
#define realloc(old, size) allocate(old, size)
#define free(block) release(block)
"""
    )
    (bouncing.folder / "starve.c").write_text(
        """
#include "sledge_model.h"
#include <stdio.h>
#undef realloc
long allocated = 0, fail_at = 0;
void *allocate(void *old, size_t size) {
  if (fail_at-- == 0) return NULL;
  if (!old) allocated++;
  return realloc(old, size);
}
int main(void) {
  const double *p = sledge_default_parameters;
  for (long k = 0;; k++) {
    double x[SLEDGE_STATES] = {0.0, 0.01, 1.0, 0.0};
    sledge_options o;
    sledge_complete_state(p, x);
    sledge_default_options(p, x, 3.0, 1e-9, &o);
    fail_at = k;
    sledge_run *run = sledge_simulate(p, x, &o);
    const int ended = run != NULL;
    sledge_free(run);
    if (allocated) return printf("%ld: %ld kept\\n", k, allocated);
    if (ended) return printf("%ld failed\\n", k) < 0;
  }
}
"""
    )
    sources = sorted(p.name for p in bouncing.folder.glob("sledge_*.c"))
    flags = ("-O0", "-include", "allocate.h", "-o", "starve")
    run(*find_compiler().command, *flags, "starve.c", *sources, "-lm", cwd=bouncing.folder)
    failed = int(run("./starve", cwd=bouncing.folder).split()[0])
    # The run, the values given back, its events, and steps and events that need more room.
    assert failed >= 5


@pytest.mark.slow
def test_export_states_and_tolerances_of_any_start_are_the_packages(bouncing, pressed):
    rng = np.random.default_rng(7)
    for done in (bouncing, pressed):
        c, simulator = library(done), simulator_of(done)
        values = done.trajectory.parameters
        p = np.array([values[n] for n in simulator.outline.parameter_names])
        tolerances = getattr(c, f"{done.name}_tolerances")
        complete = getattr(c, f"{done.name}_complete_state")
        for _ in range(50):
            motion = rng.normal(size=4) * 10.0 ** rng.integers(-12, 3)
            names = simulator.mechanism.state_names
            given = dict(zip(names, motion, strict=True))
            start = simulator.prepared(simulator.at(given, values))[0]
            whole = start.state
            x, atol = np.full(len(whole), np.nan), np.full(len(whole), np.nan)
            x[:4] = motion
            complete(address(p), address(x))
            np.testing.assert_array_equal(x, whole)
            tolerances(address(p), address(x), ctypes.c_double(1e-9), address(atol))
            np.testing.assert_array_equal(atol, 1e-9 * start.scale)


def simulator_of(done):
    mechanism = model(str(next(done.folder.parent.parent.glob("mechanism*/sledge.toml"))))
    if done.trajectory.law == "rigid":
        return Simulator(mechanism, RigidLaw())
    return Simulator(mechanism, law(done.trajectory.law))


@pytest.mark.slow
def test_export_evaluates_between_steps_in_a_program_in_cpp(bouncing):
    """A program of one's own: the motion at any time, rates, options, several runs."""
    compiler = shutil.which("g++") or shutil.which("c++")
    if compiler is None:
        pytest.skip("no C++ compiler is installed")
    times = np.linspace(0.0, bouncing.trajectory.final_time, 60)
    listed = ", ".join(map(repr, times.tolist()))
    (bouncing.folder / "mine.cc").write_text(
        f"""
#include "sledge_model.h"
#include <cstdio>
int main() {{
  const double times[] = {{{listed}}}, *p = sledge_default_parameters;
  double start[SLEDGE_STATES] = {{0}}, x[SLEDGE_STATES], rates[SLEDGE_STATES];
  sledge_options o;
  start[sledge_state_x_dot] = 1.0;
  start[sledge_state_h] = 0.01;
  sledge_complete_state(p, start);
  sledge_default_options(p, start, 3.0, 1e-11, &o);
  o.keep_steps = 1;
  sledge_run *run = sledge_simulate(p, start, &o);
  for (double t : times) {{
    if (!sledge_at(run, t, x)) return 1;
    for (double v : x) std::printf("%.17g ", v);
  }}
  if (sledge_at(run, -1.0, x) || sledge_at(run, 4.0, x)) return 2;
  sledge_rates(p, sledge_mode_flight, x, 0, rates);
  if (rates[sledge_state_h_dot] != -9.8) return 3;
  sledge_free(run);
  sledge_free(0);
  o.max_events = 3;
  run = sledge_simulate(p, start, &o);
  if (run->stop != sledge_stop_event_limit || run->event_count != 3) return 4;
  sledge_free(run);
  return 0;
}}
""",
        "utf-8",
    )
    cc, flags = find_compiler().command, ("-Wall", "-Wextra", "-Werror", "-c")
    for part in ("model", "contact"):
        run(*cc, "-O0", "-march=native", *SANITIZE, "-c", f"sledge_{part}.c", cwd=bouncing.folder)
    run(compiler, *flags, "mine.cc", cwd=bouncing.folder)
    objects = ("mine.o", "sledge_model.o", "sledge_contact.o")
    run(compiler, *SANITIZE, "-o", "mine", *objects, "-lm", cwd=bouncing.folder)
    computed = np.array(run("./mine", cwd=bouncing.folder).split(), dtype=float)
    np.testing.assert_array_equal(computed.reshape(60, -1), bouncing.trajectory(times))


def test_export_header_says_units_meanings_compiler_and_flags(pressed):
    text = (pressed.folder / "spring_model.h").read_text("utf-8")
    assert "spring_parameter_g" in text and "gravity; m/s^2" in text
    assert "spring_state_gap " in text and "spring_event_separation" in text
    assert "spring_stop_until" in text and pressed.compiler.version in text
    assert "-ffp-contract=off" in text and "free" in text and "threads" in text
    cmake = (pressed.folder / "CMakeLists.txt").read_text("utf-8")
    assert all(flag in cmake for flag in NUMERIC_FLAGS)


TABLE_3 = Scenario(
    "rod",
    {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0},
    law="bilinear-hertz",
    law_parameters={"E": 20.9e14},
    law_choices={"reload": "virgin"},
    t_end=1e-3,
)


@pytest.mark.slow
@pytest.mark.parametrize(
    "scenario",
    [
        TABLE_3,
        replace(TABLE_3, engine="compiled"),
        Scenario(
            "rod",
            {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0},
            law="bilinear-hertz",
            initial_force=350.0,
            until=("separation", "liftoff"),
            rtol=1e-9,
            max_steps=5000,
            t_end=1.0,
        ),
        Scenario(
            "rod",
            {"theta": 1.0, "theta_dot": -0.3, "x_A_dot": -1.0, "y_A": 0.05},
            law="rigid",
            law_choices={"restitution": "poisson"},
        ),
        Scenario("eccentric-disc", law="rigid", t_end=2.0),
        Scenario("painleve-klein", law="rigid"),
        Scenario(
            str(ROOT / "examples/mechanisms/wheel-on-slope.toml"), law="hunt-crossley", t_end=0.1
        ),
        Scenario(
            str(ROOT / "examples/mechanisms/oscillating-table.toml"),
            {"y": 0.05, "x_dot": 0.3, "t": 0.02},
            law="rigid",
            t_end=0.3,
        ),
    ],
    ids=["table-3", "runge-kutta", "pressed", "impacts", "settles", "guide", "toml", "shaken"],
)
def test_export_of_a_case_is_the_package_to_the_last_bit(scenario, tmp_path):
    needs_cmake()
    done = export_scenario(scenario, tmp_path / "c")
    wanted = "taylor" if scenario.engine == "auto" else scenario.engine
    assert done.trajectory.engine == wanted and len(done.trajectory.events) >= 3
    assert built_by_cmake(done) == expected(done.trajectory)
    # Without optimisation too: nothing hangs on what the compiler rearranges.
    assert built_by_compiler(done, *STRICT, "-O0") == expected(done.trajectory)


@pytest.mark.slow
def test_program_of_the_page_builds_and_finds_what_the_package_finds(tmp_path):
    page = (ROOT / "docs" / "export.md").read_text("utf-8")
    done = export_scenario(Scenario("rod", law="bilinear-hertz"), tmp_path / "c")
    program = re.search(r"```c\n(.*?)```", page, re.S).group(1)
    (done.folder / "main.c").write_text(program, "utf-8")
    computed = float(built_by_compiler(done, *STRICT, "-O2").split()[0])
    simulator = Simulator(model("rod"), law("bilinear-hertz"))
    options = {"t_end": 0.01, "parameters": {"E": 209e9}}
    for spin, stops in ((computed - 1e-5, True), (computed + 1e-5, False)):
        run_ = simulator.run({"theta": 1.0, "x_A_dot": -1.0, "theta_dot": spin}, **options)
        assert bool(run_.events_of("slip_stop")) is stops


# ---- several contacts ----


@pytest.mark.slow
def test_code_is_c99_where_no_choice_has_a_test(tmp_path):
    simulator = Simulator(model("block-two-feet"), law("linear", friction="spring"))
    code = MotionCode("feet", simulator, "taylor", find_compiler())
    for name, text in code_files(code).items():
        (tmp_path / name).write_text(text, "utf-8")
    sources = sorted(tmp_path.glob("*.c"))
    assert "#define PS_NTEST 0" in (tmp_path / "feet_model.c").read_text("utf-8")
    run(*find_compiler().command, *STRICT, "-fsyntax-only", *sources, cwd=tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "kinds", "level"),
    [
        (
            Scenario(
                "block-two-feet",
                {"y_A": 0.05, "theta": 0.1, "x_A_dot": 0.3},
                law="rigid",
                t_end=0.6,
            ),
            {"touchdown", "impact"},
            "-O1",
        ),
        (
            Scenario(
                "block-two-feet",
                {"y_A": 0.05, "theta": 0.1, "x_A_dot": 0.3},
                law="A=linear,B=rigid",
                t_end=0.4,
            ),
            {"touchdown", "separation", "impact"},
            "-O0",
        ),
    ],
    ids=["rigid", "mixed"],
)
def test_export_of_several_contacts_is_the_package_to_the_last_bit(
    scenario, kinds, level, tmp_path
):
    done = export_scenario(scenario, tmp_path / "c")
    assert kinds <= {str(e.kind) for e in done.trajectory.events}
    assert built_by_compiler(done, *STRICT, level) == expected(done.trajectory)
    c, simulator = library(done), Simulator(model("block-two-feet"), law(scenario.law))
    values, rng = done.trajectory.parameters, np.random.default_rng(3)
    p = np.array([values[n] for n in simulator.outline.parameter_names])
    for _ in range(50):
        motion = rng.normal(size=6) * 10.0 ** rng.integers(-12, 3)
        given = dict(zip(simulator.mechanism.state_names, motion, strict=True))
        start = simulator.prepared(simulator.at(given, values))[0]
        whole = start.state
        x, atol = np.full(len(whole), np.nan), np.full(len(whole), np.nan)
        x[:6] = motion
        c.block_two_feet_complete_state(address(p), address(x))
        np.testing.assert_array_equal(x, whole)
        c.block_two_feet_tolerances(address(p), address(x), ctypes.c_double(1e-9), address(atol))
        np.testing.assert_array_equal(atol, 1e-9 * start.scale)


# ---- rejected input ----


def test_export_refuses_names_that_are_none(sledge_file, tmp_path):
    target = tmp_path / "c"
    for name in ("2rod", "a-b", "ps", "Casadi", "", "rod\n"):
        with pytest.raises(InputError, match="name: got"):
            export_scenario(Scenario(sledge_file, law="rigid"), target, name)
    assert list(tmp_path.iterdir()) == []


def test_export_name_of_a_mechanism_is_made_fit():
    assert export._checked_name("ps", True) == "model_ps"
    assert export._checked_name("2rods", True) == "model_2rods"
    assert export._checked_name("rod_1", True) == "rod_1"


def test_write_folder_writes_all_or_nothing(tmp_path, monkeypatch):
    write_folder(tmp_path / "new" / "c", {"a": "1", "b": "ü"})
    assert (tmp_path / "new" / "c" / "b").read_text("utf-8") == "ü"
    before = os.umask(0o077)
    try:
        write_folder(tmp_path / "private", {"a": "1"})
    finally:
        os.umask(before)
    assert (tmp_path / "private").stat().st_mode & 0o777 == 0o700
    shutil.rmtree(tmp_path / "private")
    (tmp_path / "empty").mkdir()
    write_folder(tmp_path / "empty", {"a": "1"})
    assert os.listdir(tmp_path / "empty") == ["a"]
    # Filled by someone else in the meantime.
    with pytest.raises(InputError, match="cannot be written"):
        write_folder(tmp_path / "empty", {"a": "2"})
    assert (tmp_path / "empty" / "a").read_text() == "1"

    def full(path, *_):
        if path.name == "b":
            raise OSError(28, "No space left on device")
        path.touch()

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(InputError, match="No space left"):
        write_folder(tmp_path / "x" / "y", {"a": "1", "b": "2"})
    assert sorted(os.listdir(tmp_path)) == ["empty", "new"]


def test_enum_is_of_names_with_comments():
    assert "there is none" in enum("e", "e", [], "Nothing")
    assert "\n  e_a_b = 0  /* c */\n" in enum("e", "e", [("a/b", "c")], "One")
