"""A reproduction as files (report, figures, numbers) and as a table for the terminal."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path

from painleve_sym.errors import InputError
from painleve_sym.escape import html_text as escape
from painleve_sym.escape import markdown_text
from painleve_sym.files import write_beside
from painleve_sym.papers.item import Verdict
from painleve_sym.papers.registry import Item, Reproduction
from painleve_sym.present.figures import draw
from painleve_sym.present.page import HtmlPage, PageSection, figure, paragraph, table
from painleve_sym.present.style import Look, inline_svg, save
from painleve_sym.quantities import counted
from painleve_sym.tables import Html, cell_text, markdown_table, text_lines

FIGURES = "figures"
"""Folder of the figures below the report."""
WIDTH = 100
"""Columns of the terminal table."""
_HEADINGS = {"beyond": "beyond the paper", "physical": "physical values"}
"""Of groups that have another heading than their plural."""
_COLUMNS, _WIDTHS = ("item", "paper", "computed", "verdict"), (20, 31, 31, 12)
ON_RECORD = (
    "On record is the verdict that the authors of this program reached for each item when they "
    "compared it with the print; a verdict that differs from it has changed since."
)
_COPY = "or fault of the copy"
VERDICTS = {
    "reproduced": "agrees within the digits printed, or the words hold",
    "misprint": "a small correction of the text that was read makes it agree",
    "or fault of the copy": "the copy that was read came through character recognition, and the "
    "print itself may be right",
    "differs": "it does not agree, for the reason given",
    "failed": "the computation ended with an error",
}


def write_report(
    reproduction: Reproduction, out_dir: str | Path, look: Look | None = None
) -> tuple[Path, ...]:
    """Write ``report.md``, ``report.html``, ``results.json`` and the figures as PNG and SVG.

    Every file is written beside its name and then renamed: a reader never sees half of one. Return
    all files, the report first. InputError where the folder cannot be made or written.
    """
    out = Path(out_dir)
    try:
        (out / FIGURES).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"report folder {out}: {error.strerror}. Fix: name a folder that can be written."
        ) from error
    figures: dict[str, tuple[Path, ...]] = {}
    for item in reproduction.items:
        if item.series is not None:
            label = reproduction.label(item)
            panels = draw(item.series, look.width if look else None)
            figures[label] = save(panels, out / FIGURES / label, look)
    report, page, results = (out / n for n in ("report.md", "report.html", "results.json"))
    _write(results, _results(reproduction, figures, out))
    _write(report, markdown(reproduction))
    texts = {label: svg.read_text("utf-8") for label, (_, svg, *_) in figures.items()}
    report_page(reproduction, texts).write(page)
    return (report, page, results, *(path for paths in figures.values() for path in paths))


def _write(path: Path, text: str) -> None:
    write_beside(path, lambda file: file.write(text.encode()))


def _results(reproduction: Reproduction, figures: dict[str, tuple[Path, ...]], out: Path) -> str:
    data = reproduction.to_dict()
    for item, entry in zip(reproduction.items, data["items"], strict=True):
        files = figures.get(reproduction.label(item), ())
        entry["figures"] = [path.relative_to(out).as_posix() for path in files]
    return json.dumps(data, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


# ---- terminal ----


def summary(reproduction: Reproduction) -> str:
    """Return one sentence: the number of items by verdict, and those not as on record."""
    doubtful = sum(item.copy_in_doubt for item in reproduction.items)
    notes = {Verdict.MISPRINT.value: f" ({doubtful} possibly of the copy)" if doubtful else ""}
    counts = ", ".join(
        f"{n} {name}{notes.get(name, '')}"
        for name, n in reproduction.counts.items()
        if n or name != Verdict.FAILED.value
    )
    odd = [reproduction.label(item) for item in reproduction.items if not item.as_expected]
    end = "every verdict is that on record" if not odd else f"NOT as on record: {', '.join(odd)}"
    return f"{counted(len(reproduction.items), 'item')}: {counts}; {end}."


def terminal_table(reproduction: Reproduction) -> str:
    """Return item, claim, answer and verdict as a table of at most 100 columns.

    A verdict that is not the expected one is marked with ``!``.
    """
    lines = [*_lines(_COLUMNS), *_lines(["-" * n for n in _WIDTHS])]
    for group, items in groupby(reproduction.items, lambda item: item.group):
        lines += ["", _HEADINGS.get(group, f"{group}s")]
        for item in items:
            texts = (reproduction.label(item), item.paper, item.computed, _marked(item))
            lines += _lines(texts)
    lines += ["", *textwrap.wrap(summary(reproduction), WIDTH)]
    return "\n".join(lines) + "\n"


def _lines(row: Sequence[str]) -> Iterator[str]:
    return text_lines([row], _WIDTHS, range(len(row)))


def _verdict_text(item: Item) -> str:
    return item.verdict.value + (f" {_COPY}" if item.copy_in_doubt else "")


def _marked(item: Item) -> str:
    return _verdict_text(item) + ("" if item.as_expected else " !")


# ---- Markdown ----


def markdown(reproduction: Reproduction) -> str:
    """Return the report: an overview, then every item with its figure and numbers."""
    parts = [
        "# The paper again",
        f"{reproduction.source.rstrip('.')}: every table, figure and formula, computed and "
        "compared with the print.",
        summary(reproduction),
        ON_RECORD,
        " ".join(f"*{name}*: {meaning}." for name, meaning in VERDICTS.items()),
        markdown_table(
            ["item", "paper", "computed", "verdict"],
            [
                [f"[{label}](#{label})", *map(markdown_text, (i.paper, i.computed, _marked(i)))]
                for i in reproduction.items
                for label in (reproduction.label(i),)
            ],
        ),
    ]
    for item in reproduction.items:
        parts += _section(item, reproduction.label(item))
    return "\n\n".join(parts) + "\n"


def _section(item: Item, label: str) -> list[str]:
    lines = [
        f"- paper: {markdown_text(item.paper)}",
        f"- computed: {markdown_text(item.computed)}",
        f"- verdict: **{_verdict_text(item)}**"
        + ("" if item.as_expected else f", on record {item.expected.value}"),
    ]
    if item.reason:
        lines.append(f"- {markdown_text(item.reason)}")
    for statement, holds in item.data.get("checks", {}).items():
        lines.append(f"- [{'x' if holds else ' '}] {markdown_text(statement)}")
    parts = [f'## <a id="{label}"></a>{item.title}', "\n".join(lines)]
    for name in ("printed", "derived"):
        formula = item.data.get(f"{name}_latex")
        if formula:
            parts.append(f"{name}: $\\displaystyle {formula}$")
    if item.series is not None:
        parts.append(f"![{item.title}]({FIGURES}/{label}.png)")
    table = item.data.get("table")
    if table:
        cells = [[markdown_text(cell_text(value)) for value in row] for row in table["rows"]]
        parts.append(markdown_table(table["columns"], cells))
    return parts


# ---- HTML ----

_FILTER = """
(() => {
  const table = document.querySelector("#verdicts table");
  const rows = [...table.tBodies[0].rows];
  const bar = document.createElement("div");
  bar.className = "filter";
  bar.setAttribute("role", "group");
  bar.setAttribute("aria-label", "Filter of the verdicts");
  const text = document.createElement("input");
  text.type = "search";
  text.placeholder = "search the items";
  text.setAttribute("aria-label", "Search the items");
  const count = document.createElement("span");
  count.setAttribute("role", "status");
  let chosen = "all";
  const show = () => {
    const word = text.value.toLowerCase();
    let shown = 0;
    for (const row of rows) {
      const verdict = row.cells[3].textContent.trim().split(" ")[0];
      row.hidden = (chosen !== "all" && verdict !== chosen)
        || !row.textContent.toLowerCase().includes(word);
      shown += row.hidden ? 0 : 1;
    }
    count.textContent = shown + " of " + rows.length + " items";
    for (const b of bar.querySelectorAll("button")) {
      b.setAttribute("aria-pressed", String(b.textContent === chosen));
    }
  };
  for (const name of ["all", "reproduced", "misprint", "differs", "failed"]) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = name;
    button.addEventListener("click", () => { chosen = name; show(); });
    bar.append(button);
  }
  text.addEventListener("input", show);
  bar.append(text, count);
  table.closest(".wide").before(bar);
  show();
})();
"""


def report_page(reproduction: Reproduction, figures: Mapping[str, str]) -> HtmlPage:
    """Return the report as one page with formulas, and figures as SVG text by the item's label."""
    meanings = "".join(f"<dt>{escape(n)}</dt><dd>{escape(m)}</dd>" for n, m in VERDICTS.items())
    lead = (
        paragraph(
            f"{reproduction.source.rstrip('.')}: every table, figure and formula, computed again."
        )
        + paragraph(summary(reproduction))
        + paragraph(ON_RECORD)
        + f"<dl>{meanings}</dl>"
    )
    parts = [PageSection("Verdicts", f'<div id="verdicts">{_verdict_table(reproduction)}</div>')]
    for group, items in groupby(reproduction.items, lambda item: item.group):
        parts.append(PageSection(_HEADINGS.get(group, f"{group}s").capitalize(), ""))
        for item in items:
            label = reproduction.label(item)
            parts.append(
                PageSection(item.title, _item_html(item, label, figures.get(label)), label, 3)
            )
    return HtmlPage("The paper again", lead, parts, _FILTER)


def _verdict_table(reproduction: Reproduction) -> str:
    rows = []
    for item in reproduction.items:
        label = escape(reproduction.label(item))
        link = Html(f'<a href="#{label}">{label}</a>')
        rows.append((link, item.paper, item.computed, Html(_verdict_html(item))))
    return table(_COLUMNS, rows, "Verdicts")


def _verdict_html(item: Item) -> str:
    name = item.verdict.value
    odd = "" if item.as_expected else f" (on record {item.expected.value})"
    css = "misprint-verdict" if name == "misprint" else name
    return f'<span class="verdict {css}">{_verdict_text(item)}{odd}</span>'


def _item_html(item: Item, label: str, svg: str | None) -> str:
    command = f"painleve reproduce {item.paper_name} --only {item.id} --out {item.id}"
    pairs = (("printed", "printed in the paper"), ("derived", "derived here"))
    # MathML of the package's own printer, in place of the same as text.
    boxes = [
        f"<div><p>{words}</p>{item.data[f'{name}_mathml']}</div>"
        for name, words in pairs
        if f"{name}_mathml" in item.data
    ]
    lines = [f"verdict: {_verdict_html(item)}"]
    if not boxes:
        lines = [f"paper: {escape(item.paper)}", f"computed: {escape(item.computed)}", *lines]
    lines += [escape(item.reason)] if item.reason else []
    for statement, holds in item.data.get("checks", {}).items():
        lines.append(f"{'holds' if holds else 'does not hold'}: {escape(statement)}")
    parts = [f"<ul>{''.join(f'<li>{line}</li>' for line in lines)}</ul>"]
    if boxes:
        parts.append(f'<div class="pair">{"".join(boxes)}</div>')
    if svg is not None:
        drawing = inline_svg(svg, label, f"Figure: {item.title}")
        parts.append(figure(drawing, item.title + ".", command, whole=len(item.series or ()) > 1))
    given = item.data.get("table")
    if given:
        parts.append(table(given["columns"], given["rows"], f"Numbers of {item.title}"))
    if svg is None:
        parts.append(f"<p>Compute it alone: <code>{escape(command)}</code></p>")
    return "\n".join(parts)
