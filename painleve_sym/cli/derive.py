"""The command derive: the closed forms of a mechanism as text, LaTeX, Python or JSON."""

from __future__ import annotations

import argparse
import json
from typing import Any

from painleve_sym.cache import kept_entry
from painleve_sym.cli.case import chosen_mechanism
from painleve_sym.cli.describe import model_data
from painleve_sym.cli.options import checked_format
from painleve_sym.cli.output import print_json
from painleve_sym.cli.texts import DERIVE_FORMATS
from painleve_sym.codegen.derivation_cache import FORMULAS, entry_key
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.plain_data import to_plain


def derive(arguments: argparse.Namespace) -> int:
    """Print every closed form of a mechanism in the format asked for."""
    form = checked_format(arguments.format, DERIVE_FORMATS)
    mechanism = chosen_mechanism(arguments.model, arguments.contact)
    about = model_data(mechanism)
    page = _page(mechanism, about, form)
    if form == "json":
        print_json({"mechanism": mechanism.name, "model": about, **page})
    else:
        print(page["text"], end="")
    return 0


def _page(mechanism: Mechanism, about: dict[str, Any], form: str) -> dict[str, Any]:
    """Return the closed forms in a format, from the cache where they were printed before.

    They have the words and the default parameters of the mechanism, which its definition is
    without.
    """
    words = json.dumps([about, to_plain(mechanism.outline)])
    key = entry_key(f"closed forms as {form}", mechanism, words, by=(*FORMULAS, "study", "cli"))

    def rendered() -> dict[str, Any]:
        from painleve_sym.cli.formula_pages import written

        return written(mechanism, form)

    return kept_entry(key, rendered)
