"""Plain data of results, and NPZ files: what is written is read, broken files are rejected."""

from __future__ import annotations

import json
from dataclasses import dataclass
from enum import Enum

import numpy as np
import pytest

from painleve_sym.arrays import load_npz, save_npz
from painleve_sym.errors import InputError
from painleve_sym.files import plain_fields, to_plain


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
