"""A friction curve through every door: batch, sweep, C, derivatives, files, several contacts."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.at.delassus import Delassus
from painleve_sym.c_export.export import export_scenario
from painleve_sym.c_export.files import expected
from painleve_sym.errors import EventKind, InputError, PainleveWarning, StopReason
from painleve_sym.mechanics.friction import SLIP_VELOCITY
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.study.scenario import Scenario
from painleve_sym.study.sweeps.runner import run_sweep
from painleve_sym.study.sweeps.sweep import Sweep
from tests.motion.test_friction_curves import BUMP, EXPONENTIAL, LEINE, UNIT, belt, run_on
from tests.motion.test_several_static_frictions import BLOCKS, SIDES, G, M, Oracle, U
from tests.scenes import EXAMPLES
from tests.support.exports import built_by_compiler

BELT = "block-on-belt"


def test_rows_of_a_batch_are_the_runs():
    d = np.array([0.5, 1.0, 3.0])
    batch = run_batch(belt(LEINE), {"x_dot": 0.2}, UNIT | {"d": d}, t_end=14.0, rtol=1e-12)
    for i, fall in enumerate(d):
        run = run_on(belt(LEINE), 14.0, d=float(fall))
        assert batch["x"][i] == run.final["x"]


def test_sweep_over_the_parameter_of_a_curve_is_its_runs(tmp_path):
    text = f"""
    model = "{BELT}"
    t_end = 14.0
    state = {{ x_dot = 0.2 }}
    law = {{ name = "rigid" }}
    keep = ["x", "time_of_slip_stop"]

    [axes]
    d = [0.5, 3.0]
    """
    out = tmp_path / "swept.npz"
    run_sweep(Sweep.from_text(text, "curve.toml"), out, threads=1)
    mechanism = ps.model(BELT)
    with np.load(out, allow_pickle=False) as data:
        for i, d in enumerate((0.5, 3.0)):
            run = ps.simulate(mechanism, "rigid", {"x_dot": 0.2}, parameters={"d": d}, t_end=14.0)
            assert data["x"][i] == run.final["x"]
            assert data["time_of_slip_stop"][i] == run.events_of("slip_stop")[0].time


@pytest.mark.parametrize("law", ["rigid", "linear"])
def test_exported_c_gives_the_bits_of_the_run(law, tmp_path):
    own = {} if law == "rigid" else {"k": 1e5, "c": 200.0}
    scenario = Scenario(
        BELT, {"x_dot": 0.2}, law=law, law_parameters=own, t_end=14.0,
        initial_force=None if law == "rigid" else 1.0,
    )  # fmt: skip
    done = export_scenario(scenario, tmp_path / "c")
    assert {"slip_start", "slip_stop"} <= {e.kind for e in done.trajectory.events}
    assert built_by_compiler(done, "-O0", "-march=native", "-ffp-contract=off") == expected(
        done.trajectory
    )


def test_derivatives_by_the_parameters_of_a_curve_are_differences():
    simulator, step = belt(EXPONENTIAL), 1e-6
    options = {"t_end": 16.0, "rtol": 1e-12}
    start = {"x": 1.6, "x_dot": -0.3}
    names = ("v_s", "mu_k", "mu", "u")
    values = UNIT | {"v_s": 0.1, "u": 0.2}
    own = simulator.sensitivities(start, wrt=names, parameters=values, **options)
    assert {"slip_stop", "slip_start"} <= {e.kind for e in own.trajectory.events}
    for name in names:
        ends = [
            simulator.run(start, parameters=values | {name: values[name] + h}, **options)
            for h in (-step, step)
        ]
        slope = (ends[1].final["x"] - ends[0].final["x"]) / (2 * step)
        assert own.final_gradient("x")[name] == pytest.approx(slope, rel=2e-5)


def test_saved_motion_has_its_curve_and_continues(tmp_path):
    whole = run_on(belt(LEINE, "1.1*mu"), 20.0)
    for cut in (3.0, 7.3, whole.events_of("slip_start")[0].time):
        first = run_on(belt(LEINE, "1.1*mu"), cut)
        first.save(tmp_path / "run.npz")
        read = ps.Trajectory.load(tmp_path / "run.npz")
        assert read.final == first.final
        rest = first.continued(20.0, rtol=1e-12)
        assert rest.final["x"] == pytest.approx(whole.final["x"], abs=1e-10)


@pytest.mark.parametrize("curve", [EXPONENTIAL, BUMP])
def test_engines_agree(curve):
    ends = []
    for engine in ("taylor", "compiled"):
        simulator = ps.Simulator(belt(curve).mechanism, "rigid", engine)
        run = simulator.run({"x": 1.7, "x_dot": 0.2}, t_end=9.0, parameters=UNIT, rtol=1e-12)
        ends.append([run.final["x"], *(e.time for e in run.events)])
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)


# ---- several contacts ----


class TwoCurves(Oracle):
    """Two rigid blocks with the friction mu/(1 + 3 |v|): the load is the weight."""

    def __init__(self, rise):
        self.rise = rise

    def normal(self, i, t):
        return M[i] * G

    def friction(self, i, v, sign, t):
        return -sign * 0.4 * self.normal(i, t) / (1 + 3 * sign * v)

    def limit(self, i, t):
        return 0.4 * self.rise[i] * self.normal(i, t)


@functools.cache
def two_blocks(static):
    text = BLOCKS
    for i in (1, 2):
        own = f'friction = "mu_{i}/(1 + 3*abs(v_t))"\nstatic_friction = "{static[i - 1]}*mu_{i}"'
        text = text.replace(f'friction = "mu_{i}"', own)
    return mechanism_from_text(text)


@pytest.mark.parametrize("laws", ["rigid", "left=rigid,right=linear"])
@pytest.mark.parametrize("static", [(1, 1), (1, 1.4)])
def test_two_blocks_with_curves_are_those_of_scipy(static, laws):
    x = (0.004, -0.003)
    events, end = TwoCurves(static).run(x, (U, U), 1.2)
    law = ps.law(laws)
    start = {"x_1": x[0], "x_2": x[1], "x_1_dot": U, "x_2_dot": U}
    values = {"mu_1": 0.4, "mu_2": 0.4}
    if laws != "rigid":
        values |= {"k_right": 1e6, "c_right": 500.0}
        start["y_2"] = -M[1] * G / 1e6
    simulator = ps.Simulator(two_blocks(static), law, "auto" if laws == "rigid" else "compiled")
    run = simulator.run(start, t_end=1.2, parameters=values, rtol=1e-12)
    slips = [e for e in run.events if e.kind in ("slip_start", "slip_stop")]
    assert [(e.kind, e.contact) for e in slips] == [(k, c) for _, k, c in events]
    assert {c for _, _, c in events} == set(SIDES)
    np.testing.assert_allclose([e.time for e in slips], [t for t, *_ in events], atol=1e-8)
    own = [run.final[n] for n in ("x_1", "x_2", "x_1_dot", "x_2_dot")]
    np.testing.assert_allclose(own, end, atol=1e-8)
    assert run.energy_residual < 1e-10


def test_impact_of_several_contacts_stops_where_rest_and_slip_differ():
    start = {"y_1": 0.001, "y_2": 0.002, "x_1_dot": U, "x_2_dot": U}
    run = ps.Simulator(two_blocks((1, 1)), "rigid").run(start, t_end=0.2)
    assert run.stop_reason is StopReason.VARYING_FRICTION
    assert run.events[-1].kind is EventKind.IMPACT


# ---- impacts with two coefficients ----


@pytest.mark.parametrize(("ratio", "sticks"), [(1.0, False), (1.5, True)])
def test_impact_at_rest_sticks_up_to_the_static_coefficient(ratio, sticks):
    """A point of the rod lands without slip: it sticks where |W_nt| <= mu_s W_tt."""
    rod = ps.model("rod")
    start = {"theta": 1.0, "y_A_dot": -1.0}
    c = Delassus.of(rod).at(rod.at(start).values)
    needed = abs(c.W[0, 1] / c.W[1, 1])
    law = ps.laws.rigid(e=0.0, friction="static").with_parameters(static_ratio=ratio)
    run = ps.simulate("rod", law, start, parameters={"mu": needed / 1.2}, t_end=1e-3)
    modes = [e.mode_before for e in run.events if e.kind is EventKind.IMPACT_END]
    assert modes and modes[0].startswith("impact/stick") is sticks


def test_impact_slides_with_the_kinetic_and_then_sticks_by_the_static_coefficient():
    """Of a slip that stops in the impact, against the path by hand."""
    rod = ps.model("rod")
    start = {"theta": 1.0, "y_A_dot": -1.0, "x_A_dot": 0.05}
    c = Delassus.of(rod).at(rod.at(start).values)
    (nn, nt), (_, tt) = c.W
    mu = abs(nt / tt) / 1.2
    law = ps.laws.rigid(e=0.0, friction="static").with_parameters(static_ratio=1.5)
    run = ps.simulate("rod", law, start, parameters={"mu": mu}, t_end=1e-6)
    v_n, v_t = float(c.gap_rate[0]), float(c.slip_velocity[0])
    s = math.copysign(1, v_t)
    slip = -v_t / (nt - s * mu * tt)  # P_n until the slip stops
    v_n += (nn - s * mu * nt) * slip
    assert slip > 0 > v_n
    ends = next(e for e in run.events if e.kind is EventKind.IMPACT_MAX_COMPRESSION)
    total = slip - v_n / (nn - nt**2 / tt)
    assert ends.state["x_A_dot"] == pytest.approx(0.0, abs=1e-12)
    D = Delassus.of(rod).whole_at(rod.at(start).values)[1].D
    P_t = -s * mu * slip - nt / tt * (total - slip)
    i = rod.outline.velocity_names.index("theta_dot")
    assert ends.state["theta_dot"] == pytest.approx(D[i, 0] * total + D[i, 1] * P_t, rel=1e-12)


# ---- contact problems ----


def test_contact_problem_of_a_curve_in_space_has_the_length_of_the_slip():
    rod = ps.model("rod-3d")
    c = rod.contact
    own = (c.name, c.system, c.gap, c.slip_velocity, c.mu / (1 + abs(SLIP_VELOCITY)))
    contact = ps.Contact(*own, slip_across=c.slip_across)
    falls = ps.Mechanism("falls", "", "", c.system, (contact,), rod.domain, start=rod.start)
    state = dict(rod.start) | {"x_A_dot": -0.3, "y_A_dot": 0.4}
    speed = math.hypot(*Delassus.of(rod).at(rod.at(state).values).slip_velocity[0])
    mu = falls.parameters["mu"]
    own_case = ps.classify(falls, state)
    plain = ps.classify(rod, state, parameters={"mu": mu / (1 + speed)})
    assert own_case.problem.mu.item() == pytest.approx(mu / (1 + speed), rel=1e-14)
    assert own_case.case is plain.case


def test_map_and_casadi_take_the_friction_at_the_slip_velocity():
    rod = ps.model("rod")
    c = rod.contact
    own = (c.name, c.system, c.gap, c.slip_velocity, c.mu / (1 + abs(SLIP_VELOCITY)))
    falls = ps.Mechanism("falls", "", "", c.system, (ps.Contact(*own),), rod.domain)
    A = falls.casadi("A")
    place = falls.at({"theta": 1.0, "x_A_dot": -0.5}, {"mu": 1.8})
    plain = rod.at({"theta": 1.0, "x_A_dot": -0.5}, {"mu": 1.2})
    values = [[*p.state.values()] for p in (place, plain)]
    parameters = [[*p.parameters.values()] for p in (place, plain)]
    assert float(A(values[0], parameters[0])) == pytest.approx(
        float(rod.casadi("A")(values[1], parameters[1])), rel=1e-14
    )
    over, options = ("theta", "theta_dot"), {"points": 5, "state": {"x_A_dot": -0.5}}
    ranges = {"theta": (0.3, 1.4), "theta_dot": (-4.0, 4.0)}
    maps = [
        ps.region_map(m, over, ranges=ranges, parameters={"mu": mu}, **options)
        for m, mu in ((falls, 1.8), (rod, 1.2))
    ]
    assert np.array_equal(maps[0].case, maps[1].case)


def test_guide_slides_under_a_curve_as_by_hand():
    """A bead on a level guide, pressed by its weight: v' = -mu(v) g."""
    text = BLOCKS[: BLOCKS.index("[[springs]]")].replace(
        "g = {", "F = { default = 1.0, unit = 'N' }\ng = {"
    )
    text = text + '[[contacts]]\nname = "guide"\npoint = ["x_1", "y_1"]\nbilateral = true\n'
    text += 'friction = "mu_1/(1 + 3*abs(v_t))"\nstatic_friction = "2*mu_1"\n'
    mechanism = mechanism_from_text(text)
    for v in (0.5, -0.5):
        run = ps.simulate(mechanism, "rigid", {"x_1_dot": v}, t_end=1.0)
        stop = run.events_of("slip_stop")[0].time
        # (1 + 3 v) dv = -mu g dt
        assert stop == pytest.approx((abs(v) + 1.5 * v**2) / (0.4 * G), rel=1e-10)
        assert run.mode_names[run.final_mode].startswith("stick")


def test_rejected_questions_name_both_coefficients():
    mechanism = ps.model(BELT)
    with pytest.raises(InputError, match=r"mu_s/\(d\*Abs\(v_t\) \+ 1\) in slip"):
        ps.evaluate_jump(mechanism, "newton", {"x_dot": 1.0, "y_dot": -1.0})


def test_a_contact_at_rest_sticks_by_its_static_coefficient_on_a_map():
    """A point on a slope: it could stick where tan(slope) <= mu_s."""
    text = BLOCKS[: BLOCKS.index("[[springs]]")].replace(
        'gravity = "g"', 'gravity = ["-g*sin(a)", "-g*cos(a)"]'
    )
    text = text.replace("g = {", 'a = { default = 0.1, unit = "rad" }\ng = {', 1)
    text += '[[contacts]]\nname = "foot"\npoint = ["x_1", "y_1"]\n'
    text += 'friction = "mu_1"\nstatic_friction = "2*mu_1"\n'
    mechanism = mechanism_from_text(text)
    angles = np.linspace(0.1, 1.2, 23)
    ranges = {"a": (0.1, 1.2), "x_1_dot": (0.5, 1.0)}
    drawn = ps.region_map(mechanism, ("a", "x_1_dot"), ranges=ranges, points=23)
    assert drawn.stick_feasible.mean() == pytest.approx(np.mean(np.tan(angles) <= 0.8))
    with pytest.warns(PainleveWarning, match="static friction"):
        answer = ps.classify(mechanism, {"x_1_dot": 0.0})
    assert answer.problem.mu.item() == 0.4


def test_classify_of_a_file_whose_curve_comes_to_zero(tmp_path):
    """The condition mu > 0 of the curve is a margin behind that of the file."""
    text = (EXAMPLES / "rod.toml").read_text("utf-8")
    file = tmp_path / "falling.toml"
    file.write_text(text.replace('friction = "mu"', 'friction = "mu - 0.1*abs(v_t)"'), "utf-8")
    mechanism = ps.load_mechanism(file)
    assert len(mechanism.outline.domain) == len(mechanism.domain) == 2
    state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    rod = ps.model("rod", mu=1.3)
    assert pytest.approx(ps.classify(rod, state).A, rel=1e-12) == ps.classify(mechanism, state).A
    with pytest.raises(ps.InputError, match="friction coefficient of contact A is positive"):
        ps.classify(mechanism, state | {"x_A_dot": -15.0})
