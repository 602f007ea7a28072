"""Examples and links of the README, of the pages and of the project files."""

from __future__ import annotations

import os
import re
import runpy
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import warnings
from pathlib import Path

import pytest

from painleve_sym.choices import Friction
from painleve_sym.cli import main
from painleve_sym.cli.commands import COMMANDS
from painleve_sym.version import RELEASE
from tests.site_pages import Page
from tools import figures

ROOT = Path(__file__).parents[1]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
STUDIES = ROOT / "examples" / "studies"
"""They keep what they write: `tests/test_study_scripts.py` runs them into folders of their own."""
EXAMPLES = [p for p in sorted((ROOT / "examples").glob("*/*.py")) if p.parent != STUDIES]


def releases():
    """Return the releases of the changelog, the last one first, older ones by the pages of each."""
    changelog = (ROOT / "CHANGELOG.md").read_text("utf-8")
    recent = re.findall(r"^## \[(\d[^]]+)\]", changelog, re.M)
    return recent + re.findall(r"^\| \[(.*?)\]\(docs/changes/\1\.md\)", changelog, re.M)


def run(arguments):
    options = {"capture_output": True, "text": True, "cwd": ROOT, "timeout": 300}
    return subprocess.run([sys.executable, *arguments], env=ENVIRONMENT, **options)


README = (ROOT / "README.md").read_text("utf-8")
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
PROJECT, GROUPS = PYPROJECT["project"], PYPROJECT["dependency-groups"]
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "docs").glob("*/*.md")]
PAGES = [page for page in PAGES if page.parent.name not in ("_generated", "gallery")]
# Blocks whose lines a reader types into a terminal, and what follows a command there.
TYPED = re.compile(r"^```(?:sh|console)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def test_blocks_of_the_readme_print_what_they_show(tmp_path):
    page = Page(ROOT / "README.md", tmp_path)
    page.run()
    assert page.commands == 1


@pytest.mark.slow
def test_blocks_of_the_readme_work_in_a_fresh_clone(tmp_path):
    """`make setup` as the README says, in a copy, with the packages of this environment."""
    clone = tmp_path / "clone"
    left = (".*", "out", "build", "_generated", "gallery", "api", "__pycache__", "*.egg-info")
    shutil.copytree(ROOT, clone, ignore=shutil.ignore_patterns(*left))
    variables = {
        **{k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")},
        "PAINLEVE_CACHE": str(tmp_path / "cache"),
        "PIP_NO_INDEX": "1",
        # The value of the option `build_isolation`, whatever the name says.
        "PIP_NO_BUILD_ISOLATION": "0",
    }
    options = {"cwd": clone, "env": variables, "text": True, "capture_output": True}
    # As the Makefile does, but with this environment's pip and setuptools.
    venv.create(clone / ".venv", with_pip=False)
    (clone / ".venv" / ".created").touch()
    (packages,) = clone.glob(".venv/lib/python*/site-packages")
    (packages / "zz-others.pth").write_text(f"{sysconfig.get_path('purelib')}\n", "utf-8")
    (setup,) = [body for body in TYPED.findall(README) if "make setup" in body]
    place = "python -c 'import painleve_sym; print(painleve_sym.__file__)'"
    answer = subprocess.run(["bash", "-c", f"set -e\n{setup}\n{place}"], **options)
    assert answer.returncode == 0, answer.stderr
    assert "usage: painleve" in answer.stdout
    assert answer.stdout.splitlines()[-1] == str(clone / "painleve_sym" / "__init__.py")
    page = Page(clone / "README.md", clone, clone / ".venv" / "bin")
    page.environment = {**variables, "PATH": page.environment["PATH"]}
    page.run()
    assert page.commands == 1


def test_readme_begins_with_what_it_is_a_film_and_how_to_run_it():
    parts = ["**painleve-sym** tells", "docs/figures/rod-inconsistent.gif", "make setup"]
    parts += [". .venv/bin/activate", "painleve --help", "make reproduce", "make test"]
    parts += ["## Three questions", "## In Python"]
    places = [README.index(part) for part in parts]
    assert places == sorted(places)
    assert README.startswith("# painleve-sym\n\n**painleve-sym** tells")
    assert len(README.split()) <= 700, "one screen"


def test_no_page_installs_the_package_by_name_or_from_an_address():
    for page in PAGES:
        text = page.read_text("utf-8")
        if page.name not in ("CHANGELOG.md", "changelog.md") and page.parent.name != "changes":
            assert not re.search(r"pip install (-\S+ )*'?painleve-sym", text), page
            assert "github.com/painleve-sym" not in text, page
    assert "urls" not in PROJECT


def test_pages_name_the_friction_of_the_package():
    limits = (ROOT / "docs" / "reference" / "limits.md").read_text("utf-8")
    for text in (README, limits):
        for law in set(Friction) - {Friction.COULOMB}:
            assert re.search(rf"{law.value}\b", text, re.IGNORECASE), law
        assert "whatever the speed" not in text


def test_without_a_compiler_export_and_explore_fail_and_motions_do_not(
    tmp_path, monkeypatch, capsys
):
    """As the page *Installation* says."""
    page = " ".join((ROOT / "docs" / "install.md").read_text("utf-8").split())
    assert (
        "`export`, `explore` of another mechanism than the rod or with another law than the page's "
        "own, motions and impacts of several contacts, and impacts in space" in page
    )
    monkeypatch.setenv("CC", "/nonexistent/cc")
    start = ["rod", "--law", "rigid", "--t-end", "1e-3"]
    assert main(["export", *start, "--out", str(tmp_path / "c")]) == 1
    assert "no working C compiler" in capsys.readouterr().err
    assert main(["simulate", *start]) == 0
    assert "engine erk" in capsys.readouterr().out
    assert main(["simulate", "block-two-feet", *start[1:]]) == 2
    assert "motions of several contacts need compiled code" in capsys.readouterr().err
    assert main(["explore", "rod", "--out", str(tmp_path / "rod.html")]) == 0


def test_targets_of_make_that_pages_name_exist():
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.M))
    for page in PAGES:
        text = page.read_text("utf-8")
        typed = "\n".join(TYPED.findall(text))
        named = re.findall(r"`make ([a-z-]+)", text) + re.findall(r"^make ([a-z-]+)", typed, re.M)
        assert set(named) <= targets, page


def test_extras_of_the_page_installation_are_those_of_the_project():
    page = (ROOT / "docs" / "install.md").read_text("utf-8")
    table = re.findall(r"^\| `(\w+)` \| ([^|]+) \|", page.split("## Extras")[1], re.M)
    extras = PROJECT["optional-dependencies"]
    assert set(dict(table)) == set(extras)
    groups = re.search(r"dependency groups \((.*?)\)", page, re.S)[1]
    assert re.findall(r"`(\w+)`", groups) == list(GROUPS)
    for name, brought in table:
        packages = {re.match(r"[\w-]+", needed)[0].lower() for needed in extras[name]}
        assert {word.lower() for word in brought.split(", ")} == packages
    core = re.search(r"The package needs (.*?)\.", page)[1].lower()
    packages = {re.match(r"\w+", needed)[0] for needed in PROJECT["dependencies"]}
    assert set(re.split(r", | and ", core)) == packages


def test_pictures_of_the_readme_are_those_of_its_commands():
    """Each of the three questions has a command and the picture that it draws."""
    section = README.split("## Three questions")[1].split("\n## ")[0]
    commands = re.findall(r"`painleve (.*?) --out \S+`", section)
    pictures = [Path(path).name for path in re.findall(r"\]\(docs/figures/(.*?)\)", section)]
    assert len(commands) == len(pictures) == 3
    drawn = {**figures.COMMANDS, **figures.PAGES}
    for command, picture in zip(commands, pictures, strict=True):
        assert command.split()[0] in COMMANDS
        if picture.endswith(".gif"):
            of_page = dict(figures.films())[f"everyday/{picture}"]
            assert command.split()[:2] == of_page.split()[:2]
        else:
            assert drawn[picture].removesuffix("--out").split() == command.split()


def test_links_between_files_are_relative_and_lead_to_files():
    for page in PAGES:
        text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.M | re.S)
        for target in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", text):
            generated = target.startswith(("gallery/", "../gallery/", "explorer/"))
            assert generated or (page.parent / target).exists(), f"{page.name}: {target}"
    assert len(re.findall(r"\]\((?:docs/|examples)", README)) > 12


def test_citation_has_the_last_release():
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    assert f"\nversion: {releases()[0]}\n" in citation
    assert re.search(r"^date-released: \d{4}-\d{2}-\d{2}$", citation, re.M)


def test_changelog_begins_with_the_present_version():
    assert releases() == sorted(releases(), reverse=True)
    pages = {page.stem for page in (ROOT / "docs" / "changes").glob("*.md")}
    assert pages == set(releases()[1:])
    changelog = (ROOT / "CHANGELOG.md").read_text("utf-8")
    if ".dev" in RELEASE:  # on the way to a release that has no section yet
        assert "\n## [Unreleased]" in changelog and releases()[0] < RELEASE
    else:
        assert releases()[0] == RELEASE


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(p, id=p.stem, marks=pytest.mark.slow if "softened" in p.stem else ())
        for p in EXAMPLES
    ],
)
def test_example_runs(path, monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out.strip()


def test_import_is_light():
    code = (
        "import sys, time; t = time.perf_counter(); import painleve_sym; "
        "print(time.perf_counter() - t); "
        "print([m for m in ('sympy', 'casadi', 'numpy', 'matplotlib') if m in sys.modules])"
    )
    seconds, heavy = run(["-c", code]).stdout.splitlines()
    assert float(seconds) < 0.3
    assert heavy == "[]"
