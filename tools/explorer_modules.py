"""The WebAssembly modules of the named mechanisms, for the explorer, made again where they are old.

`python tools/explorer_modules.py [NAME ...]` writes module and description of every named mechanism
with its default law whose generated C has changed since. It needs a compiler for WebAssembly.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from painleve_sym import model
from painleve_sym.explorer.page import packed_module
from painleve_sym.explorer.prebuilt import default_law, stored_digest
from painleve_sym.explorer.source import ModuleSource
from painleve_sym.explorer.wasm import module
from painleve_sym.mechanics.models import MODELS

FOLDER = Path(__file__).parents[1] / "painleve_sym" / "explorer" / "data"


def main(names: list[str]) -> None:
    """Write the modules of these mechanisms, of all where none is named."""
    for name in names or MODELS:
        mechanism = model(name)
        source = ModuleSource(mechanism, default_law(mechanism))
        data = {"digest": source.digest, **source.description}
        text = json.dumps(data, ensure_ascii=False, indent=1)
        if stored_digest(name) != source.digest:
            (FOLDER / f"{name}.wasm.gz").write_bytes(packed_module(module(source)))
            print(f"{name}: made again")
        # Meanings and ranges may change where the C does not.
        (FOLDER / f"{name}.json").write_text(f"{text}\n", "utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
