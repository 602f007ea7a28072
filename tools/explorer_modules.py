"""The WebAssembly module of the explorer that is part of the package, made again where it is old.

`python tools/explorer_modules.py` writes module and description of the rod with its default law
where the generated C has changed since. It needs a compiler for WebAssembly.
"""

from __future__ import annotations

import json
from pathlib import Path

from painleve_sym import model
from painleve_sym.explorer.page import packed_module
from painleve_sym.explorer.prebuilt import STORED, default_law, stored_digest
from painleve_sym.explorer.source import ModuleSource
from painleve_sym.explorer.wasm import module

FOLDER = Path(__file__).parents[1] / "painleve_sym" / "explorer" / "data"


def main() -> None:
    """Write the module where it is old, and the description always: meanings may change alone."""
    mechanism = model(STORED)
    source = ModuleSource(mechanism, default_law(mechanism))
    if stored_digest() != source.digest:
        (FOLDER / f"{STORED}.wasm.gz").write_bytes(packed_module(module(source)))
        print(f"{STORED}: made again")
    data = {"digest": source.digest, **source.description}
    text = json.dumps(data, ensure_ascii=False, indent=1)
    (FOLDER / f"{STORED}.json").write_text(f"{text}\n", "utf-8")


if __name__ == "__main__":
    main()
