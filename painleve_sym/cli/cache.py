"""The command cache: where compiled code and derivations are kept, and their removal."""

from __future__ import annotations

import argparse

from painleve_sym.cache import CacheContent, cache_content, clear_cache
from painleve_sym.cli.output import print_json, show
from painleve_sym.plain_data import plain_fields
from painleve_sym.quantities import counted


def cache(arguments: argparse.Namespace) -> int:
    """Print folder and size of the cache, or clear it."""
    content = clear_cache() if arguments.clear else cache_content()
    if arguments.json:
        print_json(
            {
                **plain_fields(content, "folder", "libraries", "derivations"),
                "bytes": content.size,
                "cleared": arguments.clear,
            }
        )
    elif arguments.clear:
        show(
            f"removed: {_summary(content)}"
            if content.size
            else "The cache holds nothing to remove."
        )
    else:
        show(str(content.folder))
        show(_summary(content))
        show("`painleve cache --clear` removes them; they are made again when they are needed.")
    return 0


def _summary(content: CacheContent) -> str:
    libraries = "1 library" if content.libraries == 1 else f"{content.libraries} libraries"
    derived = counted(content.derivations, "derivation")
    return f"{libraries}, {derived}, {content.size / 1e6:.1f} MB"
