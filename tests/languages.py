"""Checkers of what the package writes in other languages: hostile texts, and what must hold."""

from __future__ import annotations

import ast
import re
from html.parser import HTMLParser

CANARY = "painleve_canary"
"""A call of this name tells that a text was executed; nothing of the package is named so."""

HOSTILE = (
    # Python
    f'x"""\n{CANARY}()\n"""',
    f"x'''\n{CANARY}()\n'''",
    f'";{CANARY}();"',
    f"{{{CANARY}()}}",
    *("\\", '"', "\\x", "\\xi", "\\u12", "\\N{", '\\"', '\\""""', "ends in \\", "a\\\nb"),
    # C, CMake, Makefile, shell
    f"*/ int {CANARY}; /*",
    *("// \\", "??/", "/* a", '"); abort(); //', "%s%n%d", "$(touch canary)", "`touch canary`"),
    *("#[[", "]]", "${HOME}", "$ENV{HOME}", "; touch canary", "\ntouch canary", "\tcanary"),
    # HTML and JavaScript
    f"</script><script>{CANARY}()</script>",
    f"<!-- <script> {CANARY}()",
    f'"><img src=x onerror="{CANARY}()">',
    *("]]>", "&amp;", "\u2028", "<svg/onload=1>", "${1}", "</title>", "--><b>"),
    # LaTeX
    "\\immediate\\write18{touch canary}",
    "\\input{/etc/passwd}",
    *("^^5cinput x", "a\n\\[", "%", "$x$", "$", "\\end{document}", "{", "}"),
    # DOT, Mermaid, Markdown
    *(
        '" -> "b',
        '"]; x [label="',
        "%%{init: {}}%%",
        "\n    a --> b",
        "[a](javascript:1)",
        "|",
        "#",
    ),
    # terminal and other alphabets
    *("\x1b]0;title\x07", "\x1b[2J", "\x9b2J", "\r", "\u202eabc", "\0", "\ufeff", "棒", "é"),
)
"""Names, titles, meanings and units that try to leave their place."""


def plain(text: str) -> str:
    """Return the text in one line, as literals and attributes hold it."""
    return " ".join(text.split())


def python_faults(text: str) -> list[str]:
    """Return what is wrong with a module of closed forms: it holds functions and nothing else."""
    try:
        module = ast.parse(text)
    except (SyntaxError, ValueError) as error:
        return [f"not Python: {error}"]
    first, second, *rest = module.body
    faults = [] if ast.get_docstring(module) else ["no docstring"]
    if not isinstance(first, ast.Expr) or ast.unparse(second) != "import math":
        faults.append("another begin than a docstring and `import math`")
    names = {function.name for function in rest if isinstance(function, ast.FunctionDef)}
    faults += [f"a statement: {ast.unparse(s)[:80]}" for s in rest if not hasattr(s, "name")]
    for function in rest:
        docstring, *body = function.body
        if not (isinstance(docstring, ast.Expr) and isinstance(docstring.value, ast.Constant)):
            faults.append(f"{function.name} begins with {ast.unparse(docstring)[:80]}")
        if any(isinstance(s, ast.Expr) for s in body):
            faults.append(f"{function.name} has a call besides its docstring")
        called = [n.func for s in body for n in ast.walk(s) if isinstance(n, ast.Call)]
        texts = {ast.unparse(f) for f in called}
        other = {t for t in texts if t not in names and not t.startswith("math.")}
        faults += [f"{function.name} calls {other}"] if other - {"abs"} else []
    return faults


_DOT = re.compile(
    r'\s*(?:digraph ("(?:[^"\\]|\\.)*") \{|rankdir=LR;|node \[shape=box\];|'
    r'"(?:[^"\\]|\\.)*" -> "(?:[^"\\]|\\.)*" \[label="(?:[^"\\]|\\.)*"\];|\})\n'
)


def dot_faults(text: str) -> list[str]:
    """Return what is wrong with a directed graph in DOT of nodes and edges with labels."""
    at, statements = 0, []
    while match := _DOT.match(text, at):
        at = match.end()
        statements.append(match)
    if at < len(text):
        return [f"not DOT: {text[at : at + 80]!r}"]
    ends = [m[0].strip() == "}" for m in statements]
    return [] if statements[0][1] and ends.index(True) == len(ends) - 1 else ["not one graph"]


_MERMAID = re.compile(
    r'stateDiagram-v2|    state "[^"]*" as \w+|    (?:\[\*\]|\w+) --> (?:\[\*\]|\w+)(?:: \w+)?'
)


def mermaid_faults(text: str) -> list[str]:
    """Return the lines that are neither states nor transitions of Mermaid."""
    return [line for line in text.splitlines() if not _MERMAID.fullmatch(line)]


def latex_faults(text: str) -> list[str]:
    """Return the lines that are neither comments nor formulas, and commands that TeX would run."""
    lines = text.split("\n")
    faults = [line for line in lines if line and not line.startswith(("% ", "\\[ "))]
    code = "\n".join(line for line in lines if not line.startswith("% "))
    return faults + re.findall(
        r"\\(?:input|write|immediate|openout|csname|def\b|end\{document)|\^\^", code
    )


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.faults: list[str] = []
        self.script = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.script = tag == "script"
        handlers = [n for n, v in attrs if n.startswith("on") and CANARY in (v or "")]
        if handlers or any((v or "").startswith("javascript:") for _, v in attrs):
            self.faults.append(f"<{tag}> runs a text: {attrs}")

    def handle_endtag(self, tag: str) -> None:
        self.script = False

    def handle_comment(self, data: str) -> None:
        if CANARY in data:
            self.faults.append("a text is a comment")

    def handle_data(self, data: str) -> None:
        # In the data of a script "<" begins a comment or an end tag, whatever quotes it is in.
        if self.script and CANARY in data and not data.lstrip().startswith("{"):
            self.faults.append("a text is in a script")
        if self.script and re.search(r"<(?:!--|/?script)", data, re.IGNORECASE):
            self.faults.append("a script holds the begin of a comment or script")


def html_faults(text: str) -> list[str]:
    """Return where a text of a user runs, is a comment, or ends its element in a page."""
    page = _Page()
    page.feed(text)
    page.close()
    return page.faults
