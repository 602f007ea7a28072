"""Results of runs: short texts, tables, notebooks, pickles and files."""

from __future__ import annotations

import concurrent.futures
import json
import multiprocessing
import pickle
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.codegen.tape import Tape, TapeOutputs
from painleve_sym.errors import InputError
from painleve_sym.laws import LawsByContact
from painleve_sym.mechanics.declarations import with_fields
from painleve_sym.mechanics.models import MODELS
from tests.languages import HOSTILE, html_faults
from tests.support.paper_law import paper_law

ROOT = Path(__file__).parents[2]
START = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
STIFF = {"E": 20.9e14}


@pytest.fixture(scope="module")
def impact():
    return ps.simulate("rod", paper_law(), START, t_end=1e-3, law_parameters=STIFF)


@pytest.fixture(scope="module")
def batch():
    states = {"theta": np.array([0.9, 1.0, 1.1])[:, None], "theta_dot": 1.0, "x_A_dot": -1.0}
    friction = {"mu": np.array([1.4, 1.5])}
    law = ps.laws.bilinear_hertz(E=20.9e14)
    return ps.simulate_batch("rod", law, states, parameters=friction, t_end=1e-3, events=2)


def test_texts_of_results_are_one_short_line(impact, batch):
    text = repr(impact)
    assert text.startswith(
        "Trajectory of 'rod' with law 'bilinear-hertz', reload elastic: 5 events"
    )
    assert "end at t = 0.001 s (t_end)" in text
    assert repr(batch) == "BatchResult of 'rod' with law 'bilinear-hertz', shape (3, 2): 6 t_end"
    simulator = ps.Simulator(ps.models.rod(), ps.laws.rigid())
    for result in (impact, batch, simulator, simulator.mechanism, ps.classify("rod", START)):
        assert len(repr(result)) < 300 and "\n" not in repr(result)


def results():
    """Return a result of every kind that a person prints."""
    rod, law = ps.models.rod(mu=1.5), ps.laws.bilinear_hertz(E=20.9e14)
    critical = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
    jump, classified = ps.evaluate_jump(rod, "energetic", START), ps.classify(rod, critical)
    impact = ps.solve_impact(np.eye(2), 0.5, (-1.0, 1.0), e=0.5)
    robot = ps.robot(ROOT / "examples/robots/quadruped.urdf")
    feet = robot.contact(["LF_foot", "RH_foot"], pose="standing", others="stuck")
    return [
        *(
            robot,
            robot.tree,
            feet,
            feet.risk(),
            feet.risk(2.5),
            ps.contact(np.eye(3), (1, 0, 0), 1.0),
        ),
        LawsByContact({"A": law, "B": ps.laws.rigid()}),
        ps.classify("rod-3d", {"theta": 0.5, "x_A_dot": -1.0}),
        *(rod, law, ps.laws.rigid(), ps.Simulator(rod, law), rod.contact, ps.material("steel")),
        *(classified, *classified.solutions, jump, *jump.phases, impact),
        ps.classify("block-two-feet", {"x_A_dot": -1.0}),
        ps.classify("block-two-feet", {"x_A_dot": -1.0, "theta": 0.1}, close="A:y_A"),
        ps.simulate(rod, law, START, t_end=1e-3).events[0],
        ps.region_map(rod, "theta,mu", points=20),
        ps.critical_force(rod, law, critical),
        ps.evaluate_corrected_jump(rod, law, START),
    ]


def test_every_result_is_one_short_line_and_html():
    for result in results():
        assert len(repr(result)) < 200 and "\n" not in repr(result), result
        assert type(result).__name__ in repr(result)
        if not hasattr(result, "_repr_html_"):
            continue
        root = ElementTree.fromstring(f"<div>{result._repr_html_()}</div>")
        assert root.findtext("p") == repr(result)
        assert root.find("table") is not None or root.find("{*}svg") is not None
        assert all(not name.startswith("_") for name in dir(result))
        assert not {"deferred", "record", "subject", "evaluator"} & set(dir(result))


def test_html_of_results_has_their_numbers():
    classified = ps.classify(ps.models.rod(mu=1.5), {**START, "theta_dot": 5.0})
    root = ElementTree.fromstring(f"<div>{classified._repr_html_()}</div>")
    cells = [cell.text for cell in root.iter("td")]
    assert cells[:3] == ["1", "A", "liftoff"]
    assert f"{classified.solutions[1].normal_force:.6g}" in cells
    page = ps.models.rod(mu=1.5)._repr_html_()
    assert "<td>mu</td><td>1.5</td>" in page and "position of the end A along the ground" in page
    jump = ps.evaluate_jump("rod", "energetic", START)
    after = f"{jump.velocity['y_A_dot']:.6g}"
    assert f"<td>y_A_dot</td><td>0</td><td>{after}</td>" in jump._repr_html_()


def test_html_of_a_hostile_mechanism_is_text():
    text = " ".join(HOSTILE)
    page = with_fields(ps.models.rod(), name=text, title=text)._repr_html_()
    assert html_faults(page) == []


def test_states_and_outputs_by_name_are_those_at_the_times_of_the_steps(impact):
    assert impact.t[0] == 0.0 and impact.t[-1] == impact.final_time
    assert impact["time"] is impact.t
    np.testing.assert_array_equal(impact["theta"], impact(impact.t)[:, 2])
    np.testing.assert_array_equal(impact["normal_force"], impact.outputs(impact.t)["normal_force"])
    assert impact.units("theta_dot") == "rad/s" and impact.units("E") == "Pa"
    with pytest.raises(InputError, match=r"unknown quantity 'thata'\. Did you mean 'theta'"):
        impact["thata"]


def test_notebooks_get_a_table_and_a_figure(impact):
    page = impact._repr_html_()
    root = ElementTree.fromstring(f"<div>{page}</div>")
    rows = root.findall("table//tr")
    assert len(rows) == 1 + len(impact.events)
    cells = [cell.text for cell in rows[1]]
    assert cells[1:3] == ["slip_stop", "A"] and float(cells[0]) == pytest.approx(4.088624e-4)
    assert root.find("{http://www.w3.org/2000/svg}svg") is not None
    assert page == impact._repr_html_()


def test_a_long_run_is_cut_in_a_notebook_and_says_so():
    bouncing = ps.simulate("rod", "rigid", {"y_A": 0.2, "theta": 1.5}, t_end=1.5)
    page = bouncing._repr_html_()
    assert f"{len(bouncing.events) - 12} more events." in page
    ended = ps.simulate("rod", "rigid", {"y_A": 0.2, "theta": 1.5}, t_end=0.1, record="end")
    assert "No events." in ended._repr_html_() and "<svg" not in ended._repr_html_()


def test_a_names_markup_is_text_in_a_notebook(impact):
    from dataclasses import replace

    named = replace(impact, names=replace(impact.names, mechanism="<script>rod"))
    assert "<script>" not in named._repr_html_() and "&lt;script&gt;rod" in named._repr_html_()


def test_table_of_a_motion_has_its_units(impact):
    frame = impact.to_dataframe(["theta", "normal_force"], times=[0.0, 1e-4, 5e-4])
    assert frame.attrs["units"] == {"time": "s", "theta": "rad", "normal_force": "N"}
    np.testing.assert_array_equal(
        frame["normal_force"], impact.outputs([0.0, 1e-4, 5e-4])["normal_force"]
    )
    assert list(impact.to_dataframe().columns) == [*impact.state_names, *impact.output_names]
    with pytest.raises(InputError, match="unknown quantity 'mass'"):
        impact.to_dataframe(["mass"])


def test_labelled_arrays_of_a_motion(impact):
    data = impact.to_xarray(["theta", "gap"])
    assert data.time.attrs["units"] == "s" and data.gap.attrs["units"] == "m"
    assert data.attrs["mechanism"] == "rod"
    np.testing.assert_array_equal(data.theta.values, impact["theta"])


def again_from(attributes):
    """Return the motion that the attributes of labelled arrays say."""
    law = ps.law(attributes["law"], **json.loads(attributes["law_choices"]))
    tables = {name: json.loads(attributes[name]) for name in ("state", "parameters", "options")}
    options = tables.pop("options")
    return ps.simulate(attributes["mechanism"], law, **tables, **options)


@pytest.mark.parametrize(
    ("mechanism", "law", "state", "options"),
    [
        (
            ps.models.rod(mu=1.5),
            ps.laws.bilinear_hertz(E=20.9e14, reload="virgin"),
            START,
            {"t_end": 1e-3, "until": "separation", "rtol": 1e-10},
        ),
        (
            "rod",
            "bilinear-hertz",
            START,
            {"t_end": 1e-4, "initial_force": 100.0, "engine": "compiled"},
        ),
        (
            "block-two-feet",
            {"A": "hertz", "B": "rigid"},
            {"y_A": 0.001, "x_A_dot": -0.1},
            {"t_end": 0.02, "max_step": 1e-3},
        ),
    ],
    ids=["virgin", "pressed", "mixed"],
)
def test_netcdf_file_of_a_motion_computes_it_again(tmp_path, mechanism, law, state, options):
    import xarray

    run = ps.simulate(mechanism, law, state, **options)
    run.save(tmp_path / "run.npz")
    for number, motion in enumerate((run, ps.Trajectory.load(tmp_path / "run.npz"))):
        path = tmp_path / f"run{number}.nc"
        motion.to_xarray().to_netcdf(path, engine="h5netcdf")
        about = xarray.open_dataset(path, engine="h5netcdf").attrs
        assert about["version"] == ps.__version__
        assert about["stop_reason"] == run.stop_reason.label and run.source == about["sources"]
        again = again_from(about)
        np.testing.assert_array_equal(again.final_state, run.final_state)
        assert (again.t.tolist(), again.inputs) == (run.t.tolist(), run.inputs)


def test_labelled_arrays_of_a_batch_name_what_does_not_vary(batch):
    about = batch.to_xarray(["time"]).attrs
    tables = {name: json.loads(about[name]) for name in ("state", "parameters", "options")}
    assert {n: v for n, v in tables["state"].items() if v} == {"theta_dot": 1.0, "x_A_dot": -1.0}
    assert "theta" not in tables["state"] and tables["parameters"]["E"] == 20.9e14
    assert "mu" not in tables["parameters"] and tables["options"]["t_end"] == 1e-3
    assert (about["law"], about["version"]) == ("bilinear-hertz", ps.__version__)


def test_a_library_that_is_not_installed_is_named(impact, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with pytest.raises(InputError, match=r"a data frame needs pandas\. Fix: pip install"):
        impact.to_dataframe()


def test_batches_keep_the_varied_inputs_as_coordinates(batch):
    data = batch.to_xarray(["theta_dot", "time_of_slip_stop"])
    assert dict(data.sizes) == {"start_theta": 3, "mu": 2}
    assert data.mu.values.tolist() == [1.4, 1.5] and data.mu.attrs["units"] == "1"
    one = data.sel(mu=1.5, start_theta=1.0)
    alone = ps.simulate(ps.models.rod(mu=1.5), ps.laws.bilinear_hertz(E=20.9e14), START, t_end=1e-3)
    assert float(one.theta_dot) == alone.final["theta_dot"]
    frame = batch.to_dataframe(["theta_dot"])
    assert frame.columns.tolist() == ["start_theta", "mu", "theta_dot"]
    row = frame[(frame.mu == 1.5) & (frame.start_theta == 1.0)]
    assert float(row.theta_dot.iloc[0]) == alone.final["theta_dot"]
    with pytest.raises(InputError, match="times_of_slip_stop has several numbers per motion"):
        batch.to_dataframe(["times_of_slip_stop"])


def test_inputs_that_vary_together_share_a_dimension():
    states = {"theta": [0.9, 1.0], "theta_dot": [1.0, 1.1], "x_A_dot": -1.0}
    runs = ps.simulate_batch("rod", "bilinear-hertz", states, t_end=1e-4)
    data = runs.to_xarray(["time"])
    assert dict(data.sizes) == {"row": 2}
    assert data.start_theta_dot.values.tolist() == [1.0, 1.1]


@pytest.mark.parametrize(
    ("mechanism", "law", "state"),
    [
        ("rod", "bilinear-hertz", START),
        ("rod", "rigid", {"y_A": 0.1, "theta": 1.0}),
        ("block-two-feet", {"A": "hertz", "B": "rigid"}, {"y_A": 0.001}),
        ("painleve-klein", "rigid", {"phi": 1.2, "x_dot": 1.0}),
    ],
)
def test_saved_and_pickled_runs_give_forces_without_their_engine(mechanism, law, state, tmp_path):
    run = ps.simulate(mechanism, law, state, t_end=0.02)
    run.save(tmp_path / "run.npz")
    times = run.sample(40)
    for again in (ps.Trajectory.load(tmp_path / "run.npz"), pickle.loads(pickle.dumps(run))):
        assert isinstance(again.evaluator, TapeOutputs)
        assert [e.kind for e in again.events] == [e.kind for e in run.events]
        for name, values in run.outputs(times).items():
            scale = np.max(np.abs(values))
            np.testing.assert_allclose(
                again.outputs(times)[name], values, rtol=0, atol=1e-14 * scale
            )
        assert again.energy_residual == pytest.approx(run.energy_residual, abs=1e-14)
        assert again.plot().axes
        again.save(tmp_path / "again.npz")


def forces_of(run):
    return run.outputs(run.sample(5))["normal_force"]


def run_once(simulator):
    return simulator.run(START, t_end=1e-3)


@pytest.mark.slow
def test_results_pass_between_processes(impact, batch):
    simulator = ps.Simulator(ps.models.rod(mu=1.5), ps.laws.bilinear_hertz(E=20.9e14))
    derivatives = simulator.sensitivities(START, ["mu"], t_end=4e-4)
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
        forces = pool.submit(forces_of, impact).result(timeout=120)
        elsewhere = pool.submit(run_once, simulator).result(timeout=120)
        rows = pool.submit(final_angles, batch).result(timeout=120)
        slopes = pool.submit(gradient_of, derivatives).result(timeout=120)
    np.testing.assert_allclose(forces, forces_of(impact), rtol=1e-14)
    np.testing.assert_array_equal(elsewhere.final_state, run_once(simulator).final_state)
    np.testing.assert_array_equal(rows, batch["theta"])
    expected = gradient_of(derivatives)
    np.testing.assert_allclose(slopes, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


def final_angles(runs):
    return runs["theta"]


def gradient_of(derivatives):
    return derivatives.gradient("normal_force", [1e-4, 3e-4])


@pytest.mark.parametrize("name", MODELS)
def test_mechanisms_and_simulators_pickle(name):
    mechanism = pickle.loads(pickle.dumps(ps.model(name)))
    assert mechanism.definition == ps.model(name).definition
    simulator = ps.Simulator(mechanism, ps.law("rigid"))
    assert pickle.loads(pickle.dumps(simulator)).label == "rigid"


def test_results_pass_through_dask(impact):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            1, threads_per_worker=1, processes=False, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        np.testing.assert_allclose(
            client.submit(forces_of, impact).result(timeout=60), forces_of(impact)
        )


@pytest.mark.parametrize(
    "change",
    [
        {"operations": [["EXEC", 0, 1]]},
        {"operations": [["INPUT", 0, 0, 99]]},
        {"operations": [["ADD", 0, 1, 10**9]]},
        {"operations": [["CONST", 0, "1"]]},
        {"operations": [["SIN", 0, 1.5]]},
        {"work": -1},
        {"sizes": "abc"},
        {"operations": 5},
    ],
)
def test_damaged_operations_are_rejected(change):
    data = {
        "sizes": [1],
        "outputs": 1,
        "work": 2,
        "operations": [["INPUT", 0, 0, 0], ["OUTPUT", 0, 0]],
    }
    assert Tape.of_data(data)(np.array([[2.0]])).tolist() == [[2.0]]
    with pytest.raises(InputError, match="formulas as operations"):
        Tape.of_data(data | change)


@pytest.mark.parametrize(
    ("law", "name"),
    [
        *(("rigid", name) for name in ("rod", "strut", "block-two-feet", "painleve-klein")),
        *(("bilinear-hertz", name) for name in ("rod", "strut")),
        pytest.param("rigid", "two-link-arm", marks=pytest.mark.slow),
        pytest.param("bilinear-hertz", "two-link-arm", marks=pytest.mark.slow),
        pytest.param("bilinear-hertz", "block-two-feet", marks=pytest.mark.slow),
    ],
)
def test_operations_are_those_of_the_engine(name, law):
    simulator = ps.Simulator(ps.model(name), ps.law(law))
    engine, tapes = simulator.integrator, simulator.output_tapes
    rng = np.random.default_rng(3)
    outline = simulator.outline
    modes = rng.integers(0, len(outline.modes), 50)
    states = rng.uniform(0.1, 0.9, (50, len(outline.state_names)))
    memory = rng.uniform(0.1, 0.9, (50, len(outline.memory_names)))
    constants = engine.constants(rng.uniform(0.1, 0.4, len(outline.parameter_names)))
    expected = engine.outputs(modes, states, memory, constants)
    result = tapes.outputs(modes, states, memory, constants)
    np.testing.assert_allclose(result, expected, rtol=1e-12)


def test_closed_forms_are_equations_in_a_notebook():
    energies, *_ = ps.closed_forms(ps.models.rod())
    kinetic = next(f for f in energies.formulas if f.name == "T")
    assert repr(kinetic) == "Formula 'T' [J]: kinetic energy"
    equation = kinetic._repr_latex_()
    assert equation.startswith(r"$\displaystyle T = ") and r"\dot{x}_{A}" in equation
    page = energies._repr_latex_()
    assert page.count("&=") == len(energies.formulas) and page.count("{") == page.count("}")
    assert repr(energies).startswith("Section 'energies': T, V")


def test_events_are_a_table():
    pytest.importorskip("pandas", reason="needs the extra cluster (pandas)")
    run = ps.simulate("rod", "bilinear-hertz", {"theta": 1.0, "x_A_dot": -1.0}, t_end=5e-3)
    frame = run.events_to_dataframe()
    assert len(frame) == len(run.events) > 2
    for row, event in zip(frame.itertuples(), run.events, strict=True):
        assert (row.time, row.kind, row.contact) == (event.time, str(event.kind), event.contact)
        assert row.normal_force == event.normal_force and row.theta == event.state["theta"]
    assert frame.attrs["units"]["normal_force"] == "N" and frame.attrs["units"]["time"] == "s"
    empty = ps.simulate("rod", "rigid", {"y_A": 1.0, "theta": 1.0}, t_end=0.1)
    assert empty.events_to_dataframe().empty
