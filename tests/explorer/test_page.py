"""Pages as files: what they hold, how large they are, and sentences where there can be none."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

import painleve_sym as ps
from painleve_sym.errors import CompilerMissing
from painleve_sym.explorer import page, wasm
from painleve_sym.explorer.prebuilt import default_law, stored_digest, stored_module
from painleve_sym.explorer.source import ModuleSource
from painleve_sym.mechanics.models import MODELS
from tests.cli.cli_helpers import run, run_json
from tests.support.exports import SLEDGE

MAX_PAGE = 400_000


def data_of(text):
    """Return the data that a page holds."""
    (text_of_data,) = re.findall(
        r'<script type="application/json" id="data">(.*?)</script>', text, re.S
    )
    return json.loads(text_of_data)


@pytest.fixture
def no_compiler(monkeypatch):
    wasm.compiler.cache_clear()
    monkeypatch.setattr(wasm, "_candidates", lambda: iter(()))
    yield
    wasm.compiler.cache_clear()


@pytest.fixture
def sledge(tmp_path):
    """A mechanism that is given by its energies, and so has nothing to draw."""
    path = tmp_path / "sledge.toml"
    path.write_text(SLEDGE.replace("a mass point", "</script><b>a mass point"), "utf-8")
    return path


def needs_compiler():
    try:
        wasm.compiler()
    except CompilerMissing:
        pytest.skip("there is no compiler for WebAssembly: see `make setup-browser`")


# ---- the page ----


@pytest.mark.parametrize("name", list(MODELS))
def test_page_of_every_named_mechanism_is_one_small_file(name, no_compiler):
    shown = ps.explore(name)
    assert shown.prebuilt
    assert len(shown.html.encode()) < MAX_PAGE
    # Nothing in it is to be loaded: addresses stand only in texts and in the names of SVG.
    outside = data_of(shown.html) and re.sub(r'id="data">.*?</script>', "", shown.html, flags=re.S)
    assert re.findall(r"https?://[^\"'` ]+", outside) == ["http://www.w3.org/2000/svg"]
    assert not re.search(r"<(link|img|iframe|script[^>]* src)|@import|url\(|\bfetch\(", outside)
    assert "default-src 'none'" in outside
    description = data_of(shown.html)["description"]
    assert description["scene"] is not None
    assert [q["name"] for q in description["states"]] == list(ps.model(name).state_names)


def test_page_begins_with_the_numbers_that_are_given():
    start = {"theta": 0.7, "x_A_dot": -2.0}
    shown = ps.explore(
        "rod",
        ps.law("bilinear-hertz", reload="virgin"),
        start,
        parameters={"mu": 1.2},
        law_parameters={"E": 1e12},
        initial_force=20.0,
        t_end=0.5,
    )
    initial = data_of(shown.html)["initial"]
    assert shown.prebuilt
    assert initial["values"]["theta"] == 0.7 and initial["values"]["theta_dot"] == 0.0
    assert initial["values"] | {"mu": 1.2, "E": 1e12} == initial["values"]
    assert (initial["force"], initial["end"]) == (20.0, 0.5)


def test_stored_module_needs_neither_sympy_nor_casadi():
    code = (
        "import sys, painleve_sym as ps; ps.explore('rod');"
        "print([m for m in ('sympy', 'casadi', 'matplotlib') if m in sys.modules])"
    )
    # The first call may describe the mechanism; the next one finds the description in the cache.
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True
        )
    assert done.stdout == "[]\n"


def test_presets_are_the_states_of_the_papers_tables():
    from painleve_sym.papers.registry import known_papers

    claims = known_papers()["impact-resolution"].claims.data
    presets = data_of(ps.explore("rod").html)["presets"]
    assert len(presets) == len(claims["tables"])
    for preset, table in zip(presets, claims["tables"].values(), strict=True):
        values = preset["settings"]["values"]
        assert values | table["state"] == values
    assert [p["settings"].get("force") for p in presets] == [None] * 4 + [300.0, 350.0]
    assert data_of(ps.explore("block").html)["presets"] == []


def test_commands_and_sizes_of_the_docs_hold(capsys, tmp_path, monkeypatch):
    text = Path(__file__).parents[2].joinpath("docs", "explorer.md").read_text("utf-8")
    monkeypatch.chdir(tmp_path)
    commands = re.findall(r"^painleve (explore rod .*)$", text, re.M)
    assert len(commands) == 2
    for command in commands:
        data = run_json(capsys, *command.split())
        assert data["prebuilt"] and Path(data["file"]).stat().st_size == data["bytes"]
    for name, words in {"rod": "page of the rod has", "two-link-arm": "two-link arm"}.items():
        (size,) = re.findall(rf"{words} (\d+) kB", text)
        assert len(ps.explore(name).html.encode()) == pytest.approx(1000 * int(size), rel=0.03)


# ---- stored modules ----


def compare_with_the_generator(name):
    mechanism = ps.model(name)
    source = ModuleSource(mechanism, default_law(mechanism))
    assert stored_digest(name) == source.digest, "run `make explorer-modules`"
    _, description = stored_module(mechanism, default_law(mechanism))
    assert description == json.loads(json.dumps(source.description))


def test_stored_modules_of_the_rod_and_the_guide_are_up_to_date():
    for name in ("rod", "painleve-klein"):
        compare_with_the_generator(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in MODELS if n not in ("rod", "painleve-klein")])
def test_other_stored_modules_are_up_to_date(name):
    compare_with_the_generator(name)


def test_stored_modules_serve_only_what_they_were_made_of():
    rod = ps.model("rod")
    assert stored_module(rod, default_law(rod)) is not None
    assert stored_module(rod, ps.law("bilinear-hertz")) is None
    assert stored_module(rod, ps.law("hertz")) is None
    feet = ps.model("block-two-feet")
    assert stored_module(feet.only("A"), default_law(feet)) is None
    # Other defaults are numbers that the page begins with.
    other = rod.with_parameters(mu=1.1)
    assert stored_module(other, default_law(other)) is not None
    assert data_of(ps.explore(other).html)["initial"]["values"]["mu"] == 1.1


# ---- mechanisms and laws of one's own ----


def test_a_mechanism_without_shapes_has_a_page_without_a_drawing(sledge, capsys, tmp_path):
    needs_compiler()
    out = tmp_path / "sledge.html"
    data = run_json(capsys, "explore", sledge, "--law", "linear", "--out", out)
    assert not data["prebuilt"] and data["bytes"] == out.stat().st_size < MAX_PAGE
    text = out.read_text("utf-8")
    description = data_of(text)["description"]
    assert description["scene"] is None
    # A text from a file cannot end the element that holds it.
    assert description["mechanism"]["title"].startswith("</script><b>a mass point")
    assert text.count("</script>") == 2


def test_a_motion_without_a_taylor_series_is_integrated_by_runge_kutta_steps(tmp_path):
    path = tmp_path / "bent.toml"
    path.write_text(SLEDGE.replace("m*g*(h + x/10)", "m*g*(h + x/10) + 3*abs(x)**3"), "utf-8")
    source = ModuleSource(ps.load_mechanism(path), ps.law("linear"))
    assert [m["engine"] for m in source.description["motions"]] == ["compiled", "compiled"]
    needs_compiler()
    assert wasm.module(source)[:4] == b"\0asm"


@pytest.mark.slow
def test_every_compiler_makes_a_module_without_imports(monkeypatch):
    needs_compiler()
    source = ModuleSource(ps.model("painleve-klein"), ps.law("rigid"))
    for command in list(wasm._candidates()):
        monkeypatch.setattr(wasm, "compiler", lambda command=command: command)
        code = wasm.module(source)
        # Section 2 of a module lists imports: the first section after the types is another one.
        assert code[:8] == b"\0asm\1\0\0\0" and b"wasi_snapshot" not in code
        assert 50_000 < len(code) < 500_000


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("rodd",), "Did you mean 'rod'"),
        (("rod", "--law", "hertzz"), "Did you mean 'hertz'"),
        (("rod", "--law", "rigid", "--initial-force", "3"), "need one compliant contact"),
        (("rod", "--state", "theta=-1"), "the rod lies flat"),
        (("rod", "--t-end", "-1"), "t_end"),
        (("rod", "--set", "mu=-1"), "0 <= mu"),
        (("painleve-klein", "--law", "hertz"), "use the law rigid"),
    ],
)
def test_bad_input_is_one_sentence_and_writes_nothing(words, message, capsys, tmp_path):
    out = tmp_path / "page.html"
    code, text, error = run(capsys, "explore", *words, "--out", out)
    assert (code, text) == (2, "")
    assert message in error and error.count("\n") <= 3
    assert list(tmp_path.iterdir()) == []


def test_other_suffixes_are_rejected(capsys, tmp_path):
    code, _, error = run(capsys, "explore", "rod", "--out", tmp_path / "page.png")
    assert code == 2 and "need one of .html" in error


def test_without_a_compiler_one_sentence_says_what_helps(no_compiler, capsys, tmp_path):
    words = ("explore", "rod", "--law", "hertz", "--out", tmp_path / "page.html")
    code, _, error = run(capsys, *words)
    assert code != 0 and list(tmp_path.iterdir()) == []
    assert "no compiler for WebAssembly" in error and "painleve-sym[web]" in error
    assert ps.explore("rod").prebuilt
    with pytest.raises(CompilerMissing):
        ps.explore("rod", "hertz")


def test_each_module_of_the_page_imports_only_earlier_ones():
    seen = set()
    for name in page.MODULES:
        imported = set(re.findall(r'from "\./([\w.]+)"', page.web_text(name)))
        assert imported <= seen, name
        seen.add(name)
    assert "import " not in re.sub(r"import\(\"", "", page.script())
