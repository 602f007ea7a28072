"""Places of rows: each row belongs to one contact and one axis, in Python as in C."""

import ctypes
import re

import pytest

from painleve_sym.codegen.compile import load
from painleve_sym.contact_rows import ContactRows
from painleve_sym.engines.c_texts import engine_texts


@pytest.mark.parametrize("n_contacts", [1, 3])
@pytest.mark.parametrize("n_tangents", [1, 2])
def test_rows_belong_to_one_contact_and_one_axis(n_contacts, n_tangents):
    rows = ContactRows(n_contacts, n_tangents)
    every, contacts = list(range(rows.size)), range(n_contacts)
    assert [r for i in contacts for r in (rows.normal(i), *rows.tangents(i))] == every
    assert [r for own in rows.each() for r in own] == rows.of_contacts(contacts) == every
    assert [r for i in contacts for r in every[rows.of(i)]] == every
    assert sorted(r for axis in range(1 + n_tangents) for r in every[rows.along(axis)]) == every
    assert every[rows.normals] == [rows.normal(i) for i in contacts]
    assert every[rows.tangentials] == [rows.tangent(i) for i in contacts]
    assert [rows.contact(r) for r in every] == sorted([*contacts] * (1 + n_tangents))
    assert [r for r in every if rows.is_normal(r)] == every[rows.normals]
    assert rows.block(0, n_contacts - 1) == (rows.of(0), rows.of(n_contacts - 1))


def test_macros_of_c_place_rows_as_python_does():
    (macros,) = engine_texts("loop/rows")
    names = ("N(i)", "T(i, 0)", "SIZE(i)", "CONTACT_OF(i)", "AXIS_OF(i)")
    functions = [f"int f{k}(int i) {{ return PS_{name}; }}" for k, name in enumerate(names)]
    seen = [f'__attribute__((visibility("default"))) {function}' for function in functions]
    loaded = load("\n".join([macros, *seen]))
    rows = ContactRows(4, int(re.search(r"PS_TANGENTS (\d+)", macros)[1]))

    def in_c(k, last):
        function = getattr(loaded, f"f{k}")
        function.restype = ctypes.c_int
        return [function(i) for i in range(last)]

    assert in_c(0, 4) == [rows.normal(i) for i in range(4)]
    assert in_c(1, 4) == [rows.tangent(i) for i in range(4)]
    assert in_c(2, 5)[-1] == rows.size
    assert in_c(3, rows.size) == [rows.contact(r) for r in range(rows.size)]
    assert [axis == 0 for axis in in_c(4, rows.size)] == list(map(rows.is_normal, range(rows.size)))
