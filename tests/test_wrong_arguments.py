"""Arguments of the wrong type: every public function rejects them in one sentence of its own."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.checks import by_name, names_of, text_of, whole_number
from painleve_sym.errors import InputError, PainleveError
from painleve_sym.files import file_path
from painleve_sym.study import RegionMap, read_fit_data

STATE = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
T_END = 1e-5


@functools.cache
def rod():
    return ps.models.rod(mu=1.5)


@functools.cache
def simulator():
    return ps.Simulator(rod(), ps.laws.hertz())


@functools.cache
def run():
    return simulator().run(STATE, t_end=T_END)


@functools.cache
def batch():
    return ps.simulate_batch("rod", "hertz", {**STATE, "theta": [0.9, 1.0]}, t_end=T_END)


def motion(**options):
    """Integrate with the law that the other cases share."""
    given = {"mechanism": "rod", "law": "hertz", "state": STATE, "t_end": T_END} | options
    return ps.simulate(**given)


# What is called, and the arguments that are replaced one after the other. Calls that are slow or
# write a file are only made with wrong arguments.
CALLS = {
    "classify": (ps.classify, {"mechanism": rod, "state": STATE, "parameters": {}, "close": ""}),
    "simulate": (motion, {"mechanism": rod, "law": "hertz", "state": STATE, "t_end": T_END}),
    "options": (motion, dict.fromkeys(("until", "material", "initial_force", "close", "engine"))),
    "accuracy": (motion, dict.fromkeys(("rtol", "record", "first_step", "max_step"))),
    "bounds": (motion, dict.fromkeys(("max_steps", "max_events", "atol"))),
    "parameters": (motion, dict.fromkeys(("parameters", "law_parameters"))),
    "simulate_batch": (
        functools.partial(ps.simulate_batch, t_end=T_END),
        {"mechanism": rod, "law": "hertz", "states": STATE, "parameters": {}},
    ),
    "Simulator": (ps.Simulator, {"mechanism": rod, "law": "hertz", "engine": "auto"}),
    "sensitivities": (
        lambda **given: simulator().sensitivities(t_end=T_END, **given),
        {"state": STATE, "wrt": "mu"},
    ),
    "jump": (ps.evaluate_jump, {"mechanism": rod, "restitution": "newton", "state": STATE}),
    "corrected jump": (
        functools.partial(ps.evaluate_corrected_jump, rod),
        {"law": "bilinear-hertz", "state": STATE},
    ),
    "solve_impact": (
        ps.solve_impact,
        {"W": np.eye(2), "mu": 0.5, "velocity": (-1, 1), "restitution": "newton", "e": 0.5},
    ),
    "critical_force": (ps.critical_force, {"mechanism": rod, "law": "hertz", "state": STATE}),
    "region_map": (
        functools.partial(ps.region_map, points=6),
        {"mechanism": rod, "over": "theta,mu", "ranges": None, "state": None, "parameters": None},
    ),
    "region_map of": (
        functools.partial(ps.region_map, "rod", "theta,mu"),
        {"points": 6, "slip": 1, "close": ""},
    ),
    "compare": (
        functools.partial(ps.compare, steps=(1e-3,), stiffness=(20.9e14,)),
        {"mechanism": rod, "state": STATE},
    ),
    "fit": (functools.partial(ps.fit, rod), {"law": "hertz", "data": "no.csv", "estimate": "mu"}),
    "sweep": (functools.partial(ps.sweep, out="no.npz"), {"source": "no.toml"}),
    "explore": (functools.partial(ps.explore, "rod"), {"state": None}),
    "export_c": (functools.partial(ps.export_c, "rod", "hertz"), {"folder": Path("/dev/null/a")}),
    "reproduce": (ps.reproduce, {"only": "eq-1", "paper": "none"}),
    "model": (ps.model, {"name": "rod"}),
    "law": (ps.law, {"name": "hertz"}),
    "rigid": (ps.laws.rigid, {"restitution": "newton", "e": 0.5, "policy": "slip"}),
    "hertz": (ps.laws.hertz, {"E": 1e9}),
    "rod": (ps.models.rod, {"mu": 0.5}),
    "load_mechanism": (ps.load_mechanism, {"path": "no.toml"}),
    "material": (ps.material, {"name": "steel"}),
    "closed_forms": (ps.closed_forms, {"mechanism": rod}),
    "citation": (lambda of: ps.citation(of), {"of": rod}),
    "read_fit_data": (lambda path: read_fit_data(path, rod()), {"path": "no.csv"}),
    "with_parameters": (lambda mu: rod().with_parameters(mu=mu), {"mu": 0.5}),
    "only": (lambda name: rod().only(name), {"name": "A"}),
    "run()": (lambda t: run()(t), {"t": 0.0}),
    "run[]": (lambda name: run()[name], {"name": "theta"}),
    "values": (lambda **given: run().values(**given), {"name": "theta", "t": 0.0}),
    "state": (lambda t: run().state(t), {"t": 0.0}),
    "outputs": (lambda t: run().outputs(t), {"t": 0.0}),
    "sample": (lambda n: run().sample(n), {"n": 5}),
    "units": (lambda name: run().units(name), {"name": "theta"}),
    "events_of": (lambda kind: run().events_of(kind), {"kind": "slip_stop"}),
    "to_dataframe": (lambda names: run().to_dataframe(names), {"names": "theta"}),
    "to_xarray": (lambda names: run().to_xarray(names), {"names": "theta"}),
    "plot": (lambda **given: run().plot(**given), {"quantities": "theta", "ax": None, "width": 3}),
    "animate": (lambda mechanism: run().animate(mechanism), {"mechanism": "x.avi"}),
    "save": (lambda path: run().save(path), {"path": "/dev/null/a.npz"}),
    "load": (ps.Trajectory.load, {"path": "no.npz"}),
    "batch[]": (lambda name: batch()[name], {"name": "theta"}),
    "batch frame": (lambda names: batch().to_dataframe(names), {"names": "theta"}),
    "batch xarray": (lambda names: batch().to_xarray(names), {"names": "theta"}),
    "map load": (RegionMap.load, {"path": "no.npz"}),
}


def wrong_values():
    """Return values that fit hardly anywhere."""
    return [
        *(3.5, -1, 0, True, float("nan"), "nonsense", "", b"x", [1.0, 2.0], ["a"], (), object()),
        *({"theta": "x"}, {"theta": None}, {1: 2}, np.zeros(3), np.zeros((0, 2))),
        *(Path("none.toml"), rod(), run(), ps.laws.hertz()),
    ]


@pytest.mark.parametrize("name", CALLS)
def test_argument_of_a_wrong_type_is_one_clear_sentence(tmp_path, monkeypatch, name):
    """Values that fit are taken: a name, a number, an empty choice."""
    monkeypatch.chdir(tmp_path)
    call, arguments = CALLS[name]
    given = {k: v() if v is rod else v for k, v in arguments.items() if v is not None}
    for replaced in arguments:
        for value in wrong_values():
            try:
                call(**(given | {replaced: value}))
            except PainleveError as error:
                assert ": " in str(error) and len(str(error)) < 2500


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (
            lambda: ps.classify("rod", [0, 0, 1]),
            r"state of 'rod': got list \[0, 0, 1\], need a mapping of names to numbers, such as "
            r"{'x_A': 1\.0}, or 6 numbers in the order x_A, y_A, theta, x_A_dot, y_A_dot, theta_",
        ),
        (
            lambda: ps.simulate("rod", STATE, "hertz", t_end=1),
            r"contact law: got dict .* need a law, its name, or one of these for each contact\. "
            r"Fix: the order is mechanism, law, state\.",
        ),
        (lambda: run().animate("x.avi"), r"animation: mechanism: got 'x\.avi', need a Mechanism\."),
        (lambda: run().plot("x.png"), r"got 'x\.png'\. Fix: to write a file, plot\(\)\.savefig"),
        (lambda: motion(rtol=0), r"rtol: got 0, need a finite number >= 1e-15 and < 1\."),
        (
            lambda: motion(t_end="soon"),
            r"t_end: got 'soon', need a number in s, or a number with a unit",
        ),
        (lambda: motion(max_steps=1.5), r"max_steps: got 1\.5, need a whole number from 1 to"),
        (lambda: motion(atol=[1e-9, 1e-9]), r"atol: got list .* need 8 numbers >= 0, one for each"),
        (lambda: motion(parameters=[1.5]), r"parameters: got list \[1\.5\], need a mapping of"),
        (lambda: run().events_of("slip_stopp"), r"kind of event 'slip_stopp'\. Did you mean"),
        (lambda: ps.evaluate_jump("rod", 0.5, STATE), r"unknown restitution law '0\.5'"),
        (lambda: batch().to_xarray("theta", dims="a,b"), r"dims: got 2 names, need 1, one for"),
    ],
)
def test_mistake_is_answered_with_the_remedy(call, sentence):
    with pytest.raises(InputError, match=sentence):
        call()


def test_image_is_no_trajectory(tmp_path):
    (tmp_path / "impact.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    with pytest.raises(InputError, match="not readable") as error:
        ps.Trajectory.load(tmp_path / "impact.png")
    assert "pickle" not in str(error.value)


def test_no_warning_comes_before_the_sentence(recwarn):
    with pytest.raises(InputError):
        motion(rtol=0)
    assert len(recwarn) == 0


def test_names_are_texts_with_commas_or_sequences():
    both = [ps.region_map("rod", over, points=6).over for over in ("theta,mu", ("theta", "mu"))]
    assert both == [("theta", "mu")] * 2
    assert run().to_dataframe("theta, normal_force").columns.tolist() == ["theta", "normal_force"]
    assert names_of("", "x") == () and names_of(["a"], "x") == ("a",)


def test_scalar_tolerance_counts_for_every_state():
    exact, same = (motion(atol=atol, rtol=1e-9) for atol in (1e-12, [1e-12] * 8))
    np.testing.assert_array_equal(exact.final_state, same.final_state)


def test_simulator_takes_names_and_files():
    named = ps.Simulator("rod", "hertz", engine="compiled")
    assert named.mechanism.name == "rod" and named.law.name == "hertz"
    assert named.engine is ps.EngineName.COMPILED
    feet = ps.Simulator("block-two-feet", {"A": "hertz", "B": ps.laws.rigid()})
    assert [law.name for law in feet.laws] == ["hertz", "rigid"]
    same = named.run(STATE, t_end=T_END).final_state
    np.testing.assert_array_equal(same, motion(engine="compiled").final_state)


def test_checks_return_what_they_take():
    assert by_name(None, "x") == {} and by_name({"a": 1}, "x") == {"a": 1}
    assert text_of("a", "x") == "a" and file_path(Path("a"), "x") == file_path("a", "x")
    assert whole_number(np.int64(3), "n", where="x", lower=1, upper=5) == 3
    for wrong in (True, 3.0, "3", None, 6):
        with pytest.raises(InputError, match=r"x: n: got .*, need a whole number from 1 to 5"):
            whole_number(wrong, "n", where="x", lower=1, upper=5)
