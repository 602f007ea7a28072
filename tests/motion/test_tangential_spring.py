"""A tangential spring in series with friction: closed solutions, SciPy, limits and symmetries."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import painleve_sym as ps
from painleve_sym.c_export.export import export_c
from painleve_sym.errors import InputError
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.finite_stiffness import evaluate_corrected_jump
from painleve_sym.study.critical.bisection import Border, CriticalForceFinder
from tests.motion.comparisons import total_energy
from tests.scenes import point_mass, simulator

M, G, MU = 2.0, 9.8, 0.4
TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
LAWS = ("linear", "hertz", "bilinear-hertz")
K_T = "tangential_stiffness"


def rod(law="linear", friction="spring"):
    return simulator("rod", f"{law}/{friction}")


def kinds(run):
    return [e.kind.value for e in run.events]


# ---- a closed solution ----


def test_block_that_stops_swings_about_its_mean_with_the_force_of_slip():
    block = ps.Simulator(mechanism_from_text(point_mass()), ps.law("linear", friction="spring"))
    speed, k_t = 1.0, 1e6
    parameters = {K_T: k_t}
    run = block.run(
        {"x_dot": speed}, t_end=0.26, initial_force=M * G, parameters=parameters, rtol=1e-12
    )
    # A constant load stops the slip where v = 0, as without a spring; the spring is still loaded.
    stop = speed / (MU * G)
    assert run.events_of("slip_stop")[0].time == pytest.approx(stop, rel=1e-12)
    assert run.outputs([0.1])["tangential_deflection"] == pytest.approx(MU * M * G / k_t, rel=1e-9)
    times = np.linspace(stop, 0.26, 40)[1:]
    w, swing = math.sqrt(k_t / M), MU * M * G / k_t
    place = speed**2 / (2 * MU * G) - swing * (1 - np.cos(w * (times - stop)))
    assert run.values("x", times) == pytest.approx(place, rel=1e-9)
    velocity = -swing * w * np.sin(w * (times - stop))
    assert run.values("x_dot", times) == pytest.approx(velocity, rel=0, abs=1e-9)


# ---- SciPy, on equations written by hand ----


def force_law(name, k, c):
    """Return F_n and its derivatives by δ and δ̇ of a law, written by hand."""
    if name == "linear":
        return lambda d, v: (k * d + c * v, k, c)
    stiffness = 4 / 3 * 20.9e10 / (2 * (1 - 0.3**2)) * math.sqrt(0.00645)
    return lambda d, v: (stiffness * max(d, 0) ** 1.5, 1.5 * stiffness * max(d, 0) ** 0.5, 0.0)


class ByHand:
    """The slender rod (m = l = 1) on the law, in coordinates of its centre, phase by phase."""

    def __init__(self, law, mu, k_t):
        self.law, self.mu, self.k_t = law, mu, k_t

    def motion(self, z, normal, tangential):
        """Return accelerations of the centre and of the angle, and those of the lower end."""
        theta, spin = z[2], z[5]
        sin, cos = math.sin(theta), math.cos(theta)
        turn = 3 * (sin * tangential - cos * normal)
        ax, ay = tangential, normal - 9.8
        return (ax, ay, turn), (
            ax + sin * turn + cos * spin**2,
            ay - cos * turn + sin * spin**2,
        )

    def end(self, z):
        """Return gap, gap rate and slip velocity of the lower end."""
        theta, spin = z[2], z[5]
        return z[1] - math.sin(theta), z[4] - math.cos(theta) * spin, z[3] + math.sin(theta) * spin

    def numbers(self, z, mode):
        """Return accelerations, F_n, v_t and ξ̇ in a mode: 0 stick, ±1 slip, None flight."""
        gap, rate, slip = self.end(z)
        if mode is None:
            return self.motion(z, 0.0, 0.0)[0], 0.0, slip, 0.0
        normal, by_depth, by_rate = self.law(-gap, -rate)
        tangential = -self.k_t * z[6] if mode == 0 else -mode * self.mu * normal
        accelerations, (_, gap_acceleration) = self.motion(z, normal, tangential)
        change = -by_depth * rate - by_rate * gap_acceleration
        yields = slip if mode == 0 else mode * self.mu * change / self.k_t
        return accelerations, normal, slip, yields

    def rates(self, z, mode):
        accelerations, _, _, yields = self.numbers(z, mode)
        return [*z[3:6], *accelerations, yields]

    def guards(self, mode):
        elastic = (
            self.law(0.0, 1.0)[2] == 0
        )  # then F_n vanishes with the compression, if not sooner
        end = (lambda t, z: -self.end(z)[0]) if elastic else lambda t, z: self.numbers(z, mode)[1]
        guards = {"separation": end}
        if mode is None:
            guards = {"touchdown": lambda t, z: self.end(z)[0]}
        elif mode == 0:
            for s in (-1, 1):
                guards[s] = lambda t, z, s=s: self.mu * self.numbers(z, 0)[1] - s * self.k_t * z[6]
        else:

            def stops(t, z):
                _, _, slip, yields = self.numbers(z, mode)
                return mode * (slip - yields)

            guards["slip_stop"] = stops
        for guard in guards.values():
            guard.terminal, guard.direction = True, -1
        return guards

    def run(self, z, t_end):
        """Return kinds and times of the events up to the first separation, and the end."""
        events, t, mode = [], 0.0, None
        while True:
            guards = self.guards(mode)
            phase = solve_ivp(
                lambda _, y, mode=mode: self.rates(y, mode),
                (t, t_end),
                z,
                "DOP853",
                rtol=1e-12,
                atol=1e-15,
                events=list(guards.values()),
                first_step=min(1e-9, (t_end - t) / 2),
                max_step=2e-6,  # the dense output, in which events are sought, is less exact
            )
            t, z = float(phase.t[-1]), phase.y[:, -1].copy()
            fired = [name for name, times in zip(guards, phase.t_events, strict=True) if len(times)]
            if not fired:
                return events, z
            (name,) = fired[:1]
            events.append((name if isinstance(name, str) else "slip_start", t))
            if name == "separation":
                return events, z
            if name == "touchdown":
                mode = self.landing(z)
            elif name == "slip_stop":
                z[6], mode = mode * self.mu * self.numbers(z, mode)[1] / self.k_t, 0
            else:
                mode = name

    def landing(self, z):
        _, rate, slip = self.end(z)
        normal, by_depth, _ = self.law(0.0, -rate)
        if normal > 0 or self.k_t * abs(slip) < -self.mu * by_depth * rate:
            return 0
        return 1 if slip > 0 else -1


@pytest.mark.slow
@settings(max_examples=8)
@given(
    name=st.sampled_from(["linear", "hertz"]),
    theta=st.floats(0.6, 1.2),
    slip=st.floats(-1.0, 1.0),
    approach=st.floats(0.05, 1.0),
    mu=st.floats(0.1, 2.0),
    log_k_t=st.floats(6.0, 9.0),
    c=st.sampled_from([0.0, 1e3]),
)
def test_landing_of_the_rod_equals_scipy(name, theta, slip, approach, mu, log_k_t, c):
    assume(abs(slip) > 0.01)
    k_t = 10**log_k_t
    parameters = {"mu": mu, K_T: k_t} | ({"c": c} if name == "linear" else {})
    state = {"theta": theta, "x_A_dot": slip, "y_A_dot": -approach, "y_A": 1e-4}
    own = rod(name).run(
        state, t_end=0.02, parameters=parameters, rtol=1e-13, until="separation", max_events=200
    )
    start = [math.cos(theta), 1e-4 + math.sin(theta), theta, slip, -approach, 0.0, 0.0]
    events, z = ByHand(force_law(name, 1e8, c), mu, k_t).run(start, 0.02)
    mine = [e for e in own.events if e.kind.value in {n for n, _ in events}]
    # Where a force is tiny a slip may stop and start again: only the last instant can tell.
    assume(all(b - a > 1e-8 for (_, a), (_, b) in itertools.pairwise(events)))
    assert [e.kind.value for e in mine] == [n for n, _ in events]
    for e, (_, time) in zip(mine, events, strict=True):
        assert e.time == pytest.approx(time, rel=1e-6, abs=1e-10)
    by_hand = (z[3] + math.sin(z[2]) * z[5], z[4] - math.cos(z[2]) * z[5], z[5])
    ends = [own.final[n] for n in ("x_A_dot", "y_A_dot", "theta_dot")]
    assert ends == pytest.approx(by_hand, rel=1e-7, abs=1e-7)


# ---- the limit of a rigid tangent ----


@pytest.mark.slow
@settings(max_examples=8)
@given(
    law=st.sampled_from(LAWS),
    slip=st.floats(1.0, 4.0),
    approach=st.floats(0.0, 0.5),
    mu=st.floats(0.0, 1.9),
    side=st.sampled_from([-1, 1]),
)
def test_sliding_contact_does_not_feel_a_stiff_spring(law, slip, approach, mu, side):
    # k_t > μ Ḟ_n/|v_t| all along: the motion up to the end of the slip is the same.
    state = {"theta": 1.0, "x_A_dot": side * slip, "y_A_dot": -approach}
    options = {"t_end": 0.01, "until": ("slip_stop", "separation")}
    plain = rod(law, "coulomb").run(state, parameters={"mu": mu}, **options)
    other = rod(law).run(state, parameters={"mu": mu, K_T: 1e15}, **options)
    assume(plain.events)
    assert kinds(other) == kinds(plain)
    assert other.final_time == pytest.approx(plain.final_time, rel=1e-6)
    for name, value in plain.final.items():
        scale = 1e-5 if "slip_stop" in kinds(plain) else 1e-10
        assert other.final[name] == pytest.approx(value, rel=scale, abs=scale), name


APPROACHES = {
    "slip all along, elastic": ({"x_A_dot": -3.0, "y_A_dot": -0.3}, {"mu": 0.3}, None),
    "slip all along, damped": ({"x_A_dot": -3.0, "y_A_dot": -0.3}, {"mu": 0.3, "c": 3e3}, 1.0),
    "slip reverses": ({"x_A_dot": 0.3, "y_A_dot": -1.0}, {"mu": 0.2}, 0.5),
}
VELOCITIES = ("x_A_dot", "y_A_dot", "theta_dot")


@pytest.mark.parametrize("name", APPROACHES)
def test_order_of_convergence_to_a_rigid_tangent(name):
    state, parameters, order = APPROACHES[name]
    options = {"t_end": 0.02, "rtol": 1e-13, "until": "separation"}
    state = {"theta": 1.0, **state}
    plain = rod(friction="coulomb").run(state, parameters=parameters, **options)
    stiffnesses = np.array([1e11, 1e12, 1e13])
    errors = []
    for k_t in stiffnesses:
        run = rod().run(state, parameters={**parameters, K_T: float(k_t)}, **options)
        errors.append(max(abs(run.final[n] - plain.final[n]) for n in VELOCITIES))
    if order is None:
        assert max(errors) < 1e-15  # steps differ: they follow the work of friction, too
    else:
        slope = -np.polyfit(np.log(stiffnesses), np.log(errors), 1)[0]
        assert slope == pytest.approx(order, abs=0.02)


def worst(t_end, k_t, plain, **options):
    """Return the largest difference of velocities over springs near k_t."""
    runs = [
        rod().run(TABLE_3, t_end=t_end, parameters={K_T: k_t * f}, **options)
        for f in np.logspace(-0.4, 0.4, 9)
    ]
    return max(abs(r.final[n] - plain.final[n]) for r in runs for n in VELOCITIES)


@pytest.mark.parametrize(
    ("t_end", "until", "order"), [(0.00131, (), 0.5), (0.01, ("separation",), 1.0)]
)
def test_order_while_a_contact_sticks_and_after_it_has_slipped_again(t_end, until, order):
    options = {"rtol": 1e-12, "until": until, "max_events": 10_000}
    plain = rod(friction="coulomb").run(TABLE_3, t_end=t_end, **options)
    errors = [worst(t_end, k_t, plain, **options) for k_t in (1e11, 1e14)]
    assert math.log10(errors[0] / errors[1]) / 3 == pytest.approx(order, abs=0.12)


def test_critical_force_is_that_of_coulomb_while_the_contact_slides():
    state = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
    values = [
        CriticalForceFinder(rod(friction=friction)).find(
            state, parameters, border=Border.COMPRESSION
        )
        for friction, parameters in (("coulomb", {}), ("spring", {K_T: 8e7}))
    ]
    assert values[1].value == pytest.approx(values[0].value, rel=1e-12)


# ---- energy, cone, mirror image, engines ----


@settings(max_examples=40)
@given(
    law=st.sampled_from(LAWS),
    mu=st.floats(0.0, 2.0),
    log_k_t=st.floats(5.0, 11.0),
    slip=st.floats(-2, 2),
    approach=st.floats(0.0, 1.0),
    c=st.floats(0.0, 1e4),
)
@example(law="linear", mu=1.4, log_k_t=8.0, slip=0.0, approach=0.5, c=0.0)
@example(law="hertz", mu=0.0, log_k_t=8.0, slip=0.0, approach=0.5, c=0.0)
# The spring is past its cone at once, and back at it within the first step.
@example(law="linear", mu=0.0, log_k_t=5.0, slip=0.0, approach=0.0, c=0.0)
def test_energy_balance_closes_and_the_mirror_image_mirrors(law, mu, log_k_t, slip, approach, c):
    parameters = {"mu": mu, K_T: 10**log_k_t} | ({"c": c} if law == "linear" else {})
    state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": slip, "y_A_dot": -approach}
    other = {**state, "theta": math.pi - 1.0, "theta_dot": -1.0, "x_A_dot": -slip}
    options = {"t_end": 0.004, "parameters": parameters, "max_events": 5000}
    run, mirror = rod(law).run(state, **options), rod(law).run(other, **options)
    t = run.sample(60)
    values, energy = run.outputs(t), total_energy(run, t)
    assert np.ptp(energy) < 3e-9 * np.max(np.abs(energy))
    assert np.all(np.diff(run.values("friction_dissipation", t)) >= -1e-9)
    bound = mu * values["normal_force"]
    assert np.all(np.abs(values["tangential_force"]) <= bound * (1 + 1e-7) + 1e-6)
    assert kinds(run) == kinds(mirror)
    assert mirror.final["y_A_dot"] == pytest.approx(run.final["y_A_dot"], rel=1e-6, abs=1e-8)
    assert mirror.final["x_A_dot"] == pytest.approx(-run.final["x_A_dot"], rel=1e-6, abs=1e-8)


def test_batch_is_its_single_runs_bit_for_bit():
    stiffnesses = np.logspace(6, 10, 7)
    batch = run_batch(rod(), TABLE_3, parameters={K_T: stiffnesses}, t_end=0.006)
    single = [rod().run(TABLE_3, parameters={K_T: float(k)}, t_end=0.006) for k in stiffnesses]
    assert list(batch["y_A_dot"]) == [r.final["y_A_dot"] for r in single]


@pytest.mark.slow
def test_derivatives_are_differences():
    state = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
    options = {"t_end": 0.004, "rtol": 1e-12, "initial_force": 400.0}
    values = {K_T: 1e8, "mu": 1.4}
    own = rod().sensitivities(state, wrt=(K_T, "mu"), parameters=values, **options)
    assert "slip_stop" in kinds(rod().run(state, parameters=values, **options))
    for name, step in ((K_T, 1e3), ("mu", 1e-6)):
        ends = [
            rod().run(state, parameters=values | {name: values[name] + h}, **options)
            for h in (-step, step)
        ]
        slope = (ends[1].final["y_A_dot"] - ends[0].final["y_A_dot"]) / (2 * step)
        assert own.final_gradient("y_A_dot")[name] == pytest.approx(slope, rel=1e-5)


def test_loaded_start_has_slid_and_a_start_at_rest_is_relaxed():
    state = {"theta": 1.0, "theta_dot": 5.0}
    for speed, side in ((-1.0, -1), (1.0, 1), (0.0, 0)):
        run = rod().run({**state, "x_A_dot": speed}, t_end=1e-4, initial_force=300.0)
        own = run.outputs([0.0])
        assert own["tangential_force"] == pytest.approx(-side * 1.4 * 300.0, rel=1e-12, abs=1e-9)


def test_exported_c_has_the_state_of_the_spring(tmp_path):
    law = ps.law("linear", friction="spring")
    export_c("rod", law, TABLE_3, folder=tmp_path, t_end=0.006)
    assert "deflection_from_slip" in (tmp_path / "rod_model.c").read_text("utf-8")


# ---- bad input ----


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: rod().run(TABLE_3, t_end=1e-3, parameters={K_T: 0.0}), f"0 < {K_T}"),
        (lambda: rod().run(TABLE_3, t_end=1e-3, parameters={K_T: -1.0}), f"0 < {K_T}"),
        (lambda: rod().run(TABLE_3, t_end=1e-3, parameters={K_T: math.inf}), "finite"),
        (lambda: ps.law("rigid", friction="spring"), "compliant law"),
        (
            lambda: ps.law("bilinear-hertz", friction="spring", reload="virgin"),
            "reload='elastic'",
        ),
        (
            lambda: ps.Simulator(ps.model("painleve-klein"), ps.law("linear", friction="spring")),
            "both sides",
        ),
        (
            lambda: evaluate_corrected_jump(
                ps.model("rod"), ps.law("linear", friction="spring"), TABLE_3
            ),
            "along its tangent",
        ),
    ],
)
def test_what_does_not_go_together_is_one_sentence(make, words):
    with pytest.raises(InputError, match=words):
        make()
