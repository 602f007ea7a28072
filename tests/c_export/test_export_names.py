"""Names of an export: each works, or is rejected in one sentence."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.c_export import export
from painleve_sym.c_export.files import clashing_name, files
from painleve_sym.c_export.text import identifiers
from painleve_sym.codegen.compile import find_compiler
from painleve_sym.errors import InputError
from painleve_sym.motion.runs import simulator_of
from painleve_sym.study.scenario import Scenario
from tests.support.exports import SLEDGE, built_by_compiler, needs_cmake, run

PLAIN = ("int", "class", "E", "errno", "NULL", "a_", "ROD", "model", "start", "own", "CONTACT")


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    path = tmp_path_factory.mktemp("mechanism") / "sledge.toml"
    # A coordinate whose name, after that of the table, is the name of the array of names.
    path.write_text(
        SLEDGE.replace("x_dot", "names_dot")
        .replace("\nx = {", "\nnames = {")
        .replace("x/10", "names/10"),
        "utf-8",
    )
    scenario = Scenario(str(path), law="linear", state={"h": 0.0, "names_dot": 1.0}, t_end=1e-3)
    simulator = simulator_of(scenario.mechanism(), scenario.contact_law())
    trajectory, place = scenario.simulate(), simulator.at(scenario.start())
    return export.ExampleCode(
        name="plain",
        simulator=simulator,
        engine_name=trajectory.engine,
        trajectory=trajectory,
        parameters=place.parameters,
        motion=simulator.start(place).state[: len(place.state)],
        t_end=1e-3,
        rtol=scenario.settings.rtol,
        until=(),
        limits={},
        initial_force=None,
        compiler=find_compiler(),
    )


def faults(case, name, folder):
    """Return what the compiler says of the export under that name; None where it is rejected."""
    named = replace(case, name=export._checked_name(name, False))
    # What it costs to generate does not depend on the name.
    named.__dict__["engine"] = case.engine
    texts = files(named)
    if clashing_name(named, texts):
        return None
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for path, text in texts.items():
        (folder / path).write_text(text, "utf-8")
    sources = sorted(path for path in texts if path.endswith(".c"))
    done = subprocess.run(
        [*find_compiler().command, "-std=c99", "-fsyntax-only", *sources],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stderr


@pytest.mark.parametrize("name", PLAIN)
def test_name_that_is_a_word_of_c_works(case, tmp_path, name):
    assert faults(case, name, tmp_path / "c") == ""


def prefixes(case):
    """Return every beginning of a name of the generated code that may be the name of an export."""
    texts = files(case).items()
    words = sorted(set().union(*(identifiers(t) for n, t in texts if n.endswith((".c", ".h")))))
    parts = {word[:i] for word in words for i, letter in enumerate(word) if letter == "_"}
    return sorted(part for part in parts if part[:1].isalpha() and len(part) < 40)


def test_names_of_the_generated_code_are_known(case):
    known = prefixes(case)
    assert {"state", "end", "start", "ps", "contact"} <= set(known)


@pytest.mark.slow
@settings(max_examples=25)
@given(data=st.data())
def test_every_name_works_or_is_refused(case, tmp_path_factory, data):
    known = prefixes(case)
    name = data.draw(
        st.sampled_from([*known, *(k.lower() for k in known), *(k.upper() for k in known)])
    )
    try:
        assert not faults(case, name, tmp_path_factory.getbasetemp() / "names")
    except InputError as error:
        assert "name: got" in str(error)


@pytest.mark.parametrize("name", ["state", "end", "ps", "Casadi", "generated"])
def test_name_that_clashes_is_refused_in_one_sentence(tmp_path, name):
    scenario = Scenario("rod", law="rigid", t_end=1e-4)
    with pytest.raises(InputError, match=f"name: got '{name}'") as caught:
        export.export_scenario(scenario, tmp_path / "c", name)
    assert str(caught.value).count(". ") <= 1 and list(tmp_path.iterdir()) == []


def test_name_of_a_mechanism_that_clashes_is_made_fit(tmp_path):
    path = tmp_path / "state.toml"
    path.write_text(SLEDGE.replace('"sledge"', '"state"'), "utf-8")
    done = export.export_scenario(Scenario(str(path), law="rigid", t_end=1e-3), tmp_path / "c")
    assert done.name == "model_state"
    assert built_by_compiler(done, "-O0", "-march=native", "-ffp-contract=off")


def test_header_serves_c_plus_plus(case, tmp_path):
    compiler = shutil.which("g++") or shutil.which("c++")
    if compiler is None:
        pytest.skip("no C++ compiler is installed")
    (tmp_path / "plain_model.h").write_text(files(case)["plain_model.h"], "utf-8")
    (tmp_path / "mine.cc").write_text('#include "plain_model.h"\nplain_coefficients c;\n')
    run(compiler, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "mine.cc", cwd=tmp_path)


# ---- as a CMake package ----

CONSUMER = """
cmake_minimum_required(VERSION 3.13)
project(mine C)
find_package(start_model REQUIRED)
add_executable(mine mine.c)
target_link_libraries(mine PRIVATE start::start_model)
"""
PROGRAM = """
#include <start_model.h>
#include <stdio.h>
int main(void) {
  double x[START_STATES] = {0};
  x[start_state_theta] = 1.0;
  x[start_state_theta_dot] = 1.0;
  x[start_state_x_A_dot] = -1.0;
  start_complete_state(start_default_parameters, x);
  puts(start_case_names[start_classify(start_default_parameters, x, 0)]);
  return 0;
}
"""


@pytest.mark.slow
def test_installed_export_is_a_package_of_cmake(tmp_path):
    needs_cmake()
    done = export.export_scenario(Scenario("rod", law="rigid", t_end=1e-4), tmp_path / "c", "start")
    prefix, mine = tmp_path / "prefix", tmp_path / "mine"
    run("cmake", "-B", "build", cwd=done.folder)
    run("cmake", "--build", "build", "--target", "start_model", cwd=done.folder)
    run("cmake", "--install", "build", "--prefix", prefix, cwd=done.folder)
    # It needs nothing of where it was built.
    shutil.rmtree(done.folder)
    mine.mkdir()
    (mine / "CMakeLists.txt").write_text(CONSUMER, "utf-8")
    (mine / "mine.c").write_text(PROGRAM, "utf-8")
    run("cmake", "-B", "build", f"-DCMAKE_PREFIX_PATH={prefix}", cwd=mine)
    run("cmake", "--build", "build", cwd=mine)
    assert run("build/mine", cwd=mine) == "inconsistent\n"
