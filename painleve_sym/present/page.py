"""A page of results: one self-contained HTML file, readable in any browser and on paper."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from painleve_sym.escape import html_text as escape
from painleve_sym.files import write_beside
from painleve_sym.tables import Html, html_table
from painleve_sym.version import __version__

_STYLE = """
:root { color-scheme: light dark; --ink: #1a1a1a; --paper: #fff; --soft: #444; --line: #ccc;
  --fill: #f3f3f3; --link: #004a80; --mark: #ffd9c7; --green: #14613f; --red: #a30000;
  --brown: #9a3300; --purple: #7a1f6b; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8e8e8; --paper: #16181b; --soft: #b4b4b4;
  --line: #4a4d52; --fill: #24272b; --link: #8fc7ff; --mark: #6b2c10; --green: #7fd6ab;
  --red: #ff9a9a; --brown: #ffb38a; --purple: #e6a4d8; } }
body { font: 1rem/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper);
  margin: 0 auto; max-width: 62rem; padding: 1rem; overflow-wrap: break-word; }
h1 { font-size: 1.7rem; line-height: 1.25; }
h2 { font-size: 1.35rem; border-bottom: 1px solid var(--line); margin-top: 2.5rem; }
h3 { font-size: 1.1rem; margin: 2rem 0 0.5rem; }
a { color: var(--link); overflow-wrap: anywhere; }
pre { overflow-x: auto; background: var(--fill); padding: 0.6rem; font-size: 0.9rem; }
code { font-size: 0.92em; }
.wide { overflow-x: auto; overflow-y: hidden; padding: 0.2rem 0; }
table { border-collapse: collapse; margin: 0.8rem 0; font-variant-numeric: tabular-nums; }
th, td { border: 1px solid var(--line); padding: 0.25rem 0.55rem; text-align: left;
  vertical-align: top; overflow-wrap: normal; }
th { background: var(--fill); }
tr[hidden] { display: none; }
figure { margin: 1rem 0; }
figure svg, figure img { box-sizing: border-box; display: block; max-width: 100%; height: auto;
  background: #fff; padding: 0.4rem; border-radius: 0.3rem; }
figure.whole svg { width: 100%; }
figure.film div { display: flex; gap: 0.8rem; align-items: center; max-width: 30rem;
  margin-top: 0.5rem; }
figure.film label { display: flex; gap: 0.5rem; flex: 1; } figure.film input { flex: 1; }
figure.film output { min-width: 7rem; font-variant-numeric: tabular-nums; }
figcaption { font-size: 0.9rem; color: var(--soft); }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(18rem, 100%), 1fr));
  gap: 0.8rem; }
.pair > div { border: 1px solid var(--line); padding: 0.5rem 0.8rem; overflow: auto hidden; }
.pair p { margin: 0; font-size: 0.9rem; color: var(--soft); }
math { font-size: 1.1rem; font-family: "STIX Two Math", "Latin Modern Math", "Cambria Math",
  "Libertinus Math", "Noto Sans Math", "DejaVu Math TeX Gyre", math; }
.misprint { background: var(--mark); outline: 2px solid var(--brown); }
.verdict { font-weight: 600; white-space: nowrap; }
.reproduced { color: var(--green); } .misprint-verdict { color: var(--brown); }
.differs { color: var(--purple); } .failed { color: var(--red); }
.filter { display: flex; flex-wrap: wrap; gap: 0.8rem; align-items: center; }
.filter button, .filter input, .film button { font: inherit; padding: 0.2rem 0.7rem; }
.filter button[aria-pressed="true"] { background: var(--ink); color: var(--paper); }
footer { margin-top: 3rem; font-size: 0.9rem; color: var(--soft);
  border-top: 1px solid var(--line); }
@media (max-width: 40rem) { table { font-size: 0.85rem; } th, td { padding: 0.2rem 0.35rem; } }
@media print {
  :root { color-scheme: light; --ink: #000; --paper: #fff; --soft: #333; --link: #000; }
  body { max-width: none; font-size: 10pt; } .filter { display: none; }
  h2, h3 { break-after: avoid; } figure, .pair, tr { break-inside: avoid; }
  a { text-decoration: none; } tr[hidden] { display: table-row; }
  .wide, pre { overflow: visible; white-space: pre-wrap; }
}
"""


@dataclass(frozen=True)
class PageSection:
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
class HtmlPage:
    """A page of results: HTML before the first section, the sections, JavaScript at the end.

    The page is complete without the script.
    """

    title: str
    lead: str
    parts: Sequence[PageSection] = field(default=())
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
    """Return a table as `html_table`; the label names it for screen readers."""
    region = f'<div class="wide" tabindex="0" role="region" aria-label="{escape(label)}">'
    return f"{region}{html_table(columns, rows)}</div>"


def unit_html(unit: str) -> Html:
    """Return a unit with its exponents raised; nothing for the unit 1."""
    return Html("" if unit == "1" else re.sub(r"\^(-?\d+)", r"<sup>\1</sup>", escape(unit)))


def figure(inner: str, caption: str = "", command: str = "", whole: bool = True) -> str:
    """Return a figure of HTML, such as SVG, with its caption and the command that draws it.

    It is as wide as the page where it is not said that it keeps its own width.
    """
    again = f" Draw it alone: <code>{escape(command)}</code>" if command else ""
    below = f"<figcaption>{escape(caption)}{again}</figcaption>" if caption or again else ""
    kind = ' class="whole"' if whole else ""
    return f"<figure{kind}>{inner}{below}</figure>"
