"""Files for archives of software and for packagers say what the project says."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

from tests.test_readme import GROUPS, PROJECT, ROOT, releases


def requirements(lines):
    """Return the bound of each package of a list."""
    return {re.match(r"[\w-]+", line)[0]: line.partition(">=")[2] for line in lines}


def test_codemeta_says_what_the_project_and_the_citation_say():
    meta = json.loads((ROOT / "codemeta.json").read_text("utf-8"))
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    assert (meta["name"], meta["version"]) == (PROJECT["name"], releases()[0])
    assert f"\ndate-released: {meta['datePublished']}\n" in citation
    assert meta["license"].endswith(f"/{PROJECT['license']}")
    assert meta["softwareRequirements"] == sorted(requirements(PROJECT["dependencies"]))


def test_recipe_of_conda_needs_what_the_project_needs():
    recipe = (ROOT / "tools" / "conda" / "recipe.yaml").read_text("utf-8")
    run = recipe.split("\n  run:\n")[1].split("\n\n")[0]
    needed = requirements(line.strip(" -").replace("-base", "") for line in run.splitlines())
    assert needed.pop("python") == PROJECT["requires-python"].removeprefix(">=")
    assert needed == requirements(PROJECT["dependencies"])
    assert f'version: "{releases()[0]}"' in recipe
    (command,) = PROJECT["scripts"].items()
    assert " = ".join(command) in recipe


def test_oldest_versions_are_the_bounds_of_the_project():
    oldest = (ROOT / "constraints-oldest.txt").read_text("utf-8")
    pinned = dict(re.findall(r"^([\w-]+)==(.*)$", oldest, re.M))
    for name, bound in requirements(PROJECT["dependencies"]).items():
        assert f"{pinned[name]}.".startswith(f"{bound}."), name


def test_each_package_is_pinned_once():
    names = re.findall(r"^([\w.-]+)==", (ROOT / "constraints.txt").read_text("utf-8"), re.M)
    assert len(names) == len(set(names)) > 100


def test_groups_of_make_are_those_of_the_project():
    makefile = (ROOT / "Makefile").read_text("utf-8")
    assert set(re.findall(r"--group (\w+)", makefile)) <= set(GROUPS)


def test_workflow_calls_the_script_and_targets_that_exist():
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text("utf-8")
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.M))
    assert "run: .ci/run" in workflow and (ROOT / ".ci" / "run").exists()
    (named,) = re.findall(r"target: \[(.*?)\]", workflow)
    assert set(named.split(", ")) <= targets
    oldest = PROJECT["requires-python"].removeprefix(">=")
    assert f'"{oldest}"' in workflow


def test_source_archive_has_every_file_at_the_top():
    manifest = Path(ROOT / "MANIFEST.in").read_text("utf-8")
    for pattern in ("*.md", "*.txt", "*.cff", "*.json", "Makefile"):
        for file in ROOT.glob(pattern):
            always = file.name == "README.md"  # setuptools includes it
            assert always or file.name in manifest, file.name
    assert tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["build-system"]
