"""The machine: what other systems lack has an alternative. Their absence is simulated."""

from __future__ import annotations

import builtins
import os
import subprocess
from pathlib import Path

import pytest

from painleve_sym.codegen import compile as compiling
from painleve_sym.errors import InputError
from painleve_sym.motion.batch.machine import available_memory, check_memory, processor_count

REAL = os.sysconf


@pytest.fixture
def no_proc(monkeypatch):
    """There is no /proc."""
    real_open, real_read = builtins.open, Path.read_text

    def refuse(path):
        if str(path).startswith("/proc"):
            raise FileNotFoundError(2, "No such file or directory", str(path))

    def opened(path, *arguments, **options):
        refuse(path)
        return real_open(path, *arguments, **options)

    def read(path, *arguments, **options):
        refuse(path)
        return real_read(path, *arguments, **options)

    monkeypatch.setattr(builtins, "open", opened)
    monkeypatch.setattr(Path, "read_text", read)


def without(*names):
    def sysconf(name):
        if name in names:
            raise ValueError("unrecognized configuration name")
        return REAL(name)

    return sysconf


def test_memory_without_proc_is_what_the_system_tells(no_proc, monkeypatch):
    whole = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    assert 0 < available_memory() <= whole
    # macOS knows only how much there is.
    monkeypatch.setattr(os, "sysconf", without("SC_AVPHYS_PAGES"))
    assert available_memory() == whole


def test_memory_that_is_unknown_refuses_nothing(no_proc, monkeypatch):
    check_memory("batch", "10 rows", 1, "fewer rows")
    with pytest.raises(InputError, match="10 rows need 1e\\+09 GB of memory"):
        check_memory("batch", "10 rows", 10**18, "fewer rows")
    monkeypatch.setattr(os, "sysconf", without("SC_AVPHYS_PAGES", "SC_PHYS_PAGES"))
    assert available_memory() is None
    check_memory("batch", "10 rows", 10**18, "fewer rows")


def test_processors_without_affinity_are_all_there_are(monkeypatch):
    assert 1 <= processor_count() <= (os.cpu_count() or 1)
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    assert processor_count() == os.cpu_count()
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert processor_count() == 1


def test_processor_without_proc_is_asked_of_the_system(no_proc, monkeypatch, tmp_path):
    name = compiling._processor.__wrapped__
    monkeypatch.setenv("PATH", str(tmp_path))
    assert isinstance(name(), str)
    tool = tmp_path / "sysctl"
    tool.write_text('#!/bin/sh\n[ "$*" = "-n machdep.cpu.brand_string" ] && echo "Apple M4"\n')
    tool.chmod(0o755)
    assert name() == "Apple M4"


APPLE = """
import sys, platform
sys.platform = "darwin"
platform.machine = lambda: "arm64"
from painleve_sym.codegen.compile import FLAGS
print(*FLAGS)
"""


def test_flags_on_apples_own_processors_name_them_otherwise():
    import sys

    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    flags = subprocess.run(
        [sys.executable, "-c", APPLE], env=environment, capture_output=True, text=True, check=True
    ).stdout.split()
    assert "-mcpu=native" in flags and "-march=native" not in flags
    assert "-ffp-contract=off" in flags


def test_what_only_linux_has_is_used_where_there_is_an_alternative():
    root = Path(compiling.__file__).parents[1]
    places = {
        "sched_getaffinity": {"motion/batch/machine.py"},
        '"/proc': {"motion/batch/machine.py", "codegen/compile.py"},
        "SC_AVPHYS_PAGES": {"motion/batch/machine.py"},
    }
    texts = {str(p.relative_to(root)): p.read_text("utf-8") for p in root.rglob("*.py")}
    for call, wanted in places.items():
        assert {name for name, text in texts.items() if call in text} == wanted
