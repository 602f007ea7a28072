"""The page's modules under Node: their own tests, and numbers equal to the package's to 1e-12."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import sys
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from painleve_sym import classify, evaluate_jump, model, region_map
from painleve_sym.explorer.prebuilt import default_law, stored_module
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.maps.case_codes import LEGEND

WEB = Path(str(resources.files("painleve_sym.explorer").joinpath("web")))
NODE = shutil.which("node")
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
    "strut": [(None, {}, None, 0.01)],
}
OUTSIDE = {"rod": {"theta": -0.5}}


def run_data(trajectory, moments):
    # The page names the contact of an event where there are several.
    several = len(trajectory.names.contacts) > 1
    return {
        "stop": trajectory.stop_reason.label,
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


def case_data(name, start, given, force, end):
    mechanism = model(name)
    packed, description = stored_module(mechanism, default_law(mechanism))
    values = {q["name"]: q["value"] for q in (*description["states"], *description["parameters"])}
    values |= (dict.fromkeys(mechanism.state_names, 0.0) if start else {}) | (start or {}) | given
    state = {n: values[n] for n in mechanism.state_names}
    own = {n: values[n] for n in mechanism.parameters}
    contact = mechanism.outline.contacts[0]
    alone = mechanism.only(contact.name) if len(mechanism.outline.contacts) > 1 else mechanism
    # The motions in their order: with the law of the page, then rigid.
    simulators = [Simulator(mechanism, default_law(mechanism))]
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
        slip=int(at.slip),
        state={n: v for n, v in state.items() if n not in over},
        parameters={n: v for n, v in own.items() if n not in over},
    )
    words = {code: word for word, code in LEGEND.items()}
    if at.case.value == "inconsistent":
        runs[-1]["after"] = dict(evaluate_jump(mechanism, "energetic", state).velocity)
    return {
        "name": f"{name} {start or 'start'}",
        "module": base64.b64encode(packed).decode(),
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
                "slip": int(at.slip),
                "cases": [[words[int(c)] for c in row] for row in grid.case],
            }
        ],
        "outside": OUTSIDE.get(name),
    }


@needs_node
@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
def test_modules_pass_their_tests_and_compute_the_packages_numbers(tmp_path):
    cases = [case_data(name, *start) for name, starts in STARTS.items() for start in starts]
    file = tmp_path / "cases.json"
    file.write_text(json.dumps(cases), "utf-8")
    done = subprocess.run(
        [NODE, "--test", str(Path(__file__).with_name("page.test.mjs"))],
        env={**os.environ, "EXPLORER_WEB": str(WEB), "EXPLORER_CASES": str(file)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-8000:] + done.stderr[-2000:]
    assert f"# pass {8 + len(cases)}\n" in done.stdout
    assert "# skipped 0\n" in done.stdout


@needs_node
@pytest.mark.skipif(not TSC.is_file(), reason="typescript is not installed: `make setup-browser`")
def test_types_in_the_comments_of_the_modules_hold():
    options = "--noEmit --allowJs --checkJs --strict --target es2022 --module es2022"
    options += " --moduleResolution bundler --lib es2023,dom,dom.iterable"
    done = subprocess.run(
        [NODE, TSC, *options.split(), *sorted(WEB.glob("*.js"))],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout
