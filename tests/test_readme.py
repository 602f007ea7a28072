"""What the README and the examples show does run."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
EXAMPLES = sorted((ROOT / "examples").glob("*/*.py"))


def run(arguments):
    options = {"capture_output": True, "text": True, "cwd": ROOT, "timeout": 300}
    return subprocess.run([sys.executable, *arguments], env=ENVIRONMENT, **options)


def test_readme_example_runs_and_prints_what_it_says():
    code = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.S)
    answer = run(["-c", code.group(1)])
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.startswith("(3*(-mu*sin(theta) + cos(theta))*cos(theta) + 1)/m\n")
    assert "4.088624e-04 s  slip_stop          5766.507 N" in answer.stdout


def test_readme_links_exist():
    for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text("utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(p, marks=pytest.mark.slow if p.parent.name == "studies" else (), id=p.stem)
        for p in EXAMPLES
    ],
)
def test_example_runs(path):
    answer = run([str(path)])
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.strip()


def test_import_is_light():
    code = (
        "import sys, time; t = time.perf_counter(); import painleve_sym; "
        "print(time.perf_counter() - t); "
        "print([m for m in ('sympy', 'casadi', 'numpy', 'matplotlib') if m in sys.modules])"
    )
    seconds, heavy = run(["-c", code]).stdout.splitlines()
    assert float(seconds) < 0.3
    assert heavy == "[]"
