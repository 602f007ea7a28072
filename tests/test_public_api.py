"""The public names: what editors see, what mypy sees from a client's side, and their examples."""

from __future__ import annotations

import doctest
import enum
import importlib
import inspect
import pickle
import re
import subprocess
import sys
from pathlib import Path

import pytest

import painleve_sym
from painleve_sym.doors import doors, listed, public_names

ROOT = Path(__file__).parents[1]
PUBLIC = {
    name: getattr(importlib.import_module(place), name)
    for name, place in public_names().items()
    if not name.startswith("__") and name != "TIME"
}
# Parts of results that the example of the whole shows, and what no reader makes by hand.
PARTS = {
    *("Border", "Chatter", "CorrectedJumpRule", "CorrectedPhase", "CriticalForceFinder"),
    *("EnergyGain", "EventSensitivity", "Export", "Film", "FitData", "FitProblem", "FitResult"),
    *("Fmu", "ForceDerivative", "FrozenEnd", "FrozenImpactSolver", "ImpactPhase", "ImpulsePhase"),
    *("LawsByContact", "NaturalPeriod", "Page", "Reproduction", "ReverseChatter"),
    *("Section", "Segment", "SingularLimit", "SlidingSolution", "Sweep"),
    *("ContactRisk", "LeastRisk", "RobotContact"),
    *("Animation", "FrictionSet", "Look", "PositiveFunction", "Proof", "SimultaneousImpact"),
    # Figures of results that take long: `tests/present` draws each.
    *("contrast_figure", "fit_figure", "outcome_figure", "risk_figure", "risk_trajectory_figure"),
    *("sensitivity_figure", "trajectory_figure", "write_figure", "write_report"),
}
DOOR_PAGES = "\n".join(p.read_text("utf-8") for p in sorted((ROOT / "docs" / "doors").glob("*.md")))


def needs_example(name: str) -> bool:
    public = PUBLIC[name]
    if inspect.isclass(public) and name not in PARTS:
        return not issubclass(public, enum.Enum | Exception)
    return name not in PARTS and (inspect.isfunction(public) or name == "model")


NEEDS_EXAMPLE = [n for n in PUBLIC if needs_example(n)]


@pytest.mark.parametrize("name", PUBLIC)
def test_public_name_is_where_it_is_said_to_be_and_says_what_it_is(name):
    public = PUBLIC[name]
    assert public.__doc__ and public.__doc__.strip()


@pytest.mark.parametrize("name", NEEDS_EXAMPLE)
def test_public_function_has_an_example(name):
    on_its_page = re.search(rf"^>>> .*\b{name}\(", DOOR_PAGES, re.M)
    assert on_its_page or ">>>" in PUBLIC[name].__doc__


@pytest.mark.parametrize(
    "module",
    sorted(
        {home for place in ("painleve_sym", *doors()) for home in listed(place).values()}
        | {f"painleve_sym.{m}" for m in ("models", "laws", "choices", "contact_rows")}
    ),
)
def test_examples_of_public_modules_run(module, monkeypatch):
    monkeypatch.chdir(ROOT)
    target = importlib.import_module(module)
    failures, _ = doctest.testmod(target, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failures == 0


CLASSES = {
    name
    for path in (ROOT / "painleve_sym").rglob("*.py")
    for name in re.findall(r"^class ([A-Z]\w+)", path.read_text("utf-8"), re.M)
}
RESULTS = {n for n, public in PUBLIC.items() if hasattr(public, "to_dict")} | {
    *("BatchResult", "Comparison", "ContactSolution", "CorrectedJump", "JumpResult", "Mechanism"),
}
# Parts of these results are read as JSON or printed; their classes have names of no public use.
PARTS_WITHOUT_A_NAME = {
    "Comparison": {"AccelerationLevel", "Answer", "FirstStep"},
    "Reproduction": {"Item", "Paper"},
    "BatchResult": {"BatchOutputs", "BatchRows", "RunOptions"},
    "Mechanism": {"MechanismOutline"},
    "SensitiveTrajectory": {"RunDerivatives", "StoredDerivatives"},
    "Trajectory": {
        "JoinedOutputs",
        "JoinedRecord",
        "EngineOutputs",
        "MotionNames",
        "RunRecord",
        "StoredRecord",
        "TapeOutputs",
    },
}


@pytest.mark.parametrize("name", sorted(RESULTS))
def test_what_a_result_holds_or_returns_has_a_public_type(name):
    result = PUBLIC[name]
    members = [m for key, m in vars(result).items() if not key.startswith("_")]
    functions = [getattr(m, "fget", None) or getattr(m, "func", m) for m in members]
    texts = [t for key, t in result.__annotations__.items() if not key.startswith("_")]
    texts += [f.__annotations__.get("return", "") for f in functions if inspect.isfunction(f)]
    held = CLASSES & set(re.findall(r"[A-Z]\w+", " ".join(map(str, texts))))
    assert held - set(PUBLIC) <= PARTS_WITHOUT_A_NAME.get(name, set())


def test_no_public_function_takes_options_without_a_name_and_type():
    for name, public in PUBLIC.items():
        if inspect.isclass(public) and issubclass(public, enum.Enum | Exception):
            continue
        functions = [public] if inspect.isfunction(public) else []
        if inspect.isclass(public):
            functions += [
                f for n, f in vars(public).items() if inspect.isfunction(f) and n[0] != "_"
            ]
        for function in functions:
            for parameter in inspect.signature(function).parameters.values():
                if parameter.kind is parameter.VAR_KEYWORD:
                    assert parameter.annotation not in ("Any", inspect.Parameter.empty), (
                        f"{name}.{function.__name__}(**{parameter.name})"
                    )


def test_every_named_mechanism_and_law_is_a_function_of_its_own():
    from painleve_sym import laws, models
    from painleve_sym.laws.catalogue import LAWS
    from painleve_sym.mechanics.models import NAMED

    named = {m.name for m in vars(models).values() if isinstance(m, models.NamedModel)}
    assert named == set(NAMED)
    assert {name.replace("-", "_") for name in LAWS} == {
        *laws.__all__,
        "bilinear_hertz_two_bodies",
    }


def test_mypy_sees_the_public_interface_from_a_client():
    client = ROOT / "tests" / "client" / "client.py"
    # Strict by the settings of the project: `make lint` has read the package by them.
    answer = subprocess.run(
        [sys.executable, "-m", "mypy", "--no-error-summary", str(client)],
        capture_output=True,
        text=True,
        cwd=ROOT,
        timeout=600,
    )
    reported = {
        (int(m[1]), m[2])
        for m in re.finditer(r"client\.py:(\d+): error: .*(\[[a-z-]+\])$", answer.stdout, re.M)
    }
    expected = {
        (number, line.split("# error: ")[1])
        for number, line in enumerate(client.read_text("utf-8").splitlines(), 1)
        if "# error: " in line and "`" not in line
    }
    assert reported == expected, answer.stdout


def test_results_are_one_line_pickle_and_have_the_data_that_the_page_says():
    ps = painleve_sym
    rod, law = ps.models.rod(mu=1.5), ps.laws.bilinear_hertz(E=209e9)
    state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    results = {
        "classify": ps.classify(rod, state),
        "simulate": ps.simulate(rod, law, state, t_end=1e-3),
        "reproduce": ps.reproduce(["eq-1"]),
        "solve_impact": ps.solve_impact([[1, 0.6], [0.6, 1]], 2.0, (0, 1.0), "energetic", 0.75),
        "evaluate_jump": ps.evaluate_jump(rod, "energetic", state),
        "evaluate_corrected_jump": ps.evaluate_corrected_jump(rod, law, state),
        "simulate_batch": ps.simulate_batch(rod, law, {**state, "theta": [1.0, 1.1]}, t_end=1e-3),
    }
    words = " ".join((ROOT / "docs" / "api.md").read_text("utf-8").split())
    with_data, arrays = re.search(
        r"Results of (.*?) have `to_dict\(\)`(.*?) arrays\.", words
    ).groups()
    for name, result in results.items():
        assert "\n" not in repr(result) and len(repr(result)) < 130
        assert type(pickle.loads(pickle.dumps(result))) is type(result)
        assert hasattr(result, "to_dict") == (f"`{name}`" in with_data) != (f"`{name}`" in arrays)
