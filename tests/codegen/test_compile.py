"""C to a loaded library: the cache may be shared, damaged or missing, the answer never wrong."""

from __future__ import annotations

import ctypes
import dataclasses
import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from painleve_sym.codegen import compile as compiling
from painleve_sym.codegen.compile import (
    cache_folder,
    compiled_library,
    find_compiler,
    library_key,
    load,
)
from painleve_sym.errors import CompileError, CompilerMissing, PainleveWarning

SOURCE = '__attribute__((visibility("default"))) int answer(void) { return %d; }\n'


@pytest.fixture
def cache(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    monkeypatch.setenv("PAINLEVE_CACHE", str(folder))
    return folder


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


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
    assert one.name.partition("-")[0] != two.name.partition("-")[0]
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
    assert len(set(keys)) == len(keys)
    assert library_key(SOURCE, compiler) == keys[0]


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
    planted = cache / f"{library_key(SOURCE % 7, find_compiler())}-{'0' * 40}.so"
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


def used_instead(named, monkeypatch):
    monkeypatch.setenv("PAINLEVE_CACHE", str(named))
    with pytest.warns(PainleveWarning, match=r"temporary folder.*Fix: set PAINLEVE_CACHE"):
        folder = cache_folder()
    try:
        assert folder != named
        assert mode(folder) == 0o700
        # The second time it is the same folder, and there is no second notice.
        assert cache_folder() == folder
        assert compiled_library(SOURCE % 3).parent == folder
        assert load(SOURCE % 3).answer() == 3
    finally:
        shutil.rmtree(folder)
        compiling._temporary_cache.cache_clear()


def test_file_in_place_of_the_cache_gives_a_temporary_one(tmp_path, monkeypatch):
    place = tmp_path / "taken"
    place.write_text("a file")
    used_instead(place, monkeypatch)
    assert place.read_text() == "a file"


def test_folder_that_cannot_be_created_gives_a_temporary_one(tmp_path, monkeypatch):
    (tmp_path / "taken").write_text("a file")
    used_instead(tmp_path / "taken" / "below", monkeypatch)


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="there is no /proc")
def test_folder_of_a_read_only_file_system_gives_a_temporary_one(monkeypatch):
    used_instead(Path("/proc/painleve-sym"), monkeypatch)


@pytest.mark.skipif(os.geteuid() == 0, reason="for root no folder is read-only")
def test_read_only_folder_gives_a_temporary_one(tmp_path, monkeypatch):
    place = tmp_path / "closed"
    place.mkdir()
    place.chmod(0o500)
    used_instead(place, monkeypatch)


def test_folder_of_another_user_gives_a_temporary_one(tmp_path, monkeypatch):
    place = tmp_path / "theirs"
    monkeypatch.setattr(os, "getuid", lambda: place.stat().st_uid + 1)
    used_instead(place, monkeypatch)


def test_cache_follows_the_environment(tmp_path, monkeypatch):
    monkeypatch.delenv("PAINLEVE_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "painleve-sym"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache_folder() == tmp_path / "home" / ".cache" / "painleve-sym"


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


def test_compile_error_carries_the_words_of_the_compiler(cache):
    with pytest.raises(CompileError, match=r"failed with exit code \d+") as caught:
        compiled_library("int broken(void) { return undeclared_thing; }\n")
    assert "undeclared_thing" in str(caught.value)
    assert find_compiler().version in str(caught.value)
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
    real = find_compiler().path
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


@pytest.mark.parametrize("processors", [1, 2])
def test_parts_of_a_source_make_one_library(cache, monkeypatch, processors):
    monkeypatch.setattr(os, "cpu_count", lambda: processors)
    assert load(PARTS % "6").answer() == 36
    assert len(list(cache.iterdir())) == 1


def test_fault_in_a_part_is_shown_in_the_compilers_own_words(cache, monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    with pytest.raises(CompileError, match="undeclared_thing"):
        compiled_library(PARTS % "undeclared_thing")
    assert list(cache.iterdir()) == []
