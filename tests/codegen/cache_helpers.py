"""Helpers shared by the tests of the cache and of what is compiled into it."""

from __future__ import annotations

import stat

SOURCE = '__attribute__((visibility("default"))) int answer(void) { return %d; }\n'


def mode(path):
    """Return the permissions of a file."""
    return stat.S_IMODE(path.stat().st_mode)
