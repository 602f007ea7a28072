"""The page's modules under Node: their own tests, and numbers equal to the package's to 1e-11."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from painleve_sym import InputError, classify, evaluate_jump, explore, law, model, region_map
from painleve_sym.errors import CompilerMissing
from painleve_sym.explorer.prebuilt import STORED, default_law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.motion.simulator import Simulator
from painleve_sym.problem.case_codes import LEGEND

WEB = Path(str(resources.files("painleve_sym.explorer").joinpath("web")))
NODE = shutil.which("node")
FILES = ("page.test.mjs", "drawings.test.mjs")
OWN = {
    file: len(re.findall(r"^test\(", Path(__file__).with_name(file).read_text("utf-8"), re.M))
    for file in FILES
}
TSC = Path(sys.prefix, "browser", "node_modules", "typescript", "bin", "tsc")
needs_node = pytest.mark.skipif(NODE is None, reason="Node is not installed (apt install nodejs)")

STARTS = {
    "rod": [
        ({"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}, {"E": 20.9e14}, None, 1e-3),
        ({"theta": 0.5, "theta_dot": 1.0, "x_A_dot": -1.0}, {}, None, 0.02),
        ({"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}, {"E": 20.9e16}, 350.0, 1e-3),
    ],
    "block-two-feet": [(None, {"mu_A": 0.5}, None, 0.01)],
    "painleve-klein": [(None, {}, None, 0.2)],
    # Later it yields with a velocity of zero, at a time that has half of the digits.
    "strut": [(None, {}, None, 0.006)],
}
VIRGIN = {"rod": [1]}
"""Starts that are followed with the reload rule of the paper."""
REFUSED = {
    "rod": [({"theta": -0.5}, None), ({"y_A": -0.1}, None), ({"y_A": -0.25}, 5.0)],
    "block-two-feet": [({"theta": -0.1}, None)],
    "painleve-klein": [({"phi": 1.0}, None)],
}
"""Changes of a start, and the initial force, that no motion of the page can begin with."""


def run_data(trajectory, moments):
    # The page names the contact of an event where there are several.
    several = len(trajectory.names.contacts) > 1
    return {
        "stop": trajectory.stop_reason.label,
        "residual": trajectory.energy_residual,
        "listed": [trajectory.events.index(e) for e in trajectory.events_above_tolerance],
        "events": [
            {
                "kind": str(e.kind),
                "time": e.time,
                "contact": (e.contact or "") * several,
                "state": e.state,
            }
            for e in trajectory.events
        ],
        "moments": [
            {
                "time": t,
                "state": dict(zip(trajectory.state_names, trajectory(t)[0].tolist(), strict=True)),
                "outputs": {k: v.item() for k, v in trajectory.outputs(t).items() if "force" in k},
            }
            for t in moments
        ],
    }


def refusal(simulators, state, change, force):
    """Return what the package says of a start, for the first motion that rejects it."""
    for i, simulator in enumerate(simulators):
        try:
            place = simulator.at({**state, **change})
            simulator.start(place, None if simulator.rigid else force)
        except InputError as error:
            return {"change": change, "force": force, "motion": i, "message": str(error)}
    raise AssertionError(f"not rejected: {change}")


def case_data(name, index, start, given, force, end):
    mechanism = model(name)
    data = explore(name).data
    description = data["description"]
    reload = "virgin" if index in VIRGIN.get(name, ()) else "elastic"
    own_law = default_law(mechanism)
    if "reload" in own_law.choices:
        own_law = law(own_law.name, reload=reload)
    values = {q["name"]: q["value"] for q in (*description["states"], *description["parameters"])}
    values |= (dict.fromkeys(mechanism.state_names, 0.0) if start else {}) | (start or {}) | given
    state = {n: values[n] for n in mechanism.state_names}
    own = {n: values[n] for n in mechanism.parameters}
    contact = mechanism.outline.contacts[0]
    alone = mechanism.only(contact.name) if len(mechanism.outline.contacts) > 1 else mechanism
    # The motions in their order: with the law of the page, then rigid.
    simulators = [Simulator(mechanism, own_law)]
    if not simulators[0].rigid:
        simulators.append(Simulator(mechanism, RigidLaw()))
    moments = np.linspace(0, end, 7)[1:-1].tolist()
    runs, largest = [], 1.0
    for simulator in simulators:
        names = {p.name for p in (*mechanism.outline.parameters, *simulator.own_parameters)}
        options = {"initial_force": force} if not simulator.rigid else {}
        parameters = {n: values[n] for n in names}
        run = simulator.run(state, t_end=end, parameters=parameters, **options)
        runs.append(run_data(run, [t for t in moments if t < run.final_time]))
        outputs = [v for m in runs[-1]["moments"] for v in m["outputs"].values()]
        largest = max(largest, *map(abs, outputs))
    at = classify(alone, state, parameters=own)
    problem = {"B": at.B, "A_stick": at.A_stick, "B_stick": at.B_stick}
    problem |= {"A_neg": at.problem.A_slip(-1), "A_pos": at.problem.A_slip(1)}
    over = tuple(description["over"])
    grid = region_map(
        alone,
        over,
        points=15,
        slip=int(at.coefficients[0].direction[0]),
        state={n: v for n, v in state.items() if n not in over},
        parameters={n: v for n, v in own.items() if n not in over},
    )
    words = {code: word for word, code in LEGEND.items()}
    if at.case.value == "inconsistent":
        runs[-1]["after"] = dict(evaluate_jump(mechanism, "energetic", state).velocity)
    return {
        "name": f"{name} {start or 'start'}",
        "module": data["module"],
        "reload": reload,
        "refused": [refusal(simulators, state, *change) for change in REFUSED.get(name, ())],
        "description": description,
        "values": values,
        "force": force,
        "contact": 0,
        "options": {"end": end, "rtol": 1e-11, "maxSteps": 100000, "maxEvents": 10000},
        "problem": problem,
        "case": at.case.value,
        "forces": sorted(s.normal_force for s in at.solutions),
        "force_scale": largest,
        "runs": runs,
        "maps": [
            {
                "over": over,
                "ranges": [[float(v[0]), float(v[-1])] for v in grid.values],
                "points": 15,
                "slip": int(at.coefficients[0].direction[0]),
                "cases": [[words[int(c)] for c in row] for row in grid.case],
            }
        ],
    }


def run_node(file, count, **environment):
    """Run the tests of the modules; all of them must pass."""
    done = subprocess.run(
        [NODE, "--test", str(Path(__file__).with_name(file))],
        env={**os.environ, "EXPLORER_WEB": str(WEB), **environment},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-8000:] + done.stderr[-2000:]
    assert f"# pass {count}\n" in done.stdout
    assert "# skipped 0\n" in done.stdout


@needs_node
@pytest.mark.parametrize("file", FILES)
def test_modules_pass_their_own_tests(file):
    run_node(file, OWN[file])


@needs_node
@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=() if n == STORED else pytest.mark.slow) for n in STARTS],
)
def test_modules_compute_the_numbers_of_the_package(name, tmp_path):
    try:
        cases = [case_data(name, i, *start) for i, start in enumerate(STARTS[name])]
    except CompilerMissing as error:
        pytest.skip(str(error))
    file = tmp_path / "cases.json"
    file.write_text(json.dumps(cases), "utf-8")
    run_node(FILES[0], OWN[FILES[0]] + len(cases), EXPLORER_CASES=str(file))


@needs_node
@pytest.mark.skipif(not TSC.is_file(), reason="typescript is not installed: `make setup-browser`")
def test_types_in_the_comments_of_the_modules_hold(pytestconfig):
    options = "--noEmit --allowJs --checkJs --strict --target es2022 --module es2022"
    options += " --moduleResolution bundler --lib es2023,dom,dom.iterable"
    # The libraries of TypeScript are not checked, and modules that did not change are not again.
    record = pytestconfig.cache.mkdir("typescript") / "checked.json"
    options += f" --skipLibCheck --incremental --tsBuildInfoFile {record}"
    done = subprocess.run(
        [NODE, TSC, *options.split(), *sorted(WEB.glob("*.js"))],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout
