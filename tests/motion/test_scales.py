"""Scales of the states of a contact are those of a static load, or of a contact at that energy."""

from __future__ import annotations

import numpy as np
import pytest

from painleve_sym.motion.scales import compliant_scales, rigid_scales

K, N, W, B = 3e5, 1.5, 0.8, 9.0


def _numbers(kinetic, b_n):
    own = {"kinetic_energy": kinetic, "W_nn": W, "b_n": b_n, "W_tt": 2.0, "b_t": 4.0, "length": 0.3}
    return {name: np.array([value]) for name, value in own.items()}


def _compliant(kinetic, b_n, gap):
    arrays = (np.array([v]) for v in (gap, K, N))
    return [float(s[0]) for s in compliant_scales(_numbers(kinetic, b_n), *arrays)]


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
    _, rate, energy = rigid_scales(_numbers(2.0, -B))
    assert float(rate[0]) == pytest.approx(np.sqrt(2 * 2.0 * W))
    assert float(energy[0]) == 2.0


@pytest.mark.parametrize(("b_n", "force"), [(-B, B / W), (0.0, 4.0 / 2.0)])
def test_rigid_contact_at_rest_has_the_energy_that_its_load_would_give(b_n, force):
    length, rate, energy = (float(s[0]) for s in rigid_scales(_numbers(0.0, b_n)))
    assert length == 0.3
    assert energy == pytest.approx(force * length)
    assert rate == pytest.approx(np.sqrt(2 * energy * W))
