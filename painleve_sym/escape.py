"""Texts of a user in other languages: one function for each, so that no text can leave its place.

Names, titles, meanings and units of a mechanism are data. What writes Python, C, HTML, LaTeX, DOT,
Mermaid, Markdown, CMake, a formula of Matplotlib or a line of a terminal takes them from here; a
command of a shell is joined by `shlex.join`.
"""

from __future__ import annotations

import html
import itertools
import json
import re
from typing import Any


def one_line(text: str) -> str:
    r"""Return text with single blanks between its words, and what is not printable as ``\u202e``.

    In comments up to the end of a line: CMake, LaTeX, Mermaid.

    >>> one_line("a title\nin two lines, and a bell: \a")
    'a title in two lines, and a bell: \\x07'
    """
    return "".join(c if c.isprintable() else _code(c) for c in " ".join(text.split()))


def _code(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")


def python_text(text: str) -> str:
    r"""Return text for a literal or docstring of Python; its value is the text, in one line.

    >>> python_text('a mass "m" of \\xi')
    'a mass \\"m\\" of \\\\xi'
    """
    return one_line(text.replace("\\", "\\\\").replace('"', '\\"'))


def c_comment(text: str) -> str:
    """Return text for a comment of C: it neither ends nor begins one, nor continues a line.

    >>> c_comment("no end */ of it")
    'no end * / of it'
    """
    return one_line(text).replace("\\", "/").replace("*/", "* /").replace("/*", "/ *")


def c_string(text: str) -> str:
    r"""Return a literal of C for the bytes of the text in UTF-8.

    >>> print(c_string('"é"'))
    "\042\303\251\042"
    """
    plain = (chr(b) if _C_PLAIN.match(chr(b)) else f"\\{b:03o}" for b in text.encode())
    return f'"{"".join(plain)}"'


_C_PLAIN = re.compile(r"[ !#->@-\[\]-~]")


def c_name(text: str) -> str:
    """Return text with all but ASCII letters, digits and underscores replaced, letters by number.

    >>> c_name("two feet/λ")
    'two_feet_u3bb'
    """
    plain = (c if c.isascii() or not c.isalnum() else f"u{ord(c):x}" for c in text)
    return re.sub(r"\W", "_", "".join(plain), flags=re.ASCII)


def html_text(text: str) -> str:
    """Return text for the content or an attribute of an element of HTML.

    >>> html_text('<a href="x">')
    '&lt;a href=&quot;x&quot;&gt;'
    """
    return html.escape(_NOT_HTML.sub("\ufffd", text))


# Controls, and halves of characters, which a byte outside UTF-8 of a command line becomes.
_NOT_HTML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]")


def html_json(data: Any) -> str:
    r"""Return data as JSON for the content of a script element of HTML, without blanks.

    >>> print(html_json({"title": "</script>"}))
    {"title":"\u003c/script>"}
    """
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def markdown_text(text: str) -> str:
    r"""Return text for a line or a cell of Markdown: no mark, no HTML.

    >>> print(markdown_text("a *b* <c>"))
    a \*b\* \<c\>
    """
    return re.sub(r"([\\`*_\[\]<>|$~])", r"\\\1", one_line(text))


def dot_string(text: str) -> str:
    r"""Return a quoted string of DOT, the language of Graphviz.

    >>> print(dot_string('my "best" rod'))
    "my \"best\" rod"
    """
    plain = one_line(text).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{plain}"'


def mermaid_string(text: str) -> str:
    """Return a quoted string of Mermaid, which writes a character by its number.

    >>> mermaid_string('slip "left"; open')
    '"slip #34;left#34;#59; open"'
    """
    plain = re.sub(r'[#";<>%]', lambda c: f"#{ord(c[0])};", one_line(text))
    return f'"{plain}"'


def figure_text(text: str) -> str:
    r"""Return text that Matplotlib shows as it is: a dollar sign begins no formula.

    >>> print(figure_text("a rod of 5 $"))
    a rod of 5 \$
    """
    return one_line(text).replace("$", r"\$")


def terminal_text(text: str) -> str:
    r"""Return text for a terminal: control characters and changes of direction are shown.

    >>> print(terminal_text("\x1b[2J"))
    \x1b[2J
    """
    return _NOT_SHOWN.sub(lambda c: _code(c[0]), text)


_NOT_SHOWN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


# ---- LaTeX ----

MAX_LATEX = 200
"""Characters of the LaTeX of a symbol."""
_LATEX = re.compile(
    r"""(?:[A-Za-z0-9 ,.'*+(){}-]|[_^](?!\^)
    |\\(?:[,;: ]|[A-Za-z]+(?![A-Za-z])))*""",
    re.VERBOSE,
)
_COMMANDS = """
    alpha beta gamma delta epsilon varepsilon zeta eta theta vartheta iota kappa lambda mu nu xi pi
    varpi rho varrho sigma varsigma tau upsilon phi varphi chi psi omega Gamma Delta Theta Lambda Xi
    Pi Sigma Upsilon Phi Psi Omega ell hbar partial nabla infty prime star ast circ dagger ddagger
    perp parallel pm mp cdot times top
    acute bar breve check ddot dddot dot grave hat mathring tilde vec widehat widetilde overline
    mathbb mathbf mathcal mathfrak mathit mathrm mathsf mathtt operatorname text
    quad
"""
_LATEX_COMMANDS = frozenset(_COMMANDS.split())


def latex_fault(text: str) -> str | None:
    r"""Return one sentence when text is not the LaTeX of a symbol, else None.

    LaTeX is a programming language that reads and writes files: letters, digits, indices,
    exponents and named letters, accents and fonts are what a symbol needs.

    >>> latex_fault(r"\dot{\theta}_\mathrm{A}") is None
    True
    """
    if len(text) > MAX_LATEX:
        return f"it has {len(text)} characters, need at most {MAX_LATEX}"
    commands = re.findall(r"\\([A-Za-z]+)", text)
    unknown = [c for c in commands if c not in _LATEX_COMMANDS]
    if unknown:
        return f"\\{unknown[0]} is not a letter, an accent or a font of LaTeX"
    if not _LATEX.fullmatch(text):
        return "it has characters that a symbol of LaTeX does not need"
    steps = ((c == "{") - (c == "}") for c in text)
    depth = list(itertools.accumulate(steps, initial=0))
    return None if min(depth) == 0 == depth[-1] else "its braces do not match"
