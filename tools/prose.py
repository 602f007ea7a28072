"""Check of the project's English against the word list `prose.toml` beside this file.

`python tools/prose.py` checks the pages (`*.md`), the docstrings, comments and messages of Python
code, the comments of C code, and the texts of TOML files. It prints one line per offence and exits
with 1 if there are any. A line that must keep a word contains `prose: allow`.
"""

from __future__ import annotations

import ast
import io
import re
import sys
import tokenize
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ("painleve_sym", "derivations", "docs", "examples", "paper", "tests", "tools", ".github")
# Pages that `make docs` writes from the package.
GENERATED = ("docs/_generated", "docs/gallery", "docs/reference/api", "docs/sg_execution_times")
# Outputs of commands, which have the words of the commands.
EXCLUDED = ("examples/output", "tools/prose.toml", *GENERATED)
DEFINITIONS = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
# Code, the target of a link, and the names before the types in a numpydoc section.
CODE = r"(`+)((?!\n\n).)+?(?<!`)\1(?!`)|(?<=\])\([^)]*\)|(?<=\n)[\w*]+(, [\w*]+)* : "
SCOPES = ("text", "summary", "name")


@dataclass(frozen=True)
class Habit:
    """One entry of the word list: a pattern to avoid in one scope, and the better words."""

    scope: str
    avoid: re.Pattern[str]
    use: str


@dataclass(frozen=True)
class Passage:
    """A piece of a file that one scope of the word list applies to, and its line (from 1)."""

    scope: str
    line: int
    text: str


def read_habits(path: Path = ROOT / "tools" / "prose.toml") -> list[Habit]:
    """Return the word list; blanks in a pattern match line ends too."""
    habits = []
    for entry in tomllib.loads(path.read_text("utf-8"))["habit"]:
        scope = entry.get("scope", "text")
        if scope not in SCOPES:
            raise ValueError(f"{path.name}: scope {scope!r} is not one of {SCOPES}")
        pattern = entry["avoid"].replace(" ", r"[ \n]")
        bounded = {
            "text": rf"\b(?:{pattern})\b",
            "summary": rf"\A\s*(?:{pattern})\b",
            "name": rf"\A_*(?:{pattern})\Z",
        }[scope]
        flags = re.IGNORECASE if scope == "text" else re.NOFLAG
        habits.append(Habit(scope, re.compile(bounded, flags), entry["use"]))
    return habits


def passages(path: Path) -> list[Passage]:
    """Return all passages of one file, by the kind of the file."""
    text = path.read_text("utf-8")
    if path.suffix == ".py":
        return [*_python(text, "tests" not in path.relative_to(ROOT).parts), *_comments(text)]
    if path.suffix in (".c", ".h"):
        comments = re.finditer(r"/\*.*?\*/|//[^\n]*", text, re.DOTALL)
        return [Passage("text", text.count("\n", 0, m.start()) + 1, m[0]) for m in comments]
    if path.suffix == ".md":
        text = re.sub(r"^```.*?^```", _blank, text, flags=re.DOTALL | re.MULTILINE)
        headings = re.finditer(r"^#+ (.*)", text, re.MULTILINE)
        summaries = [(text.count("\n", 0, m.start()) + 1, m[1]) for m in headings]
        return [Passage("text", 1, text), *(Passage("summary", *s) for s in summaries)]
    return [Passage("text", 1, text)]


def _python(text: str, messages: bool) -> Iterator[Passage]:
    """Yield docstrings, defined names, and with `messages` strings of three words or more."""
    tree = ast.parse(text)
    docstrings = set()
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            # Strings after attributes of classes and modules document them like docstrings.
            texts = [s.value for s in body if isinstance(s, ast.Expr)]
            for value in texts:
                if isinstance(value, ast.Constant) and isinstance(value.value, str):
                    docstrings.add(value)
                    yield Passage("text", value.lineno, value.value)
                    if isinstance(node, DEFINITIONS) and value is body[0].value:
                        yield Passage("summary", value.lineno, value.value)
        yield from _names(node)
    inside = {p for n in ast.walk(tree) if isinstance(n, ast.JoinedStr) for p in ast.walk(n)}
    for node in ast.walk(tree) if messages else ():
        if isinstance(node, ast.JoinedStr):
            parts = [p.value if isinstance(p, ast.Constant) else "{}" for p in node.values]
            sentence = "".join(map(str, parts))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            if node in docstrings or node in inside:
                continue
            sentence = node.value
        else:
            continue
        if len(re.findall(r"(?<!\S)[A-Za-z,;.{}'-]+(?!\S)", sentence)) >= 3:
            yield Passage("text", node.lineno, sentence)


def _names(node: ast.AST) -> Iterator[Passage]:
    """Yield the name of the variable, parameter, function or class that a node defines."""
    if isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
        yield Passage("name", node.lineno, node.id if isinstance(node, ast.Name) else node.attr)
    elif isinstance(node, ast.arg):
        yield Passage("name", node.lineno, node.arg)
    elif isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        yield Passage("name", node.lineno, node.name)


def _comments(text: str) -> Iterator[Passage]:
    """Yield comments; lines of comment below one another are one passage."""
    lines: list[str] = []
    first = last = 0
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type != tokenize.COMMENT:
            continue
        if lines and token.start[0] == last + 1 and not token.line[: token.start[1]].strip():
            lines.append(token.string.lstrip("# "))
        else:
            yield Passage("text", first, "\n".join(lines))
            first, lines = token.start[0], [token.string.lstrip("# ")]
        last = token.start[0]
    yield Passage("text", first, "\n".join(lines))


def _blank(match: re.Match[str]) -> str:
    """Return the line ends of a match alone, so that the lines after it keep their numbers."""
    return "\n" * match[0].count("\n") or "`"


def offences(path: Path, habits: list[Habit]) -> list[str]:
    """Return one line for each offence of a file: place, words, and the better words."""
    lines = path.read_text("utf-8").splitlines()
    messages = set()
    for passage in passages(path):
        text = passage.text
        if passage.scope == "text":
            # Words are apart by one blank or line end.
            text = re.sub(r"[ \t]*\n[ \t]*", "\n", text)
            text = re.sub(CODE, _blank, text, flags=re.DOTALL)
        for habit in habits:
            for match in habit.avoid.finditer(text) if habit.scope == passage.scope else ():
                line = passage.line + text.count("\n", 0, match.start())
                if "prose: allow" not in lines[line - 1]:
                    words = " ".join(match[0].split())
                    place = path.relative_to(ROOT).as_posix()
                    messages.add((line, f"{place}:{line}: {passage.scope} '{words}': {habit.use}"))
    return [message for _, message in sorted(messages)]


def files() -> list[Path]:
    """Return the files to check."""
    kinds = {".py", ".md", ".c", ".h", ".toml", ".txt", ".yml"}
    candidates = [p for folder in FOLDERS for p in sorted((ROOT / folder).rglob("*"))]
    candidates += [*sorted(ROOT.glob("*.md")), ROOT / "Makefile"]
    return [
        path
        for path in candidates
        if (path.suffix in kinds or path.name == "Makefile")
        and not path.relative_to(ROOT).as_posix().startswith(EXCLUDED)
    ]


def main() -> int:
    """Print the offences of all files, or of those named on the command line."""
    habits = read_habits()
    chosen = [Path(a).resolve() for a in sys.argv[1:]] or files()
    messages = [message for path in chosen for message in offences(path, habits)]
    print(*messages, sep="\n", end="\n" if messages else "")
    return 1 if messages else 0


if __name__ == "__main__":
    sys.exit(main())
