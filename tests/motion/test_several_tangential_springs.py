"""Tangential springs of several contacts: SciPy, one contact, energy, mirror image, engines."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import painleve_sym as ps
from painleve_sym.errors import InputError
from painleve_sym.motion.batch.run import run_batch
from tests.oracles.feet_scipy import Law
from tests.oracles.sprung_feet_scipy import SprungBlock
from tests.scenes import FEET, TABLE, simulator

# K_e of Hertz's law, both bodies of one material: (4/3) E/(2 (1 - nu^2)) sqrt(R).
_HERTZ = 2e7 * 4 / 3 / (2 * (1 - 0.3**2)) * np.sqrt(0.00645)
LAWS = {
    "soft": ({"k": 3e4, "c": 5.0}, Law(3e4, 1.0, 5.0)),
    "damped": ({"k": 1e5, "c": 40.0}, Law(1e5, 1.0, 40.0)),
    "hertz": ({"E": 2e7}, Law(_HERTZ, 1.5)),
}
STARTS = {
    "tilted drop": {"y_A": 1e-3, "theta": 0.02, "x_A_dot": -0.3},
    "slow drop": {"y_A": 1e-3, "theta": 0.01, "x_A_dot": -0.02},
    "drop on B": {"y_A": 5e-3, "theta": -0.02, "x_A_dot": 0.3, "theta_dot": 0.3},
    "slide": {"y_A": -1e-4, "theta": 1e-3, "x_A_dot": -0.2},
}


def feet(names, frictions=("spring", "spring")):
    pairs = zip("AB", names, frictions, strict=True)
    own = (f"{c}={'hertz' if n == 'hertz' else 'linear'}/{friction}" for c, n, friction in pairs)
    return simulator(FEET, ",".join(own))


def table(law="linear", engine="auto"):
    return simulator(TABLE, f"{law}/spring", engine)


def kinds(run):
    return [(str(e.kind), e.contact) for e in run.events]


# ---- SciPy, on equations written by hand ----


@pytest.mark.slow
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize(
    ("names", "springs"),
    [
        (("soft", "damped"), (8e4, None)),
        (("damped", "hertz"), (8e4, 5e4)),
        (("hertz", "hertz"), (8e4, 5e4)),
    ],
)
def test_two_feet_follow_the_equations_written_by_hand(springs, names, start):
    given_, laws = {}, []
    for foot, name, k_t in zip("AB", names, springs, strict=True):
        own, law = LAWS[name]
        laws.append(law)
        given_ |= {f"{n}_{foot}": v for n, v in own.items()}
        given_ |= {f"tangential_stiffness_{foot}": k_t} if k_t is not None else {}
    frictions = tuple("coulomb" if k is None else "spring" for k in springs)
    t_end = 0.08
    run = feet(names, frictions).run(STARTS[start], parameters=given_, t_end=t_end, rtol=1e-12)
    block = SprungBlock(tuple(laws), springs=springs)
    events, end = block.run(block.start(**STARTS[start]), t_end)
    assert kinds(run) == [(e.kind, e.foot) for e in events]
    assert len(events) >= 5
    times = np.array([[e.time, o.time] for e, o in zip(run.events, events, strict=True)])
    assert np.abs(times[:, 0] - times[:, 1]).max() < 1e-9 * t_end
    for name, value in block.foot_A(end).items():
        assert run.final[name] == pytest.approx(value, rel=1e-8, abs=2e-9), name


# ---- other independent checks ----


@pytest.mark.slow
@settings(max_examples=10)
@given(slip=st.floats(-0.5, 0.5), approach=st.floats(0.0, 0.3), log_k_t=st.floats(3.5, 7.0))
def test_foot_that_touches_alone_moves_as_an_only_contact(slip, approach, log_k_t):
    state = {"y_A": 1e-4, "theta": 0.2, "x_A_dot": slip, "y_A_dot": -approach}
    block, law = ps.model(FEET), ps.law("linear", friction="spring")
    soft = {"k": 1e5, "c": 40.0, "tangential_stiffness": 10**log_k_t}
    alone = ps.Simulator(block.only("A"), law).run(state, parameters=soft, t_end=0.02)
    both = simulator(FEET, "linear/spring").run(state, parameters=soft, t_end=0.02)
    assert [str(e.kind) for e in alone.events] == [str(e.kind) for e in both.events]
    assert alone.events
    for name in ("x_A_dot", "y_A_dot", "theta_dot", "friction_dissipation"):
        assert both.final[name] == pytest.approx(alone.final[name], rel=1e-8, abs=1e-9), name
    times = np.linspace(0, 0.02, 50)
    ours, own = both.outputs(times)["tangential_deflection_A"], alone.outputs(times)
    size = np.max(np.abs(own["tangential_deflection"]))
    assert ours == pytest.approx(own["tangential_deflection"], rel=0, abs=1e-7 * size)


drops = st.fixed_dictionaries(
    {
        "y": st.floats(0.008, 0.02),
        "theta": st.floats(1e-3, 0.02),
        "x_dot": st.floats(-0.5, 0.5),
        "theta_dot": st.floats(-0.5, 0.5),
    }
)
FRICTION = {"mu_left": 0.3, "mu_middle": 0.5, "mu_right": 0.6}
SPRUNG = {"k": 1e5, "c": 30.0, "tangential_stiffness": 5e4}


@pytest.mark.slow
@settings(max_examples=20)
@given(start=drops, law=st.sampled_from(["linear", "bilinear-hertz"]))
@example(start={"y": 0.01, "theta": 2e-3, "x_dot": 0.0, "theta_dot": 0.0}, law="linear")
def test_energy_closes_friction_stays_in_its_cone_and_the_mirror_image_mirrors(start, law):
    soft = SPRUNG if law == "linear" else {"E": 1e7, "tangential_stiffness": 5e4}
    options = {"t_end": 0.1, "max_events": 2000}
    run = table(law).run(start, parameters=soft | FRICTION, **options)
    assert run.energy_residual < 1e-9
    values = run.outputs(run.sample(80))
    for name, mu in FRICTION.items():
        leg = name.removeprefix("mu_")
        bound = mu * values[f"normal_force_{leg}"]
        assert np.all(np.abs(values[f"tangential_force_{leg}"]) <= bound * (1 + 1e-7) + 1e-6)
    mirrored = {k: v if k == "y" else -v for k, v in start.items()}
    other = FRICTION | {"mu_left": FRICTION["mu_right"], "mu_right": FRICTION["mu_left"]}
    mirror = table(law).run(mirrored, parameters=soft | other, **options)
    for name, value in run.final.items():
        if name in ("x", "x_dot", "theta", "theta_dot"):
            assert mirror.final[name] == pytest.approx(-value, rel=1e-6, abs=1e-7), name
        elif name in ("y", "y_dot"):
            assert mirror.final[name] == pytest.approx(value, rel=1e-6, abs=1e-7), name


@pytest.mark.slow
def test_engines_agree():
    start = {"y": 0.01, "theta": 0.01, "x_dot": 0.3}
    runs = [
        table(engine=engine).run(start, parameters=SPRUNG | FRICTION, t_end=0.05)
        for engine in ("auto", "compiled")
    ]
    assert len(runs[0].events) >= 4
    for run in runs[1:]:
        assert kinds(run) == kinds(runs[0])
        for name in ("x_dot", "y_dot", "theta_dot"):
            assert run.final[name] == pytest.approx(runs[0].final[name], rel=1e-8, abs=1e-9)


@pytest.mark.slow
def test_stiff_springs_are_coulomb_friction_while_the_feet_slide():
    start = {"y_A": -1e-4, "theta": 1e-3, "x_A_dot": -3.0}
    soft = {"k": 1e5, "c": 0.0}
    plain = simulator(FEET, "linear").run(start, parameters=soft, t_end=0.03)
    sprung = simulator(FEET, "linear/spring").run(
        start, parameters=soft | {"tangential_stiffness": 1e12}, t_end=0.03
    )
    assert kinds(sprung) == kinds(plain)
    assert len(plain.events) >= 3
    for name, value in plain.final.items():
        assert sprung.final[name] == pytest.approx(value, rel=1e-9, abs=1e-9), name


@pytest.mark.slow
def test_sprung_foot_beside_a_rigid_one_keeps_its_energy():
    soft = {"E_A": 2e7, "tangential_stiffness_A": 5e4, "e_energetic_B": 0.3}
    run = simulator(FEET, "A=hertz/spring,B=rigid").run(
        STARTS["tilted drop"], parameters=soft, t_end=0.2
    )
    assert "impact" in [str(e.kind) for e in run.events]
    assert {c for _, c in kinds(run)} >= {"A", "B"}
    assert run.energy_residual < 1e-9


def test_spring_with_a_dashpot_beside_a_rigid_contact_is_refused():
    laws = {"A": ps.law("linear", friction="spring"), "B": ps.law("rigid")}
    with pytest.raises(InputError, match=r"block-two-feet: friction: .*impacts.* Fix: "):
        ps.Simulator(ps.model("block-two-feet"), laws)


@pytest.mark.slow
def test_batch_is_its_single_runs_bit_for_bit_and_derivatives_are_differences():
    start, values = {"y": 0.01, "theta": 0.01, "x_dot": 0.3}, SPRUNG | FRICTION
    stiffnesses = np.logspace(4, 6, 5)
    rows = {**values, "tangential_stiffness": stiffnesses}
    batch = run_batch(table(), start, parameters=rows, t_end=0.04)
    single = [
        table().run(start, parameters={**values, "tangential_stiffness": float(k)}, t_end=0.04)
        for k in stiffnesses
    ]
    assert list(batch["x_dot"]) == [r.final["x_dot"] for r in single]
    options = {"t_end": 0.04, "rtol": 1e-12}
    own = table().sensitivities(start, wrt=("tangential_stiffness",), parameters=values, **options)
    h = 10.0
    ends = [
        table().run(start, parameters=values | {"tangential_stiffness": 5e4 + d}, **options)
        for d in (-h, h)
    ]
    slope = (ends[1].final["x_dot"] - ends[0].final["x_dot"]) / (2 * h)
    gradient = own.final_gradient("x_dot")["tangential_stiffness"]
    assert gradient == pytest.approx(slope, rel=1e-5)


def test_loaded_start_has_slid():
    soft = {"k": 1e5, "tangential_stiffness": 5e4}
    for speed in (-0.2, 0.2):
        run = simulator(FEET, "linear/spring").run(
            {"y_A": -1e-4, "x_A_dot": speed}, t_end=1e-5, parameters=soft
        )
        force = run.outputs([0.0])
        assert force["normal_force_A"] == pytest.approx(10.0)
        assert force["tangential_force_A"] == pytest.approx(-np.sign(speed) * 0.4 * 10.0)
