"""The version names the commit of a development build, wherever the package lies."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from painleve_sym import version

ROOT = Path(__file__).parents[1]
COMMIT = "1a2b3c4d5e6f708192a3b4c5d6e7f8091a2b3c4d"


def git(folder, *arguments):
    identity = ["-c", "user.name=n", "-c", "user.email=n@localhost", "-c", "commit.gpgsign=false"]
    options = {"cwd": folder, "check": True, "capture_output": True, "text": True}
    return subprocess.run(["git", *identity, *arguments], **options).stdout.strip()


@pytest.fixture
def clone(tmp_path, monkeypatch):
    if not shutil.which("git"):
        pytest.skip("needs git")
    monkeypatch.setattr(version, "RELEASE", "9.8.0.dev0")
    folder = tmp_path / "clone"
    folder.mkdir()
    git(folder, "init", "--quiet", "--initial-branch=main")
    (folder / "pyproject.toml").touch()
    git(folder, "add", "."), git(folder, "commit", "--quiet", "--message=first")
    return folder


def expected(folder):
    return f"9.8.0.dev0+g{git(folder, 'rev-parse', 'HEAD')[:8]}"


def test_clone_names_its_commit(clone):
    assert version._version(str(clone)) == expected(clone)
    git(clone, "commit", "--quiet", "--allow-empty", "--message=second")
    assert version._version(str(clone)) == expected(clone)


def test_commit_is_read_from_packed_branches_work_trees_and_without_a_branch(clone, tmp_path):
    git(clone, "branch", "main-of-others")
    git(clone, "pack-refs", "--all")
    assert not (clone / ".git" / "refs" / "heads" / "main").exists()
    assert version._version(str(clone)) == expected(clone)
    tree = tmp_path / "tree"
    git(clone, "worktree", "add", "--quiet", "-b", "side/branch", str(tree))
    git(tree, "commit", "--quiet", "--allow-empty", "--message=second")
    assert version._version(str(tree)) == expected(tree) != expected(clone)
    git(tree, "checkout", "--quiet", "--detach")
    assert version._version(str(tree)) == expected(tree)


def test_folder_without_git_has_the_version_of_its_metadata(tmp_path, monkeypatch):
    monkeypatch.setattr(version, "RELEASE", "9.8.0.dev0")
    built = f"9.8.0.dev0+g{COMMIT[:8]}"
    assert version._version(str(tmp_path)) == "9.8.0.dev0"
    (tmp_path / f"painleve_sym-{built}.dist-info").mkdir()
    assert version._version(str(tmp_path)) == built
    archive = tmp_path / "archive"
    archive.mkdir()
    (archive / "pyproject.toml").touch()
    assert version._version(str(archive)) == "9.8.0.dev0"
    (archive / "PKG-INFO").write_text(f"Name: painleve-sym\nVersion: {built}\n", "utf-8")
    assert version._version(str(archive)) == built


def test_release_has_no_commit(clone, monkeypatch):
    monkeypatch.setattr(version, "RELEASE", "9.8.0")
    assert version._version(str(clone)) == "9.8.0"


@pytest.mark.parametrize("content", [b"", b"ref: refs/heads/none", b"\xff\xfe"])
def test_git_folder_that_cannot_be_read_leaves_the_release(clone, content):
    (clone / ".git" / "HEAD").write_bytes(content)
    assert version._version(str(clone)) == "9.8.0.dev0"


def test_present_version_is_one_of_pep_440():
    assert re.fullmatch(r"\d+\.\d+\.\d+(\.dev\d+(\+g[0-9a-f]{8})?)?", version._version(str(ROOT)))
