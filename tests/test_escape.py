"""Hostile texts in every language that the package writes: none leaves its place."""

from __future__ import annotations

import ast
import json
import re
import shlex
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.mathtext import MathTextParser

from painleve_sym.c_export import export
from painleve_sym.cli import main
from painleve_sym.cli.formula_pages import latex_page
from painleve_sym.codegen.compile import find_compiler
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, ModelError
from painleve_sym.escape import (
    _LATEX_COMMANDS,
    c_comment,
    c_name,
    c_string,
    dot_string,
    figure_text,
    html_json,
    html_text,
    latex_fault,
    markdown_text,
    mermaid_string,
    one_line,
    python_text,
    terminal_text,
)
from painleve_sym.explorer.page import Page as ExplorerPage
from painleve_sym.laws import rigid
from painleve_sym.laws.formulas import closed_forms
from painleve_sym.laws.python_module import python_module
from painleve_sym.mechanics.declarations import with_fields
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.simulator import Simulator
from painleve_sym.present.run_page import run_page, scenario_command
from painleve_sym.study.scenario import Scenario
from tests.languages import (
    CANARY,
    HOSTILE,
    dot_faults,
    html_faults,
    latex_faults,
    mermaid_faults,
    plain,
    python_faults,
)
from tests.support.exports import SLEDGE, needs_cmake

POINT = """\
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
m = { default = 2.0, unit = "kg", positive = true }
mu = { default = 0.5, unit = "1" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[[contacts]]
name = "A"
point = ["x", "y"]
friction = "mu"
"""
TEXTS = st.one_of(st.sampled_from(HOSTILE), st.text(), st.text('"\\*/<>%$#;`{}\n?&^', max_size=12))
hostile = pytest.mark.parametrize("text", HOSTILE, ids=[ascii(t)[:30] for t in HOSTILE])


@pytest.fixture(scope="module")
def point():
    return mechanism_from_text(POINT)


@pytest.fixture(scope="module")
def sections(point):
    return closed_forms(point)


def with_texts(mechanism, text):
    """Return the mechanism with the text in the place of every text of its file."""
    coordinates, parameters = (
        tuple(replace(d, meaning=text, unit=text) for d in declared)
        for declared in (mechanism.system.coordinates, mechanism.system.parameters)
    )
    system = with_fields(mechanism.system, coordinates=coordinates, parameters=parameters)
    return with_fields(mechanism, name=text, title=text, source=text, system=system)


# ---- Python ----


@pytest.fixture(scope="module")
def codes(point, sections):
    """Return the modules of the mechanism with each text."""
    return {text: python_module(with_texts(point, text), sections) for text in HOSTILE}


@hostile
def test_python_module_holds_a_text_in_docstrings_alone(codes, text):
    code = codes[text]
    assert python_faults(code) == []
    about = ast.get_docstring(ast.parse(code))
    assert f"Closed forms of {plain(f'{text}: {text}')}." in about


def test_python_modules_of_hostile_texts_are_imported_and_run_nothing(codes, tmp_path):
    for i, text in enumerate(HOSTILE):
        (tmp_path / f"m{i}.py").write_text(codes[text], "utf-8")
    (tmp_path / "run.py").write_text(
        f"import builtins, os\nran = []\nbuiltins.{CANARY} = lambda: ran.append(1)\n"
        f"os.system = ran.append\nfor i in range({len(HOSTILE)}):\n"
        "    m = __import__(f'm{i}')\n    assert m.T(m=2.0, x_dot=1.0, y_dot=0.0) == 1.0\n"
        "print(ran)\n"
    )
    done = subprocess.run(
        [sys.executable, "run.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.stderr) == ("[]\n", "")


@given(TEXTS)
def test_python_text_is_the_text_in_one_line(text):
    for quotes in ('"', '"""'):
        value = ast.literal_eval(f"{quotes}{python_text(text)}{quotes}")
        assert value == plain(text)


def test_file_that_runs_code_in_the_module_of_its_formulas(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    title = '"x\\"\\"\\"\\nimport os\\nos.system(\\"touch canary\\")\\n\\"\\"\\""'
    (tmp_path / "e.toml").write_text(f"name = {title}\ntitle = {title}\n{POINT}", "utf-8")
    assert main(["derive", "e.toml", "--format", "python"]) == 0
    (tmp_path / "m.py").write_text(capsys.readouterr().out, "utf-8")
    subprocess.run([sys.executable, "m.py"], cwd=tmp_path, check=True)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["e.toml", "m.py"]


@pytest.mark.parametrize("name", ["math", "first", "gap_rate"])
def test_parameter_of_a_name_that_the_python_module_needs_is_refused(name):
    text = POINT.replace("m = {", f"{name} = {{").replace('mass = "m"', f'mass = "{name}"')
    with pytest.raises(InputError, match=rf"'{name}' is a name of its own\. Fix: rename"):
        python_module(mechanism_from_text(text))


@hostile
def test_name_of_a_contact_that_is_part_of_other_names_is_refused(text):
    if not f"_{text}".isidentifier():
        with pytest.raises(ModelError, match=r"need|not usable"):
            mechanism_from_text(POINT.replace('"A"', json.dumps(text)))


# ---- C ----


def test_c_strings_print_the_texts_and_comments_hold_them(tmp_path):
    texts = [text.replace("\0", "") for text in HOSTILE]
    lines = [f"  puts({c_string(t)}); /* {c_comment(t)} */" for t in texts]
    names = [f"static int n{i}_{c_name(t)} = {i};" for i, t in enumerate(texts)]
    code = ["#include <stdio.h>", *names, "int main(void) {", *lines]
    code += [f"  return n{i}_{c_name(t)} != {i};" for i, t in enumerate(texts)]
    (tmp_path / "t.c").write_text("\n".join([*code, "}"]) + "\n", "ascii", "replace")
    flags = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-trigraphs")
    command = [*find_compiler().command, *flags, "-o", "t", "t.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    printed = subprocess.run([tmp_path / "t"], capture_output=True, check=True).stdout
    assert printed == "".join(f"{t}\n" for t in texts).encode()


@given(TEXTS)
def test_c_comment_is_one_comment_in_one_line(text):
    comment = c_comment(text)
    assert "*/" not in comment and "/*" not in comment and "\\" not in comment
    assert comment.isprintable()


def test_names_of_c_that_differ_in_a_letter_differ():
    assert c_name("棒") != c_name("杖")
    assert re.fullmatch(r"\w+", c_name("棒 a/b"), re.ASCII)


# ---- pages ----


class _Elements(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.data, self.attributes = [], "", []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs

    def handle_data(self, data):
        self.data += data


@given(TEXTS)
def test_html_text_is_the_content_or_an_attribute_of_its_element(text):
    shown = re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f]", "\ufffd", text)
    page = _Elements(f'<p title="{html_text(text)}">{html_text(text)}</p>')
    assert page.tags == ["p"]
    assert page.data == shown and page.attributes == [("title", shown)]


@given(TEXTS)
def test_html_json_is_the_data_and_leaves_no_script_element(text):
    content = html_json({"title": text})
    assert json.loads(content) == {"title": text}
    assert html_faults(f'<script type="application/json">{content}</script>') == []
    assert "<" not in content


@hostile
def test_markdown_text_has_no_mark(text):
    shown = markdown_text(text)
    assert re.sub(r"\\[\\`*_\[\]<>|$~]", "", shown).isprintable()
    assert not re.search(r"(?<!\\)(?:\\\\)*[`*_\[\]<>|$~]", shown)


def test_whole_pages_of_hostile_texts_run_none_of_them(tmp_path):
    """The report of a motion, its film, and the page of the explorer."""
    file, text = tmp_path / "sledge.toml", " ".join(HOSTILE)
    file.write_text(SLEDGE + '[[shapes]]\nstick = [["x", "h"], ["x + 0.1", "h"]]\n', "utf-8")
    scenario = Scenario(str(file), law="rigid", t_end=0.02, title=text)
    run = scenario.simulate()
    data = {"description": {"mechanism": {"title": text, "meanings": [text]}}}
    pages = {
        "report": run_page(scenario, run).html(),
        "film": run.animate(duration=0.1, width=200).html(),
        "explorer": ExplorerPage(text, "rigid", ("taylor",), False, 0, data).html,
    }
    for name, page in pages.items():
        assert html_faults(page) == [], name
        assert (CANARY in page) == (name != "film"), name  # a film has the name alone
        assert "<svg/onload" not in page and "<img src=x" not in page, name


# ---- graphs ----


@hostile
def test_automaton_of_a_hostile_name_is_one_graph(automaton, text):
    automaton = with_fields(automaton, name=text)
    assert dot_faults(automaton.graphviz()) == []
    assert mermaid_faults(automaton.mermaid()) == []
    assert json.loads(dot_string(text).replace("\\\\", "\\u005c")) == one_line(text)


@pytest.fixture(scope="module")
def automaton():
    return Simulator(model("block"), rigid()).automaton


def test_checkers_of_graphs_find_what_is_wrong(automaton):
    wrong = automaton.graphviz().replace("digraph ", 'digraph "my "best" rod"')
    assert dot_faults(wrong)
    assert mermaid_faults('stateDiagram-v2\n    state "a"b" as c')


@given(TEXTS)
def test_mermaid_string_has_no_quote_within(text):
    assert re.fullmatch(r'"[^"]*"', mermaid_string(text))


# ---- LaTeX and figures ----


@hostile
def test_latex_page_holds_a_text_in_comments_alone(point, sections, text):
    assert latex_faults(latex_page(with_texts(point, text), sections)) == []


@pytest.mark.parametrize(
    ("latex", "fault"),
    [
        (r"\dot{x}_\mathrm{A}", None),
        (r"\varphi_{1,2}^*", None),
        (r"\input{x}", r"\\input"),
        (r"\immediate\write18{x}", r"\\immediate"),
        ("^^5cinput x", "characters"),
        ("x%", "characters"),
        ("x}{", "braces"),
        ("{x", "braces"),
        ("x\n", "characters"),
        ("x" * 300, "300 characters"),
    ],
)
def test_latex_of_a_symbol_is_letters_accents_and_fonts(latex, fault):
    answer = latex_fault(latex)
    assert (answer is None) == (fault is None)
    assert fault is None or re.search(fault, answer)
    text = POINT.replace('x = { unit = "m" }', f'x = {{ unit = "m", latex = {json.dumps(latex)} }}')
    if fault is None:
        assert mechanism_from_text(text).latex_names["x"] == latex
    else:
        with pytest.raises(ModelError, match=r"line 2, coordinates\.x\.latex: .*Fix: write one"):
            mechanism_from_text(text)


@pytest.mark.parametrize("command", sorted(_LATEX_COMMANDS))
def test_every_command_of_a_symbol_is_one_that_figures_can_draw(command):
    parser = MathTextParser("agg")
    for formula in (rf"$\{command}{{x}}$", rf"$\{command} x$"):
        try:
            parser.parse(formula)
            return
        except ValueError:
            pass
    raise AssertionError(command)


def test_figure_text_with_dollars_is_no_formula():
    for text in (t for t in HOSTILE if "$" in t):
        assert MathTextParser("agg").parse(f"{figure_text(text)}").width > 0
        assert not re.search(r"(?<!\\)\$", figure_text(text))


# ---- terminal, shell and CMake ----


def test_title_of_a_file_does_not_control_the_terminal(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    title = json.dumps("a \x1b]0;title\x07 \x1b[2J \u202e b")
    (tmp_path / "e.toml").write_text(f"title = {title}\n{POINT}", "utf-8")
    assert main(["models", "e.toml"]) == 0
    shown = capsys.readouterr().out
    assert "\\x1b[2J" in shown and not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", shown)


@given(TEXTS)
def test_terminal_text_has_no_control_character(text):
    assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", terminal_text(text))


@hostile
def test_command_of_a_report_is_the_words_it_is_made_of(text):
    words = shlex.split(scenario_command(Scenario(text, law=text)))
    assert words[2] == text and words[words.index("--law") + 1] == text


def test_comments_of_cmake_hold_the_texts(tmp_path):
    needs_cmake()
    line = Path(export.__file__).with_name("templates").joinpath("CMakeLists.txt").read_text()
    assert line.startswith("# $title")
    lines = [f"# {one_line(text)}\nmessage({i})" for i, text in enumerate(HOSTILE)]
    (tmp_path / "t.cmake").write_text("\n".join(lines) + "\n", "utf-8")
    command = ["cmake", "-P", "t.cmake"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == "" and done.stderr.split() == [str(i) for i in range(len(HOSTILE))]
    assert [p.name for p in tmp_path.iterdir()] == ["t.cmake"]


@given(TEXTS)
def test_a_comment_is_one_line_of_what_is_printable(text):
    assert one_line(text).isprintable()
