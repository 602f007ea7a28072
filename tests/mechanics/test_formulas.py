"""Formulas of a user's mechanism are as short as the named ones', long ones share named parts."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import sympy as sp

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.laws.formulas import closed_forms
from painleve_sym.mechanics.formulas.formula import named_parts
from painleve_sym.mechanics.formulas.whole_mechanism import motion_sections
from painleve_sym.mechanics.paradox.critical_friction import least_over_directions
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from tests.cli.cli_helpers import run

EXAMPLES = Path(__file__).parents[2] / "examples" / "mechanisms"
OWN = ("m*l**2/3", "x_A + l*cos(theta)")
"""Inertia and centre of the rod as its file writes them."""
ONE = "(sin(theta)**2 + cos(theta)**2)"


def _written(mechanism):
    forms = (f for s in closed_forms(mechanism) for f in s.formulas)
    return {form.name: str(form.value) for form in forms}


@pytest.mark.parametrize(
    "other", [OWN, (f"m*l**2*{ONE}/3", OWN[1]), (OWN[0], "x_A + 2*l*cos(theta)/2*(1 + m/m)/2")]
)
def test_a_copy_of_the_rod_has_the_formulas_of_the_rod(other):
    text = (EXAMPLES / "rod.toml").read_text("utf-8")
    for own, new in zip(OWN, other, strict=True):
        assert own in text
        text = text.replace(own, new)
    copy, named = _written(mechanism_from_text(text, "copy.toml")), _written(model("rod"))
    shown = named.keys() - {"T", "V"}  # the energies stay as they were given
    assert {name: copy[name] for name in shown} == {name: named[name] for name in shown}


def test_no_sine_and_cosine_squared_add_up_under_a_root():
    """In a bowl the least friction of all directions had 7000 characters."""
    c = model(EXAMPLES / "rod-in-bowl.toml").coefficients
    value = least_over_directions(c)
    values = {"theta": 1.1, "kappa": 0.4, "x": 0.5, "y": 0.05, "m": 1.3, "l": 0.5}
    numbers = {s: values[str(s)] for s in value.free_symbols | c.W_nt.free_symbols}
    W = sp.Matrix([[c.W_nn, c.W_nt], [c.W_nt, c.W_tt]]).subs(numbers)
    low, high = sorted(map(float, W.eigenvals(multiple=True)))
    expected = 2 * (low * high) ** 0.5 / (high - low)
    assert float(value.subs(numbers)) == pytest.approx(expected, rel=1e-9)
    assert len(str(value)) < 1000
    # det W = A' W_tt: nine terms are left of 225
    assert len(str(c.A_stick)) < 250
    assert float(c.A_stick.subs(numbers)) == pytest.approx(float(W.det() / W[1, 1]), rel=1e-9)


@pytest.mark.parametrize(
    "name",
    [
        *("rod", "belt-oscillator.toml", "rod-in-bowl.toml"),
        pytest.param("pr-robot", marks=pytest.mark.slow),
    ],
)
def test_named_parts_stand_for_what_they_replace(name):
    mechanism = model(EXAMPLES / name if name.endswith("toml") else name)
    values = [f.value for s in motion_sections(mechanism) for f in s.formulas]
    parts, written = named_parts(values)
    assert bool(parts) == (name != "rod")
    known = set()
    for symbol, part in parts.items():
        assert part.free_symbols & parts.keys() <= known
        known.add(symbol)
    for value, short in zip(values, written, strict=True):
        whole = sp.Matrix(short) if isinstance(value, sp.MatrixBase) else short
        for symbol, part in reversed(parts.items()):
            whole = whole.xreplace({symbol: part})
        assert whole == value
    assert set(parts) <= set().union(*(w.free_symbols for w in [*written, *parts.values()]))
    before, after = (sum(int(sp.count_ops(v)) for v in vs) for vs in (values, written))
    assert after + sum(int(sp.count_ops(p)) for p in parts.values()) <= before
    assert all(sp.count_ops(v) < 150 for v in written)


def test_names_of_parts_are_free():
    chi, x = sp.symbols("chi_2 x", real=True)
    long = sum((x + chi) ** k / (1 + (x + chi) ** 2 + sp.sin(x * chi)) for k in range(12))
    parts, _ = named_parts([long, long + 1])
    assert parts and all(str(symbol).startswith("xi_") for symbol in parts)


def test_parts_have_the_same_names_in_every_run():
    code = (
        "from painleve_sym.laws.formulas import closed_forms\n"
        "from painleve_sym.codegen.named_mechanisms import model\n"
        "from painleve_sym.mechanics.formulas.formula import named_parts\n"
        "forms = closed_forms(model('two-link-arm'))\n"
        "print(named_parts([f.value for s in forms for f in s.formulas]))\n"
    )
    texts = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
        ).stdout
        for seed in ("0", "1", "2")
    }
    assert len(texts) == 1


def test_latex_begins_with_the_parts(capsys):
    path = EXAMPLES / "belt-oscillator.toml"
    code, out, err = run(capsys, "derive", str(path), "--format", "latex")
    assert (code, err) == (0, "")
    assert r"\[ \chi_{1} = \left(a + x\right)^{2} + \left(- h + y\right)^{2} \]" in out
    assert out.index(r"\chi_{1} =") < out.index("% energies")
    assert max(map(len, out.splitlines())) < 500
