"""The folder of the cache: private, or not used; what others may have written is never loaded."""

from __future__ import annotations

import json
import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from painleve_sym import cache as caching
from painleve_sym.cache import cache_folder, own_content, read_entry, write_entry
from painleve_sym.cli import main
from painleve_sym.codegen.compile import compiled_library, library_named, load
from painleve_sym.errors import PainleveWarning
from tests.codegen.cache_helpers import SOURCE, mode

KEY = "0" * 40


# ---- folders that cannot serve ----


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
        caching.temporary_folder.cache_clear()


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
    monkeypatch.setattr(os, "geteuid", lambda: place.stat().st_uid + 1)
    used_instead(place, monkeypatch)


def test_cache_follows_the_environment(tmp_path, monkeypatch):
    monkeypatch.delenv("PAINLEVE_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "painleve-sym"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache_folder() == tmp_path / "home" / ".cache" / "painleve-sym"


NO_HOME = """
import os, pwd, sys
def unknown(uid):
    raise KeyError(uid)
pwd.getpwuid = unknown
from painleve_sym.codegen.compile import compiled_library
path = compiled_library(sys.argv[1])
print(path.parent)
assert path.exists()
"""


def test_no_home_and_no_passwd_entry_give_a_temporary_one(tmp_path):
    unset = ("HOME", "PAINLEVE_CACHE", "XDG_CACHE_HOME")
    environment = {k: v for k, v in os.environ.items() if k not in unset}
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
    done = subprocess.run(
        [sys.executable, "-c", NO_HOME, SOURCE % 4],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "there is no home folder" in done.stderr
    # Nothing is left, neither here nor where it was.
    assert list(tmp_path.iterdir()) == []
    assert done.stdout.strip() and not Path(done.stdout.strip()).exists()


def test_temporary_one_outlives_a_process_that_was_forked_off(tmp_path, monkeypatch):
    (tmp_path / "taken").write_text("a file")
    monkeypatch.setenv("PAINLEVE_CACHE", str(tmp_path / "taken"))
    with pytest.warns(PainleveWarning):
        folder = cache_folder()
    caching._remove_at_exit(folder, os.getpid() + 1)
    assert folder.exists()
    caching._remove_at_exit(folder, os.getpid())
    assert not folder.exists()
    caching.temporary_folder.cache_clear()


def test_full_disk_gives_a_temporary_one(cache, monkeypatch):
    from painleve_sym.codegen import compile as compiling

    real = compiling._build

    def build(source, compiler, folder, key):
        if folder == cache:
            raise OSError(28, "No space left on device")
        return real(source, compiler, folder, key)

    monkeypatch.setattr(compiling, "_build", build)
    with pytest.warns(PainleveWarning, match="No space left on device; compiled code is kept in a"):
        path = compiled_library(SOURCE % 5)
    try:
        assert path.parent != cache and path.exists()
    finally:
        shutil.rmtree(path.parent)
        caching.temporary_folder.cache_clear()


def test_compiler_that_finds_the_disk_full_gives_a_temporary_one(cache, tmp_path, monkeypatch):
    """The compiler fails in its own words; that the disk is full is seen by writing to it."""
    monkeypatch.setattr(
        "painleve_sym.codegen.compile.full",
        lambda folder: "No space left on device" if folder == cache else None,
    )
    script = tmp_path / "cc"
    script.write_text(
        f'#!/bin/sh\ncase "$*" in *{cache}*) echo "write error" >&2; exit 1;; esac\nexec cc "$@"\n'
    )
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    with pytest.warns(PainleveWarning, match="No space left on device"):
        path = compiled_library(SOURCE % 6)
    shutil.rmtree(path.parent)
    caching.temporary_folder.cache_clear()


# ---- what others may have written ----


@pytest.mark.parametrize("bits", [0o777, 0o775, 0o707])
def test_what_lay_in_a_folder_open_to_others_is_removed(cache, bits):
    path = compiled_library(SOURCE % 7)
    write_entry(KEY, {"a": 1})
    inode = path.stat().st_ino
    keeper = path.open("rb")  # so that the new file cannot get the same inode
    cache.chmod(bits)
    with pytest.warns(PainleveWarning, match="other users could write to it.*2 files or folders"):
        again = compiled_library(SOURCE % 7)
    assert again.stat().st_ino != inode and mode(cache) == 0o700
    keeper.close()
    assert read_entry(KEY) is None


def test_folder_that_others_can_only_read_keeps_what_it_holds(cache):
    path = compiled_library(SOURCE % 7)
    cache.chmod(0o755)
    inode = path.stat().st_ino
    assert compiled_library(SOURCE % 7).stat().st_ino == inode
    assert mode(cache) == 0o700


def test_folder_with_other_files_is_not_touched(cache, monkeypatch):
    cache.mkdir()
    (cache / "thesis.tex").write_text("mine")
    cache.chmod(0o777)
    used_instead(cache, monkeypatch)
    assert mode(cache) == 0o777 and [p.name for p in cache.iterdir()] == ["thesis.tex"]
    # Where others can only read it serves, and stays readable.
    cache.chmod(0o755)
    assert compiled_library(SOURCE % 7).parent == cache
    assert mode(cache) == 0o755


@pytest.mark.parametrize("held", [(), ("tmpabcd1234",)])
def test_folder_that_users_share_is_neither_closed_nor_emptied(cache, monkeypatch, held):
    cache.mkdir()
    for name in held:
        (cache / name).mkdir()
    cache.chmod(0o1777)
    used_instead(cache, monkeypatch)
    assert mode(cache) == 0o1777 and [p.name for p in cache.iterdir()] == [*held]
    # Where only the user can write it serves, as it is.
    cache.chmod(0o1755)
    assert compiled_library(SOURCE % 7).parent == cache
    assert mode(cache) == 0o1755


@pytest.mark.parametrize("bits", [0o720, 0o702, 0o777])
def test_file_that_others_can_write_is_not_loaded(cache, bits):
    path = compiled_library(SOURCE % 7)
    path.chmod(bits)
    assert library_named(path.name) is None
    assert mode(compiled_library(SOURCE % 7)) == 0o700
    write_entry(KEY, {"a": 1})
    assert read_entry(KEY) == {"a": 1}
    (cache / f"painleve-{KEY}.json").chmod(0o666)
    assert read_entry(KEY) is None


def test_entries_are_private_whatever_the_umask(cache):
    before = os.umask(0)
    try:
        write_entry(KEY, {"a": 1})
        path = compiled_library(SOURCE % 7)
    finally:
        os.umask(before)
    assert read_entry(KEY) == {"a": 1}
    assert library_named(path.name) == path


def test_file_of_another_user_is_not_loaded(cache, monkeypatch):
    path = compiled_library(SOURCE % 7)
    content = path.read_bytes()
    assert own_content(path) == content
    real = os.fstat

    def of_another(handle):
        info = list(real(handle))
        info[stat.ST_UID] += 1
        return os.stat_result(info)

    with monkeypatch.context() as m:
        m.setattr(os, "fstat", of_another)
        assert own_content(path) is None
        assert library_named(path.name) is None
    assert library_named(path.name) == path


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a file away")
def test_file_given_away_is_not_loaded(cache):
    path = compiled_library(SOURCE % 7)
    os.chown(path, 12345, -1)
    assert library_named(path.name) is None
    assert compiled_library(SOURCE % 7).stat().st_uid == 0
    assert load(SOURCE % 7).answer() == 7


def test_links_pipes_and_folders_are_not_loaded(cache, tmp_path):
    path = compiled_library(SOURCE % 7)
    path.rename(tmp_path / "elsewhere.so")
    path.symlink_to(tmp_path / "elsewhere.so")
    assert own_content(path) is None
    assert not compiled_library(SOURCE % 7).is_symlink()
    os.mkfifo(cache / "pipe")
    assert own_content(cache / "pipe") is None
    assert own_content(cache) is None


# ---- the command ----


def cached(capsys, *arguments):
    assert main(["cache", "--json", *arguments]) == 0
    return json.loads(capsys.readouterr().out)


def test_command_cache_shows_and_clears(cache, capsys):
    empty = {"folder": str(cache), "libraries": 0, "derivations": 0, "bytes": 0, "cleared": False}
    assert cached(capsys) == empty
    assert not cache.exists()
    path = compiled_library(SOURCE % 7)
    write_entry(KEY, {"a": 1})
    (cache / "thesis.tex").write_text("mine")
    size = path.stat().st_size + (cache / f"painleve-{KEY}.json").stat().st_size
    full = empty | {"libraries": 1, "derivations": 1, "bytes": size}
    assert cached(capsys) == full
    assert main(["cache"]) == 0
    text = capsys.readouterr().out
    assert str(cache) in text and "1 library, 1 derivation" in text and "--clear" in text
    assert cached(capsys, "--clear") == full | {"cleared": True}
    assert [p.name for p in cache.iterdir()] == ["thesis.tex"]
    assert main(["cache", "--clear"]) == 0
    assert "nothing to remove" in capsys.readouterr().out


OTHERS = ("tmpabcd1234/thesis.txt", f"{KEY}.json", f"{KEY}-{KEY}.so", "painleve-thesis/a.txt")


def test_command_cache_removes_nothing_that_only_looks_like_its_own(cache, capsys):
    path = compiled_library(SOURCE % 7)
    for name in OTHERS:
        (cache / name).parent.mkdir(exist_ok=True)
        (cache / name).write_text("work")
    assert cached(capsys)["bytes"] == path.stat().st_size
    assert main(["cache", "--clear"]) == 0
    assert not path.exists()
    assert [(cache / name).read_text() for name in OTHERS] == ["work"] * len(OTHERS)


def test_command_cache_leaves_the_folder_of_another_user(cache, capsys, monkeypatch):
    path = compiled_library(SOURCE % 7)
    monkeypatch.setattr(os, "geteuid", lambda: path.stat().st_uid + 1)
    assert main(["cache", "--clear"]) == 1
    assert "it belongs to another user" in capsys.readouterr().err
    assert path.exists()


def test_command_cache_counts_what_killed_processes_and_compilers_left(cache, capsys):
    (cache / "painleve-work-abcdef12").mkdir(parents=True)
    (cache / "painleve-work-abcdef12" / "model.c").write_text("12345")
    (cache / caching.ZIG_FOLDER / "o").mkdir(parents=True)
    (cache / caching.ZIG_FOLDER / "o" / "libc.so").write_text("123")
    assert cached(capsys)["bytes"] == 8
    assert cached(capsys, "--clear")["bytes"] == 8
    assert list(cache.iterdir()) == []
