"""The verdict on one claim of a paper, and the result it rests on."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from painleve_sym.equality import Compared
from painleve_sym.papers.panels import Panel


class Verdict(enum.StrEnum):
    """Verdict on a claim of the paper."""

    REPRODUCED = "reproduced"
    """The result agrees within the digits printed, or the words hold."""
    MISPRINT = "misprint"
    """It does not agree, but a small correction of the text that was read does."""
    DIFFERS = "differs"
    """It does not agree, and no small correction of the text does."""
    FAILED = "failed"
    """The computation ended with an exception; nothing is said about the claim."""

    @classmethod
    def of(cls, agrees: bool, corrected: bool = False) -> Verdict:
        """Return the verdict: `agrees` as printed, or once the print is `corrected`."""
        if agrees:
            return cls.REPRODUCED
        return cls.MISPRINT if corrected else cls.DIFFERS


@dataclass(frozen=True, eq=False)
class ItemOutcome(Compared):
    """The result of computing an item, in short, with its verdict and its figure.

    `reason` has the numbers for the ``{fields}`` of the reason in the claims, `data` numbers in
    full precision, as JSON values (``table`` holds ``columns`` and ``rows``), `paper` the claim
    where it is made of printed numbers.
    """

    computed: str
    verdict: Verdict
    reason: Mapping[str, float | str] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)
    panels: tuple[Panel, ...] = ()
    paper: str = ""


def checked(
    computed: str,
    checks: Mapping[str, bool],
    data: Mapping[str, Any] | None = None,
    panels: tuple[Panel, ...] = (),
    **reason: float | str,
) -> ItemOutcome:
    """Return the outcome of a claim in words: reproduced when every check holds.

    The checks are statements that the words amount to, and are kept in the data; `reason` are
    numbers for the reason in the claims.
    """
    plain = {name: bool(value) for name, value in checks.items()}
    data = {**(data or {}), "checks": plain}
    return ItemOutcome(computed, Verdict.of(all(plain.values())), reason, data, panels)


def table(columns: list[str], rows: list[list[Any]]) -> dict[str, Any]:
    """Return a table as plain data."""
    return {"columns": columns, "rows": rows}
