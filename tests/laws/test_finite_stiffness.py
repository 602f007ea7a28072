"""Closed forms of a jump at finite stiffness against quadrature of the motion they solve."""

from __future__ import annotations

import mpmath as mp
import pytest

from painleve_sym.laws import finite_stiffness as fs

VALUES = {
    fs.A: -0.7,
    fs.B: -4.0,
    fs.A_STICK: 1.3,
    fs.B_STICK: -2.0,
    fs.C: 2.5,
    fs.B_T: 3.0,
    fs.K: 50.0,
    fs.N: 1.7,
    fs.E_S: 0.6,
}
A, B, K, N, C, B_T = (VALUES[s] for s in (fs.A, fs.B, fs.K, fs.N, fs.C, fs.B_T))


def _number(form, **more):
    return mp.mpf(str(form.subs(VALUES | {getattr(fs, k): v for k, v in more.items()}).evalf(20)))


def _slip(delta, weight=lambda d: 1.0):
    """Integrate over the time of slip from rest at δ = 0: δ̇²/2 = −A K δ^(n+1)/(n+1) − B δ."""

    def integrand(root):  # of δ = r², which takes the singularity at the start away
        d = root**2
        return weight(d) * 2 * root / mp.sqrt(2 * (-A * K * d ** (N + 1) / (N + 1) - B * d))

    return mp.quad(integrand, [0, mp.sqrt(delta) / 2, mp.sqrt(delta)])


# The ratio z of both terms is 0.001, 0.4, 50: the series converges for z < 1 only.
@pytest.mark.parametrize("delta", [0.01, 0.3, 5.0])
def test_time_and_impulse_of_slip_are_integrals_along_it(delta):
    time, impulse = _slip(delta), _slip(delta, lambda d: K * d**N)
    assert float(_number(fs.slip_time(), DELTA=delta)) == pytest.approx(float(time), rel=1e-12)
    assert float(_number(fs.slip_impulse(), DELTA=delta)) == pytest.approx(
        float(impulse), rel=1e-12
    )
    # The slip that stops there: v_t = −(C P + b_t t), and v_n = A P + B t.
    stopped = _number(fs.slip_stop_velocity(time), V_T=-(C * impulse + B_T * time))
    assert float(stopped) == pytest.approx(float(A * impulse + B * time), rel=1e-12)


def test_blow_up_is_the_time_to_any_compression():
    time = _number(fs.slip_time(), DELTA=1e40)
    assert float(_number(fs.blow_up_time())) == pytest.approx(float(time), rel=1e-10)


def test_leading_correction_is_the_change_of_the_rebound_by_the_time_of_slip():
    def rebound(time):
        return _number(fs.separation_velocity(fs.slip_stop_velocity(time), 0), V_T=-1.0)

    time = _number(fs.blow_up_time())
    change = (rebound(1e-6) - rebound(0)) / 1e-6 * time
    assert float(_number(fs.leading_correction())) == pytest.approx(float(change), rel=1e-9)


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_separating_rate_is_the_stable_direction(damping):
    b_n = 5.0
    rest, delta = -b_n / (A * K), 0.01
    # δ̈ = −A (K δ + c δ̇) − b_n: along the stable direction δ̇ = λ (δ − rest) with λ < 0.
    rate = float(_number(fs.separating_rate(), DELTA=delta, B_FREE=b_n, DAMPING=damping))
    decay = rate / (delta - rest)
    assert decay < 0
    assert decay**2 == pytest.approx(-A * (K + damping * decay), rel=1e-12)
