"""Names of cache entries: each input that a derivation starts from, changed, changes the name."""

from __future__ import annotations

import ast
import importlib.util
import os
import platform
from pathlib import Path

import pytest

from painleve_sym import cache as caching
from painleve_sym.cache import code_mark, entry_name
from painleve_sym.codegen import compile as compiling
from painleve_sym.codegen import derivation_cache, quantities
from painleve_sym.codegen.compile import compiler_mark, flags
from painleve_sym.engines.compiled import CompiledEngine, _library_entry
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.explorer import wasm

PACKAGE = Path(caching.__file__).parent
FOLDERS = sorted(p.parent.name for p in PACKAGE.glob("*/__init__.py"))
ENTRY = ("title", "one", "other")


@pytest.fixture
def marks(monkeypatch):
    """Return marks of code and packages that a test may change."""
    code = {folder: f"code of {folder}" for folder in FOLDERS}
    packages = {"sympy": "sympy 1", "casadi": "casadi 1"}
    monkeypatch.setattr(caching, "code_mark", lambda folder: code[folder])
    monkeypatch.setattr(caching, "_package_mark", lambda name, file: packages[name])
    caching._versions.cache_clear()
    yield code, packages
    caching._versions.cache_clear()


def named(*texts, by=("mechanics", "laws")):
    caching._versions.cache_clear()
    return entry_name(*texts, by=by)


def test_each_input_of_an_entry_changes_its_name(marks, monkeypatch):
    code, packages = marks
    names = [named(*ENTRY)]
    names += [named(*changed) for changed in (
        ("another", "one", "other"), ("title", "1", "other"), ("title", "one", "2"),
        ("title", "other", "one"), ("title", "one"), ("title", "one", "other", "third"),
    )]  # fmt: skip
    names += [named(*ENTRY, by=by) for by in (("mechanics",), ("mechanics", "laws", "automata"))]
    for given in (packages, code):
        for key in {"sympy", "casadi", "mechanics", "laws"} & given.keys():
            before, given[key] = given[key], "changed"
            names.append(named(*ENTRY))
            given[key] = before
    monkeypatch.setattr(caching, "RELEASE", "99.9")
    names.append(named(*ENTRY))
    monkeypatch.undo()
    assert len(names) == 14 and len(set(names)) == len(names)


def test_code_that_an_entry_is_not_derived_by_plays_no_part(marks):
    code, _ = marks
    before = named(*ENTRY)
    code["cli"] = "changed"
    assert named(*ENTRY) == before


@pytest.mark.parametrize(("name", "file"), [("sympy", "release.py"), ("casadi", "_casadi.so")])
def test_mark_of_a_package_is_that_of_the_file_with_its_version(name, file):
    mark = caching._package_mark(name, file)
    path = Path(importlib.util.find_spec(name).origin).parent / file
    info = path.stat()
    assert mark == f"{path} {info.st_size} {info.st_mtime_ns}"


def test_mark_of_a_package_changes_with_its_file(tmp_path, monkeypatch):
    folder = tmp_path / "derives"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "release.py").write_text("version = 1")
    monkeypatch.syspath_prepend(str(tmp_path))
    seen = {caching._package_mark("derives", "release.py")}
    (folder / "release.py").write_text("version = 10")
    seen.add(caching._package_mark("derives", "release.py"))
    os.utime(folder / "release.py", ns=(1, 1))
    seen.add(caching._package_mark("derives", "release.py"))
    seen.add(caching._package_mark("derives", "absent.py"))
    assert len(seen) == 4


def test_mark_of_code_changes_with_every_source_of_a_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(caching, "__file__", str(tmp_path / "cache.py"))
    (tmp_path / "laws" / "inner").mkdir(parents=True)
    sources = [tmp_path / "laws" / n for n in ("a.py", "b.c", "inner/c.h", "inner/d.toml")]
    for path in (*sources, tmp_path / "laws" / "notes.md"):
        path.write_text("1")

    def mark():
        code_mark.cache_clear()
        return code_mark("laws")

    try:
        seen = [mark()]
        for path in sources:
            path.write_text("2")
            seen.append(mark())
        assert len(set(seen)) == len(seen)
        (tmp_path / "laws" / "notes.md").write_text("2")
        assert mark() == seen[-1]
    finally:
        monkeypatch.undo()
        code_mark.cache_clear()


def test_modules_outside_of_folders_play_a_part_in_every_entry(tmp_path, monkeypatch):
    monkeypatch.setattr(caching, "__file__", str(tmp_path / "cache.py"))
    monkeypatch.setattr(caching, "code_mark", lambda folder: folder)
    (tmp_path / "errors.py").write_text("1")
    (tmp_path / "laws").mkdir()
    try:
        before = named(*ENTRY)
        (tmp_path / "errors.py").write_text("2")
        assert named(*ENTRY) != before
        before = named(*ENTRY)
        (tmp_path / "laws" / "a.py").write_text("1")
        assert named(*ENTRY) == before
    finally:
        monkeypatch.undo()
        caching._versions.cache_clear()


# ---- what derives an entry ----


def imported_folders(folder):
    """Return the folders of the package that modules of a folder import, but for type checkers."""
    folders = set()
    for path in (PACKAGE / folder).rglob("*.py"):
        tree = ast.parse(path.read_text("utf-8"))
        for block in [n for n in ast.walk(tree) if isinstance(n, ast.If)]:
            if "TYPE_CHECKING" in ast.dump(block.test):
                block.body = []
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("painleve_sym."):
                folders.add(node.module.split(".")[1])
    return folders & set(FOLDERS)


UNUSED = {
    ("at", "problem"): "the rigid contact problem in numbers: nothing is derived",
    ("engines", "problem"): "the same",
    ("mechanics", "codegen"): "numbers of formulas: their derivation has its own entry",
}
"""Imports that derive nothing of an entry, each with the reason."""


@pytest.mark.parametrize("derives", [derivation_cache.FORMULAS, derivation_cache.ENGINE])
def test_folders_that_derive_have_what_they_import_among_them(derives):
    for folder in derives:
        others = imported_folders(folder) - set(derives)
        assert {o for o in others if (folder, o) not in UNUSED} == set(), folder


def calls_of_entries():
    """Return place, title and `by` of every call that names an entry."""
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            name = getattr(getattr(node, "func", None), "id", "")
            if name in ("entry_key", "entry_name") and path.name != "derivation_cache.py":
                by = [k.value for k in node.keywords if k.arg == "by"]
                title = ast.unparse(node.args[0])
                yield (
                    str(path.relative_to(PACKAGE)),
                    title,
                    ast.unparse(by[0]) if by else "FORMULAS",
                )


DERIVED_ELSEWHERE = {
    "motion/sensitivity/variational.py": "the functions are those of codegen, the C of engines",
}


def test_every_entry_is_made_again_where_the_module_that_makes_it_changes():
    sets = {name: getattr(derivation_cache, name) for name in ("MECHANISM", "FORMULAS", "ENGINE")}
    calls = list(calls_of_entries())
    assert len(calls) >= 9
    for place, title, by in calls:
        given = {"_MADE_BY": wasm._MADE_BY, "own": ()} | sets
        folders = eval(by, {"__builtins__": {}}, given)
        if place not in DERIVED_ELSEWHERE:
            assert place.split("/")[0] in folders, (place, title)


def test_quantities_are_made_again_where_the_module_that_derives_them_changes(marks):
    code, _ = marks
    keys = [quantities._key("gap", "cc", "of", "painleve_sym.motion.rigidity")]
    for changed in ({"title": "rate"}, {"mark": "clang"}, {"of": "other"}):
        given = {"title": "gap", "mark": "cc", "of": "of"} | changed
        keys.append(quantities._key(**given, module="painleve_sym.motion.rigidity"))
    for folder in ("motion", *derivation_cache.FORMULAS):
        before, code[folder] = code[folder], "changed"
        keys.append(quantities._key("gap", "cc", "of", "painleve_sym.motion.rigidity"))
        code[folder] = before
    assert len(set(keys)) == len(keys)


# ---- compilers ----


def test_mark_of_compilers_changes_with_each_of_its_inputs(tmp_path, monkeypatch):
    script = tmp_path / "cc"
    script.write_text("#!/bin/sh\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    monkeypatch.delenv("PAINLEVE_OPTIMIZE", raising=False)
    seen = [compiler_mark()]
    os.utime(script, ns=(1, 1))
    seen.append(compiler_mark())
    script.write_text("#!/bin/sh\n#\n")
    seen.append(compiler_mark())
    for name, value in (("CC", f"{script} -m32"), ("PAINLEVE_OPTIMIZE", "1")):
        monkeypatch.setenv(name, value)
        seen.append(compiler_mark())
    monkeypatch.setattr(platform, "machine", lambda: "another")
    seen.append(compiler_mark())
    monkeypatch.setattr(compiling, "_processor", lambda: "another")
    seen.append(compiler_mark())
    monkeypatch.setattr(compiling, "FLAGS", (*compiling.FLAGS, "-DOTHER"))
    seen.append(compiler_mark())
    assert "-DOTHER" in flags() and None not in seen and len(set(seen)) == len(seen)


class Builder:
    title, definition = "a builder", "what it derives"


def test_entry_of_a_library_depends_on_engine_builder_and_compiler(cache, monkeypatch):
    other = type("Other", (Builder,), {"definition": "another"})
    engines = (CompiledEngine, TaylorEngine)
    titles = {f"{role} {e.name}" for role in ("engine", "lanes") for e in engines}
    keys = [_library_entry(title, Builder())[0] for title in sorted(titles)]
    keys.append(_library_entry("engine", other())[0])
    keys.append(_library_entry("engine", Builder())[0])
    monkeypatch.setattr("painleve_sym.engines.compiled.compiler_mark", lambda: "another compiler")
    keys.append(_library_entry("engine", Builder())[0])
    assert len(titles) == 4 and None not in keys and len(set(keys)) == len(keys)


def test_module_of_a_page_depends_on_flags_units_and_every_file(monkeypatch):
    def key(units=("a.c",), **files):
        source = type("Source", (), {"units": units, "files": {"a.c": "1", "b.h": "2"} | files})
        return wasm._key(source)

    keys = [key(), key(("a.c", "b.c")), key(**{"a.c": "3"}), key(**{"b.h": "3"})]
    monkeypatch.setattr(wasm, "FLAGS", (*wasm.FLAGS, "-O3"))
    keys.append(key())
    assert len(set(keys)) == len(keys)
