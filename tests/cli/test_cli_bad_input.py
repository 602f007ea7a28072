"""Every wrong input: one line on standard error, exit code 2, nothing written."""

from __future__ import annotations

import os

import pytest

from tests.cli.cli_helpers import LAW, ROOT, TABLE_3, TABLE_4, rejected, run

CLASSIFY = ("classify", "rod", "--state", TABLE_3)
JUMP = ("jump", "rod", "--state", TABLE_3)
SIMULATE = ("simulate", "rod", "--state", TABLE_3, *LAW, "--t-end", "0.001")
CRITICAL = ("critical", "rod", "--state", TABLE_4)

# Arguments, and words the message must hold.
CASES = [
    (("simulat",), "Did you mean 'simulate'?"),
    (("sweep",), "SWEEP"),
    (("sweep", "absent.toml"), "No such file"),
    (("--verson",), "Did you mean '--version'?"),
    (("",), "unknown command ''"),
    (("classify",), "CASE"),
    (("derive",), "MODEL"),
    (("models", "rod", "extra"), "unexpected 'extra'"),
    (("classify", "rod", "--jsn"), "Did you mean '--json'?"),
    ((*CLASSIFY, "--law", "hertz"), "unknown option '--law'"),
    (("classify", "rod", "--state", "theta=1,", "theta_dot=2"), "commas, without spaces"),
    (("classify", "rdo", "--state", TABLE_3), "Did you mean 'rod'?"),
    (("derive", "rdo"), "Did you mean 'rod'?"),
    (("derive", "rod", "--format", "pyton"), "Did you mean 'python'?"),
    (("classify", "rod", "--state", "thta=1"), "Did you mean 'theta'?"),
    (("classify", "rod", "--state", "theta=1,theta=2"), "got theta twice"),
    (("classify", "rod", "--state", "theta=1", "--state", "theta=2"), "got theta twice"),
    (("classify", "rod", "--state", "theta"), "need name=value"),
    (("classify", "rod", "--state", "theta="), "need name=value"),
    (("classify", "rod", "--state", "=1"), "need name=value"),
    (("classify", "rod", "--state", "theta=1,,x_A_dot=1"), "need name=value"),
    (("classify", "rod", "--state", "theta=one"), "got 'one', need a number"),
    (("classify", "rod", "--state", "theta=nan"), "need a finite number"),
    (("classify", "rod", "--state", "theta=1,x_A_dot=-inf"), "need a finite number"),
    (("classify", "rod", "--state", "theta=1,x_A_dot=1e999"), "need a finite number"),
    (("classify", "rod", "--state", "theta=0"), "theta > 0"),
    (("classify", "rod", "--state", "theta=3.2"), "pi - theta > 0"),
    (("classify", "rod", "--state", "theta_dot=1"), "Fix: give theta"),
    (("classify", "rod", "--state", f"{TABLE_3},y_A=-1e-6"), "inside the ground"),
    (("classify", "rod", "--state", f"{TABLE_3},y_A=1e-6"), "gap = 1e-06"),
    (("classify", "rod", "--state", f"{TABLE_3},y_A_dot=-1"), "use jump or simulate"),
    (("classify", "rod", "--state", "theta=1,theta_dot=1e200"), "at most 1e+100 in size"),
    (("jump", "rod", "--state", f"{TABLE_3},y_A=-1e-6"), "inside the ground"),
    (("jump", "rod", "--state", f"{TABLE_3},y_A=1"), "above the ground"),
    (("jump", "rod", "--state", f"{TABLE_3},y_A_dot=1"), "opening"),
    (("jump", "rod", "--state", "theta=0.5,x_A_dot=-1"), "need A <= 0"),
    (("jump", "rod", "--state", "theta=1,x_A_dot=-1e300"), "at most 1e+100 in size"),
    ((*JUMP, "--restitution", "1.5"), "0 <= e_energetic <= 1"),
    ((*JUMP, "--restitution", "-0.1"), "0 <= e_energetic <= 1"),
    ((*JUMP, "--restitution", "nan"), "need a finite number"),
    ((*JUMP, "--rule", "newtn"), "Did you mean 'newton'?"),
    ((*CLASSIFY, "--set", "m=0"), "0 < m"),
    ((*CLASSIFY, "--set", "m=-1"), "0 < m"),
    ((*CLASSIFY, "--set", "mu=-0.5"), "0 <= mu"),
    ((*CLASSIFY, "--set", "mass=1"), "unknown parameter 'mass'"),
    ((*CLASSIFY, "--set", "mu=inf"), "need a finite number"),
    ((*SIMULATE, "--set", "E=1e9"), "--law-set"),
    ((*CLASSIFY, "--set", "E=1e9"), "--law-set"),
    (("classify", "pr-robot", "--close", "x"), "does not depend on x. Fix: name one of theta"),
    (("classify", "pr-robot", "--close", "angle"), "unknown coordinate 'angle'"),
    (("classify", "pr-robot", "--close", "tip2:theta"), "unknown contact 'tip2'"),
    (("classify", "pr-robot", "--close", "theta", "--set", "h=3"), "no theta makes the gap"),
    (("classify", "pr-robot", "--close", "theta,theta"), "at most one coordinate"),
    (("classify", "pr-robot", "--close", ""), "unknown coordinate ''"),
    (("classify", "block-two-feet", "--close", "y_A"), "need CONTACT:COORDINATE, such as A:y_A"),
    (("classify", "block-two-feet", "--close", "front"), "CONTACT:COORDINATE, such as A:y_A:"),
    (("classify", "block-two-feet", "--close", "B"), "CONTACT:COORDINATE, such as B:y_A:"),
    (("simulate", "rod", "--state", TABLE_3, *LAW), "--t-end"),
    (("simulate", "rod", "--state", TABLE_3, "--t-end", "1"), "--law"),
    (("simulate", "rod", "--state", TABLE_3, "--law-set", "E=1", "--t-end", "1"), "--law"),
    ((*SIMULATE, "--t-end"), "--t-end"),
    ((*SIMULATE, "--t-end", "0"), "t_end: got 0.0"),
    ((*SIMULATE, "--t-end", "-1e-3"), "t_end: got -0.001"),
    ((*SIMULATE, "--t-end", "inf"), "need a finite number"),
    ((*SIMULATE, "--law", "hrtz"), "Did you mean 'hertz'?"),
    ((*SIMULATE, "--law-set", "E=0"), "0 < E"),
    ((*SIMULATE, "--law-set", "n=0"), "0 < n"),
    ((*SIMULATE, "--law-set", "n=-1"), "0 < n"),
    ((*SIMULATE, "--law-set", "e_energetic=1.01"), "0 <= e_energetic <= 1"),
    ((*SIMULATE, "--law-set", "e_energetic=-1"), "0 <= e_energetic <= 1"),
    ((*SIMULATE, "--law-set", "E=1e9,E=2e9"), "got E twice"),
    ((*SIMULATE, "--law-set", "e_enrgetic=1"), "Did you mean 'e_energetic'?"),
    ((*SIMULATE, "--law-set", "reload=virgn"), "Did you mean 'virgin'?"),
    ((*SIMULATE, "--rtol", "0"), "rtol: got 0.0"),
    ((*SIMULATE, "--rtol", "-1e-6"), "rtol: got -1e-06"),
    ((*SIMULATE, "--rtol", "1"), "rtol: got 1.0"),
    ((*SIMULATE, "--rtol", "nan"), "need a finite number"),
    ((*SIMULATE, "--max-steps", "0"), "whole number"),
    ((*SIMULATE, "--max-steps", "2.5"), "whole number"),
    ((*SIMULATE, "--max-steps", "1e30"), "whole number"),
    ((*SIMULATE, "--samples", "1"), "samples: got 1"),
    ((*SIMULATE, "--samples", "1e8"), "samples: got 100000000"),
    ((*SIMULATE, "--engine", "compild"), "Did you mean 'compiled'?"),
    ((*SIMULATE, "--until", "separaton"), "Did you mean 'separation'?"),
    ((*SIMULATE, "--initial-force", "-5"), "got -5.0"),
    (("automaton", "rod"), "--law"),
    (("automaton", "rod", "--law", "hertz", "--law-set", "reload=virgin"), "'reload'"),
    (("automaton", "rod", "--law", "hertz", "--format", "dot"), "graphviz"),
    (("reproduce", "--only", "no-such-item"), "unknown item 'no-such-item'"),
    ((*CRITICAL, "--law-set", "n=1e90"), "range of floating point"),
    ((*CRITICAL, "--law-set", "n=1e-90"), "range of floating point"),
    ((*CRITICAL, "--law-set", "n=1e-200"), "need a finite number with 0 < n, of at least 1e-100"),
    (("classify", "rod", "--set", "m=1e-320"), "number with 0 < m, of at least 1e-100"),
    (("classify", "brick", "--set", "m=1e-310"), "parameter m (mass): got 1e-310"),
    (("jump", "brick", "--set", "b=5e-324"), "of at least 1e-100"),
    (("map", "rod", "--over", "theta,mu", "--set", "l=1e-300"), "of at least 1e-100"),
]


@pytest.mark.parametrize(("arguments", "words"), CASES)
def test_bad_input_is_one_line_and_exit_code_2(capsys, arguments, words):
    assert words in rejected(capsys, *arguments)


ANY_MASS = """
[coordinates]
x = { unit = "m", meaning = "place" }
y = { unit = "m", meaning = "height" }
a = { unit = "rad", meaning = "angle" }
[parameters]
m = { default = 1.0, unit = "kg", meaning = "mass, of which the file says no range" }
mu = { default = 0.5, unit = "1", meaning = "friction coefficient" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
inertia = "m"
angle = "a"
[[contacts]]
name = "A"
point = ["x - cos(a)", "y - sin(a)"]
friction = "mu"
[start]
a = 1.0
y = 0.8414709848078965
x_dot = -1.0
"""


@pytest.mark.parametrize(
    ("command", "mass"),
    [
        ("classify", "1e-320"),
        ("jump", "1e-320"),
        ("critical", "1e-320"),
        ("contrast", "1e-320"),
        ("classify", "0"),
        ("jump", "0"),
    ],
)
def test_mobility_without_numbers_is_said_of_the_state(capsys, tmp_path, command, mass):
    file = tmp_path / "any.toml"
    file.write_text(ANY_MASS)
    more = ("--law", "hunt-crossley") if command == "critical" else ()
    code, out, err = run(capsys, command, str(file), "--set", f"m={mass}", *more)
    assert code == 2 and out == "" and err.count("\n") == 1
    assert "state of 'any': got" in err and f"m = {float(mass)!r}" in err
    assert "is not a finite number" in err
    assert not any(word in err for word in ("array", "Problem", "nan", "inf"))


def test_several_faults_are_told_at_once(capsys):
    err = rejected(capsys, *CLASSIFY, "--set", "m=-1,mu=-1")
    assert "parameter m" in err and "parameter mu" in err


@pytest.mark.parametrize(
    "arguments",
    [
        ("x" * 300_000,),
        ("classify", "x" * 300_000),
        ("classify", "x" * 300_000 + ".toml"),
        ("classify", "rod", "--state", f"theta={'1' * 300_000}"),
        ("classify", "rod", "--state", ",".join(f"a{i}=1" for i in range(3_000))),
        ("classify", "rod", "--" + "x" * 300_000),
        (*SIMULATE, "--save", "x" * 300_000),
    ],
)
def test_an_error_line_has_a_limited_length(capsys, arguments):
    err = rejected(capsys, *arguments)
    assert len(err) < 3000


# ---- output files: rejected before anything is computed ----


@pytest.fixture
def no_computing(monkeypatch):
    def fail(*_):
        raise AssertionError("computed before the output was checked")

    monkeypatch.setattr("painleve_sym.study.scenario.Scenario.simulate", fail)


@pytest.mark.parametrize(
    ("option", "name", "words"),
    [
        ("--save", "", "is a folder"),
        ("--save", "missing/run.npz", "no such folder"),
        ("--save", "file/run.npz", "not a folder"),
        ("--save", "run.csv", ".npz"),
        ("--save", "x" * 300, "name too long"),
        ("--plot", "run.jpg", ".png, .svg, .pdf"),
        ("--plot", "run", ".png, .svg, .pdf"),
        ("--plot", "missing/run.png", "no such folder"),
        ("--plot", "", "is a folder"),
    ],
)
def test_output_file_that_cannot_be_written(capsys, tmp_path, no_computing, option, name, words):
    (tmp_path / "file").write_text("", "utf-8")
    code, out, err = run(capsys, *SIMULATE, option, tmp_path / name)
    assert (code, out) == (2, "")
    assert err.startswith(f"painleve: error: {option}: ") and err.count("\n") == 1
    assert words in err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file"]


@pytest.mark.parametrize(
    "arguments",
    [
        (*SIMULATE, "--save"),
        (*SIMULATE, "--plot"),
        ("sweep", "examples/sweeps/table3_grid.toml", "--out"),
        ("fit", "none.csv", "rod", "--law", "hertz", "--estimate", "mu", "--out"),
        ("reproduce", "--only", "eq-1", "--out"),
        ("export", "rod", "--law", "hertz", "--out"),
        ("map", "rod", "--over", "theta,mu", "--out"),
    ],
    ids=lambda words: words[0],
)
def test_output_without_a_name_is_refused(capsys, tmp_path, monkeypatch, no_computing, arguments):
    files = [str(ROOT / word) if word.startswith("examples") else word for word in arguments]
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, *files, "")
    assert (code, out) == (2, "")
    assert err.startswith("painleve: error: --") and "got an empty name. Fix: give a name" in err
    assert list(tmp_path.iterdir()) == []


def test_output_file_must_not_be_a_device(capsys, no_computing):
    assert "cannot be written" in rejected(capsys, *SIMULATE, "--save", os.devnull)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_output_folder_without_permission(capsys, tmp_path, no_computing):
    tmp_path.chmod(0o500)
    assert "Permission denied" in rejected(capsys, *SIMULATE, "--save", tmp_path / "run.npz")


@pytest.mark.parametrize("name", ["file", "file/sub", "x" * 300])
def test_report_folder_that_cannot_be_made(capsys, tmp_path, monkeypatch, name):
    def fail(*_, **__):
        raise AssertionError("computed before the folder was checked")

    monkeypatch.setattr("painleve_sym.papers.registry.reproduce", fail)
    (tmp_path / "file").write_text("", "utf-8")
    code, out, err = run(capsys, "reproduce", "--out", tmp_path / name)
    assert (code, out) == (2, "")
    assert err.startswith("painleve: error: --out: ") and err.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ("rod",),
            "'rod' is a mechanism, and a command comes first. Fix: such as `painleve classify rod`",
        ),
        (("my.toml",), "'my.toml' is a file, and a command comes first"),
        (("classify", "rod", "theta=1"), "Fix: give it with an option, such as --state theta=1"),
        (("simulate", "rod", "hertz"), "Fix: give it with --law hertz."),
        (("cache", "rod"), "unexpected 'rod'. Fix: leave it out."),
        (("simulate", "rod", "--mu", "1"), "Fix: parameters are given with --set NAME=VALUE"),
        (("simulate", "rod", "--law", "hertz", "--law-set", "mu=1"), "belongs to the mechanism"),
        (("classify", "rod", "--state", "theta=30"), "theta=30deg is theta=0.523599"),
        (("map", "rod", "--over", "theta,mu", "--slip", "left"), "need -1 or 1"),
        (("critical", "rod", "--over", "E"), "NAME=FROM:TO, such as E=1e10:1e14"),
        (("sweep", "examples/mechanisms/rod.toml"), "this is a mechanism, need a sweep"),
    ],
)
def test_a_newcomers_mistake_is_named_with_its_remedy(capsys, words, message):
    assert message in rejected(capsys, *words)
