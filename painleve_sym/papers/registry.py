"""The papers that are reproduced: each claim computed, judged, and compared with its verdict."""

from __future__ import annotations

import json
import pkgutil
import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from painleve_sym import papers
from painleve_sym.checks import names_of, text_of
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.interrupts import noted_interrupts
from painleve_sym.papers.claims import Claims, ItemClaim, read_claims
from painleve_sym.papers.item import ItemOutcome, Verdict
from painleve_sym.papers.panels import Panel
from painleve_sym.plain_data import plain_fields
from painleve_sym.progress import progress
from painleve_sym.version import __version__

FORMAT = "painleve-sym reproduction 1"


@dataclass(frozen=True)
class Paper:
    """A paper whose claims are computed again; its name is that of its folder, with hyphens."""

    name: str
    folder: Path

    @cached_property
    def claims(self) -> Claims:
        """The printed formulas, numbers and statements, with the expected verdicts."""
        return read_claims(self.folder / "claims.toml")

    @property
    def module(self) -> ModuleType:
        """The module with ``COMPUTE`` and ``Workbench``, which Python loads once.

        LookupError where an item has a claim and no computation, or a computation and no claim.
        """
        module = import_module(f"{papers.__name__}.{self.folder.name}.items")
        lonely = sorted(set(module.COMPUTE) ^ set(self.claims.items))
        if lonely:
            raise LookupError(
                f"paper {self.name}: got items {lonely} in only one of claims.toml and "
                "items.COMPUTE, need them in both."
            )
        return module


@dataclass(frozen=True, eq=False)
class Item(Compared):
    """One claim of a paper, as `paper` says it, and the answer in short, with its verdict.

    The verdict is the computed one; expected is the one the derivations and independent
    computations establish, for the `reason`, or under the assumption named there. Runs shared with
    earlier items do not count in `seconds`. `data` are numbers in full precision, as JSON values;
    `series` are the content of its figure. With `copy` a misprint may be a fault of the copy.
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
    paper_name: str
    copy: bool = False

    @property
    def as_expected(self) -> bool:
        """Whether the verdict is the expected one."""
        return self.verdict is self.expected

    @property
    def copy_in_doubt(self) -> bool:
        """Whether the verdict is a misprint that may be a fault of the copy."""
        return self.copy and self.verdict is Verdict.MISPRINT

    def to_dict(self) -> dict[str, Any]:
        """Return plain data; the arrays of the figure are left out."""
        return {
            **plain_fields(self, "id", "group", "title", "paper", "computed", "verdict"),
            "expected_verdict": self.expected.value,
            **plain_fields(self, "as_expected", "reason", "seconds"),
            "copy_in_doubt": self.copy_in_doubt,
            "has_figure": self.series is not None,
            **plain_fields(self, "data", "paper_name"),
        }


@dataclass(frozen=True, repr=False)
class Reproduction:
    """All items that were asked for, and the papers they belong to."""

    items: tuple[Item, ...]
    papers: tuple[Paper, ...]

    def __repr__(self) -> str:
        """Return the number of items of each verdict in one line."""
        counts = ", ".join(f"{count} {verdict}" for verdict, count in self.counts.items() if count)
        return f"Reproduction: {counts}"

    @property
    def ok(self) -> bool:
        """Whether every verdict is the expected one."""
        return all(item.as_expected for item in self.items)

    @property
    def counts(self) -> dict[str, int]:
        """Number of items by verdict."""
        verdicts = [item.verdict for item in self.items]
        return {v.value: verdicts.count(v) for v in Verdict}

    @property
    def source(self) -> str:
        """The papers with their bibliographic data."""
        return " ".join(str(paper.claims.source) for paper in self.papers)

    def label(self, item: Item) -> str:
        """Return the id of an item, with its paper before it where there are several."""
        return item.id if len(self.papers) == 1 else f"{item.paper_name}-{item.id}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data.

        Keys: ``format``, ``version``, ``source``, ``ok``, ``counts`` (by verdict), ``items``,
        a list with the keys of `Item.to_dict`: ``id``, ``group``, ``title``, ``paper``,
        ``computed``, ``verdict``, ``expected_verdict``, ``as_expected``, ``reason``, ``seconds``,
        ``copy_in_doubt``, ``has_figure``, ``data`` and ``paper_name``; and ``papers``, their names.
        Where ``data`` has a ``table``, it holds ``columns`` and ``rows``.
        """
        return {
            "format": FORMAT,
            "version": __version__,
            "source": self.source,
            "ok": self.ok,
            "counts": self.counts,
            "items": [item.to_dict() for item in self.items],
            "papers": [paper.name for paper in self.papers],
        }


def known_papers() -> dict[str, Paper]:
    """Return every paper by name: the folders here that hold ``claims.toml``."""
    folders = [
        Path(place) / module.name
        for place in papers.__path__
        for module in pkgutil.iter_modules([place])
        if module.ispkg
    ]
    by_name = sorted(folders, key=lambda folder: folder.name)
    names = {folder.name.replace("_", "-"): folder for folder in by_name}
    return {n: Paper(n, f) for n, f in names.items() if (f / "claims.toml").exists()}


def chosen_papers(name: str | None = None) -> tuple[Paper, ...]:
    """Return the paper of a name, all for None; InputError names the nearest known one."""
    known = known_papers()
    if name is None:
        return tuple(known.values())
    refuse_unknown("paper", text_of(name, "reproduce: paper"), known, "reproduce")
    return (known[name],)


def selected(
    only: Sequence[str] | None = None, paper: str | None = None
) -> tuple[tuple[Paper, str], ...]:
    """Return the items of these ids or groups in their order, each after its paper.

    All ids, and all papers, when left out. InputError for an unknown paper, id or group, or an
    empty list; the message names the nearest.
    """
    items = [(p, name) for p in chosen_papers(paper) for name in p.claims.items]
    if only is None:
        return tuple(items)
    only = names_of(only, "reproduce: only", "eq-1,table-2")
    if not only:
        raise InputError("reproduce: only: got no item, need at least one. Fix: leave it out.")
    known = {name for _, name in items} | {p.claims.items[name].group for p, name in items}
    for name in only:
        refuse_unknown("item", name, known, "reproduce")
    return tuple((p, n) for p, n in items if n in only or p.claims.items[n].group in only)


def reproduce(only: Sequence[str] | None = None, *, paper: str | None = None) -> Reproduction:
    """Compute every item, or those asked for; one that raises an exception has failed.

    Parameters
    ----------
    only : sequence of str, optional
        Ids or groups; all when left out.
    paper : str, optional
        Name of the paper; all when left out.

    Returns
    -------
    Reproduction

    Raises
    ------
    InputError
        Unknown names, before anything is computed.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> ps.reproduce(["eq-1"]).ok
    True
    """
    chosen = selected(only, paper)
    workbenches = {p.name: p.module.Workbench() for p, _ in chosen}
    items = []
    with noted_interrupts() as check, progress("reproduce", len(chosen), "items") as advance:
        for p, name in chosen:
            items.append(_computed(p, name, workbenches[p.name]))
            check()
            advance(1)
    return Reproduction(tuple(items), tuple(dict.fromkeys(p for p, _ in chosen)))


def _computed(paper: Paper, name: str, workbench: Any) -> Item:
    claim, start = paper.claims.items[name], time.perf_counter()
    try:
        outcome = paper.module.COMPUTE[name](workbench)
        reason = _reason(claim, outcome)
        json.dumps(outcome.data, allow_nan=False)
    except Exception as error:
        reason = "".join(traceback.format_exception_only(error)).strip()
        lines = traceback.format_exception(error)
        data = {"exception": type(error).__name__, "traceback": "".join(lines).splitlines()}
        outcome = ItemOutcome(
            "nothing: the computation ended with an error", Verdict.FAILED, data=data
        )
    return Item(
        id=name,
        group=claim.group,
        title=claim.title,
        paper=outcome.paper or claim.paper,
        computed=outcome.computed,
        verdict=outcome.verdict,
        expected=claim.expected,
        reason=reason,
        seconds=time.perf_counter() - start,
        data=outcome.data,
        series=outcome.panels or None,
        paper_name=paper.name,
        copy=claim.copy,
    )


def _reason(claim: ItemClaim, outcome: ItemOutcome) -> str:
    """Return the reason of the claim; a reason for another verdict explains nothing."""
    return claim.reason.format(**outcome.reason) if outcome.verdict is claim.expected else ""
