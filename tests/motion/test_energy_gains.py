"""Runs say where an impact or a reload adds energy, and nothing where none does."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import painleve_sym as ps
from painleve_sym.cli import main
from painleve_sym.errors import EventKind
from painleve_sym.motion.energy_gains import EnergyGain, notices
from tests.support.paper_law import paper_law

# A block on two feet that falls on both; under the energetic law of several contacts that opposed
# friction to the slip at the end of a phase it gained 4.9 %.
BLOCK = {"m": 1.0, "a": 1.0, "h": 1.4655005627793976, "J": 1.0492306332, "beta": 0.0}
BLOCK |= {"mu_A": 0.9309, "mu_B": 0.9309}
FALL = {"x_A_dot": -1.42637, "y_A_dot": -0.8336, "theta_dot": -1.2298}
# The tip of the rod ends sticking, and gets all of its approach back by Newton's law.
ROD = {"theta": 0.9094735427250726, "y_A_dot": -1.0, "x_A_dot": 0.674, "theta_dot": 0.665}


def options(values: dict[str, float]) -> str:
    return ",".join(f"{name}={value!r}" for name, value in values.items())


def kinetic_energy(mechanism: ps.Mechanism, state: dict[str, float], values: dict[str, float]):
    """Return T from the formula of the mechanism, evaluated by SymPy."""
    expr, system = mechanism.system.kinetic_energy, mechanism.system
    at = {s: state[s.name] for s in (*system.q, *system.q_dot)}
    return float(expr.subs(at | {p.symbol: values[p.name] for p in system.parameters}))


def block_falls(law: str, **more: object) -> ps.Trajectory:
    rigid = ps.laws.rigid(restitution=law, e=0.9813)
    simulator = ps.Simulator(ps.model("block-two-feet"), rigid)
    return simulator.run(FALL, parameters=BLOCK, t_end=1e-6, **more)


@pytest.mark.slow
def test_impact_of_two_feet_by_newtons_law_says_what_it_adds():
    run = block_falls("newton")
    (gain,) = run.energy_gains
    block = ps.model("block-two-feet")
    states = [dict.fromkeys(block.state_names, 0.0) | FALL, run.events[0].state]
    before, after = (kinetic_energy(block, state, run.parameters) for state in states)
    assert (gain.time, gain.kind, gain.law) == (0.0, EventKind.IMPACT, "newton")
    assert gain.contacts == ("B",)
    assert gain.kinetic_energy == pytest.approx(before, rel=1e-12)
    assert gain.gain == pytest.approx(after - before, rel=1e-9)
    assert gain.gain / before == pytest.approx(0.331, abs=5e-4)
    assert run.notices == (
        "At t = 0 s the impact of contact B adds 0.99 J, 33.1 % of the kinetic energy before it, "
        "by the restitution law newton.",
    )


@pytest.mark.slow
@pytest.mark.parametrize("law", ["energetic", "poisson"])
def test_same_impact_by_the_laws_of_a_path_loses_energy(law):
    run = block_falls(law)
    assert run.events_of("impact")
    assert run.energy_gains == run.notices == ()


def test_impact_of_one_contact_has_one_notice_for_all_its_phases():
    simulator = ps.Simulator(ps.model("rod"), ps.laws.rigid(restitution="newton", e=0.9))
    run = simulator.run(ROD, parameters={"mu": 0.827}, t_end=1e-3)
    jump = ps.evaluate_jump("rod", "newton", ROD, parameters={"mu": 0.827, "e_newton": 0.9})
    (gain,) = run.energy_gains
    assert gain.contacts == ("A",)
    assert gain.gain == pytest.approx(jump.energy_change, rel=1e-9)
    assert gain.kinetic_energy == pytest.approx(jump.kinetic_energy, rel=1e-12)
    assert run.notices == (jump.notice.replace("The", "At t = 0 s the"),)
    assert "of contact A adds" in jump.notice


def test_belt_that_drives_an_impact_is_no_gain():
    """The bead's kinetic energy grows by the work of the belt, not by that of the impact."""
    table = ps.load_mechanism("examples/mechanisms/oscillating-table.toml")
    run = ps.Simulator(table, ps.laws.rigid()).run({"y": 0.02, "x_dot": 0.1}, t_end=0.5)
    rows = [(a, b) for a, b in zip(run.events, run.events[1:], strict=False) if b.kind == "impact"]
    assert len(rows) > 2
    assert run.energy_gains == ()


def test_virgin_reloads_say_what_they_create_and_elastic_ones_nothing():
    start = {"theta": 0.5, "theta_dot": 1.0, "x_A_dot": -1.0}
    virgin = ps.simulate("rod", paper_law(reload="virgin"), start, t_end=0.0175)
    total = sum(gain.gain for gain in virgin.energy_gains)
    assert {gain.kind for gain in virgin.energy_gains} == {EventKind.RELOAD}
    assert total == pytest.approx(6.64e-6, rel=1e-3)
    # At a reload the loading curve has e² of its work stored: by hand, from the depth.
    law = ps.Simulator(ps.model("rod"), paper_law(reload="virgin"))
    constants = law.constants(virgin.parameters)
    curve = law.loading_curve({s: np.array([v]) for s, v in constants.items()})
    k, n = (float(v[0]) for v in curve)
    first = virgin.events_of("reload")[0]
    (top,) = [e for e in virgin.events_of("max_compression") if e.time < first.time]
    e2 = virgin.parameters["e_energetic"] ** 2
    depth = (first.compression - top.compression * (1 - e2)) / e2
    stored = [e2 * k * d ** (n + 1) / (n + 1) for d in (first.compression, depth)]
    assert virgin.energy_gains[0].gain == pytest.approx(stored[0] - stored[1], rel=1e-9)
    (notice,) = virgin.notices
    assert f"{len(virgin.energy_gains)} reloads create 6.64e-06 J" in notice
    assert "thermodynamically inadmissible" in notice
    elastic = ps.simulate("rod", "bilinear-hertz", start, t_end=0.0175)
    assert elastic.events_of("reload")
    assert elastic.energy_gains == ()


@settings(max_examples=25)
@given(
    st.floats(0.2, 1.4),
    st.floats(-2, 2),
    st.floats(-2, 2),
    st.floats(0.05, 1.5),
    st.floats(0, 1),
    st.sampled_from(["energetic", "poisson", "newton"]),
)
def test_what_runs_say_is_the_growth_of_the_energy(theta, slip, spin, mu, e, law):
    rod = ps.model("rod")
    start = {"theta": theta, "x_A_dot": slip, "theta_dot": spin, "y_A_dot": -1.0}
    run = ps.Simulator(rod, ps.laws.rigid(restitution=law, e=e)).run(
        start, parameters={"mu": mu}, t_end=1e-6, until="impact_end"
    )
    states = [dict.fromkeys(rod.state_names, 0.0) | start, run.final]
    before, after = (kinetic_energy(rod, state, run.parameters) for state in states)
    gained = sum(gain.gain for gain in run.energy_gains)
    assert gained == pytest.approx(max(0.0, after - before), abs=2e-9 * before)
    if law != "newton":
        assert run.notices == ()


@pytest.mark.slow
def test_gains_are_kept_by_files_and_not_by_ends(tmp_path):
    run = block_falls("newton")
    run.save(tmp_path / "run.npz")
    again = ps.Trajectory.load(tmp_path / "run.npz")
    assert again.energy_gains == run.energy_gains
    assert again.notices == run.notices
    assert block_falls("newton", record="events").notices == run.notices
    assert block_falls("newton", record="end").notices == ()


def test_many_gaining_impacts_are_summed_up():
    gains = [EnergyGain(k, EventKind.IMPACT, ("A",), 0.5, 2.0, "newton") for k in range(5)]
    sentences = notices(gains)
    assert len(sentences) == 4
    assert sentences[-1] == "2 more impacts add 1 J in all."


@pytest.mark.slow
def test_simulate_prints_and_lists_the_notice(capsys):
    words = ["simulate", "block-two-feet", "--law", "rigid", "--t-end", "1e-6"]
    words += ["--law-set", "restitution=newton,e_newton=0.9813", "--set", options(BLOCK)]
    words += ["--state", options(FALL)]
    assert main(words) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "the impact of contact B adds 0.99 J, 33.1 % of the kinetic energy before it" in text
    assert main([*words, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["notices"] == list(block_falls("newton").notices)
    (gain,) = data["energy_gains"]
    assert gain["contacts"] == ["B"]
    assert math.isclose(gain["gain"] / gain["kinetic_energy"], 0.331, abs_tol=5e-4)


def test_jump_prints_and_lists_the_notice(capsys):
    words = ["jump", "rod", "--rule", "newton", "--restitution", "0.9", "--set", "mu=0.827"]
    words += ["--state", options(ROD)]
    assert main(words) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "The impact of contact A adds 0.05" in text
    assert "can add energy where the slip stops" in text
    assert main([*words, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert len(data["notices"]) == 1
    assert data["energy_change"] > 0
    words[3] = "energetic"
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["notices"] == []
