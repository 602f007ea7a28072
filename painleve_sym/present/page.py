"""A page of results: one self-contained HTML file, readable in any browser and on paper."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from painleve_sym import __version__
from painleve_sym.escape import html_text as escape
from painleve_sym.files import write_beside

_STYLE = """
:root { color-scheme: light; }
body { font: 1rem/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff; margin: 0 auto;
  max-width: 62rem; padding: 1rem; }
h1 { font-size: 1.7rem; line-height: 1.25; }
h2 { font-size: 1.35rem; border-bottom: 1px solid #bbb; margin-top: 2.5rem; }
h3 { font-size: 1.1rem; margin: 2rem 0 0.5rem; }
a { color: #004a80; }
pre { overflow-x: auto; background: #f4f4f4; padding: 0.6rem; font-size: 0.9rem; }
code { font-size: 0.92em; }
.wide { overflow-x: auto; overflow-y: hidden; padding: 0.2rem 0; }
table { border-collapse: collapse; margin: 0.8rem 0; font-variant-numeric: tabular-nums; }
th, td { border: 1px solid #ccc; padding: 0.25rem 0.55rem; text-align: left; vertical-align: top; }
th { background: #f0f0f0; }
tr[hidden] { display: none; }
figure { margin: 1rem 0; } figure svg, figure img { max-width: 100%; height: auto; }
figcaption { font-size: 0.9rem; color: #444; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(18rem, 1fr)); gap: 0.8rem; }
.pair > div { border: 1px solid #ccc; padding: 0.5rem 0.8rem; overflow: auto hidden; }
.pair p { margin: 0; font-size: 0.9rem; color: #444; }
math { font-size: 1.1rem; }
.misprint { background: #ffd9c7; outline: 2px solid #b33c00; }
.verdict { font-weight: 600; white-space: nowrap; }
.reproduced { color: #14613f; } .misprint-verdict { color: #9a3300; } .differs { color: #7a1f6b; }
.failed { color: #a30000; }
.filter { display: flex; flex-wrap: wrap; gap: 0.8rem; align-items: center; }
.filter button, .filter input { font: inherit; padding: 0.2rem 0.7rem; }
.filter button[aria-pressed="true"] { background: #1a1a1a; color: #fff; }
footer { margin-top: 3rem; font-size: 0.9rem; color: #444; border-top: 1px solid #bbb; }
@media print {
  body { max-width: none; font-size: 10pt; } .filter { display: none; }
  h2, h3 { break-after: avoid; } figure, .pair, tr { break-inside: avoid; }
  a { color: inherit; text-decoration: none; } tr[hidden] { display: table-row; }
  .wide, pre { overflow: visible; white-space: pre-wrap; }
}
"""


@dataclass(frozen=True)
class Part:
    """A section of a page: HTML, an anchor that may be empty, and the level of its heading."""

    title: str
    body: str
    anchor: str = ""
    level: int = 2

    def html(self) -> str:
        """Return the heading and what follows."""
        anchor = f' id="{escape(self.anchor)}"' if self.anchor else ""
        return f"<h{self.level}{anchor}>{escape(self.title)}</h{self.level}>\n{self.body}"


@dataclass(frozen=True)
class Page:
    """A page of results: HTML before the first section, the sections, JavaScript at the end.

    The page is complete without the script.
    """

    title: str
    lead: str
    parts: Sequence[Part] = field(default=())
    script: str = ""

    def html(self) -> str:
        """Return the whole file as text."""
        title = escape(self.title)
        body = "\n".join(part.html() for part in self.parts)
        script = f"<script>{self.script}</script>\n" if self.script else ""
        return (
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f"<title>{title}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
            f"<main>\n<h1>{title}</h1>\n{self.lead}\n{body}\n</main>\n"
            f"<footer><p>Written by painleve-sym {escape(__version__)}.</p></footer>\n"
            f"{script}</body>\n</html>\n"
        )

    def write(self, path: Path) -> None:
        """Write the file whole, or not at all."""
        text = self.html()
        write_beside(path, lambda file: file.write(text.encode()))


def paragraph(text: str) -> str:
    """Return a paragraph of plain text."""
    return f"<p>{escape(text)}</p>"


def preformatted(text: str, label: str) -> str:
    """Return text that keeps its lines; `label` names it for screen readers."""
    return f'<pre tabindex="0" role="region" aria-label="{escape(label)}">{escape(text)}</pre>'


def table(columns: Sequence[str], rows: Iterable[Sequence[Any]], label: str) -> str:
    """Return a table with a heading row; numbers have ten digits, other values are text.

    The label names the table for screen readers.
    """
    return html_table(columns, ([escape(cell_text(v)) for v in row] for row in rows), label)


def html_table(columns: Sequence[str], texts: Iterable[Sequence[str]], label: str) -> str:
    """Return a table of cells that are HTML; see `table`."""
    head = "".join(f'<th scope="col">{escape(c)}</th>' for c in columns)
    lines = [f"<tr>{''.join(f'<td>{text}</td>' for text in row)}</tr>" for row in texts]
    return (
        f'<div class="wide" tabindex="0" role="region" aria-label="{escape(label)}"><table>'
        f"<thead><tr>{head}</tr></thead><tbody>{''.join(lines)}</tbody></table></div>"
    )


def cell_text(value: Any) -> str:
    """Return the text of a cell of a table, before any marks are escaped."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def figure(inner: str, caption: str = "", command: str = "") -> str:
    """Return a figure of HTML, such as SVG, with its caption and the command that draws it."""
    again = f" Draw it alone: <code>{escape(command)}</code>" if command else ""
    below = f"<figcaption>{escape(caption)}{again}</figcaption>" if caption or again else ""
    return f"<figure>{inner}{below}</figure>"
