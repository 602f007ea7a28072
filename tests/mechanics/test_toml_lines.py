"""Lines of TOML entries, against what `tomllib` finds in the same text."""

from __future__ import annotations

import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.mechanics.toml.lines import toml_lines

TEXT = '''# a comment with [brackets] and "quotes"
name = "a" # = [
[parameters]
m = { default = 1.0, unit = "kg", deep.er = [1, 2] }
"q r".s = 3
[definitions]
c = """
x +
 y \\" """
d = \'\'\'a
b\'\'\'
e = """a""\\""" """""
[[contacts]]
point = ["x",   # ] no end
   "y",
   ]
[contacts.sub]
k=1
[[contacts]]
point = ["a", ["b", { c = 1 }]]
[[contacts.deep]]
z = 1979-05-27 07:32:00
[start]
th.eta = -1
last = true'''


def _paths(value, path=()):
    """Return every path of nested data."""
    if isinstance(value, dict):
        entries = value.items()
    elif isinstance(value, list):
        entries = enumerate(value)
    else:
        return
    for key, inner in entries:
        yield (*path, key)
        yield from _paths(inner, (*path, key))


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("name",), 2),
        (("parameters",), 3),
        (("parameters", "m", "unit"), 4),
        (("parameters", "m", "deep", "er", 1), 4),
        (("parameters", "q r", "s"), 5),
        (("contacts", 0), 13),
        (("contacts", 0, "point", 1), 15),
        (("contacts", 0, "sub", "k"), 18),
        (("contacts", 1), 19),
        (("contacts", 1, "point", 1, 1, "c"), 20),
        (("contacts", 1, "deep", 0, "z"), 22),
        (("start", "th", "eta"), 24),
        (("start", "last"), 25),
        (("start", "absent"), 23),
        (("nowhere",), 1),
    ],
)
def test_toml_lines_find_the_line_of_an_entry(path, line):
    assert toml_lines(TEXT).of(path) == line


def test_toml_lines_know_every_entry_tomllib_finds():
    known = toml_lines(TEXT).keys
    assert set(_paths(tomllib.loads(TEXT))) == set(known)


def test_toml_lines_of_text_skip_the_line_end_after_opening_quotes():
    lines = toml_lines(TEXT)
    assert lines.of_text(("definitions", "c"), 1) == 9
    assert lines.of_text(("definitions", "d"), 1) == 11
    assert lines.of_text(("name",)) == 2
    assert lines.of_text(("absent",), 3) == 1


def test_toml_lines_count_windows_line_ends_once():
    assert toml_lines("a = 1\r\nb = 2\r\n").of(("b",)) == 2


KEYS = st.sampled_from(["a", "b-c", "1", '"x y"', "'#'"])
PLAIN = st.sampled_from(["1", "-1.5e3", "true", '"]"', "'}'", '"a\\"b"', '"""x\n"y"""', "'''\n'''"])
VALUES = st.recursive(
    PLAIN,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda vs: "[" + ", ".join(vs) + "]"),
        st.lists(inner, max_size=3).map(lambda vs: "[ # c ]\n" + ",\n".join(vs) + "\n]"),
        st.lists(inner, max_size=2).map(
            lambda vs: "{" + ", ".join(f"k{i} = {v}" for i, v in enumerate(vs)) + "}"
        ),
    ),
    max_leaves=6,
)
LINES = st.one_of(
    st.tuples(KEYS, VALUES).map(lambda t: f"{t[0]} = {t[1]}"),
    KEYS.map(lambda k: f"[{k}]"),
    st.tuples(KEYS, KEYS).map(lambda t: f"[ {t[0]} . {t[1]} ] # c"),
    KEYS.map(lambda k: f"[[{k}]]"),
    st.just("# x = [1"),
    st.just("   "),
)


@settings(max_examples=300)
@given(st.lists(LINES, max_size=8))
def test_toml_lines_know_every_entry_of_any_text(lines):
    text = "\n".join(lines)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return
    entries = toml_lines(text)
    assert set(_paths(data)) == set(entries.keys)
    assert all(1 <= line <= text.count("\n") + 1 for line in entries.keys.values())
