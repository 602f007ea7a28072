"""Examples and links of the README, of the pages and of the project files."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import painleve_sym
from painleve_sym.cli.texts import COMMANDS

ROOT = Path(__file__).parents[1]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
EXAMPLES = sorted((ROOT / "examples").glob("*/*.py"))


def run(arguments):
    options = {"capture_output": True, "text": True, "cwd": ROOT, "timeout": 300}
    return subprocess.run([sys.executable, *arguments], env=ENVIRONMENT, **options)


README = (ROOT / "README.md").read_text("utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
REPOSITORY = PROJECT["urls"]["Repository"]
CONSOLE = re.findall(r"```console\n\$ painleve ([^\n]*)\n(.*?)```", README, re.S)


def test_readme_example_in_python_prints_the_shown_output():
    code, shown = re.search(r"```python\n(.*?)```\s+```\n(.*?)```", README, re.S).groups()
    answer = run(["-c", code])
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout == shown


@pytest.mark.parametrize(("command", "shown"), CONSOLE, ids=["classify", "simulate"])
def test_readme_command_prints_the_shown_output(command, shown):
    answer = run(["-m", "painleve_sym", *shlex.split(command)])
    assert answer.returncode == 0, answer.stderr
    lines = [without_round_off(line) for line in answer.stdout.splitlines()]
    assert lines[: len(shown.splitlines())] == [without_round_off(s) for s in shown.splitlines()]


def without_round_off(line):
    """Replace numbers that are nothing but round-off (below 1e-18) by 0."""
    return re.sub(r" +-?[\d.]+e-(1[89]|[2-9]\d)$", " 0", line)


def test_readme_names_commands_that_exist():
    table = README.split("## Which command")[1].split("\n## ")[0]
    named = set(re.findall(r"`painleve (\w+)", table)) - {"COMMAND"}
    assert len(named) > 12 and named <= set(COMMANDS)


def test_readme_links_are_absolute_and_lead_to_files():
    raw = REPOSITORY.replace("github.com", "raw.githubusercontent.com")
    inside = rf"(?:{REPOSITORY}/(?:blob|tree)|{raw})/main/"
    targets = re.findall(r"\]\(([^)#]+)", README)
    assert all(t.startswith("https://") for t in targets)
    paths = [re.sub(inside, "", t) for t in targets if re.match(inside, t)]
    assert len(paths) > 20
    assert [p for p in paths if not (ROOT / p).exists()] == []
    assert [t for t in targets if "painleve-sym" in t and not re.match(inside, t)] == []


def test_links_of_pages_exist():
    for page in (*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")):
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text("utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_citation_has_version_and_address_of_the_project():
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    assert f"\nversion: {painleve_sym.__version__}\n" in citation
    assert f'\nrepository-code: "{REPOSITORY}"\n' in citation
    assert re.search(r"^date-released: \d{4}-\d{2}-\d{2}$", citation, re.M)


def test_changelog_begins_with_the_present_version():
    changelog = (ROOT / "CHANGELOG.md").read_text("utf-8")
    releases = re.findall(r"^## \[([^]]+)\]", changelog, re.M)
    assert releases[0] == painleve_sym.__version__
    assert releases == sorted(releases, reverse=True)


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
