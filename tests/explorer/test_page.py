"""Pages as files: what they hold, how large they are, and sentences where there can be none."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import subprocess
import sys
from pathlib import Path

import pytest

import painleve_sym as ps
from painleve_sym.engines.protocol import DEFAULT_RTOL
from painleve_sym.errors import CompilerMissing
from painleve_sym.explorer import page, script, wasm
from painleve_sym.explorer.exact_start import exact_start
from painleve_sym.explorer.first_map import first_map
from painleve_sym.explorer.prebuilt import STORED, default_law, stored_digest, stored_module
from painleve_sym.explorer.source import ModuleSource
from painleve_sym.mechanics import Shape
from painleve_sym.mechanics.models import MODELS
from painleve_sym.motion.energy_balance import balance_closes, balance_notice
from tests.cli.cli_helpers import run, run_json
from tests.support.exports import SLEDGE

MAX_PAGE = 650_000


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
    path.write_text(SLEDGE, "utf-8")
    return path


def needs_compiler():
    try:
        wasm.compiler()
    except CompilerMissing:
        pytest.skip("there is no compiler for WebAssembly: see `make setup-browser`")


# ---- the page ----


def check_page(shown, name):
    assert len(shown.html.encode()) < MAX_PAGE
    # Nothing in it is to be loaded: addresses stand only in texts and in the names of SVG.
    outside = data_of(shown.html) and re.sub(r'id="data">.*?</script>', "", shown.html, flags=re.S)
    assert re.findall(r"https?://[^\"'` ]+", outside) == ["http://www.w3.org/2000/svg"]
    assert not re.search(r"<(link|img|iframe|script[^>]* src)|@import|url\(|\bfetch\(", outside)
    assert "default-src 'none'" in outside
    description = data_of(shown.html)["description"]
    assert description["scene"] is not None
    assert [q["name"] for q in description["states"]] == list(ps.model(name).state_names)


def test_page_of_the_rod_is_one_small_file_that_needs_no_compiler(no_compiler):
    shown = ps.explore("rod")
    assert shown.prebuilt
    check_page(shown, "rod")


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in MODELS if name != STORED])
def test_page_of_every_named_mechanism_is_one_small_file(name):
    needs_compiler()
    check_page(ps.explore(name), name)


def test_a_text_of_the_mechanism_stays_in_its_element():
    shown = ps.explore("rod")
    hostile = "a <!-- b <script> c </script> \u2028 '\" ${d} ]]>"
    description = json.loads(json.dumps(shown.data["description"]))
    description["mechanism"]["title"] = hostile
    other = dataclasses.replace(shown, data={**shown.data, "description": description})
    assert data_of(other.html)["description"]["mechanism"]["title"] == hostile
    # No element begins within the data: an HTML parser skips their end where one does.
    (text,) = re.findall(r'id="data">(.*?)</script>', other.html, re.S)
    assert "<" not in text and other.html.count("<script") == 2


def test_words_of_the_page_have_the_meanings_of_the_glossary():
    glossary = Path(__file__).parents[2].joinpath("docs", "reference", "glossary.md")
    rows = {}
    for line in re.findall(r"^\| (?!term|---)(.*) \|$", glossary.read_text("utf-8"), re.M):
        terms, meaning = line.split(" | ")[:2]
        plain = terms.replace("$", "").replace("\\mu", "μ").replace("'", "′")
        rows |= dict.fromkeys(plain.split(", "), meaning.replace("`", ""))
    words = data_of(ps.explore("rod").html)["words"]
    assert len(words) > 15
    # Formulas, which a tooltip cannot show, stand at the end.
    for word, meaning in words.items():
        own, end = rows[word][: len(meaning)], rows[word][len(meaning) :]
        assert own == meaning and (not end or end[0] in ",:;"), word


def test_the_law_of_a_page_is_that_of_simulate_and_virgin_only_of_the_papers_presets():
    data = ps.explore("rod").data
    motions = data["description"]["motions"]
    shown = ["law", "choices"]
    assert [[m[key] for key in shown] for m in motions] == [
        ["bilinear-hertz", {"reload": "elastic"}],
        ["bilinear-hertz", {"reload": "virgin"}],
        ["rigid", dict(ps.RigidLaw().choices)],
    ]
    assert motions[0]["choices"] == dict(ps.law("bilinear-hertz").choices)
    assert data["initial"]["reload"] == "elastic"
    assert {p["settings"]["reload"] for p in data["presets"]} == {"virgin"}
    virgin = ps.explore("rod", ps.law("bilinear-hertz", reload="virgin"))
    assert virgin.prebuilt and virgin.data["initial"]["reload"] == "virgin"
    feet = ModuleSource(ps.model("block-two-feet"), ps.law("bilinear-hertz"))
    assert [s.choices.get("reload") for s in feet.simulators] == ["elastic", None]


def test_a_law_with_other_defaults_begins_with_them():
    shown = ps.explore("rod", ps.laws.bilinear_hertz(E=1e13, e_energetic=0.5))
    values = shown.data["initial"]["values"]
    assert shown.prebuilt and (values["E"], values["e_energetic"]) == (1e13, 0.5)


def test_the_energy_balance_of_a_page_has_the_rule_and_sentence_of_a_run():
    tolerances = ps.explore("rod").data["tolerances"]
    rtol, limit = tolerances["rtol"], tolerances["openFrom"]
    assert rtol == DEFAULT_RTOL
    assert balance_closes(0.999 * limit, rtol) and not balance_closes(limit, rtol)
    text = re.sub(r"`\s*\+\s*`", "", script.web_text("motion.js"))
    sentence, _, _ = balance_notice(0.013, rtol).partition(" Fix: ")
    first, _, last = sentence.partition("1.3 %")
    assert f"{first}${{short(100 * residual, 2)}} %" in text
    assert last.replace("1e-11", "${rtol}") in text
    assert balance_notice(float("inf"), rtol) in text


def test_few_quantities_stand_first():
    description = ps.explore("rod").data["description"]
    every = [*description["states"], *description["parameters"]]
    leading = [q["name"] for q in every if q["leading"]]
    assert leading == ["theta", "x_A_dot", "theta_dot", "mu", "E", "e_energetic"]


WEDGE = """
[coordinates]
x = { unit = "m", meaning = "place of the wedge's tip" }
y = { unit = "m", meaning = "height of the wedge above the floor" }
z = { unit = "m", meaning = "height of the foot of the post" }
[parameters]
M = { default = 3.0, unit = "kg", meaning = "mass of each", positive = true }
k = { default = 500.0, unit = "N/m", meaning = "stiffness of the spring", positive = true }
alpha = { default = 0.35, unit = "rad", meaning = "angle of the wedge", upper = 1.5 }
mu_1 = { default = 0.3, unit = "1", meaning = "friction wedge on floor" }
mu_2 = { default = 0.2, unit = "1", meaning = "friction post on wedge" }
[[bodies]]
name = "wedge"
mass = "M"
centre = ["x + 0.2", "y + 0.05"]
[[bodies]]
name = "post"
mass = "M"
centre = ["0.1", "z + 0.2"]
[[springs]]
extension = "0.1*t - x"
stiffness = "k"
[[contacts]]
name = "floor"
point = ["x", "y"]
friction = "mu_1"
[[contacts]]
name = "face"
gap = "(z - y - (0.1 - x)*tan(alpha))*cos(alpha)"
slip_velocity = "-x_dot*cos(alpha) + (z_dot - y_dot)*sin(alpha)"
friction = "mu_2"
[start]
z = 0.0365
x_dot = 0.05
"""


def test_a_start_that_is_compressed_by_rounding_is_closed(tmp_path):
    path = tmp_path / "wedge.toml"
    path.write_text(f'name = "wedge"\ntitle = "wedge under a post"\ngravity = "9.81"\n{WEDGE}')
    wedge = ps.load_mechanism(path)
    state, notes = exact_start(wedge)
    assert state["z"] == pytest.approx(0.1 * math.tan(0.35), rel=1e-12)
    assert {n: v for n, v in state.items() if n != "z"} == {
        n: wedge.start.get(n, 0.0) for n in state if n != "z"
    }
    assert notes == [
        "z is 0.0365028495 m, which closes the contact face; the mechanism's start has 0.0365."
    ]
    # A compression that is meant stays, and so do exact starts.
    pressed = dataclasses.replace(wedge, start={"z": 0.03})
    assert exact_start(pressed) == ({**state, "z": 0.03, "x_dot": 0.0}, [])
    rod = ps.model("rod")
    assert exact_start(rod) == ({**dict.fromkeys(rod.state_names, 0.0), **rod.start}, [])


@pytest.mark.slow
def test_the_first_map_prefers_a_contact_whose_start_is_not_on_a_border(monkeypatch):
    feet = ps.model("block-two-feet")
    assert first_map(feet, [-1, -1]).contact == 0
    # With mu_A at W_nn / W_nt the slope A of the first foot is zero at the start.
    at = ps.classify(feet, feet.start).problem
    border = at.W[0, 0] / abs(at.W[0, 1])
    held = feet.with_parameters(mu_A=border)
    slip = -1 if at.W[0, 1] < 0 else 1
    assert first_map(held, [slip, slip]).contact == 1


@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(
            n,
            marks=pytest.mark.slow if n in ("rod-bending", "pr-robot", "block-two-feet") else (),
        )
        for n in MODELS
    ],
)
def test_first_map_of_every_named_mechanism_has_two_regions(name):
    mechanism = ps.model(name)
    shown = first_map(mechanism, [-1] * len(mechanism.outline.contacts))
    assert shown.regions >= 2
    contact = mechanism.outline.contacts[shown.contact].name
    alone = mechanism if len(mechanism.outline.contacts) == 1 else mechanism.only(contact)
    held = {n: v for n, v in mechanism.start.items() if n not in shown.ranges}
    grid = ps.region_map(
        alone, tuple(shown.ranges), ranges=dict(shown.ranges), points=31, slip=-1, state=held
    )
    # At other points than those that the choice was made of.
    counts = [n for case, n in grid.counts.items() if case != "outside"]
    assert sorted(counts)[-2] >= 0.01 * 31**2


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


def test_commands_and_sizes_of_the_docs_hold(capsys, tmp_path, monkeypatch):
    text = Path(__file__).parents[2].joinpath("docs", "explorer.md").read_text("utf-8")
    monkeypatch.chdir(tmp_path)
    commands = re.findall(r"^painleve (explore rod .*)$", text, re.M)
    assert len(commands) == 2
    for command in commands:
        data = run_json(capsys, *command.split())
        assert data["prebuilt"] and Path(data["file"]).stat().st_size == data["bytes"]
    (size,) = re.findall(r"page of the rod has (\d+) kB", text)
    assert len(ps.explore("rod").html.encode()) == pytest.approx(1000 * int(size), rel=0.03)


# ---- the stored module, and those of the cache ----


def test_stored_module_is_up_to_date():
    mechanism = ps.model(STORED)
    source = ModuleSource(mechanism, default_law(mechanism))
    assert stored_digest() == source.digest, "run `make explorer-modules`"
    _, description = stored_module(mechanism, default_law(mechanism))
    assert description == json.loads(json.dumps(source.description))


def test_stored_module_serves_only_what_it_was_made_of():
    rod = ps.model("rod")
    assert stored_module(rod, default_law(rod)) is not None
    assert stored_module(rod, ps.law("bilinear-hertz", reload="virgin")) is not None
    assert stored_module(rod, ps.law("bilinear-hertz", friction="static")) is None
    assert stored_module(rod, ps.law("hertz")) is None
    feet = ps.model("block-two-feet")
    assert stored_module(feet, default_law(feet)) is None
    # Other defaults are numbers that the page begins with.
    other = rod.with_parameters(mu=1.1)
    assert stored_module(other, default_law(other)) is not None
    assert data_of(ps.explore(other).html)["initial"]["values"]["mu"] == 1.1
    # Another drawing or text is another page.
    for change in ({"shapes": ()}, {"title": "another"}):
        assert stored_module(dataclasses.replace(rod, **change), default_law(rod)) is None


def test_a_module_is_compiled_once_and_then_comes_from_the_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("PAINLEVE_CACHE", str(tmp_path / "cache"))
    calls = []
    monkeypatch.setattr(wasm, "compiler", lambda: ("cc",))
    monkeypatch.setattr(wasm, "_compiled", lambda *given: calls.append(given) or b"\0asm")
    source = type("Source", (), {"files": {"a.c": "int a;"}, "units": ("a.c",)})
    assert [wasm.module(source), wasm.module(source)] == [b"\0asm", b"\0asm"]
    assert len(calls) == 1
    # Neither needs a compiler any more, nor does another text find that module.
    monkeypatch.setattr(wasm, "compiler", lambda: pytest.fail("asked for a compiler"))
    assert wasm.module(source) == b"\0asm"
    source.files = {"a.c": "int b;"}
    with pytest.raises(pytest.fail.Exception):
        wasm.module(source)


def test_second_page_derives_nothing_and_is_the_same(cache, monkeypatch, sledge):
    monkeypatch.setattr(wasm, "compiler", lambda: ("cc",))
    monkeypatch.setattr(wasm, "_compiled", lambda *_: b"\0asm")
    mechanism = ps.load_mechanism(sledge)
    first = ps.explore(mechanism, "linear").html

    def refuse(*_):
        raise AssertionError("this should have come from the cache")

    monkeypatch.setattr(ModuleSource, "files", property(refuse))
    monkeypatch.setattr(ModuleSource, "_first_map", property(refuse))
    assert ps.explore(mechanism, "linear").html == first
    # Other numbers of the start or of the law are another description.
    for other in (
        lambda: ps.explore(mechanism.with_parameters(m=3.0), "linear"),
        lambda: ps.explore(mechanism, ps.laws.linear(k=1e5)),
    ):
        with pytest.raises(AssertionError):
            other()
    # Where the module is gone or damaged both are made again.
    monkeypatch.undo()
    monkeypatch.setenv("PAINLEVE_CACHE", str(cache))
    monkeypatch.setattr(wasm, "compiler", lambda: ("cc",))
    monkeypatch.setattr(wasm, "_compiled", lambda *_: b"\0asm")
    for path in cache.glob("*.json"):
        if b'"module"' in path.read_bytes():
            path.write_bytes(b"damaged")
    assert ps.explore(mechanism, "linear").html == first


def test_page_of_another_drawing_text_or_law_is_made_of_another_text():
    feet = ps.model("block-two-feet")
    drawn = {"shapes": (Shape.dot((0, 0)),)}
    changes = (drawn, {"title": "another"}, {"sketch": "another"}, {"start": {}})
    mechanisms = [feet, *(dataclasses.replace(feet, **change) for change in changes)]
    texts = [ModuleSource(m, ps.law("rigid")).definition for m in mechanisms]
    texts.append(ModuleSource(feet, ps.law("hertz")).definition)
    assert len(set(texts)) == len(texts)
    whole = ModuleSource(MODELS["block-two-feet"](), ps.law("rigid"))
    assert whole.definition == texts[0]


# ---- mechanisms and laws of one's own ----


@pytest.mark.slow
def test_a_mechanism_without_shapes_has_a_page_without_a_drawing(sledge, capsys, tmp_path):
    needs_compiler()
    out = tmp_path / "sledge.html"
    data = run_json(capsys, "explore", sledge, "--law", "linear", "--out", out)
    assert not data["prebuilt"] and data["bytes"] == out.stat().st_size < MAX_PAGE
    text = out.read_text("utf-8")
    description = data_of(text)["description"]
    assert description["scene"] is None
    # A text from a file cannot end the element that holds it.
    title = ps.load_mechanism(sledge).title
    assert "</script>" in title and description["mechanism"]["title"] == title
    assert text.count("</script>") == 2


def test_links_lead_to_the_documentation_that_is_given(capsys, tmp_path):
    assert ps.explore("rod").data["docs"] is None
    out = tmp_path / "rod.html"
    run_json(capsys, "explore", "rod", "--docs", "..", "--out", out)
    assert data_of(out.read_text("utf-8"))["docs"] == ".."
    # Every page that a panel names is one of the documentation.
    named = re.findall(r'"([\w/-]+)",\n +[\["`]|#more\("([\w/-]+)"', script.web_text("page.js"))
    names = {a or b for a, b in named}
    assert names == {"impacts", "maps", "complementarity", "reference/events", "explorer", "index"}
    docs = Path(__file__).parents[2] / "docs"
    assert all((docs / f"{name}.md").is_file() for name in names)


@pytest.mark.slow
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


def test_without_a_compiler_one_sentence_says_what_helps(
    no_compiler, cache, capsys, tmp_path, sledge
):
    words = ("explore", sledge, "--law", "linear", "--out", tmp_path / "page.html")
    code, _, error = run(capsys, *words)
    assert code != 0 and not (tmp_path / "page.html").exists()
    assert "no compiler for WebAssembly" in error and "painleve-sym[web]" in error
    assert "the rod with its default law needs neither" in error
    assert ps.explore("rod").prebuilt
    with pytest.raises(CompilerMissing):
        ps.explore(sledge, "linear")


def test_each_module_of_the_page_imports_only_earlier_ones():
    seen = set()
    for name in script.MODULES:
        imported = set(re.findall(r'from "\./([\w.]+)"', script.web_text(name)))
        assert imported <= seen, name
        seen.add(name)
    assert "import " not in re.sub(r"import\(\"", "", page.script())
