"""Many small integers drawn at once, which Hypothesis does much quicker than one by one."""

from __future__ import annotations

from collections.abc import Sequence

from hypothesis import strategies as st


def integers(ranges: Sequence[range]) -> st.SearchStrategy[list[int]]:
    """Return the strategy of lists with one integer of each range; 0 is the simplest.

    Each range has 0, and at most some fifty numbers: they are drawn about evenly, as the remainder
    of a byte.
    """
    count = len(ranges)
    return st.binary(min_size=count, max_size=count).map(
        lambda drawn: [r[(byte - r.start) % len(r)] for r, byte in zip(ranges, drawn, strict=True)]
    )
