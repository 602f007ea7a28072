"""One thing the paper says, what was computed for it, and the verdict."""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any

from painleve_sym.papers.panels import Panel
from painleve_sym.papers.run_cache import Workbench


class Verdict(enum.Enum):
    """How a claim of the paper fares.

    REPRODUCED
        What was computed agrees within the digits printed, or the words hold.
    MISPRINT
        It does not agree, but a small correction of the print does.
    DIFFERS
        It does not agree, and the print is not at fault.
    """

    REPRODUCED = "reproduced"
    MISPRINT = "misprint"
    DIFFERS = "differs"


@dataclass(frozen=True)
class Printed:
    """A number as it is printed.

    Attributes
    ----------
    text : str
        With all its digits, such as ``-0.0337``.
    within : float or None
        Tolerance where the paper calls the number approximate; else half the last digit.
    """

    text: str
    within: float | None = None

    @property
    def value(self) -> float:
        """The number."""
        return float(self.text)

    @property
    def tolerance(self) -> float:
        """`within`, or half a unit of the last digit printed."""
        if self.within is not None:
            return self.within
        exponent = Decimal(self.text).as_tuple().exponent
        return 0.5 * 10.0 ** int(exponent)

    def matches(self, computed: float) -> bool:
        """Return whether the number computed is printed correctly."""
        # A computed number that lies on the edge rounds either way: 1e-6 of the digit decides.
        return bool(abs(computed - self.value) <= self.tolerance * (1 + 1e-6))


@dataclass(frozen=True)
class Outcome:
    """What computing an item gave.

    Attributes
    ----------
    paper, computed : str
        The claim and the answer, in short.
    verdict : Verdict
    reason : str
        Why it differs, or under which assumption it agrees.
    data : mapping
        Numbers in full precision, as JSON values. ``table`` holds ``columns`` and ``rows``.
    panels : tuple of Panel
        The figure, where there is one.
    """

    paper: str
    computed: str
    verdict: Verdict
    reason: str = ""
    data: Mapping[str, Any] = field(default_factory=dict)
    panels: tuple[Panel, ...] = ()


@dataclass(frozen=True)
class Entry:
    """An item that can be computed.

    Attributes
    ----------
    id, group, title : str
    compute : callable
    expected : Verdict
        The verdict the derivations and independent computations establish.
    """

    id: str
    group: str
    title: str
    compute: Callable[[Workbench], Outcome]
    expected: Verdict = Verdict.REPRODUCED


def features(
    paper: str,
    computed: str,
    checks: Mapping[str, bool],
    reason: str = "",
    data: Mapping[str, Any] | None = None,
    panels: tuple[Panel, ...] = (),
) -> Outcome:
    """Return the outcome of a claim in words: reproduced when every check holds.

    Parameters
    ----------
    paper, computed : str
    checks : mapping of str to bool
        What the words amount to; kept in the data.
    reason : str
    data : mapping, optional
    panels : tuple of Panel
    """
    held = {name: bool(value) for name, value in checks.items()}
    verdict = Verdict.REPRODUCED if all(held.values()) else Verdict.DIFFERS
    return Outcome(paper, computed, verdict, reason, {**(data or {}), "checks": held}, panels)


def table(columns: list[str], rows: list[list[Any]]) -> dict[str, Any]:
    """Return a table as plain data."""
    return {"columns": columns, "rows": rows}
