"""The paper again: one entry per table, figure and formula, each computed and judged."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from painleve_sym import __version__
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.papers.claim import Entry, Verdict
from painleve_sym.papers.impact_resolution import (
    beyond,
    diagrams,
    figures,
    formulas,
    impacts,
    jump,
    reference_values,
    statements,
    tables,
)
from painleve_sym.papers.impact_resolution.claims import TABLES
from painleve_sym.papers.panels import Panel
from painleve_sym.papers.run_cache import Workbench

FORMAT = "painleve-sym reproduction 1"
SOURCE = "Zhao, Liu & Chen, Impact model resolution on Painlevé's paradox"

_FIGURES = (*diagrams.ENTRIES, *figures.ENTRIES, *impacts.ENTRIES)
ENTRIES: tuple[Entry, ...] = (
    *formulas.ENTRIES,
    *tables.ENTRIES,
    *sorted(_FIGURES, key=lambda entry: int(entry.id.removeprefix("fig-"))),
    *statements.ENTRIES,
    *jump.ENTRIES,
    *reference_values.ENTRIES,
    *beyond.ENTRIES,
)
"""Every item, in the order in which they are reported."""

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Item:
    """One thing the paper says, and what came out.

    Attributes
    ----------
    id, group, title : str
    paper : str
        The claim.
    computed : str
        The answer, in short.
    verdict, expected : Verdict
        What came out, and what the derivations and independent computations establish.
    reason : str
        Why it differs, or under which assumption it agrees.
    seconds : float
        Time to compute it; what earlier items shared is not counted again.
    data : mapping
        Numbers in full precision, as JSON values.
    series : tuple of Panel or None
        What its figure shows.
    """

    id: str
    group: str
    title: str
    paper: str
    computed: str
    verdict: Verdict
    expected: Verdict
    reason: str
    seconds: float
    data: Mapping[str, Any]
    series: tuple[Panel, ...] | None

    @property
    def as_expected(self) -> bool:
        """Whether the verdict is the expected one."""
        return self.verdict is self.expected

    def to_dict(self) -> dict[str, Any]:
        """Return plain data; the arrays of the figure are left out."""
        return {
            "id": self.id,
            "group": self.group,
            "title": self.title,
            "paper": self.paper,
            "computed": self.computed,
            "verdict": self.verdict.value,
            "expected_verdict": self.expected.value,
            "as_expected": self.as_expected,
            "reason": self.reason,
            "seconds": self.seconds,
            "has_figure": self.series is not None,
            "data": dict(self.data),
        }


@dataclass(frozen=True)
class Reproduction:
    """All items that were asked for."""

    items: tuple[Item, ...]

    @property
    def ok(self) -> bool:
        """Whether every verdict is the expected one."""
        return all(item.as_expected for item in self.items)

    @property
    def counts(self) -> dict[str, int]:
        """Number of items by verdict."""
        verdicts = [item.verdict for item in self.items]
        return {v.value: verdicts.count(v) for v in Verdict}

    def to_dict(self) -> dict[str, Any]:
        """Return plain data.

        Keys: ``format``, ``version``, ``source``, ``ok``, ``counts`` (by verdict) and ``items``,
        a list with the keys of `Item.to_dict`: ``id``, ``group``, ``title``, ``paper``,
        ``computed``, ``verdict``, ``expected_verdict``, ``as_expected``, ``reason``, ``seconds``,
        ``has_figure`` and ``data``. Where ``data`` has a ``table``, it holds ``columns`` and
        ``rows``.
        """
        return {
            "format": FORMAT,
            "version": __version__,
            "source": SOURCE,
            "ok": self.ok,
            "counts": self.counts,
            "items": [item.to_dict() for item in self.items],
        }


def item_ids() -> tuple[str, ...]:
    """Return the ids of all items, in order."""
    return tuple(entry.id for entry in ENTRIES)


def group_names() -> tuple[str, ...]:
    """Return the groups of items, in order."""
    return tuple(dict.fromkeys(entry.group for entry in ENTRIES))


def selected(only: Sequence[str] | None) -> tuple[Entry, ...]:
    """Return the entries of these ids or groups in their order; all for None.

    Raises
    ------
    InputError
        An unknown id or an empty list; the message names the nearest.
    """
    if only is None:
        return ENTRIES
    only = [only] if isinstance(only, str) else only
    if not only:
        raise InputError("reproduce: only: got no item, need at least one. Fix: leave it out.")
    known = (*item_ids(), *group_names())
    for name in only:
        if name not in known:
            raise InputError(f"reproduce: {unknown_name('item', name, known)}")
    return tuple(e for e in ENTRIES if e.id in only or e.group in only)


def reproduce(only: Sequence[str] | None = None, progress: Progress | None = None) -> Reproduction:
    """Compute every item, or those asked for.

    Parameters
    ----------
    only : sequence of str, optional
        Ids or groups; all when left out.
    progress : callable, optional
        Called with (number from 1, how many, title) before each item is computed.

    Returns
    -------
    Reproduction

    Raises
    ------
    InputError
        Unknown ids, before anything is computed.
    """
    entries = selected(only)
    bench = Workbench({number: table.state for number, table in TABLES.items()})
    items = []
    for number, entry in enumerate(entries, 1):
        if progress is not None:
            progress(number, len(entries), entry.title)
        items.append(_computed(entry, bench))
    return Reproduction(tuple(items))


def _computed(entry: Entry, bench: Workbench) -> Item:
    start = time.perf_counter()
    outcome = entry.compute(bench)
    return Item(
        id=entry.id,
        group=entry.group,
        title=entry.title,
        paper=outcome.paper,
        computed=outcome.computed,
        verdict=outcome.verdict,
        expected=entry.expected,
        reason=outcome.reason,
        seconds=time.perf_counter() - start,
        data=outcome.data,
        series=outcome.panels or None,
    )
