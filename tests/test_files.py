"""Plain data of results, and NPZ files: what is written is read, broken files are rejected."""

from __future__ import annotations

import json
import os
import stat
import zipfile
from dataclasses import dataclass
from enum import Enum

import numpy as np
import pytest

from painleve_sym import arrays
from painleve_sym.arrays import load_npz, save_npz
from painleve_sym.errors import InputError
from painleve_sym.files import write_beside
from painleve_sym.plain_data import plain_fields, to_plain
from painleve_sym.system import open_no_link


class _Colour(Enum):
    RED = "red"


@dataclass(frozen=True)
class _Inner:
    pair: tuple[int, float]
    colour: _Colour


class _Own:
    def to_dict(self):
        return {"own": 1}


@dataclass(frozen=True)
class _Outer:
    inner: _Inner
    grid: np.ndarray
    by_colour: dict
    none: None = None


def test_nested_results_become_data_that_json_can_write():
    outer = _Outer(_Inner((1, 0.5), _Colour.RED), np.eye(2), {_Colour.RED: _Own()})
    plain = to_plain(outer)
    assert plain == {
        "inner": {"pair": [1, 0.5], "colour": "red"},
        "grid": [[1.0, 0.0], [0.0, 1.0]],
        "by_colour": {"red": {"own": 1}},
        "none": None,
    }
    assert json.loads(json.dumps(plain)) == plain
    assert list(plain_fields(outer, "none", "inner")) == ["none", "inner"]


def test_npz_file_gives_back_texts_and_arrays(tmp_path):
    path = tmp_path / "a.npz"
    save_npz(path, "test 1", {"name": "x"}, {"a": np.arange(3.0), "b": None})
    texts, arrays = load_npz(path, "test 1", "test", ["name"], ["a"], ["b"])
    assert texts["name"] == "x"
    np.testing.assert_array_equal(arrays["a"], [0.0, 1.0, 2.0])
    assert arrays["b"] is None


@pytest.mark.parametrize(
    ("form", "texts", "arrays", "part"),
    [
        ("test 2", [], [], "got format 'test 1', need 'test 2'"),
        ("test 1", ["title"], [], "title"),
        ("test 1", [], ["c"], "'c'"),
    ],
)
def test_npz_file_of_another_format_or_incomplete_is_refused(tmp_path, form, texts, arrays, part):
    path = tmp_path / "a.npz"
    save_npz(path, "test 1", {"name": "x"}, {"a": np.arange(3.0)})
    with pytest.raises(InputError, match=r"test file .* not readable") as error:
        load_npz(path, form, "test", texts, arrays)
    assert part in str(error.value)


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x05\x06" + bytes(18)])
def test_file_that_is_not_npz_is_refused(tmp_path, content):
    path = tmp_path / "a.npz"
    path.write_bytes(content)
    with pytest.raises(InputError, match="Fix: give a file written by save"):
        load_npz(path, "test 1", "test", [], [])


def test_npz_file_of_zeros_is_refused_before_they_are_read(tmp_path, monkeypatch):
    path = tmp_path / "a.npz"
    monkeypatch.setattr(arrays, "_SMALL", arrays._SMALL // 8)
    save_npz(path, "test 1", {}, {"a": np.zeros(2**19)})
    zeros = zipfile.ZipFile(path).read("a.npy")
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        for name in ("b", "c", "d", "e", "f", "g", "h", "i"):
            archive.writestr(f"{name}.npy", zeros)
    with pytest.raises(InputError, match=r"0\.0378 GB of arrays that compress like zeros"):
        load_npz(path, "test 1", "test", [], [])


def test_npz_file_whose_header_names_more_than_it_holds_is_refused(tmp_path):
    path = tmp_path / "a.npz"
    save_npz(path, "test 1", {}, {"a": np.zeros(3)})
    content = zipfile.ZipFile(path).read("a.npy").replace(b"(3,), }    ", b"(3000000,),}")
    assert b"3000000" in content
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.npy", content)
    with pytest.raises(InputError, match=r"array a\.npy is cut short"):
        load_npz(path, "test 1", "test", [], [])


def test_npz_file_of_objects_is_refused_without_advice_to_load_it_unsafely(tmp_path):
    np.savez(tmp_path / "a.npz", text=np.array([{}], object))
    (tmp_path / "b.npz").write_bytes(b"\x89PNG\r\n")
    for name in ("a.npz", "b.npz"):
        with pytest.raises(InputError) as error:
            load_npz(tmp_path / name, "test 1", "test", [], [])
        assert "allow_pickle=True" not in str(error.value) and "unsafely" not in str(error.value)


@pytest.mark.parametrize(("umask", "mode"), [(0o077, 0o600), (0o022, 0o644), (0o007, 0o660)])
def test_file_has_the_permissions_that_the_umask_leaves(tmp_path, umask, mode):
    before = os.umask(umask)
    try:
        write_beside(tmp_path / "new", lambda file: file.write(b"1"))
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == mode


def test_file_that_is_written_again_keeps_its_permissions(tmp_path):
    path = tmp_path / "private"
    path.write_bytes(b"1")
    path.chmod(0o600)
    write_beside(path, lambda file: file.write(b"2"))
    assert path.read_bytes() == b"2" and stat.S_IMODE(path.stat().st_mode) == 0o600
    with pytest.raises(ZeroDivisionError):
        write_beside(path, lambda file: file.write(b"3") / 0)
    assert path.read_bytes() == b"2" and list(tmp_path.iterdir()) == [path]


def test_link_is_not_opened(tmp_path):
    (tmp_path / "victim").write_text("1")
    (tmp_path / "link").symlink_to("victim")
    for mode in ("r", "w", "a"):
        with pytest.raises(OSError, match="symbolic links"):
            open(tmp_path / "link", mode, opener=open_no_link)  # noqa: SIM115
    assert (tmp_path / "victim").read_text() == "1"
