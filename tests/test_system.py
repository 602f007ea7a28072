"""Differences of operating systems, simulated: no machine of theirs has run the package."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import platformdirs
import pytest

from painleve_sym import system
from painleve_sym.cache import cache_folder, named_folder, own_content
from painleve_sym.codegen import compile as compiling


@pytest.fixture
def windows(monkeypatch):
    """Calls that Windows lacks are gone; files have no owner, and their mode means nothing."""
    monkeypatch.setattr(system, "PLATFORM", "win32")
    for name in ("O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "geteuid", "getuid", "sysconf"):
        monkeypatch.delattr(os, name, raising=False)


def test_folder_of_the_cache_is_that_of_the_system(monkeypatch, tmp_path):
    monkeypatch.delenv("PAINLEVE_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    linux = named_folder()
    assert linux == tmp_path / "painleve-sym" == platformdirs.user_cache_path("painleve-sym")
    for other in ("darwin", "win32"):
        monkeypatch.setattr(system, "PLATFORM", other)
        monkeypatch.setattr(platformdirs, "user_cache_path", lambda: Path("/caches of the user"))
        assert named_folder() == Path("/caches of the user/painleve-sym")


def test_windows_takes_folders_and_files_as_the_user_s_own(windows, monkeypatch, tmp_path):
    folder = tmp_path / "cache"
    folder.mkdir(mode=0o777)
    monkeypatch.setenv("PAINLEVE_CACHE", str(folder))
    assert cache_folder() == folder
    (folder / "entry").write_bytes(b"1\r\n2")
    assert own_content(folder / "entry") == b"1\r\n2"


def test_windows_opens_no_link(windows, tmp_path):
    (tmp_path / "file").write_bytes(b"1")
    (tmp_path / "link").symlink_to(tmp_path / "file")
    assert own_content(tmp_path / "link") is None
    with pytest.raises(OSError, match="link"):
        open(tmp_path / "link", "wb", opener=system.open_no_link)  # noqa: SIM115
    assert (tmp_path / "file").read_bytes() == b"1"


def test_windows_compiles_libraries_of_its_own_kind(windows, monkeypatch, tmp_path):
    """The compiler is asked for a file that ends in .dll; here it makes one of this system."""
    monkeypatch.setenv("PAINLEVE_CACHE", str(tmp_path))
    source = '__attribute__((visibility("default"))) double answer(void) { return 7; }\n'
    built = compiling.compiled_library(source)
    assert built.suffix == ".dll" and compiling.library_named(built.name) == built
    assert compiling.compiled_library(source) == built


def test_flags_of_windows_have_no_position_independence():
    code = (
        "from painleve_sym import system; system.PLATFORM = 'win32'; "
        "from painleve_sym.codegen.compile import FLAGS; print('-fPIC' in FLAGS, len(FLAGS))"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.split() == ["False", str(len(compiling.FLAGS) - 1)]
