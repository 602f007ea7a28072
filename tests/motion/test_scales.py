"""Scales of the states of a contact are those of a static load, or of a contact at that energy."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from painleve_sym.automata.scales import Terms, compliant_scales, rigid_scales
from painleve_sym.codegen.evaluate import numbers

K, N, W, B = 3e5, 1.5, 0.8, 9.0


OWN = sp.symbols("kinetic_energy W_nn W_tt b_n b_t length", real=True)


def _values(scales, terms, kinetic, b_n):
    """Return the scales of a contact; their terms are evaluated one after the other."""
    values = dict(zip(OWN, (kinetic, W, 2.0, b_n, 4.0, 0.3), strict=True))
    for term in terms.all:
        values[term.symbol] = float(numbers([term.expression], values)[0])
    return numbers(scales, values).tolist()


def _compliant(kinetic, b_n, gap):
    terms = Terms()
    own = {s.name: s for s in OWN}
    scales = compliant_scales(own, *map(sp.Float, (gap, K, N)), terms)
    return _values(scales, terms, kinetic, b_n)


def _rigid(kinetic, b_n):
    terms = Terms()
    return _values(rigid_scales({s.name: s for s in OWN}, terms), terms, kinetic, b_n)


@pytest.mark.parametrize("gap", [0.02, -0.01])
def test_pressed_contact_has_the_scales_of_its_static_compression(gap):
    delta, rate, energy = _compliant(2.0, -B, gap)
    assert pytest.approx(B / W) == K * delta**N
    assert rate == pytest.approx(np.sqrt(delta * B))
    stored = K * max(0.0, -gap) ** (N + 1) / (N + 1)
    assert energy == pytest.approx(2.0 + stored + B / W * delta)


def test_contact_without_load_has_a_hundredth_of_what_its_energy_compresses():
    delta, rate, energy = _compliant(2.0, 0.0, 0.0)
    assert pytest.approx(2.0) == K * (100 * delta) ** (N + 1) / (N + 1)
    assert rate == pytest.approx(0.01 * np.sqrt(2 * 2.0 * W))
    assert energy == 2.0


def test_rigid_contact_has_the_speed_of_its_energy():
    _, rate, energy = _rigid(2.0, -B)
    assert rate == pytest.approx(np.sqrt(2 * 2.0 * W))
    assert energy == 2.0


@pytest.mark.parametrize(("b_n", "force"), [(-B, B / W), (0.0, 4.0 / 2.0)])
def test_rigid_contact_at_rest_has_the_energy_that_its_load_would_give(b_n, force):
    length, rate, energy = _rigid(0.0, b_n)
    assert length == 0.3
    assert energy == pytest.approx(force * length)
    assert rate == pytest.approx(np.sqrt(2 * energy * W))
