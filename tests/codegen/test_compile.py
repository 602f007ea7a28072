"""C to a loaded library: the cache may be shared, damaged or missing, the answer never wrong."""

from __future__ import annotations

import ctypes
import dataclasses
import importlib.util
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

from painleve_sym.cache import COMPILER_LOG, clear_cache
from painleve_sym.codegen import compile as compiling
from painleve_sym.codegen.compile import (
    compiled_library,
    find_compiler,
    library_key,
    load,
)
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import CompileError, CompilerMissing, InputError
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import Simulator
from tests.codegen.cache_helpers import SOURCE, mode

CC = shutil.which("cc") or "cc"


def has_ziglang():
    return importlib.util.find_spec("ziglang") is not None


def script(path, text):
    """Return the path of a program for the shell."""
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


def libraries(folder):
    return sorted(folder.glob("*.so"))


def test_library_is_compiled_and_loaded(cache):
    assert load(SOURCE % 42).answer() == 42


def test_cache_and_library_are_private(cache):
    path = compiled_library(SOURCE % 1)
    assert path.parent == cache
    assert mode(cache) == 0o700
    assert mode(path) & 0o077 == 0


def test_open_cache_folder_is_made_private(cache):
    cache.mkdir(mode=0o755)
    cache.chmod(0o755)
    compiled_library(SOURCE % 1)
    assert mode(cache) == 0o700


def test_nothing_but_the_library_is_left(cache):
    path = compiled_library(SOURCE % 1)
    assert list(cache.iterdir()) == [path]


def test_same_source_is_compiled_once(cache, monkeypatch):
    path = compiled_library(SOURCE % 1)
    monkeypatch.setattr(compiling, "_build", lambda *_: pytest.fail("compiled again"))
    assert compiled_library(SOURCE % 1) == path


def test_changed_source_has_another_key(cache):
    one, two = compiled_library(SOURCE % 1), compiled_library(SOURCE % 2)
    assert one != two
    assert one.name.split("-")[1] != two.name.split("-")[1]
    assert load(SOURCE % 1).answer() == 1
    assert load(SOURCE % 2).answer() == 2


def test_key_depends_on_source_compiler_flags_and_processor(monkeypatch):
    compiler = find_compiler()
    keys = [library_key(SOURCE, compiler), library_key(SOURCE + " ", compiler)]
    keys.append(library_key(SOURCE, dataclasses.replace(compiler, version="cc 99.9")))
    with monkeypatch.context() as m:
        m.setattr(compiling, "FLAGS", (*compiling.FLAGS, "-DOTHER"))
        keys.append(library_key(SOURCE, compiler))
    with monkeypatch.context() as m:
        m.setattr(compiling, "_processor", lambda: "flags: none")
        keys.append(library_key(SOURCE, compiler))
    for level in ("", "1"):
        with monkeypatch.context() as m:
            m.setenv("PAINLEVE_OPTIMIZE", level)
            keys.append(library_key(SOURCE, compiler))
    assert len(set(keys)) == len(keys)
    assert library_key(SOURCE, compiler) == keys[0]


@pytest.mark.slow
def test_levels_of_optimization_compute_the_same_bits(monkeypatch):
    """Of a motion with contact, slip and separation, and of its derivatives."""

    def numbers(level):
        monkeypatch.setenv("PAINLEVE_OPTIMIZE", level)
        rod = Simulator(model("rod"), law("bilinear-hertz"))
        state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
        run = rod.sensitivities(state, ("theta", "mu"), t_end=0.01)
        return run.trajectory.final_state.tobytes(), run.final_jacobian.tobytes()

    assert numbers("0") == numbers("")


def test_level_of_optimization_that_does_not_exist_is_refused(monkeypatch):
    monkeypatch.setenv("PAINLEVE_OPTIMIZE", "fast")
    with pytest.raises(InputError, match="PAINLEVE_OPTIMIZE: got 'fast', need 0, 1, 2 or 3"):
        compiled_library(SOURCE % 1)


@pytest.mark.parametrize("damage", [b"", b"\x7fELF", b"garbage" * 1000])
def test_damaged_library_is_rebuilt(cache, damage):
    path = compiled_library(SOURCE % 7)
    path.write_bytes(damage)
    again = compiled_library(SOURCE % 7)
    assert load(SOURCE % 7).answer() == 7
    assert libraries(cache) == [again]


def test_single_flipped_bit_is_noticed(cache):
    path = compiled_library(SOURCE % 7)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    assert compiled_library(SOURCE % 7).read_bytes() != bytes(content)


def test_foreign_library_under_the_right_key_is_rebuilt(cache):
    path, foreign = compiled_library(SOURCE % 7), compiled_library(SOURCE % 8)
    path.unlink()
    planted = cache / f"painleve-{library_key(SOURCE % 7, find_compiler())}-{'0' * 40}.so"
    shutil.copy(foreign, planted)
    assert load(SOURCE % 7).answer() == 7
    assert not planted.exists()


RACE = """
import sys, pathlib, time
from painleve_sym.codegen.compile import load
pathlib.Path(sys.argv[1]).touch()
while not pathlib.Path(sys.argv[2]).exists():
    time.sleep(0.001)
sys.exit(load(sys.argv[3]).answer() != 13)
"""


def test_two_processes_may_compile_at_once(cache, tmp_path):
    marks = [tmp_path / "a", tmp_path / "b"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    running = [
        subprocess.Popen(
            [sys.executable, "-c", RACE, str(mine), str(other), SOURCE % 13],
            env=environment,
            stderr=subprocess.PIPE,
        )
        for mine, other in (marks, marks[::-1])
    ]
    for process in running:
        _, errors = process.communicate(timeout=120)
        assert process.returncode == 0, errors.decode()
    compiled = libraries(cache)
    assert compiled
    assert list(cache.iterdir()) == compiled
    assert compiled_library(SOURCE % 13) in compiled


def test_products_are_rounded_before_they_are_added(cache):
    """Sums and differences in turn: what a compiler may turn into vfmaddsub."""
    lines = [
        f"y[{i}] = x[{3 * i}] * x[{3 * i + 1}] {'-+'[i % 2]} x[{3 * i + 2}];" for i in range(8)
    ]
    lines += [f"y[{8 + i}] = x[{i}] / x[10] * x[11] {'+-'[i % 2]} x[11];" for i in range(4)]
    shown = '__attribute__((visibility("default")))'
    head = f"{shown} void f(const double *restrict x, double *restrict y)"
    call = load(f"{head} {{ {' '.join(lines)} }}").f
    x, y = np.random.default_rng(5).normal(size=(200, 24)), np.empty((200, 12))
    for row, out in zip(x, y, strict=True):
        call(ctypes.c_void_p(row.ctypes.data), ctypes.c_void_p(out.ctypes.data))
    signs = np.array([-1.0, 1.0] * 4)
    np.testing.assert_array_equal(y[:, :8], x[:, ::3] * x[:, 1::3] + signs * x[:, 2::3])
    b, c = x[:, 10:11], x[:, 11:12]
    np.testing.assert_array_equal(y[:, 8:], x[:, :4] / b * c - signs[:4] * c)


def _only_log(cache):
    (log,) = cache.iterdir()
    assert log.name == COMPILER_LOG
    return log.read_text()


def test_compile_error_is_one_sentence_and_a_file_has_the_text_of_the_compiler(cache):
    with pytest.raises(CompileError, match=r"\(exit code \d+\).*Fix: ") as caught:
        compiled_library("int broken(void) { return undeclared_thing; }\n")
    assert "undeclared_thing" in caught.value.compiler_text
    assert "undeclared_thing" not in str(caught.value)
    assert "\n" not in str(caught.value)
    assert find_compiler().version in str(caught.value)
    assert "undeclared_thing" in _only_log(cache)
    assert str(cache / COMPILER_LOG) in str(caught.value)
    clear_cache()
    assert list(cache.iterdir()) == []


def test_compiler_missing_says_what_to_do(monkeypatch, cache):
    monkeypatch.setenv("CC", "/nonexistent/cc")
    with pytest.raises(CompilerMissing, match=r"/nonexistent/cc.*Fix: install gcc.*CC"):
        compiled_library(SOURCE % 1)
    assert not cache.exists()


def test_compiler_that_does_not_run_is_no_compiler(tmp_path, monkeypatch):
    broken = tmp_path / "broken-cc"
    broken.write_text("#!/bin/sh\nexit 3\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CC", str(broken))
    with pytest.raises(CompilerMissing, match="broken-cc"):
        find_compiler()


def test_compiler_is_the_one_named_by_cc(tmp_path, monkeypatch, cache):
    (real,) = find_compiler().command
    own = tmp_path / "own-cc"
    own.write_text(f'#!/bin/sh\necho "$@" >> {tmp_path}/calls\nexec {real} "$@"\n')
    own.chmod(0o755)
    monkeypatch.setenv("CC", str(own))
    assert load(SOURCE % 5).answer() == 5
    calls = (tmp_path / "calls").read_text()
    assert "-ffp-contract=off" in calls
    assert "fast-math" not in calls


PARTS = """
#ifdef PS_PART
#define PS_HAS(part) (PS_PART == part)
#else
#define PS_HAS(part) 1
#endif
int square(int);
#if PS_HAS(1)
__attribute__((visibility("hidden"))) int square(int x) { return x * x; }
#endif
#if PS_HAS(0)
__attribute__((visibility("default"))) int answer(void) { return square(%s); }
#endif
"""


@pytest.mark.parametrize(("level", "processors", "runs"), [("", 1, 3), ("", 2, 3), ("0", 2, 1)])
def test_parts_of_a_source_make_one_library(cache, monkeypatch, level, processors, runs):
    """One run of the compiler where nothing is optimized: it reads what they share once."""
    commands, run = [], compiling._run
    monkeypatch.setattr(compiling, "_run", lambda *words: commands.append(words) or run(*words))
    monkeypatch.setattr(os, "cpu_count", lambda: processors)
    monkeypatch.setenv("PAINLEVE_OPTIMIZE", level)
    assert load(PARTS % "6").answer() == 36
    assert len(commands) == runs
    assert len(list(cache.iterdir())) == 1


def test_fault_in_a_part_is_kept_in_the_compilers_own_words(cache, monkeypatch):
    monkeypatch.setenv("PAINLEVE_OPTIMIZE", "")
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    with pytest.raises(CompileError, match="does not compile"):
        compiled_library(PARTS % "undeclared_thing")
    assert "undeclared_thing" in _only_log(cache)


# ---- commands that are not a plain compiler ----


def test_arguments_of_cc_come_before_the_packages_own(tmp_path, monkeypatch, cache):
    plain = compiled_library(SOURCE % 5)
    own = script(tmp_path / "my cc", f'echo "$@" >> {tmp_path}/calls\nexec {CC} "$@"')
    monkeypatch.setenv("CC", f"'{own}' -O1 '-DTWO=1 + 1'")
    path = compiled_library("\n" + SOURCE % 5)
    assert load("\n" + SOURCE % 5).answer() == 5
    calls = (tmp_path / "calls").read_text().splitlines()
    assert calls[0] == "-O1 -DTWO=1 + 1 --version"
    assert all(call.startswith("-O1 -DTWO=1 + 1 -O3 -march=native") for call in calls[1:])
    assert find_compiler().command == (str(own), "-O1", "-DTWO=1 + 1")
    # Another argument makes another library.
    monkeypatch.setenv("CC", f"'{CC}' -O1")
    assert compiled_library(SOURCE % 5) != plain and path.exists()


def test_cc_may_be_a_path_with_spaces(tmp_path, monkeypatch, cache):
    monkeypatch.setenv("CC", str(script(tmp_path / "my cc", f'exec {CC} "$@"')))
    assert load(SOURCE % 5).answer() == 5


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("exit 0", "wrote no file"),
        ('case "$*" in *--version) exit 0;; esac; echo no headers >&2; exit 1', "exit code 1"),
        (
            "case \"$*\" in *--version) printf '\\377\\n';; *) printf '\\377' >&2; exit 7;; esac",
            "exit code 7",
        ),
    ],
)
def test_compiler_that_makes_nothing_is_told_by_name(tmp_path, monkeypatch, cache, text, fault):
    broken = script(tmp_path / "broken-cc", text)
    monkeypatch.setenv("CC", f"{broken} -O1")
    for call in (find_compiler, lambda: compiled_library(SOURCE % 1)):
        with pytest.raises(CompilerMissing, match=r"broken-cc -O1.*Fix: ") as caught:
            call()
        assert fault in str(caught.value)
        assert "no headers" not in str(caught.value)
    assert ("no headers" in text) == ("no headers" in _only_log(cache))


@pytest.mark.parametrize("named", ["gcc 'oops", "-", "/nonexistent/cc -O1", "/"])
def test_cc_that_names_no_command_is_told_by_name(monkeypatch, cache, named):
    monkeypatch.setenv("CC", named)
    with pytest.raises(CompilerMissing) as caught:
        find_compiler()
    assert repr(named) in str(caught.value)


def test_next_compiler_is_taken_where_the_first_makes_nothing(tmp_path, monkeypatch, cache):
    script(tmp_path / "cc", "exit 0")
    script(tmp_path / "gcc", f'PATH={os.environ["PATH"]}; exec {CC} "$@"')
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert load(SOURCE % 5).answer() == 5
    assert find_compiler().command == (str(tmp_path / "gcc"),)


def test_compiler_of_the_package_ziglang_is_the_last_resort(tmp_path, monkeypatch, cache):
    """A stand-in for the package: `python -m ziglang cc` runs the compiler of this machine."""
    package = tmp_path / "packages" / "ziglang"
    package.mkdir(parents=True)
    (package / "__init__.py").touch()
    (package / "zig").touch()
    (package / "__main__.py").write_text(
        "import os, sys\n"
        "assert sys.argv.pop(1) == 'cc'\n"
        f"os.environ['PATH'] = {os.environ['PATH']!r}\n"
        "assert all(os.environ.get(f'ZIG_{n}_CACHE_DIR') for n in ('LOCAL', 'GLOBAL'))"
        " or '--version' in sys.argv\n"
        f"os.execv({CC!r}, ['cc', *sys.argv[1:]])\n"
    )
    (tmp_path / "bin").mkdir()
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    assert has_ziglang() or compiling.compiler_mark() is None
    monkeypatch.syspath_prepend(str(package.parent))
    monkeypatch.setenv("PYTHONPATH", str(package.parent))
    assert find_compiler().command[:4] == (sys.executable, "-m", "ziglang", "cc")
    assert load(SOURCE % 5).answer() == 5
    # A library of one compiler is not taken for that of another.
    assert str(package / "zig") in (compiling.compiler_mark() or "")
    assert library_key(SOURCE, find_compiler()) != library_key(
        SOURCE, dataclasses.replace(find_compiler(), command=(CC,))
    )


@pytest.mark.slow
@pytest.mark.skipif(not has_ziglang(), reason="ziglang is not installed")
def test_ziglang_gives_the_numbers_of_gcc_to_the_last_bit(tmp_path, monkeypatch):
    arguments = ("simulate", "rod", "--state", "theta=1,theta_dot=1,x_A_dot=-1", "--json")
    arguments += ("--law", "bilinear-hertz", "--law-set", "E=20.9e14", "--t-end", "1e-3")
    outputs = []
    for name, path in (("gcc", os.environ["PATH"]), ("zig", str(tmp_path))):
        done = subprocess.run(
            [sys.executable, "-m", "painleve_sym", *arguments],
            env={
                **{k: v for k, v in os.environ.items() if k != "CC"},
                "PATH": path,
                "PAINLEVE_CACHE": str(tmp_path / name),
                "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
            },
            stdout=subprocess.PIPE,
            check=True,
        )
        outputs.append(done.stdout)
    assert b'"engine": "taylor"' in outputs[0]
    assert outputs[0] == outputs[1]
