"""Every script in examples/studies does what its docstring says, into a folder of its own."""

from __future__ import annotations

import csv
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
STUDIES = ROOT / "examples" / "studies"
FIGURES = (".png", ".svg")

# Script: arguments ({} is the folder), files it writes there, a line it prints.
RUNS: dict[str, tuple[tuple[str, ...], tuple[str, ...], str]] = {
    "bench_rod/bench_rod.py": (
        ("--quick", "--out", "{}/new"),
        ("new/bench-rod.json", "new/bench-rod.png", "new/bench-rod.svg"),
        r"rigid +0\.\d\d .*\n.*\nbending 2,1 +[1-9]",
    ),
    "corrected_jump/corrected_jump.py": (
        ("{}/new",),
        ("new/corrected-jump.png", "new/corrected-jump.svg"),
        r"written: .*corrected-jump",
    ),
    "critical_force/study.py": (
        ("{}/new",),
        ("new/convergence.csv", "new/critical-force-convergence.png"),
        r"expected -0\.8503",
    ),
    "fit_noisy_impacts.py": (("{}/new",), ("new/impacts.csv", "new/force.csv"), ""),
    "impact_energy.py": (
        ("40",),
        (),
        r"(?s)ladder +energetic +0 .*ladder +poisson +0 .*ladder +newton +[1-9]",
    ),
    "paradox_in_space/paradox_in_space.py": (
        ("--quick", "--out", "{}/new"),
        ("new/paradox-in-space.json", "new/paradox-in-space.png", "new/paradox-in-space.svg"),
        r"(?s)1\.40  ± 17\.7\d deg .*e-1\d.*contacts at rest: 1: \d+, 3: \d+\n",
    ),
    "impact_in_space.py": (
        ("1000", "{}/hodographs"),
        ("hodographs.png", "hodographs.svg"),
        r"(?s)sticks +\d.*paradox: slides.*again: slips again.*twice: sticks",
    ),
    "reverse_chatter/growth.py": (
        ("--points", "3", "--out", "{}/new"),
        ("new/growth.json", "new/growth.png", "new/growth.svg"),
        r"(?m)^energetic +0\.\d+ ",
    ),
    "rigid_rod/landing.py": (
        ("--quick", "--out", "{}/new"),
        ("new/landing.json", "new/landing.png", "new/landing-maps.png"),
        r"landing 2,1 0\.8229",
    ),
    "rigid_rod/rigid_rod.py": (
        ("--quick", "--out", "{}/new"),
        ("new/rigid-rod.json", "new/thresholds.csv", "new/rigid-rod.png", "new/rigid-rod.svg"),
        r"nothing diverges below mu = 0\.3639",
    ),
    "robots/robots.py": (("--quick", "--out", "{}/new"), (), r"ANYmal C|not installed"),
    "sensitive_impact.py": (("{}/rate",), ("rate.png", "rate.svg"), r"mu"),
    "optimal_control.py": (
        ("{}/control",),
        ("control.png", "control.svg"),
        # By hand: 2/3, 2 and 4/3 s, and 8 N^2 s.
        r"(?s)(0\.6666666667 +){2}s.*(2\.0000000000 +){2}s.*(1\.3333333333 +){2}s"
        r".*(8\.0000000000 +){2}.*0\.666666667 s, slips back at 2\.666666667 s"
        r".*x = -?\d\.\de-1\d m, v = -?(\d\.\de-1\d|0\.0e\+00) m",
    ),
    "block_on_belt.py": (
        ("{}/block-on-belt",),
        ("block-on-belt.png", "block-on-belt.svg"),
        r"(?s)zero +12\.00103129483\d +4\.29599952548\d .*closed form: 9\.785093762383 s",
    ),
    "sticking_feet.py": (
        ("{}/feet",),
        ("feet.png", "feet.svg"),
        r"(?s)rigid feet stop together at 0\.170068 s.*2e\+05 +B +0\.170068",
    ),
    "woodpecker.py": (
        ("{}/cycles",),
        ("cycles.png", "cycles.svg", "cycles.json"),
        r"(?s)along the path +0\.1512\d\d .* 27\.806\n.*final slip +0\.14597\d .* 22\.882",
    ),
    "tangential_compliance.py": (
        ("--quick", "--out", "{}/new/spring"),
        ("new/spring.json", "new/spring.png", "new/spring.svg"),
        r"(?s)0\.8235 +0\.098358.*slip reverses.*order 0\.50",
    ),
    "singular_point/fates.py": (
        ("--points", "3", "--out", "{}/new"),
        ("new/fates.json", "new/fates.png", "new/fates.svg"),
        r"exponents measured in [1-9]\d* jams agree to \d\.\de-0[4-9]",
    ),
}


def shares_are_those_of_the_page(printed: str, folder: Path) -> None:
    shares = (re.search(rf"{n} +([\d.]+) %", printed) for n in ("sticks", "slips again", "slides"))
    sticks, again, slides = (share[1] for share in shares)
    page = " ".join((ROOT / "docs" / "impacts-in-space.md").read_text("utf-8").split())
    assert f"{sticks} % end sticking, in {slides} % the slip turns out" in page
    assert f"in {again} % it stops in the sector and begins again" in page


def third_remainder_is_small(printed: str, folder: Path) -> None:
    with (folder / "new" / "convergence.csv").open(newline="", encoding="utf-8") as file:
        assert float([*csv.DictReader(file)][-1]["third"]) < 1e-8


MORE = {
    "impact_in_space.py": shares_are_those_of_the_page,
    "critical_force/study.py": third_remainder_is_small,
}
"""What else a script must have printed and written."""


def kept_results() -> dict[Path, int]:
    """Return when each committed figure and table of the studies was written; ns."""
    files = [p for folder in (STUDIES, ROOT / "docs" / "figures") for p in folder.rglob("*.*")]
    return {p: p.stat().st_mtime_ns for p in files if p.suffix in (*FIGURES, ".json", ".csv")}


def numbers(text: str) -> list[float]:
    return [float(n) for n in re.findall(r"(?<![\w.])-?\d+\.?\d*(?:e[+-]?\d+)?", text)]


def test_every_study_script_is_run_here():
    # Those of the folder `peers` need other programs: tests/test_peers_page.py.
    here = {p.relative_to(STUDIES) for p in STUDIES.glob("**/*.py")}
    assert {str(p) for p in here if p.parts[0] != "peers"} == set(RUNS)


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNS)
def test_a_study_script_writes_what_it_says(name, tmp_path):
    arguments, files, printed = RUNS[name]
    command = [sys.executable, str(STUDIES / name), *(a.format(tmp_path) for a in arguments)]
    options = {"capture_output": True, "text": True, "cwd": tmp_path, "timeout": 900}
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    # Thousands of motions: compiled as for users.
    environment["PAINLEVE_OPTIMIZE"] = ""
    before = kept_results()
    answer = subprocess.run(command, env=environment, **options)
    assert answer.returncode == 0, answer.stderr
    assert kept_results() == before, "a script that is told where to write wrote elsewhere"
    assert re.search(printed, answer.stdout), answer.stdout
    if name in MORE:
        MORE[name](answer.stdout, tmp_path)
    for file in files:
        path = tmp_path / file
        assert path.stat().st_size > (5000 if path.suffix in FIGURES else 100), file
        if path.suffix == ".json":
            json.loads(path.read_text("utf-8"))
        kept = STUDIES / "fit" / path.name
        if name.startswith("fit") and kept.exists():
            assert numbers(path.read_text("utf-8")) == pytest.approx(
                numbers(kept.read_text("utf-8")), rel=1e-4, abs=2e-5
            )
